// Types of the C library's header that are plain numbers, field for field: tests/Layouts.cs compares sizes and offsets.
using System;
using System.Runtime.InteropServices;

#pragma warning disable 169, 649 // Fields that only the library reads or writes.

namespace Cullet
{
    /// <summary>A view: what a camera sees, and how. Filled by <c>FromMatrix</c>, <c>FromCamera</c> or
    /// <c>LookAt</c>; then its last three fields may be changed.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletView
    {
        uint size;

        /// <summary><c>CulletDepth.Standard</c> or <c>CulletDepth.Reversed</c>.</summary>
        public CulletDepth Depth;

        /// <summary>World to clip space, column-major.</summary>
        public CulletMatrix ClipFromWorld;

        /// <summary>Width of the viewport in pixels, 1 to 65536.</summary>
        public uint Width;

        /// <summary>Height of the viewport in pixels, 1 to 65536.</summary>
        public uint Height;

        /// <summary>Layers that it sees; all of them at first.</summary>
        public uint Layers;

        /// <summary>1 where fronts are clockwise; 0 at first.</summary>
        public uint Clockwise;

        /// <summary>Faces of one-sided meshes that are not drawn: 0 none, 1 the backs, 2 the fronts, as
        /// some shadow passes do; 1 at first.</summary>
        public uint CullFace;

        uint reserved;
    }

    /// <summary>An affine transform: x becomes linear * x + translation. Mirrored and singular ones too; one
    /// that is not finite keeps its instance visible.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletTransform
    {
        /// <summary>The columns of the linear part, one after another.</summary>
        public CulletLinear Linear;

        /// <summary>The translation; double, so that worlds of 1e7 units stay right.</summary>
        public CulletDouble3 Translation;
    }

    /// <summary>Settings of culling. Filled by <c>Preset</c>; then any field may be changed. Switches are 0 or
    /// 1.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletSettings
    {
        uint size;

        /// <summary>Cull what is outside the frustum.</summary>
        public uint Frustum;

        /// <summary>An exact test for each box that straddles the frustum: drops big boxes near its corners.</summary>
        public uint FrustumExact;

        /// <summary>Cull by the potentially visible sets of a scene that has some.</summary>
        public uint Pvs;

        /// <summary>Cull by the cells and portals of a scene that has some.</summary>
        public uint Portals;

        /// <summary>A <c>CulletBackfaces</c>.</summary>
        public CulletBackfaces Backfaces;

        /// <summary>Cull triangles without area.</summary>
        public uint Degenerate;

        /// <summary>Cull what lies behind other instances.</summary>
        public uint Occlusion;

        /// <summary>Pixels across the occlusion buffer, 1 to 4096, at most the viewport's. More sees
        /// smaller gaps, and costs its square.</summary>
        public uint OcclusionWidth;

        /// <summary>Budget for drawing occluders, in microseconds of a cost model, from 0.</summary>
        public float OcclusionBudget;

        /// <summary>Share of the cost of drawing what is left that may be spent where nothing is found,
        /// from 0; below 0 for no limit.</summary>
        public float OcclusionRisk;

        /// <summary>Lossy: cull what is narrower and lower than so many pixels. 0, the default, culls
        /// nothing for its size.</summary>
        public float DetailPixels;

        /// <summary>Lossy: draw levels of detail that are off by at most so many pixels, in scenes that
        /// have levels. 0, the default, draws everything in full.</summary>
        public float LodPixels;

        /// <summary>A <c>CulletOutput</c>.</summary>
        public CulletOutput Output;

        /// <summary>Record why each instance was culled, for <c>CulletState.VisibleReasons</c>: two bytes a
        /// slot. 0 by default.</summary>
        public uint Reasons;

        /// <summary>Lossy: a budget for levels of detail, in triangles; 0, the default, for none. Where more
        /// would be drawn, <c>LodPixels</c> is raised until they are not, as far as there are levels.</summary>
        public uint LodTriangles;
    }

    /// <summary>Handle of an instance in its scene: stays the same until the instance is removed.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletHandle
    {
        /// <summary>Index, from 0 in the order in which instances are added, used again after a removal.</summary>
        public uint Index;

        /// <summary>How often that index was used before.</summary>
        public uint Generation;
    }

    /// <summary>Why an instance was culled.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletReason
    {
        byte stage;

        /// <summary>The stage, a <c>CulletStage</c>; 0 for one that is visible.</summary>
        public CulletStage Stage => (CulletStage)stage;

        /// <summary>For the frustum the number of the plane that it is outside of; 255 where parts went for
        /// different ones.</summary>
        public byte Detail;
    }

    /// <summary>A range of a mesh's triangles with one material.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletPart
    {
        /// <summary>First triangle of the range.</summary>
        public uint FirstTriangle;

        /// <summary>How many triangles.</summary>
        public uint TriangleCount;

        /// <summary>A number of the caller's for the material; draws are sorted by it.</summary>
        public uint Material;

        /// <summary><c>CulletMeshFlags.OneSided</c>, <c>CulletMeshFlags.Masked</c>,
        /// <c>CulletMeshFlags.Blended</c>.</summary>
        public CulletMeshFlags Flags;
    }

