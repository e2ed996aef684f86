/* Every mistake that a C program makes in passing arguments is a status and a message, and changes nothing. */
#include <math.h>
#include <pthread.h>
#include "check.h"

static const float POSITIONS[12] = {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1};
static const uint32_t INDICES[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

static cullet_mesh_arrays tetrahedron(void) {
    cullet_mesh_arrays arrays = {POSITIONS, 4, INDICES, 12, NULL, 0, CULLET_ONE_SIDED, 0};
    return arrays;
}

static cullet_instance at(uint32_t mesh, double x, double z) {
    cullet_instance instance = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}, 0, 1, 0, 0, 7};
    instance.mesh = mesh;
    instance.transform.translation[0] = x;
    instance.transform.translation[2] = z;
    return instance;
}

static void handles(void) {
    cullet_scene scene, second, wrong, none = {0};
    cullet_state state;
    cullet_occlusion buffer;
    cullet_scene_info info;
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_occlusion_create(64, 64, &buffer));
    IS(CULLET_STATUS_NULL_HANDLE, cullet_scene_commit(none));
    wrong.id = state.id;
    IS(CULLET_STATUS_WRONG_HANDLE, cullet_scene_commit(wrong));
    THAT(strstr(cullet_last_error(), "is the handle of a state, not of a scene") != NULL);
    wrong.id = buffer.id;
    IS(CULLET_STATUS_WRONG_HANDLE, cullet_scene_destroy(wrong));
    wrong.id = 0xdeadbeefdeadbeef;
    IS(CULLET_STATUS_WRONG_HANDLE, cullet_scene_refit(wrong));
    wrong.id = scene.id + 1;
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_get_info(wrong, &info));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_OK, cullet_scene_create(&second));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_get_info(scene, &info));
    IS(CULLET_STATUS_OK, cullet_scene_get_info(second, &info));
    THAT(info.instance_count == 0 && info.min[0] > info.max[0]);
    IS(CULLET_STATUS_OK, cullet_scene_destroy(second));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_state_destroy(state));
    IS(CULLET_STATUS_OK, cullet_occlusion_destroy(buffer));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_occlusion_destroy(buffer));
}

/* A later version may give a reserved field a meaning: until then it is 0. */
static void reserved(void) {
    cullet_scene scene;
    cullet_state state;
    cullet_occlusion buffer;
    cullet_mesh_arrays arrays = tetrahedron();
    cullet_settings settings;
    cullet_view view = ahead();
    cullet_scene_info info;
    uint32_t mesh, found;
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_occlusion_create(64, 64, &buffer));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &arrays, &mesh));
    cullet_instance two[2] = {at(mesh, 0, -10), at(mesh, 0, -20)};
    two[1].reserved = 7;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add(scene, two, 2, NULL));
    SAYS("cullet_scene_add: reserved of instance 1 is 7: it must be 0");
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    THAT(info.instance_count == 0);
    two[1].reserved = 0;
    IS(CULLET_STATUS_OK, cullet_scene_add(scene, two, 2, NULL));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_BALANCED, &settings));
    view.reserved = 7;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &view, &settings, state));
    SAYS("view->reserved is 7: it must be 0");
    view.reserved = 0;
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
    const float corners[12] = {-1, -1, 0, 2, 1, -1, 0, 2, 0, 1, 0, 2};
    const uint32_t triangle[3] = {0, 1, 2};
    cullet_clip_triangles in_clip;
    memset(&in_clip, 0, sizeof in_clip);
    in_clip.vertices = corners;
    in_clip.stride = 16;
    in_clip.offset_y = 4;
    in_clip.offset_zw = 12;
    in_clip.indices = triangle;
    in_clip.triangle_count = 1;
    in_clip.reserved = 7;
    IS(CULLET_STATUS_OK, cullet_clip_begin(buffer, 0.1));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_clip_draw(buffer, &in_clip, &found));
    SAYS("triangles->reserved is 7: it must be 0");
    IS(CULLET_STATUS_INVALID_VALUE, cullet_clip_test_triangles(buffer, &in_clip, &found));
    in_clip.reserved = 0;
    IS(CULLET_STATUS_OK, cullet_clip_draw(buffer, &in_clip, &found));
    view.size = 0;
    IS(CULLET_STATUS_STRUCT_SIZE, cullet_cull(scene, &view, NULL, state));
    SAYS("cullet_cull: view->size is 0, not 160: fill the view by cullet_view_from_matrix or its like");
    IS(CULLET_STATUS_OK, cullet_occlusion_destroy(buffer));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
}

