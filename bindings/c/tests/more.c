/* Queries, candidates, shadows, lights, two eyes and threads of one's own: answers, and mistakes in passing arguments. */
#include <math.h>
#include <pthread.h>
#include "check.h"

static const float CORNERS[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const uint32_t FACES[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                   3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};

static cullet_scene scene;
static cullet_handle ids[4];
static uint32_t slots[4];

/* A wall ahead; behind it a box; a tower above the view; a box behind the eye. */
static void build(void) {
    cullet_mesh_arrays box = {CORNERS, 8, FACES, 36, NULL, 0, CULLET_ONE_SIDED, 0};
    uint32_t mesh;
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &box, &mesh));
    cullet_instance four[4] = {{{{9, 0, 0, 0, 5, 0, 0, 0, 1}, {0, 0, -10}}, 0, 1, 0, 0, 0},
                               {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, -20}}, 0, 1, 0, 0, 1},
                               {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 40, -10}}, 0, 2, 0, 0, 2},
                               {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 40, 20}}, 0, 1, 0, 0, 3}};
    for (int i = 0; i < 4; i++) four[i].mesh = mesh;
    IS(CULLET_STATUS_OK, cullet_scene_add(scene, four, 4, ids));
    IS(CULLET_STATUS_OK, cullet_scene_commit(scene));
    for (int i = 0; i < 4; i++) IS(CULLET_STATUS_OK, cullet_scene_slot(scene, ids[i], &slots[i]));
}

/* Whether the last cull of a state left an instance. */
static int has(cullet_state state, int instance) {
    uint32_t found[4];
    size_t count;
    IS(CULLET_STATUS_OK, cullet_visible_slots(state, found, 4, &count));
    for (size_t i = 0; i < count; i++)
        if (found[i] == slots[instance]) return 1;
    return 0;
}

static void sights(void) {
    const cullet_segment three[3] = {{{0, 0, 0}, {0, 0, -30}}, {{0, 20, 0}, {0, 20, -30}}, {{NAN, 0, 0}, {0, 0, -30}}};
    cullet_sight found[3];
    cullet_sight_options options;
    IS(CULLET_STATUS_OK, cullet_lines_of_sight(scene, three, 3, NULL, found));
    THAT(found[0].blocked == 1 && found[0].handle.index == ids[0].index && found[0].slot == slots[0]);
    THAT(fabs(found[0].share - 0.3) < 1e-9 && fabs(found[0].point[2] + 9) < 1e-6);
    THAT(found[1].blocked == 0 && found[1].share == 0 && found[2].blocked == 0);
    memset(&options, 0, sizeof options);
    options.ignored_count = 1;
    options.ignored[0] = ids[0];
    IS(CULLET_STATUS_OK, cullet_lines_of_sight(scene, three, 1, &options, found));
    THAT(found[0].blocked == 1 && found[0].handle.index == ids[1].index);
    options.ignored_layers = 1;
    IS(CULLET_STATUS_OK, cullet_lines_of_sight(scene, three, 1, &options, found));
    THAT(found[0].blocked == 0);
    options.ignored_count = 3;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_lines_of_sight(scene, three, 1, &options, found));
    SAYS("options->ignored_count is 3: it must be 0 to 2");
    options.ignored_count = 0;
    options.any = 7;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_lines_of_sight(scene, three, 1, &options, found));
    IS(CULLET_STATUS_NULL_POINTER, cullet_lines_of_sight(scene, NULL, 1, NULL, found));
    IS(CULLET_STATUS_NULL_POINTER, cullet_lines_of_sight(scene, three, 1, NULL, NULL));
    IS(CULLET_STATUS_OK, cullet_lines_of_sight(scene, NULL, 0, NULL, NULL));
}

static void boxes(void) {
    const cullet_box from = {{-1, -1, -1}, {1, 1, 1}};
    const cullet_box to[4] = {{{-1, -1, -21}, {1, 1, -20}}, {{-1, 30, -21}, {1, 31, -20}}, {{1, 0, 0}, {0, 1, 1}},
                              {{-1, -1, -21}, {1, INFINITY, -20}}};
    cullet_box_sight_options options = {0, 2, 0};
    uint8_t found[4];
    IS(CULLET_STATUS_OK, cullet_box_to_box(scene, &from, to, 4, NULL, found));
    THAT(found[0] == CULLET_FOUND_HIDDEN && found[1] == CULLET_FOUND_VISIBLE && found[2] == CULLET_FOUND_OUTSIDE);
    THAT(found[3] == CULLET_FOUND_VISIBLE);
    IS(CULLET_STATUS_OK, cullet_box_to_box(scene, &from, to, 1, &options, found));
    THAT(found[0] == CULLET_FOUND_HIDDEN);
    options.ignored_layers = 1;
    IS(CULLET_STATUS_OK, cullet_box_to_box(scene, &from, to, 1, &options, found));
    THAT(found[0] == CULLET_FOUND_VISIBLE);
    options.splits = 17;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_box_to_box(scene, &from, to, 1, &options, found));
    SAYS("options->splits is 17: it must be 0 to 16");
    uint32_t cell = 5;
    const double point[3] = {0, 0, 0};
    IS(CULLET_STATUS_OK, cullet_scene_cell_of(scene, point, &cell));
    THAT(cell == UINT32_MAX);
}

