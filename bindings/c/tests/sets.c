/* Levels and visible sets as a game has them: files that bake.c left in FOLDER, opened, asked and culled by, with the answers
 * that it wrote. sets FOLDER: without one, what needs no file. */
#include "house.h"

static char path[600];

static const char *file(const char *folder, const char *name) {
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* Levels made by hand: an octahedron in the place of the ball, far away. */
static void levels(void) {
    static const float tips[18] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    static const uint32_t sides[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    const double eye[3] = {0, 1.5, 0}, far_eye[3] = {0, 1.5, -300}, target[3] = {6, 1, -3};
    cullet_scene scene = house();
    cullet_state state;
    cullet_settings settings;
    cullet_mesh_arrays coarse = {tips, 6, sides, 24, NULL, 0, CULLET_ONE_SIDED, 0};
    cullet_levels found[2];
    cullet_draw_command commands[32];
    cullet_draw_key keys[32];
    uint32_t slots[64], mesh;
    double pixels = 7;
    size_t count;
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_NO_RESULT, cullet_visible_lod(state, &pixels));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &coarse, &mesh));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_lod(scene, 1, mesh, NAN));
    SAYS("error is NaN: it must be finite and at least 0");
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_lod(scene, 1, mesh, -1));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_lod(scene, 1, 1, .5f));
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_add_lod(scene, 1, 9, .5f));
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_add_lod(scene, 9, mesh, .5f));
    IS(CULLET_STATUS_OK, cullet_scene_add_lod(scene, 1, mesh, .5f));
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, found, 2, &count));
    THAT(count == 1 && found[0].mesh == mesh && found[0].group_count == 1 && found[0].triangle_count == 8);
    THAT(found[0].least_error == .5f && found[0].most_error == .5f);
    IS(CULLET_STATUS_OK, cullet_scene_commit(scene));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_BALANCED, &settings));
    settings.occlusion = 0;
    THAT(settings.lod_pixels == 0 && settings.lod_triangles == 0);
    for (int how = 0; how < 4; how++) {
        /* In full; near; far away; near with a budget. */
        cullet_view view;
        cullet_draws draws = {commands, keys, 32, 0, slots, 64, 0, NULL, 0, 0};
        int coarse_ones = 0, full_ones = 0;
        IS(CULLET_STATUS_OK, cullet_view_look_at(how == 2 ? far_eye : eye, target, .9, .1, 640, 400, &view));
        settings.lod_pixels = how == 0 || how == 3 ? 0 : 1;
        settings.lod_triangles = how == 3 ? 500 : 0;
        IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
        IS(CULLET_STATUS_OK, cullet_visible_lod(state, &pixels));
        IS(CULLET_STATUS_OK, cullet_visible_draws(state, scene, NULL, 0, &draws));
        for (size_t i = 0; i < draws.command_count; i++) {
            coarse_ones += keys[i].level == 1 && keys[i].mesh == mesh;
            full_ones += keys[i].level == 0 && keys[i].mesh == 1;
        }
        THAT(how < 2 ? coarse_ones == 0 && full_ones > 0 : coarse_ones > 0 && full_ones == 0);
        THAT(how == 0 ? pixels == 0 : how == 3 ? pixels > 1 : pixels == 1);
    }
    settings.lod_pixels = NAN;
    cullet_view view = inside(0);
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &view, &settings, state));
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_clear_levels(scene, 9));
    IS(CULLET_STATUS_OK, cullet_scene_clear_levels(scene, 1));
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, found, 2, &count));
    THAT(count == 0);
    IS(CULLET_STATUS_NULL_POINTER, cullet_visible_lod(state, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

static void mistakes(void) {
    cullet_scene scene = house();
    cullet_pvs pvs = {0}, wrong = {scene.id};
    uint32_t given = 9;
    IS(CULLET_STATUS_FILE, cullet_pvs_open("no such file.cpvs", &pvs));
    SAYS("cullet_pvs_open: no such file.cpvs: ");
    IS(CULLET_STATUS_FILE, cullet_pvs_open(".", &pvs));
    SAYS("it is no file");
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_open(NULL, &pvs));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_pvs_open("\xff", &pvs));
    IS(CULLET_STATUS_FILE, cullet_pvs_read((const uint8_t *)"no sets at all, but many bytes of something", 40, &pvs));
    IS(CULLET_STATUS_NULL_HANDLE, cullet_pvs_destroy(pvs));
    IS(CULLET_STATUS_WRONG_HANDLE, cullet_scene_set_pvs(scene, wrong));
    SAYS("is the handle of a scene, not of a pvs");
    IS(CULLET_STATUS_OK, cullet_scene_set_pvs(scene, pvs));
    /* A scene by hand has no occluders of a file. */
    IS(CULLET_STATUS_OK, cullet_scene_take_occluders(scene, 1, &given));
    THAT(given == 0);
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_take_occluders(scene, 2, &given));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_set_pvs(scene, pvs));
}

static void files(const char *folder) {
    cullet_scene scene, hand = house();
    cullet_state state;
    cullet_levels found[2];
    cullet_pvs of[2], none = {0};
    size_t count;
    uint32_t hidden = 0, given;
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_open(file(folder, "house.glb"), &scene));
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, found, 2, &count));
    THAT(count == 1 && found[0].group_count >= 2);
    IS(CULLET_STATUS_OK, cullet_scene_take_occluders(scene, 1, &given));
    THAT(given == 2);
    IS(CULLET_STATUS_OK, cullet_pvs_open(file(folder, "house.cpvs"), &of[0]));
    IS(CULLET_STATUS_OK, cullet_pvs_open(file(folder, "rooms.cpvs"), &of[1]));
    FILE *answers = fopen(file(folder, "house.txt"), "r");
    THAT(answers != NULL);
    for (int kind = 0; kind < 2; kind++) {
        IS(CULLET_STATUS_OK, cullet_scene_set_pvs(scene, of[kind]));
        for (int i = 0; i < VIEWS; i++) {
            unsigned long expected;
            cullet_view view = inside(i);
            THAT(fscanf(answers, "%lu", &expected) == 1);
            uint32_t with = sees(scene, state, &view, 1, 0), without = sees(scene, state, &view, 0, 0);
            THAT(with == expected && (with & ~without) == 0);
            hidden += with != without;
            /* The same question after the sets went: their answer does not stand. */
            sees(scene, state, &view, 1, 0);
            IS(CULLET_STATUS_OK, cullet_scene_set_pvs(scene, none));
            THAT(sees(scene, state, &view, 1, 0) == without);
            IS(CULLET_STATUS_OK, cullet_scene_set_pvs(scene, of[kind]));
            THAT(sees(scene, state, &view, 1, 0) == with);
        }
    }
    THAT(hidden >= 2);
    fclose(answers);
    /* Of a scene that is another by one instance, and of one without cells. */
    cullet_handle first = {0, 0};
    const cullet_transform moved = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 9, 0}};
    IS(CULLET_STATUS_OK, cullet_scene_set_transforms(hand, &first, &moved, 1));
    IS(CULLET_STATUS_FILE, cullet_scene_set_pvs(hand, of[0]));
    SAYS("another scene");
    IS(CULLET_STATUS_FILE, cullet_scene_set_pvs(hand, of[1]));
    for (int kind = 0; kind < 2; kind++) IS(CULLET_STATUS_OK, cullet_pvs_destroy(of[kind]));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_set_pvs(scene, of[0]));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(hand));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

int main(int argc, char **argv) {
    levels();
    mistakes();
    if (argc > 1) files(argv[1]);
    printf("%d checks passed\n", checks);
    return 0;
}
