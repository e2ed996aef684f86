//! Merged groups of instances, measured without what made them.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use cullet::mesh::Part;
use cullet::{Culler, Instance, Mesh, MeshData, Output, Scene, Stage, Transform};
use cullet_bake::levels::{ChainOptions, LevelsError, NO_GROUP, build_chain};
use cullet_bake::merged::{
    Keep, Member, MergeInput, MergeOptions, MergedGroup, MeshAttributes, add_to_scene,
};
use cullet_draw::surface::deviation;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, answers::cull, cases, soups};

/// Balls and walls in rows, some mirrored, some of two parts, and a ground.
fn village(rng: &mut Rng) -> Scene {
    let mut scene = Scene::new();
    let (positions, indices) = soups::bumpy_ball(14, 0.1);
    let triangles = (indices.len() / 3) as u32;
    let part = |first_triangle, triangle_count, material| Part {
        first_triangle,
        triangle_count,
        material,
        ..Part::default()
    };
    let parts = vec![part(0, triangles / 2, 1), part(triangles / 2, triangles - triangles / 2, 2)];
    let ball = MeshData { positions, indices, parts, ..MeshData::default() };
    let mut meshes = Vec::new();
    for data in [ball, cullet_testkit::meshes::block([-0.5; 3], [0.5, 2.0, 0.2]).to_data()] {
        let mesh = scene.add_mesh(Mesh::new(data.clone()).unwrap());
        let chain = build_chain(&data, &ChainOptions::default()).unwrap();
        if !chain.groups.is_empty() {
            let (held, levels) = chain.into_levels().unwrap();
            let held = scene.add_mesh(held);
            scene.add_levels(mesh, held, levels).unwrap();
        }
        meshes.push(mesh);
    }
    for at in 0..30 + rng.below(30) {
        let place = [(at % 8) as f64 * 2.2 + 1e4, rng.range(0.0, 0.3), (at / 8) as f64 * 2.2];
        let scale = [rng.range(0.5, 1.2) as f32 * if at % 5 == 0 { -1.0 } else { 1.0 }, 1.0, 0.9];
        let transform = Transform::from_scale_translation(scale, place);
        scene.add(Instance::new(meshes[rng.index(2)], transform)).unwrap();
    }
    let ground =
        scene.add_mesh(cullet_testkit::meshes::block([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0]));
    scene.add(Instance::new(ground, Transform::from_translation([1e4, 0.0, 0.0]))).unwrap();
    scene.rebase([1e4, 0.0, 0.0]);
    scene.commit(&Culler::default());
    scene
}

/// Merges a scene alone: no attributes, nothing kept.
fn merge(
    scene: &Scene,
    options: &MergeOptions,
    go_on: impl Fn(f64) -> bool + Sync,
) -> Result<Option<Vec<MergedGroup>>, LevelsError> {
    cullet_bake::merged::merge(scene, &MergeInput::default(), options, go_on)
}

/// The instances below a group.
fn below(groups: &[MergedGroup], number: usize) -> Vec<u32> {
    let members = groups[number].members.iter();
    members
        .flat_map(|m| match *m {
            Member::Instance(slot) => vec![slot],
            Member::Group(other) => {
                assert!((other as usize) < number);
                below(groups, other as usize)
            }
        })
        .collect()
}

