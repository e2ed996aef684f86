/** The C++17 interface of cullet: cullet.h with objects that destroy themselves, spans, and exceptions.
 *
 * Every function throws cullet::error where the C call fails; cullet.h says when, what it costs, and the rules on threads.
 * Objects are moved, not copied. A moved-from object holds no handle: using it throws. */
#ifndef CULLET_HPP
#define CULLET_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "cullet.h"

namespace cullet {

/** What a call refused: its status, and in what() the message of cullet_last_error. */
class error : public std::runtime_error {
public:
    error(cullet_status status, const std::string &message) : std::runtime_error(message), status_(status) {}
    cullet_status status() const noexcept { return status_; }

private:
    cullet_status status_;
};

/** Throws unless a status is CULLET_STATUS_OK. */
inline void check(cullet_status status) {
    if (status != CULLET_STATUS_OK) throw error(status, cullet_last_error());
}

/** See cullet_set_allocator: call it before anything else. */
inline void set_allocator(const cullet_allocator &allocator) { check(cullet_set_allocator(&allocator)); }

/** Elements of a caller's in a row: made of pointer and size, of arrays, and of whatever has data() and size(). */
template <typename T>
class span {
public:
    constexpr span() noexcept = default;
    constexpr span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    template <std::size_t N>
    constexpr span(T (&array)[N]) noexcept : data_(array), size_(N) {}
    template <typename C, typename = std::enable_if_t<
                              std::is_convertible_v<decltype(std::declval<C &>().data()), T *> &&
                              std::is_convertible_v<decltype(std::declval<C &>().size()), std::size_t>>>
    constexpr span(C &&container) noexcept : data_(container.data()), size_(container.size()) {}
    constexpr T *data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }
    constexpr T *begin() const noexcept { return data_; }
    constexpr T *end() const noexcept { return data_ + size_; }
    constexpr T &operator[](std::size_t at) const { return data_[at]; }

private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {
/** A handle that is destroyed once. */
template <typename H, cullet_status (*Destroy)(H)>
class owner {
public:
    owner() noexcept = default;
    explicit owner(H handle) noexcept : handle_(handle) {}
    owner(owner &&other) noexcept : handle_(std::exchange(other.handle_, H{0})) {}
    owner &operator=(owner &&other) noexcept {
        if (this != &other) {
            reset();
            handle_ = std::exchange(other.handle_, H{0});
        }
        return *this;
    }
    owner(const owner &) = delete;
    owner &operator=(const owner &) = delete;
    ~owner() { reset(); }
    H get() const noexcept { return handle_; }

private:
    void reset() noexcept {
        if (handle_.id != 0) Destroy(handle_);
        handle_ = H{0};
    }
    H handle_{0};
};

/** Returns what a call writes to its last argument. */
template <typename T, typename F, typename... A>
T written(F call, const A &...args) {
    T value;
    check(call(args..., &value));
    return value;
}

/** Number type of three numbers in a row: of arrays, and of vectors of three or four floats or doubles. */
template <typename V>
constexpr uint32_t number_of() {
    static_assert(std::is_standard_layout_v<V> && std::is_trivially_copyable_v<V>, "three numbers in a row are needed");
    constexpr std::size_t size = sizeof(V);
    static_assert(size == 12 || size == 16 || size == 24 || size == 32, "three or four floats or doubles are needed");
    static_assert(alignof(V) >= (size < 24 ? alignof(float) : alignof(double)), "floats or doubles are needed");
    return size < 24 ? CULLET_NUMBER_F32 : CULLET_NUMBER_F64;
}

/** Fills a vector by a call that takes room and writes a count; the vector keeps its memory. */
template <typename T, typename F>
inline void fill(std::vector<T> &to, F read) {
    size_t count = 0;
    to.resize(to.capacity());
    cullet_status status = read(to.data(), to.size(), &count);
    if (status == CULLET_STATUS_TOO_SMALL || (status == CULLET_STATUS_OK && count > to.size())) {
        to.resize(count);
        status = read(to.data(), to.size(), &count);
    }
    to.resize(status == CULLET_STATUS_OK ? count : 0);
    check(status);
}
}  // namespace detail

/** An instance of a mesh at a place, in layer 1, with a number of the caller's. */
inline cullet_instance instance_of(uint32_t mesh, double x, double y, double z, uint64_t user = 0) {
    return {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {x, y, z}}, mesh, 1, 0, 0, user};
}

