//! The funnel counts what each stage took, triangle for triangle.

use cullet::cull::detail::Detail;
use cullet::cull::occlusion::Occlusion;
use cullet::{Culler, Instance, Output, Scene, Stage, funnel::Unit};
use cullet_testkit::answers::cull;
use cullet_testkit::oracles::alone::{check_rows, fates, fates_alone, telling};
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{random_culler, random_view};
use cullet_testkit::{Rng, meshes};

/// Settings of all kinds.
/// Two balls of many clusters beside the others, so that clusters go as well.
fn scene(rng: &mut Rng) -> Scene {
    let mut scene = random_scene(rng, 14);
    let ball = scene.add_mesh(meshes::ball(24));
    for _ in 0..3 {
        let scale = [rng.range(0.5, 9.0) as f32; 3];
        let at = rng.vector(9.0);
        let place = cullet::Transform::from_scale_translation(scale, at);
        scene.add(Instance::new(ball, place)).expect("the mesh exists");
    }
    // Flattened to a line.
    let flat = cullet::Transform::from_scale_translation([2.0, 0.0, 0.0], rng.vector(9.0));
    scene.add(Instance::new(ball, flat)).expect("the mesh exists");
    scene.prepare(cullet::prepared::Preparation::ALL);
    scene
}

#[test]
fn rows_chain_and_count_what_the_record_says() {
    let mut rng = Rng(31);
    let mut taken = [[0u64; 3]; Stage::ALL.len() + 1];
    for round in 0..150 {
        let mut scene = scene(&mut rng);
        if round % 2 == 0 {
            scene.commit(&Culler::default());
        }
        let (view, culler) = (random_view(&mut rng), telling(&random_culler(&mut rng)));
        let result = cull(&culler, &scene, &view);
        let fates = fates(&scene, &result);
        check_rows(&scene, &result, &fates);
        for row in &result.funnel.rows {
            taken[row.stage as usize][row.unit as usize] += row.dropped().triangles;
        }
        // The shallower answers count as much, and nothing in between where nothing is tested.
        for output in [Output::Instances, Output::Clusters] {
            let shallow = cull(&culler.clone().with_output(output), &scene, &view);
            let rows = &shallow.funnel.rows;
            assert!(rows.windows(2).all(|w| w[0].left == w[1].entered), "{rows:#?}");
            let same = rows.iter().take_while(|row| row.unit == Instances);
            assert!(same.zip(&result.funnel.rows).all(|(a, b)| a == b));
            assert_eq!(shallow.funnel.left().triangles, shallow.triangle_count);
            assert_eq!(shallow.slots().count() as u64, shallow.instance_count);
            let drawn: u64 = shallow
                .whole
                .iter()
                .flat_map(|r| r.first..r.first + r.count)
                .map(|slot| (slot, 0, scene.mesh(slot).clusters().len()))
                .chain(
                    shallow
                        .partial
                        .iter()
                        .map(|d| (d.slot, d.first_cluster as usize, d.cluster_count as usize)),
                )
                .map(|(slot, first, count)| {
                    let clusters = &scene.mesh(slot).clusters()[first..first + count];
                    clusters.iter().map(|c| u64::from(c.triangle_count)).sum::<u64>()
                })
                .sum();
            if culler.degenerate {
                assert_eq!(drawn, shallow.triangle_count);
            } else {
                assert!(drawn <= shallow.triangle_count);
            }
        }
    }
    // Every row has been at work.
    use Unit::{Clusters, Instances, Triangles};
    for (stage, unit) in [
        (Stage::Layer, Instances),
        (Stage::Frustum, Instances),
        (Stage::Frustum, Clusters),
        (Stage::Frustum, Triangles),
        (Stage::Detail, Instances),
        (Stage::Degenerate, Instances),
        (Stage::Degenerate, Triangles),
        (Stage::Backface, Clusters),
        (Stage::Backface, Triangles),
        (Stage::Occlusion, Instances),
    ] {
        assert!(taken[stage as usize][unit as usize] > 0, "{stage:?} took no {unit:?}: {taken:?}");
    }
}

