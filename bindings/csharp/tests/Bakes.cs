// Levels, visible sets and bakes by the classes: a house of two rooms with a door between them, baked and saved by a
// library that can, then opened and culled by one that need not.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;

namespace Cullet.Tests
{
    static unsafe class Bakes
    {
        const int Rings = 24, Sides = 40, Views = 6;

        /// <summary>Lowest and highest corner of each wall; the last three leave a door between the rooms.</summary>
        static readonly double[][] Walls =
        {
            new[] { -9, -1, -5, 9, 0, 5.0 }, new[] { -9, 3, -5, 9, 4, 5.0 }, new[] { -9, -1, -5, -8, 4, 5.0 },
            new[] { 8, -1, -5, 9, 4, 5.0 }, new[] { -9, -1, -5, 9, 4, -4.0 }, new[] { -9, -1, 4, 9, 4, 5.0 },
            new[] { -.5, -1, -4.5, .5, 4, -1 }, new[] { -.5, -1, 1, .5, 4, 4.5 },
            new[] { -.5, 2.2, -1.5, .5, 4, 1.5 }
        };

        static CulletDouble3 At(double x, double y, double z) => new CulletDouble3(x, y, z);

        /// <summary>Mesh 0 is a block, mesh 1 a ball. Balls stand in each corner of a room.</summary>
        static CulletScene House()
        {
            var scene = new CulletScene();
            scene.AddMesh(Answers.Cube, Answers.Faces, CulletMeshFlags.OneSided);
            var ball = new List<float>();
            var around = new List<uint>();
            for (int ring = 0; ring <= Rings; ring++)
                for (int side = 0; side < Sides; side++)
                {
                    double up = Math.PI * ring / Rings, turn = 2 * Math.PI * side / Sides;
                    // Both poles are one point.
                    double wide = ring % Rings == 0 ? 0 : Math.Sin(up);
                    ball.Add((float)(wide * Math.Cos(turn) + 0));
                    ball.Add((float)Math.Cos(up));
                    ball.Add((float)(wide * Math.Sin(turn) + 0));
                }
            for (uint ring = 0; ring < Rings; ring++)
                for (uint side = 0; side < Sides; side++)
                {
                    uint a = ring * Sides + side, b = ring * Sides + (side + 1) % Sides, c = a + Sides, d = b + Sides;
                    if (ring > 0) around.AddRange(new[] { a, b, c });
                    if (ring + 1 < Rings) around.AddRange(new[] { b, d, c });
                }
            scene.AddMesh(ball.ToArray(), around.ToArray(), CulletMeshFlags.OneSided);
            foreach (double[] w in Walls)
            {
                var half = CulletLinear.Scale(
                    (float)(w[3] - w[0]) / 2, (float)(w[4] - w[1]) / 2, (float)(w[5] - w[2]) / 2);
                var middle = At((w[0] + w[3]) / 2, (w[1] + w[4]) / 2, (w[2] + w[5]) / 2);
                scene.Add(new CulletInstance(0, new CulletTransform(half, middle)));
            }
            for (int i = 0; i < 6; i++)
            {
                var place = At(i % 2 == 1 ? 6 + i * .1 : -6 - i * .1, .5 + .25 * i, i / 2 > 0 ? 3.2 - i * .2 : -3.2);
                scene.Add(new CulletInstance(1, new CulletTransform(CulletLinear.Scale(.3f, .3f, .3f), place)));
            }
            scene.Commit();
            return scene;
        }

        static CulletView Inside(int number)
        {
            CulletDouble3 eye = At(number % 2 == 1 ? 5 - number * .5 : -5 + number * .5, 1.5, -2 + number * .7);
            var target = At(eye.X + (number % 2 == 1 ? -1 : 1), 1.4, eye.Z + .3 * number - .6);
            return CulletView.LookAt(eye, target, 1.2, 0.05, 640, 400);
        }