/** See cullet_view_look_at. */
inline cullet_view look_at(const std::array<double, 3> &eye, const std::array<double, 3> &target, double fov_y,
                           double near_plane, uint32_t width, uint32_t height) {
    return detail::written<cullet_view>(cullet_view_look_at, eye.data(), target.data(), fov_y, near_plane, width, height);
}

/** See cullet_view_from_matrix. */
inline cullet_view view_from_matrix(const std::array<double, 16> &clip_from_world, uint32_t depth, uint32_t width,
                                    uint32_t height) {
    return detail::written<cullet_view>(cullet_view_from_matrix, clip_from_world.data(), depth, width, height);
}

/** See cullet_view_from_camera. */
inline cullet_view view_from_camera(const cullet_camera &camera, uint32_t depth, uint32_t width, uint32_t height) {
    return detail::written<cullet_view>(cullet_view_from_camera, &camera, depth, width, height);
}

/** See cullet_settings_preset. */
inline cullet_settings preset(cullet_preset number) {
    return detail::written<cullet_settings>(cullet_settings_preset, number);
}

/** A scene: meshes and their instances. */
class scene {
public:
    scene() : own_(detail::written<cullet_scene>(cullet_scene_create)) {}
    static scene open(const std::string &path) {
        return scene(detail::written<cullet_scene>(cullet_open, path.c_str()));
    }
    cullet_scene get() const noexcept { return own_.get(); }

    /** Adds a mesh of one part: three floats a vertex, three indices a triangle. */
    uint32_t add_mesh(span<const float> positions, span<const uint32_t> indices, uint32_t flags = 0) {
        if (positions.size() % 3 != 0)
            throw error(CULLET_STATUS_INVALID_VALUE, "add_mesh: positions has " + std::to_string(positions.size()) +
                                                         " floats, which is no multiple of 3");
        return add_mesh({positions.data(), positions.size() / 3, indices.data(), indices.size(), nullptr, 0, flags, 0});
    }
    uint32_t add_mesh(const cullet_mesh_arrays &arrays) {
        return detail::written<uint32_t>(cullet_scene_add_mesh, get(), &arrays);
    }
    std::vector<cullet_handle> add(span<const cullet_instance> instances) {
        std::vector<cullet_handle> handles(instances.size());
        check(cullet_scene_add(get(), instances.data(), instances.size(), handles.data()));
        return handles;
    }
    void remove(span<const cullet_handle> handles) {
        check(cullet_scene_remove(get(), handles.data(), handles.size()));
    }
    void set_transforms(span<const cullet_handle> handles, span<const cullet_transform> transforms) {
        same(handles.size(), transforms.size());
        check(cullet_scene_set_transforms(get(), handles.data(), transforms.data(), handles.size()));
    }
    void set_layers(span<const cullet_handle> handles, span<const uint32_t> layers) {
        same(handles.size(), layers.size());
        check(cullet_scene_set_layers(get(), handles.data(), layers.data(), handles.size()));
    }
    void set_flags(span<const cullet_handle> handles, span<const uint32_t> flags) {
        same(handles.size(), flags.size());
        check(cullet_scene_set_flags(get(), handles.data(), flags.data(), handles.size()));
    }
    void set_bounds(const cullet_handle &handle, cullet_bounds kind, span<const float> numbers = {}) {
        const std::size_t needed = kind == CULLET_BOUNDS_WORLD ? 6 : kind == CULLET_BOUNDS_MARGIN ? 1 : 0;
        if (numbers.size() < needed)
            throw error(CULLET_STATUS_INVALID_VALUE, "set_bounds: " + std::to_string(numbers.size()) + " numbers, but " +
                                                         std::to_string(needed) + " are needed");
        check(cullet_scene_set_bounds(get(), handle, kind, numbers.data()));
    }
    void commit() { check(cullet_scene_commit(get())); }
    void refit() { check(cullet_scene_refit(get())); }
    cullet_scene_info info() const {
        return detail::written<cullet_scene_info>(cullet_scene_get_info, get());
    }
    uint32_t slot(const cullet_handle &handle) const {
        return detail::written<uint32_t>(cullet_scene_slot, get(), handle);
    }
    cullet_instance instance(uint32_t slot, cullet_handle *handle = nullptr) const {
        cullet_instance instance;
        check(cullet_scene_instance(get(), slot, &instance, handle));
        return instance;
    }
    cullet_mesh_info mesh_info(uint32_t mesh) const {
        return detail::written<cullet_mesh_info>(cullet_scene_mesh_info, get(), mesh);
    }
    /** Reads what to upload of a mesh: three floats a vertex, three indices a triangle, in the order of draws. */
    void mesh_read(uint32_t mesh, std::vector<float> &positions, std::vector<uint32_t> &indices) const {
        const cullet_mesh_info info = mesh_info(mesh);
        positions.resize(3 * info.position_count);
        indices.resize(info.index_count);
        check(cullet_scene_mesh_read(get(), mesh, positions.data(), positions.size(), indices.data(), indices.size()));
    }
    void levels(uint32_t mesh, std::vector<cullet_levels> &to) const {
        detail::fill(to, [&](cullet_levels *data, size_t room, size_t *count) {
            return cullet_scene_levels(get(), mesh, data, room, count);
        });
    }
    void add_lod(uint32_t mesh, uint32_t coarse, float error) { check(cullet_scene_add_lod(get(), mesh, coarse, error)); }
    void clear_levels(uint32_t mesh) { check(cullet_scene_clear_levels(get(), mesh)); }

private:
    using owner = detail::owner<cullet_scene, cullet_scene_destroy>;
    explicit scene(cullet_scene made) noexcept : own_(made) {}
    static void same(std::size_t handles, std::size_t values) {
        if (handles != values)
            throw error(CULLET_STATUS_INVALID_VALUE,
                        std::to_string(handles) + " handles, but " + std::to_string(values) + " values");
    }
    owner own_;
};

