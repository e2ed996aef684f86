// Culling, and reading what came of it.
using System;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>What a shadow map is culled for.</summary>
    public struct CulletShadow
    {
        /// <summary>The light.</summary>
        public CulletLight Light;

        /// <summary>The view that the shadow map is drawn with; null where it is not known yet.</summary>
        public CulletView? Map;

        /// <summary>The state of the camera's own cull of the scene as it is: then only what casts a shadow on what
        /// that found visible is kept. Null for shadows on any place that the camera shows.</summary>
        public CulletState Receivers;

        /// <summary>Shadows may be wrong by so much to every side, in world units; at least 0.</summary>
        public double Margin;

        /// <summary>Where a cascade of the camera begins. Both 0 for all of what the camera sees.</summary>
        public double SliceNear;

        /// <summary>Where the cascade ends; positive infinity in perspective for no end.</summary>
        public double SliceFar;
    }

    /// <summary>The state of a view: what it remembers between frames, and its last result. Make one for each view that
    /// is culled frame after frame. Where settings are left out they are those of the preset Balanced.</summary>
    public sealed unsafe class CulletState : CulletObject
    {
        /// <summary>Makes the state of a view.</summary>
        public CulletState()
        {
            cullet_state made;
            CulletLibrary.Check(cullet_state_create(&made));
            Take(made.id);
        }

        internal override CulletStatus Destroy(ulong id) => cullet_state_destroy(new cullet_state { id = id });

        internal cullet_state Handle => new cullet_state { id = Id };

        static cullet_scene HandleOf(CulletScene scene) => new cullet_scene { id = IdOf(scene, nameof(scene)) };

        /// <summary>Culls a scene for a view. What the view sees is never culled, but for lossy settings. Allocates
        /// nothing once the state has grown.</summary>
        public void Cull(CulletScene scene, in CulletView view, CulletSettings? settings = null)
        {
            CulletView seen = view;
            CulletSettings set = settings.GetValueOrDefault();
            Check(cullet_cull(HandleOf(scene), &seen, settings.HasValue ? &set : null, Handle), scene);
        }

        /// <summary>Culls among candidates: bit s mod 64 of word s / 64 is that of slot s. All others are culled after
        /// the frustum.</summary>
        public void CullAmong(
            CulletScene scene, in CulletView view, ReadOnlySpan<ulong> words, CulletSettings? settings = null)
        {
            CulletView seen = view;
            CulletSettings set = settings.GetValueOrDefault();
            fixed (ulong* all = &MemoryMarshal.GetReference(words))
                Check(
                    cullet_cull_among(
                        HandleOf(scene), &seen, settings.HasValue ? &set : null, all, Size(words.Length), Handle),
                    scene);
        }

        /// <summary>Culls once for both eyes of a headset: what either sees stays.</summary>
        public void CullStereo(
            CulletScene scene, in CulletView left, in CulletView right, CulletSettings? settings = null)
        {
            CulletView one = left, other = right;
            CulletSettings set = settings.GetValueOrDefault();
            Check(
                cullet_cull_stereo(HandleOf(scene), &one, &other, settings.HasValue ? &set : null, Handle), scene);
        }

        /// <summary>Culls for a light: what must be drawn into its shadow map so that the camera's picture has its
        /// shadows. Take a state for each light and each cascade.</summary>
        public void CullShadow(
            CulletScene scene, in CulletView camera, in CulletShadow shadow, CulletSettings? settings = null)
        {
            CulletView seen = camera, map = shadow.Map.GetValueOrDefault();
            CulletSettings set = settings.GetValueOrDefault();
            var raw = new cullet_shadow
            {
                light = shadow.Light,
                map = shadow.Map.HasValue ? &map : null,
                margin = shadow.Margin,
                slice_near = shadow.SliceNear,
                slice_far = shadow.SliceFar
            };
            if (shadow.Receivers != null) raw.receivers = shadow.Receivers.Handle;
            Check(
                cullet_cull_shadow(HandleOf(scene), &seen, &raw, settings.HasValue ? &set : null, Handle), scene,
                shadow.Receivers);
        }

        /// <summary>Finds the lights that can change the picture of this state's last <see cref="Cull"/>, and writes
        /// why each of the others cannot.</summary>
        public void CullLights(
            CulletScene scene, ReadOnlySpan<CulletLight> lights, Span<CulletLightReason> reasons)
        {
            Room(lights.Length, reasons.Length, nameof(reasons));
            fixed (CulletLight* all = &MemoryMarshal.GetReference(lights))
            fixed (CulletLightReason* found = &MemoryMarshal.GetReference(reasons))
                Check(cullet_cull_lights(HandleOf(scene), Handle, all, Size(lights.Length), (byte*)found), scene);
        }

        /// <summary>How many instances are visible.</summary>
        public int VisibleCount
        {
            get
            {
                UIntPtr count;
                Check(cullet_visible_slots(Handle, null, Size(0), &count));
                return (int)count;
            }
        }

        /// <summary>By how many pixels the surfaces of the last result may be off, for their levels of detail; 0 where
        /// none were chosen.</summary>
        public double LodPixels
        {
            get
            {
                double pixels;
                Check(cullet_visible_lod(Handle, &pixels));
                return pixels;
            }
        }

        /// <summary>Writes the slots of which something is visible, ascending, and returns how many there are. Throws
        /// with <see cref="CulletStatus.TooSmall"/> where there is no room; the instances of the scene are always
        /// enough.</summary>
        public int VisibleSlots(Span<uint> slots)
        {
            UIntPtr count;
            // A capacity of 0 asks for the count alone, and is no mistake.
            if (slots.Length == 0) return Empty(VisibleCount, nameof(slots));
            fixed (uint* all = &MemoryMarshal.GetReference(slots))
                Check(cullet_visible_slots(Handle, all, Size(slots.Length), &count));
            return (int)count;
        }

        /// <summary>Writes the handles of what is visible, in the order of the slots.</summary>
        public int VisibleHandles(CulletScene scene, Span<CulletHandle> handles)
        {
            UIntPtr count;
            fixed (CulletHandle* all = &MemoryMarshal.GetReference(handles))
                Check(
                    cullet_visible_handles(
                        Handle, HandleOf(scene), handles.Length == 0 ? null : all, Size(handles.Length), &count),
                    scene);
            return handles.Length == 0 ? Empty((int)count, nameof(handles)) : (int)count;
        }

        /// <summary>Writes your own numbers of what is visible, in the order of the slots.</summary>
        public int VisibleUsers(CulletScene scene, Span<ulong> users)
        {
            UIntPtr count;
            fixed (ulong* all = &MemoryMarshal.GetReference(users))
                Check(
                    cullet_visible_users(
                        Handle, HandleOf(scene), users.Length == 0 ? null : all, Size(users.Length), &count),
                    scene);
            return users.Length == 0 ? Empty((int)count, nameof(users)) : (int)count;
        }

        /// <summary>Writes which eye may see each visible slot: bit 0 for left, bit 1 for right. The views are those of
        /// <see cref="CullStereo"/>.</summary>
        public int VisibleEyes(CulletScene scene, in CulletView left, in CulletView right, Span<byte> eyes)
        {
            CulletView one = left, other = right;
            UIntPtr count;
            fixed (byte* all = &MemoryMarshal.GetReference(eyes))
                Check(
                    cullet_visible_eyes(
                        Handle, HandleOf(scene), &one, &other, eyes.Length == 0 ? null : all, Size(eyes.Length),
                        &count),
                    scene);
            return eyes.Length == 0 ? Empty((int)count, nameof(eyes)) : (int)count;
        }

        /// <summary>Writes why each slot was culled, one for each slot of the scene; none unless
        /// <see cref="CulletSettings.Reasons"/> was 1. Returns how many there are.</summary>
        public int VisibleReasons(Span<CulletReason> reasons)
        {
            UIntPtr count;
            fixed (CulletReason* all = &MemoryMarshal.GetReference(reasons))
                Check(cullet_visible_reasons(
                    Handle, reasons.Length == 0 ? null : all, Size(reasons.Length), &count));
            return reasons.Length == 0 ? Empty((int)count, nameof(reasons)) : (int)count;
        }

        /// <summary>Returns the counts in and out of each stage that ran. Allocates: it is for tools.</summary>
        public CulletFunnelRow[] Funnel()
        {
            var rows = new CulletFunnelRow[32];
            UIntPtr count;
            fixed (CulletFunnelRow* all = rows) Check(cullet_visible_funnel(Handle, all, Size(32), &count));
            Array.Resize(ref rows, (int)count);
            return rows;
        }

        /// <summary>Writes the draws of the last result into arrays that grow as they must. <paramref name="places"/>
        /// says where your buffers hold meshes 0, 1, ...; a mesh beyond them counts from its own first index.</summary>
        public void Draws(
            CulletScene scene, CulletDraws draws,
            ReadOnlySpan<CulletMeshPlace> places = default(ReadOnlySpan<CulletMeshPlace>))
        {
            if (draws == null) throw new ArgumentNullException(nameof(draws));
            // The counts of the first try are those that the second needs.
            if (Fill(scene, draws, places) == CulletStatus.TooSmall) Check(Fill(scene, draws, places), scene);
        }

        CulletStatus Fill(CulletScene scene, CulletDraws draws, ReadOnlySpan<CulletMeshPlace> places)
        {
            fixed (CulletMeshPlace* meshes = &MemoryMarshal.GetReference(places))
            fixed (CulletDrawCommand* commands = draws.commands)
            fixed (CulletDrawKey* keys = draws.keys)
            fixed (uint* instances = draws.instances, indices = draws.indices)
            {
                var raw = new cullet_draws
                {
                    commands = commands,
                    keys = keys,
                    command_capacity = Size(draws.commands.Length),
                    instances = instances,
                    instance_capacity = Size(draws.instances.Length),
                    indices = indices,
                    index_capacity = Size(draws.indices.Length)
                };
                CulletStatus status =
                    cullet_visible_draws(Handle, HandleOf(scene), meshes, Size(places.Length), &raw);
                bool asked = draws.commands.Length == 0 && draws.instances.Length == 0 && draws.indices.Length == 0;
                // All capacities 0 ask for the counts, and are no mistake.
                if (status == CulletStatus.Ok && asked && (ulong)raw.command_count != 0) status = CulletStatus.TooSmall;
                if (status == CulletStatus.TooSmall || status == CulletStatus.Ok)
                    draws.Take((int)raw.command_count, (int)raw.instance_count, (int)raw.index_count);
                else
                    Check(status, scene);
                GC.KeepAlive(scene);
                return status;
            }
        }

        /// <summary>Refuses no room where there is something.</summary>
        static int Empty(int count, string name)
        {
            Room(count, 0, name);
            return 0;
        }
    }

    /// <summary>Indexed indirect draws, as graphics interfaces read them. Keep it from frame to frame: it allocates
    /// only to grow.</summary>
    public sealed class CulletDraws
    {
        internal CulletDrawCommand[] commands = new CulletDrawCommand[0];
        internal CulletDrawKey[] keys = new CulletDrawKey[0];
        internal uint[] instances = new uint[0];
        internal uint[] indices = new uint[0];
        int commandCount, instanceCount, indexCount;

        /// <summary>The commands: opaque ones first, then by material and mesh.</summary>
        public ReadOnlySpan<CulletDrawCommand> Commands =>
            new ReadOnlySpan<CulletDrawCommand>(commands, 0, commandCount);

        /// <summary>The properties of each command.</summary>
        public ReadOnlySpan<CulletDrawKey> Keys => new ReadOnlySpan<CulletDrawKey>(keys, 0, commandCount);

        /// <summary>Slots: the instances of each command are a range of them.</summary>
        public ReadOnlySpan<uint> Instances => new ReadOnlySpan<uint>(instances, 0, instanceCount);

        /// <summary>Indices to be uploaded with the commands where the output is triangles; none else.</summary>
        public ReadOnlySpan<uint> Indices => new ReadOnlySpan<uint>(indices, 0, indexCount);

        /// <summary>Takes counts, and grows arrays that are too short for them, whose contents are lost.</summary>
        internal void Take(int commandsNow, int instancesNow, int indicesNow)
        {
            commandCount = commandsNow;
            instanceCount = instancesNow;
            indexCount = indicesNow;
            Grow(ref commands, commandsNow);
            Grow(ref keys, commandsNow);
            Grow(ref instances, instancesNow);
            Grow(ref indices, indicesNow);
        }

        static void Grow<T>(ref T[] array, int count)
        {
            if (array.Length < count) array = new T[count + count / 4];
        }
    }
}
