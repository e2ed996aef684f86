/* The first culled frame: what of a file is visible from a point. cc first.c $(pkg-config --cflags --libs cullet) */
#include <stdio.h>
#include <cullet.h>

int main(int argc, char **argv) {
    cullet_scene scene; cullet_state state; cullet_view view; size_t count;
    const double eye[3] = {0, 2, 0}, target[3] = {0, 2, -10};
    if (cullet_open(argc > 1 ? argv[1] : "scene.glb", &scene) || cullet_state_create(&state) ||
        cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, &view) ||
        cullet_cull(scene, &view, NULL, state) || cullet_visible_slots(state, NULL, 0, &count))
        return fprintf(stderr, "%s\n", cullet_last_error()), 1;
    printf("%zu instances are visible\n", count);
    return 0;
}
