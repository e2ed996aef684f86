// Frames in C# beside the same in C, turn by turn in one process: equal answers, and both times. And what C# allocates.
using System;
using System.Diagnostics;
using System.Linq;
using System.Runtime.InteropServices;

namespace Cullet.Tests
{
    static unsafe class Frames
    {
        const string C = "frames";

        [DllImport(C)]
        static extern void border_setup();

        [DllImport(C)]
        static extern UIntPtr border_frame(uint frame);

        [DllImport(C)]
        static extern void boxes_setup();

        [DllImport(C)]
        static extern UIntPtr boxes_frame(uint frame, uint sets);

        [DllImport(C)]
        static extern byte* border_flags();

        [DllImport(C)]
        static extern uint* border_slots();

        [DllImport(C)]
        static extern CulletDrawCommand* border_commands();

        const int Side = 317, Count = Side * Side, Around = 629;

        static readonly CulletBox[] given = new CulletBox[Count];
        static readonly byte[] flags = new byte[Count];
        static readonly uint[] slots = new uint[Count];
        static readonly CulletDraws draws = new CulletDraws();
        static CulletBoxes boxes;
        static CulletScene scene;
        static CulletState state;

        internal static void Run(int rounds)
        {
            border_setup();
            boxes_setup();
            Setup();
            Compare("a cull of boxes", rounds, f => Boxes(f, false), f => (int)boxes_frame(f, 0), SameFlags);
            Compare("setting and culling boxes", 1, f => Boxes(f, true), f => (int)boxes_frame(f, 1), SameFlags);
            Compare("a frame of instances", 1, Scene, f => (int)border_frame(f), SameDraws);
            Allocations();
        }

        static void Setup()
        {
            for (int i = 0; i < Count; i++)
            {
                float x = 3 * (i % Side), z = 3 * (i / Side);
                given[i] = new CulletBox(x, 0, z, x + 1, 1, z + 1);
            }
            var walls = new CulletBox[64];
            for (int i = 0; i < 64; i++)
            {
                float x = 118 * (i % 8), z = 118 * (i / 8);
                walls[i] = new CulletBox(x, 0, z, x + 40, 9, z + 2);
            }
            boxes = new CulletBoxes(640);
            boxes.SetOccluders(CulletOccluder.Boxes(walls));
            boxes.Set(given);
            float[] corners = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1 };
            uint[] faces =
            {
                0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1,
                    6, 5
            };
            scene = new CulletScene();
            uint mesh = scene.AddMesh(corners, faces, CulletMeshFlags.OneSided);
            var instances = new CulletInstance[Count];
            for (int i = 0; i < Count; i++)
                instances[i] = new CulletInstance(mesh, CulletTransform.At(3.0 * (i % Side), 0, 3.0 * (i / Side)));
            scene.Add(instances, null);
            scene.Commit();
            state = new CulletState();
        }

        static CulletView View(uint frame, double height)
        {
            double angle = 0.01 * frame, middle = 1.5 * Side;
            var target = new CulletDouble3(middle + 100 * Math.Cos(angle), 0, middle + 100 * Math.Sin(angle));
            return CulletView.LookAt(new CulletDouble3(middle, height, middle), target, 0.9, 0.1, 1280, 720);
        }

        static int Boxes(uint frame, bool sets)
        {
            if (sets) boxes.Set(given);
            return boxes.Cull(View(frame, 5), flags);
        }

        static int Scene(uint frame)
        {
            state.Cull(scene, View(frame, 20));
            int count = state.VisibleSlots(slots);
            state.Draws(scene, draws);
            return count;
        }

        static bool SameFlags(int count)
        {
            byte* there = border_flags();
            for (int i = 0; i < Count; i++) if (flags[i] != there[i]) return false;
            return true;
        }

        static bool SameDraws(int count)
        {
            uint* there = border_slots();
            for (int i = 0; i < count; i++) if (slots[i] != there[i]) return false;
            CulletDrawCommand* commands = border_commands();
            for (int i = 0; i < draws.Commands.Length; i++)
                if (!draws.Commands[i].Equals(commands[i])) return false;
            return draws.Commands.Length > 0;
        }

        static void Compare(
            string what, int rounds, Func<uint, int> ours, Func<uint, int> theirs, Func<int, bool> isSame)
        {
            var times = new[] { new long[rounds * Around], new long[rounds * Around] };
            long visible = 0;
            // The first round warms up and compares; the others take times.
            for (int round = 0; round <= rounds; round++)
            {
                for (uint frame = 0; frame < Around; frame++)
                {
                    int[] counts = new int[2];
                    for (uint turn = 0; turn < 2; turn++)
                    {
                        uint which = (frame + turn) % 2;
                        long start = Stopwatch.GetTimestamp();
                        counts[which] = which == 0 ? ours(frame) : theirs(frame);
                        long took = Stopwatch.GetTimestamp() - start;
                        if (round > 0) times[which][(round - 1) * Around + frame] = took;
                    }
                    Check.Equal(counts[1], counts[0], $"{what}: visible in frame {frame}");
                    if (round == 0) Check.That(isSame(counts[0]), $"{what}: C# and C give the same in frame {frame}");
                    visible += counts[0];
                }
            }
            double[] medians = times
                .Select(all => all.OrderBy(t => t).ElementAt(all.Length / 2) * 1e6 / Stopwatch.Frequency).ToArray();
            double ratio = medians[0] / medians[1];
            Console.WriteLine(
                $"{what} of {Count}, {visible / (rounds + 1) / Around} visible: " +
                $"C# {medians[0]:0.0} us, C {medians[1]:0.0} us, {ratio:0.000} times");
            // Far above what is measured: something copies or marshals arrays.
            Check.That(ratio < 1.3, $"{what} takes {ratio} times as long as in C");
        }

        /// <summary>Frames leave nothing for the garbage collector.</summary>
        static void Allocations()
        {
            CulletOccluder door = CulletOccluder.Boxes(new CulletBox(0, 0, 0, 40, 9, 2));
            long before = 0;
            for (uint frame = 0; frame < 120; frame++)
            {
                // What the runtime compiles and the arrays grow to is there by then.
                if (frame == 20) before = GC.GetAllocatedBytesForCurrentThread();
                Scene(frame % 20);
                Boxes(frame, frame % 10 == 0);
                boxes.MoveOccluder(0, CulletTransform.At(0.01 * frame, 0, 0));
                boxes.SetOccluder(0, door);
            }
            long more = GC.GetAllocatedBytesForCurrentThread() - before;
            Check.Equal(0L, more, "the number of bytes that 100 frames allocate");
        }
    }
}
