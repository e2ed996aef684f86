/* Calls of boxes, of buffers and of views. */
#ifndef CULLET_TESTS_RANDOM_BOXES_H
#define CULLET_TESTS_RANDOM_BOXES_H

#include "arguments.h"

static void *boxes_at(run *r, size_t count, size_t stride, size_t size, double low) {
    return filled(r, count ? (count - 1) * stride + 3 * size : 0, size, low, 60);
}

static const cullet_box_arrays *box_arrays(run *r) {
    cullet_box_arrays *a = in(r, sizeof *a);
    memset(a, 0, sizeof *a);
    size_t size = one_in(r, 2) ? 4 : 8, second;
    a->count = one_in(r, 8) ? below(r, 2) : below(r, 200);
    a->stride = size * (3 + below(r, 3));
    a->second_stride = one_in(r, 2) ? 0 : size * (3 + below(r, 3));
    second = a->second_stride ? a->second_stride : a->stride;
    a->number = or_wrong(r, size == 8, 2);
    a->form = or_wrong(r, below(r, 2), 2);
    for (int i = 0; i < 3 && one_in(r, 2); i++) a->origin[i] = finite_of(r, number(r, -1e6, 1e6));
    a->first = ptr(r, boxes_at(r, a->count, a->stride, size, -60), a->count);
    a->second = ptr(r, boxes_at(r, a->count, second, size, 0), a->count);
    if (a->count && one_in(r, 60) && bad(r, 1)) a->stride = one_in(r, 2) ? a->stride + 1 : 2 * size;
    a->count = or_huge(r, a->count);
    return ptr(r, a, 1);
}

static cullet_occluder *occluder(run *r, cullet_occluder *o) {
    memset(o, 0, sizeof *o);
    o->kind = below(r, 4);
    o->index_size = one_in(r, 2) ? 2 : 4 * below(r, 2);
    o->stride = (o->kind == 0 ? 24 : 12) + 4 * below(r, 3);
    o->transform = transform_at(r);
    if (o->kind == CULLET_OCCLUDER_KIND_BOXES) {
        o->position_count = below(r, 5);
        float *all = filled(r, o->position_count ? (o->position_count - 1) * o->stride + 24 : 0, 4, -20, 20);
        for (size_t i = 0; i < o->position_count; i++) {
            float *box = all + i * o->stride / 4;
            for (int a = 3; a < 6; a++) box[a] = box[a - 3] + (float)number(r, 0, 9);
            for (int a = 0; a < 6; a++) finite_of(r, box[a]);
        }
        o->positions = ptr(r, all, o->position_count);
    } else {
        triangles t = soup(r, o->stride);
        uint16_t *narrow = in(r, t.indices * 2);
        for (size_t i = 0; i < t.indices; i++) narrow[i] = (uint16_t)t.index[i];
        o->position_count = t.positions;
        o->index_count = t.indices;
        o->positions = ptr(r, t.position, t.positions);
        o->indices = ptr(r, o->index_size == 2 ? (void *)narrow : t.index, t.indices);
        bad(r, t.indices == 0);
        o->index_size = or_wrong(r, o->index_size, 1);
        o->index_count = or_huge(r, o->index_count);
    }
    bad(r, o->position_count == 0);
    o->kind = or_wrong(r, o->kind, 4);
    if (one_in(r, 60) && bad(r, 1)) o->stride = 8;
    return o;
}

static void do_boxes_create(run *r) {
    cullet_boxes *made = out(r, sizeof *made);
    if (done(r, cullet_boxes_create(or_wrong(r, below(r, 100), 4097), ptr(r, made, 1)))) keep(r, BOXES, made->id);
}

static void do_boxes_destroy(run *r) { destroy_one(r, BOXES); }
static void do_boxes_set(run *r) { done(r, cullet_boxes_set(boxes(r), box_arrays(r))); }
static void do_boxes_update(run *r) {
    size_t first = one_in(r, 20) ? SIZE_MAX - below(r, 9) : below(r, 40);
    done(r, cullet_boxes_update(boxes(r), first, box_arrays(r)));
}

static size_t capacity(run *r, size_t most) { return one_in(r, 4) ? below(r, 4) : most; }

static void do_boxes_cull(run *r) {
    size_t room = capacity(r, 220), *visible = out(r, sizeof *visible), ones = 0, end = 0;
    uint8_t *flags = out(r, room);
    int has_count = one_in(r, 2);
    size_t given = or_huge(r, room), *count = has_count ? crooked(r, visible) : NULL;
    if (!done(r, cullet_boxes_cull(boxes(r), view(r), bytes_ptr(r, flags, room), given, count))) return;
    for (; end < room && flags[end] <= 1; end++) ones += flags[end];
    written(r, flags, end);
    if (has_count && *visible != ones) fail(r, "the count is not that of the flags");
}