    /// <summary>How large a mesh of a scene is.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletMeshInfo
    {
        UIntPtr position_count;

        /// <summary>Vertices.</summary>
        public int PositionCount => checked((int)position_count);

        UIntPtr index_count;

        /// <summary>Indices: three a triangle, degenerate triangles included.</summary>
        public int IndexCount => checked((int)index_count);

        UIntPtr part_count;

        /// <summary>Parts.</summary>
        public int PartCount => checked((int)part_count);

        UIntPtr cluster_count;

        /// <summary>Clusters: what culling finer than instances takes as a whole.</summary>
        public int ClusterCount => checked((int)cluster_count);

        /// <summary>The lowest corner of its box.</summary>
        public CulletFloat3 Min;

        /// <summary>The highest corner of its box.</summary>
        public CulletFloat3 Max;
    }

    /// <summary>A box: its lowest and its highest corner.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletBox
    {
        /// <summary>The lowest corner.</summary>
        public CulletFloat3 Min;

        /// <summary>The highest corner.</summary>
        public CulletFloat3 Max;
    }

    /// <summary>Two points in world space: from where one looks, and what is looked at.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletSegment
    {
        /// <summary>The start.</summary>
        public CulletDouble3 From;

        /// <summary>The end.</summary>
        public CulletDouble3 To;
    }

    /// <summary>Settings of lines of sight. Their default is 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletSightOptions
    {
        /// <summary>Layers that do not block, as bits; an instance that is in others too does.</summary>
        public uint IgnoredLayers;

        /// <summary>1 where both sides of one-sided triangles block; 0 for the side that is drawn.</summary>
        public uint BothSides;

        /// <summary>1 for any blocker, which ends the search as soon as there is one; 0 for the nearest.</summary>
        public uint Any;

        /// <summary>How many of <c>Ignored</c> are there, up to 2.</summary>
        public uint IgnoredCount;

        /// <summary>Instances that do not block, such as who looks and who is looked at. One that names
        /// nothing is no error.</summary>
        public CulletHandlePair Ignored;
    }

    /// <summary>Result for one line of sight.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletSight
    {
        /// <summary>1 where something opaque blocks; 0 where nothing is known to, and then all else is 0.</summary>
        public uint Blocked;

        /// <summary>Slot of the blocker.</summary>
        public uint Slot;

        /// <summary>Handle of the blocker.</summary>
        public CulletHandle Handle;

        /// <summary>Triangle of the blocker, as numbered in the mesh that was added.</summary>
        public uint Triangle;

        uint reserved;

        /// <summary>How far along the way it is crossed, from 0 at the start to 1 at the end.</summary>
        public double Share;

        /// <summary>Where, in world space.</summary>
        public CulletDouble3 Point;
    }

    /// <summary>Settings of <c>CulletScene.BoxToBox</c>. Their default is 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletBoxSightOptions
    {
        /// <summary>Layers that hide nothing, as bits; an instance that is in others too does.</summary>
        public uint IgnoredLayers;

        /// <summary>How often boxes may be halved, 0 to 16, to find a proof for each half: several
        /// occluders may hide together what none hides alone.</summary>
        public uint Splits;

        uint reserved;
    }

    /// <summary>All eyes in a box, in world space. A point is a box too; one whose <c>Min</c> is above its
    /// <c>Max</c> has no eye; where a number is not finite, eyes may be anywhere.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletEyeBox
    {
        /// <summary>The lowest corner.</summary>
        public CulletDouble3 Min;

        /// <summary>The highest corner.</summary>
        public CulletDouble3 Max;
    }

    /// <summary>Settings of region queries. 0 takes the default of
    /// each.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletRegionSettings
    {
        /// <summary>Longest side of the cells that the box is cut into, in world units; default 2.
        /// Occluders lose half of it on every side. A smaller one drops more, and costs with its third
        /// power.</summary>
        public double CellWorld;

        /// <summary>The farthest that a point of a view's near rectangle is from its eye; default 0.25.</summary>
        public double NearWorld;

        /// <summary>No more cells than this; default 64. Cost is in proportion.</summary>
        public uint MostCells;

        /// <summary>Pixels across each of the six squares that are looked at, 8 to 4096; default 512.</summary>
        public uint Width;

        /// <summary>No more occluders than this; default 2048.</summary>
        public uint MostBodies;

        /// <summary>Layers that the eyes do not see, as bits. Not read where there is a view, which has its
        /// own.</summary>
        public uint IgnoredLayers;

        uint reserved;
    }

    /// <summary>Numbers of instances, of their clusters and of their triangles.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletCounts
    {
        /// <summary>Instances.</summary>
        public ulong Instances;

        /// <summary>Clusters.</summary>
        public ulong Clusters;

        /// <summary>Triangles.</summary>
        public ulong Triangles;
    }