/** Draws of a result; the vectors keep their memory from frame to frame. */
struct draw_lists {
    std::vector<cullet_draw_command> commands;
    std::vector<cullet_draw_key> keys;
    std::vector<uint32_t> instances;
    /** Where the output is triangles. */
    std::vector<uint32_t> indices;

private:
    friend class state;
    /** All the room that there is. */
    cullet_draws room() {
        commands.resize(commands.capacity());
        keys.resize(commands.size());
        instances.resize(instances.capacity());
        indices.resize(indices.capacity());
        return {commands.data(), keys.data(), commands.size(), 0, instances.data(), instances.size(), 0,
                indices.data(),  indices.size(), 0};
    }
    bool holds(const cullet_draws &needed) const {
        return needed.command_count <= commands.size() && needed.instance_count <= instances.size() &&
               needed.index_count <= indices.size();
    }
    void grow(const cullet_draws &needed) {
        if (commands.size() < needed.command_count) commands.resize(needed.command_count);
        if (instances.size() < needed.instance_count) instances.resize(needed.instance_count);
        if (indices.size() < needed.index_count) indices.resize(needed.index_count);
    }
    void shrink(const cullet_draws &used) {
        commands.resize(used.command_count);
        keys.resize(used.command_count);
        instances.resize(used.instance_count);
        indices.resize(used.index_count);
    }
};

/** Jobs on threads of the caller's: run(job, count) calls job(0), job(1) and so on below count, on any threads, and returns
 * when all have returned. It must live until the cull ends, and throw nothing. */
template <typename F>
cullet_jobs jobs_on(uint32_t threads, F &run) {
    const auto call = [](void *context, void (*job)(void *, size_t), void *jobs, size_t count) noexcept {
        (*static_cast<F *>(context))([=](std::size_t number) { job(jobs, number); }, std::size_t(count));
    };
    return {threads, 0, call, const_cast<void *>(static_cast<const void *>(&run))};
}

/** The state of a view, and its last result. Vectors that are filled keep their memory from frame to frame. */
class state {
public:
    state() : own_(detail::written<cullet_state>(cullet_state_create)) {}
    cullet_state get() const noexcept { return own_.get(); }

