/* Calls of scenes and of their culls. */
#ifndef CULLET_TESTS_RANDOM_SCENES_H
#define CULLET_TESTS_RANDOM_SCENES_H

#include "boxes.h"

static void do_scene_create(run *r) {
    cullet_scene *made = out(r, sizeof *made);
    if (done(r, cullet_scene_create(ptr(r, made, 1)))) keep(r, SCENE, made->id);
}

static void do_scene_destroy(run *r) { destroy_one(r, SCENE); }

/* A text of a model, with bytes changed now and then. */
static void do_open(run *r) {
    static const char *const texts[] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n",
        "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
        "{\n\"classname\" \"worldspawn\"\n{\n"
        "( 0 0 0 ) ( 0 1 0 ) ( 0 0 1 ) a 0 0 0 1 1\n( 9 9 9 ) ( 9 9 10 ) ( 9 10 9 ) a 0 0 0 1 1\n"
        "( 0 0 0 ) ( 0 0 1 ) ( 1 0 0 ) a 0 0 0 1 1\n( 9 9 9 ) ( 10 9 9 ) ( 9 9 10 ) a 0 0 0 1 1\n"
        "( 0 0 0 ) ( 1 0 0 ) ( 0 1 0 ) a 0 0 0 1 1\n( 9 9 9 ) ( 9 10 9 ) ( 10 9 9 ) a 0 0 0 1 1\n}\n}\n"};
    static const char *const ends[] = {"obj", "off", "ply", "stl", "map"};
    uint32_t kind = below(r, 5);
    size_t length = strlen(texts[kind]);
    char name[64], text[1024];
    cullet_scene *made = out(r, sizeof *made);
    memcpy(text, texts[kind], length);
    for (int i = one_in(r, 2) ? 0 : 1 + (int)below(r, 4); i > 0; i--) text[below(r, (uint32_t)length)] = (char)below(r, 256);
    snprintf(name, sizeof name, "random_%ld_%d.%s", (long)getpid(), r->thread, ends[kind]);
    FILE *file = fopen(name, "wb");
    if (!file || fwrite(text, 1, length, file) != length || fclose(file)) fail(r, "a file could not be written");
    if (one_in(r, 20) && bad(r, 1)) name[0] = '\xff';
    if (done(r, cullet_open(bytes_ptr(r, name, 1), ptr(r, made, 1)))) keep(r, SCENE, made->id);
    name[0] = 'r';
    remove(name);
}

static void do_scene_add_mesh(run *r) {
    cullet_mesh_arrays *a = in(r, sizeof *a);
    memset(a, 0, sizeof *a);
    uint32_t *mesh = out(r, sizeof *mesh), faces = 0;
    triangles t = soup(r, 12);
    a->position_count = t.positions;
    a->positions = ptr(r, t.position, t.positions);
    a->indices = ptr(r, t.index, t.indices);
    a->part_count = t.indices > 2 && one_in(r, 2) ? 1 + below(r, 3) : 0;
    cullet_part *parts = in(r, a->part_count * sizeof *parts);
    for (size_t i = 0; i < a->part_count; i++) {
        uint32_t count = i + 1 < a->part_count ? below(r, 3) : (uint32_t)(t.indices / 3) - faces;
        if (faces + count > t.indices / 3) count = 0;
        cullet_part part = {faces, or_wrong(r, count, count + 1), below(r, 5), or_wrong(r, below(r, 2) + 4 * below(r, 2), 16)};
        parts[i] = part;
        faces += count;
    }
    bad(r, a->part_count && faces != t.indices / 3);
    a->parts = ptr(r, parts, a->part_count);
    a->flags = or_wrong(r, a->part_count ? 2 * below(r, 2) : below(r, 8), 12);
    a->material = below(r, 5);
    a->index_count = or_huge(r, t.indices);
    done(r, cullet_scene_add_mesh(scene(r), ptr(r, a, 1), ptr(r, mesh, 1)));
}

static uint32_t mesh(run *r) { return one_in(r, 30) ? (uint32_t)next(r) : below(r, 3); }

static void do_scene_mesh_info(run *r) {
    cullet_mesh_info *info = out(r, sizeof *info);
    if (done(r, cullet_scene_mesh_info(scene(r), mesh(r), ptr(r, info, 1))) && info->index_count % 3) fail(r, "no triangles");
}

static void do_scene_mesh_read(run *r) {
    cullet_mesh_info info;
    cullet_scene of = scene(r);
    uint32_t number = mesh(r);
    int is_known = cullet_scene_mesh_info(of, number, &info) == CULLET_STATUS_OK;
    size_t points = is_known ? 3 * info.position_count : 9, count = is_known ? info.index_count : 9;
    if (one_in(r, 4)) points = below(r, 99);
    if (one_in(r, 4)) count = below(r, 99);
    if (points * 4 > PAGE - FRONT || count * 4 > PAGE - FRONT) return;
    float *positions = out(r, points * 4);
    uint32_t *indices = out(r, count * 4);
    float *to = ptr(r, positions, points);
    size_t given = or_huge(r, count);
    if (!done(r, cullet_scene_mesh_read(of, number, to, points, ptr(r, indices, count), given)) || !is_known) return;
    written(r, positions, points ? 12 * info.position_count : 0);
    written(r, indices, count ? 4 * info.index_count : 0);
}

