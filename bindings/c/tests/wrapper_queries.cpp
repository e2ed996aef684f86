// The C++ wrappers of scenes' queries, of the culls beside cullet_cull, of levels and of sets.
#include <cullet_pvs.hpp>
#include <cullet_queries.hpp>
#include <thread>

#include "wrapper_check.hpp"

static const float corners[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const uint32_t faces[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                 3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};

static void queries(const cullet::scene &scene, const std::vector<cullet_handle> &handles, const cullet_view &view) {
    const cullet_segment segments[] = {{{0, 0, 0}, {0, 0, -30}}, {{0, 20, 0}, {0, 20, -30}}};
    std::vector<cullet_sight> sights;
    cullet::lines_of_sight(scene, segments, sights);
    require(sights.size() == 2 && sights[0].blocked == 1 && sights[1].blocked == 0, "one line is blocked");
    require(sights[0].handle.index == handles[0].index, "by the wall");
    cullet_sight_options options{};
    options.ignored_count = 3;
    throws(CULLET_STATUS_INVALID_VALUE, [&] { cullet::lines_of_sight(scene, segments, sights, &options); }, "3 ignored");
    const cullet_box from = {{-1, -1, -1}, {1, 1, 1}}, to[] = {{{-1, -1, -21}, {1, 1, -20}}, {{-1, 30, -21}, {1, 31, -20}}};
    std::vector<uint8_t> found;
    cullet::box_to_box(scene, from, to, found);
    require(found.size() == 2 && found[0] == CULLET_FOUND_HIDDEN && found[1] == CULLET_FOUND_VISIBLE, "a box is hidden");
    require(cullet::cell_of(scene, {0, 0, 0}) == UINT32_MAX, "no cells");
    cullet_reason reason;
    const cullet_settings exact = cullet::preset(CULLET_PRESET_EXACT);
    const std::string why = cullet::explain(scene, view, handles[1], &exact, &reason);
    require(reason.stage == CULLET_STAGE_OCCLUSION && why.find("occlusion") != std::string::npos, "why");
    require(why.find('\0') == std::string::npos, "a text without a zero");
    cullet::region region;
    std::vector<uint32_t> slots;
    throws(CULLET_STATUS_NO_RESULT, [&] { region.slots(slots); }, "nothing was culled");
    region.cull(scene, {{-.2, -.2, -.2}, {.2, .2, .2}});
    region.slots(slots);
    require(slots.size() == 2, "a region sees the wall and the tower");
    region.cull(scene, {{-.2, -.2, -.2}, {.2, .2, .2}}, &view);
    region.slots(slots);
    require(slots.size() == 1 && slots[0] == scene.slot(handles[0]), "in the view the wall alone");
}

static void instances(cullet::scene &scene, const std::vector<cullet_handle> &handles) {
    cullet_handle handle{9, 9};
    const uint32_t slot = scene.slot(handles[1]);
    const cullet_instance found = scene.instance(slot, &handle);
    require(found.user == 11 && handle.index == handles[1].index && scene.instance(slot).mesh == found.mesh, "an instance");
    throws(CULLET_STATUS_NOT_FOUND, [&] { scene.instance(99); }, "an empty slot");
    std::vector<float> positions;
    std::vector<uint32_t> indices;
    scene.mesh_read(found.mesh, positions, indices);
    require(positions.size() == 24 && indices.size() == 36 && scene.mesh_info(found.mesh).part_count == 1, "a mesh");
    throws(CULLET_STATUS_NOT_FOUND, [&] { scene.mesh_read(9, positions, indices); }, "no mesh");
    const float margin[] = {0.5f};
    scene.set_bounds(handles[1], CULLET_BOUNDS_MARGIN, margin);
    scene.set_bounds(handles[1], CULLET_BOUNDS_MESH);
    throws(CULLET_STATUS_INVALID_VALUE, [&] { scene.set_bounds(handles[1], CULLET_BOUNDS_WORLD, margin); }, "6 numbers");
}

static void culls(const cullet::scene &scene, const std::vector<cullet_handle> &handles, const cullet_view &view) {
    cullet::state state, shadow, pooled;
    std::vector<uint32_t> slots, of_pool;
    const cullet_settings exact = cullet::preset(CULLET_PRESET_EXACT);
    const uint64_t without_wall[] = {~(uint64_t(1) << scene.slot(handles[0]))};
    state.cull_among(scene, view, without_wall, &exact);
    state.slots(slots);
    require(slots.size() == 1 && slots[0] == scene.slot(handles[1]), "among candidates");
    throws(CULLET_STATUS_INVALID_VALUE, [&] { state.cull_among(scene, view, {}); }, "no words");

    state.cull(scene, view, exact);
    std::vector<uint8_t> reasons;
    cullet_light lights[2] = {};
    lights[0].direction[1] = -1;
    lights[1].kind = CULLET_LIGHT_KIND_POINT;
    lights[1].position[2] = 20;
    lights[1].range = 3;
    state.lights(scene, lights, reasons);
    require(reasons.size() == 2 && reasons[0] == CULLET_LIGHT_REASON_KEPT && reasons[1] == CULLET_LIGHT_REASON_FRUSTUM, "lights");
    cullet_shadow of_sun{};
    of_sun.light = lights[0];
    of_sun.receivers = state.get();
    shadow.cull_shadow(scene, view, of_sun);
    shadow.slots(slots);
    require(!slots.empty(), "casters");
    throws(CULLET_STATUS_INVALID_VALUE, [&] { state.cull_shadow(scene, view, of_sun); }, "the state of the receivers");

    cullet::draw_lists draws;
    draws.commands.reserve(8);
    for (int turn = 0; turn < 2; turn++) {
        state.draws(scene, {}, draws);
        require(draws.commands.size() == 1 && draws.keys.size() == 1 && draws.instances.size() == 1, "one draw");
        require(draws.commands[0].index_count > 0 && draws.indices.empty(), "of clusters");
    }
    require(state.lod() == 0, "no levels");

    const cullet_view right = cullet::look_at({0.1, 0, 0}, {0.1, 0, -1}, 0.9, 0.1, 640, 400);
    std::vector<uint8_t> eyes;
    pooled.cull_stereo(scene, view, right, &exact);
    pooled.eyes(scene, view, right, eyes);
    require(eyes.size() == 1 && eyes[0] == 3, "both eyes see the wall");
    const cullet_view aside = cullet::look_at({0, 0, 0}, {-0.995, 0, -0.0998}, 0.9, 0.1, 640, 400);
    pooled.cull_stereo(scene, view, aside, &exact);
    pooled.eyes(scene, view, aside, eyes);
    require(eyes.size() == 1 && eyes[0] == 1, "the left eye alone does");

    const auto pool = [](auto job, std::size_t count) {
        std::vector<std::thread> threads;
        for (std::size_t number = 0; number < count; number++) threads.emplace_back([=] { job(number); });
        for (std::thread &thread : threads) thread.join();
    };
    pooled.cull_on(cullet::jobs_on(2, pool), scene, view, &exact);
    pooled.slots(of_pool);
    state.slots(slots);
    require(slots == of_pool, "the same on a pool");
    throws(CULLET_STATUS_INVALID_VALUE, [&] { pooled.cull_on(cullet::jobs_on(0, pool), scene, view); }, "no threads");
}

static void levels(const cullet_view &view) {
    cullet::scene scene;
    std::vector<cullet_levels> found;
    const uint32_t fine = scene.add_mesh(corners, faces);
    const uint32_t coarse = scene.add_mesh(corners, cullet::span<const uint32_t>(faces, 24));
    scene.add_lod(fine, coarse, 0.25f);
    scene.levels(fine, found);
    require(found.size() == 1 && found[0].mesh == coarse && found[0].most_error == 0.25f, "one level");
    const cullet_instance one[] = {cullet::instance_of(fine, 0, 0, -90)};
    scene.add(one);
    scene.commit();
    cullet::state state;
    cullet::draw_lists draws;
    cullet_settings settings = cullet::preset(CULLET_PRESET_BALANCED);
    settings.lod_pixels = 2;
    state.cull(scene, view, settings);
    state.draws(scene, {}, draws);
    require(state.lod() == 2 && draws.keys.size() == 1 && draws.keys[0].mesh == coarse && draws.keys[0].level == 1, "drawn");
    scene.clear_levels(fine);
    scene.levels(fine, found);
    require(found.empty(), "no level");
    throws(CULLET_STATUS_INVALID_VALUE, [&] { scene.add_lod(fine, fine, 1); }, "itself");
}

int main() {
    cullet::scene scene;
    const uint32_t box = scene.add_mesh(corners, faces, CULLET_ONE_SIDED);
    cullet_instance three[] = {cullet::instance_of(box, 0, 0, -10, 10), cullet::instance_of(box, 0, 0, -20, 11),
                               cullet::instance_of(box, 0, 40, -10, 12)};
    three[0].transform.linear[0] = 9;
    three[0].transform.linear[4] = 5;
    const std::vector<cullet_handle> handles = scene.add(three);
    scene.commit();
    const cullet_view view = cullet::look_at({0, 0, 0}, {0, 0, -1}, 0.9, 0.1, 640, 400);
    queries(scene, handles, view);
    instances(scene, handles);
    culls(scene, handles, view);
    levels(view);
    throws(CULLET_STATUS_FILE, [] { cullet::pvs::open("no such file"); }, "no file");
    const uint8_t nonsense[64] = {1, 2, 3};
    throws(CULLET_STATUS_FILE, [&] { cullet::pvs::read(nonsense); }, "no sets");
    cullet::clear_pvs(scene);
    require(cullet::take_occluders(scene, true) == 0, "no occluders of a file");
    std::puts("the wrappers do as they say");
}
