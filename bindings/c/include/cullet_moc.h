/** Masked occlusion culling's interface over cullet's occlusion buffer: programs that are written against the class
 * MaskedOcclusionCulling include this header in place of MaskedOcclusionCulling.h and link cullet.
 *
 * Vertices are x, y, w of clip space, or with a matrix x, y, z of a model; depth is 1 / w; normalised device coordinates have
 * y upward. What differs: OCCLUDED is proved for every point of a pixel and not for its middle, so that nothing is hidden
 * that is seen through a gap narrower than a pixel, and less is found. All clip planes are always taken into account, and
 * TestTriangles tests the rectangle and the nearest corner of each triangle. Not there: bins (BinTriangles,
 * RenderTrilist), MergeBuffer, statistics, the choice of a SIMD level. An object is to be used by one thread at a time. */
#ifndef CULLET_MOC_H
#define CULLET_MOC_H

#include <new>

#include "cullet.h"

class MaskedOcclusionCulling {
public:
    enum CullingResult { VISIBLE = 0x0, OCCLUDED = 0x1, VIEW_CULLED = 0x3 };

    enum BackfaceWinding { BACKFACE_NONE = 0, BACKFACE_CW = 1, BACKFACE_CCW = 2 };

    enum ClipPlanes {
        CLIP_PLANE_NONE = 0x00,
        CLIP_PLANE_NEAR = 0x01,
        CLIP_PLANE_LEFT = 0x02,
        CLIP_PLANE_RIGHT = 0x04,
        CLIP_PLANE_BOTTOM = 0x08,
        CLIP_PLANE_TOP = 0x10,
        CLIP_PLANE_SIDES = CLIP_PLANE_LEFT | CLIP_PLANE_RIGHT | CLIP_PLANE_BOTTOM | CLIP_PLANE_TOP,
        CLIP_PLANE_ALL = CLIP_PLANE_SIDES | CLIP_PLANE_NEAR
    };

    /** Bytes from vertex to vertex, from x to y, and from x to z or w. */
    struct VertexLayout {
        VertexLayout() {}
        VertexLayout(int stride, int offsetY, int offsetZW)
            : mStride(stride), mOffsetY(offsetY), mOffsetW(offsetZW) {}
        int mStride = 16;
        int mOffsetY = 4;
        union {
            int mOffsetZ;
            int mOffsetW = 12;
        };
    };

    /** A new object without a buffer; nullptr where there is no memory. */
    static MaskedOcclusionCulling *Create() { return new (std::nothrow) MaskedOcclusionCulling; }

    static void Destroy(MaskedOcclusionCulling *moc) { delete moc; }

    /** Width and height in pixels, 1 to 4096; they need not be multiples of anything. Empties the buffer. */
    void SetResolution(unsigned int width, unsigned int height) {
        Forget();
        Checked(cullet_occlusion_create(width, height, &mBuffer));
        mWidth = mBuffer.id != 0 ? width : 0;
        mHeight = mBuffer.id != 0 ? height : 0;
        ClearBuffer();
    }

    void GetResolution(unsigned int &width, unsigned int &height) const {
        width = mWidth;
        height = mHeight;
    }

    /** Distance of the near plane as a w, from the next ClearBuffer on; 0.001 where it is smaller, as at first. */
    void SetNearClipPlane(float nearDist) { mNear = nearDist; }

    float GetNearClipPlane() const { return mNear; }

    void ClearBuffer() { Checked(cullet_clip_begin(mBuffer, mNear)); }

    /** Draws occluders. VIEW_CULLED where none of them can be seen. */
    CullingResult RenderTriangles(const float *inVtx, const unsigned int *inTris, int nTris,
                                  const float *modelToClipMatrix = nullptr, BackfaceWinding bfWinding = BACKFACE_CW,
                                  ClipPlanes clipPlaneMask = CLIP_PLANE_ALL,
                                  const VertexLayout &vtxLayout = VertexLayout(16, 4, 12)) {
        (void)clipPlaneMask;
        const cullet_clip_triangles all = Triangles(inVtx, inTris, nTris, modelToClipMatrix, bfWinding, vtxLayout);
        uint32_t found = CULLET_FOUND_VISIBLE;
        Checked(cullet_clip_draw(mBuffer, &all, &found));
        return Result(found);
    }

