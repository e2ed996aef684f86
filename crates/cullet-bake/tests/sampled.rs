//! Sets of scenes by sampled lines: rays against brute force, sets against pictures, bytes against other threads.

use std::sync::atomic::{AtomicU32, Ordering};

use cullet::mesh::{Alpha, Part};
use cullet::{Handle, Instance, Mesh, MeshData, Scene, Transform};
use cullet_bake::sampled::{
    Granularity, RayTree, RayTreeOptions, SampledBake, SampledError, SampledSettings, ScenePvs,
    SolidVoxels, ViewCells, bake_sampled, check_pictures, scene_hash,
};
use cullet_bake::work::{Rounds, RunEnd, RunOptions, UnitFolder, split};
use cullet_cells::query::{Sight, SightOptions, line_of_sight};
use cullet_testkit::{Folder, Rng, cases, meshes, scenes};

/// A square of this half side in the plane z = 0, its front towards +z.
fn square(half: f32, part: Part) -> Mesh {
    let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let positions = positions.map(|[x, y]: [f32; 2]| [x * half, y * half, 0.0]).to_vec();
    let parts = vec![Part { triangle_count: 2, ..part }];
    let data =
        MeshData { positions, indices: vec![0, 1, 2, 0, 2, 3], parts, ..MeshData::default() };
    Mesh::new(data).expect("a good mesh")
}

const TWO_SIDED: Part = Part {
    first_triangle: 0,
    triangle_count: 0,
    material: 0,
    two_sided: true,
    alpha: Alpha::Opaque,
};

/// A wall of a kind at z = 0, and a plate on each side of it.
fn walled(wall: Part) -> (Scene, [Handle; 3]) {
    let mut scene = Scene::new();
    let (wall, plate) =
        (scene.add_mesh(square(40.0, wall)), scene.add_mesh(square(0.5, TWO_SIDED)));
    let mut add = |mesh, z| {
        scene.add(Instance::new(mesh, Transform::from_translation([0.0, 1.0, z]))).expect("a mesh")
    };
    let handles = [add(wall, 0.0), add(plate, 3.0), add(plate, -3.0)];
    scene.commit(&cullet::Culler::default());
    (scene, handles)
}

/// Cells on both sides of the wall: 0 in front of it, 1 behind.
fn both_sides() -> ViewCells {
    let cells = ViewCells::grid([[-2.0, 0.0, -6.0], [2.0, 2.0, 6.0]], [1, 1, 2]).expect("a box");
    assert_eq!(cells.cell_of([0.0, 1.0, 5.0]), Some(1));
    cells
}

fn some_rays(rays: u64) -> SampledSettings {
    // Nothing but what lines find.
    SampledSettings::default().with_rays(rays).with_missing(0.0)
}

fn sees(scene: &Scene, settings: &SampledSettings) -> ScenePvs {
    let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
    bake_sampled(&tree, &both_sides(), settings, 2).expect("good settings")
}

fn row(pvs: &ScenePvs, cell: u32, handles: &[Handle; 3]) -> [bool; 3] {
    handles.map(|h| pvs.visible.has(cell, h.index))
}

#[test]
fn rays_meet_what_brute_force_meets() {
    let mut rng = Rng(1);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..cases(60) {
        let mut scene = scenes::mixed_scene(&mut rng);
        scene.commit(&cullet::Culler::default());
        for granularity in [Granularity::Instance, Granularity::Cluster] {
            let options = RayTreeOptions { granularity, ..RayTreeOptions::default() };
            let Ok(tree) = RayTree::new(&scene, &options) else { continue };
            for k in 0..300 {
                let from = rng.vector(9.0);
                let to = rng.vector(3.0);
                let mut direction: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
                if k % 10 == 0 {
                    direction = [[0.0, 0.0, -1.0], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0]][rng.index(3)];
                }
                let (fast, slow) =
                    (tree.first_hit(from, direction), tree.first_hit_ref(from, direction));
                assert_eq!(fast, slow, "from {from:?} along {direction:?}");
                hits += u32::from(slow.is_some());
                misses += u32::from(slow.is_none());
            }
        }
    }
    assert!(hits > cases(2_000) && misses > cases(2_000), "{hits} hits, {misses} misses");
}

