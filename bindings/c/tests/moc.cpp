// A program that is written against masked occlusion culling, on a scene that it is written for: what is called occluded is
// held against the depth of that scene sampled more finely, and so is how much is found.
//
// moc FILE [PICTURE.pgm]: a model whose meshes hide each other, such as intel-castle.glb; and where the depth of its third view
// is to be written
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include <cullet.hpp>
#include <cullet_moc.h>

static void require(bool condition, const char *what) {
    if (condition) return;
    std::fprintf(stderr, "failed: %s (%s)\n", what, cullet_last_error());
    std::exit(1);
}

using Matrix = std::array<float, 16>;

// A quad across the screen at some depth, in clip space, and what it hides; which windings are drawn; which way is up.
static void facts() {
    MaskedOcclusionCulling *moc = MaskedOcclusionCulling::Create();
    require(moc->TestRect(-1, -1, 1, 1, 1) == MaskedOcclusionCulling::VISIBLE, "nothing is hidden without a buffer");
    require(moc->GetStatus() == CULLET_STATUS_NULL_HANDLE, "the failure is told");
    moc->SetResolution(320, 192);
    unsigned int width, height;
    moc->GetResolution(width, height);
    require(width == 320 && height == 192, "resolution");
    // x, y, z, w: the upper half of the screen at w 10, counter-clockwise.
    const float w = 10;
    const float quad[16] = {-w, 0, 0, w, w, 0, 0, w, w, w, 0, w, -w, w, 0, w};
    const unsigned int ccw[6] = {0, 1, 2, 0, 2, 3}, cw[6] = {0, 2, 1, 0, 3, 2};
    using M = MaskedOcclusionCulling;
    const auto hides = [&] { return moc->TestRect(-0.5f, 0.2f, 0.5f, 0.8f, 11) == M::OCCLUDED; };
    require(moc->RenderTriangles(quad, cw, 2) == M::VIEW_CULLED && !hides(), "clockwise ones are culled");
    require(moc->RenderTriangles(quad, ccw, 2, nullptr, M::BACKFACE_CCW) == M::VIEW_CULLED && !hides(), "ccw culled");
    require(moc->RenderTriangles(quad, ccw, 2) == M::VISIBLE && hides(), "counter-clockwise ones are drawn");
    require(moc->TestRect(-0.5f, 0.2f, 0.5f, 0.8f, 9) == M::VISIBLE, "what is nearer is visible");
    require(moc->TestRect(-0.5f, -0.8f, 0.5f, -0.2f, 11) == M::VISIBLE, "the lower half is open");
    require(moc->TestRect(1.5f, 0, 2, 1, 11) == M::VIEW_CULLED, "beyond the edge");
    require(moc->TestRect(NAN, 0, 2, 1, 11) == M::VISIBLE, "NaN is visible");
    std::vector<float> depth(320 * 192);
    moc->ComputePixelDepthBuffer(depth.data(), false);
    const size_t low = 20 * 320 + 160, high = 171 * 320 + 160;
    require(depth[low] == -1 && std::fabs(depth[high] - 0.1f) < 1e-3f && depth[high] <= 0.1f, "from the bottom");
    moc->ComputePixelDepthBuffer(depth.data(), true);
    require(depth[high] == -1 && depth[low] > 0.09f, "from the top");
    moc->ClearBuffer();
    require(!hides() && moc->RenderTriangles(quad, cw, 2, nullptr, M::BACKFACE_CCW) == M::VISIBLE && hides(), "cw drawn");
    moc->ClearBuffer();
    require(moc->RenderTriangles(quad, cw, 2, nullptr, M::BACKFACE_NONE) == M::VISIBLE && hides(), "both are drawn");
    // The same by a matrix, of a model's x, y, z, tightly packed; and mirrored, which turns the windings.
    for (const float mirror : {1.0f, -1.0f}) {
        const float model[12] = {-1 * mirror, 0, 0, 1 * mirror, 0, 0, 1 * mirror, 1, 0, -1 * mirror, 1, 0};
        const Matrix flat = {w * mirror, 0, 0, 0, 0, w, 0, 0, 0, 0, 1, 0, 0, 0, 0, w};
        const Matrix deep = {w * mirror, 0, 0, 0, 0, w, 0, 0, 0, 0, 1, -1, 0, 0, 0, w};
        for (const Matrix &clip : {flat, deep}) {
        moc->ClearBuffer();
        const M::VertexLayout packed(12, 4, 8);
        require(moc->RenderTriangles(model, ccw, 2, clip.data(), M::BACKFACE_CW, M::CLIP_PLANE_ALL, packed) == M::VISIBLE,
                "drawn by a matrix");
        require(hides(), "hidden by what was drawn by a matrix");
        const float behind[12] = {-0.5f, 0.2f, 12, 0.5f, 0.2f, 12, 0.5f, 0.8f, 12, -0.5f, 0.8f, 12};
        const unsigned int *turned = mirror > 0 ? ccw : cw;
        const Matrix farther = {12 * mirror, 0, 0, 0, 0, 12, 0, 0, 0, 0, 1, 0, 0, 0, 0, 12};
        require(moc->TestTriangles(behind, turned, 2, farther.data(), M::BACKFACE_CW, M::CLIP_PLANE_ALL, packed) ==
                    M::OCCLUDED, "triangles behind");
        const Matrix nearer = {8 * mirror, 0, 0, 0, 0, 8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 8};
        require(moc->TestTriangles(behind, turned, 2, nearer.data(), M::BACKFACE_CW, M::CLIP_PLANE_ALL, packed) ==
                    M::VISIBLE, "triangles before");
        }
    }
    M::Destroy(moc);
}