#[test]
fn each_level_is_as_near_to_its_instances_as_it_states() {
    let mut rng = Rng(5);
    for case in 0..cases(4).max(1) {
        let scene = village(&mut rng);
        let groups = merge(&scene, &MergeOptions::default(), |_| true).unwrap().unwrap();
        assert!(groups.len() > 1, "case {case}");
        let mut times = vec![0; scene.slot_count() as usize];
        for (number, group) in groups.iter().enumerate() {
            let slots = below(&groups, number);
            group.members.iter().for_each(|m| {
                if let Member::Instance(slot) = m {
                    times[*slot as usize] += 1;
                }
            });
            let (mut positions, mut indices) = (Vec::new(), Vec::new());
            for slot in slots {
                let (mesh, m) = (scene.mesh(slot), scene.transform(slot).to_matrix());
                indices.extend(mesh.indices().iter().map(|i| i + positions.len() as u32));
                positions.extend(mesh.positions().iter().map(|p| {
                    let p = p.map(f64::from);
                    let place = |a: usize| {
                        m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a]
                            - group.origin[a]
                    };
                    [0, 1, 2].map(|a| place(a) as f32)
                }));
            }
            let levels = &group.levels;
            assert!(
                !levels.groups.is_empty() && levels.groups.is_sorted_by(|a, b| a.error <= b.error)
            );
            for (level, stated) in levels.groups.iter().enumerate() {
                let made =
                    (0..levels.made_from.len()).filter(|&c| levels.made_from[c] == level as u32);
                let list: Vec<u32> = made
                    .flat_map(|c| levels.cluster_indices(c as u32).collect::<Vec<_>>())
                    .collect();
                assert!(!list.is_empty() && list.len() < indices.len());
                let far =
                    deviation((&positions, &indices), (&levels.mesh.positions, &list), 40_000, 77);
                assert!(
                    far.p999 <= stated.error && far.max <= stated.error * 1.2,
                    "case {case}: {far:?}, {stated:?}"
                );
                // The sphere is around all of it.
                let length = |p: &[f32; 3]| p.iter().map(|v| v * v).sum::<f32>().sqrt();
                assert!(positions.iter().all(|p| length(p) <= stated.radius * 1.0001));
            }
            assert!(levels.made_from.iter().all(|&g| g != NO_GROUP));
        }
        assert!(times.iter().all(|&n| n <= 1));
    }
}

#[test]
fn merged_groups_draw_less_from_afar_and_nothing_changes_near_by() {
    let mut rng = Rng(8);
    let mut scene = village(&mut rng);
    let groups = merge(&scene, &MergeOptions::default(), |_| true).unwrap().unwrap();
    let count = |scene: &Scene, far: f64| {
        let view = look([1e4 + 8.0, 0.4 * far, far], [1e4 + 8.0, 0.0, 8.0], [1280, 720]);
        let lod = Some(cullet::lod::Lod::default());
        let culler = Culler::default().with_lod(lod).with_output(Output::Triangles);
        cull(&culler.only(Stage::Lod), scene, &view).triangle_count
    };
    let fars = [4.0, 40.0, 120.0, 1000.0];
    let before = fars.map(|far| count(&scene, far));
    assert_eq!(add_to_scene(&mut scene, &groups).unwrap().len(), groups.len());
    scene.commit(&Culler::default());
    let after = fars.map(|far| count(&scene, far));
    assert!(after.iter().zip(&before).all(|(a, b)| a <= b), "{after:?} of {before:?}");
    // Farther away all that is left of each is a sheet or two.
    assert!(after[1] * 10 < before[1] * 9, "{after:?} of {before:?}");
    // Added twice, an instance would be stood for twice.
    assert!(add_to_scene(&mut scene, &groups).is_err());
}

#[test]
fn groups_are_the_same_on_any_number_of_threads_and_can_be_stopped() {
    let scene = village(&mut Rng(3));
    let mut options = MergeOptions::default();
    let one = merge(&scene, &options, |_| true).unwrap();
    options.threads = 3;
    assert_eq!(merge(&scene, &options, |_| true).unwrap(), one);
    assert_eq!(merge(&scene, &options, |share| share < 0.3).unwrap(), None);
    assert_eq!(merge(&Scene::new(), &options, |_| true).unwrap(), Some(Vec::new()));
}

/// Keeps in memory.
#[derive(Default)]
struct Shelf {
    kept: Mutex<HashMap<u64, Vec<u8>>>,
    read: AtomicUsize,
}