#[test]
fn rays_meet_what_lines_of_sight_meet() {
    let mut rng = Rng(2);
    let mut blocked = 0;
    let options = SightOptions::default();
    for _ in 0..cases(30) {
        let mut scene = scenes::random_scene(&mut rng, 30);
        scene.commit(&cullet::Culler::default());
        let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("instances");
        for _ in 0..200 {
            let (from, to) = (rng.vector(14.0), rng.vector(14.0));
            let direction: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
            let hit = tree.first_hit(from, direction).filter(|h| h.distance < 1.0);
            match line_of_sight(&scene, from, to, &options) {
                Sight::Blocked(by) => {
                    // Two at almost one place may change places.
                    let hit = hit.expect("the ray is stopped as well");
                    let near = (hit.distance - by.share).abs() < 1e-6;
                    assert!(
                        near && (hit.target == by.handle.index
                            || (hit.distance - by.share).abs() < 1e-9)
                    );
                    blocked += 1;
                }
                // A flat one is not looked at by rays, nor one stretched beyond numbers.
                Sight::Clear => assert_eq!(hit, None),
            }
        }
    }
    assert!(blocked > cases(500), "{blocked}");
}

#[test]
fn a_wall_hides_what_is_behind_it_and_only_that() {
    let (scene, handles) = walled(TWO_SIDED);
    let pvs = sees(&scene, &some_rays(50_000));
    assert_eq!(row(&pvs, 1, &handles), [true, true, false]);
    assert_eq!(row(&pvs, 0, &handles), [true, false, true]);
    assert_eq!(pvs.found.count(), 4);
    assert_eq!(pvs.visible_pairs(), 4);
    assert!(pvs.buried.is_empty());
    assert_eq!(pvs.seen_from(0).collect::<Vec<_>>(), [handles[0].index, handles[2].index]);
}

#[test]
fn a_one_sided_wall_is_looked_through_from_behind() {
    let (scene, handles) = walled(Part { two_sided: false, ..TWO_SIDED });
    let pvs = sees(&scene, &some_rays(50_000));
    // Its front looks towards +z, from where it hides; from behind it is not drawn, and so not seen either.
    let found = |cell: u32| handles.map(|h| pvs.found.has(cell, h.index));
    assert_eq!(found(1), [true, true, false]);
    assert_eq!(found(0), [false, true, true]);
    assert_eq!(row(&pvs, 0, &handles), [true; 3], "the cell touches the wall");
}

#[test]
fn masked_and_blended_walls_are_seen_and_hide_nothing() {
    for alpha in [Alpha::Masked, Alpha::Blended] {
        let (scene, handles) = walled(Part { alpha, ..TWO_SIDED });
        let pvs = sees(&scene, &some_rays(50_000));
        for cell in 0..2 {
            assert_eq!(row(&pvs, cell, &handles), [true; 3], "{alpha:?} {cell}");
        }
    }
    let (mut scene, handles) = walled(TWO_SIDED);
    let flags = cullet::InstanceFlags { transparent: true, ..cullet::InstanceFlags::default() };
    scene.set_flags(handles[0], flags).expect("an instance");
    let pvs = sees(&scene, &some_rays(50_000));
    assert_eq!(row(&pvs, 0, &handles), [true; 3]);
}

#[test]
fn what_is_large_or_near_is_kept_by_its_angle_and_neighbours_are_joined() {
    let (scene, handles) = walled(TWO_SIDED);
    let far = |z: f64| -> ViewCells {
        ViewCells::grid([[-1.0, 0.0, z], [1.0, 2.0, z + 1.0]], [1, 1, 1]).expect("a box")
    };
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let keeps = |z: f64, angle: f64| {
        let settings = some_rays(20_000).with_keep_angle(angle);
        let pvs = bake_sampled(&tree, &far(z), &settings, 1).expect("good settings");
        pvs.visible.has(0, handles[2].index)
    };
    // The plate behind the wall, of radius 0.71 at a distance of 4 to 5: 0.36 radians at the most.
    assert!(!keeps(1.0, std::f64::consts::PI) && !keeps(1.0, 0.37) && keeps(1.0, 0.3));
    let settings = some_rays(50_000).with_union_radius(Some(0.0));
    let pvs = sees(&scene, &settings);
    assert_eq!(row(&pvs, 0, &handles), [true; 3], "the cells touch");
    assert_eq!(pvs.found.count(), 4);
}

