//! Bounds of skinned and morphed meshes hold every vertex, and `Scene::audit` finds those that do not.

use std::borrow::Cow;

use cullet::bounds::Aabb;
use cullet::{Instance, Mesh, MeshData, Scene, SceneError, Transform, scene::BoundsOverride};
use cullet_io::deform::{DeformError, JointBoxes, MorphBounds, MorphedJointBoxes, Morphs, Skin};
use proptest::prelude::*;

type Matrix = [[f32; 3]; 4];

/// Any matrix: turned, sheared, mirrored, flattened, far away.
fn matrix() -> impl Strategy<Value = Transform> {
    let scale = prop_oneof![4 => Just(1.0f32), 1 => Just(0.0), 1 => Just(-1.0), 1 => Just(100.0)];
    let away = prop_oneof![3 => Just(1.0f64), 1 => Just(1e6)];
    let three = || prop::array::uniform3(-2.0f32..2.0);
    (prop::array::uniform3(three()), prop::array::uniform3(-5.0f64..5.0), scale, away).prop_map(
        |(linear, t, scale, away)| Transform {
            linear: linear.map(|c| c.map(|v| v * scale)),
            translation: t.map(|v| v * away),
        },
    )
}

/// Positions, four joints and weights a vertex, and the joints' bind and current matrices.
#[derive(Clone, Debug)]
struct Figure {
    positions: Vec<[f32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    binds: Vec<Transform>,
    now: Vec<Transform>,
}

impl Figure {
    fn skin(&self) -> Skin<'_> {
        Skin {
            positions: &self.positions,
            joints: &self.joints,
            weights: &self.weights,
            inverse_binds: &self.binds,
        }
    }
}

const JOINTS: usize = 5;

fn figure(weight: impl Strategy<Value = [f32; 4]> + Clone) -> impl Strategy<Value = Figure> {
    let vertex =
        (prop::array::uniform3(-10.0f32..10.0), prop::array::uniform4(0..JOINTS as u16), weight);
    let joints = || prop::collection::vec(matrix(), JOINTS);
    (prop::collection::vec(vertex, 1..40), joints(), joints()).prop_map(|(v, binds, now)| Figure {
        positions: v.iter().map(|v| v.0).collect(),
        joints: v.iter().map(|v| v.1).collect(),
        weights: v.iter().map(|v| v.2).collect(),
        binds,
        now,
    })
}

/// Some of the four are 0, and all add to 1 as nearly as f32 can.
fn normal_weights() -> impl Strategy<Value = [f32; 4]> + Clone {
    let part = || prop_oneof![Just(0.0f32), 0.0f32..1.0];
    (0.01f32..1.0, part(), part(), part()).prop_map(|(a, b, c, d)| {
        let sum = a + b + c + d;
        [a, b, c, d].map(|w| w / sum)
    })
}

fn careless_weights() -> impl Strategy<Value = [f32; 4]> + Clone {
    prop::array::uniform4(prop_oneof![Just(0.0f32), -1.5f32..1.5])
}

fn f32_matrix(t: &Transform) -> Matrix {
    let [x, y, z] = t.linear;
    [x, y, z, t.translation.map(|v| v as f32)]
}

fn f32_apply(m: &Matrix, p: [f32; 3], w: f32) -> [f32; 3] {
    std::array::from_fn(|a| m[0][a] * p[0] + m[1][a] * p[1] + m[2][a] * p[2] + m[3][a] * w)
}

/// Poses as a vertex shader does: matrices multiplied, then blended, all in f32.
fn posed_in_f32(figure: &Figure) -> Vec<[f32; 3]> {
    let matrices: Vec<Matrix> = (0..JOINTS)
        .map(|j| {
            let (now, bind) = (f32_matrix(&figure.now[j]), f32_matrix(&figure.binds[j]));
            std::array::from_fn(|c| f32_apply(&now, bind[c], if c == 3 { 1.0 } else { 0.0 }))
        })
        .collect();
    let place = |v: usize| {
        let mut blend = [[0.0f32; 3]; 4];
        for (j, w) in figure.joints[v].into_iter().zip(figure.weights[v]) {
            for (c, column) in blend.iter_mut().enumerate() {
                (0..3).for_each(|a| column[a] += matrices[usize::from(j)][c][a] * w);
            }
        }
        f32_apply(&blend, figure.positions[v], 1.0)
    };
    (0..figure.positions.len()).map(place).collect()
}

