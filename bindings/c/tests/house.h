/* A house of two rooms with a door between them, and things in it: what the tests of bakes and of sets look at. */
#ifndef CULLET_TESTS_HOUSE_H
#define CULLET_TESTS_HOUSE_H

#include <math.h>
#include "check.h"

enum { RINGS = 24, SIDES = 40, BLOCKS = 9, BALLS = 6, THINGS = BLOCKS + BALLS, VIEWS = 6 };

static const float CORNERS[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const uint32_t FACES[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                   3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};

/* Lowest and highest corner of each wall; the last three leave a door in the wall between the rooms. */
static const double WALLS[BLOCKS][6] = {
    {-9, -1, -5, 9, 0, 5},      {-9, 3, -5, 9, 4, 5},        {-9, -1, -5, -8, 4, 5},
    {8, -1, -5, 9, 4, 5},       {-9, -1, -5, 9, 4, -4},      {-9, -1, 4, 9, 4, 5},
    {-.5, -1, -4.5, .5, 4, -1}, {-.5, -1, 1, .5, 4, 4.5},    {-.5, 2.2, -1.5, .5, 4, 1.5}};

static cullet_instance placed(uint32_t mesh, const double at[3], const double half[3], uint64_t user) {
    cullet_instance one = {{{(float)half[0], 0, 0, 0, (float)half[1], 0, 0, 0, (float)half[2]}, {at[0], at[1], at[2]}},
                           mesh, 1, 0, 0, user};
    return one;
}

/* Mesh 0 is a block, mesh 1 a ball. Balls stand in each corner of a room. */
static cullet_scene house(void) {
    static float ball[3 * (RINGS + 1) * SIDES];
    static uint32_t around[6 * RINGS * SIDES];
    cullet_scene scene;
    cullet_mesh_arrays block = {CORNERS, 8, FACES, 36, NULL, 0, CULLET_ONE_SIDED, 0}, round = block;
    cullet_instance all[THINGS];
    uint32_t mesh;
    size_t corners = 0, indices = 0;
    for (int ring = 0; ring <= RINGS; ring++)
        for (int side = 0; side < SIDES; side++) {
            double up = 3.14159265358979 * ring / RINGS, turn = 6.28318530717959 * side / SIDES;
            /* Both poles are one point. */
            double wide = ring % RINGS == 0 ? 0 : sin(up);
            ball[corners++] = (float)(wide * cos(turn) + 0);
            ball[corners++] = (float)cos(up);
            ball[corners++] = (float)(wide * sin(turn) + 0);
        }
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t side = 0; side < SIDES; side++) {
            uint32_t a = ring * SIDES + side, b = ring * SIDES + (side + 1) % SIDES, c = a + SIDES, d = b + SIDES;
            const uint32_t two[6] = {a, b, c, b, d, c};
            for (int i = ring == 0 ? 3 : 0; i < (ring + 1 == RINGS ? 3 : 6); i++) around[indices++] = two[i];
        }
    round.positions = ball;
    round.position_count = corners / 3;
    round.indices = around;
    round.index_count = indices;
    IS(CULLET_STATUS_OK, cullet_scene_create(&scene));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &block, &mesh));
    IS(CULLET_STATUS_OK, cullet_scene_add_mesh(scene, &round, &mesh));
    for (int i = 0; i < BLOCKS; i++) {
        double at[3], half[3];
        for (int a = 0; a < 3; a++) {
            at[a] = (WALLS[i][a] + WALLS[i][a + 3]) / 2;
            half[a] = (WALLS[i][a + 3] - WALLS[i][a]) / 2;
        }
        all[i] = placed(0, at, half, (uint64_t)i);
    }
    for (int i = 0; i < BALLS; i++) {
        const double at[3] = {i % 2 ? 6.0 + i * .1 : -6.0 - i * .1, .5 + .25 * i, i / 2 ? 3.2 - i * .2 : -3.2},
                     half[3] = {.3, .3, .3};
        all[BLOCKS + i] = placed(1, at, half, (uint64_t)(BLOCKS + i));
    }
    IS(CULLET_STATUS_OK, cullet_scene_add(scene, all, THINGS, NULL));
    IS(CULLET_STATUS_OK, cullet_scene_commit(scene));
    return scene;
}

/* A view from a place in one room, through the door into the other. */
static cullet_view inside(int number) {
    const double eye[3] = {number % 2 ? 5.0 - number * .5 : -5.0 + number * .5, 1.5, -2.0 + number * .7},
                 target[3] = {eye[0] + (number % 2 ? -1 : 1), 1.4, eye[2] + .3 * number - .6};
    cullet_view view;
    IS(CULLET_STATUS_OK, cullet_view_look_at(eye, target, 1.2, 0.05, 640, 400, &view));
    return view;
}

/* Bits of the handles that a view sees, by settings without occlusion, so that cells and sets alone hide. */
static uint32_t sees(cullet_scene scene, cullet_state state, const cullet_view *view, uint32_t pvs, uint32_t portals) {
    cullet_handle seen[THINGS];
    cullet_settings settings;
    size_t count;
    uint32_t bits = 0;
    IS(CULLET_STATUS_OK, cullet_settings_preset(CULLET_PRESET_BALANCED, &settings));
    settings.occlusion = 0;
    settings.pvs = pvs;
    settings.portals = portals;
    IS(CULLET_STATUS_OK, cullet_cull(scene, view, &settings, state));
    IS(CULLET_STATUS_OK, cullet_visible_handles(state, scene, seen, THINGS, &count));
    for (size_t i = 0; i < count; i++) bits |= UINT32_C(1) << seen[i].index;
    return bits;
}

#endif