#[test]
fn what_moves_in_ways_unknown_hides_nothing_and_is_kept() {
    let (mut scene, handles) = walled(TWO_SIDED);
    let bounds = cullet::scene::BoundsOverride::None;
    scene.set_bounds(handles[0], bounds).expect("an instance");
    let mut nowhere = Transform::IDENTITY;
    nowhere.translation[1] = f64::NAN;
    scene.set_transform(handles[1], nowhere).expect("an instance");
    let pvs = sees(&scene, &some_rays(50_000));
    for cell in 0..2 {
        assert_eq!(row(&pvs, cell, &handles), [true; 3]);
    }
}

#[test]
fn bytes_are_the_same_for_any_number_of_threads() {
    let scene = scenes::city(5, 1, 60);
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let region = [[-60.0, 0.5, -60.0], [60.0, 4.0, 60.0]];
    let cells = ViewCells::adaptive(&tree, &[region], 30, 1).expect("a box");
    assert_eq!(cells, ViewCells::adaptive(&tree, &[region], 30, 1).expect("a box"));
    let bake = |threads, seed| {
        let settings = some_rays(100_000).with_seed(seed);
        bake_sampled(&tree, &cells, &settings, threads).expect("good settings")
    };
    let one = bake(1, 1);
    for threads in [2, 5] {
        let other = bake(threads, 1);
        assert_eq!(other, one, "{threads} threads");
        assert_eq!(other.rows_bytes(), one.rows_bytes());
    }
    assert_ne!(bake(2, 7), one, "the seed counts");
}

#[test]
fn bytes_are_the_same_for_any_split_into_units_and_after_a_stop() {
    let scene = scenes::city(5, 1, 60);
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let region = [[-60.0, 0.5, -60.0], [60.0, 4.0, 60.0]];
    let cells = ViewCells::adaptive(&tree, &[region], 30, 1).expect("a box");
    let new = |rays| SampledBake::new(&tree, &cells, &some_rays(rays)).expect("good settings");
    let whole = bake_sampled(&tree, &cells, &some_rays(200_000), 1).expect("good settings");
    for (shares, threads) in [(&[[0, 1]][..], 2), (&[[1, 3], [2, 3], [0, 3]][..], 1)] {
        let folder = Folder::new("sampled");
        let units = UnitFolder::new(folder.root()).expect("a folder");
        let options = RunOptions { threads, folder: Some(&units), ..RunOptions::default() };
        // Stopped early, so that some of the units of a round lie there.
        let calls = AtomicU32::new(0);
        let mut stopped = new(200_000);
        let end = stopped.run(&options, &|_| calls.fetch_add(1, Ordering::Relaxed) < 120);
        assert_eq!(end.expect("a folder"), RunEnd::Stopped);
        let files = || std::fs::read_dir(folder.root()).expect("a folder").count();
        assert!(stopped.rays() < 200_000 && files() > 0, "{} files", files());
        for &share in shares {
            let mut part = new(200_000);
            let end = part.run(&RunOptions { share: Some(share), ..options }, &|_| true);
            assert_eq!(end.expect("a folder"), RunEnd::Share);
        }
        // One that was damaged is done again.
        let some = std::fs::read_dir(folder.root()).expect("a folder").flatten().next();
        std::fs::write(some.expect("a file").path(), b"SAMPUNT1").expect("written");
        let mut joined = new(200_000);
        assert_eq!(joined.run(&options, &|_| true).expect("a folder"), RunEnd::Whole);
        assert_eq!(joined.finish(), whole, "{shares:?}");
        // A larger budget goes on from the same files.
        let before = files();
        let mut more = new(300_000);
        assert_eq!(more.run(&options, &|_| true).expect("a folder"), RunEnd::Whole);
        assert!(files() > before);
        let by_itself = bake_sampled(&tree, &cells, &some_rays(300_000), 1);
        assert_eq!(more.finish(), by_itself.expect("good settings"));
    }
    let other = SampledBake::new(&tree, &cells, &some_rays(200_000).with_seed(2));
    assert_ne!(other.expect("good settings").key(), new(200_000).key(), "the seed counts");
}