struct Object {
    std::vector<float> clip;  // x, y, z, w
    const std::vector<unsigned int> *indices;
    float x[2], y[2], w;      // its rectangle
    bool bounded;
};

// Depth by samples: scale * scale a pixel, nearest 1 / w, no culling.
static void sample(const Object &object, int width, int height, std::vector<double> &nearest) {
    for (size_t t = 0; t + 2 < object.indices->size(); t += 3) {
        const float *v[3];
        bool in_front = true;
        for (int i = 0; i < 3; i++) {
            v[i] = &object.clip[(*object.indices)[t + i] * 4];
            in_front &= v[i][3] > 1e-3f;
        }
        if (!in_front) continue;  // Samples that are missing make the check of what is hidden harder, not easier.
        double x[3], y[3], n[3];
        for (int i = 0; i < 3; i++) {
            n[i] = 1.0 / v[i][3];
            x[i] = (v[i][0] * n[i] + 1) * 0.5 * width;
            y[i] = (v[i][1] * n[i] + 1) * 0.5 * height;
        }
        const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        if (!(area > 0)) continue;  // Clockwise on the screen, as they are culled where they are drawn.
        const auto clamp = [](double value, int most) { return int(std::min(std::max(value, 0.0), double(most))); };
        const int x0 = clamp(std::floor(std::min({x[0], x[1], x[2]})), width - 1);
        const int x1 = clamp(std::ceil(std::max({x[0], x[1], x[2]})), width - 1);
        const int y0 = clamp(std::floor(std::min({y[0], y[1], y[2]})), height - 1);
        const int y1 = clamp(std::ceil(std::max({y[0], y[1], y[2]})), height - 1);
        for (int py = y0; py <= y1; py++)
            for (int px = x0; px <= x1; px++) {
                double b[3];
                bool inside = true;
                for (int i = 0; i < 3; i++) {
                    const int j = (i + 1) % 3, k = (i + 2) % 3;
                    b[i] = ((x[j] - px - 0.5) * (y[k] - py - 0.5) - (x[k] - px - 0.5) * (y[j] - py - 0.5)) / area;
                    inside &= b[i] >= 0;
                }
                if (!inside) continue;
                double &at = nearest[size_t(py) * width + px];
                at = std::max(at, b[0] * n[0] + b[1] * n[1] + b[2] * n[2]);
            }
    }
}

