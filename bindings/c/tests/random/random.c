/* Calls every function of cullet.h at random, and checks what the header promises of all of them:
 *     random [SECONDS] [SEED] [rates]
 *
 * Arguments are right, or wrong in a way that the library can see: handles that are stale, of another kind or never made,
 * NULL, pointers that are not aligned, counts beyond memory, numbers that are NaN, infinite or huge, indices out of range,
 * arrays that are too short. What the header leaves to the caller is kept: an array has as many elements as its count says.
 *
 * Checks: a status that the header lists and that is no defect; no success with an argument that the header refuses; after a
 * failure a message of one line of UTF-8 that names the function, and outputs as they were; after a success nothing written
 * beyond the count. Every array ends where memory ends, so that one element too many ends the program.
 *
 * Half of the time one thread calls, so that a seed takes the same steps again; then two share all objects. `rates` lists how
 * often each function succeeded and failed. Memory of odd seeds comes from an allocator of the test's, which checks what is given
 * back, and at the end that all of it was. -DBAKES for a library with bakes: then visible sets are made and called too. */
#ifdef BAKES
#include "sets.h"
#else
#include "levels.h"
#endif
#include "../own_allocator.h"

static void do_visible_slots(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    uint32_t *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_slots(state(r), to, given, ptr(r, count, 1)));
    if (counted(r, ok, all, sizeof *all, room, count)) slots(r, all, *count);
}

static void do_visible_handles(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    cullet_handle *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_handles(state(r), scene(r), to, given, ptr(r, count, 1)));
    counted(r, ok, all, sizeof *all, room, count);
}

static void do_visible_users(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    uint64_t *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_users(state(r), scene(r), to, given, ptr(r, count, 1)));
    counted(r, ok, all, sizeof *all, room, count);
}

static void do_visible_reasons(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    cullet_reason *all = out(r, room * sizeof *all);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_reasons(state(r), bytes_ptr(r, all, room), given, ptr(r, count, 1)));
    if (!counted(r, ok, all, sizeof *all, room, count)) return;
    for (size_t i = 0; i < *count; i++) if (all[i].stage > CULLET_STAGE_DEGENERATE) fail(r, "a stage that is none");
}

static void do_visible_funnel(run *r) {
    size_t room = capacity(r, 32), *count = out_count(r);
    cullet_funnel_row *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_funnel(state(r), to, given, ptr(r, count, 1)));
    if (!counted(r, ok, all, sizeof *all, room, count)) return;
    for (size_t i = 0; i < *count; i++) {
        if (all[i].stage > CULLET_STAGE_DEGENERATE || all[i].unit > 2) fail(r, "a row of no stage or unit");
        if (all[i].left.instances > all[i].entered.instances) fail(r, "more leave a stage than entered");
    }
}

static void do_visible_eyes(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    uint8_t *all = out(r, room), *to = bytes_ptr(r, all, room);
    const cullet_view *both[2];
    eyes(r, both);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_visible_eyes(state(r), scene(r), both[0], both[1], to, given, ptr(r, count, 1)));
    if (!counted(r, ok, all, 1, room, count)) return;
    for (size_t i = 0; i < *count; i++) if (!all[i] || all[i] > 3) fail(r, "an eye that is none");
}

static void do_visible_draws(run *r) {
    cullet_draws *draws = in(r, sizeof *draws);
    size_t rooms[3] = {0, 0, 0}, place_count = below(r, 4);
    memset(draws, 0, sizeof *draws);
    if (!one_in(r, 4)) rooms[0] = capacity(r, 2000), rooms[1] = capacity(r, 2000), rooms[2] = capacity(r, 20000);
    cullet_draw_command *commands = out(r, rooms[0] * sizeof *commands);
    cullet_draw_key *keys = out(r, rooms[0] * sizeof *keys);
    uint32_t *all = out(r, rooms[1] * 4), *indices = out(r, rooms[2] * 4);
    cullet_mesh_place *places = filled(r, place_count * sizeof *places, 4, 0, 9);
    draws->commands = ptr(r, commands, rooms[0]);
    draws->keys = ptr(r, keys, rooms[0]);
    draws->instances = ptr(r, all, rooms[1]);
    draws->indices = ptr(r, indices, rooms[2]);
    draws->command_capacity = or_huge(r, rooms[0]);
    draws->instance_capacity = or_huge(r, rooms[1]);
    draws->index_capacity = or_huge(r, rooms[2]);
    places = ptr(r, places, place_count);
    if (!done(r, cullet_visible_draws(state(r), scene(r), places, place_count, ptr(r, draws, 1)))) return;
    int has_room = rooms[0] + rooms[1] + rooms[2] > 0;
    written(r, commands, has_room ? draws->command_count * sizeof *commands : 0);
    written(r, keys, has_room ? draws->command_count * sizeof *keys : 0);
    written(r, all, has_room ? draws->instance_count * 4 : 0);
    written(r, indices, has_room ? draws->index_count * 4 : 0);
    for (size_t i = 0; i < draws->command_count && has_room; i++) {
        size_t end = (size_t)commands[i].first_instance + commands[i].instance_count;
        if (end > draws->instance_count) fail(r, "a draw has instances that are not there");
    }
}

