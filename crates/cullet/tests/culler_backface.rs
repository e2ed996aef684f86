//! The fast way to cull back faces against the exact one: the same triangles by triangle, and a part of
//! them by cluster.

use cullet::cull::backface::{ClusterEye, Facing, ObjectEye, ViewEye};
use cullet::mesh::Part;
use cullet::{
    Backface, Camera, Culler, Depth, Instance, Mesh, MeshData, Output, Projection, Reason, Scene,
    Stage, Transform, View, Visible,
    funnel::Unit,
    prepared::{Preparation, Prepared},
    view::{CullFace, FrontFace},
};
use cullet_testkit::answers::{cull, listed};
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::random_view;
use cullet_testkit::{Rng, at_every_level, meshes};
use proptest::prelude::*;

fn by(backface: Backface, output: Output) -> Culler {
    Culler::default().with_backface(backface).with_output(output).with_reasons(true)
}

/// A bumpy ball of 2 · rings · 2 rings triangles around a point, one-sided.
fn ball(rings: u32, bumps: f64, centre: [f64; 3]) -> Mesh {
    let segments = rings * 2;
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..segments {
            let a = std::f64::consts::PI * f64::from(i) / f64::from(rings);
            let b = std::f64::consts::TAU * f64::from(j) / f64::from(segments);
            let r = 1.0 + bumps * (5.0 * a).sin() * (7.0 * b).cos();
            // Its poles are points, so that their triangles are degenerate and not merely thin.
            let sine = if i % rings == 0 { 0.0 } else { a.sin() };
            let p = [r * sine * b.cos(), r * a.cos(), r * sine * b.sin()];
            positions.push([0, 1, 2].map(|k| (p[k] + centre[k]) as f32));
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..segments {
            let k = (j + 1) % segments;
            let (a, b) = (i * segments + j, i * segments + k);
            let (c, d) = (a + segments, b + segments);
            indices.extend([a, b, c, b, d, c]);
        }
    }
    meshes::one_sided((positions, indices))
}

fn alone(mesh: Mesh, transform: Transform) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, transform)).expect("the mesh exists");
    scene.prepare(Preparation::ALL);
    scene
}

fn looking_at(eye: [f64; 3], target: [f64; 3]) -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.2, aspect: 1.0, near: 1e-3, far: f64::INFINITY };
    let camera = Camera::look_at(eye, target, projection);
    View::new(&camera, Depth::Reversed, [512, 512]).expect("a good camera")
}

/// On scenes and views of every kind: mirrored, stretched, flattened, orthographic, with either face
/// culled and either winding.
#[test]
fn fast_drops_what_exact_drops() {
    let mut rng = Rng(21);
    let mut exact_dropped = 0_u64;
    for round in 0..200 {
        let scene = random_scene(&mut rng, 15);
        let view = random_view(&mut rng);
        let ways = [Backface::Off, Backface::Fast, Backface::Exact];
        let [off, fast, exact] =
            ways.map(|way| listed(&cull(&by(way, Output::Triangles), &scene, &view)));
        assert_eq!(exact, fast, "round {round}");
        assert!(exact.is_subset(&off), "round {round}");
        exact_dropped += (off.len() - exact.len()) as u64;
    }
    println!("exact {exact_dropped}");
    assert!(exact_dropped > 7_000, "{exact_dropped}");
}

/// Clusters that are left out hold nothing that the exact test keeps.
#[test]
fn clusters_that_go_hold_back_faces_alone() {
    let mut rng = Rng(22);
    let mut gone = 0;
    for _ in 0..60 {
        let mut scene = random_scene(&mut rng, 8);
        let mesh = scene.add_mesh(ball(40, 0.1, [0.0; 3]));
        scene.prepare(Preparation::ALL);
        for _ in 0..3 {
            let t = Transform::from_translation(rng.vector(8.0));
            scene.add(Instance::new(mesh, t)).expect("the mesh exists");
        }
        let view = random_view(&mut rng);
        let clusters = cull(&by(Backface::Fast, Output::Clusters), &scene, &view);
        let all = cull(&by(Backface::Off, Output::Clusters), &scene, &view);
        let triangles = cull(&by(Backface::Exact, Output::Triangles), &scene, &view);
        let drawn = |v: &Visible, slot: u32, triangle: u32| {
            let is_whole = v.whole.iter().any(|r| (r.first..r.first + r.count).contains(&slot));
            is_whole
                || v.partial.iter().filter(|r| r.slot == slot).any(|r| {
                    let clusters = &scene.mesh(slot).clusters()[r.first_cluster as usize..];
                    let mut own = clusters[..r.cluster_count as usize].iter();
                    own.any(|c| c.triangles().contains(&triangle))
                })
        };
        for (slot, triangle) in listed(&triangles) {
            assert!(drawn(&clusters, slot, triangle), "triangle {triangle} of slot {slot}");
        }
        gone += all.triangle_count - clusters.triangle_count;
        let row = clusters.funnel.rows.iter().find(|r| r.stage == Stage::Backface);
        if let Some(row) = row {
            assert_eq!(row.unit, Unit::Clusters);
            assert_eq!(row.dropped().clusters > 0, clusters.triangle_count < all.triangle_count);
        } else {
            assert_eq!(view.cull_face, CullFace::None);
        }
    }
    assert!(gone > 20_000, "{gone} triangles went with their clusters");
}

