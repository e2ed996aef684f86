#include <stdio.h>
#include <cullet.h>
int main(void) {
    cullet_scene scene; cullet_state state; cullet_view view; size_t count;
    if (cullet_open("scene.glb", &scene) || cullet_state_create(&state)
        || cullet_view_look_at((double[]){0, 2, 0}, (double[]){0, 2, -10}, 0.9, 0.1, 1280, 720, &view)
        || cullet_cull(scene, &view, NULL, state) || cullet_visible_slots(state, NULL, 0, &count))
        return puts(cullet_last_error()), 1;
    printf("%zu instances are visible\n", count);
}
