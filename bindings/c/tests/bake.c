/* Bakes: levels, occluders, cells and sets, with progress, stops, shares and mistakes. bake FOLDER leaves the files there that
 * sets.c opens, with the answers. */
#include <pthread.h>
#include "house.h"

static char names[5][512];
enum { MODEL, SETS, CELL_SETS, ANSWERS, UNITS };

static void name_files(const char *folder) {
    const char *files[5] = {"house.glb", "house.cpvs", "rooms.cpvs", "house.txt", "units"};
    for (int i = 0; i < 5; i++) snprintf(names[i], sizeof names[i], "%s/%s", folder, files[i]);
}

/* What a callback saw. */
static struct {
    int calls, last;
    double share;
    cullet_scene scene;
    cullet_status changed, read;
    pthread_mutex_t inside;
} heard;

static uint32_t step(void *context, double share) {
    THAT(context == &heard && pthread_mutex_trylock(&heard.inside) == 0);
    THAT(share >= heard.share && share <= 1);
    heard.share = share;
    heard.calls++;
    if (heard.scene.id != 0) {
        cullet_scene_info info;
        heard.changed = cullet_scene_refit(heard.scene);
        heard.read = cullet_scene_get_info(heard.scene, &info);
    }
    pthread_mutex_unlock(&heard.inside);
    return heard.calls < heard.last;
}

/* Options whose callback stops at a call; 0 for never. */
static cullet_bake_options listening(uint32_t threads, int last) {
    cullet_bake_options options;
    memset(&options, 0, sizeof options);
    memset(&heard, 0, sizeof heard);
    heard.last = last == 0 ? 1000000 : last;
    options.threads = threads;
    options.step = step;
    options.context = &heard;
    return options;
}

static uint8_t *bytes_of(cullet_pvs pvs, size_t *size) {
    IS(CULLET_STATUS_OK, cullet_pvs_write(pvs, NULL, 0, size));
    uint8_t *bytes = malloc(*size);
    THAT(bytes != NULL);
    IS(CULLET_STATUS_TOO_SMALL, cullet_pvs_write(pvs, bytes, *size - 1, size));
    IS(CULLET_STATUS_OK, cullet_pvs_write(pvs, bytes, *size, size));
    return bytes;
}

static void keep(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    THAT(file != NULL && fwrite(bytes, 1, size, file) == size);
    THAT(fclose(file) == 0);
}

/* Two sets are the same, byte for byte. */
static int same(cullet_pvs a, cullet_pvs b) {
    size_t sizes[2];
    uint8_t *first = bytes_of(a, &sizes[0]), *second = bytes_of(b, &sizes[1]);
    int is = sizes[0] == sizes[1] && memcmp(first, second, sizes[0]) == 0;
    free(first);
    free(second);
    return is;
}

static void options(cullet_scene scene) {
    cullet_bake_options wrong = listening(1025, 0);
    uint32_t count = 77;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_levels(scene, &wrong, &count));
    SAYS("options->threads is 1025: it must be 0 to 1024");
    wrong = listening(1, 0);
    wrong.reserved = 1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_levels(scene, &wrong, &count));
    wrong.reserved = 0;
    wrong.share_count = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_levels(scene, &wrong, &count));
    SAYS("options->folder is NULL");
    wrong.folder = names[UNITS];
    wrong.share = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_levels(scene, &wrong, &count));
    SAYS("options->share is 2: it must be below options->share_count, 2");
    wrong.share = wrong.share_count = 0;
    wrong.folder = "\xff\xfe";
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_levels(scene, &wrong, &count));
    SAYS("options->folder is not UTF-8");
    wrong.folder = names[UNITS];
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_cells(scene, NULL, &wrong, &count));
    SAYS("this bake has no units");
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_occluders(scene, 2, NULL, &count));
    SAYS("always is 2");
    THAT(count == 77 && heard.calls == 0);
}