/// The floor: of what the exact test takes, so much is taken at every distance.
#[test]
fn nearly_all_back_faces_go() {
    let scene = alone(ball(60, 0.08, [0.0; 3]), Transform::IDENTITY);
    let mesh = scene.mesh(0);
    for (distance, of_clusters) in [(1.2, 60), (1.5, 56), (3.0, 49), (20.0, 42), (500.0, 42)] {
        let (mut exact, mut fast, mut by_cluster) = (0, 0, 0);
        let mut rng = Rng(5);
        for _ in 0..40 {
            let d = rng.vector(1.0);
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            let view = looking_at(d.map(|v| v / length * distance), [0.0; 3]);
            let culled = |way, output| {
                let culler = by(way, output).with_frustum(false);
                let all = u64::from(mesh.triangle_count() - mesh.degenerate_count());
                all - cull(&culler, &scene, &view).triangle_count.min(all)
            };
            exact += culled(Backface::Exact, Output::Triangles);
            fast += culled(Backface::Fast, Output::Triangles);
            by_cluster += culled(Backface::Fast, Output::Clusters);
        }
        assert_eq!(fast, exact, "at {distance}");
        let share = by_cluster * 100 / exact;
        assert!(share >= of_clusters, "clusters take {share} % of the exact at {distance}");
    }
}

#[test]
fn every_simd_level_culls_the_same() {
    let mut rng = Rng(24);
    for _ in 0..10 {
        let mut scene = random_scene(&mut rng, 5);
        let mesh = scene.add_mesh(ball(30, 0.1, [0.0; 3]));
        scene.prepare(Preparation::ALL);
        scene.add(Instance::new(mesh, Transform::IDENTITY)).expect("the mesh exists");
        let view = random_view(&mut rng);
        for output in [Output::Clusters, Output::Triangles] {
            let expected = cull(&by(Backface::Fast, output), &scene, &view);
            at_every_level!(|level| {
                let culled = cull(&by(Backface::Fast, output).with_simd(level), &scene, &view);
                assert!(culled == expected);
            });
        }
    }
}

/// A leaf of many clusters, all of which face one way.
fn leaf(degenerate: bool) -> Mesh {
    let side = 40_u32;
    let positions = (0..side * side)
        .map(|i| [(i % side) as f32, (i / side) as f32, ((i * 7) % 5) as f32 * 0.01])
        .collect();
    let mut indices = Vec::new();
    for y in 0..side - 1 {
        for x in 0..side - 1 {
            let a = y * side + x;
            indices.extend([a, a + 1, a + side, a + 1, a + side + 1, a + side]);
        }
    }
    if degenerate {
        indices.extend([0, 0, 1]);
    }
    meshes::one_sided((positions, indices))
}

#[test]
fn what_faces_away_altogether_goes_for_that_reason() {
    for degenerate in [false, true] {
        let scene = alone(leaf(degenerate), Transform::IDENTITY);
        let behind = looking_at([20.0, 20.0, -60.0], [20.0, 20.0, 0.0]);
        let before = looking_at([20.0, 20.0, 60.0], [20.0, 20.0, 0.0]);
        for output in [Output::Clusters, Output::Triangles] {
            let culler = by(Backface::Fast, output);
            let gone = cull(&culler, &scene, &behind);
            let reason = Some(Reason { stage: Stage::Backface, detail: 0 });
            assert_eq!((gone.instance_count, gone.triangle_count), (0, 0));
            assert_eq!(gone.reasons, [reason]);
            assert!(gone.whole.is_empty() && gone.partial.is_empty());
            let handle = scene.handle(0).expect("it is there");
            let told = culler.explain(&scene, &behind, handle).expect("the handle is good");
            assert_eq!(told.reason, reason);
            let there = cull(&culler, &scene, &before);
            assert_eq!((there.whole.len(), there.reasons[0]), (1, None));
            // The other way round with front faces culled, and with clockwise fronts.
            let mut other = before.clone();
            other.cull_face = CullFace::Front;
            assert_eq!(cull(&culler, &scene, &other).instance_count, 0);
            other.front_face = FrontFace::Clockwise;
            assert_eq!(cull(&culler, &scene, &other).instance_count, 1);
            other.cull_face = CullFace::Back;
            assert_eq!(cull(&culler, &scene, &other).instance_count, 0);
        }
    }
}

