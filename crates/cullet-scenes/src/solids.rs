//! Closed shapes of many kinds.

use std::f64::consts::SQRT_2;

use cullet::Transform;
use glam::{DMat3, DVec3};

use super::builder::{SceneBuilder, Sides, any_rotation, fill};
use super::rng::{Rng, sin_cos};
use super::shapes::{Shape, star};
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::Model;

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "solids",
    about: "closed shapes of many kinds in a square, convex and concave, with holes and cavities, \
            turned, stretched and mirrored; half of their triangles always face away",
    keys: &[
        KeyInfo { name: "seed", about: "which poses", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "n",
            about: "how many shapes, all kinds in turn",
            default: 225,
            min: 1,
            max: 1_000_000,
        },
    ],
};

/// Distance between neighbouring shapes, each of which fits a sphere of radius 1 before it is
/// stretched.
const PITCH: f64 = 4.0;

/// Colours in turn (Okabe and Ito's, without black).
const COLOURS: [u32; 7] = [0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442, 0x0072B2, 0xD55E00, 0xCC79A7];

/// Every kind, by name; each is within −1..1 on every axis.
pub(super) fn kinds() -> Vec<(&'static str, Shape)> {
    let ball = |steps: u32| -> Vec<[f64; 2]> {
        (0..=steps)
            .map(|i| match i {
                0 => [0.0, -1.0],
                i if i == steps => [0.0, 1.0],
                i => {
                    let (s, c) = sin_cos(f64::from(i) / f64::from(steps) * 0.5);
                    [s, -c]
                }
            })
            .collect()
    };
    let circle = |centre: f64, radius: f64, steps: u32| -> Vec<[f64; 2]> {
        (0..steps)
            .map(|i| {
                let (s, c) = sin_cos(f64::from(i) / f64::from(steps));
                [centre + radius * c, radius * s]
            })
            .collect()
    };
    let capsule: Vec<[f64; 2]> = ball(12)
        .iter()
        .map(|[r, y]| [r * 0.5, y * 0.5 + if *y < 0.0 { -0.5 } else { 0.5 }])
        .collect();
    let gear: Vec<[f64; 2]> = (0..48)
        .map(|i| {
            let r = if i / 2 % 2 == 0 { 1.0 } else { 0.78 };
            let (s, c) = sin_cos(f64::from(i) / 48.0);
            [r * c, r * s]
        })
        .collect();
    let stairs: Vec<[f64; 2]> = [[-1.0, -1.0], [1.0, -1.0]]
        .into_iter()
        .chain((0..5).rev().flat_map(|i| {
            let x = f64::from(i) * 0.4 - 1.0;
            [[x + 0.4, x + 0.4], [x, x + 0.4]]
        }))
        .collect();
    let arrow = [
        [-1.0, -0.35],
        [0.2, -0.35],
        [0.2, -0.9],
        [1.0, 0.0],
        [0.2, 0.9],
        [0.2, 0.35],
        [-1.0, 0.35],
    ];
    let a = 0.35;
    let cross = [
        [-a, -1.0],
        [a, -1.0],
        [a, -a],
        [1.0, -a],
        [1.0, a],
        [a, a],
        [a, 1.0],
        [-a, 1.0],
        [-a, a],
        [-1.0, a],
        [-1.0, -a],
        [-a, -a],
    ];
    let vase = [
        [0.0, -1.0],
        [0.45, -1.0],
        [0.75, -0.4],
        [0.6, 0.2],
        [0.35, 0.6],
        [0.5, 1.0],
        [0.4, 1.0],
        [0.25, 0.6],
        [0.5, 0.2],
        [0.65, -0.4],
        [0.4, -0.9],
        [0.0, -0.9],
    ];
    // Ten sides, eight triangles each: outside, inside, and the two annular ends.
    let pipe = [[0.7, -1.0], [1.0, -1.0], [1.0, 1.0], [0.7, 1.0]];
    let frame = [[0.6, -0.25], [SQRT_2, -0.25], [SQRT_2, 0.25], [0.6, 0.25]];
    let cube = |r: f64| Shape::cuboid([-r; 3], [r; 3]);
    let ico = |r: f64| Shape::icosphere(2).scaled([r; 3], [0.0; 3]);
    vec![
        ("box", cube(0.8)),
        ("tetrahedron", Shape::tetrahedron()),
        ("octahedron", Shape::octahedron()),
        ("dodecahedron", Shape::dodecahedron()),
        ("icosahedron", Shape::icosahedron()),
        ("sphere", Shape::lathe(&ball(16), 32)),
        ("icosphere", Shape::icosphere(3)),
        ("capsule", Shape::lathe(&capsule, 24)),
        ("cylinder", Shape::lathe(&[[0.7, -1.0], [0.7, 1.0]], 32)),
        ("cone", Shape::lathe(&[[0.9, -1.0], [0.0, 1.0]], 32)),
        ("pyramid stump", Shape::lathe(&[[1.0, -0.7], [0.5, 0.7]], 4)),
        ("torus", Shape::ring_lathe(&circle(0.7, 0.3, 16), 32)),
        ("80-face pipe", Shape::ring_lathe(&pipe, 10)),
        ("elbow", Shape::rod(12, false, 0.35, 16, elbow)),
        ("spring", Shape::rod(96, false, 0.12, 8, spring)),
        ("torus knot", Shape::rod(160, true, 0.16, 10, knot)),
        ("star", Shape::prism(&star(5, 0.42), -0.3, 0.3)),
        ("gear", Shape::prism(&gear, -0.2, 0.2)),
        ("cross", Shape::prism(&cross, -a, a)),
        ("arrow", Shape::prism(&arrow, -0.25, 0.25)),
        ("stairs", Shape::prism(&stairs, -0.6, 0.6)),
        ("wedge", Shape::prism(&[[-1.0, -0.6], [1.0, -0.6], [-1.0, 0.6]], -0.7, 0.7)),
        ("frame", Shape::ring_lathe(&frame, 4).map(|p| quarter_diagonal(p) * 0.99)),
        ("vase", Shape::lathe(&vase, 24)),
        ("hollow box", cube(0.8).and(&cube(0.6).flipped())),
        ("onion", ico(1.0).and(&ico(0.8).flipped()).and(&ico(0.5))),
        (
            "twins",
            Shape::octahedron()
                .scaled([0.45; 3], [-0.5, 0.0, 0.0])
                .and(&Shape::octahedron().scaled([0.45; 3], [0.5, 0.0, 0.0])),
        ),
    ]
}

