/* Arguments that several calls take: right, or wrong in a way that the header refuses. */
#ifndef CULLET_TESTS_RANDOM_ARGUMENTS_H
#define CULLET_TESTS_RANDOM_ARGUMENTS_H

#include "machine.h"

static cullet_transform transform(run *r) {
    cullet_transform t = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    int is_plain = one_in(r, 2);
    for (int i = 0; i < 9 && !is_plain; i++) t.linear[i] = (float)number(r, -2, 2);
    for (int i = 0; i < 3; i++) t.translation[i] = number(r, -25, 25);
    return t;
}

static const cullet_transform *transform_at(run *r) {
    cullet_transform *t = in(r, sizeof *t);
    *t = transform(r);
    return optional(r, t);
}

static cullet_camera camera(run *r) {
    cullet_camera c = {{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1, 30, 0, 0.1, 100};
    for (int i = 0; i < 3; i++) c.eye[i] = number(r, -15, 15), c.direction[i] = number(r, -1, 1);
    c.fov_y = one_in(r, 3) ? 0 : number(r, 0.2, 2);
    c.far_plane = number(r, 20, 200);
    if (c.fov_y > 0 && one_in(r, 3)) c.far_plane = INFINITY;
    return c;
}

/* A view, or one that is refused. Nearly all are good. */
static cullet_view *view_of(run *r, const cullet_camera *from) {
    cullet_view *v = in(r, sizeof *v);
    memset(v, 0, sizeof *v);
    uint32_t width = 1 + below(r, 300), height = 1 + below(r, 300);
    bad(r, cullet_view_from_camera(from, below(r, 2), width, height, v) != CULLET_STATUS_OK);
    if (one_in(r, 8)) v->layers = below(r, 4), v->clockwise = below(r, 2), v->cull_face = below(r, 3);
    if (!one_in(r, 40)) return v;
    double *of_matrix = &v->clip_from_world[below(r, 16)];
    switch (below(r, 8)) {
    case 0: v->size += 1 + below(r, 9), bad(r, 1); break;
    case 1: v->depth = 2 + below(r, 9), bad(r, 1); break;
    case 2: v->width = one_in(r, 2) ? 0 : 65537, bad(r, 1); break;
    case 3: v->clockwise = 2 + below(r, 9), bad(r, 1); break;
    case 4: v->cull_face = 3 + below(r, 9), bad(r, 1); break;
    case 5: v->reserved = 1 + below(r, 9), bad(r, 1); break;
    case 6: *of_matrix = finite_of(r, one_in(r, 2) ? NAN : INFINITY); break;
    default: *of_matrix = number(r, -3, 3);
    }
    return v;
}

static cullet_view *any_view(run *r) {
    cullet_camera from = camera(r);
    return view_of(r, &from);
}

static const cullet_view *view(run *r) { return ptr(r, any_view(r), 1); }

static const cullet_settings *settings(run *r) {
    cullet_settings *s = in(r, sizeof *s);
    memset(s, 0, sizeof *s);
    if (one_in(r, 4)) return NULL;
    bad(r, cullet_settings_preset(below(r, 3), s) != CULLET_STATUS_OK);
    s->occlusion_width = one_in(r, 50) ? 4096 : 1 + below(r, 200);
    s->reasons = below(r, 2);
    s->output = below(r, 3);
    s->backfaces = below(r, 3);
    if (one_in(r, 4)) s->occlusion_risk = -1;
    if (one_in(r, 4)) s->detail_pixels = s->lod_pixels = (float)below(r, 9);
    if (one_in(r, 4)) s->lod_triangles = below(r, 5000);
    uint32_t *of[] = {&s->size, &s->frustum, &s->frustum_exact, &s->pvs, &s->portals, &s->backfaces, &s->degenerate,
                      &s->occlusion, &s->output, &s->reasons};
    uint32_t *one = of[below(r, sizeof of / sizeof *of)];
    *one = or_wrong(r, *one, 3 + below(r, 9));
    s->occlusion_width = or_wrong(r, s->occlusion_width, one_in(r, 2) ? 0 : 4097);
    if (one_in(r, 60)) s->detail_pixels = (float)finite_of(r, NAN);
    if (one_in(r, 60)) s->occlusion_budget = (float)finite_of(r, NAN);
    return crooked(r, s);
}

static const float CORNERS[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const uint32_t FACES[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                   3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};

/* Triangles: a body, or any. `stride` is at least 12. */
typedef struct {
    size_t positions, indices;
    float *position;
    uint32_t *index;
} triangles;

static triangles soup(run *r, size_t stride) {
    triangles t = {8, 36, NULL, NULL};
    int is_body = one_in(r, 2);
    if (!is_body) t.positions = below(r, 60), t.indices = t.positions ? 3 * below(r, 40) : 0;
    t.position = filled(r, t.positions ? (t.positions - 1) * stride + 12 : 0, 4, -3, 3);
    t.index = in(r, t.indices * 4);
    double size = number(r, 0.2, 6);
    for (size_t i = 0; i < 24 && is_body; i++) {
        t.position[i / 3 * stride / 4 + i % 3] = CORNERS[i] * (float)size;
    }
    for (size_t i = 0; i < t.indices; i++) t.index[i] = is_body ? FACES[i] : below(r, (uint32_t)t.positions);
    for (size_t i = 0; i < 3 * t.positions; i++) finite_of(r, t.position[i / 3 * stride / 4 + i % 3]);
    if (t.indices && one_in(r, 40) && bad(r, 1)) t.index[below(r, (uint32_t)t.indices)] = (uint32_t)t.positions + below(r, 2);
    if (t.indices && one_in(r, 60) && bad(r, 1)) t.indices--, t.index++;
    return t;
}

static cullet_light light(run *r) {
    cullet_light l;
    l.kind = or_wrong(r, below(r, 3), 3);
    l.reserved = or_wrong(r, 0, 1);
    l.range = number(r, 0, 60);
    l.half_angle = number(r, 0.1, 1.4);
    for (int i = 0; i < 3; i++) l.position[i] = number(r, -20, 20), l.direction[i] = number(r, -1, 1);
    return l;
}

#endif