fn hold(figure: &Figure) -> Result<(), TestCaseError> {
    let boxes = JointBoxes::new(&figure.skin()).unwrap();
    let bounds = boxes.bounds(&figure.now, [0.0; 3]);
    prop_assert!(bounds.is_finite());
    for points in [figure.skin().pose(&figure.now).unwrap(), posed_in_f32(figure)] {
        for (v, p) in points.into_iter().enumerate() {
            prop_assert!(bounds.contains(p), "vertex {v} at {p:?} leaves {bounds:?}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(400)))]

    #[test]
    fn joint_boxes_hold_every_blend(figure in figure(normal_weights())) {
        hold(&figure)?;
    }

    #[test]
    fn joint_boxes_hold_careless_weights(figure in figure(careless_weights())) {
        hold(&figure)?;
    }

    #[test]
    fn morphed_joint_boxes_hold_what_is_morphed_and_then_skinned(
        figure in figure(normal_weights()),
        pulls in prop::collection::vec(prop::array::uniform3(-5.0f32..5.0), 80),
        weights in prop::collection::vec(prop_oneof![Just(0.0f32), -2.0f32..2.0, Just(1e4)], 0..3),
    ) {
        let n = figure.positions.len();
        let targets = [&pulls[..n], &pulls[40..40 + n]];
        let boxes = MorphedJointBoxes::new(&figure.skin(), &targets).unwrap();
        let bounds = boxes.bounds(&figure.now, &weights, [0.0; 3]);
        prop_assert!(bounds.is_finite());
        let morphs = Morphs { positions: &figure.positions, targets: &targets };
        let morphed = Figure { positions: morphs.pose(&weights).unwrap(), ..figure.clone() };
        for points in [morphed.skin().pose(&figure.now).unwrap(), posed_in_f32(&morphed)] {
            for (v, p) in points.into_iter().enumerate() {
                prop_assert!(bounds.contains(p), "vertex {v} at {p:?} leaves {bounds:?}");
            }
        }
        if weights.iter().all(|w| *w == 0.0) {
            let plain = JointBoxes::new(&figure.skin()).unwrap().bounds(&figure.now, [0.0; 3]);
            let grown = (0..3).map(|a| bounds.max[a] - plain.max[a]).fold(0.0f32, f32::max);
            let size = plain.max.iter().chain(&plain.min).fold(0.0f32, |m, v| m.max(v.abs()));
            prop_assert!(grown <= size * 1e-3, "without weights it is as loose as {grown}");
        }
    }

    #[test]
    fn an_origin_is_subtracted(figure in figure(normal_weights()), o in prop::array::uniform3(-1e7f64..1e7)) {
        let bounds = JointBoxes::new(&figure.skin()).unwrap().bounds(&figure.now, o);
        for p in figure.skin().pose(&figure.now).unwrap() {
            for a in 0..3 {
                let p = f64::from(p[a]) - o[a];
                prop_assert!(f64::from(bounds.min[a]) <= p && p <= f64::from(bounds.max[a]));
            }
        }
    }

    #[test]
    fn morph_bounds_hold_any_weights(
        vertices in prop::collection::vec(prop::array::uniform3(-10.0f32..10.0), 1..30),
        pulls in prop::collection::vec(prop::array::uniform3(-10.0f32..10.0), 90),
        weights in prop::collection::vec(prop_oneof![Just(0.0f32), -2.0f32..2.0, Just(1e6)], 0..4),
    ) {
        let n = vertices.len();
        let targets = [&pulls[..n], &pulls[30..30 + n], &pulls[60..60 + n]];
        let morphs = Morphs { positions: &vertices, targets: &targets };
        let bounds = MorphBounds::new(&morphs).unwrap().bounds(&weights);
        let in_f32 = |v: usize| {
            let pulled = targets.iter().zip(&weights);
            pulled.fold(vertices[v], |p, (t, w)| std::array::from_fn(|a| p[a] + t[v][a] * w))
        };
        let exact = morphs.pose(&weights).unwrap();
        for (v, p) in exact.into_iter().enumerate() {
            prop_assert!(bounds.contains(p) && bounds.contains(in_f32(v)), "{p:?} leaves {bounds:?}");
        }
    }
}

#[test]
fn a_turned_arm_has_tight_bounds() {
    // Upper and lower arm along x, the elbow at x = 1 bent up by a quarter.
    let positions: Vec<[f32; 3]> = (0..=20).map(|i| [i as f32 * 0.1, 0.0, 0.0]).collect();
    let joints = vec![[0u16, 1, 0, 0]; 21];
    let weights: Vec<[f32; 4]> = (0..=20)
        .map(|i| if i <= 10 { [1.0, 0.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0, 0.0] })
        .collect();
    let binds = [Transform::IDENTITY, Transform::from_translation([-1.0, 0.0, 0.0])];
    let skin =
        Skin { positions: &positions, joints: &joints, weights: &weights, inverse_binds: &binds };
    let up = Transform {
        linear: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [1.0, 0.0, 0.0],
    };
    let boxes = JointBoxes::new(&skin).unwrap();
    let b = boxes.bounds(&[Transform::IDENTITY, up], [0.0; 3]);
    for (got, want) in b.min.iter().chain(&b.max).zip([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]) {
        assert!((got - want).abs() < 1e-5, "{b:?}");
    }
    assert_eq!(boxes.joint_box(7), Aabb::EMPTY);
    assert!(boxes.joint_box(1).min[0] > 0.0);
}

#[test]
fn what_is_missing_keeps_everything() {
    let positions = [[0.0f32, 1.0, 2.0]; 2];
    let joints = [[0u16, 9, 9, 9], [1, 0, 0, 0]];
    let weights = [[1.0f32, 0.0, 0.0, 0.0]; 2];
    let binds = [Transform::IDENTITY; 2];
    let skin =
        Skin { positions: &positions, joints: &joints, weights: &weights, inverse_binds: &binds };
    // The joints 9 have weight 0.
    let boxes = JointBoxes::new(&skin).unwrap();
    assert_eq!(boxes.bounds(&binds[..1], [0.0; 3]), Aabb::EVERYTHING);
    let mut broken = binds;
    broken[1].linear[0][0] = f32::NAN;
    assert_eq!(boxes.bounds(&broken, [0.0; 3]), Aabb::EVERYTHING);
    let nan = [[f32::NAN, 0.0, 0.0, 0.0]; 2];
    let boxes = JointBoxes::new(&Skin { weights: &nan, ..skin }).unwrap();
    assert_eq!(boxes.bounds(&binds, [0.0; 3]), Aabb::EVERYTHING);
    // Without weights all vertices are at zero; without vertices there is nothing.
    let none = JointBoxes::new(&Skin { weights: &[[0.0; 4]; 2], ..skin }).unwrap();
    assert!(none.bounds(&[], [0.0; 3]).contains([0.0; 3]));
    let empty = Skin { positions: &[], joints: &[], weights: &[], inverse_binds: &[] };
    assert_eq!(JointBoxes::new(&empty).unwrap().bounds(&[], [0.0; 3]), Aabb::EMPTY);

    let error = JointBoxes::new(&Skin { inverse_binds: &binds[..1], ..skin }).unwrap_err();
    assert_eq!(error, DeformError::Joint { vertex: 1, joint: 1, joints: 1 });
    let error = JointBoxes::new(&Skin { weights: &weights[..1], ..skin }).unwrap_err();
    assert_eq!(
        error.to_string(),
        "weights are 1, but there are 2 vertices; give one for each vertex"
    );
    let targets: [&[[f32; 3]]; 1] = [&positions[..1]];
    assert!(MorphBounds::new(&Morphs { positions: &positions, targets: &targets }).is_err());
    let targets: [&[[f32; 3]]; 1] = [&[[f32::NAN; 3]; 2]];
    let morphs = MorphBounds::new(&Morphs { positions: &positions, targets: &targets }).unwrap();
    assert_eq!(morphs.bounds(&[1.0]), Aabb::EVERYTHING);
    assert_eq!(morphs.bounds(&[f32::NAN]), Aabb::EVERYTHING);
    assert!(morphs.bounds(&[0.0]).is_finite());
    let morphs = MorphBounds::new(&Morphs { positions: &[], targets: &[] }).unwrap();
    assert_eq!(morphs.bounds(&[1.0]), Aabb::EMPTY);
}

fn triangle() -> Mesh {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [50.0, 50.0, 50.0]];
    // The last vertex is of no triangle.
    Mesh::new(MeshData {
        positions,
        indices: vec![0, 1, 2],
        deformable: true,
        ..MeshData::default()
    })
    .unwrap()
}

#[test]
fn audit_names_the_stale_and_nothing_else() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(triangle());
    let place = |x: f64, y: f64| Transform::from_translation([x, y, 0.1]);
    let mut add = |bounds| {
        let x = f64::from(scene.slot_count()) * 1e6 / 3.0;
        scene.add(Instance { bounds, ..Instance::new(mesh, place(x, 1e5 / 7.0)) }).unwrap()
    };
    let rigid: Vec<_> = (0..20).map(|_| add(BoundsOverride::Mesh)).collect();
    let stale = rigid[13];
    let unbounded = add(BoundsOverride::None);
    let margin = add(BoundsOverride::Margin(2.5));
    scene.rebase([1e5, 0.0, 3.0]);
    assert_eq!(scene.audit(|_| None), Ok(vec![]), "rigid instances keep to their bounds");

    // All of these moved by 2 along y; the bounds of only one do not know.
    let mut moved = triangle().positions().to_vec();
    moved.iter_mut().take(3).for_each(|p| p[1] += 2.0);
    let current = |h| [stale, unbounded, margin].contains(&h).then(|| Cow::Borrowed(&moved[..]));
    let violations = scene.audit(current).unwrap();
    assert_eq!(violations.len(), 1, "{violations:?}");
    let s = violations[0];
    assert_eq!((s.handle, s.slot, s.vertex, s.outside), (stale, 13, 2, 3));
    assert!((s.excess - 2.0).abs() < 0.01, "{s:?}");
    // Grown by what it says, they hold.
    scene.set_bounds(stale, BoundsOverride::Margin(s.excess as f32 * 1.001)).unwrap();
    assert_eq!(scene.audit(current), Ok(vec![]));

    let mut broken = moved.clone();
    broken[1][0] = f32::NAN;
    let violations = scene.audit(|h| (h == stale).then(|| Cow::Borrowed(&broken[..]))).unwrap();
    assert_eq!(
        (violations.len(), violations[0].vertex, violations[0].excess),
        (1, 1, f64::INFINITY)
    );
    let error = scene.audit(|h| (h == stale).then(|| Cow::Borrowed(&moved[..2]))).unwrap_err();
    assert_eq!(error, SceneError::Positions { handle: stale, given: 2, vertices: 4 });
}

#[test]
fn a_target_grows_only_the_joints_whose_vertices_it_moves() {
    let positions = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]];
    let skin = Skin {
        positions: &positions,
        joints: &[[0, 0, 0, 0], [1, 0, 0, 0]],
        weights: &[[1.0, 0.0, 0.0, 0.0]; 2],
        inverse_binds: &[Transform::IDENTITY; 2],
    };
    let smile: [[f32; 3]; 2] = [[0.0, 2.0, 0.0], [0.0, 0.0, 0.0]];
    let lost: [[f32; 3]; 2] = [[f32::NAN, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let boxes = MorphedJointBoxes::new(&skin, &[&smile, &lost]).unwrap();
    // Joint 1 is lifted far up, and no vertex that the target moves is with it.
    let joints = [Transform::IDENTITY, Transform::from_translation([0.0, 50.0, 0.0])];
    let b = boxes.bounds(&joints, &[1.5], [0.0; 3]);
    assert!((b.max[1] - 50.0).abs() < 1e-2 && b.min[1] > -1e-2, "{b:?}");
    assert_eq!(boxes.bounds(&joints, &[1.5, 0.1], [0.0; 3]), Aabb::EVERYTHING);
    assert_eq!(boxes.bounds(&joints, &[f32::NAN], [0.0; 3]), Aabb::EVERYTHING);
    assert_eq!(boxes.bounds(&joints[..1], &[1.5], [0.0; 3]), Aabb::EVERYTHING);
    let short: [[f32; 3]; 1] = [[0.0; 3]];
    let error = MorphedJointBoxes::new(&skin, &[&short]).unwrap_err();
    assert!(matches!(error, DeformError::Length { count: 1, vertices: 2, .. }), "{error}");
}
