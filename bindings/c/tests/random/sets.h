/* Calls of visible sets and of bakes, with files: for libraries that are built with bakes. */
#ifndef CULLET_TESTS_RANDOM_SETS_H
#define CULLET_TESTS_RANDOM_SETS_H

#include "levels.h"

/* A thread's own: the bytes of the sets that it wrote last. */
static struct {
    uint8_t bytes[1 << 16];
    size_t size;
} written_sets[2];

static cullet_pvs sets(run *r) { return (cullet_pvs){pick(r, SETS)}; }

static char *file_name(run *r, const char *end) {
    char name[64];
    int length = snprintf(name, sizeof name, "random_%ld_%d.%s", (long)getpid(), r->thread, end);
    return memcpy(in(r, (size_t)length + 1), name, (size_t)length + 1);
}

/* Two rooms of a few boxes, closed more or less: little enough for a bake. */
static void small_scene(run *r) {
    static const double walls[8][6] = {{-9, -1, -5, 9, 0, 5},  {-9, 3, -5, 9, 4, 5},  {-9, -1, -5, -8, 4, 5},
                                       {8, -1, -5, 9, 4, 5},   {-9, -1, -5, 9, 4, -4}, {-9, -1, 4, 9, 4, 5},
                                       {-1, -1, -5, 1, 4, -1}, {-1, -1, 1, 1, 4, 5}};
    cullet_scene made;
    if (cullet_scene_create(&made) != CULLET_STATUS_OK) fail(r, "no scene is made");
    uint32_t block = cube(made), balls = below(r, 4);
    for (uint32_t i = 0; i < 8 + balls; i++) {
        cullet_instance one = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}, block, 1, 0, 0, i};
        for (int a = 0; a < 3; a++) {
            const double low = i < 8 ? walls[i][a] : (double)below(r, 5) - 3, high = i < 8 ? walls[i][a + 3] : low + 1;
            one.transform.linear[4 * a] = (float)(high - low) / 2;
            one.transform.translation[a] = (low + high) / 2;
        }
        if (!one_in(r, 30) && cullet_scene_add(made, &one, 1, NULL) != CULLET_STATUS_OK) fail(r, "no instance is added");
    }
    if (cullet_scene_commit(made) != CULLET_STATUS_OK) fail(r, "no scene is sorted");
    int place = r->place;
    if (replace(SCENE, place, made.id) != CULLET_STATUS_OK) fail(r, "an object could not be destroyed");
}

typedef struct {
    run *of;
    double share;
    int last;
} hearing;

static uint32_t heard_step(void *context, double share) {
    hearing *heard = context;
    if (!(share >= heard->share && share <= 1)) fail(heard->of, "progress that falls, or is no share");
    heard->share = share;
    return heard->last-- > 0;
}

/* Options of a bake; a few stop it. */
static const cullet_bake_options *bake_options(run *r, hearing *heard, int has_units) {
    cullet_bake_options *o = in(r, sizeof *o);
    memset(o, 0, sizeof *o);
    if (one_in(r, 4)) return NULL;
    heard->of = r, heard->share = 0, heard->last = one_in(r, 6) ? (int)below(r, 4) : 1 << 20;
    o->threads = or_wrong(r, below(r, 4), 1025);
    o->reserved = or_wrong(r, 0, 1);
    o->step = one_in(r, 3) ? NULL : heard_step;
    o->context = heard;
    if (one_in(r, 60) && bad(r, 1)) o->share = 1;
    if (one_in(r, 60) && bad(r, 1)) o->share_count = 2; /* without a folder */
    if (!has_units && one_in(r, 60) && bad(r, 1)) o->folder = file_name(r, "units");
    return crooked(r, o);
}

/* A scene for a bake, made now and then. */
static cullet_scene baked_scene(run *r) {
    if (one_in(r, 3)) small_scene(r);
    return scene(r);
}

static void do_bake_levels(run *r) {
    hearing heard;
    uint32_t *count = out(r, sizeof *count);
    const cullet_bake_options *how = bake_options(r, &heard, 1);
    done(r, cullet_bake_levels(baked_scene(r), how, one_in(r, 3) ? NULL : crooked(r, count)));
}

static void do_bake_occluders(run *r) {
    hearing heard;
    uint32_t *given = out(r, sizeof *given);
    const cullet_bake_options *how = bake_options(r, &heard, 1);
    uint32_t always = or_wrong(r, below(r, 2), 2);
    done(r, cullet_bake_occluders(baked_scene(r), always, how, one_in(r, 3) ? NULL : crooked(r, given)));
}

