/* Boxes in, flags out: answers, every mistake that a program makes in passing arrays, and what a frame allocates. */
#include <math.h>
#include "check.h"

/* glibc's own, which these stand before in the whole process. */
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
static size_t allocations;

#ifdef COUNT_ALLOCATIONS
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
#endif

typedef struct {
    uint64_t name;
    float center[3], half[3];
} object;

static object objects[4] = {{1, {0, 0, -8}, {1, 1, 1}},
                            {2, {0, 0, -20}, {1, 1, 1}},
                            {3, {0, 0, 20}, {1, 1, 1}},
                            {4, {9, 0, -20}, {1, 1, 1}}};
static const float WALL[6] = {-5, -5, -11, 5, 5, -10};
static const float BODY[12] = {40, 40, -10, -40, -40, -10, -40, 40, -90, 40, -40, -90};
static const uint16_t FACES[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

static cullet_box_arrays arrays_of(void) {
    cullet_box_arrays arrays = {objects[0].center, objects[0].half, sizeof(object), 0, 4, 0, 0, {0, 0, 0}};
    arrays.form = CULLET_BOX_FORM_CENTER_HALF;
    return arrays;
}

static cullet_occluder wall_of(void) {
    cullet_occluder wall = {CULLET_OCCLUDER_KIND_BOXES, 0, WALL, 24, 1, NULL, 0, NULL};
    return wall;
}

static cullet_occluder body_of(uint32_t kind) {
    cullet_occluder body = {0, 2, BODY, 12, 4, FACES, 12, NULL};
    body.kind = kind;
    return body;
}

static void answers(void) {
    cullet_boxes boxes;
    cullet_box_arrays arrays = arrays_of();
    cullet_occluder occluder = wall_of();
    cullet_view view = ahead();
    uint8_t flags[5] = {9, 9, 9, 9, 9};
    uint64_t words[1];
    size_t visible;
    IS(CULLET_STATUS_OK, cullet_boxes_create(0, &boxes));
    IS(CULLET_STATUS_OK, cullet_boxes_cull(boxes, &view, NULL, 0, &visible));
    THAT(visible == 0);
    IS(CULLET_STATUS_OK, cullet_boxes_set(boxes, &arrays));
    IS(CULLET_STATUS_OK, cullet_boxes_cull(boxes, &view, flags, 5, &visible));
    THAT(visible == 3 && flags[0] == 1 && flags[1] == 1 && flags[2] == 0 && flags[3] == 1 && flags[4] == 9);
    IS(CULLET_STATUS_OK, cullet_boxes_set_occluders(boxes, &occluder, 1));
    IS(CULLET_STATUS_OK, cullet_boxes_cull(boxes, &view, flags, 4, NULL));
    THAT(flags[0] == 1 && flags[1] == 0 && flags[2] == 0 && flags[3] == 1);
    IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, &visible));
    THAT(words[0] == 9 && visible == 2);
    /* The wall goes away, and comes back as triangles that are seen from both sides. */
    const cullet_transform away = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 100, 0}};
    IS(CULLET_STATUS_OK, cullet_boxes_move_occluder(boxes, 0, &away));
    IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
    THAT(words[0] == 11);
    for (uint32_t kind = CULLET_OCCLUDER_KIND_HULL; kind <= CULLET_OCCLUDER_KIND_TWO_SIDED_TRIANGLES; kind++) {
        occluder = body_of(kind);
        IS(CULLET_STATUS_OK, cullet_boxes_set_occluder(boxes, 0, &occluder));
        IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
        THAT((words[0] & 6) == 0 && (words[0] & 1) == 1);
    }
    /* A box moves: the others stay. */
    arrays.count = 1;
    arrays.first = objects[2].center;
    objects[2].center[2] = -8;
    IS(CULLET_STATUS_OK, cullet_boxes_update(boxes, 2, &arrays));
    IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
    THAT((words[0] & 7) == 5);
    objects[2].center[2] = 20;
    IS(CULLET_STATUS_OK, cullet_boxes_destroy(boxes));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
}