static void do_scene_add(run *r) {
    size_t count = below(r, 12);
    cullet_instance *all = in(r, count * sizeof *all);
    cullet_handle *made = out(r, count * sizeof *made);
    int is_null = one_in(r, 4);
    for (size_t i = 0; i < count; i++) {
        all[i].transform = transform(r);
        all[i].mesh = one_in(r, 99) ? 99 : below(r, 2);
        all[i].layers = below(r, 4);
        all[i].flags = or_wrong(r, below(r, 32), 32);
        all[i].reserved = or_wrong(r, 0, 1);
        all[i].user = next(r);
    }
    const cullet_instance *from = ptr(r, all, count);
    size_t given = or_huge(r, count);
    if (!done(r, cullet_scene_add(scene(r), from, given, is_null || !count ? NULL : crooked(r, made))) || is_null) return;
    for (size_t i = 0; i < count; i++) {
        atomic_store(&instances[below(r, IDS)], made[i].index | (uint64_t)made[i].generation << 32);
    }
}

static void do_scene_remove(run *r) {
    size_t count = below(r, 3);
    cullet_handle *all = ptr(r, handles(r, count), count);
    done(r, cullet_scene_remove(scene(r), all, or_huge(r, count)));
}

static void do_scene_set_transforms(run *r) {
    size_t count = below(r, 4);
    cullet_transform *to = in(r, count * sizeof *to);
    for (size_t i = 0; i < count; i++) to[i] = transform(r);
    cullet_handle *all = ptr(r, handles(r, count), count);
    done(r, cullet_scene_set_transforms(scene(r), all, ptr(r, to, count), or_huge(r, count)));
}

static void do_scene_set_layers(run *r) {
    size_t count = below(r, 4);
    uint32_t *to = in(r, count * sizeof *to);
    for (size_t i = 0; i < count; i++) to[i] = (uint32_t)next(r);
    cullet_handle *all = ptr(r, handles(r, count), count);
    done(r, cullet_scene_set_layers(scene(r), all, ptr(r, to, count), or_huge(r, count)));
}

static void do_scene_set_flags(run *r) {
    size_t count = below(r, 4);
    uint32_t *to = in(r, count * sizeof *to);
    for (size_t i = 0; i < count; i++) to[i] = or_wrong(r, below(r, 32), 32);
    cullet_handle *all = ptr(r, handles(r, count), count);
    done(r, cullet_scene_set_flags(scene(r), all, ptr(r, to, count), or_huge(r, count)));
}

static void do_scene_set_bounds(run *r) {
    uint32_t kind = or_wrong(r, below(r, 4), 4);
    size_t count = kind == CULLET_BOUNDS_WORLD ? 6 : kind == CULLET_BOUNDS_MARGIN;
    float *numbers = filled(r, count * 4, 4, kind == CULLET_BOUNDS_MARGIN ? -1 : -40, 20);
    bad(r, kind == CULLET_BOUNDS_MARGIN && !(numbers[0] >= 0));
    done(r, cullet_scene_set_bounds(scene(r), handle(r), kind, ptr(r, numbers, count)));
}

static void do_scene_commit(run *r) { done(r, cullet_scene_commit(scene(r))); }
static void do_scene_refit(run *r) { done(r, cullet_scene_refit(scene(r))); }

static void do_scene_get_info(run *r) {
    cullet_scene_info *info = out(r, sizeof *info);
    if (!done(r, cullet_scene_get_info(scene(r), ptr(r, info, 1)))) return;
    if (info->instance_count > info->slot_count || info->reserved) fail(r, "more instances than slots");
}

static void do_scene_slot(run *r) {
    uint32_t *slot = out(r, sizeof *slot);
    done(r, cullet_scene_slot(scene(r), handle(r), ptr(r, slot, 1)));
}

static void do_scene_instance(run *r) {
    cullet_instance *instance = out(r, sizeof *instance);
    cullet_handle *named = out(r, sizeof *named);
    uint32_t slot = one_in(r, 20) ? (uint32_t)next(r) : below(r, 20);
    cullet_scene of = scene(r);
    int is_null = one_in(r, 4);
    if (!done(r, cullet_scene_instance(of, slot, ptr(r, instance, 1), is_null ? NULL : crooked(r, named)))) return;
    if (instance->reserved || instance->flags >= 32) fail(r, "an instance with flags that are none");
    uint32_t back;
    if (is_null || r->together) return;
    if (cullet_scene_slot(of, *named, &back) != CULLET_STATUS_OK || back != slot) fail(r, "a handle names another slot");
}

