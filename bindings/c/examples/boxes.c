#include <stdio.h>
#include <cullet.h>
struct object { const char *name; float center[3], half[3]; } objects[] = {
    {"tree", {-2, 2, -20}, {1, 2, 1}}, {"house", {6, 3, -30}, {4, 3, 4}},
    {"rock behind the wall", {0, 1, -50}, {2, 1, 2}}, {"car behind the eye", {0, 1, 10}, {2, 1, 1}},
    {"tower behind the wall", {9, 20, -60}, {3, 20, 3}}};
float wall[] = {-40, 0, -41, 40, 9, -40}; /* lowest and highest corner */
int main(void) {
    enum { COUNT = sizeof objects / sizeof *objects };
    cullet_box_arrays arrays = {.first = objects->center, .second = objects->half, .stride = sizeof *objects,
                                .count = COUNT, .form = CULLET_BOX_FORM_CENTER_HALF};
    cullet_occluder hides = {.kind = CULLET_OCCLUDER_KIND_BOXES, .positions = wall, .stride = 24, .position_count = 1};
    cullet_boxes boxes; cullet_view view; uint8_t flags[COUNT]; size_t visible;
    if (cullet_boxes_create(0, &boxes) || cullet_boxes_set(boxes, &arrays)
        || cullet_boxes_set_occluders(boxes, &hides, 1)
        || cullet_view_look_at((double[]){0, 2, 0}, (double[]){0, 2, -10}, 0.9, 0.1, 1280, 720, &view)
        || cullet_boxes_cull(boxes, &view, flags, COUNT, &visible)) return puts(cullet_last_error()), 1;
    for (int i = 0; i < COUNT; i++) if (flags[i]) printf("draw the %s\n", objects[i].name);
    printf("%zu of %d boxes may be visible\n", visible, COUNT);
}
