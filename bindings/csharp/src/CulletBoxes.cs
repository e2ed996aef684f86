// Boxes in, flags out: your own objects, with no scene.
using System;
using System.Reflection;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>Where the boxes are in structs of your own.</summary>
    public readonly struct CulletBoxLayout
    {
        /// <summary>Bytes from the start of a struct to the lowest corner, or to the centre.</summary>
        public readonly int First;

        /// <summary>Bytes from the start of a struct to the highest corner, or to half the size.</summary>
        public readonly int Second;

        /// <summary>What the two are.</summary>
        public readonly CulletBoxForm Form;

        /// <summary>The type of their numbers.</summary>
        public readonly CulletNumber Number;

        /// <summary>Makes a layout of offsets in bytes.</summary>
        public CulletBoxLayout(int first, int second, CulletBoxForm form, CulletNumber number = CulletNumber.F32)
        {
            First = first;
            Second = second;
            Form = form;
            Number = number;
        }

        /// <summary>Returns the layout of a struct by the names of two fields, each of three floats or three doubles.
        /// Looks them up by reflection: call it once and keep the answer. Refuses structs with references, bool or
        /// char, whose offsets reflection does not tell.</summary>
        public static CulletBoxLayout Of<T>(string first, string second, CulletBoxForm form) where T : struct
        {
            if (!IsPlain(typeof(T))) throw new ArgumentException($"{typeof(T)} has a field that is no number");
            CulletNumber number = NumberOf(typeof(T), first), other = NumberOf(typeof(T), second);
            if (number != other) throw new ArgumentException($"{first} and {second} have numbers of different types");
            return new CulletBoxLayout(
                (int)Marshal.OffsetOf(typeof(T), first), (int)Marshal.OffsetOf(typeof(T), second), form, number);
        }

        const BindingFlags Fields = BindingFlags.Instance | BindingFlags.Public | BindingFlags.NonPublic;

        internal static bool IsPlain(Type type)
        {
            if (type.IsPrimitive || type.IsEnum) return type != typeof(bool) && type != typeof(char);
            if (!type.IsValueType || type.IsAutoLayout) return false;
            foreach (FieldInfo field in type.GetFields(Fields)) if (!IsPlain(field.FieldType)) return false;
            return true;
        }

        static CulletNumber NumberOf(Type type, string name)
        {
            FieldInfo field = name == null ? null : type.GetField(name, Fields);
            if (field == null) throw new ArgumentException($"{type} has no field {name}");
            FieldInfo[] inner = field.FieldType.GetFields(Fields);
            bool isThree = inner.Length == 3 && inner[1].FieldType == inner[0].FieldType;
            if (isThree && inner[2].FieldType == inner[0].FieldType)
            {
                if (inner[0].FieldType == typeof(float)) return CulletNumber.F32;
                if (inner[0].FieldType == typeof(double)) return CulletNumber.F64;
            }
            throw new ArgumentException($"{type}.{name} is a {field.FieldType}: it must have three floats or doubles");
        }
    }

    /// <summary>What hides: opaque boxes, a convex body or triangles, in arrays of yours that are read when it is
    /// set.</summary>
    public struct CulletOccluder
    {
        CulletOccluderKind kind;
        Array positions;
        Array indices;
        int indexSize;

        /// <summary>Where it stands; null for the identity.</summary>
        public CulletTransform? Transform;

        /// <summary>Returns boxes, each within what is opaque.</summary>
        public static CulletOccluder Boxes(params CulletBox[] boxes) => new CulletOccluder { positions = boxes };

        /// <summary>Returns a closed convex body of up to 256 corners: three floats each, and triangles that are wound
        /// counter-clockwise seen from outside. The quickest kind by far for what is convex.</summary>
        public static CulletOccluder Hull(float[] positions, ushort[] indices) =>
            Of(CulletOccluderKind.Hull, positions, indices, 2);

        /// <summary>Returns a closed convex body with indices of 32 bits.</summary>
        public static CulletOccluder Hull(float[] positions, uint[] indices) =>
            Of(CulletOccluderKind.Hull, positions, indices, 4);

        /// <summary>Returns triangles, which hide from their fronts, or from both sides.</summary>
        public static CulletOccluder Triangles(float[] positions, ushort[] indices, bool twoSided = false) =>
            Of(twoSided ? CulletOccluderKind.TwoSidedTriangles : CulletOccluderKind.Triangles, positions, indices, 2);

        /// <summary>Returns triangles with indices of 32 bits.</summary>
        public static CulletOccluder Triangles(float[] positions, uint[] indices, bool twoSided = false) =>
            Of(twoSided ? CulletOccluderKind.TwoSidedTriangles : CulletOccluderKind.Triangles, positions, indices, 4);

        static CulletOccluder Of(CulletOccluderKind kind, float[] positions, Array indices, int indexSize)
        {
            if (positions != null) Vertices(positions.Length, nameof(positions));
            return new CulletOccluder { kind = kind, positions = positions, indices = indices, indexSize = indexSize };
        }

        /// <summary>Fills what the library reads. The arrays stay where they are until the handles are freed.</summary>
        internal unsafe void Fill(cullet_occluder* raw, CulletTransform* transform, ref GCHandle first,
            ref GCHandle second)
        {
            bool isBoxes = kind == CulletOccluderKind.Boxes;
            first = GCHandle.Alloc(positions, GCHandleType.Pinned);
            second = GCHandle.Alloc(indices, GCHandleType.Pinned);
            raw->kind = (uint)kind;
            raw->index_size = (uint)indexSize;
            raw->stride = Size(isBoxes ? 24 : 12);
            raw->positions = (float*)first.AddrOfPinnedObject();
            raw->position_count = Size(positions == null ? 0 : isBoxes ? positions.Length : positions.Length / 3);
            raw->indices = (void*)second.AddrOfPinnedObject();
            raw->index_count = Size(indices == null ? 0 : indices.Length);
            raw->transform = null;
            if (Transform.HasValue)
            {
                *transform = Transform.Value;
                raw->transform = transform;
            }
        }
    }

    /// <summary>A set of boxes to be culled over your own arrays. It holds copies; a set has one view at a
    /// time.</summary>
    public sealed unsafe class CulletBoxes : CulletObject
    {
        /// <summary>Makes an empty set. The occlusion buffer has so many pixels across; 0 takes 640.</summary>
        public CulletBoxes(int occlusionWidth = 0)
        {
            cullet_boxes made;
            CulletLibrary.Check(cullet_boxes_create((uint)occlusionWidth, &made));
            Take(made.id);
        }

        internal override CulletStatus Destroy(ulong id) => cullet_boxes_destroy(new cullet_boxes { id = id });

        cullet_boxes Handle => new cullet_boxes { id = Id };

        /// <summary>Replaces all boxes. A box with a NaN is always visible; one whose lowest corner is above its
        /// highest is never. Numbers are relative to an origin, a point of the world.</summary>
        public void Set(ReadOnlySpan<CulletBox> boxes, CulletDouble3 origin = default(CulletDouble3)) =>
            Give(-1, boxes, origin);

        /// <summary>Replaces as many boxes as there are, from one on: those that moved.</summary>
        public void Update(int first, ReadOnlySpan<CulletBox> boxes, CulletDouble3 origin = default(CulletDouble3)) =>
            Give(Index(first), boxes, origin);

        /// <summary>Replaces all boxes by those of two arrays of points, equally long.</summary>
        public void Set(
            ReadOnlySpan<CulletFloat3> first, ReadOnlySpan<CulletFloat3> second, CulletBoxForm form,
            CulletDouble3 origin = default(CulletDouble3))
        {
            SameLength(first.Length, second.Length, nameof(second));
            fixed (CulletFloat3* a = &MemoryMarshal.GetReference(first), b = &MemoryMarshal.GetReference(second))
                Give(-1, a, b, 12, first.Length, (uint)form, 0, origin);
        }

        /// <summary>Replaces all boxes by those in structs of your own.</summary>
        public void Set<T>(ReadOnlySpan<T> objects, CulletBoxLayout layout,
            CulletDouble3 origin = default(CulletDouble3))
            where T : struct => Give(-1, objects, layout, origin);

        /// <summary>Replaces all boxes by those in structs of your own.</summary>
        public void Set<T>(T[] objects, CulletBoxLayout layout, CulletDouble3 origin = default(CulletDouble3))
            where T : struct => Give<T>(-1, objects, layout, origin);

        /// <summary>Replaces boxes from one on by those in structs of your own.</summary>
        public void Update<T>(
            int first, ReadOnlySpan<T> objects, CulletBoxLayout layout, CulletDouble3 origin = default(CulletDouble3))
            where T : struct => Give(Index(first), objects, layout, origin);

        /// <summary>Replaces boxes from one on by those in structs of your own.</summary>
        public void Update<T>(
            int first, T[] objects, CulletBoxLayout layout, CulletDouble3 origin = default(CulletDouble3))
            where T : struct => Give<T>(Index(first), objects, layout, origin);

        /// <summary>Replaces all boxes by those behind pointers, with strides and counts of yours.</summary>
        public void SetPointers(cullet_box_arrays* arrays) => Check(cullet_boxes_set(Handle, arrays));

        /// <summary>Replaces boxes from one on by those behind pointers.</summary>
        public void UpdatePointers(int first, cullet_box_arrays* arrays) =>
            Check(cullet_boxes_update(Handle, Size(Index(first)), arrays));

        static int Index(int first)
        {
            if (first < 0) throw new ArgumentOutOfRangeException(nameof(first));
            return first;
        }

        void Give(int at, ReadOnlySpan<CulletBox> boxes, CulletDouble3 origin)
        {
            fixed (CulletBox* all = &MemoryMarshal.GetReference(boxes))
                Give(at, all, all == null ? null : &all->Max, sizeof(CulletBox), boxes.Length, 0, 0, origin);
        }

        void Give<T>(int at, ReadOnlySpan<T> objects, CulletBoxLayout layout, CulletDouble3 origin) where T : struct
        {
#if CULLET_NO_SPAN
            // Some hosts pin structs with references too.
            if (!Plain<T>.Is) throw new ArgumentException($"{typeof(T)} has a field that is no number");
            int size = Marshal.SizeOf(typeof(T));
            GCHandle pinned = GCHandle.Alloc(objects.Array, GCHandleType.Pinned);
            try
            {
                Give(at, (byte*)pinned.AddrOfPinnedObject() + objects.Start * (long)size, size, objects.Length,
                    layout, origin);
            }
            finally
            {
                pinned.Free();
            }
#else
            // Refuses structs with references.
            ReadOnlySpan<byte> bytes = MemoryMarshal.AsBytes(objects);
            int size = objects.Length == 0 ? 0 : bytes.Length / objects.Length;
            fixed (byte* all = &MemoryMarshal.GetReference(bytes)) Give(at, all, size, objects.Length, layout, origin);
#endif
        }

#if CULLET_NO_SPAN
        static class Plain<T>
        {
            internal static readonly bool Is = CulletBoxLayout.IsPlain(typeof(T));
        }
#endif

        void Give(int at, byte* all, int size, int count, CulletBoxLayout layout, CulletDouble3 origin)
        {
            if (count == 0)
            {
                Give(at, null, null, 24, 0, (uint)layout.Form, (uint)layout.Number, origin);
                return;
            }
            int room = size - (layout.Number == CulletNumber.F64 ? 24 : 12);
            if (layout.First < 0 || layout.Second < 0 || layout.First > room || layout.Second > room)
                throw new ArgumentException(
                    $"the layout has offsets {layout.First} and {layout.Second}: they must be 0 to {room}",
                        nameof(layout));
            Give(at, all + layout.First, all + layout.Second, size, count, (uint)layout.Form, (uint)layout.Number,
                origin);
        }

        void Give(int at, void* first, void* second, int stride, int count, uint form, uint number,
            CulletDouble3 origin)
        {
            var arrays = new cullet_box_arrays
            {
                first = first,
                second = second,
                stride = Size(stride),
                count = Size(count),
                form = form,
                number = number,
                origin = origin
            };
            Check(at < 0 ? cullet_boxes_set(Handle, &arrays) : cullet_boxes_update(Handle, Size(at), &arrays));
        }

        /// <summary>Replaces what hides; occluders have the numbers 0, 1, 2, ... in their order. All or none.</summary>
        public void SetOccluders(params CulletOccluder[] occluders)
        {
            int count = occluders == null ? 0 : occluders.Length;
            var pinned = new GCHandle[2 * count];
            var raw = new cullet_occluder[count + 1];
            var transforms = new CulletTransform[count + 1];
            fixed (cullet_occluder* all = raw)
            fixed (CulletTransform* at = transforms)
            {
                try
                {
                    for (int i = 0; i < count; i++)
                        occluders[i].Fill(all + i, at + i, ref pinned[2 * i], ref pinned[2 * i + 1]);
                    Check(cullet_boxes_set_occluders(Handle, all, Size(count)));
                }
                finally
                {
                    foreach (GCHandle handle in pinned) if (handle.IsAllocated) handle.Free();
                }
            }
        }

        /// <summary>Replaces one occluder, such as triangles that deform. Allocates nothing for triangles in the place
        /// of as many.</summary>
        public void SetOccluder(int number, CulletOccluder occluder)
        {
            cullet_occluder raw;
            CulletTransform transform;
            GCHandle first = default(GCHandle), second = default(GCHandle);
            try
            {
                occluder.Fill(&raw, &transform, ref first, ref second);
                Check(cullet_boxes_set_occluder(Handle, (uint)number, &raw));
            }
            finally
            {
                if (first.IsAllocated) first.Free();
                if (second.IsAllocated) second.Free();
            }
        }

        /// <summary>Moves one occluder; null for the identity. Allocates nothing.</summary>
        public void MoveOccluder(int number, CulletTransform? transform)
        {
            CulletTransform at = transform.GetValueOrDefault();
            Check(cullet_boxes_move_occluder(Handle, (uint)number, transform.HasValue ? &at : null));
        }

        /// <summary>Culls for a view, writes 1 for each box that may be visible and 0 for each that is proved not to
        /// be, and returns how many may be visible. There must be a flag for each box. Allocates nothing after the
        /// first time.</summary>
        public int Cull(in CulletView view, Span<byte> flags)
        {
            fixed (byte* all = &MemoryMarshal.GetReference(flags)) return Cull(view, all, flags.Length);
        }

        /// <summary>Culls as the other does, into flags that are true or false.</summary>
        public int Cull(in CulletView view, Span<bool> flags)
        {
            // A bool of C# is a byte of 0 or 1.
            fixed (bool* all = &MemoryMarshal.GetReference(flags)) return Cull(view, (byte*)all, flags.Length);
        }

        /// <summary>Culls as the others do, into flags behind a pointer, with room for so many.</summary>
        public int Cull(in CulletView view, byte* flags, int capacity)
        {
            CulletView copy = view;
            UIntPtr visible;
            Check(cullet_boxes_cull(Handle, &copy, flags, Size(capacity), &visible));
            return (int)visible;
        }

        /// <summary>Culls as the others do, and writes bits: bit i mod 64 of word i / 64 is the flag of box
        /// i.</summary>
        public int CullBits(in CulletView view, Span<ulong> words)
        {
            CulletView copy = view;
            UIntPtr visible;
            fixed (ulong* all = &MemoryMarshal.GetReference(words))
                Check(cullet_boxes_cull_bits(Handle, &copy, all, Size(words.Length), &visible));
            return (int)visible;
        }
    }
}