static void levels(cullet_scene scene) {
    cullet_bake_options stop = listening(2, 1), go = listening(2, 0);
    cullet_levels found[4];
    cullet_mesh_info held, ball;
    cullet_scene_info info;
    uint32_t given = 9;
    size_t count = 9;
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, NULL, 0, &count));
    THAT(count == 0);
    stop = listening(2, 1);
    IS(CULLET_STATUS_STOPPED, cullet_bake_levels(scene, &stop, &given));
    SAYS("options->step stopped the bake");
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    THAT(given == 9 && heard.calls == 1 && info.mesh_count == 2);
    go = listening(2, 0);
    heard.scene = scene;
    IS(CULLET_STATUS_OK, cullet_bake_levels(scene, &go, &given));
    THAT(heard.calls == 2 && heard.share == 1 && given >= 1);
    THAT(heard.changed == CULLET_STATUS_BUSY && heard.read == CULLET_STATUS_BUSY);
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, found, 4, &count));
    THAT(count == 1 && found[0].mesh >= 2 && found[0].group_count >= 2);
    THAT(found[0].least_error > 0 && found[0].least_error <= found[0].most_error && found[0].most_error < 2);
    IS(CULLET_STATUS_OK, cullet_scene_mesh_info(scene, found[0].mesh, &held));
    IS(CULLET_STATUS_OK, cullet_scene_mesh_info(scene, 1, &ball));
    THAT(held.index_count / 3 == found[0].triangle_count && held.index_count > ball.index_count);
    /* Again: the same numbers, and no mesh is left over. */
    const uint32_t before = found[0].mesh;
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    const uint32_t meshes = info.mesh_count;
    IS(CULLET_STATUS_OK, cullet_bake_levels(scene, NULL, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_levels(scene, 1, found, 4, &count));
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    THAT(count == 1 && info.mesh_count == meshes && before >= 2);
    IS(CULLET_STATUS_NOT_FOUND, cullet_scene_levels(scene, 999, found, 4, &count));
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_levels(scene, 1, found, 4, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_commit(scene));
}

static void occluders(cullet_scene scene) {
    uint32_t given = 9, again;
    cullet_bake_options stop = listening(1, 1);
    IS(CULLET_STATUS_STOPPED, cullet_bake_occluders(scene, 1, &stop, &given));
    THAT(given == 9);
    IS(CULLET_STATUS_OK, cullet_bake_occluders(scene, 1, NULL, &given));
    THAT(given == 2);
    IS(CULLET_STATUS_OK, cullet_scene_take_occluders(scene, 0, &again));
    IS(CULLET_STATUS_OK, cullet_scene_take_occluders(scene, 1, NULL));
    THAT(again <= given);
}

/* Bytes that are cut or changed are refused, and never taken for others. */
static void damage(cullet_pvs pvs) {
    size_t size;
    uint8_t *bytes = bytes_of(pvs, &size);
    cullet_pvs other = {7};
    for (size_t cut = 0; cut < size; cut++) {
        uint8_t *part = malloc(cut + 1);
        THAT(part != NULL);
        memcpy(part, bytes, cut);
        IS(CULLET_STATUS_FILE, cullet_pvs_read(part, cut, &other));
        free(part);
    }
    THAT(other.id == 7);
    for (size_t at = 0; at < size; at++) {
        bytes[at] ^= 0x10;
        /* Zeros that fill a place up to a multiple are no part of any sum. */
        if (cullet_pvs_read(bytes, size, &other) == CULLET_STATUS_OK) {
            THAT(same(pvs, other));
            IS(CULLET_STATUS_OK, cullet_pvs_destroy(other));
        }
        bytes[at] ^= 0x10;
    }
    free(bytes);
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_read(NULL, 5, &other));
    IS(CULLET_STATUS_FILE, cullet_pvs_read(NULL, 0, &other));
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_read((const uint8_t *)"x", 1, NULL));
}

enum { CELLS = 32 };

static cullet_pvs_settings few(void) {
    static const cullet_eye_box rooms = {{-8, 0, -4}, {8, 3, 4}};
    cullet_pvs_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.boxes = &rooms;
    settings.box_count = 1;
    settings.grid[0] = 8;
    settings.grid[1] = 1;
    settings.grid[2] = 4;
    settings.rays = 60000;
    return settings;
}