    /// <summary>Counts of one stage at one unit; what leaves a row enters the next.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletFunnelRow
    {
        /// <summary>A <c>CulletStage</c>.</summary>
        public CulletStage Stage;

        /// <summary>Unit that it tested: 0 instances, 1 clusters, 2 triangles.</summary>
        public uint Unit;

        /// <summary>Counts in.</summary>
        public CulletCounts Entered;

        /// <summary>Counts out.</summary>
        public CulletCounts Left;
    }

    /// <summary>Where the renderer's buffers hold a mesh.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletMeshPlace
    {
        /// <summary>Where its indices begin.</summary>
        public uint FirstIndex;

        /// <summary>Where its vertices begin.</summary>
        public int BaseVertex;
    }

    /// <summary>One indexed indirect draw, as Vulkan, Direct3D 12, Metal and WebGPU read it: 20 bytes.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletDrawCommand
    {
        /// <summary>How many indices.</summary>
        public uint IndexCount;

        /// <summary>How many instances.</summary>
        public uint InstanceCount;

        /// <summary>First index, in the order of <c>CulletScene.ReadMesh</c>, plus the place of the mesh.</summary>
        public uint FirstIndex;

        /// <summary>Added to each index.</summary>
        public int BaseVertex;

        /// <summary>First entry of <c>Instances</c>.</summary>
        public uint FirstInstance;
    }

    /// <summary>Properties of a draw command: the same for all its instances.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletDrawKey
    {
        /// <summary><c>CulletDrawState.TwoSided</c> and so on.</summary>
        public CulletDrawState State;

        /// <summary>The material.</summary>
        public uint Material;

        /// <summary>The mesh.</summary>
        public uint Mesh;

        /// <summary>The part of the mesh.</summary>
        public uint Part;

        /// <summary>The level of detail.</summary>
        public uint Level;
    }

    /// <summary>An instance to add: a mesh with a transform.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletInstance
    {
        /// <summary>Where it is.</summary>
        public CulletTransform Transform;

        /// <summary>Number of its mesh.</summary>
        public uint Mesh;

        /// <summary>Bits of the layers that it is in; a view sees it where they share a bit. 0 is in none,
        /// so never drawn.</summary>
        public uint Layers;

        /// <summary><c>CulletInstanceFlags.AlwaysVisible</c> and so on.</summary>
        public CulletInstanceFlags Flags;

        uint reserved;

        /// <summary>A number of the caller's, such as an entity or an index;
        /// <c>CulletState.VisibleUsers</c> gives it back.</summary>
        public ulong User;
    }

    /// <summary>Contents of a scene.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletSceneInfo
    {
        /// <summary>Instances.</summary>
        public uint InstanceCount;

        /// <summary>Slots, empty ones included: how long an array by slot must be.</summary>
        public uint SlotCount;

        /// <summary>Meshes.</summary>
        public uint MeshCount;

        uint reserved;

        /// <summary>Triangles of all instances.</summary>
        public ulong TriangleCount;

        /// <summary>Rises whenever a commit put instances into other slots.</summary>
        public ulong OrderVersion;

        /// <summary>The point that boxes in world space are relative to: zero, but for files far from it.</summary>
        public CulletDouble3 Origin;

        /// <summary>The lowest corner of the box around all instances, relative to <c>Origin</c>; above
        /// <c>Max</c> for none.</summary>
        public CulletFloat3 Min;

        /// <summary>The highest corner.</summary>
        public CulletFloat3 Max;
    }

    /// <summary>A light that casts shadows, in world space. Numbers that make no light keep every caster.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletLight
    {
        /// <summary>A <c>CulletLightKind</c>.</summary>
        public CulletLightKind Kind;

        uint reserved;

        /// <summary>Where it is; not read for a directional light.</summary>
        public CulletDouble3 Position;

        /// <summary>The way the light travels, of any length above 0; not read for a point light.</summary>
        public CulletDouble3 Direction;

        /// <summary>How far it reaches, in world units: positive infinity for no limit; one that is not above
        /// 0 lights nothing. Not read for a directional light.</summary>
        public double Range;

        /// <summary>Spot: the angle between the axis and the side of the cone, in radians.</summary>
        public double HalfAngle;
    }

    /// <summary>A camera. Right-handed, looking along <c>Direction</c>.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public partial struct CulletCamera
    {
        /// <summary>Where it stands.</summary>
        public CulletDouble3 Eye;

        /// <summary>Where it looks; of any length above 0.</summary>
        public CulletDouble3 Direction;

        /// <summary>Up; not along <c>Direction</c>.</summary>
        public CulletDouble3 Up;

        /// <summary>Perspective: the full vertical field of view in radians, above 0 and below pi. 0 for an
        /// orthographic camera.</summary>
        public double FovY;

        /// <summary>Orthographic: height of what it sees, in units of the scene. Not read in perspective.</summary>
        public double Height;

        /// <summary>Width over height of what it sees; 0 takes that of the viewport.</summary>
        public double Aspect;

        /// <summary>Distance of the near plane: above 0 in perspective.</summary>
        public double NearPlane;

        /// <summary>Distance of the far plane, beyond the near one; positive infinity in perspective for
        /// none.</summary>
        public double FarPlane;
    }
}