static void pointers(void) {
    char bytes[64];
    cullet_scene scene;
    cullet_view view;
    uint32_t mesh = 77;
    cullet_mesh_arrays arrays = tetrahedron();
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_create(NULL));
    IS(CULLET_STATUS_NULL_POINTER, cullet_open(NULL, &scene));
    IS(CULLET_STATUS_NULL_POINTER, cullet_open("a", NULL));
    FILE *tiles = fopen("tileset.json", "w");
    THAT(tiles && fputs("{\"asset\":{\"version\":\"1.0\"},\"root\":{}}", tiles) >= 0 && fclose(tiles) == 0);
    IS(CULLET_STATUS_FILE, cullet_open("tileset.json", &scene));
    SAYS("3D Tiles are left out of this build: it needs the feature tiles");
    remove("tileset.json");
    IS(CULLET_STATUS_FILE, cullet_open("no/such/file.glb", &scene));
    THAT(strstr(cullet_last_error(), "no/such/file.glb") != NULL);
    IS(CULLET_STATUS_INVALID_VALUE, cullet_open("\xff\xfe", &scene));
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_add_mesh(scene, NULL, &mesh));
    SAYS("arrays is NULL: it must point to a value");
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_add_mesh(scene, &arrays, NULL));
    SAYS("mesh is NULL: it must point to a value");
    arrays.positions = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_add_mesh(scene, &arrays, &mesh));
    SAYS("positions is NULL, but its length is given as 4");
    arrays.positions = (const float *)(const void *)(bytes + (((uintptr_t)bytes & 1) ? 0 : 1));
    IS(CULLET_STATUS_ALIGNMENT, cullet_scene_add_mesh(scene, &arrays, &mesh));
    arrays = tetrahedron();
    arrays.position_count = SIZE_MAX;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_mesh(scene, &arrays, &mesh));
    arrays.position_count = 3;
    IS(CULLET_STATUS_MESH, cullet_scene_add_mesh(scene, &arrays, &mesh));
    THAT(strstr(cullet_last_error(), "there are 3 vertices") != NULL);
    arrays = tetrahedron();
    arrays.index_count = 11;
    IS(CULLET_STATUS_MESH, cullet_scene_add_mesh(scene, &arrays, &mesh));
    arrays = tetrahedron();
    arrays.flags = 64;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_mesh(scene, &arrays, &mesh));
    arrays.flags = CULLET_MASKED | CULLET_BLENDED;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add_mesh(scene, &arrays, &mesh));
    float bad[12];
    memcpy(bad, POSITIONS, sizeof bad);
    bad[4] = NAN;
    arrays = tetrahedron();
    arrays.positions = bad;
    IS(CULLET_STATUS_MESH, cullet_scene_add_mesh(scene, &arrays, &mesh));
    cullet_part part = {1, 3, 0, 0};
    arrays = tetrahedron();
    arrays.flags = 0;
    arrays.parts = &part;
    arrays.part_count = 1;
    IS(CULLET_STATUS_MESH, cullet_scene_add_mesh(scene, &arrays, &mesh));
    THAT(mesh == 77);
    const double flat[16] = {0};
    const double eye[3] = {0, 0, 0};
    IS(CULLET_STATUS_NULL_POINTER, cullet_view_from_matrix(NULL, 0, 64, 64, &view));
    IS(CULLET_STATUS_VIEW, cullet_view_from_matrix(flat, 0, 64, 64, &view));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_view_from_matrix(flat, 2, 64, 64, &view));
    IS(CULLET_STATUS_VIEW, cullet_view_look_at(eye, eye, 0.9, 0.1, 64, 64, &view));
    const double far_away[3] = {0, 0, -1};
    IS(CULLET_STATUS_VIEW, cullet_view_look_at(eye, far_away, 0.9, 0.1, 0, 0, &view));
    IS(CULLET_STATUS_VIEW, cullet_view_look_at(eye, far_away, NAN, 0.1, 64, 64, &view));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
}