static void wrong_settings(cullet_scene scene) {
    const cullet_eye_box boxes[2] = {{{-7, 1, -3}, {-1, 2, 3}}, {{1, 1, -3}, {7, 2, 3}}};
    cullet_pvs_settings settings = few();
    cullet_pvs pvs = {5};
    settings.reserved = 1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    settings = few();
    settings.missing = NAN;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    SAYS("settings->missing is NaN");
    settings.missing = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    settings = few();
    settings.keep_angle = -1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    SAYS("settings->keep_angle is -1: it must be finite and at least 0");
    settings.keep_angle = 4;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    SAYS("settings->keep_angle is 4: it must be at most pi");
    settings.keep_angle = 0;
    settings.join = INFINITY;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    settings = few();
    settings.cells = 6;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    SAYS("settings->grid cuts one box");
    settings.cells = 0;
    settings.boxes = boxes;
    settings.box_count = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    settings.boxes_are_cells = 1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    SAYS("neither cells nor a grid");
    settings = few();
    settings.boxes = NULL;
    settings.box_count = 2;
    IS(CULLET_STATUS_NULL_POINTER, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    cullet_eye_box turned = {{1, 1, 1}, {0, NAN, 0}};
    settings.boxes = &turned;
    settings.box_count = 1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(scene, &settings, NULL, &pvs));
    IS(CULLET_STATUS_NULL_POINTER, cullet_bake_pvs(scene, &settings, NULL, NULL));
    cullet_scene empty;
    IS(CULLET_STATUS_OK, cullet_scene_create(&empty));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_pvs(empty, NULL, NULL, &pvs));
    SAYS("nothing to bake");
    IS(CULLET_STATUS_OK, cullet_bake_levels(empty, NULL, NULL));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_cells(empty, NULL, NULL, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(empty));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_bake_pvs(empty, NULL, NULL, &pvs));
    THAT(pvs.id == 5);
}

static void queries(cullet_pvs pvs) {
    cullet_pvs_info info;
    cullet_eye_box boxes[CELLS];
    float missing[CELLS];
    uint32_t all[CELLS];
    size_t count, seen;
    IS(CULLET_STATUS_OK, cullet_pvs_get_info(pvs, &info));
    THAT(info.cell_count == CELLS && info.target_count == THINGS && info.targets == CULLET_PVS_TARGETS_INSTANCES);
    THAT(info.rays >= 60000 && info.mean_missing >= 0 && info.most_missing <= 1 && info.mean_missing <= info.most_missing);
    IS(CULLET_STATUS_OK, cullet_pvs_cells(pvs, boxes, CELLS, &count));
    THAT(count == CELLS);
    IS(CULLET_STATUS_OK, cullet_pvs_missing(pvs, missing, CELLS, &count));
    THAT(count == CELLS);
    IS(CULLET_STATUS_TOO_SMALL, cullet_pvs_cells(pvs, boxes, CELLS - 1, &count));
    for (uint32_t cell = 0; cell < CELLS; cell++) all[cell] = cell;
    for (uint32_t cell = 0; cell < CELLS; cell++) {
        double points[9] = {0, 0, 0, NAN, 0, 0, 1e9, 0, 0};
        uint32_t of[3], things[THINGS], any[THINGS];
        for (int a = 0; a < 3; a++) points[a] = (boxes[cell].min[a] + boxes[cell].max[a]) / 2;
        IS(CULLET_STATUS_OK, cullet_pvs_cell_of(pvs, points, 3, of));
        THAT(of[0] == cell && of[1] == UINT32_MAX && of[2] == UINT32_MAX);
        IS(CULLET_STATUS_OK, cullet_pvs_visible(pvs, &cell, 1, things, THINGS, &seen));
        THAT(seen <= THINGS);
        for (size_t i = 0; i < seen; i++) THAT(things[i] < THINGS && (i == 0 || things[i - 1] < things[i]));
        IS(CULLET_STATUS_OK, cullet_pvs_visible(pvs, all, CELLS, any, THINGS, &count));
        THAT(count >= seen);
    }
    uint32_t none = CELLS;
    IS(CULLET_STATUS_NOT_FOUND, cullet_pvs_visible(pvs, &none, 1, NULL, 0, &count));
    SAYS("cells[0] is 32: the sets have 32 cells");
    IS(CULLET_STATUS_OK, cullet_pvs_visible(pvs, NULL, 0, NULL, 0, &count));
    THAT(count == 0);
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_visible(pvs, NULL, 1, NULL, 0, &count));
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_cell_of(pvs, NULL, 1, &none));
    IS(CULLET_STATUS_NULL_POINTER, cullet_pvs_get_info(pvs, NULL));
}

