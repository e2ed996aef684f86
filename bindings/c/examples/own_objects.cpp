// Objects of one's own in a std::vector: culled by the C++ wrapper, found again by their numbers.
#include <cstdio>
#include <vector>

#include <cullet.hpp>

struct Tree {
    double x, z;
    float height;
};

int main() try {
    std::vector<Tree> trees;
    for (int i = 0; i < 1000; i++) trees.push_back({(i % 40) * 5.0, (i / 40) * 5.0, 2.0f + float(i % 5)});

    const std::vector<float> positions = {-1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1};
    const std::vector<uint32_t> indices = {0, 1, 2, 3, 4, 2};
    cullet::scene scene;
    const uint32_t mesh = scene.add_mesh(positions, indices);
    std::vector<cullet_instance> instances;
    for (size_t i = 0; i < trees.size(); i++) {
        cullet_instance at = cullet::instance_of(mesh, trees[i].x, 0, trees[i].z, i);
        at.transform.linear[4] = trees[i].height;
        instances.push_back(at);
    }
    scene.add(instances);
    scene.commit();

    cullet::state state;
    std::vector<uint64_t> visible;
    state.cull(scene, cullet::look_at({-5, 2, -5}, {100, 2, 100}, 0.9, 0.1, 1280, 720));
    state.users(scene, visible);
    std::printf("%zu of %zu trees are visible, the first at %g %g\n", visible.size(), trees.size(),
                trees[visible.at(0)].x, trees[visible.at(0)].z);
} catch (const cullet::error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