static void do_boxes_cull_bits(run *r) {
    size_t room = capacity(r, 5), *visible = out(r, sizeof *visible), ones = 0;
    uint64_t *words = out(r, room * 8), unwritten = UINT64_C(0x0101010101010101) * MARK;
    int has_count = one_in(r, 2);
    size_t given = or_huge(r, room), *count = has_count ? crooked(r, visible) : NULL;
    if (!done(r, cullet_boxes_cull_bits(boxes(r), view(r), ptr(r, words, room), given, count))) return;
    for (size_t i = 0; i < room && words[i] != unwritten; i++) {
        for (uint64_t word = words[i]; word; word &= word - 1) ones++;
    }
    if (has_count && *visible != ones) fail(r, "the count is not that of the bits");
}

static void do_boxes_set_occluders(run *r) {
    size_t count = below(r, 4);
    cullet_occluder *all = in(r, count * sizeof *all);
    for (size_t i = 0; i < count; i++) occluder(r, &all[i]);
    size_t given = or_huge(r, count);
    done(r, cullet_boxes_set_occluders(boxes(r), ptr(r, all, count), given));
}

static void do_boxes_set_occluder(run *r) {
    cullet_occluder *one = occluder(r, in(r, sizeof *one));
    done(r, cullet_boxes_set_occluder(boxes(r), below(r, 3), ptr(r, one, 1)));
}

static void do_boxes_move_occluder(run *r) { done(r, cullet_boxes_move_occluder(boxes(r), below(r, 3), transform_at(r))); }

static void do_clip_begin(run *r) { done(r, cullet_clip_begin(buffer(r), (float)finite_of(r, number(r, -0.1, 1)))); }

static const cullet_clip_triangles *clip_triangles(run *r) {
    cullet_clip_triangles *c = in(r, sizeof *c);
    memset(c, 0, sizeof *c);
    size_t count = below(r, 60), vertices = 1 + below(r, 50);
    uint32_t *index = in(r, count * 12);
    c->stride = 12 + 4 * below(r, 3);
    c->offset_y = 4;
    c->offset_zw = c->stride - 4;
    c->vertices = ptr(r, filled(r, vertices * c->stride, 4, -4, 9), count);
    for (size_t i = 0; i < 3 * count; i++) index[i] = below(r, (uint32_t)vertices);
    c->indices = ptr(r, index, count);
    c->clip_from_model = optional(r, filled(r, 64, 4, -2, 2));
    c->cull_winding = or_wrong(r, below(r, 3), 3);
    c->reserved = or_wrong(r, 0, 1);
    size_t *odd[] = {&c->stride, &c->offset_y, &c->offset_zw};
    if (count && one_in(r, 60) && bad(r, 1)) *odd[below(r, 3)] += 1 + below(r, 3);
    c->triangle_count = or_huge(r, count);
    return ptr(r, c, 1);
}

static void found(run *r, const uint32_t *result) { if (*result > 2) fail(r, "an answer that is none"); }

static void do_clip_draw(run *r) {
    uint32_t *result = out(r, sizeof *result);
    int is_null = one_in(r, 3);
    uint32_t *to = is_null ? NULL : crooked(r, result);
    if (done(r, cullet_clip_draw(buffer(r), clip_triangles(r), to)) && !is_null) found(r, result);
}

static void do_clip_test_rect(run *r) {
    uint32_t *result = out(r, sizeof *result);
    float n[5];
    for (int i = 0; i < 5; i++) n[i] = (float)number(r, -1.5, i < 2 ? 1 : 3);
    if (done(r, cullet_clip_test_rect(buffer(r), n[0], n[1], n[2], n[3], n[4], ptr(r, result, 1)))) found(r, result);
}

static void do_clip_test_triangles(run *r) {
    uint32_t *result = out(r, sizeof *result);
    if (done(r, cullet_clip_test_triangles(buffer(r), clip_triangles(r), ptr(r, result, 1)))) found(r, result);
}

static void do_occlusion_create(run *r) {
    cullet_occlusion *made = out(r, sizeof *made);
    uint32_t width = or_wrong(r, 1 + below(r, 140), 4097), height = or_wrong(r, 1 + below(r, 140), 0);
    if (done(r, cullet_occlusion_create(width, height, ptr(r, made, 1)))) keep(r, BUFFER, made->id);
}

static void do_occlusion_destroy(run *r) { destroy_one(r, BUFFER); }

static void do_occlusion_begin(run *r) {
    double *origin = in(r, 24);
    int is_null = one_in(r, 2);
    for (int i = 0; i < 3; i++) origin[i] = number(r, -9, 9), bad(r, !is_null && !isfinite(origin[i]));
    done(r, cullet_occlusion_begin(buffer(r), view(r), is_null ? NULL : crooked(r, origin)));
}

