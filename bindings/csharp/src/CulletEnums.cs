// Numbers that the C library gives names: tests/Layouts.cs compares them with its header.
using System;

namespace Cullet
{
    /// <summary>How a call went. All but <c>CulletStatus.Ok</c> leave a message in
    /// <c>CulletException.Message</c>, and change nothing unless they say so.</summary>
    public enum CulletStatus : int
    {
        /// <summary>It did what it says.</summary>
        Ok = 0,

        /// <summary>A pointer is NULL that must not be.</summary>
        NullPointer = 1,

        /// <summary>A pointer is not aligned to what it points to.</summary>
        Alignment = 2,

        /// <summary>The <c>Size</c> of a struct is not the one that this library knows: it was not filled
        /// by the function that fills it, or header and library are of different versions.</summary>
        StructSize = 3,

        /// <summary>A number is outside its range, or not finite, or a text is not UTF-8.</summary>
        InvalidValue = 4,

        /// <summary>A handle is 0, so that it was never made.</summary>
        NullHandle = 5,

        /// <summary>A handle's object was destroyed.</summary>
        StaleHandle = 6,

        /// <summary>A handle is of another kind of object.</summary>
        WrongHandle = 7,

        /// <summary>Another thread is using the object in a way that excludes this call. Nothing waits; see
        /// the rules on threads.</summary>
        Busy = 8,

        /// <summary>An array is too short; the count that is needed was written.</summary>
        TooSmall = 9,

        /// <summary>A state holds no result yet, or the scene has changed since, or it is of another scene:
        /// cull again.</summary>
        NoResult = 10,

        /// <summary>An instance handle names no instance of the scene, or a mesh or a slot is not there.</summary>
        NotFound = 11,

        /// <summary>A mesh is refused: an index beyond the vertices, a position that is not finite.</summary>
        Mesh = 12,

        /// <summary>The numbers make no view.</summary>
        View = 13,

        /// <summary>A file, or the bytes of one, cannot be loaded or written, or is of another scene.</summary>
        File = 14,

        /// <summary>There are as many objects as there can be.</summary>
        Full = 15,

        /// <summary>A defect of this library: the call was stopped. The object that it was about to change
        /// can only be destroyed.</summary>
        Internal = 16,

        /// <summary>A bake ended before its end: a callback stopped it, or it was one share of several. The
        /// scene is as it was; what was finished lies in the folder of the bake, if it has one.</summary>
        Stopped = 17,

        /// <summary>It had to be called before the library allocated memory.</summary>
        TooLate = 18,
    }

    /// <summary>What the two arrays of boxes hold.</summary>
    public enum CulletBoxForm : uint
    {
        /// <summary>The lowest and the highest corner.</summary>
        MinMax = 0,

        /// <summary>The centre and half the size.</summary>
        CenterHalf = 1,
    }

    /// <summary>Kinds of lights.</summary>
    public enum CulletLightKind : uint
    {
        /// <summary>Parallel rays, as of the sun.</summary>
        Directional = 0,

        /// <summary>A light that shines all around.</summary>
        Point = 1,

        /// <summary>A light that shines into a cone.</summary>
        Spot = 2,
    }

    /// <summary>Why a light does not matter for a view.</summary>
    public enum CulletLightReason : byte
    {
        /// <summary>It may matter.</summary>
        Kept = 0,

        /// <summary>It lights nothing at all.</summary>
        Unlit = 1,

        /// <summary>What it reaches is outside the view.</summary>
        Frustum = 2,

        /// <summary>What it reaches is hidden.</summary>
        Occlusion = 3,

        /// <summary>It reaches nothing that the view was found to see.</summary>
        NoReceiver = 4,
    }

    /// <summary>Types of numbers in arrays of the caller's.</summary>
    public enum CulletNumber : uint
    {
        /// <summary><c>float</c>.</summary>
        F32 = 0,

        /// <summary><c>double</c>.</summary>
        F64 = 1,
    }

    /// <summary>Kinds of occluders.</summary>
    public enum CulletOccluderKind : uint
    {
        /// <summary>Boxes, each within what is opaque: <c>positions</c> has a lowest and a highest corner
        /// for each, six floats.</summary>
        Boxes = 0,

        /// <summary>A closed convex body, of triangles wound counter-clockwise seen from outside: the
        /// quickest kind by far for what is convex. Up to 256 corners.</summary>
        Hull = 1,

        /// <summary>Triangles that hide from their fronts alone, which are counter-clockwise.</summary>
        Triangles = 2,

        /// <summary>Triangles that hide from both sides.</summary>
        TwoSidedTriangles = 3,
    }

    /// <summary>Bounds of an instance.</summary>
    public enum CulletBounds : uint
    {
        /// <summary>The box of its mesh, transformed.</summary>
        Mesh = 0,

        /// <summary>None: it is visible to every stage but the layers.</summary>
        None = 1,

        /// <summary>A box in world space, relative to the scene's origin: what is animated, or placed by a
        /// shader.</summary>
        World = 2,