static void regions(void) {
    cullet_region region;
    cullet_region_settings settings;
    const cullet_eye_box eyes = {{-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25}};
    cullet_view view = ahead();
    uint32_t found[4];
    size_t count;
    memset(&settings, 0, sizeof settings);
    IS(CULLET_STATUS_OK, cullet_region_create(&region));
    IS(CULLET_STATUS_NO_RESULT, cullet_region_slots(region, NULL, 0, &count));
    IS(CULLET_STATUS_OK, cullet_region_cull(scene, &eyes, NULL, NULL, region));
    IS(CULLET_STATUS_OK, cullet_region_slots(region, found, 4, &count));
    THAT(count == 3);
    for (size_t i = 0; i < count; i++) THAT(found[i] != slots[1]);
    IS(CULLET_STATUS_OK, cullet_region_cull(scene, &eyes, &view, NULL, region));
    IS(CULLET_STATUS_OK, cullet_region_slots(region, found, 4, &count));
    THAT(count == 1 && found[0] == slots[0]);
    settings.ignored_layers = 1;
    IS(CULLET_STATUS_OK, cullet_region_cull(scene, &eyes, NULL, &settings, region));
    IS(CULLET_STATUS_OK, cullet_region_slots(region, found, 4, &count));
    THAT(count == 1 && found[0] == slots[2]);
    settings.width = 5;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_region_cull(scene, &eyes, NULL, &settings, region));
    SAYS("width is 5");
    settings.width = 0;
    settings.reserved = 1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_region_cull(scene, &eyes, NULL, &settings, region));
    IS(CULLET_STATUS_NULL_POINTER, cullet_region_cull(scene, NULL, NULL, NULL, region));
    IS(CULLET_STATUS_OK, cullet_region_destroy(region));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_region_destroy(region));
}

static void candidates(void) {
    cullet_state state;
    cullet_view view = ahead();
    cullet_settings settings;
    uint64_t words[1];
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_EXACT, &settings));
    words[0] = ~(UINT64_C(1) << slots[0]);
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
    THAT(has(state, 0) && !has(state, 1));
    IS(CULLET_STATUS_OK, cullet_cull_among(scene, &view, &settings, words, 1, state));
    THAT(!has(state, 0) && has(state, 1));
    /* What it answered is not taken for an answer without candidates, nor for one with others. */
    words[0] = UINT64_MAX;
    IS(CULLET_STATUS_OK, cullet_cull_among(scene, &view, &settings, words, 1, state));
    THAT(has(state, 0));
    words[0] = 0;
    IS(CULLET_STATUS_OK, cullet_cull_among(scene, &view, &settings, words, 1, state));
    THAT(!has(state, 0));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_among(scene, &view, &settings, words, 0, state));
    THAT(!has(state, 0));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
    THAT(has(state, 0));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