static void sets(cullet_scene scene) {
    cullet_pvs_settings settings = few();
    cullet_pvs one = {0}, other = {0};
    cullet_bake_options of = listening(3, 3);
    size_t size;
    IS(CULLET_STATUS_STOPPED, cullet_bake_pvs(scene, &settings, &of, &one));
    THAT(one.id == 0 && heard.calls == 3);
    of = listening(1, 0);
    heard.scene = scene;
    IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, &settings, &of, &one));
    THAT(heard.calls > 3 && heard.changed == CULLET_STATUS_BUSY && heard.read == CULLET_STATUS_OK);
    IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, &settings, NULL, &other));
    THAT(same(one, other));
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(other));
    /* In units: stopped in the middle, then by two shares, then joined. */
    of = listening(2, 5);
    of.folder = names[UNITS];
    IS(CULLET_STATUS_STOPPED, cullet_bake_pvs(scene, &settings, &of, &other));
    for (uint32_t share = 0; share < 2; share++) {
        cullet_pvs part = {0};
        of = listening(2, 0);
        of.folder = names[UNITS];
        of.share = share;
        of.share_count = 2;
        /* No round of these is known to be the last, so a share ends with all of it. */
        IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, &settings, &of, &part));
        THAT(same(one, part));
        IS(CULLET_STATUS_OK, cullet_pvs_destroy(part));
    }
    of = listening(1, 0);
    of.folder = names[UNITS];
    IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, &settings, &of, &other));
    THAT(same(one, other));
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(other));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_pvs_destroy(other));
    /* Another seed is another bake. */
    settings.seed = 2;
    IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, &settings, NULL, &other));
    THAT(!same(one, other));
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(other));
    queries(one);
    damage(one);
    uint8_t *bytes = bytes_of(one, &size);
    keep(names[SETS], bytes, size);
    free(bytes);
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(one));
}

/* Shares of work whose one round is its last: each does its own, and a call without shares joins them. */
static void shares(void) {
    cullet_scene alone = house(), parts = house();
    cullet_levels of[2][4];
    size_t counts[2];
    IS(CULLET_STATUS_OK, cullet_bake_levels(alone, NULL, NULL));
    for (uint32_t share = 0; share < 2; share++) {
        cullet_bake_options own = listening(1, 0);
        own.folder = names[UNITS];
        own.share = share;
        own.share_count = 2;
        IS(CULLET_STATUS_STOPPED, cullet_bake_levels(parts, &own, NULL));
        SAYS("this share is done");
        IS(CULLET_STATUS_OK, cullet_scene_levels(parts, 1, NULL, 0, &counts[1]));
        THAT(counts[1] == 0);
    }
    cullet_bake_options join = listening(1, 0);
    join.folder = names[UNITS];
    IS(CULLET_STATUS_OK, cullet_bake_levels(parts, &join, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_levels(alone, 1, of[0], 4, &counts[0]));
    IS(CULLET_STATUS_OK, cullet_scene_levels(parts, 1, of[1], 4, &counts[1]));
    THAT(counts[0] == 1 && counts[1] == 1 && memcmp(&of[0][0], &of[1][0], sizeof of[0][0]) == 0);
    IS(CULLET_STATUS_OK, cullet_scene_destroy(alone));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(parts));
}

static void cells(cullet_scene scene, cullet_state state) {
    cullet_cells_settings settings;
    cullet_bake_options stop = listening(2, 2);
    cullet_pvs pvs, wrong;
    cullet_pvs_info info;
    cullet_view view = inside(0);
    const double points[2][3] = {{-4, 1.5, 0}, {4, 1.5, 0}};
    uint32_t count = 9, of[2];
    size_t size, seen;
    memset(&settings, 0, sizeof settings);
    const uint32_t before = sees(scene, state, &view, 1, 1);
    settings.voxel = 0.2;
    IS(CULLET_STATUS_STOPPED, cullet_bake_cells(scene, &settings, &stop, &count));
    THAT(count == 9 && heard.calls == 2);
    IS(CULLET_STATUS_OK, cullet_scene_cell_of(scene, points[0], &of[0]));
    THAT(of[0] == UINT32_MAX);
    settings.voxel = NAN;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_cells(scene, &settings, NULL, &count));
    settings.voxel = 1e-6;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_bake_cells(scene, &settings, NULL, &count));
    SAYS("exceed the limit");
    settings.voxel = 0.2;
    settings.ignored_count = 1;
    IS(CULLET_STATUS_NULL_POINTER, cullet_bake_cells(scene, &settings, NULL, &count));
    settings.ignored_count = 0;
    stop = listening(2, 0);
    IS(CULLET_STATUS_OK, cullet_bake_cells(scene, &settings, &stop, &count));
    THAT(count == 3 && heard.calls == 5 && heard.share == 1);
    for (int i = 0; i < 2; i++) IS(CULLET_STATUS_OK, cullet_scene_cell_of(scene, points[i], &of[i]));
    THAT(of[0] != of[1] && of[0] < 3 && of[1] < 3);
    /* The same state, view and settings: cells came, so the answer of before does not stand. */
    THAT(sees(scene, state, &view, 1, 1) != before);
    IS(CULLET_STATUS_OK, cullet_bake_pvs(scene, NULL, NULL, &pvs));
    IS(CULLET_STATUS_OK, cullet_pvs_get_info(pvs, &info));
    THAT(info.targets == CULLET_PVS_TARGETS_CELLS && info.cell_count == 3 && info.target_count == 3 && info.rays == 0);
    IS(CULLET_STATUS_NOT_FOUND, cullet_pvs_cells(pvs, NULL, 0, &seen));
    SAYS("ask cullet_scene_cell_of");
    IS(CULLET_STATUS_OK, cullet_pvs_visible(pvs, of, 1, NULL, 0, &seen));
    THAT(seen == 2);
    damage(pvs);
    uint8_t *bytes = bytes_of(pvs, &size);
    keep(names[CELL_SETS], bytes, size);
    IS(CULLET_STATUS_OK, cullet_pvs_read(bytes, size, &wrong));
    THAT(same(pvs, wrong));
    free(bytes);
    cullet_scene bare = house();
    IS(CULLET_STATUS_FILE, cullet_scene_set_pvs(bare, wrong));
    SAYS("this scene has none");
    settings.voxel = 0.3;
    IS(CULLET_STATUS_OK, cullet_bake_cells(bare, &settings, NULL, NULL));
    IS(CULLET_STATUS_FILE, cullet_scene_set_pvs(bare, wrong));
    SAYS("it was baked from other cells");
    IS(CULLET_STATUS_OK, cullet_scene_destroy(bare));
    IS(CULLET_STATUS_OK, cullet_scene_set_pvs(scene, pvs));
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(pvs));
    IS(CULLET_STATUS_OK, cullet_pvs_destroy(wrong));
}

