/** Visible sets in C++17, opened, asked and given to scenes; and bakes, for libraries that are built with them.
 *
 * As cullet.hpp: what a call refuses is thrown as cullet::error; cullet.h says what each does and costs. */
#ifndef CULLET_PVS_HPP
#define CULLET_PVS_HPP

#include <exception>
#include <functional>

#include "cullet.hpp"

namespace cullet {

class bake_options;

/** Visible sets: what may be seen from each of some cells. */
class pvs {
public:
    static pvs open(const std::string &path) {
        return pvs(detail::written<cullet_pvs>(cullet_pvs_open, path.c_str()));
    }
    static pvs read(span<const uint8_t> bytes) {
        return pvs(detail::written<cullet_pvs>(cullet_pvs_read, bytes.data(), bytes.size()));
    }
    /** Bakes sets of a scene; see cullet_bake_pvs. */
    static pvs bake(const scene &scene, const cullet_pvs_settings *settings, const bake_options &options);
    cullet_pvs get() const noexcept { return own_.get(); }

    void write(std::vector<uint8_t> &bytes) const {
        detail::fill(bytes, [&](uint8_t *data, size_t room, size_t *count) {
            return cullet_pvs_write(get(), data, room, count);
        });
    }
    cullet_pvs_info info() const {
        return detail::written<cullet_pvs_info>(cullet_pvs_get_info, get());
    }
    void cells(std::vector<cullet_eye_box> &to) const {
        detail::fill(to, [&](cullet_eye_box *data, size_t room, size_t *count) {
            return cullet_pvs_cells(get(), data, room, count);
        });
    }
    void missing(std::vector<float> &to) const {
        detail::fill(to, [&](float *data, size_t room, size_t *count) {
            return cullet_pvs_missing(get(), data, room, count);
        });
    }
    /** The view cell of a point; UINT32_MAX where it is in none. */
    uint32_t cell_of(const std::array<double, 3> &point) const {
        uint32_t cell;
        check(cullet_pvs_cell_of(get(), point.data(), 1, &cell));
        return cell;
    }
    /** What may be seen from any of some cells: indices of handles, or cells. */
    void visible(span<const uint32_t> cells, std::vector<uint32_t> &to) const {
        detail::fill(to, [&](uint32_t *data, size_t room, size_t *count) {
            return cullet_pvs_visible(get(), cells.data(), cells.size(), data, room, count);
        });
    }

private:
    using owner = detail::owner<cullet_pvs, cullet_pvs_destroy>;
    explicit pvs(cullet_pvs made) noexcept : own_(made) {}
    owner own_;
};

/** Culls a scene by sets from now on. */
inline void set_pvs(scene &scene, const pvs &sets) { check(cullet_scene_set_pvs(scene.get(), sets.get())); }

/** Culls a scene by no sets any more. */
inline void clear_pvs(scene &scene) { check(cullet_scene_set_pvs(scene.get(), cullet_pvs{0})); }

/** Gives meshes the occluders that the scene's file brought; returns how many took some. */
inline uint32_t take_occluders(scene &scene, bool always) {
    return detail::written<uint32_t>(cullet_scene_take_occluders, scene.get(), always);
}

/** Threads, progress and units of a bake; see cullet_bake_options. */
class bake_options {
public:
    uint32_t threads = 1;
    /** Share of the work, from 0, and how many shares there are; 0 for all of it. */
    uint32_t share = 0, share_count = 0;
    /** Folder of finished units; empty for none. */
    std::string folder;
    /** Hears of the share that is done; returns whether to go on. What it throws stops the bake, and is thrown by that. */
    std::function<bool(double)> step;

    /** Calls a bake with these options. */
    template <typename F>
    void run(F bake) const {
        heard heard{this, nullptr};
        const cullet_bake_options options = {threads,
                                             share,
                                             share_count,
                                             0,
                                             folder.empty() ? nullptr : folder.c_str(),
                                             step ? &call : nullptr,
                                             &heard};
        const cullet_status status = bake(&options);
        if (heard.thrown) std::rethrow_exception(heard.thrown);
        check(status);
    }

private:
    struct heard {
        const bake_options *of;
        std::exception_ptr thrown;
    };
    static uint32_t call(void *context, double share) {
        heard &own = *static_cast<heard *>(context);
        try {
            return own.of->step(share);
        } catch (...) {
            own.thrown = std::current_exception();
            return 0;
        }
    }
};

inline pvs pvs::bake(const scene &scene, const cullet_pvs_settings *settings, const bake_options &options) {
    cullet_pvs made{0};
    options.run([&](const cullet_bake_options *o) { return cullet_bake_pvs(scene.get(), settings, o, &made); });
    return pvs(made);
}

/** Bakes levels of detail of every mesh; returns how many have some. Commit the scene afterwards. */
inline uint32_t bake_levels(scene &scene, const bake_options &options = {}) {
    uint32_t count = 0;
    options.run([&](const cullet_bake_options *o) { return cullet_bake_levels(scene.get(), o, &count); });
    return count;
}

/** Bakes occluders of every mesh; returns how many took theirs. */
inline uint32_t bake_occluders(scene &scene, bool always, const bake_options &options = {}) {
    uint32_t given = 0;
    options.run([&](const cullet_bake_options *o) { return cullet_bake_occluders(scene.get(), always, o, &given); });
    return given;
}

/** Finds rooms and openings in the triangles of a scene; returns how many cells there are. */
inline uint32_t bake_cells(scene &scene, const cullet_cells_settings *settings = nullptr,
                           const bake_options &options = {}) {
    uint32_t count = 0;
    options.run([&](const cullet_bake_options *o) { return cullet_bake_cells(scene.get(), settings, o, &count); });
    return count;
}

/** Writes a scene to a file; with the glTF file that it is of, that one with what was baked added. */
inline void save(scene &scene, const std::string &path, const std::string &original = {}) {
    check(cullet_scene_save(scene.get(), path.c_str(), original.empty() ? nullptr : original.c_str()));
}

}  // namespace cullet

#endif
