// Mistakes throw and change nothing: objects that are disposed of, stale handles, null, wrong sizes. And finalizers.
using System;
using System.Runtime.CompilerServices;
using System.Threading;

namespace Cullet.Tests
{
    static unsafe class Mistakes
    {
        static readonly float[] Positions = { 1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1 };
        static readonly uint[] Indices = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };

        internal static void Run()
        {
            Disposed();
            Scenes();
            Boxes();
            Layouts();
            Others();
            Finalizers();
            Threads();
        }

        static void Disposed()
        {
            CulletView view = Answers.Ahead();
            var scene = new CulletScene();
            var state = new CulletState();
            ulong id = scene.Id;
            Check.That(id != 0 && !scene.IsDisposed, "an object that lives");
            scene.Dispose();
            scene.Dispose();
            Check.That(scene.IsDisposed, "an object that is disposed of");
            Check.Throws<ObjectDisposedException>("CulletScene", () => scene.Commit());
            Check.Throws<ObjectDisposedException>("CulletScene", () => state.Cull(scene, view));
            Check.Throws<ObjectDisposedException>("CulletScene", () => Check.Equal(0ul, scene.Id, "unreachable"));
            Check.Throws<ArgumentNullException>("scene", () => state.Cull(null, view));
            state.Dispose();
            Check.Throws<ObjectDisposedException>("CulletState", () =>
                Check.Equal(0, state.VisibleCount, "unreachable"));
            // The library itself refuses the handle that was, and one of another kind.
            var stale = new CulletNative.cullet_scene { id = id };
            Check.Refused(CulletStatus.StaleHandle, "cullet_scene_commit",
                () => CulletLibrary.Check(CulletNative.cullet_scene_commit(stale)));
            using (var boxes = new CulletBoxes())
            {
                var wrong = new CulletNative.cullet_scene { id = boxes.Id };
                Check.Refused(CulletStatus.WrongHandle, "not of a scene",
                    () => CulletLibrary.Check(CulletNative.cullet_scene_commit(wrong)));
                // Destroyed behind the back of its object: refused, and Dispose is quiet.
                CulletLibrary.Check(CulletNative.cullet_boxes_destroy(new CulletNative.cullet_boxes { id = boxes.Id }));
                Check.Refused(CulletStatus.StaleHandle, "", () => boxes.CullBits(view, new ulong[1]));
            }
        }