impl Keep for Shelf {
    fn read(&self, key: u64) -> Option<Vec<u8>> {
        let found = self.kept.lock().unwrap().get(&key).cloned();
        self.read.fetch_add(usize::from(found.is_some()), Ordering::Relaxed);
        found
    }

    fn write(&self, key: u64, bytes: &[u8]) {
        self.kept.lock().unwrap().insert(key, bytes.to_vec());
    }
}

#[test]
fn what_was_stopped_goes_on_from_what_is_kept() {
    let mut scene = village(&mut Rng(3));
    let shelf = Shelf::default();
    let options = MergeOptions::default();
    let kept = |scene: &Scene, options: &MergeOptions, go_on: &(dyn Fn(f64) -> bool + Sync)| {
        shelf.read.store(0, Ordering::Relaxed);
        let input = MergeInput { keep: Some(&shelf), ..MergeInput::default() };
        let made = cullet_bake::merged::merge(scene, &input, options, go_on).unwrap();
        (made, shelf.read.load(Ordering::Relaxed))
    };
    let count = || shelf.kept.lock().unwrap().len();
    let whole = merge(&scene, &options, |_| true).unwrap();
    assert_eq!(kept(&scene, &options, &|share| share < 0.3), (None, 0));
    let before = count();
    assert!(before > 0);
    assert_eq!(kept(&scene, &options, &|_| true), (whole.clone(), before));
    let all = count();
    assert!(all > before);
    assert_eq!(kept(&scene, &options, &|_| true), (whole.clone(), all));
    // What is damaged is made again.
    for bytes in shelf.kept.lock().unwrap().values_mut() {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
    }
    assert_eq!(kept(&scene, &options, &|_| true).0, whole);
    // Options, the place of one instance and attributes are all in the keys.
    let mut coarser = options;
    coarser.first = 1.0 / 400.0;
    assert_eq!(kept(&scene, &coarser, &|_| true).1, 0);
    let slot = below(&whole.unwrap(), 0)[0];
    let (handle, m) = (scene.handle(slot).unwrap(), scene.transform(slot).to_matrix());
    let moved = Transform::from_translation([m[12], m[13] + 0.25, m[14]]);
    scene.set_transform(handle, moved).unwrap();
    scene.commit(&Culler::default());
    let (made, found) = kept(&scene, &options, &|_| true);
    assert_eq!(made, merge(&scene, &options, |_| true).unwrap());
    assert!(found < all, "{found} of {all}");
    assert!(kept(&scene, &options, &|_| true).1 > found);
    let colors = vec![[0.5; 4]; scene.meshes()[0].positions().len()];
    let own = MeshAttributes { colors: &colors, ..MeshAttributes::default() };
    let input = MergeInput { attributes: &[own], keep: Some(&shelf), share: None };
    shelf.read.store(0, Ordering::Relaxed);
    cullet_bake::merged::merge(&scene, &input, &options, |_| true).unwrap();
    assert_eq!(shelf.read.load(Ordering::Relaxed), 0);
}

#[test]
fn shares_join_to_the_groups_of_one_whatever_is_lost() {
    let scene = village(&mut Rng(5));
    let options = MergeOptions::default();
    let whole = merge(&scene, &options, |_| true).unwrap().unwrap();
    let shelf = Shelf::default();
    let share = |share| {
        let input = MergeInput { keep: Some(&shelf), share, ..MergeInput::default() };
        let made = cullet_bake::merged::merge(&scene, &input, &options, |_| true).unwrap().unwrap();
        (made, shelf.kept.lock().unwrap().len(), shelf.read.swap(0, Ordering::Relaxed))
    };
    let (none, first, read) = share(Some([1, 3]));
    assert!(none.is_empty() && first > 0 && read == 0);
    // Who comes later makes what lacks and nothing else: all but the topmost, of which each has its own.
    let (_, second, read) = share(Some([0, 3]));
    assert!(second >= first && read > 0, "{second} {first} {read}");
    assert_eq!(share(Some([1, 3])), (Vec::new(), second, first));
    let lost = *shelf.kept.lock().unwrap().keys().min().unwrap();
    shelf.kept.lock().unwrap().remove(&lost);
    let (made, all, read) = share(None);
    assert!(made == whole && read == second - 1 && all >= second);
    assert_eq!(share(None).2, all);
}