#[test]
fn units_of_strangers_make_the_same_sets() {
    let scene = scenes::city(5, 1, 60);
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let region = [[-60.0, 0.5, -60.0], [60.0, 4.0, 60.0]];
    let cells = ViewCells::adaptive(&tree, &[region], 20, 1).expect("a box");
    let settings = some_rays(300_000);
    let new = || SampledBake::new(&tree, &cells, &settings).expect("good settings");
    let (mut joiner, mut stranger) = (new(), new());
    while !joiner.costs().is_empty() {
        let units = split(&joiner.costs(), 2 + joiner.round() * 7);
        assert_eq!(stranger.costs(), joiner.costs());
        let bytes = units.iter().rev().map(|items| {
            let part = stranger.run_items(items.clone(), 1, &|_| true).expect("nobody stops it");
            SampledBake::bytes_of(&part)
        });
        let mut bytes: Vec<_> = bytes.collect();
        bytes.reverse();
        for bake in [&mut joiner, &mut stranger] {
            let parts = units.iter().zip(&bytes).map(|(items, b)| bake.read(items.clone(), b));
            let parts = parts.collect::<Option<Vec<_>>>().expect("whole");
            bake.merge(parts);
        }
    }
    let whole = bake_sampled(&tree, &cells, &settings, 2).expect("good settings");
    assert_eq!(joiner.finish(), whole);
}

#[test]
fn pictures_of_a_city_show_next_to_nothing_that_the_sets_lack() {
    // As many however few cases are tried: of few poses, an unlucky one is a large share.
    const POSES: u32 = 60;
    let mut scene = scenes::city(8, 1, 150);
    scene.commit(&cullet::Culler::default());
    for granularity in [Granularity::Instance, Granularity::Cluster] {
        let options = RayTreeOptions { granularity, ..RayTreeOptions::default() };
        let tree = RayTree::new(&scene, &options).expect("a scene");
        let region = [[-96.0, 0.2, -96.0], [96.0, 3.0, 96.0]];
        let cells = ViewCells::adaptive(&tree, &[region], 80, 1).expect("a box");
        assert_eq!(cells.len(), 80);
        let pvs = bake_sampled(&tree, &cells, &some_rays(1_500_000), 2).expect("good settings");
        let all = u64::from(tree.targets().count()) * 80;
        assert!(pvs.visible_pairs() * 10 < all * 7, "{} of {all}", pvs.visible_pairs());
        let check = check_pictures(&tree, &cells, &pvs.visible, POSES, 24, 1, 2);
        assert!(check.seen > u64::from(POSES) * 5);
        assert!(check.pixel_error() < 0.001, "{check:?}");
        assert!(check.missing_share() < 0.01, "{check:?}");
        // Emptied rows are found out, every one of them.
        let none = cullet_bake::pvs::BitRows::new(80, tree.targets().count());
        let empty = check_pictures(&tree, &cells, &none, POSES, 24, 1, 2);
        assert_eq!((empty.missing, empty.seen), (check.seen, check.seen));
        assert!(empty.pixel_error() > 0.4, "{empty:?}");
    }
}

