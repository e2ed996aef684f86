// Levels of detail, visible sets and bakes, as the header of the C library (bindings/c/include/cullet.h) declares and
// explains them. Bakes are in libraries that are built with them alone: CULLET_FEATURES=scenes,files,queries,bake.
using System;
using System.Runtime.InteropServices;

namespace Cullet
{
    /// <summary>Levels of detail of a mesh: one chain of whole meshes, or one hierarchy of clusters.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletLevels
    {
        /// <summary>The mesh of the scene that holds the triangles of all its levels.</summary>
        public uint Mesh;

        /// <summary>Steps of simplification: of a chain its levels.</summary>
        public uint GroupCount;

        /// <summary>Triangles of all levels together.</summary>
        public ulong TriangleCount;

        /// <summary>The least distance from the original surface of a step, in units of the mesh.</summary>
        public float LeastError;

        /// <summary>The largest.</summary>
        public float MostError;
    }

    /// <summary>Kinds of items that visible sets hold.</summary>
    public enum CulletPvsTargets : uint
    {
        /// <summary>Cells of the scene. Conservative, and true of whatever moves.</summary>
        Cells = 0,

        /// <summary>Instances, by the index of their handles, seen from view cells. Found by sampled lines, so
        /// that something may be missing.</summary>
        Instances = 1,
    }

    /// <summary>Contents of visible sets.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletPvsInfo
    {
        /// <summary>Cells that there is a set of.</summary>
        public uint CellCount;

        /// <summary>Items that the sets may hold: cells, or instances.</summary>
        public uint TargetCount;

        /// <summary>The kind of items.</summary>
        public CulletPvsTargets Targets;

        uint reserved;

        /// <summary>Rays that were traced for them; 0 for sets of cells.</summary>
        public ulong Rays;

        /// <summary>Share of looks that are estimated to end on something that its set lacks, 0 to 1: the mean
        /// over the cells.</summary>
        public double MeanMissing;

        /// <summary>The same of the cell where it is largest.</summary>
        public double MostMissing;
    }

    /// <summary>Three whole numbers.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CulletUInt3
    {
        /// <summary>Each number.</summary>
        public uint X, Y, Z;
    }

    public static unsafe partial class CulletNative
    {
        /// <summary>Handle of potentially visible sets: what may be seen from each of some cells. A plain
        /// number: copy it freely; 0 is none.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_pvs
        {
            public ulong id;
        }

        /// <summary>Threads, progress and units of a bake. Set it to zero before its fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_bake_options
        {
            public uint threads;
            public uint share;
            public uint share_count;
            public uint reserved;
            public IntPtr folder;
            public IntPtr step;
            public void* context;
        }

        /// <summary>Settings of visible sets. Set them to zero before their fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_pvs_settings
        {
            public CulletEyeBox* boxes;
            public UIntPtr box_count;
            public uint boxes_are_cells;
            public uint cells;
            public CulletUInt3 grid;
            public uint reserved;
            public ulong rays;
            public ulong seed;
            public double missing;
            public double keep_angle;
            public double join;
        }

        /// <summary>Settings of cells that are found. Set them to zero before their fields.</summary>
        [StructLayout(LayoutKind.Sequential)]
        public struct cullet_cells_settings
        {
            public double voxel;
            public CulletHandle* ignored;
            public UIntPtr ignored_count;
        }

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_levels(
            cullet_scene scene, uint mesh, CulletLevels* levels, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_add_lod(cullet_scene scene, uint mesh, uint coarse, float error);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_clear_levels(cullet_scene scene, uint mesh);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_visible_lod(cullet_state state, double* pixels);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_take_occluders(cullet_scene scene, uint always, uint* given);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_open(byte* path, cullet_pvs* pvs);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_read(byte* bytes, UIntPtr size, cullet_pvs* pvs);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_write(cullet_pvs pvs, byte* bytes, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_destroy(cullet_pvs pvs);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_get_info(cullet_pvs pvs, CulletPvsInfo* info);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_cells(
            cullet_pvs pvs, CulletEyeBox* boxes, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_missing(cullet_pvs pvs, float* shares, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_cell_of(cullet_pvs pvs, double* points, UIntPtr count, uint* cells);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_pvs_visible(
            cullet_pvs pvs, uint* cells, UIntPtr cell_count, uint* targets, UIntPtr capacity, UIntPtr* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_set_pvs(cullet_scene scene, cullet_pvs pvs);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_bake_occluders(
            cullet_scene scene, uint always, cullet_bake_options* options, uint* given);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_bake_levels(cullet_scene scene, cullet_bake_options* options, uint* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_bake_pvs(
            cullet_scene scene, cullet_pvs_settings* settings, cullet_bake_options* options, cullet_pvs* pvs);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_bake_cells(
            cullet_scene scene, cullet_cells_settings* settings, cullet_bake_options* options, uint* count);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern CulletStatus cullet_scene_save(cullet_scene scene, byte* path, byte* original);
    }
}