/// Two-sided parts, double-sided instances and meshes that can deform keep everything.
#[test]
fn what_has_no_back_is_kept_whole() {
    let view = looking_at([20.0, 20.0, -60.0], [20.0, 20.0, 0.0]);
    let whole = |scene: &Scene| {
        [Output::Clusters, Output::Triangles].map(|output| {
            let all = scene.triangle_count();
            cull(&by(Backface::Fast, output), scene, &view).triangle_count == all
        })
    };
    let mesh = leaf(false);
    assert_eq!(whole(&alone(mesh.clone(), Transform::IDENTITY)), [false; 2]);
    // Prepared data is made anew with the mesh.
    let mut scene = alone(mesh.clone(), Transform::IDENTITY);
    scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    assert_eq!(whole(&scene), [true; 2]);
    scene.edit_meshes(|_, mesh| mesh.set_two_sided(false));
    assert_eq!(whole(&scene), [false; 2]);
    let handle = scene.handle(0).expect("it is there");
    let flags = cullet::InstanceFlags { double_sided: true, ..scene.flags(0) };
    scene.set_flags(handle, flags).expect("it is there");
    assert_eq!(whole(&scene), [true; 2]);
    let data = MeshData {
        positions: mesh.positions().to_vec(),
        indices: mesh.indices().to_vec(),
        parts: vec![Part { triangle_count: mesh.triangle_count(), ..Part::default() }],
        deformable: true,
        ..MeshData::default()
    };
    let deformable = Mesh::new(data).expect("a good mesh");
    assert_eq!(whole(&alone(deformable, Transform::IDENTITY)), [true; 2]);
    // Of two parts with one back, the other stays.
    let half = mesh.triangle_count() / 2;
    let mut parts = vec![Part { triangle_count: half, two_sided: true, ..Part::default() }];
    parts.push(Part { first_triangle: half, triangle_count: half, ..Part::default() });
    let indices = mesh.indices()[..half as usize * 6].to_vec();
    let data =
        MeshData { positions: mesh.positions().to_vec(), indices, parts, ..MeshData::default() };
    let scene = alone(Mesh::new(data).expect("a good mesh"), Transform::IDENTITY);
    for output in [Output::Clusters, Output::Triangles] {
        let left = cull(&by(Backface::Fast, output), &scene, &view).triangle_count;
        assert_eq!(left, u64::from(half));
    }
}

/// Far from the world's origin a renderer's rounding turns triangles: where it could, only the exact
/// test is used, and it is never wrong to use the fast one.
#[test]
fn far_away_the_doubt_decides() {
    let mesh = ball(30, 0.05, [0.0; 3]);
    let mut ways = Vec::new();
    for far in [0.0, 1e3, 1e5, 1e9, 1e12, 1e15] {
        let scene = alone(mesh.clone(), Transform::from_translation([far; 3]));
        let eye = [far + 0.5, far + 2.5, far - 1.5];
        let view = looking_at(eye, [far; 3]);
        let object = ObjectEye::of_view(&view, scene.transform(0));
        assert_eq!(object, ViewEye::new(&view).in_space_of(scene.transform(0)));
        ways.push(scene.prepared_of(0).backfaces().and_then(|b| b.eye(&object)).is_some());
        let [fast, exact] = [Backface::Fast, Backface::Exact]
            .map(|way| listed(&cull(&by(way, Output::Triangles), &scene, &view)));
        assert_eq!(exact, fast, "at {far}");
    }
    assert_eq!(ways, [true, true, true, false, false, false]);
}