/// A wall of square plates side by side, each in its own place of one picture: in its u are the halves of the plate, which
/// makes a seam in its middle.
fn plates() -> (Scene, Vec<[f32; 2]>) {
    const ACROSS: u32 = 8;
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for half in 0..2 {
        for y in 0..=ACROSS {
            for x in 0..=ACROSS / 2 {
                let [x, y] = [x + half * ACROSS / 2, y].map(|v| v as f32 / ACROSS as f32);
                positions.push([x, y, 0.0]);
                uvs.push([x + half as f32 * 2.0, y + 1.0]);
            }
        }
        let row = ACROSS / 2 + 1;
        for y in 0..ACROSS {
            for x in 0..ACROSS / 2 {
                let a = half * row * (ACROSS + 1) + y * row + x;
                indices.extend([a, a + 1, a + row + 1, a, a + row + 1, a + row]);
            }
        }
    }
    let mut scene = Scene::new();
    let mesh =
        scene.add_mesh(Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap());
    for at in 0..144 {
        let place = [f64::from(at % 12), f64::from(at / 12), 0.0];
        scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap();
    }
    scene.commit(&Culler::default());
    (scene, uvs)
}

#[test]
fn groups_keep_texture_coordinates_and_their_seams() {
    let (scene, uvs) = plates();
    let colors = vec![[1.0; 4]; uvs.len()];
    let attributes = [MeshAttributes { uvs: &uvs, colors: &colors }];
    let input = MergeInput { attributes: &attributes, ..MergeInput::default() };
    let options = MergeOptions::default();
    let groups = cullet_bake::merged::merge(&scene, &input, &options, |_| true).unwrap().unwrap();
    let plain = merge(&scene, &options, |_| true).unwrap().unwrap();
    assert!(!groups.is_empty() && plain.iter().all(|g| g.uvs.is_empty() && g.colors.is_empty()));
    for group in &groups {
        let mesh = &group.levels.mesh;
        assert_eq!(group.uvs.len(), mesh.positions.len());
        assert!(group.colors.is_empty(), "white is no colour");
        // Every triangle is of one half of one plate: its texture coordinates go with its places.
        for t in mesh.indices.as_chunks::<3>().0 {
            let offsets = t.map(|v| {
                let (p, uv) = (mesh.positions[v as usize], group.uvs[v as usize]);
                let x = f64::from(p[0]) + group.origin[0] - f64::from(uv[0]);
                let y = f64::from(p[1]) + group.origin[1] - f64::from(uv[1]);
                [x.round() as i32, y.round() as i32]
            });
            assert!(offsets[0] == offsets[1] && offsets[1] == offsets[2], "{offsets:?}");
        }
    }
    // Seams cost triangles: of a plane without any nearly nothing is left.
    let least = |groups: &[MergedGroup]| {
        groups.iter().map(|g| g.levels.mesh.indices.len()).min().unwrap_or(0)
    };
    assert!(least(&plain) < least(&groups), "{} {}", least(&plain), least(&groups));
}

#[test]
fn wrong_options_are_refused() {
    let scene = Scene::new();
    let refused = |change: &dyn Fn(&mut MergeOptions)| {
        let mut options = MergeOptions::default();
        change(&mut options);
        matches!(merge(&scene, &options, |_| true), Err(LevelsError::Value { .. }))
    };
    assert!(!refused(&|_| ()));
    assert!(refused(&|o| o.smallest = 1));
    assert!(refused(&|o| o.fan = 6));
    assert!(refused(&|o| o.first = f64::NAN));
    assert!(refused(&|o| o.levels = 0));
    assert!(refused(&|o| o.keep = 1.5));
    assert!(refused(&|o| o.threads = 0));
}
