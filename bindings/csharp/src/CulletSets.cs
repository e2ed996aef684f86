// Visible sets: opened, asked, and given to scenes.
using System;
using System.Runtime.InteropServices;
using static Cullet.CulletLibrary;
using static Cullet.CulletNative;

namespace Cullet
{
    /// <summary>Potentially visible sets: what may be seen from each of some cells. Several threads may read them side
    /// by side.</summary>
    public sealed unsafe class CulletPvs : CulletObject
    {
        internal CulletPvs(ulong id) => Take(id);

        /// <summary>Opens a file of <c>cullet pvs</c>, or one of bytes from <see cref="Write"/>.</summary>
        public static CulletPvs Open(string path)
        {
            cullet_pvs made;
            fixed (byte* text = Utf8(path, nameof(path))) CulletLibrary.Check(cullet_pvs_open(text, &made));
            return new CulletPvs(made.id);
        }

        /// <summary>Makes visible sets of the bytes of such a file, which are copied.</summary>
        public static CulletPvs Read(ReadOnlySpan<byte> bytes)
        {
            cullet_pvs made;
            fixed (byte* all = &MemoryMarshal.GetReference(bytes))
                CulletLibrary.Check(cullet_pvs_read(all, Size(bytes.Length), &made));
            return new CulletPvs(made.id);
        }

        internal override CulletStatus Destroy(ulong id) => cullet_pvs_destroy(new cullet_pvs { id = id });

        internal cullet_pvs Handle => new cullet_pvs { id = Id };

        /// <summary>Returns the bytes of a file, which <see cref="Read"/> and <see cref="Open"/> take.</summary>
        public byte[] Write()
        {
            UIntPtr count;
            Check(cullet_pvs_write(Handle, null, Size(0), &count));
            var bytes = new byte[(int)count];
            fixed (byte* all = bytes) Check(cullet_pvs_write(Handle, all, count, &count));
            return bytes;
        }

        /// <summary>Returns how many cells and targets there are, and how much the sets are likely to miss.</summary>
        public CulletPvsInfo Info()
        {
            CulletPvsInfo info;
            Check(cullet_pvs_get_info(Handle, &info));
            return info;
        }

        /// <summary>Returns the view cells, by their numbers, in world space. Throws with
        /// <see cref="CulletStatus.NotFound"/> for sets of a scene's own cells.</summary>
        public CulletEyeBox[] Cells()
        {
            UIntPtr count;
            Check(cullet_pvs_cells(Handle, null, Size(0), &count));
            var cells = new CulletEyeBox[(int)count];
            fixed (CulletEyeBox* all = cells) Check(cullet_pvs_cells(Handle, all, count, &count));
            return cells;
        }

        /// <summary>Returns for each view cell the share of looks that are estimated to end on something that its set
        /// lacks, 0 to 1. Throws as <see cref="Cells"/> does.</summary>
        public float[] Missing()
        {
            UIntPtr count;
            Check(cullet_pvs_missing(Handle, null, Size(0), &count));
            var shares = new float[(int)count];
            fixed (float* all = shares) Check(cullet_pvs_missing(Handle, all, count, &count));
            return shares;
        }

        /// <summary>Returns the view cell of a point in world space; <c>uint.MaxValue</c> where it is in none. Throws
        /// as <see cref="Cells"/> does.</summary>
        public uint CellOf(CulletDouble3 point)
        {
            uint cell;
            Check(cullet_pvs_cell_of(Handle, (double*)&point, Size(1), &cell));
            return cell;
        }

        /// <summary>Writes the view cell of each point.</summary>
        public void CellsOf(ReadOnlySpan<CulletDouble3> points, Span<uint> cells)
        {
            Room(points.Length, cells.Length, nameof(cells));
            fixed (CulletDouble3* all = &MemoryMarshal.GetReference(points))
            fixed (uint* found = &MemoryMarshal.GetReference(cells))
                Check(cullet_pvs_cell_of(Handle, (double*)all, Size(points.Length), found));
        }

        /// <summary>Writes what may be seen from any of some cells, ascending, and returns how many there are: the
        /// <see cref="CulletHandle.Index"/> of instances, or cells, as <see cref="CulletPvsInfo.Targets"/> says. The
        /// <see cref="CulletPvsInfo.TargetCount"/> is always room enough. Instances that were added since the bake are
        /// in no set.</summary>
        public int Visible(ReadOnlySpan<uint> cells, Span<uint> targets)
        {
            UIntPtr count;
            fixed (uint* from = &MemoryMarshal.GetReference(cells))
            fixed (uint* all = &MemoryMarshal.GetReference(targets))
                Check(cullet_pvs_visible(
                    Handle, from, Size(cells.Length), targets.Length == 0 ? null : all, Size(targets.Length), &count));
            // A capacity of 0 asks for the count alone, and is no mistake.
            Room((int)count, targets.Length, nameof(targets));
            return (int)count;
        }
    }
}