    void cull(const scene &scene, const cullet_view &view) {
        check(cullet_cull(scene.get(), &view, nullptr, get()));
    }
    void cull(const scene &scene, const cullet_view &view, const cullet_settings &settings) {
        check(cullet_cull(scene.get(), &view, &settings, get()));
    }
    /** Culls on threads of the caller's: see jobs_on. */
    void cull_on(const cullet_jobs &jobs, const scene &scene, const cullet_view &view,
                 const cullet_settings *settings = nullptr) {
        check(cullet_cull_on(&jobs, scene.get(), &view, settings, get()));
    }
    /** Culls among candidates: a bit for each slot, 64 a word. */
    void cull_among(const scene &scene, const cullet_view &view, span<const uint64_t> words,
                    const cullet_settings *settings = nullptr) {
        check(cullet_cull_among(scene.get(), &view, settings, words.data(), words.size(), get()));
    }
    void cull_stereo(const scene &scene, const cullet_view &left, const cullet_view &right,
                     const cullet_settings *settings = nullptr) {
        check(cullet_cull_stereo(scene.get(), &left, &right, settings, get()));
    }
    /** Which eye may see each of the slots: bit 0 for the left, bit 1 for the right. */
    void eyes(const scene &scene, const cullet_view &left, const cullet_view &right, std::vector<uint8_t> &to) const {
        detail::fill(to, [&](uint8_t *data, size_t room, size_t *count) {
            return cullet_visible_eyes(get(), scene.get(), &left, &right, data, room, count);
        });
    }
    void cull_shadow(const scene &scene, const cullet_view &camera, const cullet_shadow &shadow,
                     const cullet_settings *settings = nullptr) {
        check(cullet_cull_shadow(scene.get(), &camera, &shadow, settings, get()));
    }
    /** A cullet_light_reason for each light. */
    void lights(const scene &scene, span<const cullet_light> lights, std::vector<uint8_t> &reasons) {
        reasons.resize(lights.size());
        check(cullet_cull_lights(scene.get(), get(), lights.data(), lights.size(), reasons.data()));
    }
    /** By how many pixels levels of detail may be off; 0 where none were chosen. */
    double lod() const {
        return detail::written<double>(cullet_visible_lod, get());
    }
    void draws(const scene &scene, span<const cullet_mesh_place> places, draw_lists &to) const {
        cullet_draws arrays = to.room();
        cullet_status status = cullet_visible_draws(get(), scene.get(), places.data(), places.size(), &arrays);
        if (status == CULLET_STATUS_TOO_SMALL || (status == CULLET_STATUS_OK && !to.holds(arrays))) {
            to.grow(arrays);
            arrays = to.room();
            status = cullet_visible_draws(get(), scene.get(), places.data(), places.size(), &arrays);
        }
        check(status);
        to.shrink(arrays);
    }
    void slots(std::vector<uint32_t> &to) const {
        detail::fill(to, [&](uint32_t *data, size_t room, size_t *count) {
            return cullet_visible_slots(get(), data, room, count);
        });
    }
    void handles(const scene &scene, std::vector<cullet_handle> &to) const {
        detail::fill(to, [&](cullet_handle *data, size_t room, size_t *count) {
            return cullet_visible_handles(get(), scene.get(), data, room, count);
        });
    }
    void users(const scene &scene, std::vector<uint64_t> &to) const {
        detail::fill(to, [&](uint64_t *data, size_t room, size_t *count) {
            return cullet_visible_users(get(), scene.get(), data, room, count);
        });
    }
    void reasons(std::vector<cullet_reason> &to) const {
        detail::fill(to, [&](cullet_reason *data, size_t room, size_t *count) {
            return cullet_visible_reasons(get(), data, room, count);
        });
    }
    void funnel(std::vector<cullet_funnel_row> &to) const {
        detail::fill(to, [&](cullet_funnel_row *data, size_t room, size_t *count) {
            return cullet_visible_funnel(get(), data, room, count);
        });
    }

private:
    using owner = detail::owner<cullet_state, cullet_state_destroy>;
    owner own_;
};

/** An occlusion buffer, drawn and tested by hand. */
class occlusion {
public:
    occlusion(uint32_t width, uint32_t height)
        : own_(detail::written<cullet_occlusion>(cullet_occlusion_create, width, height)) {}
    cullet_occlusion get() const noexcept { return own_.get(); }
    void begin(const cullet_view &view) { check(cullet_occlusion_begin(get(), &view, nullptr)); }
    void draw(span<const cullet_box> boxes) {
        check(cullet_occlusion_draw_boxes(get(), boxes.data(), boxes.size(), nullptr));
    }
    void draw(span<const float> positions, span<const uint32_t> indices, bool two_sided) {
        check(cullet_occlusion_draw_triangles(get(), positions.data(), positions.size() / 3, indices.data(),
                                              indices.size(), two_sided, nullptr));
    }
    /** A cullet_found for each box. */
    void test(span<const cullet_box> boxes, std::vector<uint8_t> &results) {
        results.resize(boxes.size());
        check(cullet_occlusion_test_boxes(get(), boxes.data(), boxes.size(), results.data()));
    }

private:
    using owner = detail::owner<cullet_occlusion, cullet_occlusion_destroy>;
    owner own_;
};

