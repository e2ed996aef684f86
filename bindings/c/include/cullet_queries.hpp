/** Queries in C++17: lines of sight, boxes from boxes, regions of eyes, and why an instance is drawn or culled.
 *
 * As cullet.hpp: what a call refuses is thrown as cullet::error; cullet.h says what each does and costs. */
#ifndef CULLET_QUERIES_HPP
#define CULLET_QUERIES_HPP

#include "cullet.hpp"

namespace cullet {

/** Finds what blocks lines of sight; the results have as many elements as there are segments. */
inline void lines_of_sight(const scene &scene, span<const cullet_segment> segments, std::vector<cullet_sight> &results,
                           const cullet_sight_options *options = nullptr) {
    results.resize(segments.size());
    check(cullet_lines_of_sight(scene.get(), segments.data(), segments.size(), options, results.data()));
}

/** A cullet_found for each box: whether it is hidden from all of the box `from`. */
inline void box_to_box(const scene &scene, const cullet_box &from, span<const cullet_box> to,
                       std::vector<uint8_t> &results, const cullet_box_sight_options *options = nullptr) {
    results.resize(to.size());
    check(cullet_box_to_box(scene.get(), &from, to.data(), to.size(), options, results.data()));
}

/** The cell of a point; UINT32_MAX where it is in none. */
inline uint32_t cell_of(const scene &scene, const std::array<double, 3> &point) {
    return detail::written<uint32_t>(cullet_scene_cell_of, scene.get(), point.data());
}

/** Why an instance is drawn or culled: a line for each stage; its reason too, unless that is null. */
inline std::string explain(const scene &scene, const cullet_view &view, const cullet_handle &handle,
                           const cullet_settings *settings = nullptr, cullet_reason *reason = nullptr) {
    size_t length = 0;
    check(cullet_explain(scene.get(), &view, settings, handle, reason, nullptr, 0, &length));
    std::string text(length, 0);
    check(cullet_explain(scene.get(), &view, settings, handle, nullptr, &text[0], text.size(), &length));
    text.resize(length - 1);
    return text;
}

/** The memory of region queries, and the last result. */
class region {
public:
    region() : own_(detail::written<cullet_region>(cullet_region_create)) {}
    cullet_region get() const noexcept { return own_.get(); }

    /** Finds what may be seen from any eye in a box, in any direction or, with a view, as that looks. */
    void cull(const scene &scene, const cullet_eye_box &eyes, const cullet_view *view = nullptr,
              const cullet_region_settings *settings = nullptr) {
        check(cullet_region_cull(scene.get(), &eyes, view, settings, get()));
    }
    void slots(std::vector<uint32_t> &to) const {
        detail::fill(to, [&](uint32_t *data, size_t room, size_t *count) {
            return cullet_region_slots(get(), data, room, count);
        });
    }

private:
    using owner = detail::owner<cullet_region, cullet_region_destroy>;
    owner own_;
};

}  // namespace cullet

#endif
