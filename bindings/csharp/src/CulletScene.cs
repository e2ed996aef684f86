// A scene: meshes and instances, and the questions that are asked of it.
using System;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>A scene of meshes and instances. Several threads may cull it side by side, each with a state of its
    /// own.</summary>
    public sealed unsafe class CulletScene : CulletObject
    {
        /// <summary>Makes an empty scene.</summary>
        public CulletScene()
        {
            cullet_scene made;
            CulletLibrary.Check(cullet_scene_create(&made));
            Take(made.id);
        }

        CulletScene(ulong id) => Take(id);

        /// <summary>Opens a file: glTF and GLB, baked or not, OBJ, PLY, STL, OFF, maps of Quake. The scene is
        /// committed; its instances have the handles 0, 1, 2, ... of generation 0.</summary>
        public static CulletScene Open(string path)
        {
            cullet_scene made;
            fixed (byte* text = Utf8(path, nameof(path))) CulletLibrary.Check(cullet_open(text, &made));
            return new CulletScene(made.id);
        }

        internal override CulletStatus Destroy(ulong id) => cullet_scene_destroy(new cullet_scene { id = id });

        cullet_scene Handle => new cullet_scene { id = Id };

        /// <summary>Adds a mesh of three floats a vertex and three indices a triangle, and returns its number. Without
        /// parts it is one, with these flags and this material.</summary>
        public uint AddMesh(
            ReadOnlySpan<float> positions, ReadOnlySpan<uint> indices, CulletMeshFlags flags = CulletMeshFlags.None,
            uint material = 0, ReadOnlySpan<CulletPart> parts = default(ReadOnlySpan<CulletPart>))
        {
            int vertices = Vertices(positions.Length, nameof(positions));
            uint mesh;
            fixed (float* corners = &MemoryMarshal.GetReference(positions))
            fixed (uint* faces = &MemoryMarshal.GetReference(indices))
            fixed (CulletPart* ranges = &MemoryMarshal.GetReference(parts))
            {
                var arrays = new cullet_mesh_arrays
                {
                    positions = corners,
                    position_count = Size(vertices),
                    indices = faces,
                    index_count = Size(indices.Length),
                    parts = parts.Length == 0 ? null : ranges,
                    part_count = Size(parts.Length),
                    flags = (uint)flags,
                    material = material
                };
                Check(cullet_scene_add_mesh(Handle, &arrays, &mesh));
            }
            return mesh;
        }

        /// <summary>Returns how large a mesh is.</summary>
        public CulletMeshInfo MeshInfo(uint mesh)
        {
            CulletMeshInfo info;
            Check(cullet_scene_mesh_info(Handle, mesh, &info));
            return info;
        }

        /// <summary>Writes the geometry of a mesh in the order that draws count in: upload these indices. An empty span
        /// leaves one of them out.</summary>
        public void ReadMesh(uint mesh, Span<float> positions, Span<uint> indices)
        {
            fixed (float* corners = &MemoryMarshal.GetReference(positions))
            fixed (uint* faces = &MemoryMarshal.GetReference(indices))
                Check(cullet_scene_mesh_read(
                    Handle, mesh, positions.Length == 0 ? null : corners, Size(positions.Length),
                    indices.Length == 0 ? null : faces, Size(indices.Length)));
        }

        /// <summary>Adds instances, all or none, and writes a handle for each, unless that span is empty. Commit before
        /// culling where many were added.</summary>
        public void Add(ReadOnlySpan<CulletInstance> instances, Span<CulletHandle> handles)
        {
            if (handles.Length != 0) Room(instances.Length, handles.Length, nameof(handles));
            fixed (CulletInstance* all = &MemoryMarshal.GetReference(instances))
            fixed (CulletHandle* made = &MemoryMarshal.GetReference(handles))
                Check(cullet_scene_add(Handle, all, Size(instances.Length), handles.Length == 0 ? null : made));
        }

        /// <summary>Adds an instance and returns its handle.</summary>
        public CulletHandle Add(in CulletInstance instance)
        {
            CulletInstance copy = instance;
            CulletHandle handle;
            Check(cullet_scene_add(Handle, &copy, Size(1), &handle));
            return handle;
        }

        /// <summary>Removes instances, all or none; their handles are stale from then on.</summary>
        public void Remove(ReadOnlySpan<CulletHandle> handles)
        {
            fixed (CulletHandle* all = &MemoryMarshal.GetReference(handles))
                Check(cullet_scene_remove(Handle, all, Size(handles.Length)));
        }

        /// <summary>Removes an instance.</summary>
        public void Remove(CulletHandle handle) => Check(cullet_scene_remove(Handle, &handle, Size(1)));

        /// <summary>Moves instances, all or none: a transform for each handle. The next cull is right at once, and
        /// faster after <see cref="Refit"/>.</summary>
        public void SetTransforms(ReadOnlySpan<CulletHandle> handles, ReadOnlySpan<CulletTransform> transforms)
        {
            SameLength(handles.Length, transforms.Length, nameof(transforms));
            fixed (CulletHandle* all = &MemoryMarshal.GetReference(handles))
            fixed (CulletTransform* values = &MemoryMarshal.GetReference(transforms))
                Check(cullet_scene_set_transforms(Handle, all, values, Size(handles.Length)));
        }

        /// <summary>Moves an instance.</summary>
        public void SetTransform(CulletHandle handle, CulletTransform transform) =>
            Check(cullet_scene_set_transforms(Handle, &handle, &transform, Size(1)));

        /// <summary>Sets the layers of instances, all or none: a mask for each handle.</summary>
        public void SetLayers(ReadOnlySpan<CulletHandle> handles, ReadOnlySpan<uint> layers)
        {
            SameLength(handles.Length, layers.Length, nameof(layers));
            fixed (CulletHandle* all = &MemoryMarshal.GetReference(handles))
            fixed (uint* values = &MemoryMarshal.GetReference(layers))
                Check(cullet_scene_set_layers(Handle, all, values, Size(handles.Length)));
        }

        /// <summary>Sets the flags of instances, all or none: flags for each handle.</summary>
        public void SetFlags(ReadOnlySpan<CulletHandle> handles, ReadOnlySpan<CulletInstanceFlags> flags)
        {
            SameLength(handles.Length, flags.Length, nameof(flags));
            fixed (CulletHandle* all = &MemoryMarshal.GetReference(handles))
            fixed (CulletInstanceFlags* values = &MemoryMarshal.GetReference(flags))
                Check(cullet_scene_set_flags(Handle, all, (uint*)values, Size(handles.Length)));
        }

        /// <summary>Gives an instance the bounds of its mesh again, or none: then every stage but the layers keeps it.
        /// </summary>
        public void SetBounds(CulletHandle handle, CulletBounds bounds)
        {
            // The others have numbers.
            if (bounds != CulletBounds.Mesh && bounds != CulletBounds.None)
                throw new ArgumentException("bounds must be Mesh or None: the others have numbers", nameof(bounds));
            Check(cullet_scene_set_bounds(Handle, handle, (uint)bounds, null));
        }

        /// <summary>Gives an instance a box in world space, relative to the scene's origin.</summary>
        public void SetBounds(CulletHandle handle, CulletBox box) =>
            Check(cullet_scene_set_bounds(Handle, handle, (uint)CulletBounds.World, (float*)&box));

        /// <summary>Gives an instance the box of its mesh, grown on every side by a distance, from 0.</summary>
        public void SetBounds(CulletHandle handle, float margin) =>
            Check(cullet_scene_set_bounds(Handle, handle, (uint)CulletBounds.Margin, &margin));

        /// <summary>Sorts the slots by place and prepares new meshes. Call it after loading, and after large
        /// changes.</summary>
        public void Commit() => Check(cullet_scene_commit(Handle));

        /// <summary>Fits the nodes of the hierarchy to what moved: makes the next cull faster, never
        /// different.</summary>
        public void Refit() => Check(cullet_scene_refit(Handle));

        /// <summary>Returns the contents of the scene. Cost: linear in its instances.</summary>
        public CulletSceneInfo Info()
        {
            CulletSceneInfo info;
            Check(cullet_scene_get_info(Handle, &info));
            return info;
        }

        /// <summary>Returns the slot of an instance: the index of arrays by slot, until the next commit.</summary>
        public uint Slot(CulletHandle handle)
        {
            uint slot;
            Check(cullet_scene_slot(Handle, handle, &slot));
            return slot;
        }

        /// <summary>Returns the instance of a slot, and its handle.</summary>
        public CulletInstance Instance(uint slot, out CulletHandle handle)
        {
            CulletInstance instance;
            CulletHandle found;
            Check(cullet_scene_instance(Handle, slot, &instance, &found));
            handle = found;
            return instance;
        }

        /// <summary>Returns why an instance is drawn or culled: its reason, and a line for each stage. For tools: it
        /// may cull the whole scene twice. Without settings they are those of the preset Balanced.</summary>
        public string Explain(
            in CulletView view, CulletHandle handle, out CulletReason reason, CulletSettings? settings = null)
        {
            CulletView seen = view;
            CulletSettings set = settings.GetValueOrDefault();
            CulletSettings* given = settings.HasValue ? &set : null;
            CulletReason why;
            UIntPtr length;
            Check(cullet_explain(Handle, &seen, given, handle, &why, null, Size(0), &length));
            var text = new byte[(int)length];
            fixed (byte* bytes = text)
            {
                Check(cullet_explain(Handle, &seen, given, handle, &why, bytes, length, null));
                reason = why;
                return Text(bytes);
            }
        }

        /// <summary>Finds what blocks lines of sight, and writes a result for each segment. Exact.</summary>
        public void LinesOfSight(
            ReadOnlySpan<CulletSegment> segments, Span<CulletSight> results, CulletSightOptions? options = null)
        {
            Room(segments.Length, results.Length, nameof(results));
            CulletSightOptions set = options.GetValueOrDefault();
            fixed (CulletSegment* all = &MemoryMarshal.GetReference(segments))
            fixed (CulletSight* found = &MemoryMarshal.GetReference(results))
                Check(cullet_lines_of_sight(
                    Handle, all, Size(segments.Length), options.HasValue ? &set : null, found));
        }

        /// <summary>Tests for each box of <paramref name="to"/> whether all of it is proved to be hidden from all of
        /// the box <paramref name="from"/>, relative to the scene's origin.</summary>
        public void BoxToBox(
            CulletBox from, ReadOnlySpan<CulletBox> to, Span<CulletFound> results,
            CulletBoxSightOptions? options = null)
        {
            Room(to.Length, results.Length, nameof(results));
            CulletBoxSightOptions set = options.GetValueOrDefault();
            fixed (CulletBox* all = &MemoryMarshal.GetReference(to))
            fixed (CulletFound* found = &MemoryMarshal.GetReference(results))
                Check(cullet_box_to_box(
                    Handle, &from, all, Size(to.Length), options.HasValue ? &set : null, (byte*)found));
        }

        /// <summary>Returns the levels of detail of a mesh: of its file, made by <see cref="AddLod"/>, or baked. The
        /// first is number 1 in <see cref="CulletDrawKey.Level"/>.</summary>
        public CulletLevels[] Levels(uint mesh)
        {
            UIntPtr count;
            Check(cullet_scene_levels(Handle, mesh, null, Size(0), &count));
            var levels = new CulletLevels[(int)count];
            fixed (CulletLevels* all = levels) Check(cullet_scene_levels(Handle, mesh, all, count, &count));
            return levels;
        }

        /// <summary>Gives a mesh a coarser one to be drawn in its place where the eye is far enough. No point of either
        /// may be farther than <paramref name="error"/> from the surface of the other, in units of the mesh. Commit the
        /// scene before culling.</summary>
        public void AddLod(uint mesh, uint coarse, float error) =>
            Check(cullet_scene_add_lod(Handle, mesh, coarse, error));

        /// <summary>Takes all levels of a mesh away. Meshes that held them stay in the scene.</summary>
        public void ClearLevels(uint mesh) => Check(cullet_scene_clear_levels(Handle, mesh));

        /// <summary>Gives meshes the occluders that the scene's file brought, to all of them or where they save time;
        /// returns how many took theirs.</summary>
        public uint TakeOccluders(bool always = false)
        {
            uint given;
            Check(cullet_scene_take_occluders(Handle, always ? 1u : 0u, &given));
            return given;
        }

        /// <summary>Culls by visible sets from now on where <see cref="CulletSettings.Pvs"/> is 1 and the eye is in one
        /// of their cells; null for no more. They are copied. Throws with <see cref="CulletStatus.File"/> where they
        /// are of another scene.</summary>
        public void SetPvs(CulletPvs sets) =>
            Check(cullet_scene_set_pvs(Handle, sets == null ? default(cullet_pvs) : sets.Handle), sets);

        /// <summary>Returns the cell of a point; <c>uint.MaxValue</c> where it is in none, or the scene has
        /// none.</summary>
        public uint CellOf(CulletDouble3 point)
        {
            uint cell;
            Check(cullet_scene_cell_of(Handle, (double*)&point, &cell));
            return cell;
        }
    }
}
