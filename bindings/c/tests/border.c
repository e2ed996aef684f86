/* A frame in C at 1e5 instances, for examples/border.rs, which runs it beside the same in Rust; and by itself a count of what
 * a frame allocates. cc -shared -fPIC border.c -lcullet for the first; cc -DALONE border.c -lcullet for the second. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <cullet.h>

#define SIDE 317
#define COUNT (SIDE * SIDE)

static cullet_scene scene;
static cullet_state state;
static uint32_t slots[COUNT], drawn[COUNT];
static cullet_draw_command commands[COUNT];
static cullet_draw_key keys[COUNT];

static void check(cullet_status status) {
    if (status == CULLET_STATUS_OK) return;
    fprintf(stderr, "%s\n", cullet_last_error());
    exit(1);
}

void border_setup(void);
size_t border_frame(uint32_t frame);

void border_setup(void) {
    static const float corners[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    static const uint32_t faces[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                       3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};
    static cullet_instance instances[COUNT];
    cullet_mesh_arrays box = {corners, 8, faces, 36, NULL, 0, CULLET_ONE_SIDED, 0};
    uint32_t mesh;
    check(cullet_scene_create(&scene));
    check(cullet_scene_add_mesh(scene, &box, &mesh));
    for (int i = 0; i < COUNT; i++) {
        cullet_instance at = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}, 0, 1, 0, 0, 0};
        at.transform.translation[0] = 3.0 * (i % SIDE);
        at.transform.translation[2] = 3.0 * (double)(i / SIDE);
        at.mesh = mesh;
        instances[i] = at;
    }
    check(cullet_scene_add(scene, instances, COUNT, NULL));
    check(cullet_scene_commit(scene));
    check(cullet_state_create(&state));
}

/* Culls, and reads slots and draws; returns how many are visible. */
size_t border_frame(uint32_t frame) {
    const double angle = 0.01 * frame, middle = 1.5 * SIDE;
    const double eye[3] = {middle, 20, middle};
    const double target[3] = {middle + 100 * cos(angle), 0, middle + 100 * sin(angle)};
    cullet_draws draws = {commands, keys, COUNT, 0, drawn, COUNT, 0, NULL, 0, 0};
    cullet_view view;
    size_t count;
    check(cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view));
    check(cullet_cull(scene, &view, NULL, state));
    check(cullet_visible_slots(state, slots, COUNT, &count));
    check(cullet_visible_draws(state, scene, NULL, 0, &draws));
    return count;
}

/* The same place as boxes alone, with some walls before them. */
static cullet_boxes boxes;
static cullet_box corners_of[COUNT];
static uint8_t flags[COUNT];

static void take_boxes(void) {
    cullet_box_arrays arrays = {corners_of[0].min, corners_of[0].max, sizeof(cullet_box), 0, COUNT, 0, 0, {0, 0, 0}};
    check(cullet_boxes_set(boxes, &arrays));
}

void boxes_setup(void);
size_t boxes_frame(uint32_t frame, uint32_t sets);

void boxes_setup(void) {
    static float walls[64][6];
    cullet_occluder occluder = {CULLET_OCCLUDER_KIND_BOXES, 0, walls[0], 24, 64, NULL, 0, NULL};
    for (int i = 0; i < COUNT; i++) {
        const float x = 3.0f * (float)(i % SIDE), z = 3.0f * (float)(i / SIDE);
        cullet_box box = {{x, 0, z}, {x + 1, 1, z + 1}};
        corners_of[i] = box;
    }
    for (int i = 0; i < 64; i++) {
        const float x = 118.0f * (float)(i % 8), z = 118.0f * (float)(i / 8);
        const float wall[6] = {x, 0, z, x + 40, 9, z + 2};
        for (int k = 0; k < 6; k++) walls[i][k] = wall[k];
    }
    check(cullet_boxes_create(640, &boxes));
    check(cullet_boxes_set_occluders(boxes, &occluder, 1));
    take_boxes();
}

/* Culls boxes, which are set anew where `sets` is 1; returns how many are visible. */
size_t boxes_frame(uint32_t frame, uint32_t sets) {
    const double angle = 0.01 * frame, middle = 1.5 * SIDE;
    const double eye[3] = {middle, 5, middle};
    const double target[3] = {middle + 100 * cos(angle), 0, middle + 100 * sin(angle)};
    cullet_view view;
    size_t visible;
    if (sets) take_boxes();
    check(cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view));
    check(cullet_boxes_cull(boxes, &view, flags, COUNT, &visible));
    return visible;
}

#ifdef ALONE
/* glibc's own, which these stand before in the whole process. */
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
static size_t allocations;

void *malloc(size_t size) {
    allocations++;
    return __libc_malloc(size);
}
void *calloc(size_t count, size_t size) {
    allocations++;
    return __libc_calloc(count, size);
}
void *realloc(void *of, size_t size) {
    allocations++;
    return __libc_realloc(of, size);
}
void *aligned_alloc(size_t alignment, size_t size) {
    allocations++;
    return __libc_memalign(alignment, size);
}
int posix_memalign(void **to, size_t alignment, size_t size);
int posix_memalign(void **to, size_t alignment, size_t size) {
    allocations++;
    *to = __libc_memalign(alignment, size);
    return *to == NULL ? 12 : 0;
}

int main(void) {
    border_setup();
    const size_t before = allocations;
    /* Once around: arrays grow to what the scene needs. */
    for (uint32_t frame = 0; frame < 629; frame++) border_frame(frame);
    const size_t grown = allocations;
    size_t count = 0;
    for (uint32_t frame = 0; frame < 629; frame++) count += border_frame(frame);
    /* Before printf, which allocates itself. */
    const size_t in_frames = allocations - grown;
    printf("%zu allocations to set up, %zu while arrays grew, %zu in 629 frames of %zu visible instances\n", before,
           grown - before, in_frames, count / 629);
    return before == 0 || in_frames != 0;
}
#endif