static void mistakes(void) {
    cullet_boxes boxes, none = {0}, wrong;
    cullet_occlusion buffer;
    cullet_box_arrays arrays = arrays_of(), bad;
    cullet_view view = ahead(), empty;
    uint8_t flags[4] = {9, 9, 9, 9};
    size_t visible = 99;
    memset(&empty, 0, sizeof empty);
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_create(5000, &boxes));
    SAYS("occlusion_width is 5000: it must be 0 to 4096");
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_create(0, NULL));
    IS(CULLET_STATUS_OK, cullet_boxes_create(0, &boxes));
    IS(CULLET_STATUS_OK, cullet_occlusion_create(8, 8, &buffer));
    wrong.id = buffer.id;
    IS(CULLET_STATUS_WRONG_HANDLE, cullet_boxes_set(wrong, &arrays));
    SAYS("is the handle of an occlusion buffer, not of a set of boxes");
    IS(CULLET_STATUS_OK, cullet_occlusion_destroy(buffer));
    IS(CULLET_STATUS_NULL_HANDLE, cullet_boxes_set(none, &arrays));
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_set(boxes, NULL));
    bad = arrays;
    bad.second = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_set(boxes, &bad));
    SAYS("arrays->second is NULL, but its length is given as 4");
    bad = arrays;
    bad.stride = 10;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    SAYS("the stride of arrays->first is 10 bytes: it must be a multiple of 4 and at least 12");
    bad = arrays;
    bad.second_stride = 8;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    SAYS("the stride of arrays->second is 8 bytes");
    bad = arrays;
    bad.number = CULLET_NUMBER_F64;
    bad.stride = 20;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    SAYS("at least 24");
    bad = arrays;
    bad.first = (const char *)objects[0].center + 1;
    IS(CULLET_STATUS_ALIGNMENT, cullet_boxes_set(boxes, &bad));
    bad = arrays;
    bad.count = SIZE_MAX / 4;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    bad = arrays;
    bad.number = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    SAYS("arrays->number is 2: it must be 0 or 1, a cullet_number");
    bad = arrays;
    bad.form = 2;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    bad = arrays;
    bad.origin[1] = NAN;
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set(boxes, &bad));
    IS(CULLET_STATUS_OK, cullet_boxes_set(boxes, &arrays));
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_update(boxes, 1, &arrays));
    SAYS("4 boxes from box 1 on, but the set has 4");
    IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_update(boxes, SIZE_MAX, &arrays));
    IS(CULLET_STATUS_TOO_SMALL, cullet_boxes_cull(boxes, &view, flags, 3, &visible));
    SAYS("room for 3 flags, but 4 are needed");
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_cull(boxes, &view, NULL, 4, &visible));
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_cull(boxes, NULL, flags, 4, &visible));
    IS(CULLET_STATUS_STRUCT_SIZE, cullet_boxes_cull(boxes, &empty, flags, 4, &visible));
    IS(CULLET_STATUS_TOO_SMALL, cullet_boxes_cull_bits(boxes, &view, NULL, 0, &visible));
    THAT(flags[0] == 9 && visible == 99);
    IS(CULLET_STATUS_OK, cullet_boxes_destroy(boxes));
}