#[test]
fn the_estimate_falls_and_tells_the_size_of_what_is_missing() {
    let scene = scenes::city(6, 1, 300);
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let region = [[-72.0, 0.2, -72.0], [72.0, 3.0, 72.0]];
    let cells = ViewCells::adaptive(&tree, &[region], 40, 1).expect("a box");
    let mut bake = SampledBake::new(&tree, &cells, &some_rays(800_000)).expect("good settings");
    assert_eq!(bake.missing(), 1.0, "nothing is known yet");
    let options = RunOptions { threads: 2, ..RunOptions::default() };
    // A moment later than nothing.
    let mut first = SampledBake::new(&tree, &cells, &some_rays(100_000)).expect("good settings");
    assert_eq!(first.run(&options, &|_| true).expect("no folder"), RunEnd::Whole);
    let early = first.missing();
    assert_eq!(bake.run(&options, &|_| true).expect("no folder"), RunEnd::Whole);
    let late = bake.missing();
    assert!(late < early * 0.5 && late > 0.0 && late < 0.01, "{early} {late}");
    assert!(bake.rays() >= 800_000 && bake.spent() == 1.0);
    let pvs = bake.finish();
    assert_eq!(pvs.missing.len(), 40);
    let check = check_pictures(&tree, &cells, &pvs.visible, 40, 24, 3, 2);
    // Not a bound, but not far off either.
    assert!(check.pixel_error() < late * 4.0 + 2e-4, "{late} {check:?}");
}

#[test]
fn a_bake_ends_when_little_enough_is_missing() {
    let (scene, _) = walled(TWO_SIDED);
    let settings = SampledSettings::default().with_missing(0.01);
    let pvs = sees(&scene, &settings);
    assert!(pvs.rays < 2_000_000, "{} of 100,000,000", pvs.rays);
}

#[test]
fn a_cell_within_something_solid_is_told_and_one_in_a_room_is_not() {
    for two_sided in [true, false] {
        let mut scene = Scene::new();
        let part = Part { triangle_count: 12, two_sided, ..TWO_SIDED };
        let solid = cullet_testkit::soups::block([-5.0; 3], [5.0; 3]);
        let solid = scene.add_mesh(meshes::of_parts(solid, vec![part]));
        let solid = scene.add(Instance::new(solid, Transform::IDENTITY)).expect("a mesh");
        let room = cullet_testkit::soups::block([20.0, -5.0, -5.0], [30.0, 5.0, 5.0]);
        let room = cullet_testkit::soups::turned(room);
        let room = scene.add_mesh(meshes::of_parts(room, vec![part]));
        let room = scene.add(Instance::new(room, Transform::IDENTITY)).expect("a mesh");
        scene.commit(&cullet::Culler::default());
        let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
        let cells =
            ViewCells::grid([[-4.0, -4.0, -4.0], [29.0, 4.0, 4.0]], [3, 1, 1]).expect("a box");
        let pvs = bake_sampled(&tree, &cells, &some_rays(100_000), 1).expect("good settings");
        assert!(pvs.buried.is_empty(), "the first reaches out");
        let cells = ViewCells::grid([[-4.0; 3], [4.0; 3]], [1, 1, 1]).expect("a box");
        let pvs = bake_sampled(&tree, &cells, &some_rays(100_000), 1).expect("good settings");
        assert_eq!(pvs.buried, [0]);
        // Through a one-sided one all is seen but itself; a two-sided one shuts it in.
        let seen: Vec<u32> = pvs.seen_from(0).collect();
        let kept = solid.index;
        assert!(seen.contains(&kept), "for the eye is within its bounds");
        // Of a one-sided room the far walls turn their fronts this way.
        assert_eq!(seen.contains(&room.index), !two_sided);
        let inside =
            ViewCells::grid([[21.0, -4.0, -4.0], [29.0, 4.0, 4.0]], [1, 1, 1]).expect("a box");
        let pvs = bake_sampled(&tree, &inside, &some_rays(100_000), 1).expect("good settings");
        assert!(pvs.buried.is_empty() && pvs.visible.has(0, room.index));
    }
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let empty = Scene::new();
    let options = RayTreeOptions::default();
    assert_eq!(RayTree::new(&empty, &options).err(), Some(SampledError::Empty { instances: 0 }));
    let (scene, _) = walled(TWO_SIDED);
    let hidden = RayTreeOptions { layers: 0, ..options };
    assert_eq!(RayTree::new(&scene, &hidden).err(), Some(SampledError::Empty { instances: 3 }));
    let tree = RayTree::new(&scene, &options).expect("a scene");
    let cells = both_sides();
    let refused = |settings: SampledSettings| {
        matches!(
            SampledBake::new(&tree, &cells, &settings).err(),
            Some(SampledError::Setting { .. })
        )
    };
    let fine = SampledSettings::default();
    assert!(refused(fine.with_rays(0)));
    assert!(refused(fine.with_missing(f64::NAN)) && refused(fine.with_missing(1.5)));
    assert!(refused(fine.with_keep_angle(0.0)) && refused(fine.with_keep_angle(4.0)));
    assert!(refused(fine.with_union_radius(Some(-1.0))));
    assert!(refused(fine.with_union_radius(Some(f64::NAN))));
    let no_cells = ViewCells::default();
    let none = SampledBake::new(&tree, &no_cells, &fine);
    assert!(matches!(none.err(), Some(SampledError::Cells { cells: 0, .. })));
    for strange in [[f64::NAN, 0.0, 0.0], [0.0; 3], [f64::INFINITY, 0.0, 1.0]] {
        assert_eq!(tree.first_hit([0.0; 3], strange), None);
    }
    assert_eq!(tree.first_hit([f64::NAN; 3], [1.0, 0.0, 0.0]), None);
    assert!(matches!(ViewCells::adaptive(&tree, &[], 5, 1), Err(SampledError::Cells { .. })));
    assert!(matches!(
        ViewCells::adaptive(&tree, &[[[0.0; 3], [1.0; 3]]], 0, 1),
        Err(SampledError::Cells { .. })
    ));
}