/** An occluder of boxes, which must live until it is handed over. */
inline cullet_occluder occluder_of(span<const cullet_box> boxes) {
    const float *first = boxes.size() > 0 ? boxes[0].min : nullptr;
    return {CULLET_OCCLUDER_KIND_BOXES, 0, first, sizeof(cullet_box), boxes.size(), nullptr, 0, nullptr};
}

/** An occluder of triangles, three floats a vertex in a row; arrays and transform must live until it is handed over. */
inline cullet_occluder occluder_of(cullet_occluder_kind kind, span<const float> positions, span<const uint32_t> indices,
                                   const cullet_transform *transform = nullptr) {
    return {uint32_t(kind), 4, positions.data(), 12, positions.size() / 3, indices.data(), indices.size(), transform};
}

/** Boxes in, flags out: the program's own objects, culled without a scene. */
class boxes {
public:
    /** occlusion_width: see cullet_boxes_create. */
    explicit boxes(uint32_t occlusion_width = 0)
        : own_(detail::written<cullet_boxes>(cullet_boxes_create, occlusion_width)) {}
    cullet_boxes get() const noexcept { return own_.get(); }

    /** Takes boxes by members of objects, such as &object::center and &object::half: arrays or vectors of numbers. */
    template <typename T, typename V>
    void set_centers(span<const T> objects, V T::*center, V T::*half) {
        set(arrays_of(objects, center, half, CULLET_BOX_FORM_CENTER_HALF));
    }
    template <typename T, typename V>
    void set_corners(span<const T> objects, V T::*min, V T::*max) {
        set(arrays_of(objects, min, max, CULLET_BOX_FORM_MIN_MAX));
    }
    void set(span<const cullet_box> boxes) { set_corners(boxes, &cullet_box::min, &cullet_box::max); }
    void set(const cullet_box_arrays &arrays) { check(cullet_boxes_set(get(), &arrays)); }
    void update(std::size_t first, const cullet_box_arrays &arrays) {
        check(cullet_boxes_update(get(), first, &arrays));
    }
    /** Arrays over members of objects, as set and update take them. */
    template <typename T, typename V>
    static cullet_box_arrays arrays_of(span<const T> objects, V T::*a, V T::*b, cullet_box_form form) {
        cullet_box_arrays arrays{};
        if (objects.size() > 0) {
            arrays.first = &(objects[0].*a);
            arrays.second = &(objects[0].*b);
        }
        arrays.stride = sizeof(T);
        arrays.count = objects.size();
        arrays.number = detail::number_of<V>();
        arrays.form = form;
        return arrays;
    }

    void set_occluders(span<const cullet_occluder> occluders) {
        check(cullet_boxes_set_occluders(get(), occluders.data(), occluders.size()));
    }
    void set_occluders(std::initializer_list<cullet_occluder> occluders) {
        check(cullet_boxes_set_occluders(get(), occluders.begin(), occluders.size()));
    }
    void set_occluder(uint32_t number, const cullet_occluder &occluder) {
        check(cullet_boxes_set_occluder(get(), number, &occluder));
    }
    void move_occluder(uint32_t number, const cullet_transform &transform) {
        check(cullet_boxes_move_occluder(get(), number, &transform));
    }

    /** Writes a flag a box into flags, which has room for them; returns how many are 1. */
    std::size_t cull(const cullet_view &view, span<uint8_t> flags) {
        return detail::written<std::size_t>(cullet_boxes_cull, get(), &view, flags.data(), flags.size());
    }
    /** The same as bits. */
    std::size_t cull_bits(const cullet_view &view, span<uint64_t> words) {
        return detail::written<std::size_t>(cullet_boxes_cull_bits, get(), &view, words.data(), words.size());
    }

private:
    using owner = detail::owner<cullet_boxes, cullet_boxes_destroy>;
    owner own_;
};

}  // namespace cullet

#endif