static void scenes(void) {
    cullet_scene scene;
    cullet_state state;
    cullet_handle ids[3];
    cullet_settings settings;
    cullet_mesh_arrays arrays = tetrahedron();
    uint32_t mesh, slots[3];
    size_t count = 0;
    cullet_view view = ahead(), empty;
    memset(&empty, 0, sizeof empty);
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_NO_RESULT, cullet_visible_slots(state, NULL, 0, &count));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, NULL, state));
    IS(CULLET_STATUS_OK, cullet_visible_slots(state, NULL, 0, &count));
    THAT(count == 0);
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &arrays, &mesh));
    cullet_instance three[3] = {at(mesh, 0, -10), at(mesh, 0, 10), at(mesh, 1, -30)};
    three[2].mesh = 5;
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_add(scene, three, 3, ids));
    three[2].mesh = mesh;
    three[1].flags = 4096;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_add(scene, three, 3, ids));
    three[1].flags = 0;
    cullet_scene_info info;
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    THAT(info.instance_count == 0);
    IS(CULLET_STATUS_OK, cullet_scene_add(scene, three, 3, ids));
    IS(CULLET_STATUS_OK, cullet_scene_commit(scene));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_BALANCED, &settings));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_settings_preset(3, &settings));
    settings.reasons = 1;
    settings.occlusion = 0;
    IS(CULLET_STATUS_STRUCT_SIZE, cullet_cull(scene, &empty, &settings, state));
    cullet_settings bad = settings;
    bad.size = 4;
    IS(CULLET_STATUS_STRUCT_SIZE, cullet_cull(scene, &view, &bad, state));
    bad = settings;
    bad.frustum = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &view, &bad, state));
    bad = settings;
    bad.occlusion_budget = NAN;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &view, &bad, state));
    bad = settings;
    bad.output = 9;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &view, &bad, state));
    cullet_view turned = view;
    turned.clip_from_world[3] = INFINITY;
    IS(CULLET_STATUS_VIEW, cullet_cull(scene, &turned, &settings, state));
    turned = view;
    turned.cull_face = 7;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull(scene, &turned, &settings, state));
    IS(CULLET_STATUS_NULL_POINTER, cullet_cull(scene, NULL, &settings, state));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
    count = 99;
    IS(CULLET_STATUS_TOO_SMALL, cullet_visible_slots(state, slots, 1, &count));
    THAT(count == 2);
    IS(CULLET_STATUS_NULL_POINTER, cullet_visible_slots(state, NULL, 3, &count));
    SAYS("the array is NULL, but its length is given as 3");
    IS(CULLET_STATUS_NULL_POINTER, cullet_visible_slots(state, slots, 3, NULL));
    IS(CULLET_STATUS_OK, cullet_visible_slots(state, slots, 3, &count));
    THAT(count == 2);
    uint64_t users[3];
    IS(CULLET_STATUS_OK, cullet_visible_users(state, scene, users, 3, &count));
    THAT(users[0] == 7 && users[1] == 7);
    cullet_reason reasons[3];
    IS(CULLET_STATUS_OK, cullet_visible_reasons(state, reasons, 3, &count));
    uint32_t slot;
    IS(CULLET_STATUS_OK, cullet_scene_slot(scene, ids[1], &slot));
    THAT(count == 3 && reasons[slot].stage == CULLET_STAGE_FRUSTUM);
    cullet_reason why;
    char words[16];
    size_t length;
    IS(CULLET_STATUS_OK, cullet_explain(scene, &view, &settings, ids[1], &why, words, sizeof words, &length));
    THAT(why.stage == CULLET_STAGE_FRUSTUM && length > sizeof words && strlen(words) == sizeof words - 1);
    IS(CULLET_STATUS_OK, cullet_explain(scene, &view, NULL, ids[0], NULL, NULL, 0, NULL));
    cullet_draws draws;
    memset(&draws, 0, sizeof draws);
    IS(CULLET_STATUS_OK, cullet_visible_draws(state, scene, NULL, 0, &draws));
    THAT(draws.command_count >= 1 && draws.instance_count == 2);
    draws.instances = slots;
    draws.instance_capacity = 1;
    IS(CULLET_STATUS_TOO_SMALL, cullet_visible_draws(state, scene, NULL, 0, &draws));
    IS(CULLET_STATUS_OK, cullet_scene_remove(scene, &ids[0], 1));
    IS(CULLET_STATUS_NO_RESULT, cullet_visible_users(state, scene, users, 3, &count));
    IS(CULLET_STATUS_NO_RESULT, cullet_visible_draws(state, scene, NULL, 0, &draws));
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_remove(scene, &ids[0], 1));
    cullet_transform far_off = three[0].transform;
    cullet_transform both[2] = {far_off, far_off};
    cullet_handle mixed[2] = {ids[1], ids[0]};
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_set_transforms(scene, mixed, both, 2));
    cullet_instance found;
    IS(CULLET_STATUS_OK, cullet_scene_slot(scene, ids[1], &slot));
    IS(CULLET_STATUS_OK, cullet_scene_instance(scene, slot, &found, NULL));
    THAT(found.transform.translation[2] == 10);
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_instance(scene, 99, &found, NULL));
    const float corners[6] = {-1, -1, -1, 1, 1, 1}, less = -1;
    IS(CULLET_STATUS_OK, cullet_scene_set_bounds(scene, ids[1], CULLET_BOUNDS_WORLD, corners));
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_set_bounds(scene, ids[1], CULLET_BOUNDS_WORLD, NULL));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_set_bounds(scene, ids[1], CULLET_BOUNDS_MARGIN, &less));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_scene_set_bounds(scene, ids[1], 4, corners));
    uint32_t layers = 0, indices[12];
    IS(CULLET_STATUS_OK, cullet_scene_set_layers(scene, &ids[2], &layers, 1));
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_mesh_read(scene, 1, NULL, 0, indices, 12));
    IS(CULLET_STATUS_TOO_SMALL, cullet_scene_mesh_read(scene, 0, NULL, 0, indices, 11));
    IS(CULLET_STATUS_OK, cullet_scene_mesh_read(scene, 0, NULL, 0, indices, 12));
    cullet_transform nan = far_off;
    nan.linear[0] = NAN;
    IS(CULLET_STATUS_OK, cullet_scene_set_transforms(scene, &ids[1], &nan, 1));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, NULL, state));
    IS(CULLET_STATUS_OK, cullet_visible_slots(state, slots, 3, &count));
    THAT(count == 1 && slots[0] == slot);
    cullet_scene other;
    IS(CULLET_STATUS_OK, cullet_scene_create(&other));
    IS(CULLET_STATUS_NO_RESULT, cullet_visible_users(state, other, users, 3, &count));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(other));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_OK, cullet_visible_slots(state, slots, 3, &count));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_visible_users(state, scene, users, 3, &count));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