        /// <summary>Handles that a view sees where cells and sets alone hide.</summary>
        static string Sees(CulletScene scene, CulletState state, int view, uint pvs)
        {
            CulletSettings settings = CulletSettings.Preset(CulletPreset.Balanced);
            settings.Occlusion = 0;
            settings.Portals = 0;
            settings.Pvs = pvs;
            state.Cull(scene, Inside(view), settings);
            var handles = new CulletHandle[64];
            int count = state.VisibleHandles(scene, handles);
            return string.Join(" ", handles.Take(count).Select(h => h.Index).OrderBy(i => i));
        }

        static CulletPvsSettings Few() => new CulletPvsSettings
        {
            Boxes = new[] { new CulletEyeBox { Min = At(-8, 0, -4), Max = At(8, 3, 4) } },
            Grid = new CulletUInt3 { X = 8, Y = 1, Z = 4 },
            Rays = 60000
        };

        /// <summary>Bakes a house into a folder, by a library that was built with bakes.</summary>
        internal static void Bake(string folder)
        {
            Func<string, string> file = name => Path.Combine(folder, name);
            using (CulletScene scene = House())
            using (var state = new CulletState())
            {
                Progress(scene);
                CulletLevels[] levels = scene.Levels(1);
                Check.That(levels.Length == 1 && levels[0].Mesh >= 2 && levels[0].GroupCount >= 2, "the ball's levels");
                Check.That(levels[0].LeastError > 0 && levels[0].MostError >= levels[0].LeastError, "errors of levels");
                scene.Commit();
                Check.Equal(2u, CulletBake.Occluders(scene, true), "meshes with occluders");
                using (CulletPvs sets = CulletBake.Sets(scene, Few()))
                {
                    Ask(sets);
                    File.WriteAllBytes(file("house.cpvs"), sets.Write());
                    Shares(scene, sets, file("units"));
                }
                Wrong(scene);
                Check.Equal(3u, CulletBake.Cells(scene), "cells");
                using (CulletPvs sets = CulletBake.Sets(scene))
                {
                    CulletPvsInfo info = sets.Info();
                    Check.That(info.Targets == CulletPvsTargets.Cells && info.CellCount == 3
                        && info.MeanMissing == 0, "sets of cells");
                    Check.Refused(CulletStatus.NotFound, "cullet_scene_cell_of", () => sets.Cells());
                    File.WriteAllBytes(file("rooms.cpvs"), sets.Write());
                }
                CulletBake.Save(scene, file("house.glb"));
                Check.Throws<ArgumentNullException>("path", () => CulletBake.Save(scene, null));
                Check.Refused(CulletStatus.File, "house.xyz", () => CulletBake.Save(scene, file("house.xyz")));
            }
        }

        static void Progress(CulletScene scene)
        {
            var shares = new List<double>();
            var options = new CulletBakeOptions { Threads = 2, Step = share => { shares.Add(share); return false; } };
            Check.Refused(CulletStatus.Stopped, "options->step", () => CulletBake.Levels(scene, options));
            Check.That(shares.Count == 1 && scene.Levels(1).Length == 0, "a bake that was stopped");
            options.Step = share => { throw new TimeoutException("thrown by the step"); };
            Check.Throws<TimeoutException>("thrown by the step", () => CulletBake.Levels(scene, options));
            Check.Equal(0, scene.Levels(1).Length, "levels after an exception");
            shares.Clear();
            options.Step = share =>
            {
                shares.Add(share);
                GC.Collect();
                return true;
            };
            Check.That(CulletBake.Levels(scene, options) >= 1, "meshes with levels");
            Check.That(shares.Count == 2 && shares[1] == 1 && shares[0] <= 1, "progress");
        }