        static void Scenes()
        {
            CulletView view = Answers.Ahead();
            Check.Throws<ArgumentNullException>("path", () => CulletScene.Open(null));
            Check.Throws<ArgumentException>("character 0", () => CulletScene.Open("a\0b"));
            Check.Refused(CulletStatus.File, "kein/Körper.glb", () => CulletScene.Open("kein/Körper.glb"));
            using (var scene = new CulletScene())
            using (var other = new CulletScene())
            using (var state = new CulletState())
            {
                Check.Throws<ArgumentException>("11 floats", () => scene.AddMesh(new float[11], Indices));
                Check.Refused(CulletStatus.Mesh, "3 vertices", () => scene.AddMesh(new float[9], Indices));
                Check.Refused(CulletStatus.Mesh, "", () => scene.AddMesh(Positions, new uint[11]));
                Check.Refused(CulletStatus.InvalidValue, "", () =>
                    scene.AddMesh(Positions, Indices, (CulletMeshFlags)64));
                uint mesh = scene.AddMesh(Positions, Indices);
                var instance = new CulletInstance(mesh, CulletTransform.At(0, 0, -10), 7);
                Check.Refused(CulletStatus.NotFound, "mesh 5", () =>
                    scene.Add(new CulletInstance(5, instance.Transform)));
                Check.Throws<ArgumentException>("room for 1", () =>
                    scene.Add(new CulletInstance[2], new CulletHandle[1]));
                Check.Equal(0u, scene.Info().InstanceCount, "instances after refusals");
                CulletHandle[] one = { scene.Add(instance) };
                scene.Commit();
                Check.Throws<ArgumentException>("2 entries", () => scene.SetTransforms(one, new CulletTransform[2]));
                Check.Throws<ArgumentException>("0 entries", () => scene.SetLayers(one, null));
                Check.Throws<ArgumentException>("0 entries", () => scene.SetFlags(one, new CulletInstanceFlags[0]));
                Check.Throws<ArgumentException>("Mesh or None", () => scene.SetBounds(one[0], CulletBounds.World));
                Check.Refused(CulletStatus.InvalidValue, "", () => scene.SetBounds(one[0], -1f));
                Check.Refused(CulletStatus.NoResult, "", () => state.VisibleSlots(new uint[4]));
                Check.Refused(CulletStatus.StructSize, "fill the view", () => state.Cull(scene, default(CulletView)));
                Check.Refused(CulletStatus.StructSize, "settings", () =>
                    state.Cull(scene, view, default(CulletSettings)));
                CulletSettings settings = CulletSettings.Preset(CulletPreset.Exact);
                settings.Frustum = 2;
                Check.Refused(CulletStatus.InvalidValue, "frustum", () => state.Cull(scene, view, settings));
                scene.Add(instance);
                state.Cull(scene, view);
                Check.Refused(CulletStatus.TooSmall, "", () => state.VisibleSlots(new uint[1]));
                Check.Throws<ArgumentException>("room for 0", () => state.VisibleSlots(null));
                Check.Throws<ArgumentException>("room for 0", () => state.VisibleUsers(scene, null));
                Check.Throws<ArgumentException>("room for 0", () => state.VisibleHandles(scene, null));
                Check.Refused(CulletStatus.TooSmall, "", () => state.VisibleUsers(scene, new ulong[1]));
                Check.Refused(CulletStatus.NoResult, "", () => state.VisibleUsers(other, new ulong[2]));
                Check.Throws<ArgumentNullException>("draws", () => state.Draws(scene, null));
                Check.Refused(CulletStatus.TooSmall, "", () => scene.ReadMesh(0, null, new uint[11]));
                Check.Refused(CulletStatus.NotFound, "", () => scene.MeshInfo(9));
                CulletHandle handle;
                Check.Refused(CulletStatus.NotFound, "", () => scene.Instance(99, out handle));
                scene.Remove(one[0]);
                Check.Refused(CulletStatus.NoResult, "", () => state.VisibleUsers(scene, new ulong[2]));
                Check.Refused(CulletStatus.NotFound, "", () => scene.Remove(one[0]));
                Check.Refused(CulletStatus.NotFound, "", () => scene.Slot(one[0]));
                CulletReason reason;
                Check.Refused(CulletStatus.NotFound, "", () => scene.Explain(view, one[0], out reason));
                Check.Throws<ArgumentException>("room for 1", () =>
                    scene.LinesOfSight(new CulletSegment[2], new CulletSight[1]));
                Check.Throws<ArgumentException>("room for 0",
                    () => scene.BoxToBox(default(CulletBox), new CulletBox[1], new CulletFound[0]));
                Check.Throws<ArgumentException>("room for 0", () => state.CullLights(scene, new CulletLight[1], null));
            }
        }

        static void Boxes()
        {
            CulletView view = Answers.Ahead();
            Check.Refused(CulletStatus.InvalidValue, "5000", () => new CulletBoxes(5000));
            Check.Refused(CulletStatus.InvalidValue, "", () => new CulletBoxes(-1));
            using (var boxes = new CulletBoxes())
            {
                var four = new CulletBox[4];
                boxes.Set(null);
                boxes.Set(four);
                Check.Throws<ArgumentException>("3 entries",
                    () => boxes.Set(new CulletFloat3[4], new CulletFloat3[3], CulletBoxForm.MinMax));
                Check.Refused(CulletStatus.InvalidValue, "form", () =>
                    boxes.Set(new CulletFloat3[4], new CulletFloat3[4], (CulletBoxForm)9));
                Check.Refused(CulletStatus.InvalidValue, "4 boxes from box 1 on", () => boxes.Update(1, four));
                Check.Throws<ArgumentOutOfRangeException>("first", () => boxes.Update(-1, four));
                Check.Refused(CulletStatus.InvalidValue, "", () =>
                    boxes.Set(four, new CulletDouble3(0, double.NaN, 0)));
                Check.Refused(CulletStatus.TooSmall, "room for 3 flags, but 4 are needed", () =>
                    boxes.Cull(view, new byte[3]));
                Check.Refused(CulletStatus.TooSmall, "", () => boxes.Cull(view, new bool[0]));
                Check.Refused(CulletStatus.TooSmall, "", () => boxes.CullBits(view, null));
                Check.Refused(CulletStatus.StructSize, "", () => boxes.Cull(default(CulletView), new byte[4]));
                Check.Refused(CulletStatus.NullPointer, "arrays is NULL", () =>
                    boxes.SetPointers((CulletNative.cullet_box_arrays*)null));
                Check.Refused(CulletStatus.InvalidValue, "occluder 0", () =>
                    boxes.SetOccluders(default(CulletOccluder)));
                Check.Refused(CulletStatus.InvalidValue, "occluder 0: index 3",
                    () => boxes.SetOccluders(CulletOccluder.Triangles(new float[9], Indices)));
                Check.Throws<ArgumentException>("10 floats", () => CulletOccluder.Hull(new float[10], Indices));
                Check.Refused(CulletStatus.InvalidValue, "", () =>
                    boxes.SetOccluders(CulletOccluder.Hull(null, Indices)));
                Check.Refused(CulletStatus.InvalidValue, "", () =>
                    boxes.SetOccluders(CulletOccluder.Hull(Positions, (uint[])null)));
                Check.Refused(CulletStatus.NotFound, "", () => boxes.MoveOccluder(0, null));
                Check.Refused(CulletStatus.NotFound, "", () =>
                    boxes.SetOccluder(-1, CulletOccluder.Boxes(default(CulletBox))));
            }
        }