static void occlusion(void) {
    cullet_occlusion buffer;
    cullet_view view = ahead();
    cullet_box wall = {{-5, -5, -10}, {5, 5, -9}}, empty = {{1, 1, 1}, {0, 0, 0}};
    cullet_box tests[3] = {{{-1, -1, -20}, {1, 1, -19}}, {{-1, -1, -8}, {1, 1, -7}}, {{500, 0, -20}, {501, 1, -19}}};
    uint8_t found[3] = {9, 9, 9};
    static float nearness[64 * 40];
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_create(0, 64, &buffer));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_create(5000, 64, &buffer));
    IS(CULLET_STATUS_OK, cullet_occlusion_create(64, 40, &buffer));
    IS(CULLET_STATUS_NO_RESULT, cullet_occlusion_test_boxes(buffer, tests, 3, found));
    IS(CULLET_STATUS_OK, cullet_occlusion_begin(buffer, &view, NULL));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_draw_boxes(buffer, &empty, 1, NULL));
    IS(CULLET_STATUS_OK, cullet_occlusion_draw_boxes(buffer, &wall, 1, NULL));
    IS(CULLET_STATUS_OK, cullet_occlusion_test_boxes(buffer, tests, 3, found));
    THAT(found[0] == CULLET_FOUND_HIDDEN && found[1] == CULLET_FOUND_VISIBLE && found[2] == CULLET_FOUND_OUTSIDE);
    const uint32_t beyond[3] = {0, 1, 9};
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_draw_triangles(buffer, POSITIONS, 4, beyond, 3, 1, NULL));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_draw_triangles(buffer, POSITIONS, 4, INDICES, 12, 2, NULL));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_occlusion_draw_triangles(buffer, POSITIONS, 4, INDICES, 11, 1, NULL));
    IS(CULLET_STATUS_TOO_SMALL, cullet_occlusion_read(buffer, nearness, 64 * 39));
    IS(CULLET_STATUS_OK, cullet_occlusion_read(buffer, nearness, 64 * 40));
    THAT(nearness[20 * 64 + 32] > 0.1f && nearness[20 * 64 + 32] <= 1.0f / 9);
    /* The eye is within it, so that it covers everything. */
    IS(CULLET_STATUS_OK, cullet_occlusion_draw_triangles(buffer, POSITIONS, 4, INDICES, 12, 1, NULL));
    IS(CULLET_STATUS_OK, cullet_occlusion_read(buffer, nearness, 64 * 40));
    THAT(nearness[20 * 64 + 32] > 1.0f / 9);
    IS(CULLET_STATUS_OK, cullet_occlusion_destroy(buffer));
}

