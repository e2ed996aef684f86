// Answers by the classes: boxes, scenes, queries, shadows, lights, candidates, two eyes, an occlusion buffer by hand.
using System;
using System.Linq;

namespace Cullet.Tests
{
    static unsafe class Answers
    {
        struct Item
        {
            internal ulong Name;
            internal CulletFloat3 Center, Half;

            internal Item(ulong name, float x, float y, float z)
            {
                Name = name;
                Center = new CulletFloat3(x, y, z);
                Half = new CulletFloat3(1, 1, 1);
            }
        }

        struct Wide
        {
            internal double Low, A, B, High, C, D;
        }

        internal static readonly float[] Cube =
            { -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1 };

        internal static readonly uint[] Faces =
        {
            0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5
        };

        static CulletDouble3 At(double x, double y, double z) => new CulletDouble3(x, y, z);

        internal static CulletView Ahead(double x = 0) =>
            CulletView.LookAt(At(x, 0, 0), At(x, 0, -1), 0.9, 0.1, 640, 400);

        internal static void Run()
        {
            Boxes();
            Draws();
            using (CulletScene scene = Build())
            using (var state = new CulletState())
            {
                Culls(scene, state);
                Moves(scene, state);
            }
            using (CulletScene scene = Build())
            using (var state = new CulletState())
            {
                Sights(scene);
                Regions(scene);
                Candidates(scene, state);
                Shadows(scene, state);
                Lights(scene);
                Eyes(scene, state);
            }
            Occlusion();
            Views();
            Check.Equal(3, CulletLibrary.Version.Split('.').Length, "numbers of the version");
            Check.Equal("stale handle", CulletLibrary.Name(CulletStatus.StaleHandle), "the name of a status");
        }