static void do_bake_cells(run *r) {
    hearing heard;
    uint32_t *count = out(r, sizeof *count);
    cullet_cells_settings *s = in(r, sizeof *s);
    const cullet_bake_options *how = bake_options(r, &heard, 0);
    memset(s, 0, sizeof *s);
    s->voxel = one_in(r, 20) ? number(r, -1, 9) : 0.2 + 0.1 * below(r, 4);
    bad(r, !(s->voxel >= 0) || isinf(s->voxel));
    s->ignored_count = below(r, 2);
    s->ignored = ptr(r, handles(r, s->ignored_count), s->ignored_count);
    const cullet_cells_settings *at = crooked(r, s); /* never NULL: the default may take long */
    done(r, cullet_bake_cells(baked_scene(r), at, how, one_in(r, 3) ? NULL : crooked(r, count)));
}

static void do_bake_pvs(run *r) {
    static const cullet_eye_box rooms = {{-8, 0, -4}, {8, 3, 4}};
    hearing heard;
    cullet_pvs *made = out(r, sizeof *made);
    cullet_pvs_settings *s = in(r, sizeof *s);
    cullet_eye_box *boxes = in(r, 2 * sizeof *boxes);
    const cullet_bake_options *how = bake_options(r, &heard, 1);
    int is_own = one_in(r, 4); /* sets of the scene's own cells, where it has some */
    memset(s, 0, sizeof *s);
    boxes[0] = boxes[1] = rooms;
    boxes[1].max[0] = -1;
    s->rays = 200 + below(r, 2000);
    s->seed = below(r, 3);
    s->box_count = is_own ? 0 : 1 + below(r, 2);
    s->boxes_are_cells = s->box_count && one_in(r, 2);
    if (s->box_count == 1 && !s->boxes_are_cells && one_in(r, 2)) s->grid[0] = s->grid[1] = s->grid[2] = 1 + below(r, 3);
    if (!s->boxes_are_cells && !s->grid[0] && !is_own) s->cells = 1 + below(r, 9);
    if (one_in(r, 3)) s->keep_angle = number(r, 0, 3), s->join = number(r, 0, 2), s->missing = number(r, -1, 1);
    bad(r, !(s->keep_angle >= 0 && s->keep_angle < 3.1416) || !(s->join >= 0) || isinf(s->join) || isnan(s->missing));
    if (s->box_count && one_in(r, 20)) boxes[0].min[0] = number(r, -9, 9);
    s->reserved = or_wrong(r, 0, 1);
    s->boxes_are_cells = or_wrong(r, s->boxes_are_cells, 2);
    s->boxes = ptr(r, boxes, s->box_count);
    const cullet_pvs_settings *at = crooked(r, s); /* never NULL: the default takes long */
    if (done(r, cullet_bake_pvs(baked_scene(r), at, how, ptr(r, made, 1)))) keep(r, SETS, made->id);
}

static void do_scene_save(run *r) {
    static const char *const ends[] = {"glb", "ply", "obj", "stl"};
    int is_wrong = one_in(r, 30) && bad(r, 1);
    char *name = file_name(r, is_wrong ? "xyz" : ends[below(r, 4)]), *original = NULL;
    if (one_in(r, 20) && bad(r, 1)) original = file_name(r, "none.glb");
    int ok = done(r, cullet_scene_save(scene(r), bytes_ptr(r, name, 1), original));
    cullet_scene back;
    /* What was saved can be opened, but for numbers that are too large. */
    if (ok && cullet_open(name, &back) == CULLET_STATUS_OK) {
        if (cullet_scene_destroy(back) != CULLET_STATUS_OK) fail(r, "a scene that was saved is not destroyed");
    }
    remove(name);
}

static void do_pvs_write(run *r) {
    size_t room = capacity(r, sizeof written_sets[0].bytes), *count = out_count(r);
    uint8_t *all = out(r, room), *to = bytes_ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_pvs_write(sets(r), to, given, ptr(r, count, 1)));
    if (!counted(r, ok, all, 1, room, count)) return;
    memcpy(written_sets[r->thread].bytes, all, *count);
    written_sets[r->thread].size = *count;
}