/* Threads: readers of a scene side by side, a change that comes between is refused, and messages are each thread's own. */
static cullet_scene shared;

static void *reader(void *argument) {
    cullet_view view = ahead();
    cullet_state state;
    size_t count, *busy = argument;
    cullet_state none = {0};
    if (cullet_state_create(&state) != CULLET_STATUS_OK) return "state";
    if (cullet_state_destroy(none) != CULLET_STATUS_NULL_HANDLE) return "null handle";
    if (strstr(cullet_last_error(), "cullet_state_destroy") == NULL) return "message of the thread";
    for (int i = 0; i < 2000; i++) {
        cullet_status status = cullet_cull(shared, &view, NULL, state);
        if (status == CULLET_STATUS_BUSY) {
            ++*busy;
            continue;
        }
        if (status != CULLET_STATUS_OK) return "cull";
        if (cullet_visible_slots(state, NULL, 0, &count) != CULLET_STATUS_OK || count == 0) return "slots";
    }
    return cullet_state_destroy(state) == CULLET_STATUS_OK ? NULL : "destroy";
}

static void threads(void) {
    pthread_t ids[3];
    size_t busy[3] = {0, 0, 0}, refused = 0;
    cullet_mesh_arrays arrays = tetrahedron();
    cullet_handle handle;
    uint32_t mesh;
    IS(CULLET_STATUS_OK, cullet_scene_create(&shared));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(shared, &arrays, &mesh));
    cullet_instance one = at(mesh, 0, -10);
    IS(CULLET_STATUS_OK, cullet_scene_add(shared, &one, 1, &handle));
    IS(CULLET_STATUS_OK, cullet_scene_commit(shared));
    for (int i = 0; i < 3; i++) THAT(pthread_create(&ids[i], NULL, reader, &busy[i]) == 0);
    for (int i = 0; i < 2000; i++) {
        cullet_status status = cullet_scene_set_transforms(shared, &handle, &one.transform, 1);
        THAT(status == CULLET_STATUS_OK || status == CULLET_STATUS_BUSY);
        refused += status == CULLET_STATUS_BUSY;
    }
    for (int i = 0; i < 3; i++) {
        void *failure;
        THAT(pthread_join(ids[i], &failure) == 0);
        if (failure != NULL) fprintf(stderr, "thread %d: %s\n", i, (const char *)failure);
        THAT(failure == NULL);
    }
    printf("threads: %zu culls and %zu changes came while another excluded them\n",
           busy[0] + busy[1] + busy[2], refused);
    IS(CULLET_STATUS_OK, cullet_scene_destroy(shared));
}

int main(void) {
    THAT(strcmp(cullet_last_error(), "") == 0);
    handles();
    reserved();
    pointers();
    scenes();
    occlusion();
    threads();
    printf("%d checks passed\n", checks);
    return 0;
}