static void occluders(void) {
    cullet_boxes boxes;
    cullet_box_arrays arrays = arrays_of();
    cullet_view view = ahead();
    uint64_t words[1];
    float nan[12];
    memcpy(nan, BODY, sizeof nan);
    nan[7] = NAN;
    IS(CULLET_STATUS_OK, cullet_boxes_create(0, &boxes));
    IS(CULLET_STATUS_OK, cullet_boxes_set(boxes, &arrays));
    cullet_occluder two[2] = {wall_of(), wall_of()};
    IS(CULLET_STATUS_OK, cullet_boxes_set_occluders(boxes, two, 1));
#define REFUSED(words) IS(CULLET_STATUS_INVALID_VALUE, cullet_boxes_set_occluders(boxes, two, 2)); SAYS(words)
    two[1].kind = 7;
    REFUSED("occluder 1: kind is 7: it must be 0 to 3");
    two[1] = wall_of();
    two[1].stride = 20;
    REFUSED("occluder 1: stride is 20: it must be at least 24 bytes");
    two[1] = wall_of();
    two[1].position_count = 0;
    REFUSED("occluder 1: it has no positions");
    const float turned[6] = {1, 0, 0, 0, 1, 1};
    two[1] = wall_of();
    two[1].positions = turned;
    REFUSED("occluder 1: box 0");
    two[1].positions = nan + 3;
    REFUSED("occluder 1: box 0 is not finite");
    two[1] = body_of(CULLET_OCCLUDER_KIND_TRIANGLES);
    two[1].positions = nan;
    REFUSED("occluder 1: vertex 2 is not finite");
    two[1] = body_of(CULLET_OCCLUDER_KIND_HULL);
    two[1].position_count = 3;
    REFUSED("occluder 1: index 3, but there are 3 vertices");
    two[1].kind = CULLET_OCCLUDER_KIND_TRIANGLES;
    REFUSED("occluder 1: index 3, but there are 3 vertices");
    two[1] = body_of(CULLET_OCCLUDER_KIND_HULL);
    two[1].index_count = 9;
    REFUSED("give them as CULLET_OCCLUDER_KIND_TRIANGLES");
    two[1].index_count = 10;
    REFUSED("occluder 1: 10 indices do not make whole triangles");
    two[1].index_size = 1;
    REFUSED("occluder 1: index_size is 1: it must be 4 or 2");
    two[1].index_size = 2;
    two[1].indices = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_boxes_set_occluders(boxes, two, 2));
    SAYS("indices of occluder 1 is NULL");
    /* All the time the first wall is there. */
    IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
    THAT(words[0] == 9);
    IS(CULLET_STATUS_NOT_FOUND, cullet_boxes_move_occluder(boxes, 1, NULL));
    IS(CULLET_STATUS_NOT_FOUND, cullet_boxes_set_occluder(boxes, 1, &two[0]));
    SAYS("occluder 1: the set has 1");
    IS(CULLET_STATUS_OK, cullet_boxes_set_occluders(boxes, NULL, 0));
    IS(CULLET_STATUS_OK, cullet_boxes_cull_bits(boxes, &view, words, 1, NULL));
    THAT(words[0] == 11);
    IS(CULLET_STATUS_OK, cullet_boxes_destroy(boxes));
}

/* Frames in which boxes, a wall and triangles move: the second half allocates nothing. */
static void frames(void) {
    enum { COUNT = 5000, FRAMES = 60 };
    static object many[COUNT];
    static uint8_t flags[COUNT];
    static float moving[12];
    cullet_boxes boxes;
    cullet_box_arrays arrays = arrays_of(), one = arrays_of();
    cullet_occluder two[2] = {wall_of(), body_of(CULLET_OCCLUDER_KIND_TRIANGLES)};
    size_t before = 0;
    for (int i = 0; i < COUNT; i++) {
        object at = {0, {(float)(i % 100) - 50, (float)(i / 1000) - 2, -(float)(i % 71) - 5}, {0.4f, 0.4f, 0.4f}};
        many[i] = at;
    }
    arrays.first = many[0].center;
    arrays.second = many[0].half;
    arrays.count = COUNT;
    IS(CULLET_STATUS_OK, cullet_boxes_create(320, &boxes));
    IS(CULLET_STATUS_OK, cullet_boxes_set_occluders(boxes, two, 2));
    two[1].positions = moving;
    one.count = 1;
    for (int frame = 0; frame < 2 * FRAMES; frame++) {
        const double angle = 0.02 * (frame % FRAMES);
        const double eye[3] = {0, 0, 0}, target[3] = {sin(angle), 0, -cos(angle)};
        const cullet_transform moved = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {angle, 0, 0}};
        cullet_view view;
        if (frame == FRAMES) before = allocations;
        for (int i = 0; i < 12; i++) moving[i] = BODY[i] + (float)angle;
        IS(CULLET_STATUS_OK, cullet_boxes_set(boxes, &arrays));
        IS(CULLET_STATUS_OK, cullet_boxes_update(boxes, 7, &one));
        IS(CULLET_STATUS_OK, cullet_boxes_move_occluder(boxes, 0, &moved));
        IS(CULLET_STATUS_OK, cullet_boxes_set_occluder(boxes, 1, &two[1]));
        IS(CULLET_STATUS_OK, cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view));
        IS(CULLET_STATUS_OK, cullet_boxes_cull(boxes, &view, flags, COUNT, NULL));
    }
    const size_t in_frames = allocations - before;
#ifdef COUNT_ALLOCATIONS
    THAT(before > 0 && in_frames == 0);
#else
    THAT(before == 0 && in_frames == 0);
#endif
    IS(CULLET_STATUS_OK, cullet_boxes_destroy(boxes));
}

int main(void) {
    answers();
    mistakes();
    occluders();
    frames();
    printf("%d checks of boxes passed\n", checks);
    return 0;
}