/// Turned by an eighth about y, which sets the corners of a four-sided lathe on the diagonals.
fn quarter_diagonal(p: DVec3) -> DVec3 {
    let h = SQRT_2 * 0.5;
    DVec3::new(h * (p.x + p.z), p.y, h * (p.z - p.x))
}

/// A quarter of a circle.
fn elbow(t: f64) -> (DVec3, DVec3, DVec3) {
    let (s, c) = sin_cos(t * 0.25);
    let out = DVec3::new(c, s, 0.0);
    (out * 1.2 - DVec3::new(0.6, 0.6, 0.0), DVec3::Z, out)
}

/// Four turns about the y axis.
fn spring(t: f64) -> (DVec3, DVec3, DVec3) {
    let (s, c) = sin_cos(t * 4.0);
    let along =
        DVec3::new(-s * 0.85, 0.8 * 2.0 / (4.0 * std::f64::consts::TAU), c * 0.85).normalize();
    let out = DVec3::new(c, 0.0, s);
    (DVec3::new(c * 0.85, t * 1.6 - 0.8, s * 0.85), out, along.cross(out))
}

/// The (2, 3) torus knot.
fn knot(t: f64) -> (DVec3, DVec3, DVec3) {
    let at = |t: f64| {
        let (s2, c2) = sin_cos(2.0 * t);
        let (s3, c3) = sin_cos(3.0 * t);
        let r = 0.55 + 0.25 * c3;
        DVec3::new(r * c2, r * s2, 0.25 * s3)
    };
    let (p, ahead) = (at(t), at(t + 1e-4));
    // The frame leans on the origin, so that it comes back to itself after the whole length.
    let along = (ahead - p).normalize();
    let out = along.cross(p + ahead).normalize();
    (p, out, along.cross(out))
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let n = spec.get("n") as u32;
    let mut rng = Rng::new(spec.get("seed"), 1);
    let mut b = SceneBuilder::new(spec);
    let mut meshes = Vec::new();
    for (i, (name, shape)) in kinds().into_iter().enumerate() {
        let material = b.material(name, COLOURS[i % COLOURS.len()]);
        meshes.push(b.mesh(name, &[(shape, material)], Sides::One)?);
    }
    let side = f64::from(n).sqrt().ceil();
    let reach = side * PITCH * 0.5;
    let material = b.material("floor", 0xB9B4AA);
    let floor = b.mesh("floor", &[(Shape::building(1), material)], Sides::One)?;
    let edge = reach + 1.0;
    b.add(floor, fill([-edge, -0.5, -edge], [edge, 0.0, edge]))?;

    for i in 0..n {
        let mesh = meshes[i as usize % meshes.len()];
        let row = (f64::from(i) / side).floor();
        let column = f64::from(i) - row * side;
        let stretch = DVec3::new(rng.range(0.6, 1.4), rng.range(0.6, 1.4), rng.range(0.6, 1.4));
        // The first of each kind is upright, so that a grid of few shapes shows them plainly.
        let rotation =
            if i < meshes.len() as u32 { DMat3::IDENTITY } else { any_rotation(&mut rng) };
        let mirror = if i % 4 == 3 { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
        let m = rotation * DMat3::from_diagonal(stretch * mirror);
        let linear = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.as_vec3().to_array());
        let at = |y: f64| Transform {
            linear,
            translation: [(column + 0.5) * PITCH - reach, y, (row + 0.5) * PITCH - reach],
        };
        // It floats a little above the floor: touching faces would hide each other.
        let lowest =
            at(0.0).transform_box(&b.model.scene.meshes()[mesh as usize].bounds(), [0.0; 3]);
        b.add(mesh, at(0.1 - f64::from(lowest.min[1])))?;
    }
    Ok(b.finish())
}