        static void Boxes()
        {
            Item[] items = { new Item(1, 0, 0, -8), new Item(2, 0, 0, -20), new Item(3, 0, 0, 20),
                new Item(4, 9, 0, -20) };
            var layout = CulletBoxLayout.Of<Item>("Center", "Half", CulletBoxForm.CenterHalf);
            Check.That(layout.First == 8 && layout.Second == 20
                && layout.Number == CulletNumber.F32, "the layout of Item");
            CulletView view = Ahead();
            var flags = new byte[5];
            var words = new ulong[1];
            using (var boxes = new CulletBoxes())
            {
                Func<ulong> bits = () =>
                {
                    boxes.CullBits(view, words);
                    return words[0];
                };
                Check.Equal(0, boxes.Cull(view, new byte[0]), "visible of none");
                boxes.Set(items, layout);
                flags[4] = 9;
                Check.Equal(3, boxes.Cull(view, flags), "visible");
                Check.That(flags.SequenceEqual(new byte[] { 1, 1, 0, 1, 9 }), "flags");
                boxes.SetOccluders(CulletOccluder.Boxes(new CulletBox(-5, -5, -11, 5, 5, -10)));
                var drawn = new bool[4];
                Check.Equal(2, boxes.Cull(view, drawn), "visible behind a wall");
                Check.That(drawn.SequenceEqual(new[] { true, false, false, true }), "flags that are bools");
                Check.Equal(2, boxes.CullBits(view, words), "visible as bits");
                Check.Equal(9ul, words[0], "bits");
                boxes.MoveOccluder(0, CulletTransform.At(0, 100, 0));
                Check.Equal(11ul, bits(), "bits where the wall is away");
                boxes.MoveOccluder(0, null);
                Check.Equal(9ul, bits(), "bits where the wall is back");
                float[] body = { 40, 40, -10, -40, -40, -10, -40, 40, -90, 40, -40, -90 };
                ushort[] small = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
                uint[] large = small.Select(i => (uint)i).ToArray();
                foreach (CulletOccluder one in new[]
                {
                    CulletOccluder.Hull(body, small), CulletOccluder.Hull(body, large),
                        CulletOccluder.Triangles(body, small),
                    CulletOccluder.Triangles(body, large), CulletOccluder.Triangles(body, small, true)
                })
                {
                    boxes.SetOccluder(0, one);
                    Check.Equal(1ul, bits() & 7, "bits behind a body");
                }
                CulletOccluder away = CulletOccluder.Hull(body, small);
                away.Transform = CulletTransform.At(0, 500, 0);
                boxes.SetOccluders(away, CulletOccluder.Boxes(new CulletBox(-5, -5, -11, 5, 5, -10)));
                Check.Equal(9ul, bits(), "bits behind the second of two");
                items[2].Center.Z = -8;
                boxes.Update(2, new[] { items[2] }, layout);
                Check.Equal(13ul, bits(), "bits after a box moved");
                boxes.SetOccluders();
                Check.Equal(15ul, bits(), "bits without occluders");
                // The same boxes in other arrays, moved together with their origin.
                var corners = items.Select(i => new CulletBox(
                    i.Center.X - 1, i.Center.Y - 1, i.Center.Z - 101, i.Center.X + 1, i.Center.Y + 1,
                        i.Center.Z - 99)).ToArray();
                boxes.Set(corners, At(0, 0, 100));
                Check.Equal(15ul, bits(), "bits of corners");
                boxes.Update(1, new[] { new CulletBox(0, 0, 20, 1, 1, 21) });
                Check.Equal(13ul, bits(), "bits after a box went behind the eye");
                boxes.Set(new ReadOnlySpan<CulletBox>(corners, 2, 2), At(0, 0, 100));
                corners[2].Min.Z = corners[2].Max.Z = 0;
                boxes.Update(0, new ReadOnlySpan<CulletBox>(corners, 2, 1), At(0, 0, 100));
                flags[2] = 9;
                Check.Equal(1, boxes.Cull(view, new Span<byte>(flags, 3, 2)), "visible of a part of an array");
                Check.That(flags[2] == 9 && flags[3] == 0 && flags[4] == 1, "flags in a part of an array");
                boxes.Set(new ReadOnlySpan<Item>(items, 1, 3), layout);
                Check.Equal(7ul, bits(), "bits of a part of an array of structs");
                boxes.Set(items.Select(i => i.Center).ToArray(), items.Select(i => i.Half).ToArray(),
                    CulletBoxForm.CenterHalf);
                Check.Equal(15ul, bits(), "bits of two arrays");
                Wide[] wide = { new Wide { Low = -1, B = -9, High = 1, D = -8 },
                    new Wide { Low = -1, B = 8, High = 1, D = 9 } };
                boxes.Set(wide, new CulletBoxLayout(0, 24, CulletBoxForm.MinMax, CulletNumber.F64));
                Check.Equal(1ul, bits(), "bits of doubles");
                fixed (CulletBox* all = corners)
                {
                    var raw = new CulletNative.cullet_box_arrays
                        { first = all, second = &all->Max, stride = (UIntPtr)24, count = (UIntPtr)4,
                            origin = At(0, 0, 100) };
                    boxes.SetPointers(&raw);
                    fixed (byte* to = flags) Check.Equal(3, boxes.Cull(view, to, 4), "visible behind a pointer");
                }
            }
        }

        /// <summary>A wall ahead; behind it a box; a tower above the view; a box behind the eye.</summary>
        static CulletScene Build()
        {
            var scene = new CulletScene();
            uint mesh = scene.AddMesh(Cube, Faces, CulletMeshFlags.OneSided);
            var wall = new CulletTransform(CulletLinear.Scale(9, 5, 1), At(0, 0, -10));
            CulletInstance[] four =
            {
                new CulletInstance(mesh, wall, 10), new CulletInstance(mesh, CulletTransform.At(0, 0, -20), 11),
                new CulletInstance(mesh, CulletTransform.At(0, 40, -10), 12) { Layers = 2 },
                new CulletInstance(mesh, CulletTransform.At(0, 40, 20), 13)
            };
            var handles = new CulletHandle[4];
            scene.Add(four, handles);
            scene.Commit();
            Check.That(handles.Select(h => h.Index).SequenceEqual(new uint[] { 0, 1, 2, 3 }), "handles");
            return scene;
        }

        static CulletHandle Nth(uint index) => new CulletHandle { Index = index };