        struct Named
        {
            internal string Name;
            internal CulletFloat3 Low, High;
        }

        struct Flagged
        {
            internal bool IsOn;
            internal CulletFloat3 Low, High;
        }

        struct Mixed
        {
            internal CulletFloat3 Low;
            internal CulletDouble3 High;
            internal float One;
        }

        static void Layouts()
        {
            Func<string, string, Action> mixed = (a, b) => () => CulletBoxLayout.Of<Mixed>(a, b, CulletBoxForm.MinMax);
            Check.Throws<ArgumentException>("no number", () =>
                CulletBoxLayout.Of<Named>("Low", "High", CulletBoxForm.MinMax));
            Check.Throws<ArgumentException>("no number", () =>
                CulletBoxLayout.Of<Flagged>("Low", "High", CulletBoxForm.MinMax));
            Check.Throws<ArgumentException>("different types", mixed("Low", "High"));
            Check.Throws<ArgumentException>("no field", mixed("Low", "Higher"));
            Check.Throws<ArgumentException>("no field", mixed("Low", null));
            Check.Throws<ArgumentException>("three floats", mixed("One", "Low"));
            using (var boxes = new CulletBoxes())
            {
                var beyond = new CulletBoxLayout(0, 13, CulletBoxForm.MinMax);
                Check.Throws<ArgumentException>("0 to 12", () => boxes.Set(new CulletBox[3], beyond));
                var before = new CulletBoxLayout(-1, 12, CulletBoxForm.MinMax);
                Check.Throws<ArgumentException>("0 to 12", () => boxes.Set(new CulletBox[3], before));
                var askew = new CulletBoxLayout(1, 12, CulletBoxForm.MinMax);
                Check.Refused(CulletStatus.Alignment, "", () => boxes.Set(new CulletBox[3], askew));
                // A struct with a reference is refused, however it is laid out.
                Check.Throws<ArgumentException>("", () =>
                    boxes.Set(new Named[3], new CulletBoxLayout(8, 20, CulletBoxForm.MinMax)));
                Check.Throws<ObjectDisposedException>("", () =>
                {
                    boxes.Dispose();
                    boxes.Set(new CulletBox[3], new CulletBoxLayout(0, 12, CulletBoxForm.MinMax));
                });
            }
        }

        static void Others()
        {
            var point = default(CulletDouble3);
            Check.Refused(CulletStatus.View, "", () => CulletView.LookAt(point, point, 0.9, 0.1, 64, 64));
            Check.Refused(CulletStatus.View, "", () =>
                CulletView.LookAt(point, new CulletDouble3(0, 0, -1), 0.9, 0.1, -1, 64));
            Check.Throws<ArgumentException>("16", () =>
                CulletView.FromMatrix(new double[15], CulletDepth.Standard, 64, 64));
            Check.Refused(CulletStatus.View, "", () =>
                CulletView.FromMatrix(new double[16], CulletDepth.Standard, 64, 64));
            Check.Refused(CulletStatus.InvalidValue, "", () => CulletSettings.Preset((CulletPreset)3));
            Check.Throws<IndexOutOfRangeException>("", () =>
                Check.Equal(0.0, default(CulletMatrix)[16], "unreachable"));
            Check.Refused(CulletStatus.InvalidValue, "", () => new CulletOcclusion(0, 64));
            using (var buffer = new CulletOcclusion(64, 40))
            {
                buffer.Begin(Answers.Ahead());
                Check.Refused(CulletStatus.TooSmall, "", () => buffer.Read(new float[64 * 39]));
                Check.Throws<ArgumentException>("room for 1", () =>
                    buffer.TestBoxes(new CulletBox[2], new CulletFound[1]));
                Check.Refused(CulletStatus.InvalidValue, "", () =>
                    buffer.DrawTriangles(new float[9], new uint[] { 0, 1, 9 }));
                Check.Throws<ArgumentException>("10 floats", () => buffer.DrawTriangles(new float[10], Indices));
            }
            // Never called: by now the library has allocated.
            var late = new CulletNative.cullet_allocator { alloc = (IntPtr)1, free = (IntPtr)1 };
            Check.Refused(CulletStatus.TooLate, "first call", () =>
            {
                CulletNative.cullet_allocator copy = late;
                CulletLibrary.Check(CulletNative.cullet_set_allocator(&copy));
            });
            using (var region = new CulletRegion())
                Check.Throws<ArgumentNullException>("scene", () => region.Cull(null, default(CulletEyeBox)));
        }

