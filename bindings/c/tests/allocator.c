/* The caller's allocator. A process has one for its whole life, so each test is a process of its own. */
#define _GNU_SOURCE
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include "house.h"
#include "own_allocator.h"

static own_memory own;

/* Makes, culls, reads and destroys one of each kind, and has one call refused. */
static void use(void) {
    cullet_scene scene = house();
    cullet_state state;
    cullet_boxes boxes;
    cullet_occlusion buffer;
    cullet_region region;
    cullet_view view = inside(0);
    const cullet_box box = {{-1, -1, -9}, {1, 1, -8}};
    const cullet_eye_box eyes = {{-5, 1, -2}, {-4.9, 1.1, -1.9}};
    const cullet_region_settings few = {.most_cells = 4, .width = 32, .most_bodies = 20};
    cullet_box_arrays arrays = {box.min, box.max, sizeof box, 0, 1, 0, 0, {0, 0, 0}};
    uint8_t flag;
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    THAT(sees(scene, state, &view, 0, 0) != 0);
    IS(CULLET_STATUS_OK, cullet_boxes_create(0, &boxes));
    IS(CULLET_STATUS_OK, cullet_boxes_set(boxes, &arrays));
    IS(CULLET_STATUS_OK, cullet_boxes_cull(boxes, &view, &flag, 1, NULL));
    IS(CULLET_STATUS_OK, cullet_occlusion_create(64, 64, &buffer));
    IS(CULLET_STATUS_OK, cullet_occlusion_begin(buffer, &view, NULL));
    IS(CULLET_STATUS_OK, cullet_occlusion_draw_boxes(buffer, &box, 1, NULL));
    IS(CULLET_STATUS_OK, cullet_region_create(&region));
    IS(CULLET_STATUS_OK, cullet_region_cull(scene, &eyes, NULL, &few, region));
    IS(CULLET_STATUS_OK, cullet_region_destroy(region));
    IS(CULLET_STATUS_OK, cullet_occlusion_destroy(buffer));
    IS(CULLET_STATUS_OK, cullet_boxes_destroy(boxes));
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    IS(CULLET_STATUS_OK, cullet_scene_destroy(scene));
    IS(CULLET_STATUS_STALE_HANDLE, cullet_scene_commit(scene));
}

static void *use_on_a_thread(void *unused) {
    for (int i = 0; i < 3; i++) use();
    return unused;
}

static void counts(int has_realloc) {
    cullet_allocator functions = own_functions(&own);
    pthread_t threads[4];
    if (!has_realloc) functions.realloc = NULL;
    IS(CULLET_STATUS_OK, cullet_set_allocator(&functions));
    memset(&functions, 0, sizeof functions); /* copied */
    THAT(own.calls == 0);
    use();
    /* What stays are tables of handles and the last message. */
    const size_t blocks = own.blocks, bytes = own.bytes, calls = own.calls;
    THAT(calls > 100 && blocks > 0 && blocks < 40);
    THAT((own.reallocs > 0) == has_realloc);
    for (int i = 0; i < 5; i++) use();
    THAT(own.blocks == blocks && own.bytes == bytes && own.calls > 5 * (calls - 40));
    for (int i = 0; i < 4; i++) THAT(pthread_create(&threads[i], NULL, use_on_a_thread, NULL) == 0);
    for (int i = 0; i < 4; i++) THAT(pthread_join(threads[i], NULL) == 0);
    /* Lists of free handles may have grown. Each thread has freed its message. */
    THAT(own.blocks == blocks && own.bytes <= bytes + 400);
    THAT(own.most_alignment >= 8 && own.most_alignment <= 64);
    printf("%zu calls, %zu blocks and %zu bytes left, alignments up to %zu\n", own.calls, own.blocks, own.bytes,
           own.most_alignment);
}

static void counts_with_realloc(void) { counts(1); }
static void counts_without_realloc(void) { counts(0); }

static void frames_allocate_nothing(void) {
    const cullet_allocator functions = own_functions(&own);
    IS(CULLET_STATUS_OK, cullet_set_allocator(&functions));
    cullet_scene scene = house();
    cullet_state state;
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    size_t before = 0;
    for (int frame = 0; frame < 40; frame++) {
        if (frame == 20) before = own.calls;
        cullet_view view = inside(frame % VIEWS);
        THAT(sees(scene, state, &view, 0, 0) != 0);
    }
    THAT(before > 0 && own.calls == before);
}

static void refusals(void) {
    const cullet_allocator right = own_functions(&own);
    cullet_allocator wrong = right;
    char bytes[2 * sizeof right];
    THAT(cullet_version() != NULL);
    IS(CULLET_STATUS_NULL_POINTER, cullet_set_allocator(NULL));
    IS(CULLET_STATUS_ALIGNMENT, cullet_set_allocator((const cullet_allocator *)(void *)(bytes + 1 - (uintptr_t)bytes % 2)));
    wrong.alloc = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_set_allocator(&wrong));
    SAYS("cullet_set_allocator: allocator->alloc is NULL");
    wrong = right;
    wrong.free = NULL;
    IS(CULLET_STATUS_NULL_POINTER, cullet_set_allocator(&wrong));
    SAYS("allocator->free is NULL");
    /* Refusals allocated nothing, so that it is not too late. */
    IS(CULLET_STATUS_OK, cullet_set_allocator(&right));
    IS(CULLET_STATUS_TOO_LATE, cullet_set_allocator(&right));
    THAT(own.calls == 0);
    use();
    THAT(own.calls > 100);
    IS(CULLET_STATUS_TOO_LATE, cullet_set_allocator(&right));
    SAYS("make this the first call");
}

static void too_late(void) {
    const cullet_allocator functions = own_functions(&own);
    cullet_state state;
    IS(CULLET_STATUS_OK, cullet_state_create(&state));
    IS(CULLET_STATUS_TOO_LATE, cullet_set_allocator(&functions));
    SAYS("the library has allocated memory");
    use();
    IS(CULLET_STATUS_OK, cullet_state_destroy(state));
    THAT(own.calls == 0);
}

static void exhausted(void) {
    const cullet_allocator functions = own_functions(&own);
    own.limit = 100000;
    IS(CULLET_STATUS_OK, cullet_set_allocator(&functions));
    use();
}

/* Runs a test in a process of its own; returns how it ended, and what it wrote to stderr. */
static int run_alone(void (*test)(void), char *said, size_t room) {
    int ends[2], status;
    THAT(pipe(ends) == 0);
    fflush(NULL);
    const pid_t child = fork();
    THAT(child >= 0);
    if (child == 0) {
        if (said) dup2(ends[1], 2);
        test();
        exit(0);
    }
    close(ends[1]);
    for (ssize_t got; said && room > 1 && (got = read(ends[0], said, room - 1)) > 0; said += got, room -= (size_t)got) said[got] = 0;
    close(ends[0]);
    THAT(waitpid(child, &status, 0) == child);
    return status;
}

int main(void) {
    static void (*const tests[])(void) = {counts_with_realloc, counts_without_realloc, frames_allocate_nothing, refusals,
                                          too_late};
    static char said[4096];
    for (size_t i = 0; i < sizeof tests / sizeof *tests; i++) THAT(run_alone(tests[i], NULL, 0) == 0);
    const int status = run_alone(exhausted, said, sizeof said);
    fputs(said, stderr);
    THAT(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT && strstr(said, "memory allocation of "));
    printf("%d checks passed\n", checks);
    return 0;
}