        /// <summary>Your own numbers of what is visible, less 10.</summary>
        static string Visible(CulletScene scene, CulletState state)
        {
            var users = new ulong[16];
            int count = state.VisibleUsers(scene, users);
            Check.Equal(count, state.VisibleCount, "the count of what is visible");
            return string.Join(" ", users.Take(count).OrderBy(u => u).Select(u => u - 10));
        }

        static void Culls(CulletScene scene, CulletState state)
        {
            CulletView view = Ahead();
            CulletSettings exact = CulletSettings.Preset(CulletPreset.Exact);
            exact.Reasons = 1;
            state.Cull(scene, view, exact);
            Check.Equal("0", Visible(scene, state), "visible");
            var slots = new uint[4];
            Check.Equal(1, state.VisibleSlots(slots), "visible slots");
            Check.Equal(scene.Slot(Nth(0)), slots[0], "the slot of the wall");
            CulletHandle found;
            CulletInstance wall = scene.Instance(slots[0], out found);
            Check.That(found.Equals(Nth(0)) && wall.User == 10
                && wall.Transform.Linear.X.X == 9, "the instance of a slot");
            var handles = new CulletHandle[1];
            Check.That(state.VisibleHandles(scene, handles) == 1 && handles[0].Equals(Nth(0)), "visible handles");
            var reasons = new CulletReason[4];
            Check.Equal(4, state.VisibleReasons(reasons), "reasons");
            Check.Equal(CulletStage.Visible, reasons[slots[0]].Stage, "the wall's reason");
            Check.Equal(CulletStage.Occlusion, reasons[scene.Slot(Nth(1))].Stage, "the hidden box's reason");
            Check.Equal(CulletStage.Frustum, reasons[scene.Slot(Nth(3))].Stage, "the reason of what is behind the eye");
            CulletFunnelRow[] funnel = state.Funnel();
            Check.That(funnel.Length > 1
                && funnel.Any(r => r.Stage == CulletStage.Occlusion), "the funnel has occlusion");
            Check.Equal(4ul, funnel[0].Entered.Instances, "what enters the funnel");
            CulletReason why;
            string words = scene.Explain(view, Nth(1), out why, exact);
            Check.Equal(CulletStage.Occlusion, why.Stage, "the explained reason");
            Check.That(words.Contains("occlusion") && words.Contains("\n")
                && !words.Contains("\0"), "the explanation: " + words);
            CulletSceneInfo info = scene.Info();
            Check.That(info.InstanceCount == 4 && info.SlotCount >= 4 && info.TriangleCount == 48, "the contents");
            Check.That(Math.Abs(info.Max.Y - 41) < 1e-3 && Math.Abs(info.Min.X + 9) < 1e-3, "the box of the scene");
            Check.Equal(uint.MaxValue, scene.CellOf(At(0, 0, 0)), "the cell");
        }

        static void Moves(CulletScene scene, CulletState state)
        {
            CulletView view = Ahead();
            CulletSettings exact = CulletSettings.Preset(CulletPreset.Exact);
            CulletHandle[] two = { Nth(1), Nth(3) };
            scene.SetTransforms(two, new[] { CulletTransform.At(0, 0, -5), CulletTransform.At(0, 0, -30) });
            scene.Refit();
            state.Cull(scene, view, exact);
            Check.Equal("0 1", Visible(scene, state), "visible after moves");
            scene.SetTransform(Nth(1), CulletTransform.At(0, 0, -20));
            scene.SetFlags(two, new[] { CulletInstanceFlags.AlwaysVisible, CulletInstanceFlags.None });
            state.Cull(scene, view, exact);
            Check.Equal("0 1", Visible(scene, state), "visible with one that always is");
            scene.SetLayers(two, new uint[] { 2, 1 });
            view.Layers = 1;
            state.Cull(scene, view, exact);
            Check.Equal("0", Visible(scene, state), "visible after layers");
            scene.SetBounds(Nth(0), new CulletBox(0, 0, 100, 1, 1, 101));
            state.Cull(scene, view, exact);
            Check.Equal("3", Visible(scene, state), "visible with bounds behind the eye");
            scene.SetBounds(Nth(0), 0.5f);
            scene.SetBounds(Nth(3), CulletBounds.None);
            state.Cull(scene, view, exact);
            Check.Equal("0 3", Visible(scene, state), "visible with one without bounds");
            scene.SetBounds(Nth(0), CulletBounds.Mesh);
            scene.Remove(two);
            CulletHandle again = scene.Add(new CulletInstance(0, CulletTransform.At(0, 0, -4), 15));
            Check.That(again.Generation == 1, "the generation of an index that is used again");
            scene.Remove(Nth(0));
            scene.Commit();
            state.Cull(scene, view, exact);
            Check.Equal("5", Visible(scene, state), "visible after removals");
        }