        static void Ask(CulletPvs sets)
        {
            CulletPvsInfo info = sets.Info();
            Check.That(info.CellCount == 32 && info.TargetCount == 15 && info.Targets == CulletPvsTargets.Instances
                && info.Rays > 0, "the contents of sets");
            CulletEyeBox[] cells = sets.Cells();
            float[] missing = sets.Missing();
            Check.That(cells.Length == 32 && missing.Length == 32 && missing.All(m => m >= 0 && m <= 1), "cells");
            Check.That(missing.Max() <= info.MostMissing + 1e-6, "the most that is missing");
            CulletEyeBox fifth = cells[5];
            CulletDouble3 middle = At((fifth.Min.X + fifth.Max.X) / 2, 1, (fifth.Min.Z + fifth.Max.Z) / 2);
            Check.Equal(5u, sets.CellOf(middle), "the cell of a point");
            var of = new uint[3];
            sets.CellsOf(new[] { middle, At(0, 900, 0) }, of);
            Check.That(of[0] == 5 && of[1] == uint.MaxValue && of[2] == 0, "the cells of points");
            var targets = new uint[15];
            int one = sets.Visible(new uint[] { 5 }, targets);
            Check.That(one > 0 && one <= 15 && targets.Take(one - 1).Zip(targets.Skip(1), (a, b) => a < b).All(b => b),
                "what may be seen");
            int all = sets.Visible(Enumerable.Range(0, 32).Select(i => (uint)i).ToArray(), targets);
            Check.That(all >= one, "what may be seen from all cells");
            Check.Equal(0, sets.Visible(null, null), "what is seen from nowhere");
            Check.Refused(CulletStatus.NotFound, "the sets have 32 cells",
                () => sets.Visible(new uint[] { 32 }, targets));
            Check.Throws<ArgumentException>("room for 0", () => sets.Visible(new uint[] { 5 }, null));
            Check.Refused(CulletStatus.TooSmall, "", () => sets.Visible(new uint[] { 5 }, new uint[1]));
            Check.Throws<ArgumentException>("room for 1", () => sets.CellsOf(new CulletDouble3[2], new uint[1]));
            byte[] bytes = sets.Write();
            using (CulletPvs again = CulletPvs.Read(bytes))
                Check.That(again.Write().SequenceEqual(bytes), "the bytes of sets that were read");
            Check.Refused(CulletStatus.File, "", () => CulletPvs.Read(bytes.Take(bytes.Length - 1).ToArray()));
            bytes[bytes.Length / 2] ^= 16;
            Check.Refused(CulletStatus.File, "", () => CulletPvs.Read(bytes));
        }

        /// <summary>Units in a folder make what one bake makes.</summary>
        static void Shares(CulletScene scene, CulletPvs sets, string folder)
        {
            for (int share = 0; share < 2; share++)
            {
                var options = new CulletBakeOptions { Share = share, ShareCount = 2, Folder = folder };
                // No round of these is known to be the last, so a share ends with all of it.
                using (CulletPvs joined = CulletBake.Sets(scene, Few(), options))
                    Check.That(joined.Write().SequenceEqual(sets.Write()), "the bytes of joined shares");
                using (CulletScene part = House())
                    Check.Refused(CulletStatus.Stopped, "this share is done", () => CulletBake.Levels(part, options));
            }
            using (CulletScene whole = House())
            {
                CulletBake.Levels(whole, new CulletBakeOptions { Folder = folder });
                Check.That(whole.Levels(1).SequenceEqual(scene.Levels(1)), "levels of joined shares");
            }
        }

        static void Wrong(CulletScene scene)
        {
            Check.Throws<ArgumentNullException>("scene", () => CulletBake.Levels(null));
            Check.Refused(CulletStatus.InvalidValue, "options->threads is 1025",
                () => CulletBake.Levels(scene, new CulletBakeOptions { Threads = 1025 }));
            Check.Refused(CulletStatus.InvalidValue, "options->threads",
                () => CulletBake.Levels(scene, new CulletBakeOptions { Threads = -1 }));
            Check.Refused(CulletStatus.InvalidValue, "no units",
                () => CulletBake.Cells(scene, 0, null, new CulletBakeOptions { Folder = "units" }));
            Check.Refused(CulletStatus.InvalidValue, "voxel", () => CulletBake.Cells(scene, -1));
            Check.Refused(CulletStatus.InvalidValue, "keep_angle",
                () => CulletBake.Sets(scene, new CulletPvsSettings { KeepAngle = 4 }));
            Check.Refused(CulletStatus.InvalidValue, "boxes_are_cells",
                () => CulletBake.Sets(scene, new CulletPvsSettings { BoxesAreCells = true }));
        }

