// Boxes in, flags out, over objects as a C++ program has them: a span, and which members are centre and half size.
#include <cstdio>
#include <vector>

#include <cullet.hpp>

struct object {
    const char *name;
    float center[3], half[3];
};

int main() try {
    const std::vector<object> objects = {{"tree", {-2, 2, -20}, {1, 2, 1}},
                                         {"rock behind the wall", {0, 1, -50}, {2, 1, 2}},
                                         {"car behind the eye", {0, 1, 10}, {2, 1, 1}}};
    const cullet_box wall[] = {{{-40, 0, -41}, {40, 9, -40}}};
    cullet::boxes boxes;
    boxes.set_centers(cullet::span<const object>(objects), &object::center, &object::half);
    boxes.set_occluders({cullet::occluder_of(wall)});

    std::vector<uint8_t> flags(objects.size()); // once; each frame:
    boxes.cull(cullet::look_at({0, 2, 0}, {0, 2, -10}, 0.9, 0.1, 1280, 720), flags);
    for (size_t i = 0; i < objects.size(); i++)
        if (flags[i]) std::printf("draw the %s\n", objects[i].name);
} catch (const cullet::error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