/* Saves the scene; and what is seen of the file when it is opened, with each kind of sets, for sets.c. */
static void save(cullet_scene scene, cullet_state state) {
    cullet_scene again;
    cullet_levels found[4];
    uint32_t given;
    size_t count;
    FILE *answers = fopen(names[ANSWERS], "w");
    THAT(answers != NULL);
    IS(CULLET_STATUS_FILE, cullet_scene_save(scene, "house.txt", NULL));
    SAYS("is of no kind that is written");
    IS(CULLET_STATUS_FILE, cullet_scene_save(scene, names[MODEL], "no such file.glb"));
    SAYS("no such file.glb");
    IS(CULLET_STATUS_NULL_POINTER, cullet_scene_save(scene, NULL, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_save(scene, names[MODEL], NULL));
    cullet_scene_info info;
    IS(CULLET_STATUS_OK, cullet_scene_get_info(scene, &info));
    THAT(info.instance_count == THINGS);
    IS(CULLET_STATUS_OK, cullet_open(names[MODEL], &again));
    IS(CULLET_STATUS_OK, cullet_scene_levels(again, 1, found, 4, &count));
    THAT(count == 1);
    IS(CULLET_STATUS_OK, cullet_scene_take_occluders(again, 1, &given));
    THAT(given == 2);
    for (int kind = 0; kind < 2; kind++) {
        cullet_pvs pvs;
        IS(CULLET_STATUS_OK, cullet_pvs_open(names[kind == 0 ? SETS : CELL_SETS], &pvs));
        IS(CULLET_STATUS_OK, cullet_scene_set_pvs(again, pvs));
        for (int i = 0; i < VIEWS; i++) {
            cullet_view view = inside(i);
            fprintf(answers, "%lu\n", (unsigned long)sees(again, state, &view, 1, 0));
        }
        IS(CULLET_STATUS_OK, cullet_pvs_destroy(pvs));
    }
    THAT(fclose(answers) == 0);
    /* A glTF as it is, with what was baked added. */
    char copy[600];
    snprintf(copy, sizeof copy, "%s.glb", names[MODEL]);
    IS(CULLET_STATUS_OK, cullet_scene_save(again, copy, names[MODEL]));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(again));
    IS(CULLET_STATUS_OK, cullet_open(copy, &again));
    IS(CULLET_STATUS_OK, cullet_scene_levels(again, 1, found, 4, &count));
    THAT(count == 1);
    IS(CULLET_STATUS_OK, cullet_scene_destroy(again));
}

int main(int argc, char **argv) {
    cullet_state state;
    cullet_scene scene = house();
    name_files(argc > 1 ? argv[1] : ".");
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    options(scene);
    wrong_settings(scene);
    sets(scene);
    shares();
    cells(scene, state);
    levels(scene);
    occluders(scene);
    save(scene, state);
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    printf("%d checks passed\n", checks);
    return 0;
}