        static void Draws()
        {
            using (CulletScene scene = Build())
            using (var state = new CulletState())
            {
                CulletMeshInfo info = scene.MeshInfo(0);
                Check.That(info.PositionCount == 8 && info.IndexCount == 36 && info.PartCount == 1, "the mesh");
                Check.That(info.Min.X == -1 && info.Max.Z == 1 && info.ClusterCount > 0, "the box of the mesh");
                var positions = new float[24];
                var indices = new uint[36];
                scene.ReadMesh(0, positions, indices);
                Check.That(positions.SequenceEqual(Cube), "positions");
                Check.That(indices.OrderBy(i => i).SequenceEqual(Faces.OrderBy(i => i)), "indices");
                scene.ReadMesh(0, null, indices);
                CulletPart[] parts =
                {
                    new CulletPart { TriangleCount = 6, Material = 3 },
                    new CulletPart { FirstTriangle = 6, TriangleCount = 6, Material = 4,
                        Flags = CulletMeshFlags.Blended }
                };
                uint second = scene.AddMesh(Cube, Faces, parts: parts);
                scene.Add(new CulletInstance(second, CulletTransform.At(0, 0, -5), 16));
                scene.Commit();
                var draws = new CulletDraws();
                CulletMeshPlace[] places = { new CulletMeshPlace { FirstIndex = 1000, BaseVertex = 7 } };
                CulletSettings settings = CulletSettings.Preset(CulletPreset.Exact);
                settings.Output = CulletOutput.Instances;
                state.Cull(scene, Ahead(), settings);
                state.Draws(scene, draws, places);
                Check.Equal(3, draws.Commands.Length, "commands");
                Check.That(draws.Instances.Length >= 2 && draws.Indices.Length == 0, "instances of draws");
                Check.That(draws.Keys[2].Material == 4
                    && draws.Keys[2].State == (CulletDrawState.Blended | CulletDrawState.TwoSided),
                    "the blended draw is the last");
                int wall = draws.Keys[0].Mesh == 0 ? 0 : 1;
                Check.That(draws.Commands[wall].FirstIndex == 1000
                    && draws.Commands[wall].BaseVertex == 7, "the place of a mesh");
                Check.Equal("36 1", $"{draws.Commands[wall].IndexCount} {draws.Commands[wall].InstanceCount}",
                    "the wall's draw");
                settings.Output = CulletOutput.Triangles;
                state.Cull(scene, Ahead(), settings);
                state.Draws(scene, draws);
                Check.That(draws.Indices.Length >= 36 + 6, "indices of triangles");
                // Fewer are drawn into the same arrays.
                state.Cull(scene, Ahead(500));
                state.Draws(scene, draws);
                Check.That(draws.Commands.Length == 0 && draws.Instances.Length == 0, "no draws");
            }
        }