// Processor time of a view: all objects drawn, then each tested by its rectangle; the least of some turns.
static void costs(const std::vector<Object> &objects) {
    MaskedOcclusionCulling *moc = MaskedOcclusionCulling::Create();
    moc->SetResolution(1280, 720);
    moc->SetNearClipPlane(0.1f);
    const auto now = [] { return 1e3 * double(std::clock()) / CLOCKS_PER_SEC; };
    double first = 0, draw = INFINITY, test = INFINITY;
    size_t triangles = 0, hidden = 0;
    for (int turn = 0; turn < 30; turn++) {
        const double start = now();
        moc->ClearBuffer();
        triangles = 0;
        for (const Object &object : objects) {
            const int count = int(object.indices->size() / 3);
            moc->RenderTriangles(object.clip.data(), object.indices->data(), count);
            triangles += size_t(count);
        }
        const double drawn = now();
        for (const Object &o : objects)
            hidden += moc->TestRect(o.x[0], o.y[0], o.x[1], o.y[1], o.w) == MaskedOcclusionCulling::OCCLUDED;
        const double tested = now();
        if (turn == 0) first = drawn - start;
        draw = std::min(draw, drawn - start);
        test = std::min(test, tested - drawn);
    }
    require(hidden > 0, "something is hidden");
    std::printf("1280 x 720: %zu triangles of %zu meshes in %.2f ms (the first time %.2f), a rectangle in %.0f ns\n", triangles,
                objects.size(), draw, first, 1e6 * test / double(objects.size()));
    MaskedOcclusionCulling::Destroy(moc);
}

// Near is bright, and what nothing covers is black.
static void picture(const MaskedOcclusionCulling &moc, unsigned int width, unsigned int height, const char *path) {
    std::vector<float> depth(size_t(width) * height);
    moc.ComputePixelDepthBuffer(depth.data(), true);
    std::FILE *file = std::fopen(path, "wb");
    require(file != nullptr, "the picture is written");
    std::fprintf(file, "P5 %u %u 255\n", width, height);
    for (const float near : depth)
        std::fputc(near > 0 ? int(std::min(255.0f, 40 + 215 * std::sqrt(std::min(1.0f, near * 8)))) : 0, file);
    std::fclose(file);
}

