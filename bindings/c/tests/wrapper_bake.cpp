// The C++ wrapper of bakes: progress, exceptions out of it, and what comes of them. wrapper_bake FOLDER has the files of bake.c.
#include <cullet_pvs.hpp>
#include <cullet_queries.hpp>

#include "wrapper_check.hpp"

int main(int argc, char **argv) {
    const std::string folder = argc > 1 ? argv[1] : ".";
    cullet::scene scene = cullet::scene::open(folder + "/house.glb");
    cullet::pvs rooms = cullet::pvs::open(folder + "/rooms.cpvs"), views = cullet::pvs::open(folder + "/house.cpvs");
    cullet::set_pvs(scene, rooms);
    const uint32_t room = cullet::cell_of(scene, {-4, 1.5, 0});
    std::vector<uint32_t> seen;
    rooms.visible(cullet::span<const uint32_t>(&room, 1), seen);
    require(rooms.info().targets == CULLET_PVS_TARGETS_CELLS && seen.size() == 2, "two rooms see each other");
    std::vector<cullet_eye_box> boxes;
    std::vector<float> missing;
    views.cells(boxes);
    views.missing(missing);
    require(boxes.size() == 32 && missing.size() == 32 && views.cell_of({0, 0, 1e9}) == UINT32_MAX, "view cells");
    throws(CULLET_STATUS_NOT_FOUND, [&] { rooms.cells(boxes); }, "rooms have no view cells");

    const cullet_eye_box within = {{-8, 0, -4}, {8, 3, 4}};
    cullet_pvs_settings settings{};
    settings.boxes = &within;
    settings.box_count = 1;
    settings.grid[0] = 8;
    settings.grid[1] = 1;
    settings.grid[2] = 4;
    settings.rays = 60000;
    cullet::bake_options options;
    double last = 0;
    options.threads = 2;
    options.step = [&](double share) { return last = share, true; };
    std::vector<uint8_t> own, given;
    cullet::pvs::bake(scene, &settings, options).write(own);
    views.write(given);
    require(own == given && last > 0.9, "the bytes of the file");
    options.step = [](double) { return false; };
    throws(CULLET_STATUS_STOPPED, [&] { cullet::pvs::bake(scene, &settings, options); }, "stopped");
    options.step = [](double) -> bool { throw std::runtime_error("of the callback"); };
    try {
        cullet::bake_levels(scene, options);
        require(false, "an exception passes");
    } catch (const cullet::error &) {
        require(false, "the callback's own");
    } catch (const std::runtime_error &error) {
        require(std::strcmp(error.what(), "of the callback") == 0, "its words");
    }
    require(cullet::bake_levels(scene) >= 1, "levels");
    require(cullet::bake_occluders(scene, true) == 2, "occluders");
    cullet_cells_settings find{};
    find.voxel = 0.2;
    require(cullet::bake_cells(scene, &find) == 3, "cells");
    require(cullet::take_occluders(scene, false) <= 2, "occluders that pay");
    scene.commit();
    cullet::save(scene, folder + "/again.glb");
    throws(CULLET_STATUS_FILE, [&] { cullet::save(scene, folder + "/again.txt"); }, "no kind of file");
    std::puts("the wrapper of bakes does as it says");
}
