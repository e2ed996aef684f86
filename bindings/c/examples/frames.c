/* A scene made by hand, culled frame after frame into arrays that are used again: nothing is allocated in the loop. */
#include <stdio.h>
#include <stdlib.h>
#include <cullet.h>

#define SIDE 32

static void check(cullet_status status) {
    if (status == CULLET_STATUS_OK) return;
    fprintf(stderr, "%s: %s\n", cullet_status_name((int32_t)status), cullet_last_error());
    exit(1);
}

int main(void) {
    static const float corners[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    static const uint32_t faces[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                       3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};
    static cullet_instance instances[SIDE * SIDE];
    static cullet_draw_command commands[SIDE * SIDE];
    static cullet_draw_key keys[SIDE * SIDE];
    static uint32_t slots[SIDE * SIDE];
    cullet_scene scene;
    cullet_state state;
    cullet_mesh_arrays box = {corners, 8, faces, 36, NULL, 0, CULLET_ONE_SIDED, 0};
    uint32_t mesh;

    check(cullet_scene_create(&scene));
    check(cullet_scene_add_mesh(scene, &box, &mesh));
    for (int i = 0; i < SIDE * SIDE; i++) {
        cullet_instance at = {{{1, 0, 0, 0, (float)(1 + i % 7), 0, 0, 0, 1}, {0, 0, 0}}, 0, 1, 0, 0, 0};
        at.transform.translation[0] = 3.0 * (i % SIDE);
        at.transform.translation[2] = 3.0 * (double)(i / SIDE);
        at.mesh = mesh;
        at.user = (uint64_t)i;
        instances[i] = at;
    }
    check(cullet_scene_add(scene, instances, SIDE * SIDE, NULL));
    check(cullet_scene_commit(scene));
    check(cullet_state_create(&state));

    for (int frame = 0; frame < 8; frame++) {
        const double eye[3] = {-2.0, 2.0, 3.0 * frame}, target[3] = {40, 1, 40};
        cullet_draws draws = {commands, keys, SIDE * SIDE, 0, slots, SIDE * SIDE, 0, NULL, 0, 0};
        cullet_view view;
        check(cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view));
        check(cullet_cull(scene, &view, NULL, state));
        check(cullet_visible_draws(state, scene, NULL, 0, &draws));
        printf("frame %d: %zu instances in %zu draws\n", frame, draws.instance_count, draws.command_count);
    }
    check(cullet_state_destroy(state));
    check(cullet_scene_destroy(scene));
    return 0;
}
