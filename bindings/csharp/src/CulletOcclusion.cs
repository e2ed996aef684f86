// An occlusion buffer by hand, and what is seen from a region of eyes.
using System;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>An occlusion buffer: draw what hides, then test boxes. Hidden is a proof at every resolution.</summary>
    public sealed unsafe class CulletOcclusion : CulletObject
    {
        /// <summary>How many pixels the buffer has.</summary>
        public int Width { get; }

        /// <summary>How many rows the buffer has.</summary>
        public int Height { get; }

        /// <summary>Makes a buffer of so many pixels, 1 to 4096 each way.</summary>
        public CulletOcclusion(int width, int height)
        {
            cullet_occlusion made;
            CulletLibrary.Check(cullet_occlusion_create((uint)width, (uint)height, &made));
            Take(made.id);
            Width = width;
            Height = height;
        }

        internal override CulletStatus Destroy(ulong id) => cullet_occlusion_destroy(new cullet_occlusion { id = id });

        cullet_occlusion Handle => new cullet_occlusion { id = Id };

        /// <summary>Empties the buffer and turns it to a view. Boxes are relative to an origin.</summary>
        public void Begin(in CulletView view, CulletDouble3 origin = default(CulletDouble3))
        {
            CulletView seen = view;
            Check(cullet_occlusion_begin(Handle, &seen, (double*)&origin));
        }

        /// <summary>Draws boxes that hide, each within what is opaque, near ones first.</summary>
        public void DrawBoxes(ReadOnlySpan<CulletBox> boxes, CulletTransform? transform = null)
        {
            CulletTransform at = transform.GetValueOrDefault();
            fixed (CulletBox* all = &MemoryMarshal.GetReference(boxes))
                Check(cullet_occlusion_draw_boxes(Handle, all, Size(boxes.Length), transform.HasValue ? &at : null));
        }

        /// <summary>Draws triangles that hide: from both sides, or from their fronts alone, which are
        /// counter-clockwise.</summary>
        public void DrawTriangles(
            ReadOnlySpan<float> positions, ReadOnlySpan<uint> indices, bool twoSided = false,
            CulletTransform? transform = null)
        {
            int vertices = Vertices(positions.Length, nameof(positions));
            CulletTransform at = transform.GetValueOrDefault();
            fixed (float* corners = &MemoryMarshal.GetReference(positions))
            fixed (uint* faces = &MemoryMarshal.GetReference(indices))
                Check(cullet_occlusion_draw_triangles(
                    Handle, corners, Size(vertices), faces, Size(indices.Length), twoSided ? 1u : 0u,
                    transform.HasValue ? &at : null));
        }

        /// <summary>Tests boxes, and writes a result for each.</summary>
        public void TestBoxes(ReadOnlySpan<CulletBox> boxes, Span<CulletFound> results)
        {
            Room(boxes.Length, results.Length, nameof(results));
            fixed (CulletBox* all = &MemoryMarshal.GetReference(boxes))
            fixed (CulletFound* found = &MemoryMarshal.GetReference(results))
                Check(cullet_occlusion_test_boxes(Handle, all, Size(boxes.Length), (byte*)found));
        }

        /// <summary>Writes the nearness that covers all of each pixel, row by row from the top left; 0 where nothing is
        /// proved. Needs room for <see cref="Width"/> times <see cref="Height"/>.</summary>
        public void Read(Span<float> nearness)
        {
            fixed (float* all = &MemoryMarshal.GetReference(nearness))
                Check(cullet_occlusion_read(Handle, all, Size(nearness.Length)));
        }
    }

    /// <summary>A region query: its memory, and its last result.</summary>
    public sealed unsafe class CulletRegion : CulletObject
    {
        /// <summary>Makes the memory of region queries.</summary>
        public CulletRegion()
        {
            cullet_region made;
            CulletLibrary.Check(cullet_region_create(&made));
            Take(made.id);
        }

        internal override CulletStatus Destroy(ulong id) => cullet_region_destroy(new cullet_region { id = id });

        cullet_region Handle => new cullet_region { id = Id };

        /// <summary>Finds what may be seen from any eye in a box. The view is how all the eyes look; null for any
        /// direction. Nothing that an eye sees is missing.</summary>
        public void Cull(
            CulletScene scene, CulletEyeBox eyes, CulletView? view = null, CulletRegionSettings? settings = null)
        {
            CulletView seen = view.GetValueOrDefault();
            CulletRegionSettings set = settings.GetValueOrDefault();
            var handle = new cullet_scene { id = IdOf(scene, nameof(scene)) };
            Check(
                cullet_region_cull(
                    handle, &eyes, view.HasValue ? &seen : null, settings.HasValue ? &set : null, Handle),
                scene);
        }

        /// <summary>Returns the slots that may be seen, ascending, as the scene had them when it was culled.</summary>
        public uint[] Slots()
        {
            UIntPtr count;
            Check(cullet_region_slots(Handle, null, Size(0), &count));
            var slots = new uint[(int)count];
            fixed (uint* all = slots) Check(cullet_region_slots(Handle, all, count, &count));
            return slots;
        }
    }
}