        static void Sights(CulletScene scene)
        {
            CulletSegment[] three =
            {
                new CulletSegment { To = At(0, 0, -30) },
                    new CulletSegment { From = At(0, 20, 0), To = At(0, 20, -30) },
                new CulletSegment { From = At(double.NaN, 0, 0), To = At(0, 0, -30) }
            };
            var found = new CulletSight[3];
            scene.LinesOfSight(three, found);
            Check.That(found[0].Blocked == 1 && found[0].Handle.Equals(Nth(0)), "the blocker");
            Check.That(Math.Abs(found[0].Share - 0.3) < 1e-9
                && Math.Abs(found[0].Point.Z + 9) < 1e-6, "where it blocks");
            Check.That(found[1].Blocked == 0 && found[2].Blocked == 0, "free lines");
            var options = new CulletSightOptions { IgnoredCount = 1 };
            options.Ignored.First = Nth(0);
            scene.LinesOfSight(three, found, options);
            Check.That(found[0].Handle.Equals(Nth(1)), "the blocker behind one that is ignored");
            CulletBox[] to =
            {
                new CulletBox(-1, -1, -21, 1, 1, -20), new CulletBox(-1, 30, -21, 1, 31, -20),
                    new CulletBox(1, 0, 0, 0, 1, 1)
            };
            var results = new CulletFound[3];
            scene.BoxToBox(new CulletBox(-1, -1, -1, 1, 1, 1), to, results);
            Check.That(results.SequenceEqual(new[] { CulletFound.Hidden, CulletFound.Visible, CulletFound.Outside }),
                "boxes");
            scene.BoxToBox(new CulletBox(-1, -1, -1, 1, 1, 1), to, results,
                new CulletBoxSightOptions { IgnoredLayers = 1 });
            Check.Equal(CulletFound.Visible, results[0], "a box behind what hides nothing");
        }

        static void Regions(CulletScene scene)
        {
            var eyes = new CulletEyeBox { Min = At(-0.25, -0.25, -0.25), Max = At(0.25, 0.25, 0.25) };
            using (var region = new CulletRegion())
            {
                Check.Refused(CulletStatus.NoResult, "region", () => region.Slots());
                region.Cull(scene, eyes);
                uint[] slots = region.Slots();
                Check.That(slots.Length == 3 && !slots.Contains(scene.Slot(Nth(1))), "what a region sees");
                region.Cull(scene, eyes, Ahead());
                Check.That(region.Slots().SequenceEqual(new[] { scene.Slot(Nth(0)) }),
                    "what a region with a view sees");
                region.Cull(scene, eyes, null, new CulletRegionSettings { IgnoredLayers = 1 });
                Check.That(region.Slots().SequenceEqual(new[] { scene.Slot(Nth(2)) }), "what a region sees in a layer");
            }
        }

        static void Candidates(CulletScene scene, CulletState state)
        {
            CulletSettings exact = CulletSettings.Preset(CulletPreset.Exact);
            ulong[] words = { ~(1ul << (int)scene.Slot(Nth(0))) };
            state.CullAmong(scene, Ahead(), words, exact);
            Check.Equal("1", Visible(scene, state), "visible among candidates");
            Check.Refused(CulletStatus.InvalidValue, "words", () => state.CullAmong(scene, Ahead(), null, exact));
        }

        static void Shadows(CulletScene scene, CulletState camera)
        {
            CulletView view = Ahead();
            var shadow = new CulletShadow { Light = CulletLight.Directional(At(0, -1, 0)), Receivers = camera };
            CulletSettings exact = CulletSettings.Preset(CulletPreset.Exact);
            camera.Cull(scene, view, exact);
            using (var state = new CulletState())
            {
                state.CullShadow(scene, view, shadow, exact);
                Check.Equal("0 2", Visible(scene, state), "what casts shadows");
                shadow.SliceNear = 0.1;
                shadow.SliceFar = 5;
                state.CullShadow(scene, view, shadow, exact);
                Check.Equal("", Visible(scene, state), "what casts shadows into a cascade before the wall");
                shadow = new CulletShadow { Light = CulletLight.Spot(At(0, 60, -10), At(0, -1, -0.01), 100, 0.5) };
                CulletView map = CulletView.LookAt(At(0, 60, -10), At(0, 0, -10.5), 0.9, 1, 512, 512);
                map.Layers = 1;
                shadow.Map = map;
                state.CullShadow(scene, view, shadow, exact);
                Check.That(!Visible(scene, state).Contains("2"), "a map that does not see the tower's layer");
                shadow.Margin = -1;
                Check.Refused(CulletStatus.InvalidValue, "margin is -1", () => state.CullShadow(scene, view, shadow));
            }
        }