static void shadows(void) {
    cullet_state camera, state;
    cullet_view view = ahead(), map;
    cullet_settings settings;
    cullet_shadow shadow;
    const double above[3] = {0, 60, -10}, below[3] = {0, 0, -10.5};
    memset(&shadow, 0, sizeof shadow);
    shadow.light.kind = CULLET_LIGHT_KIND_DIRECTIONAL;
    shadow.light.direction[1] = -1;
    IS(CULLET_STATUS_OK, cullet_state_create(&camera));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_BALANCED, &settings));
    settings.reasons = 1;
    shadow.receivers = camera;
    IS(CULLET_STATUS_NO_RESULT, cullet_cull_shadow(scene, &view, &shadow, &settings, state));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, camera));
    /* The tower is seen by nobody, but its shadow is: the box behind the eye shades nothing that is. */
    IS(CULLET_STATUS_OK, cullet_cull_shadow(scene, &view, &shadow, &settings, state));
    THAT(has(state, 0) && has(state, 2) && !has(state, 3));
    cullet_reason reasons[4];
    size_t count;
    IS(CULLET_STATUS_OK, cullet_visible_reasons(state, reasons, 4, &count));
    THAT(count == 4 && reasons[slots[3]].stage == CULLET_STAGE_FRUSTUM);
    /* In a cascade that ends before the wall there is no receiver. */
    shadow.slice_near = 0.1;
    shadow.slice_far = 5;
    IS(CULLET_STATUS_OK, cullet_cull_shadow(scene, &view, &shadow, &settings, state));
    THAT(!has(state, 0) && !has(state, 2));
    shadow.slice_far = INFINITY;
    IS(CULLET_STATUS_OK, cullet_cull_shadow(scene, &view, &shadow, &settings, state));
    THAT(has(state, 0) && has(state, 2));
    shadow.slice_near = 7;
    shadow.slice_far = 6;
    IS(CULLET_STATUS_VIEW, cullet_cull_shadow(scene, &view, &shadow, &settings, state));
    SAYS("the slice of the shadow");
    shadow.slice_near = shadow.slice_far = 0;
    IS(CULLET_STATUS_OK, cullet_view_look_at(above, below, 0.9, 1, 512, 512, &map));
    shadow.light.kind = CULLET_LIGHT_KIND_SPOT;
    memcpy(shadow.light.position, above, sizeof above);
    shadow.light.range = 100;
    shadow.light.half_angle = 0.5;
    shadow.map = &map;
    map.layers = 1;
    IS(CULLET_STATUS_OK, cullet_cull_shadow(scene, &view, &shadow, NULL, state));
    THAT(has(state, 0) && !has(state, 2));
    shadow.margin = -1;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_shadow(scene, &view, &shadow, NULL, state));
    SAYS("shadow->margin is -1: it must be at least 0");
    shadow.margin = 0;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_shadow(scene, &view, &shadow, NULL, camera));
    SAYS("take another");
    shadow.receivers = state;
    IS(CULLET_STATUS_NO_RESULT, cullet_cull_shadow(scene, &view, &shadow, NULL, camera));
    SAYS("that of a light");
    shadow.light.kind = 3;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_shadow(scene, &view, &shadow, NULL, state));
    SAYS("shadow->light kind is 3: it must be 0 to 2");
    IS(CULLET_STATUS_OK, cullet_state_destroy(camera));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

static void lights(void) {
    cullet_state state;
    cullet_view view = ahead();
    cullet_settings settings;
    cullet_light five[5];
    uint8_t reasons[5] = {9, 9, 9, 9, 9};
    memset(five, 0, sizeof five);
    five[0].direction[1] = -1;
    for (int i = 1; i < 5; i++) {
        five[i].kind = CULLET_LIGHT_KIND_POINT;
        five[i].range = 3;
    }
    five[1].position[2] = -8; /* before the wall */
    five[2].position[2] = 20; /* behind the eye */
    five[3].position[2] = -6;
    five[3].position[0] = 2;
    five[3].range = 0;
    five[4].position[2] = -20; /* behind the wall */
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_EXACT, &settings));
    IS(CULLET_STATUS_NO_RESULT, cullet_cull_lights(scene, state, five, 5, reasons));
    IS(CULLET_STATUS_OK, cullet_cull(scene, &view, &settings, state));
    IS(CULLET_STATUS_OK, cullet_cull_lights(scene, state, five, 5, reasons));
    THAT(reasons[0] == CULLET_LIGHT_REASON_KEPT && reasons[1] == CULLET_LIGHT_REASON_KEPT);
    THAT(reasons[2] == CULLET_LIGHT_REASON_FRUSTUM && reasons[3] == CULLET_LIGHT_REASON_UNLIT);
    THAT(reasons[4] == CULLET_LIGHT_REASON_OCCLUSION || reasons[4] == CULLET_LIGHT_REASON_NO_RECEIVER);
    five[3].kind = 9;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_lights(scene, state, five, 5, reasons));
    SAYS("lights[3] kind is 9: it must be 0 to 2");
    five[3].kind = 1;
    five[3].reserved = 9;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_lights(scene, state, five, 5, reasons));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