        /// <summary>The collector destroys what nobody disposed of: the handle is stale afterwards.</summary>
        static void Finalizers()
        {
            ulong[] ids = new ulong[20];
            // On a thread that ends, so that no stack still has them.
            var thread = new Thread(() =>
            {
                for (int i = 0; i < ids.Length; i++) ids[i] = Forgotten();
            });
            thread.Start();
            thread.Join();
            for (int i = 0; i < 10; i++)
            {
                GC.Collect();
                GC.WaitForPendingFinalizers();
            }
            int stale = 0;
            foreach (ulong id in ids)
            {
                CulletStatus status = CulletNative.cullet_scene_commit(new CulletNative.cullet_scene { id = id });
                if (status == CulletStatus.StaleHandle) stale++;
            }
            // Mono looks for references on stacks by what looks like one.
            Check.That(stale >= ids.Length - 2, $"{stale} of {ids.Length} forgotten objects were destroyed");
            // Objects live as long as a call of theirs runs, whatever the collector does meanwhile.
            bool isDone = false;
            var collector = new Thread(() =>
            {
                while (!Volatile.Read(ref isDone)) GC.Collect();
            });
            collector.Start();
            try
            {
                for (int i = 0; i < 300; i++) Check.Equal(0, Short(), "visible of an object that lives for a call");
            }
            finally
            {
                Volatile.Write(ref isDone, true);
                collector.Join();
            }
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        static ulong Forgotten() => new CulletScene().Id;

        [MethodImpl(MethodImplOptions.NoInlining)]
        static int Short() => new CulletBoxes(64).Cull(Answers.Ahead(), new byte[0]);

        /// <summary>Calls that exclude each other throw or pass, and so does Dispose while a call runs: then it may be
        /// called again, and leaves nothing behind.</summary>
        static void Threads()
        {
            int busy = 0;
            for (int round = 0; round < 20; round++) busy += DisposedMeanwhile();
            Check.That(busy > 0, "Dispose came while a call ran");
        }

        static int DisposedMeanwhile()
        {
            int busy = 0;
            var boxes = new CulletBoxes(64);
            var many = new CulletBox[20000];
            for (int i = 0; i < many.Length; i++) many[i] = new CulletBox(0, 0, -i - 1, 1, 1, -i);
            boxes.Set(many);
            CulletView view = Answers.Ahead();
            ulong id = boxes.Id;
            Exception failure = null;
            var threads = new Thread[2];
            for (int t = 0; t < threads.Length; t++)
            {
                threads[t] = new Thread(() =>
                {
                    var flags = new byte[many.Length];
                    while (true)
                    {
                        try
                        {
                            boxes.Cull(view, flags);
                        }
                        catch (CulletException error) when (error.Status == CulletStatus.Busy)
                        {
                        }
                        catch (Exception error)
                        {
                            var refused = error as CulletException;
                            bool isStale = refused != null && refused.Status == CulletStatus.StaleHandle;
                            if (!isStale && !(error is ObjectDisposedException)) failure = error;
                            return;
                        }
                    }
                });
                threads[t].Start();
            }
            Thread.Sleep(2);
            while (!boxes.IsDisposed)
            {
                try
                {
                    boxes.Dispose();
                }
                catch (CulletException error) when (error.Status == CulletStatus.Busy)
                {
                    busy++;
                }
            }
            foreach (Thread thread in threads) thread.Join();
            if (failure != null) throw failure;
            CulletStatus left = CulletNative.cullet_boxes_destroy(new CulletNative.cullet_boxes { id = id });
            Check.Equal(CulletStatus.StaleHandle, left, "the handle of a set that was disposed of by turns");
            return busy;
        }
    }
}