/* Boxes, some of them empty where that is allowed. */
static cullet_box *some_boxes(run *r, size_t count, int may_be_wrong) {
    cullet_box *all = filled(r, count * sizeof *all, 4, -30, 30);
    for (size_t i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++) {
            float *low = &all[i].min[a], *high = &all[i].max[a];
            if (!one_in(r, 40)) *high = *low + (float)number(r, 0, 9);
            bad(r, !may_be_wrong && !(isfinite(*low) && isfinite(*high) && *low <= *high));
        }
    }
    return all;
}

static void do_occlusion_draw_boxes(run *r) {
    size_t count = below(r, 6);
    const cullet_box *all = ptr(r, some_boxes(r, count, 0), count);
    size_t given = or_huge(r, count);
    done(r, cullet_occlusion_draw_boxes(buffer(r), all, given, transform_at(r)));
}

static void do_occlusion_draw_triangles(run *r) {
    triangles t = soup(r, 12);
    const float *positions = ptr(r, t.position, t.positions);
    const uint32_t *indices = ptr(r, t.index, t.indices);
    size_t count = or_huge(r, t.indices);
    done(r, cullet_occlusion_draw_triangles(buffer(r), positions, t.positions, indices, count, or_wrong(r, below(r, 2), 2),
                                            transform_at(r)));
}

/* Answers, one byte each, up to `most`. */
static void answers(run *r, const uint8_t *all, size_t count, uint8_t most) {
    for (size_t i = 0; i < count; i++) if (all[i] > most) fail(r, "an answer that is none");
}

static void do_occlusion_test_boxes(run *r) {
    size_t count = below(r, 100);
    const cullet_box *all = ptr(r, some_boxes(r, count, 1), count);
    uint8_t *results = out(r, count), *to = bytes_ptr(r, results, count);
    size_t given = or_huge(r, count);
    if (done(r, cullet_occlusion_test_boxes(buffer(r), all, given, to))) answers(r, results, count, 2);
}

static void do_occlusion_read(run *r) {
    size_t room = capacity(r, 140 * 140);
    float *nearness = out(r, room * 4), unwritten;
    memset(&unwritten, MARK, sizeof unwritten);
    if (!done(r, cullet_occlusion_read(buffer(r), ptr(r, nearness, room), or_huge(r, room)))) return;
    for (size_t i = 0; i < room && nearness[i] != unwritten; i++) if (!(nearness[i] >= 0)) fail(r, "nearness is not from 0 on");
}

static void is_view(run *r, const cullet_view *made, int ok) {
    if (ok && (made->size != sizeof *made || made->reserved)) fail(r, "a view was not filled");
}

static void do_view_from_matrix(run *r) {
    cullet_view *made = out(r, sizeof *made);
    double *matrix = filled(r, 128, 8, -2, 2);
    cullet_view *other = any_view(r);
    r->wrong = 0; /* of that view, which is not handed in */
    if (!one_in(r, 4)) memcpy(matrix, other->clip_from_world, 128);
    for (int i = 0; i < 16; i++) finite_of(r, matrix[i]);
    uint32_t depth = or_wrong(r, below(r, 2), 2), width = or_wrong(r, 1 + below(r, 99), 0), height = or_wrong(r, 9, 65537);
    is_view(r, made, done(r, cullet_view_from_matrix(ptr(r, matrix, 1), depth, width, height, ptr(r, made, 1))));
}

static void do_view_from_camera(run *r) {
    cullet_view *made = out(r, sizeof *made);
    cullet_camera *from = in(r, sizeof *from);
    *from = camera(r);
    for (int i = 0; i < 3; i++) finite_of(r, from->eye[i]), finite_of(r, from->direction[i]);
    double *odd[] = {&from->fov_y, &from->aspect, &from->near_plane, &from->height, &from->far_plane, &from->up[0]};
    if (one_in(r, 20)) *odd[below(r, 6)] = number(r, -9, 9);
    if (one_in(r, 40)) *odd[below(r, 3)] = finite_of(r, NAN);
    uint32_t depth = or_wrong(r, below(r, 2), 2), width = or_wrong(r, 1 + below(r, 99), 0), height = or_wrong(r, 9, 65537);
    is_view(r, made, done(r, cullet_view_from_camera(ptr(r, from, 1), depth, width, height, ptr(r, made, 1))));
}

static void do_view_look_at(run *r) {
    cullet_view *made = out(r, sizeof *made);
    double *eye = filled(r, 24, 8, -20, 20), *target = filled(r, 24, 8, -20, 20);
    for (int i = 0; i < 3; i++) finite_of(r, eye[i]), finite_of(r, target[i]);
    double fov = finite_of(r, number(r, -0.1, 3)), near_plane = finite_of(r, number(r, -0.1, 3));
    bad(r, fov <= 0 || fov >= 3.1415926536 || near_plane <= 0);
    uint32_t width = or_wrong(r, 1 + below(r, 99), 0), height = or_wrong(r, 9, 65537);
    const double *from = ptr(r, eye, 1), *to = ptr(r, target, 1);
    is_view(r, made, done(r, cullet_view_look_at(from, to, fov, near_plane, width, height, ptr(r, made, 1))));
}

#endif
