/* Random numbers, memory that ends where a page ends, checks of what every call promises, and handles. */
#ifndef CULLET_TESTS_RANDOM_MACHINE_H
#define CULLET_TESTS_RANDOM_MACHINE_H

#define _GNU_SOURCE
#include <cullet.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

enum { PAGES = 32, PAGE = 1 << 17, MARK = 0xa5, FRONT = 32, OBJECTS = 4, IDS = 64 };
enum { SCENE, STATE, BUFFER, BOXES, REGION, SETS, KINDS };

static _Atomic uint64_t objects[KINDS][OBJECTS], stale[KINDS], instances[IDS];

typedef struct {
    uint64_t random;
    int thread, together, op, place, wrong, wild, page, out_count;
    long step;
    unsigned char *pages[PAGES];
    struct { unsigned char *at; size_t bytes; int is_count; } outs[8];
} run;

typedef struct {
    const char *name;
    void (*call)(run *);
    atomic_long failed, succeeded;
} operation;

static operation *named(int op);
static uint64_t first_seed;

static void fail(const run *r, const char *why) {
    fprintf(stderr, "seed %llu, thread %d, step %ld, %s: %s (last error: %s)\n", (unsigned long long)first_seed, r->thread,
            r->step, named(r->op)->name, why, cullet_last_error());
    _Exit(1);
}

/* Random numbers. */

static uint64_t next(run *r) {
    r->random ^= r->random << 13;
    r->random ^= r->random >> 7;
    r->random ^= r->random << 17;
    return r->random * UINT64_C(0x2545f4914f6cdd1d) >> 16;
}

static uint32_t below(run *r, uint32_t limit) { return (uint32_t)(next(r) % limit); }
static int one_in(run *r, uint32_t n) { return below(r, n) == 0; }

static double number(run *r, double low, double high) {
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0, 1e300, -1e300, 3e38, -3e38, 1e19, 1e-310, 1e-40, -1e7, 1};
    if (r->wild && one_in(r, (uint32_t)r->wild)) return odd[below(r, sizeof odd / sizeof *odd)];
    return low + (high - low) * (double)below(r, 1 << 24) / (1 << 24);
}

/* Takes note of an argument that the header refuses. */
static int bad(run *r, int is_wrong) { return r->wrong |= is_wrong; }

/* Now and then a wrong value in place of a right one. */
static uint32_t or_wrong(run *r, uint32_t right, uint32_t wrong) { return one_in(r, 60) && bad(r, 1) ? wrong : right; }
static size_t or_huge(run *r, size_t right) { return one_in(r, 80) && bad(r, 1) ? SIZE_MAX - below(r, 99) : right; }
static double finite_of(run *r, double value) { return bad(r, !isfinite(value)), value; }

/* Memory that ends where a page ends. */

static void *in(run *r, size_t bytes) {
    if (r->page == PAGES || bytes > PAGE) fail(r, "the test wants more memory than it has");
    return r->pages[r->page++] + PAGE - bytes;
}

static void *filled(run *r, size_t bytes, size_t size, double low, double high) {
    unsigned char *at = in(r, bytes);
    for (size_t i = 0; i + size <= bytes; i += size) {
        double wide = number(r, low, high);
        float narrow = (float)wide;
        memcpy(at + i, size == 4 ? (void *)&narrow : (void *)&wide, size);
    }
    return at;
}

static void *out_of(run *r, size_t bytes, int is_count) {
    unsigned char *at = in(r, bytes + FRONT);
    memset(at, MARK, bytes + FRONT);
    r->outs[r->out_count].at = at + FRONT;
    r->outs[r->out_count].bytes = bytes;
    r->outs[r->out_count++].is_count = is_count;
    return at + FRONT;
}

static void *out(run *r, size_t bytes) { return out_of(r, bytes, 0); }
static size_t *out_count(run *r) { return out_of(r, sizeof(size_t), 1); }

/* The pointer; or one that is not aligned, and so refused. */
static void *crooked(run *r, const void *right) { return (char *)(uintptr_t)right + (one_in(r, 120) && bad(r, 1)); }

/* The pointer; or one that is refused, where there is something to point to. */
static void *ptr(run *r, const void *right, size_t count) {
    if (count && one_in(r, 120) && bad(r, 1)) return NULL;
    return count ? crooked(r, right) : (void *)(uintptr_t)right;
}

static void *bytes_ptr(run *r, void *right, size_t count) { return count && one_in(r, 60) && bad(r, 1) ? NULL : right; }
static void *optional(run *r, const void *right) { return one_in(r, 4) ? NULL : crooked(r, right); }

static int is_marked(const unsigned char *at, size_t bytes) {
    return !bytes || (*at == MARK && !memcmp(at, at + 1, bytes - 1));
}

/* Of an output, `bytes` were written and no more. */
static void written(run *r, const void *at, size_t bytes) {
    for (int i = 0; i < r->out_count; i++) {
        if (r->outs[i].at != at) continue;
        if (bytes > r->outs[i].bytes) fail(r, "a count is larger than the array");
        if (!is_marked(r->outs[i].at + bytes, r->outs[i].bytes - bytes)) fail(r, "written beyond the count");
    }
}

static int is_utf8(const char *text) {
    const unsigned char *c = (const unsigned char *)text;
    while (*c) {
        int more = *c < 0x80 ? 0 : *c >> 5 == 6 && *c >= 0xc2 ? 1 : *c >> 4 == 14 ? 2 : *c >> 3 == 30 && *c < 0xf5 ? 3 : -1;
        if (more < 0) return 0;
        for (c++; more > 0; more--, c++) if (*c >> 6 != 2) return 0;
    }
    return 1;
}

