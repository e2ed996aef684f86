// The C++ wrapper: objects destroy themselves once, are moved, and throw what the calls refuse.
#if __cplusplus >= 202002L
#include <span>
#endif

#include "wrapper_check.hpp"

struct vector3 {
    double x, y, z;
};

struct object {
    int name;
    vector3 center, half;
};

/* Objects of one's own: a vector of double centres, and where there is std::span, that. */
static void boxes(const cullet_view &view) {
    const std::vector<object> objects = {{1, {0, 0, -20}, {1, 1, 1}}, {2, {0, 0, 20}, {1, 1, 1}}, {3, {0, 0, -5}, {1, 1, 1}}};
    const cullet_box wall[] = {{{-5, -5, -11}, {5, 5, -10}}};
    std::vector<uint8_t> flags(3, 9);
    cullet::boxes all(320);
    all.set_centers(cullet::span<const object>(objects), &object::center, &object::half);
    require(all.cull(view, flags) == 2 && flags[0] == 1 && flags[1] == 0 && flags[2] == 1, "in the view");
    all.set_occluders({cullet::occluder_of(wall)});
    uint64_t words[1];
    require(all.cull_bits(view, words) == 1 && words[0] == 4, "behind the wall");
    throws(CULLET_STATUS_TOO_SMALL, [&] { all.cull(view, cullet::span<uint8_t>(flags.data(), 2)); }, "two flags");
    throws(CULLET_STATUS_NOT_FOUND, [&] { all.move_occluder(1, {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}}); }, "one occluder");
    const cullet_box corners[] = {{{-1, -1, -9}, {1, 1, -8}}};
    all.set(corners);
    require(all.cull(view, flags) == 1, "by corners");
#if __cplusplus >= 202002L
    const std::span<const object> part = std::span(objects).subspan(1);
    all.set_centers(cullet::span<const object>(part), &object::center, &object::half);
    require(all.cull(view, std::span(flags)) == 1 && flags[0] == 0 && flags[1] == 1, "a part of a span");
#endif
    cullet::boxes moved = std::move(all);
    throws(CULLET_STATUS_NULL_HANDLE, [&] { all.cull(view, flags); }, "moved from");
    require(moved.cull(view, flags) >= 1, "moved to");
}

int main() {
    const float positions[] = {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1};
    const std::vector<uint32_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    cullet_scene gone;
    {
        cullet::scene scene;
        gone = scene.get();
        cullet::scene moved = std::move(scene);
        require(moved.get().id == gone.id && scene.get().id == 0, "a move takes the handle");
        throws(CULLET_STATUS_NULL_HANDLE, [&] { scene.commit(); }, "a moved-from scene throws");
        cullet::scene other;
        other = std::move(moved);
        require(other.get().id == gone.id, "assignment takes the handle");
    }
    require(cullet_scene_commit(gone) == CULLET_STATUS_STALE_HANDLE, "the scene was destroyed");

    cullet::scene scene;
    const uint32_t mesh = scene.add_mesh(positions, indices, CULLET_ONE_SIDED);
    throws(CULLET_STATUS_INVALID_VALUE, [&] { scene.add_mesh(cullet::span<const float>(positions, 4), indices); }, "4 floats");
    throws(CULLET_STATUS_MESH, [&] { scene.add_mesh(cullet::span<const float>(positions, 3), indices); }, "an index beyond");
    throws(CULLET_STATUS_FILE, [] { cullet::scene::open("no such file"); }, "no file");
    const cullet_instance two[] = {cullet::instance_of(mesh, 0, 0, -10, 41), cullet::instance_of(mesh, 0, 0, 10, 42)};
    const std::vector<cullet_handle> handles = scene.add(two);
    scene.commit();
    require(scene.info().instance_count == 2, "two instances");

    cullet::state state;
    std::vector<uint64_t> users;
    std::vector<uint32_t> slots;
    std::vector<cullet_handle> seen;
    std::vector<cullet_reason> reasons;
    std::vector<cullet_funnel_row> funnel;
    const cullet_view view = cullet::look_at({0, 0, 0}, {0, 0, -1}, 0.9, 0.1, 640, 400);
    throws(CULLET_STATUS_NO_RESULT, [&] { state.slots(slots); }, "nothing was culled yet");
    cullet_settings settings = cullet::preset(CULLET_PRESET_EXACT);
    settings.reasons = 1;
    state.cull(scene, view, settings);
    state.users(scene, users);
    state.slots(slots);
    state.handles(scene, seen);
    state.reasons(reasons);
    state.funnel(funnel);
    require(users.size() == 1 && users[0] == 41 && slots.size() == 1 && seen.size() == 1, "one is visible");
    require(seen[0].index == handles[0].index && reasons.size() == 2 && funnel.size() > 2, "it is the first");
    // Behind what was ahead: the vectors shrink and grow.
    const cullet_transform there[] = {two[1].transform, two[0].transform};
    scene.set_transforms(handles, there);
    scene.refit();
    throws(CULLET_STATUS_NO_RESULT, [&] { state.users(scene, users); }, "the scene has changed");
    state.cull(scene, view);
    state.users(scene, users);
    require(users.size() == 1 && users[0] == 42, "the other is visible");
    throws(CULLET_STATUS_INVALID_VALUE, [&] { scene.set_transforms(handles, cullet::span<const cullet_transform>(there, 1)); },
           "as many transforms as handles");
    const uint32_t none[] = {0, 0};
    scene.set_layers(handles, none);
    state.cull(scene, view);
    state.users(scene, users);
    require(users.empty(), "in no layer");
    scene.remove(handles);
    require(scene.info().instance_count == 0, "removed");

    cullet::occlusion buffer(128, 80);
    buffer.begin(view);
    const cullet_box wall[] = {{{-5, -5, -10}, {5, 5, -9}}};
    const cullet_box tests[] = {{{-1, -1, -20}, {1, 1, -19}}, {{-1, -1, -8}, {1, 1, -7}}};
    std::vector<uint8_t> found;
    buffer.draw(wall);
    buffer.test(tests, found);
    require(found[0] == CULLET_FOUND_HIDDEN && found[1] == CULLET_FOUND_VISIBLE, "hidden behind the wall");
    boxes(view);
    throws(CULLET_STATUS_NULL_POINTER, [] { cullet::set_allocator({}); }, "no functions");
    std::puts("the wrapper does as it says");
}