        static void Lights(CulletScene scene)
        {
            CulletLight[] four =
            {
                CulletLight.Directional(At(0, -1, 0)), CulletLight.Point(At(0, 0, -8), 3),
                    CulletLight.Point(At(0, 0, 20), 3),
                CulletLight.Point(At(2, 0, -6), 0)
            };
            var reasons = new CulletLightReason[4];
            using (var state = new CulletState())
            {
                Check.Refused(CulletStatus.NoResult, "", () => state.CullLights(scene, four, reasons));
                state.Cull(scene, Ahead(), CulletSettings.Preset(CulletPreset.Exact));
                state.CullLights(scene, four, reasons);
            }
            Check.That(reasons.SequenceEqual(new[]
            {
                CulletLightReason.Kept, CulletLightReason.Kept, CulletLightReason.Frustum, CulletLightReason.Unlit
            }), "lights");
        }

        static void Eyes(CulletScene scene, CulletState state)
        {
            CulletView left = Ahead(11), right = Ahead(11.2);
            state.CullStereo(scene, left, right);
            var eyes = new byte[4];
            Check.That(state.VisibleEyes(scene, left, right, eyes) >= 1 && eyes[0] == 3, "eyes");
        }

        static void Occlusion()
        {
            CulletBox[] tests =
            {
                new CulletBox(-1, -1, -20, 1, 1, -19), new CulletBox(-1, -1, -8, 1, 1, -7),
                    new CulletBox(500, 0, -20, 501, 1, -19)
            };
            var found = new CulletFound[3];
            var nearness = new float[64 * 40];
            using (var buffer = new CulletOcclusion(64, 40))
            {
                Check.Refused(CulletStatus.NoResult, "", () => buffer.TestBoxes(tests, found));
                buffer.Begin(Ahead());
                buffer.DrawBoxes(new[] { new CulletBox(-5, -5, -110, 5, 5, -109) }, CulletTransform.At(0, 0, 100));
                buffer.TestBoxes(tests, found);
                Check.That(found.SequenceEqual(new[] { CulletFound.Hidden, CulletFound.Visible,
                    CulletFound.Outside }), "tests");
                buffer.Read(nearness);
                Check.That(nearness[20 * 64 + 32] > 0.1f && nearness[20 * 64 + 32] <= 1f / 9, "nearness");
                buffer.Begin(Ahead(), At(0, 0, -100));
                float[] sheet = { -5, -5, -10, 5, -5, -10, 5, 5, -10, -5, 5, -10 };
                uint[] faces = { 0, 1, 2, 0, 2, 3 };
                buffer.DrawTriangles(sheet, faces, false, CulletTransform.At(0, 0, 0));
                var shifted = tests.Select(b =>
                    new CulletBox(b.Min.X, b.Min.Y, b.Min.Z + 100, b.Max.X, b.Max.Y, b.Max.Z + 100));
                buffer.TestBoxes(shifted.ToArray(), found);
                Check.That(found[0] == CulletFound.Hidden
                    && found[1] == CulletFound.Visible, "tests relative to an origin");
            }
        }

        static void Views()
        {
            CulletView view = Ahead();
            Check.That(view.Width == 640 && view.Height == 400 && view.Layers == uint.MaxValue, "a view");
            var numbers = new double[16];
            for (int i = 0; i < 16; i++) numbers[i] = view.ClipFromWorld[i];
            CulletView same = CulletView.FromMatrix(numbers, CulletDepth.Reversed, 640, 400);
            Check.Equal(view.ClipFromWorld[11], same.ClipFromWorld[11], "a number of the matrix");
            var camera = new CulletCamera
                { Direction = At(0, 0, -1), Up = At(0, 1, 0), FovY = 0.9, NearPlane = 0.1,
                    FarPlane = double.PositiveInfinity };
            same = CulletView.FromCamera(camera, CulletDepth.Reversed, 640, 400);
            for (int i = 0; i < 16; i++)
                Check.That(Math.Abs(numbers[i] - same.ClipFromWorld[i]) < 1e-12, $"number {i} of a camera's matrix");
        }
    }
}