    /** Tests a rectangle in normalised device coordinates, as near as wmin. */
    CullingResult TestRect(float xmin, float ymin, float xmax, float ymax, float wmin) const {
        uint32_t found = CULLET_FOUND_VISIBLE;
        Checked(cullet_clip_test_rect(mBuffer, xmin, ymin, xmax, ymax, wmin, &found));
        return Result(found);
    }

    CullingResult TestTriangles(const float *inVtx, const unsigned int *inTris, int nTris,
                                const float *modelToClipMatrix = nullptr, BackfaceWinding bfWinding = BACKFACE_CW,
                                ClipPlanes clipPlaneMask = CLIP_PLANE_ALL,
                                const VertexLayout &vtxLayout = VertexLayout(16, 4, 12)) {
        (void)clipPlaneMask;
        const cullet_clip_triangles all = Triangles(inVtx, inTris, nTris, modelToClipMatrix, bfWinding, vtxLayout);
        uint32_t found = CULLET_FOUND_VISIBLE;
        Checked(cullet_clip_test_triangles(mBuffer, &all, &found));
        return Result(found);
    }

    /** 1 / w that covers all of each pixel, row by row from the bottom, from the top with flipY; -1 where nothing does. */
    void ComputePixelDepthBuffer(float *depthData, bool flipY = false) const {
        const size_t width = mWidth, height = mHeight, count = width * height;
        if (!Checked(cullet_occlusion_read(mBuffer, depthData, count))) return;
        for (size_t at = 0; at < count; at++)
            if (depthData[at] == 0.0f) depthData[at] = -1.0f;
        for (size_t y = 0; !flipY && y < height / 2; y++)
            for (size_t x = 0; x < width; x++) {
                float &a = depthData[y * width + x], &b = depthData[(height - 1 - y) * width + x];
                const float was = a;
                a = b;
                b = was;
            }
    }

    /** The status of the last call that failed; CULLET_STATUS_OK where none did. What fails keeps everything visible. */
    cullet_status GetStatus() const { return mStatus; }

    MaskedOcclusionCulling(const MaskedOcclusionCulling &) = delete;
    MaskedOcclusionCulling &operator=(const MaskedOcclusionCulling &) = delete;

private:
    MaskedOcclusionCulling() {}
    ~MaskedOcclusionCulling() { Forget(); }

    void Forget() {
        if (mBuffer.id != 0) cullet_occlusion_destroy(mBuffer);
        mBuffer.id = 0;
    }

    bool Checked(cullet_status status) const {
        if (status != CULLET_STATUS_OK) mStatus = status;
        return status == CULLET_STATUS_OK;
    }

    static CullingResult Result(uint32_t found) {
        return found == CULLET_FOUND_HIDDEN ? OCCLUDED : found == CULLET_FOUND_OUTSIDE ? VIEW_CULLED : VISIBLE;
    }

    static cullet_clip_triangles Triangles(const float *vertices, const unsigned int *indices, int count,
                                           const float *matrix, BackfaceWinding winding, const VertexLayout &layout) {
        static_assert(sizeof(unsigned int) == sizeof(uint32_t), "indices have 32 bits");
        cullet_clip_triangles all = {};
        all.vertices = vertices;
        all.stride = (size_t)layout.mStride;
        all.offset_y = (size_t)layout.mOffsetY;
        all.offset_zw = (size_t)layout.mOffsetW;
        all.indices = reinterpret_cast<const uint32_t *>(indices);
        all.triangle_count = count > 0 ? (size_t)count : 0;
        all.clip_from_model = matrix;
        all.cull_winding = (uint32_t)winding;
        return all;
    }

    cullet_occlusion mBuffer = {0};
    float mNear = 0.0f;
    unsigned int mWidth = 0, mHeight = 0;
    mutable cullet_status mStatus = CULLET_STATUS_OK;
};

#endif
