/* Calls of levels of detail. */
#ifndef CULLET_TESTS_RANDOM_LEVELS_H
#define CULLET_TESTS_RANDOM_LEVELS_H

#include "scenes.h"

/* Adds a cube to a scene, unless that has many meshes; returns its number. */
static uint32_t cube(cullet_scene to) {
    cullet_mesh_arrays a = {0};
    cullet_mesh_info info;
    uint32_t made = 0;
    a.positions = CORNERS, a.position_count = 8;
    a.indices = FACES, a.index_count = 36;
    if (cullet_scene_mesh_info(to, 30, &info) == CULLET_STATUS_OK) return 0;
    return cullet_scene_add_mesh(to, &a, &made) == CULLET_STATUS_OK ? made : 0;
}

static void do_scene_add_lod(run *r) {
    cullet_scene of = scene(r);
    int is_fit = one_in(r, 3);
    uint32_t fine = is_fit ? cube(of) : mesh(r), coarse = is_fit ? cube(of) : mesh(r);
    float error = one_in(r, 30) ? (float)finite_of(r, number(r, 0, 2)) : (float)below(r, 9);
    bad(r, !(error >= 0) || isinf(error) || fine == coarse);
    done(r, cullet_scene_add_lod(of, fine, coarse, error));
}

static void do_scene_clear_levels(run *r) { done(r, cullet_scene_clear_levels(scene(r), mesh(r))); }

static void do_scene_levels(run *r) {
    size_t room = capacity(r, 16), *count = out_count(r);
    cullet_levels *all = out(r, room * sizeof *all), *to = ptr(r, all, room);
    size_t given = or_huge(r, room);
    if (!done(r, cullet_scene_levels(scene(r), mesh(r), to, given, ptr(r, count, 1)))) return;
    written(r, all, room ? *count * sizeof *all : 0);
    for (size_t i = 0; room && i < *count; i++) {
        if (!(all[i].least_error >= 0 && all[i].most_error >= all[i].least_error)) fail(r, "errors that are none");
    }
}

static void do_scene_take_occluders(run *r) {
    uint32_t *given = out(r, sizeof *given);
    done(r, cullet_scene_take_occluders(scene(r), or_wrong(r, below(r, 2), 2), one_in(r, 3) ? NULL : crooked(r, given)));
}

static void do_visible_lod(run *r) {
    double *pixels = out(r, sizeof *pixels);
    if (done(r, cullet_visible_lod(state(r), ptr(r, pixels, 1))) && !(*pixels >= 0)) fail(r, "no number of pixels");
}

#endif