static void do_settings_preset(run *r) {
    cullet_settings *made = out(r, sizeof *made);
    if (done(r, cullet_settings_preset(or_wrong(r, below(r, 3), 3), ptr(r, made, 1))) && made->size != sizeof *made) {
        fail(r, "settings were not filled");
    }
}

static void do_state_create(run *r) {
    cullet_state *made = out(r, sizeof *made);
    if (done(r, cullet_state_create(ptr(r, made, 1)))) keep(r, STATE, made->id);
}

static void do_state_destroy(run *r) { destroy_one(r, STATE); }
static void do_cull(run *r) { done(r, cullet_cull(scene(r), view(r), settings(r), state(r))); }

static void do_cull_among(run *r) {
    cullet_scene of = scene(r);
    cullet_scene_info info;
    size_t count = below(r, 5);
    if (!one_in(r, 4) && cullet_scene_get_info(of, &info) == CULLET_STATUS_OK && info.slot_count < 4096) {
        count = (info.slot_count + 63) / 64;
    }
    uint64_t *words = in(r, count * 8);
    for (size_t i = 0; i < count; i++) words[i] = next(r) * next(r);
    const uint64_t *from = ptr(r, words, count);
    size_t given = or_huge(r, count);
    done(r, cullet_cull_among(of, view(r), settings(r), from, given, state(r)));
}

/* Both eyes of a headset, or two views that are not. */
static void eyes(run *r, const cullet_view *both[2]) {
    cullet_camera from = camera(r), other = from;
    if (from.fov_y <= 0) from.fov_y = other.fov_y = 1;
    other.eye[0] += 0.06;
    cullet_view *left = view_of(r, &from), *right;
    if (one_in(r, 8)) {
        right = any_view(r);
    } else {
        right = in(r, sizeof *right);
        memset(right, 0, sizeof *right);
        bad(r, cullet_view_from_camera(&other, left->depth, left->width, left->height, right) != CULLET_STATUS_OK);
        right->layers = left->layers;
    }
    both[0] = ptr(r, left, 1);
    both[1] = ptr(r, right, 1);
}

static void do_cull_stereo(run *r) {
    const cullet_view *both[2];
    eyes(r, both);
    done(r, cullet_cull_stereo(scene(r), both[0], both[1], settings(r), state(r)));
}

/* A pool that runs its jobs in any order, some twice, some not at all, some on another thread. */
typedef struct {
    void (*job)(void *, size_t);
    void *jobs;
    size_t count, first;
} share;

static void *every_second(void *of) {
    share *s = of;
    for (size_t i = s->first; i < s->count; i += 2) s->job(s->jobs, i);
    return NULL;
}

static void run_jobs(void *context, void (*job)(void *, size_t), void *jobs, size_t count) {
    uint32_t how = *(uint32_t *)context;
    share even = {job, jobs, count, 0}, odd = {job, jobs, count, 1};
    pthread_t thread;
    int has_thread = how & 1 && pthread_create(&thread, NULL, every_second, &odd) == 0;
    if (how & 2) every_second(&even);
    if (how & 4) for (size_t i = count; i-- > 0;) job(jobs, i);
    if (has_thread) pthread_join(thread, NULL);
}

static void do_cull_on(run *r) {
    cullet_jobs *jobs = in(r, sizeof *jobs);
    uint32_t how = below(r, 8);
    memset(jobs, 0, sizeof *jobs);
    jobs->threads = or_wrong(r, one_in(r, 20) ? UINT32_MAX : 1 + below(r, 8), 0);
    jobs->reserved = or_wrong(r, 0, 1);
    jobs->run = one_in(r, 60) && bad(r, 1) ? NULL : run_jobs;
    jobs->context = &how;
    done(r, cullet_cull_on(ptr(r, jobs, 1), scene(r), view(r), settings(r), state(r)));
}

static void do_explain(run *r) {
    cullet_reason *reason = out(r, sizeof *reason);
    size_t room = capacity(r, 2000), *length = out(r, sizeof *length);
    char *text = out(r, room);
    int has_reason = one_in(r, 2), has_length = one_in(r, 2);
    size_t given = or_huge(r, room);
    if (!done(r, cullet_explain(scene(r), view(r), settings(r), handle(r), has_reason ? reason : NULL,
                                bytes_ptr(r, text, room), given, has_length ? crooked(r, length) : NULL))) return;
    if (has_reason && reason->stage > CULLET_STAGE_DEGENERATE) fail(r, "a stage that is none");
    if (!room) return;
    if (!memchr(text, 0, room)) fail(r, "a text without an end");
    if (!is_utf8(text)) fail(r, "a text that is not UTF-8");
    if (has_length && *length <= strlen(text)) fail(r, "a length that is less than the text");
    written(r, text, strlen(text) + 1);
}

#endif