prop_compose! {
    fn transforms()(
        linear in prop::array::uniform3(prop::array::uniform3(-1.0_f32..1.0)),
        size in -6.0_f64..6.0,
        stretch in -3.0_f64..0.0,
        far in -1.0_f64..8.0,
        direction in prop::array::uniform3(-1.0_f64..1.0),
    ) -> Transform {
        let mut t = Transform {
            linear: linear.map(|c| c.map(|v| (f64::from(v) * 10f64.powf(size)) as f32)),
            translation: direction.map(|v| v * 10f64.powf(far + size)),
        };
        t.linear[1] = t.linear[1].map(|v| (f64::from(v) * 10f64.powf(stretch)) as f32);
        t
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(400)))]

    /// Instances of any size and shape, anywhere: what planes and cones cull, `ObjectEye` culls.
    #[test]
    fn planes_and_cones_prove_no_more_than_the_corners(
        transform in transforms(),
        eye in prop::array::uniform3(-3.0_f64..3.0),
        bumps in 0.0_f64..0.3,
        offset in -4.0_f64..4.0,
        kind in 0_u32..16,
    ) {
        let centre = [10f64.powf(offset.abs()) * offset.signum(), 0.0, 0.0];
        let mesh = ball(12, bumps, centre);
        // An eye near the mesh, in the world.
        let m = transform.to_matrix();
        let at = [0, 1, 2].map(|k| eye[k] * 1.5 + centre[k]);
        let world: [f64; 3] = std::array::from_fn(|r| (0..3).map(|c| m[c * 4 + r] * at[c]).sum::<f64>() + m[12 + r]);
        let homogeneous = if kind & 1 == 0 {
            [world[0], world[1], world[2], 1.0]
        } else {
            [eye[0], eye[1], eye[2], 0.0]
        };
        let front_face = if kind & 2 == 0 { FrontFace::CounterClockwise } else { FrontFace::Clockwise };
        let cull_face = if kind & 4 == 0 { CullFace::Back } else { CullFace::Front };
        let object = if kind & 8 == 0 {
            ObjectEye::new(homogeneous, &transform, front_face, cull_face)
        } else {
            let target = transform.translation;
            let projection = Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 1e-3, far: 1e3 };
            let Ok(mut view) = View::new(&Camera::look_at(world, target, projection), Depth::Standard, [64, 64]) else {
                return Ok(());
            };
            (view.front_face, view.cull_face) = (front_face, cull_face);
            ObjectEye::of_view(&view, &transform)
        };
        let prepared = Prepared::of(&mesh, Preparation::ALL);
        let Some(planes) = prepared.backfaces() else { return Ok(()) };
        let Some(eye) = planes.eye(&object) else { return Ok(()) };
        prop_assert_eq!(eye.facing(), object.culled_side());
        let mut words = vec![0; mesh.triangle_count().div_ceil(64) as usize];
        let level = cullet::Simd::best();
        planes.cull_words(level, &eye, 0, &mut words);
        for t in 0..mesh.triangle_count() {
            if words[t as usize / 64] >> (t % 64) & 1 == 1 {
                prop_assert!(object.culls(&mesh.corners(t)), "triangle {}", t);
            }
        }
        let mut culled = vec![0; mesh.clusters().len().div_ceil(64)];
        if let Some(cones) = prepared.cluster_cones(eye.facing()) {
            cones.cull(level, &eye, &mut culled);
        }
        for (i, c) in mesh.clusters().iter().enumerate() {
            if culled[i / 64] >> (i % 64) & 1 == 1 {
                prop_assert!(c.triangles().all(|t| object.culls(&mesh.corners(t))), "cluster {}", i);
            }
        }
        // Cones of the other side say nothing to this eye.
        let other = if eye.facing() == Facing::Back { Facing::Front } else { Facing::Back };
        if let Some(cones) = prepared.cluster_cones(other) {
            cones.cull(level, &eye, &mut culled);
            prop_assert!(culled.iter().all(|&w| w == 0));
        }
    }
}

#[test]
fn a_cone_by_itself_says_what_the_mask_of_all_says() {
    let mesh = meshes::ball(16);
    let prepared = Prepared::of(&mesh, Preparation::ALL);
    let cones = prepared.cluster_cones(Facing::Back).expect("flat clusters");
    let (mut rng, mut culled, mut behind) = (Rng(61), Vec::new(), 0);
    for _ in 0..100 {
        let [x, y, z] = rng.vector(6.0);
        let at = [x, y, z, 1.0];
        let own = Transform::IDENTITY;
        let object = ObjectEye::new(at, &own, FrontFace::default(), CullFace::Back);
        let eye = prepared.backfaces().and_then(|planes| planes.eye(&object)).expect("an eye");
        cones.cull(cullet::Simd::best(), &eye, &mut culled);
        let alone = ClusterEye::new(at).expect("an eye");
        for i in 0..mesh.clusters().len() {
            let is_behind = cones.get(i).is_some_and(|cone| cone.is_behind_eye(&alone));
            assert_eq!(culled[i / 64] >> (i % 64) & 1 == 1, is_behind, "cluster {i} from {at:?}");
            behind += u32::from(is_behind);
        }
    }
    assert!(behind > 100, "{behind}");
}