static void do_lines_of_sight(run *r) {
    size_t count = below(r, 20);
    cullet_segment *lines = filled(r, count * sizeof *lines, 8, -25, 25);
    cullet_sight *results = out(r, count * sizeof *results), *to = ptr(r, results, count);
    cullet_sight_options *options = in(r, sizeof *options);
    cullet_sight_options given = {below(r, 4), below(r, 2), below(r, 2), below(r, 3), {handle(r), handle(r)}};
    int is_null = one_in(r, 3);
    uint32_t *odd[] = {&given.both_sides, &given.any, &given.ignored_count};
    if (!is_null) odd[0] = odd[below(r, 3)], *odd[0] = or_wrong(r, *odd[0], 3);
    *options = given;
    const cullet_segment *from = ptr(r, lines, count);
    size_t asked = or_huge(r, count);
    if (!done(r, cullet_lines_of_sight(scene(r), from, asked, is_null ? NULL : crooked(r, options), to))) return;
    for (size_t i = 0; i < count; i++) {
        if (results[i].blocked > 1 || results[i].reserved) fail(r, "an answer that is none");
        if (!(results[i].share >= 0 && results[i].share <= 1)) fail(r, "a share that is not from 0 to 1");
        int has_blocker = results[i].slot || results[i].triangle || results[i].share != 0;
        if (has_blocker && !results[i].blocked) fail(r, "a blocker that is none");
    }
}

static void do_box_to_box(run *r) {
    size_t count = below(r, 12);
    const cullet_box *from = ptr(r, some_boxes(r, 1, 1), 1), *to = ptr(r, some_boxes(r, count, 1), count);
    cullet_box_sight_options *options = in(r, sizeof *options);
    int is_null = one_in(r, 3);
    options->ignored_layers = below(r, 4);
    options->splits = is_null ? 0 : or_wrong(r, below(r, 4), 17);
    options->reserved = is_null ? 0 : or_wrong(r, 0, 1);
    uint8_t *results = out(r, count);
    const void *how = is_null ? NULL : crooked(r, options);
    size_t asked = or_huge(r, count);
    if (done(r, cullet_box_to_box(scene(r), from, to, asked, how, bytes_ptr(r, results, count)))) answers(r, results, count, 2);
}

static void do_scene_cell_of(run *r) {
    double *point = filled(r, 24, 8, -20, 20);
    uint32_t *cell = out(r, sizeof *cell);
    done(r, cullet_scene_cell_of(scene(r), ptr(r, point, 1), ptr(r, cell, 1)));
}

static void do_region_create(run *r) {
    cullet_region *made = out(r, sizeof *made);
    if (done(r, cullet_region_create(ptr(r, made, 1)))) keep(r, REGION, made->id);
}

static void do_region_destroy(run *r) { destroy_one(r, REGION); }

static void do_region_cull(run *r) {
    cullet_eye_box *box = in(r, sizeof *box);
    cullet_region_settings *how = in(r, sizeof *how);
    for (int i = 0; i < 3; i++) {
        box->min[i] = number(r, -9, 9);
        box->max[i] = one_in(r, 20) ? number(r, -9, 9) : box->min[i] + number(r, 0, 2);
    }
    memset(how, 0, sizeof *how);
    how->cell_world = one_in(r, 2) ? 0 : number(r, -0.1, 4);
    how->near_world = one_in(r, 2) ? 0 : number(r, -0.1, 1);
    how->most_cells = 1 + below(r, 4);
    how->width = or_wrong(r, 8 + below(r, 60), one_in(r, 2) ? 7 : 4097);
    how->most_bodies = one_in(r, 2) ? 0 : 1 + below(r, 50);
    how->ignored_layers = below(r, 4);
    how->reserved = or_wrong(r, 0, 1);
    const cullet_view *all = one_in(r, 2) ? NULL : crooked(r, any_view(r));
    const cullet_region_settings *how_at = crooked(r, how); /* never NULL: the default takes long */
    done(r, cullet_region_cull(scene(r), ptr(r, box, 1), all, how_at, region(r)));
}

static void do_region_slots(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r);
    uint32_t *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_region_slots(region(r), to, given, ptr(r, count, 1)));
    if (counted(r, ok, all, sizeof *all, room, count)) slots(r, all, *count);
}