        /// <summary>The box of its mesh, grown on every side by a distance: for vertices that a shader
        /// displaces.</summary>
        Margin = 3,
    }

    /// <summary>Settings that go together. None has a stage that is lossy.</summary>
    public enum CulletPreset : uint
    {
        /// <summary>Everything that can be proved, for tools and for renderers to which a triangle costs
        /// much.</summary>
        Exact = 0,

        /// <summary>Stages that pay in most frames: the default.</summary>
        Balanced = 1,

        /// <summary>Stages that are fastest to run.</summary>
        Fast = 2,
    }

    /// <summary>How deep the answer goes.</summary>
    public enum CulletOutput : uint
    {
        /// <summary>Whole instances.</summary>
        Instances = 0,

        /// <summary>Instances, and of those that straddle the frustum or are one-sided the clusters that
        /// are left: the default.</summary>
        Clusters = 1,

        /// <summary>Triangles of every visible instance.</summary>
        Triangles = 2,
    }

    /// <summary>How back faces of one-sided meshes are culled.</summary>
    public enum CulletBackfaces : uint
    {
        /// <summary>Not at all.</summary>
        Off = 0,

        /// <summary>Clusters by cones, and where the output is triangles, each by a plane of four bytes:
        /// the default.</summary>
        Fast = 1,

        /// <summary>Every triangle from its corners, where the output is triangles: some fifty times as long.</summary>
        Exact = 2,
    }

    /// <summary>Kinds of culling, in the order in which they run.</summary>
    public enum CulletStage : uint
    {
        /// <summary>No stage: visible.</summary>
        Visible = 0,

        /// <summary>Layers that view and instance do not share.</summary>
        Layer = 1,

        /// <summary>Outside the frustum.</summary>
        Frustum = 2,

        /// <summary>Not in the potentially visible set of the eye's cell.</summary>
        Pvs = 3,

        /// <summary>Not seen through any portal.</summary>
        Portal = 4,

        /// <summary>Too small on the screen.</summary>
        Detail = 5,

        /// <summary>Another level of detail stands for it.</summary>
        Lod = 6,

        /// <summary>Behind something.</summary>
        Occlusion = 7,

        /// <summary>Seen from behind.</summary>
        Backface = 8,

        /// <summary>Without area.</summary>
        Degenerate = 9,
    }

    /// <summary>Result of a test of an occlusion buffer.</summary>
    public enum CulletFound : byte
    {
        /// <summary>It may be visible.</summary>
        Visible = 0,

        /// <summary>It is proved to be hidden.</summary>
        Hidden = 1,

        /// <summary>It is out of the view.</summary>
        Outside = 2,
    }

    /// <summary>Properties of a mesh or of a part of it.</summary>
    [Flags]
    public enum CulletMeshFlags : uint
    {
        /// <summary>None of them.</summary>
        None = 0,

        /// <summary>One-sided: only the fronts of its triangles are drawn, which are counter-clockwise.
        /// Only such meshes have back faces to cull.</summary>
        OneSided = 1,

        /// <summary>Vertices may move (skinned, morphed): give instances bounds that hold every pose, and
        /// no cluster of it is culled by itself.</summary>
        Deformable = 2,

        /// <summary>The material is cut out by a threshold: it never hides anything.</summary>
        Masked = 4,

        /// <summary>The material is blended: it never hides anything.</summary>
        Blended = 8,
    }

    /// <summary>Properties of a draw.</summary>
    [Flags]
    public enum CulletDrawState : uint
    {
        /// <summary>None of them.</summary>
        None = 0,

        /// <summary>Two sides are drawn.</summary>
        TwoSided = 1,

        /// <summary>The transform mirrors: fronts are clockwise on the screen.</summary>
        Mirrored = 2,

        /// <summary>The material is cut out by a threshold.</summary>
        Masked = 4,

        /// <summary>The material is blended: draws want an order from back to front.</summary>
        Blended = 8,
    }

    /// <summary>Properties of an instance.</summary>
    [Flags]
    public enum CulletInstanceFlags : uint
    {
        /// <summary>None of them.</summary>
        None = 0,

        /// <summary>No stage but the layers may cull it.</summary>
        AlwaysVisible = 1,

        /// <summary>It never hides anything.</summary>
        NoOcclusion = 2,

        /// <summary>Both sides of its triangles are drawn, whatever its mesh says.</summary>
        TwoSided = 4,

        /// <summary>It is blended, whatever its mesh says.</summary>
        Transparent = 8,

        /// <summary>It is going to move: a hint that keeps nodes of what stands tight.</summary>
        Dynamic = 16,
    }

    /// <summary>Which clip depth is near.</summary>
    public enum CulletDepth : uint
    {
        /// <summary>Clip depth 0 at the near plane, 1 at the far plane.</summary>
        Standard = 0,

        /// <summary>Clip depth 1 at the near plane, 0 at the far plane, which may be infinitely far.</summary>
        Reversed = 1,
    }
}