/* Checks how a call ended; returns whether it succeeded. */
static int done(run *r, cullet_status status) {
    operation *of = named(r->op);
    const char *message = cullet_last_error();
    size_t length = strlen(of->name);
    int ok = status == CULLET_STATUS_OK, small = status == CULLET_STATUS_TOO_SMALL;
    atomic_fetch_add(ok ? &of->succeeded : &of->failed, 1);
    int is_own = (status == CULLET_STATUS_STOPPED && strstr(of->name, "_bake_")) ||
                 (status == CULLET_STATUS_TOO_LATE && strstr(of->name, "_allocator"));
    if (!is_own && ((int)status < 0 || status >= CULLET_STATUS_FULL)) fail(r, "a status that is none, or a defect");
    if (status == CULLET_STATUS_BUSY && !r->together) fail(r, "busy, and nobody else calls");
    if (ok && r->wrong) fail(r, "an argument was taken that the header refuses");
    for (int i = 0; i < r->out_count; i++) {
        if (!is_marked(r->outs[i].at - FRONT, FRONT)) fail(r, "written before an array");
        if (!ok && !(small && r->outs[i].is_count) && !is_marked(r->outs[i].at, r->outs[i].bytes)) {
            fail(r, "an output was written by a call that failed");
        }
    }
    if (ok) return 1;
    if (strncmp(message, of->name, length) || strncmp(message + length, ": ", 2) || !message[length + 3]) {
        fail(r, "the message does not name the function, or says nothing");
    }
    if (!is_utf8(message) || strchr(message, '\n')) fail(r, "the message is no line of UTF-8");
    return 0;
}

/* Results: a count, and an array of `size` an element, or too little room for it. */
static int counted(run *r, int ok, const void *array, size_t size, size_t room, const size_t *count) {
    if (!ok) {
        if (!is_marked((const unsigned char *)count, sizeof *count) && *count <= room) fail(r, "room for all was too little");
        return 0;
    }
    if (room && *count > room) fail(r, "a count is larger than the array");
    written(r, array, room ? *count * size : 0);
    return room > 0;
}

/* Slots ascend. */
static void slots(run *r, const uint32_t *all, size_t count) {
    for (size_t i = 1; i < count; i++) if (all[i - 1] >= all[i]) fail(r, "slots do not ascend");
}

/* Handles. */

static uint64_t any_of(run *r, int kind) { return atomic_load(&objects[kind][below(r, OBJECTS)]); }

static uint64_t wrong_handle(run *r, int kind) {
    int other = (kind + 1 + (int)below(r, KINDS - 1)) % KINDS;
    bad(r, 1);
    switch (below(r, 6)) {
    case 0: return 0;
    case 1: return atomic_load(&stale[kind]);
    case 2: return any_of(r, other);
    case 3: return any_of(r, kind) | (uint64_t)1 << 55; /* a generation that is never reached */
    case 4: return any_of(r, kind) | 0xffffff;          /* an index that is never reached */
    default: return next(r) | (uint64_t)0xff << 56;
    }
}

static uint64_t pick(run *r, int kind) {
    uint64_t id = 0;
    if (one_in(r, 25)) return wrong_handle(r, kind);
    /* Mostly objects of one place, so that a state has a result of its scene. */
    if (!one_in(r, 4)) id = atomic_load(&objects[kind][r->place]);
    for (int i = 0; i < 8 && !id; i++) id = any_of(r, kind);
    bad(r, id == 0);
    return id;
}

static cullet_scene scene(run *r) { return (cullet_scene){pick(r, SCENE)}; }
static cullet_state state(run *r) { return (cullet_state){pick(r, STATE)}; }
static cullet_occlusion buffer(run *r) { return (cullet_occlusion){pick(r, BUFFER)}; }
static cullet_boxes boxes(run *r) { return (cullet_boxes){pick(r, BOXES)}; }
static cullet_region region(run *r) { return (cullet_region){pick(r, REGION)}; }

static cullet_status destroy(int kind, uint64_t id) {
    switch (kind) {
    case SCENE: return cullet_scene_destroy((cullet_scene){id});
    case STATE: return cullet_state_destroy((cullet_state){id});
    case BUFFER: return cullet_occlusion_destroy((cullet_occlusion){id});
    case BOXES: return cullet_boxes_destroy((cullet_boxes){id});
    case SETS: return cullet_pvs_destroy((cullet_pvs){id});
    default: return cullet_region_destroy((cullet_region){id});
    }
}

/* Puts an object in the place of another, which is destroyed once nobody uses it. */
static cullet_status replace(int kind, int place, uint64_t id) {
    uint64_t old = atomic_exchange(&objects[kind][place], id);
    cullet_status status = CULLET_STATUS_OK;
    while (old && (status = destroy(kind, old)) == CULLET_STATUS_BUSY) sched_yield();
    if (old) atomic_store(&stale[kind], old);
    return status;
}

static void keep(run *r, int kind, uint64_t id) {
    if (replace(kind, (int)below(r, OBJECTS), id) != CULLET_STATUS_OK) fail(r, "an object could not be destroyed");
}

/* Destroys an object, or fails to. */
static void destroy_one(run *r, int kind) {
    int is_wrong = !one_in(r, 4);
    done(r, is_wrong ? destroy(kind, wrong_handle(r, kind)) : replace(kind, (int)below(r, OBJECTS), 0));
}

static cullet_handle handle(run *r) {
    uint64_t packed = atomic_load(&instances[below(r, IDS)]);
    if (one_in(r, 30)) packed = next(r);
    return (cullet_handle){(uint32_t)packed, (uint32_t)(packed >> 32)};
}

static cullet_handle *handles(run *r, size_t count) {
    cullet_handle *all = in(r, count * sizeof *all);
    for (size_t i = 0; i < count; i++) all[i] = handle(r);
    return all;
}

#endif