/* The bytes that were written last; or damaged ones, which are refused or the same. */
static uint8_t *bytes_of_sets(run *r, size_t *size, int *is_whole) {
    const size_t all = written_sets[r->thread].size;
    *size = all;
    if (one_in(r, 4)) *size = below(r, (uint32_t)all + 1);
    uint8_t *bytes = in(r, *size);
    memcpy(bytes, written_sets[r->thread].bytes, *size);
    for (int i = one_in(r, 2) && *size ? 1 + (int)below(r, 4) : 0; i > 0; i--) {
        bytes[below(r, (uint32_t)*size)] ^= (uint8_t)(1u << below(r, 8));
    }
    bad(r, *size < all || !all);
    *is_whole = *size == all && all && !memcmp(bytes, written_sets[r->thread].bytes, all);
    return bytes;
}

static void read_sets(run *r, int is_whole, cullet_status status, const cullet_pvs *made) {
    int was_wrong = r->wrong;
    if (done(r, status)) keep(r, SETS, made->id);
    else if (is_whole && !was_wrong) fail(r, "sets that were written are refused");
}

static void do_pvs_read(run *r) {
    cullet_pvs *made = out(r, sizeof *made);
    size_t size;
    int is_whole;
    uint8_t *bytes = bytes_of_sets(r, &size, &is_whole);
    const uint8_t *from = bytes_ptr(r, bytes, size);
    read_sets(r, is_whole, cullet_pvs_read(from, size, ptr(r, made, 1)), made);
}

static void do_pvs_open(run *r) {
    cullet_pvs *made = out(r, sizeof *made);
    size_t size;
    int is_whole, is_there = !one_in(r, 30);
    uint8_t *bytes = bytes_of_sets(r, &size, &is_whole);
    char *name = file_name(r, "cpvs");
    FILE *file = is_there ? fopen(name, "wb") : NULL;
    if (is_there && (!file || fwrite(bytes, 1, size, file) != size || fclose(file))) fail(r, "a file could not be written");
    bad(r, !is_there);
    read_sets(r, is_whole, cullet_pvs_open(bytes_ptr(r, name, 1), ptr(r, made, 1)), made);
    remove(name);
}

static void do_pvs_destroy(run *r) { destroy_one(r, SETS); }

static void do_pvs_get_info(run *r) {
    cullet_pvs_info *info = out(r, sizeof *info);
    if (!done(r, cullet_pvs_get_info(sets(r), ptr(r, info, 1)))) return;
    if (info->reserved || info->targets > CULLET_PVS_TARGETS_INSTANCES) fail(r, "sets of what is none");
    if (!(info->mean_missing >= 0 && info->mean_missing <= info->most_missing)) fail(r, "a share that is none");
}

static void do_pvs_cells(run *r) {
    size_t room = capacity(r, 2000), *count = out_count(r);
    cullet_eye_box *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_pvs_cells(sets(r), to, given, ptr(r, count, 1)));
    counted(r, ok, all, sizeof *all, room, count);
}

static void do_pvs_missing(run *r) {
    size_t room = capacity(r, 2000), *count = out_count(r);
    float *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    int ok = done(r, cullet_pvs_missing(sets(r), to, given, ptr(r, count, 1)));
    if (!counted(r, ok, all, sizeof *all, room, count)) return;
    for (size_t i = 0; i < *count; i++) if (!(all[i] >= 0 && all[i] <= 1)) fail(r, "a share that is none");
}

static void do_pvs_cell_of(run *r) {
    size_t count = below(r, 20);
    double *points = filled(r, count * 24, 8, -9, 9);
    uint32_t *cells = out(r, count * sizeof *cells), *to = ptr(r, cells, count);
    const double *from = ptr(r, points, count);
    size_t given = or_huge(r, count);
    done(r, cullet_pvs_cell_of(sets(r), from, given, to));
}

static void do_pvs_visible(run *r) {
    size_t room = capacity(r, 700), *count = out_count(r), cell_count = below(r, 4);
    uint32_t *cells = in(r, cell_count * sizeof *cells), *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    for (size_t i = 0; i < cell_count; i++) cells[i] = one_in(r, 20) ? (uint32_t)next(r) : below(r, 4);
    size_t given = or_huge(r, room);
    const uint32_t *from = ptr(r, cells, cell_count);
    int ok = done(r, cullet_pvs_visible(sets(r), from, cell_count, to, given, ptr(r, count, 1)));
    if (counted(r, ok, all, sizeof *all, room, count)) slots(r, all, *count);
}

static void do_scene_set_pvs(run *r) {
    int before = r->wrong;
    cullet_pvs of = {one_in(r, 5) ? 0 : pick(r, SETS)};
    if (!of.id) r->wrong = before; /* 0 is none here */
    done(r, cullet_scene_set_pvs(scene(r), of));
}

#endif