static void do_cull_shadow(run *r) {
    cullet_shadow *s = in(r, sizeof *s);
    memset(s, 0, sizeof *s);
    s->light = light(r);
    s->map = one_in(r, 3) ? crooked(r, any_view(r)) : NULL;
    int before = r->wrong;
    s->receivers.id = one_in(r, 2) ? pick(r, STATE) : 0;
    if (!s->receivers.id) r->wrong = before; /* 0 is none here */
    s->margin = one_in(r, 3) ? number(r, -0.2, 3) : 0;
    bad(r, !(s->margin >= 0));
    if (one_in(r, 3)) s->slice_near = number(r, 0, 9), s->slice_far = number(r, 0, 40);
    done(r, cullet_cull_shadow(scene(r), view(r), ptr(r, s, 1), settings(r), state(r)));
}

static void do_cull_lights(run *r) {
    size_t count = below(r, 9);
    cullet_light *all = in(r, count * sizeof *all);
    for (size_t i = 0; i < count; i++) all[i] = light(r);
    uint8_t *reasons = out(r, count), *to = bytes_ptr(r, reasons, count);
    const cullet_light *from = ptr(r, all, count);
    size_t given = or_huge(r, count);
    if (done(r, cullet_cull_lights(scene(r), state(r), from, given, to))) answers(r, reasons, count, 4);
}

/* Names. */

static void name(run *r, const char *text) {
    if (!text || !is_utf8(text) || strlen(text) > 1 << 16) fail(r, "a name that is none");
    atomic_fetch_add(&named(r->op)->succeeded, 1);
}

static void do_stage_name(run *r) { name(r, cullet_stage_name(below(r, 2) ? below(r, 12) : (uint32_t)next(r))); }
static void do_unit_name(run *r) { name(r, cullet_unit_name(below(r, 2) ? below(r, 4) : (uint32_t)next(r))); }
static void do_status_name(run *r) { name(r, cullet_status_name(below(r, 2) ? (int32_t)below(r, 20) - 2 : (int32_t)next(r))); }
static void do_last_error(run *r) { name(r, cullet_last_error()); }

static own_memory own;

/* Always too late: see main. */
static void do_set_allocator(run *r) {
    cullet_allocator *a = in(r, sizeof *a);
    *a = own_functions(&own);
    bad(r, 1);
    if (one_in(r, 4)) a->alloc = NULL;
    if (one_in(r, 4)) a->free = NULL;
    done(r, cullet_set_allocator(ptr(r, a, 1)));
}

static void do_version(run *r) { name(r, cullet_version()); }

#define CALL(name) {"cullet_" #name, do_##name, 0, 0}
static operation operations[] = {
    CALL(boxes_create), CALL(boxes_destroy), CALL(boxes_set), CALL(boxes_update), CALL(boxes_cull),
    CALL(boxes_cull_bits), CALL(boxes_set_occluders), CALL(boxes_set_occluder), CALL(boxes_move_occluder),
    CALL(clip_begin), CALL(clip_draw), CALL(clip_test_rect), CALL(clip_test_triangles), CALL(state_create),
    CALL(state_destroy), CALL(cull), CALL(cull_among), CALL(cull_stereo), CALL(visible_eyes), CALL(cull_on),
    CALL(explain), CALL(open), CALL(scene_add_mesh), CALL(scene_mesh_info), CALL(scene_mesh_read),
    CALL(occlusion_create), CALL(occlusion_destroy), CALL(occlusion_begin), CALL(occlusion_draw_boxes),
    CALL(occlusion_draw_triangles), CALL(occlusion_test_boxes), CALL(occlusion_read), CALL(lines_of_sight),
    CALL(box_to_box), CALL(scene_cell_of), CALL(region_create), CALL(region_destroy), CALL(region_cull),
    CALL(region_slots), CALL(visible_slots), CALL(visible_handles), CALL(visible_users), CALL(visible_reasons),
    CALL(visible_funnel), CALL(visible_draws), CALL(stage_name), CALL(unit_name), CALL(scene_create),
    CALL(scene_destroy), CALL(scene_add), CALL(scene_remove), CALL(scene_set_transforms),
    CALL(scene_set_layers), CALL(scene_set_flags), CALL(scene_set_bounds), CALL(scene_commit),
    CALL(scene_refit), CALL(scene_get_info), CALL(scene_slot), CALL(scene_instance), CALL(settings_preset),
    CALL(cull_shadow), CALL(cull_lights), CALL(last_error), CALL(status_name), CALL(version),
    CALL(view_from_matrix), CALL(view_from_camera), CALL(view_look_at), CALL(scene_add_lod),
    CALL(scene_clear_levels), CALL(scene_levels), CALL(scene_take_occluders), CALL(visible_lod), CALL(set_allocator),
#ifdef BAKES
    CALL(pvs_open), CALL(pvs_read), CALL(pvs_write), CALL(pvs_destroy), CALL(pvs_get_info), CALL(pvs_cells),
    CALL(pvs_missing), CALL(pvs_cell_of), CALL(pvs_visible), CALL(scene_set_pvs), CALL(bake_levels),
    CALL(bake_occluders), CALL(bake_cells), CALL(bake_pvs), CALL(scene_save),
#endif
};
enum { OPERATIONS = sizeof operations / sizeof *operations };