#[test]
fn the_hash_of_a_scene_is_of_what_sets_depend_on() {
    let (mut scene, handles) = walled(TWO_SIDED);
    let before = scene_hash(&scene);
    assert_eq!(scene_hash(&walled(TWO_SIDED).0), before);
    scene.sort();
    assert_eq!(scene_hash(&scene), before, "the order of slots is none of it");
    scene
        .set_transform(handles[1], Transform::from_translation([0.0, 1.0, 3.5]))
        .expect("an instance");
    assert_ne!(scene_hash(&scene), before);
    assert_ne!(scene_hash(&walled(Part { two_sided: false, ..TWO_SIDED }).0), before);
}

/// A world far from its origin: rays are those of the world near it.
#[test]
fn rays_far_away_meet_what_they_meet_nearby() {
    let mut rng = Rng(9);
    let mut met = 0;
    for _ in 0..cases(10) {
        let offset = [1e7, -3e6, 2e7];
        let build = |offset: [f64; 3]| {
            let mut rng = Rng(77);
            let mut scene = Scene::new();
            let ball = scene.add_mesh(meshes::ball(8));
            for _ in 0..20 {
                let at: [f64; 3] = rng.vector(10.0).map(|v| (v * 4.0).round() / 4.0);
                let place: [f64; 3] = std::array::from_fn(|a| at[a] + offset[a]);
                scene.add(Instance::new(ball, Transform::from_translation(place))).expect("a mesh");
            }
            scene.rebase(offset);
            scene.commit(&cullet::Culler::default());
            scene
        };
        let (near, far) = (build([0.0; 3]), build(offset));
        let options = RayTreeOptions::default();
        let near = RayTree::new(&near, &options).map(|t| {
            let far = RayTree::new(&far, &options).expect("a scene");
            for _ in 0..100 {
                let from = rng.vector(12.0).map(|v| (v * 8.0).round() / 8.0);
                let moved: [f64; 3] = std::array::from_fn(|a| from[a] + offset[a]);
                let direction = rng.direction();
                let hit = t.first_hit(from, direction);
                assert_eq!(far.first_hit(moved, direction), hit);
                met += u32::from(hit.is_some());
            }
        });
        near.expect("a scene");
    }
    assert!(met > cases(20), "{met}");
}