        /// <summary>Opens what was baked, by a library without bakes.</summary>
        internal static void Sets(string folder)
        {
            Func<string, string> file = name => Path.Combine(folder, name);
            Levels();
            using (CulletScene scene = CulletScene.Open(file("house.glb")))
            using (CulletScene other = House())
            using (var state = new CulletState())
            using (CulletPvs house = CulletPvs.Open(file("house.cpvs")))
            using (CulletPvs rooms = CulletPvs.Open(file("rooms.cpvs")))
            {
                Check.Equal(1, scene.Levels(1).Length, "levels of a file");
                Check.Equal(2u, scene.TakeOccluders(true), "occluders of a file");
                Check.Equal(0u, other.TakeOccluders(), "occluders without a file");
                int hidden = 0;
                foreach (CulletPvs sets in new[] { house, rooms })
                    for (int view = 0; view < Views; view++)
                    {
                        scene.SetPvs(null);
                        string without = Sees(scene, state, view, 1);
                        scene.SetPvs(sets);
                        string with = Sees(scene, state, view, 1);
                        Check.That(with.Split(' ').All(without.Split(' ').Contains), "what sets show, a view shows");
                        Check.Equal(without, Sees(scene, state, view, 0), "a view with the sets switched off");
                        hidden += with == without ? 0 : 1;
                    }
                Check.That(hidden >= 2, "sets hide something");
                other.SetTransform(new CulletHandle(), CulletTransform.At(0, 9, 0));
                Check.Refused(CulletStatus.File, "another scene", () => other.SetPvs(house));
                Check.Refused(CulletStatus.File, "this scene has none", () => other.SetPvs(rooms));
                house.Dispose();
                Check.Throws<ObjectDisposedException>("CulletPvs", () => scene.SetPvs(house));
                Check.Throws<ObjectDisposedException>("CulletPvs", () => house.Info());
                Check.Refused(CulletStatus.File, "no such file", () => CulletPvs.Open("no such file"));
                Check.Throws<EntryPointNotFoundException>("cullet_bake_levels", () => CulletBake.Levels(scene));
            }
        }

        /// <summary>A cube in the place of the ball, far away.</summary>
        static void Levels()
        {
            using (CulletScene scene = House())
            using (var state = new CulletState())
            {
                Check.Refused(CulletStatus.NoResult, "", () => Check.Equal(0.0, state.LodPixels, "unreachable"));
                Check.Refused(CulletStatus.InvalidValue, "error is NaN", () => scene.AddLod(1, 0, float.NaN));
                Check.Refused(CulletStatus.NotFound, "", () => scene.AddLod(9, 0, 1));
                Check.Refused(CulletStatus.NotFound, "", () => scene.Levels(9));
                uint coarse = scene.AddMesh(Answers.Cube, Answers.Faces, CulletMeshFlags.OneSided);
                scene.AddLod(1, coarse, .8f);
                CulletLevels[] levels = scene.Levels(1);
                Check.That(levels.Length == 1 && levels[0].Mesh == coarse && levels[0].TriangleCount == 12
                    && levels[0].MostError == .8f, "a level by hand");
                scene.Commit();
                CulletSettings settings = CulletSettings.Preset(CulletPreset.Balanced);
                settings.Occlusion = 0;
                settings.LodPixels = 1;
                CulletView far = CulletView.LookAt(At(0, 1.5, -900), At(6, 1, -3), .9, .1, 640, 400);
                state.Cull(scene, far, settings);
                Check.Equal(1.0, state.LodPixels, "pixels that levels may be off by");
                var draws = new CulletDraws();
                state.Draws(scene, draws);
                Check.That(Has(draws, coarse, 1) && !Has(draws, 1, 0), "the coarse mesh is drawn");
                scene.ClearLevels(1);
                Check.Equal(0, scene.Levels(1).Length, "levels that were taken away");
                state.Cull(scene, far, settings);
                state.Draws(scene, draws);
                Check.That(!Has(draws, coarse, 1) && Has(draws, 1, 0), "the mesh itself is drawn");
            }
        }

        static bool Has(CulletDraws draws, uint mesh, uint level)
        {
            for (int i = 0; i < draws.Keys.Length; i++)
                if (draws.Keys[i].Mesh == mesh && draws.Keys[i].Level == level) return true;
            return false;
        }
    }
}