static operation *named(int op) { return &operations[op]; }

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + (double)time.tv_nsec * 1e-9;
}

static int is_name(const char *function) {
    return strstr(function, "_name") || !strcmp(function, "cullet_version") || !strcmp(function, "cullet_last_error");
}

/* Objects are made and destroyed less often than used, so that much happens to each; bakes and files take long. */
static int is_seldom(const char *function) {
    static const char *const parts[] = {"_create", "_destroy", "_bake_", "_save"};
    int is = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) is |= strstr(function, parts[i]) != NULL;
    return is;
}

static double ends;

static void *work(void *of) {
    run *r = of;
    /* Steps enough for every function to succeed, however slow the machine. */
    for (long least = r->step + 10000; r->step < least || now() < ends; r->step++) {
        do r->op = (int)below(r, OPERATIONS);
        while (is_seldom(named(r->op)->name) && !one_in(r, 8));
        r->wrong = r->page = r->out_count = 0;
        r->place = (int)below(r, OBJECTS);
        r->wild = one_in(r, 4) ? one_in(r, 2) ? 4 : 40 : 0;
        operations[r->op].call(r);
    }
    return NULL;
}

int main(int argc, char **argv) {
    static run runs[2];
    double seconds = argc > 1 ? atof(argv[1]) : 5, begun = now();
    pthread_t threads[2];
    long calls = 0;
    int missed = 0;
    size_t size = (size_t)sysconf(_SC_PAGESIZE);
    first_seed = argc > 2 ? strtoull(argv[2], NULL, 0) : 1;
    printf("seed %llu\n", (unsigned long long)first_seed);
    fflush(stdout);
    if (first_seed % 2) {
        const cullet_allocator functions = own_functions(&own);
        if (cullet_set_allocator(&functions) != CULLET_STATUS_OK) return puts(cullet_last_error()), 1;
    }
    alarm((unsigned)seconds + 600); /* a call that does not return ends the program */
    for (int i = 0; i < 2; i++) {
        runs[i].random = (first_seed + 1) * UINT64_C(0x9e3779b97f4a7c15) + 2 * (uint64_t)i + 1;
        runs[i].thread = i;
        for (int p = 0; p < PAGES; p++) {
            unsigned char *at = mmap(NULL, PAGE + size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
            if (at == MAP_FAILED || mprotect(at + PAGE, size, PROT_NONE)) return perror("mmap"), 1;
            runs[i].pages[p] = at;
        }
    }
    ends = begun + seconds / 2;
    work(&runs[0]);
    ends = begun + seconds;
    for (int i = 0; i < 2; i++) {
        runs[i].together = 1;
        if (pthread_create(&threads[i], NULL, work, &runs[i])) return perror("pthread_create"), 1;
    }
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    for (int kind = 0; kind < KINDS; kind++) {
        for (int i = 0; i < OBJECTS; i++) {
            if (replace(kind, i, 0) != CULLET_STATUS_OK) fail(&runs[0], "an object is not destroyed");
        }
    }
    for (int i = 0; i < OPERATIONS; i++) {
        long well = atomic_load(&operations[i].succeeded), badly = atomic_load(&operations[i].failed);
        /* Names never fail; what fails seldom, such as making an object, may not have in few calls. */
        int is_missed = !well || (!badly && well > 400 && !is_name(operations[i].name));
        if (operations[i].call == do_set_allocator) is_missed = !badly;
        if (argc > 3 || is_missed) printf("%-32s %8ld succeeded %8ld failed\n", operations[i].name, well, badly);
        missed += is_missed;
        calls += well + badly;
    }
    /* Tables of handles, and a message for the main thread. */
    if (own.blocks > 60) fail(&runs[0], "memory is not given back");
    printf("%ld calls in %.0f seconds: nothing found\n", calls, now() - begun);
    if (first_seed % 2) printf("%zu allocations, %zu blocks left\n", own.calls, own.blocks);
    if (missed) fprintf(stderr, "%d functions never succeeded, or never failed\n", missed);
    return missed > 0;
}
