// Bakes, for libraries that are built with them: CULLET_FEATURES=scenes,files,queries,bake.
using System;
using System.Runtime.ExceptionServices;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>Threads, progress and units of a bake. Nothing of it changes what is baked.</summary>
    public sealed class CulletBakeOptions
    {
        /// <summary>Threads that work, up to 1024; they end before the call does.</summary>
        public int Threads = 1;

        /// <summary>Number of this share of the work, from 0 and below <see cref="ShareCount"/>.</summary>
        public int Share;

        /// <summary>Shares that the work is split into, each a call on any machine with the same folder and scene; 0
        /// for all of it. Such a call throws with <see cref="CulletStatus.Stopped"/> once its share lies in the folder
        /// and others are missing.</summary>
        public int ShareCount;

        /// <summary>Folder for finished units, so that a bake goes on after a stop; null for none.</summary>
        public string Folder;

        /// <summary>Called after each unit of work with the share that is done, 0 to 1; returns whether to go on.
        /// Called on threads of the bake, by one at a time. An exception stops the bake, which throws it. Null for
        /// none.</summary>
        public Func<double, bool> Step;
    }

    /// <summary>Settings of visible sets. 0 takes the default of each.</summary>
    public sealed class CulletPvsSettings
    {
        /// <summary>Boxes to make view cells in, in world space; null for the bounds of the scene.</summary>
        public CulletEyeBox[] Boxes;

        /// <summary>Whether the boxes are the view cells themselves; then <see cref="Cells"/> and <see cref="Grid"/>
        /// are 0.</summary>
        public bool BoxesAreCells;

        /// <summary>How many view cells to make, small ones where geometry is near; default 500.</summary>
        public uint Cells;

        /// <summary>In place of that: equal cells, so many along each axis of the one box.</summary>
        public CulletUInt3 Grid;

        /// <summary>The most rays to trace.</summary>
        public ulong Rays;

        /// <summary>Seed of the rays; default 1.</summary>
        public ulong Seed;

        /// <summary>The bake ends earlier where the mean share of looks that are estimated to miss something is at most
        /// this; default 0.00002. Below 0 to use all rays.</summary>
        public double Missing;

        /// <summary>Things that could appear wider than this are kept, met by a ray or not: in radians, up to pi, the
        /// default.</summary>
        public double KeepAngle;

        /// <summary>View cells get the sets of others within this distance, in world units; default none.</summary>
        public double Join;
    }

    /// <summary>Bakes levels, occluders, cells and visible sets. A library without them throws an
    /// <see cref="EntryPointNotFoundException"/>. A bake that is stopped throws with <see cref="CulletStatus.Stopped"/>
    /// and leaves the scene as it was.</summary>
    public static unsafe class CulletBake
    {
        /// <summary>Bakes levels of detail of every mesh; returns how many have some. Commit the scene
        /// afterwards.</summary>
        public static uint Levels(CulletScene scene, CulletBakeOptions options = null)
        {
            uint count = 0;
            uint* to = &count;
            Run(scene, options, given => cullet_bake_levels(HandleOf(scene), (cullet_bake_options*)given, to));
            return count;
        }

        /// <summary>Bakes occluders of every mesh and gives them to meshes, to all of them or where they save time;
        /// returns how many took theirs.</summary>
        public static uint Occluders(CulletScene scene, bool always = false, CulletBakeOptions options = null)
        {
            uint taken = 0;
            uint* to = &taken;
            Run(scene, options, given => cullet_bake_occluders(
                HandleOf(scene), always ? 1u : 0u, (cullet_bake_options*)given, to));
            return taken;
        }

        /// <summary>Finds rooms and openings in the triangles of a scene, and gives it these cells; returns how many
        /// there are. A voxel of 0 finds its own side. <paramref name="ignored"/> are instances that hide nothing
        /// because they move. The work has no units: leave the folder null.</summary>
        public static uint Cells(
            CulletScene scene, double voxel = 0, CulletHandle[] ignored = null, CulletBakeOptions options = null)
        {
            uint count = 0;
            uint* to = &count;
            fixed (CulletHandle* all = ignored)
            {
                var settings = new cullet_cells_settings { voxel = voxel, ignored = all };
                if (ignored != null) settings.ignored_count = Size(ignored.Length);
                cullet_cells_settings* set = &settings;
                Run(scene, options, given => cullet_bake_cells(
                    HandleOf(scene), set, (cullet_bake_options*)given, to));
            }
            return count;
        }

        /// <summary>Bakes visible sets of a scene: of its own cells where it has some and the settings ask for no view
        /// cells, else of instances seen from view cells, found by rays.</summary>
        public static CulletPvs Sets(
            CulletScene scene, CulletPvsSettings settings = null, CulletBakeOptions options = null)
        {
            cullet_pvs made;
            CulletPvsSettings of = settings ?? new CulletPvsSettings();
            fixed (CulletEyeBox* boxes = of.Boxes)
            {
                var raw = new cullet_pvs_settings
                {
                    boxes = boxes,
                    box_count = Size(of.Boxes == null ? 0 : of.Boxes.Length),
                    boxes_are_cells = of.BoxesAreCells ? 1u : 0u,
                    cells = of.Cells,
                    grid = of.Grid,
                    rays = of.Rays,
                    seed = of.Seed,
                    missing = of.Missing,
                    keep_angle = of.KeepAngle,
                    join = of.Join
                };
                cullet_pvs_settings* set = &raw;
                cullet_pvs* to = &made;
                Run(scene, options, given => cullet_bake_pvs(
                    HandleOf(scene), set, (cullet_bake_options*)given, to));
            }
            return new CulletPvs(made.id);
        }

        /// <summary>Writes a scene to a file; with <paramref name="original"/>, a GLB is that glTF file with what was
        /// baked added.</summary>
        public static void Save(CulletScene scene, string path, string original = null)
        {
            fixed (byte* to = Utf8(path, nameof(path)))
            fixed (byte* from = original == null ? null : Utf8(original, nameof(original)))
                CulletLibrary.Check(cullet_scene_save(HandleOf(scene), to, from));
            GC.KeepAlive(scene);
        }

        static cullet_scene HandleOf(CulletScene scene) => new cullet_scene { id = IdOf(scene, nameof(scene)) };

        /// <summary>Calls a bake with options as C has them, or with none.</summary>
        static void Run(CulletScene scene, CulletBakeOptions options, Func<IntPtr, CulletStatus> bake)
        {
            CulletBakeOptions of = options ?? new CulletBakeOptions();
            var heard = new Heard { Step = of.Step };
            GCHandle context = GCHandle.Alloc(heard);
            try
            {
                fixed (byte* folder = of.Folder == null ? null : Utf8(of.Folder, nameof(options)))
                {
                    var raw = new cullet_bake_options
                    {
                        threads = (uint)of.Threads,
                        share = (uint)of.Share,
                        share_count = (uint)of.ShareCount,
                        folder = (IntPtr)folder,
                        step = of.Step == null ? IntPtr.Zero : CallPointer,
                        context = (void*)GCHandle.ToIntPtr(context)
                    };
                    CulletStatus status = bake((IntPtr)(&raw));
                    heard.Thrown?.Throw();
                    CulletLibrary.Check(status);
                }
            }
            finally
            {
                context.Free();
                GC.KeepAlive(scene);
            }
        }

        sealed class Heard
        {
            internal Func<double, bool> Step;
            internal ExceptionDispatchInfo Thrown;
        }

        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        delegate uint StepCall(void* context, double share);

        // Kept for ever, as the pointer to it is.
        static readonly StepCall Call = OnStep;
        static readonly IntPtr CallPointer = Marshal.GetFunctionPointerForDelegate(Call);

        /// <summary>Passes progress on. No exception may leave it: below is the library.</summary>
        [MonoPInvokeCallback(typeof(StepCall))]
        static uint OnStep(void* context, double share)
        {
            var heard = (Heard)GCHandle.FromIntPtr((IntPtr)context).Target;
            try
            {
                return heard.Step(share) ? 1u : 0u;
            }
            catch (Exception error)
            {
                heard.Thrown = ExceptionDispatchInfo.Capture(error);
                return 0;
            }
        }

        /// <summary>IL2CPP looks for an attribute of this name on what C calls.</summary>
        [AttributeUsage(AttributeTargets.Method)]
        sealed class MonoPInvokeCallbackAttribute : Attribute
        {
            internal MonoPInvokeCallbackAttribute(Type type) => Type = type;

            internal Type Type { get; }
        }
    }
}