static void eyes(void) {
    cullet_state state;
    cullet_view left, right, other = ahead();
    /* One eye beside the wall, and one before its end. */
    const double from[3] = {11, 0, 0}, ahead_of[3] = {11, 0, -1}, from_2[3] = {11.2, 0, 0}, ahead_2[3] = {11.2, 0, -1};
    uint8_t seen[4];
    size_t count;
    IS(CULLET_STATUS_OK, cullet_view_look_at(from, ahead_of, 0.9, 0.1, 640, 400, &left));
    IS(CULLET_STATUS_OK, cullet_view_look_at(from_2, ahead_2, 0.9, 0.1, 640, 400, &right));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_cull_stereo(scene, &left, &right, NULL, state));
    THAT(has(state, 0) && !has(state, 3));
    IS(CULLET_STATUS_OK, cullet_visible_eyes(state, scene, &left, &right, seen, 4, &count));
    THAT(count >= 1 && seen[0] == 3);
    IS(CULLET_STATUS_NO_RESULT, cullet_cull_lights(scene, state, NULL, 0, NULL));
    other.width = 100;
    IS(CULLET_STATUS_VIEW, cullet_cull_stereo(scene, &left, &other, NULL, state));
    IS(CULLET_STATUS_NULL_POINTER, cullet_cull_stereo(scene, &left, NULL, NULL, state));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
}

/* A pool that starts a thread for each job. */
typedef struct {
    void (*job)(void *, size_t);
    void *jobs;
    size_t number;
} call;

static size_t runs;

static void *one(void *argument) {
    const call *of = argument;
    of->job(of->jobs, of->number);
    return NULL;
}

static void run(void *context, void (*job)(void *, size_t), void *jobs, size_t count) {
    pthread_t threads[64];
    call calls[64];
    ++*(size_t *)context;
    for (size_t i = 0; i < count && i < 64; i++) {
        call of = {job, jobs, i};
        calls[i] = of;
        if (pthread_create(&threads[i], NULL, one, &calls[i]) != 0) exit(1);
    }
    for (size_t i = 0; i < count && i < 64; i++) pthread_join(threads[i], NULL);
}

static void threads(void) {
    enum { SIDE = 80 };
    static cullet_instance many[SIDE * SIDE];
    static uint32_t mine[SIDE * SIDE], pooled[SIDE * SIDE];
    cullet_mesh_arrays box = {CORNERS, 8, FACES, 36, NULL, 0, CULLET_ONE_SIDED, 0};
    cullet_scene city;
    cullet_state alone, state;
    cullet_settings settings;
    cullet_jobs jobs = {4, 0, run, &runs};
    uint32_t mesh;
    IS(CULLET_STATUS_OK, cullet_scene_create(&city));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(city, &box, &mesh));
    for (int i = 0; i < SIDE * SIDE; i++) {
        cullet_instance at = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}, 0, 1, 0, 0, 0};
        at.transform.linear[4] = (float)(1 + i * 7 % 9);
        at.transform.translation[0] = 3.0 * (i % SIDE);
        at.transform.translation[2] = 3.0 * (double)(i / SIDE);
        many[i] = at;
    }
    IS(CULLET_STATUS_OK, cullet_scene_add(city, many, SIDE * SIDE, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_commit(city));
    IS(CULLET_STATUS_OK, cullet_state_create(&alone));
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_EXACT, &settings));
    for (int frame = 0; frame < 8; frame++) {
        const double eye[3] = {-5, 3, 30.0 + frame}, target[3] = {200, 2, 120};
        cullet_view view;
        size_t count, of_pool;
        IS(CULLET_STATUS_OK, cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view));
        IS(CULLET_STATUS_OK, cullet_cull(city, &view, &settings, alone));
        IS(CULLET_STATUS_OK, cullet_cull_on(&jobs, city, &view, &settings, state));
        IS(CULLET_STATUS_OK, cullet_visible_slots(alone, mine, SIDE * SIDE, &count));
        IS(CULLET_STATUS_OK, cullet_visible_slots(state, pooled, SIDE * SIDE, &of_pool));
        THAT(count > 0 && count == of_pool && memcmp(mine, pooled, count * sizeof *mine) == 0);
    }
    THAT(runs > 0);
    cullet_view view = ahead();
    jobs.threads = 0;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_on(&jobs, city, &view, NULL, state));
    jobs.threads = 2;
    jobs.run = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_cull_on(&jobs, city, &view, NULL, state));
    SAYS("jobs->run is NULL");
    jobs.reserved = 3;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_cull_on(&jobs, city, &view, NULL, state));
    IS(CULLET_STATUS_NULL_POINTER, cullet_cull_on(NULL, city, &view, NULL, state));
    IS(CULLET_STATUS_OK, cullet_state_destroy(alone));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(city));
}

int main(void) {
    build();
    sights();
    boxes();
    regions();
    candidates();
    shadows();
    lights();
    eyes();
    threads();
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    printf("%d checks passed, jobs were run %zu times\n", checks, runs);
    return 0;
}