#[test]
fn each_row_takes_what_its_stage_takes_alone_of_what_the_rows_before_left() {
    let mut rng = Rng(32);
    for _ in 0..120 {
        let scene = scene(&mut rng);
        let (view, culler) = (random_view(&mut rng), telling(&random_culler(&mut rng)));
        let together = fates(&scene, &cull(&culler, &scene, &view));
        let alone = fates_alone(&culler, &scene, &view);
        for slot in scene.slots() {
            let (a, b) = (&together[slot as usize], &alone[slot as usize]);
            let differ = a.iter().zip(b).position(|(a, b)| a != b);
            assert!(
                differ.is_none(),
                "slot {slot}, triangle {differ:?}: {:?} together, {:?} alone, {culler:?}",
                differ.map(|t| a[t]),
                differ.map(|t| b[t])
            );
        }
    }
}

#[test]
fn a_triangle_names_the_stage_that_took_it() {
    let mut rng = Rng(33);
    for _ in 0..40 {
        let scene = scene(&mut rng);
        let view = random_view(&mut rng);
        let result = cull(&telling(&random_culler(&mut rng)), &scene, &view);
        for (slot, fates) in (0..).zip(fates(&scene, &result)) {
            for (t, fate) in (0..).zip(fates) {
                assert_eq!(result.stage_of(slot, t), fate.map(|f| f.0), "slot {slot}, {t}");
            }
        }
    }
}

#[test]
fn one_stage_runs_alone_or_is_left_out() {
    let all = telling(&Culler::default())
        .with_detail(Detail::default())
        .with_occlusion(Occlusion::default());
    let exist =
        [Stage::Frustum, Stage::Detail, Stage::Occlusion, Stage::Backface, Stage::Degenerate];
    for one in exist {
        // Also where it was off.
        for from in [&all, &exist.iter().fold(all.clone(), |c, &s| c.without(s))] {
            let only = from.only(one);
            assert!(Stage::ALL.iter().all(|&s| only.runs(s) == (s == one || s == Stage::Layer)));
        }
        let without = all.without(one);
        assert!(exist.iter().all(|&s| without.runs(s) == (s != one)));
    }
    let mut rng = Rng(34);
    for _ in 0..30 {
        let (scene, view) = (scene(&mut rng), random_view(&mut rng));
        for one in exist {
            let result = cull(&all.only(one), &scene, &view);
            for stage in Stage::ALL.into_iter().filter(|&s| s != one && s != Stage::Layer) {
                assert_eq!(result.funnel.dropped(stage), cullet::funnel::Counts::default());
            }
        }
    }
}

/// Counts follow everything that may happen to instances and meshes.
#[test]
fn counts_follow_the_scene() {
    let mut rng = Rng(35);
    for _ in 0..40 {
        let mut scene = scene(&mut rng);
        for _ in 0..30 {
            let slots: Vec<u32> = scene.slots().collect();
            let slot = slots[rng.below(slots.len() as u64) as usize];
            let handle = scene.handle(slot).expect("it is there");
            match rng.below(8) {
                0 if slots.len() > 4 => scene.remove(handle).expect("it is there"),
                1 => {
                    scene.commit(&Culler::default());
                }
                2 => {
                    scene.commit_slice();
                }
                3 => scene.set_layers(handle, 1 << rng.below(3)).expect("it is there"),
                4 => {
                    let mesh = meshes::blob(&mut rng);
                    scene.edit_mesh(rng.below(4) as u32, |m| *m = mesh);
                }
                5 => drop(scene.edit_meshes(|_, mesh| mesh.set_two_sided(true))),
                6 => scene.commit_in_order(),
                _ => {
                    let instance = Instance::new(rng.below(5) as u32, *scene.transform(slot));
                    scene.add(instance).expect("the mesh exists");
                }
            }
            let view = random_view(&mut rng);
            let culler = telling(&Culler::default());
            let result = cull(&culler, &scene, &view);
            check_rows(&scene, &result, &fates(&scene, &result));
        }
    }
}