int main(int argc, char **argv) {
    facts();
    if (argc < 2) {
        std::printf("skipped: no model was named\n");
        return 0;
    }
    cullet::scene scene = cullet::scene::open(argv[1]);
    const cullet_scene_info info = scene.info();
    std::vector<std::vector<float>> positions(info.mesh_count);
    std::vector<std::vector<unsigned int>> indices(info.mesh_count);
    for (uint32_t mesh = 0; mesh < info.mesh_count; mesh++) {
        cullet_mesh_info of;
        cullet::check(cullet_scene_mesh_info(scene.get(), mesh, &of));
        positions[mesh].resize(of.position_count * 3);
        indices[mesh].resize(of.index_count);
        cullet::check(cullet_scene_mesh_read(scene.get(), mesh, positions[mesh].data(), positions[mesh].size(),
                                             indices[mesh].data(), indices[mesh].size()));
    }
    const unsigned int width = 320, height = 192;
    const int fine = 3;
    MaskedOcclusionCulling *moc = MaskedOcclusionCulling::Create();
    moc->SetResolution(width, height);
    moc->SetNearClipPlane(0.1f);
    // Where things are: some reach far beyond the others.
    std::vector<double> places[3];
    for (uint32_t slot = 0; slot < info.slot_count; slot++) {
        cullet_instance at;
        cullet_mesh_info of;
        if (cullet_scene_instance(scene.get(), slot, &at, nullptr) != CULLET_STATUS_OK) continue;
        cullet::check(cullet_scene_mesh_info(scene.get(), at.mesh, &of));
        for (int r = 0; r < 3; r++) {
            double p = at.transform.translation[r];
            for (int c = 0; c < 3; c++) p += at.transform.linear[c * 3 + r] * 0.5 * (double(of.min[c]) + of.max[c]);
            places[r].push_back(p);
        }
    }
    double centre[3], half[3];
    for (int a = 0; a < 3; a++) {
        std::sort(places[a].begin(), places[a].end());
        const size_t count = places[a].size();
        centre[a] = places[a][count / 2];
        half[a] = 0.5 * (places[a][count * 3 / 4] - places[a][count / 4]);
    }
    size_t tested = 0, occluded = 0, possible = 0, of_triangles = 0;
    for (int number = 0; number < 4; number++) {
        const double angle = 1.5707963 * number + 0.4;
        const std::array<double, 3> eye = {centre[0] + half[0] * 1.2 * std::cos(angle), centre[1],
                                           centre[2] + half[2] * 1.2 * std::sin(angle)};
        const cullet_view view =
            cullet::look_at(eye, {centre[0], centre[1], centre[2]}, 1.0, 0.1, width, height);
        std::vector<Object> objects;
        moc->ClearBuffer();
        for (uint32_t slot = 0; slot < info.slot_count; slot++) {
            cullet_instance at;
            if (cullet_scene_instance(scene.get(), slot, &at, nullptr) != CULLET_STATUS_OK) continue;
            double clip[16];
            for (int c = 0; c < 4; c++)
                for (int r = 0; r < 4; r++) {
                    clip[c * 4 + r] = c == 3 ? view.clip_from_world[12 + r] : 0;
                    for (int k = 0; k < 3; k++)
                        clip[c * 4 + r] += view.clip_from_world[k * 4 + r] *
                                           (c == 3 ? at.transform.translation[k] : double(at.transform.linear[c * 3 + k]));
                }
            Object object = {{}, &indices[at.mesh], {INFINITY, -INFINITY}, {INFINITY, -INFINITY}, INFINITY, true};
            const std::vector<float> &from = positions[at.mesh];
            for (size_t v = 0; v < from.size(); v += 3) {
                float to[4];
                for (int r = 0; r < 4; r++)
                    to[r] = float(clip[r] * from[v] + clip[4 + r] * from[v + 1] + clip[8 + r] * from[v + 2] + clip[12 + r]);
                object.clip.insert(object.clip.end(), to, to + 4);
                object.bounded &= to[3] > 0.1f;
                for (int a = 0; a < 2; a++) {
                    float *range = a == 0 ? object.x : object.y;
                    range[0] = std::min(range[0], to[a] / to[3]);
                    range[1] = std::max(range[1], to[a] / to[3]);
                }
                object.w = std::min(object.w, to[3]);
            }
            if (!object.clip.empty()) objects.push_back(std::move(object));
        }
        std::vector<double> nearest(size_t(width) * fine * height * fine, 0.0);
        for (const Object &object : objects) {
            moc->RenderTriangles(object.clip.data(), object.indices->data(), int(object.indices->size() / 3));
            sample(object, int(width) * fine, int(height) * fine, nearest);
        }
        if (number == 2) costs(objects);
        if (argc > 2 && number == 2) picture(*moc, width, height, argv[2]);
        for (const Object &object : objects) {
            if (!object.bounded) continue;
            const auto found = moc->TestRect(object.x[0], object.y[0], object.x[1], object.y[1], object.w);
            if (found == MaskedOcclusionCulling::VIEW_CULLED) continue;
            tested++;
            // Each sample within its rectangle must be nearer than all of it.
            const auto edge = [&](float ndc, unsigned int pixels) { return (double(ndc) + 1) * 0.5 * pixels * fine - 0.5; };
            const int x0 = std::max(0, int(std::ceil(edge(object.x[0], width))));
            const int x1 = std::min(int(width) * fine - 1, int(std::floor(edge(object.x[1], width))));
            const int y0 = std::max(0, int(std::ceil(edge(object.y[0], height))));
            const int y1 = std::min(int(height) * fine - 1, int(std::floor(edge(object.y[1], height))));
            bool hidden = true;
            for (int y = y0; y <= y1; y++)
                for (int x = x0; x <= x1; x++)
                    hidden &= nearest[size_t(y) * width * fine + x] > 1.0 / object.w * (1 - 1e-6);
            possible += hidden;
            const bool is = found == MaskedOcclusionCulling::OCCLUDED;
            occluded += is;
            require(!is || hidden, "a sample is seen of what was called occluded");
            const auto finer = moc->TestTriangles(object.clip.data(), object.indices->data(),
                                                  int(object.indices->size() / 3));
            of_triangles += finer == MaskedOcclusionCulling::OCCLUDED;
            require(!is || finer != MaskedOcclusionCulling::VISIBLE, "triangles are hidden where their rectangle is");
        }
    }
    require(moc->GetStatus() == CULLET_STATUS_OK, "no call failed");
    std::printf("%zu rectangles: %zu occluded, %zu by samples; by triangles %zu\n", tested, occluded, possible, of_triangles);
    require(tested > 500 && occluded * 2 > possible && possible > 200, "at least half of what samples allow is found");
    MaskedOcclusionCulling::Destroy(moc);
}