/// Houses and towers, all closed, one-sided or not, and small things among and in them.
fn town(rng: &mut Rng, two_sided: bool) -> Scene {
    let mut scene = Scene::new();
    let part = Part { triangle_count: 12, two_sided, ..TWO_SIDED };
    let house = meshes::of_parts(
        cullet_testkit::soups::block([-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]),
        vec![part],
    );
    let (house, ball) = (scene.add_mesh(house), scene.add_mesh(meshes::ball(4)));
    for x in 0..4 {
        for z in 0..4 {
            let place = [f64::from(x) * 10.0, 0.0, f64::from(z) * 10.0];
            let scale =
                [rng.range(2.0, 4.8), rng.range(3.0, 9.0), rng.range(2.0, 4.8)].map(|v| v as f32);
            let mut t = Transform::from_scale_translation(scale, place);
            if rng.chance(0.4) {
                // Turned a little, so that its sides lie along no voxel.
                let (s, c) = (0.3_f32, 0.953_939_2_f32);
                t.linear[0] = [scale[0] * c, 0.0, scale[0] * s];
                t.linear[2] = [-scale[2] * s, 0.0, scale[2] * c];
            }
            scene.add(Instance::new(house, t)).expect("a mesh");
        }
    }
    for _ in 0..60 {
        let place = [rng.range(-5.0, 35.0), rng.range(0.2, 4.0), rng.range(-5.0, 35.0)];
        let t = Transform::from_scale_translation([0.2; 3], place);
        scene.add(Instance::new(ball, t)).expect("a mesh");
    }
    scene.commit(&cullet::Culler::default());
    scene
}

#[test]
fn no_line_finds_what_voxels_prove_hidden() {
    let mut rng = Rng(5);
    let mut proven = 0;
    for round in 0..cases(4) {
        let scene = town(&mut rng, round % 2 == 0);
        let granularity = [Granularity::Instance, Granularity::Cluster][round as usize / 2 % 2];
        let tree =
            RayTree::new(&scene, &RayTreeOptions { granularity, ..RayTreeOptions::default() });
        let tree = tree.expect("a scene");
        let region = [[-6.0, 0.1, -6.0], [36.0, 2.5, 36.0]];
        let cells = ViewCells::adaptive(&tree, &[region], 150, 1).expect("a box");
        let solid = SolidVoxels::new(&tree, 96).expect("in its range");
        let [full, all] = solid.counts();
        assert!(full * 50 > all && full * 2 < all, "{full} of {all}");
        let hidden = solid.hidden(&tree, &cells);
        let pvs = bake_sampled(&tree, &cells, &some_rays(1_000_000), 2).expect("good settings");
        for cell in 0..cells.len() {
            for target in 0..tree.targets().count() {
                let both = hidden.has(cell, target) && pvs.found.has(cell, target);
                assert!(!both, "{target} is proven hidden from {cell}, and a line found it");
            }
        }
        proven += hidden.count();
    }
    assert!(proven > u64::from(cases(4)) * 1000, "{proven}");
}

#[test]
fn an_open_or_transparent_shell_proves_nothing_and_no_box_nothing() {
    let (scene, _) = walled(TWO_SIDED);
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    assert_eq!(
        SolidVoxels::new(&tree, 64).expect("in its range").counts()[0],
        0,
        "walls without inside"
    );
    for resolution in [0, 1, 513] {
        assert!(matches!(SolidVoxels::new(&tree, resolution), Err(SampledError::Setting { .. })));
    }
    let mut scene = Scene::new();
    let block = scene.add_mesh(meshes::block([-2.0; 3], [2.0; 3]));
    let one = scene.add(Instance::new(block, Transform::IDENTITY)).expect("a mesh");
    let hides = |scene: &Scene| {
        let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
        let solid = SolidVoxels::new(&tree, 16).expect("in its range");
        let at = |z: f64| [[-0.5, -0.5, z], [0.5, 0.5, z + 1.0]];
        let strange = [[f64::NAN; 3], [1.0; 3]];
        assert!(!solid.hides(strange, at(5.0)) && !solid.hides(at(5.0), strange));
        // From within the block, or far to the side of it, nothing is proven.
        assert!(!solid.hides(at(-0.5), at(5.0)));
        assert!(!solid.hides([[9.0; 3], [10.0; 3]], at(5.0)));
        solid.hides(at(-6.0), at(5.0))
    };
    assert!(hides(&scene));
    let flags = cullet::InstanceFlags { transparent: true, ..cullet::InstanceFlags::default() };
    scene.set_flags(one, flags).expect("an instance");
    assert!(!hides(&scene));
}
