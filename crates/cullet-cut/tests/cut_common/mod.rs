//! What the tests of cuts share: shapes, and checks that do not trust the code under test.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::collections::HashMap;

use cullet::bounds::Plane;
use cullet_cut::{CapOptions, CutInput, CutMesh, CutOptions, Keep, cut};

/// Positions and indices.
pub(crate) type Shape = (Vec<[f32; 3]>, Vec<u32>);

/// A sphere of `rings` × 2·`rings` quads, welded at its poles and its seam.
pub(crate) fn sphere(centre: [f32; 3], radius: f32, rings: u32) -> Shape {
    let (around, mut positions, mut indices) = (rings * 2, vec![], vec![]);
    for i in 1..rings {
        let polar = std::f64::consts::PI * f64::from(i) / f64::from(rings);
        for j in 0..around {
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let p = [polar.sin() * turn.cos(), polar.cos(), -polar.sin() * turn.sin()];
            positions.push([0, 1, 2].map(|a| centre[a] + radius * p[a] as f32));
        }
    }
    let at = |i: u32, j: u32| (i - 1) * around + j % around;
    let [north, south] = [0, 1].map(|i| positions.len() as u32 + i);
    positions.push([centre[0], centre[1] + radius, centre[2]]);
    positions.push([centre[0], centre[1] - radius, centre[2]]);
    for j in 0..around {
        indices.extend([north, at(1, j), at(1, j + 1)]);
        indices.extend([south, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    (positions, indices)
}

/// A box of twelve triangles.
pub(crate) fn cube(min: [f32; 3], max: [f32; 3]) -> Shape {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] });
    let faces: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    ((0..8).map(corner).collect(), indices)
}

/// Several shapes as one.
pub(crate) fn join(shapes: &[Shape]) -> Shape {
    let mut all: Shape = Default::default();
    for (positions, indices) in shapes {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(indices.iter().map(|i| i + first));
    }
    all
}

/// The same surface inside out.
pub(crate) fn turned(mut shape: Shape) -> Shape {
    shape.1.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    shape
}

/// Three vertices of its own for each triangle.
pub(crate) fn soup((positions, indices): &Shape) -> Shape {
    let positions: Vec<_> = indices.iter().map(|&i| positions[i as usize]).collect();
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

/// Edges, by position, that triangles do not run along as often one way as the other.
pub(crate) fn leaks(positions: &[[f32; 3]], indices: &[u32]) -> usize {
    let mut net: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for t in indices.chunks_exact(3) {
        let p = [0, 1, 2].map(|i| positions[t[i] as usize].map(|v| (v + 0.0).to_bits()));
        for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
            if a < b {
                *net.entry([a, b]).or_default() += 1;
            } else if b < a {
                *net.entry([b, a]).or_default() -= 1;
            }
        }
    }
    net.values().filter(|&&n| n != 0).count()
}

/// Six times the signed volume, divided by six, about the origin of the coordinates.
pub(crate) fn volume(positions: &[[f32; 3]], indices: &[u32]) -> f64 {
    let det = |t: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|i| positions[t[i] as usize].map(f64::from));
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    indices.chunks_exact(3).map(det).sum::<f64>() / 6.0
}

/// Cuts, with caps.
pub(crate) fn capped(shape: &Shape, planes: &[Plane], keep: Keep) -> CutMesh {
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    cut(&input, planes, &CutOptions { keep, caps: Some(CapOptions::default()) }).unwrap()
}

/// Cuts, left open.
pub(crate) fn open(shape: &Shape, planes: &[Plane], keep: Keep) -> CutMesh {
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    cut(&input, planes, &CutOptions { keep, caps: None }).unwrap()
}

/// Both halves of a closed shape must be closed, and their volumes add up. Returns that of the inside.
#[track_caller]
pub(crate) fn check_halves(shape: &Shape, planes: &[Plane], what: &str) -> f64 {
    let whole = volume(&shape.0, &shape.1);
    let halves = [Keep::Inside, Keep::Outside].map(|keep| {
        let half = capped(shape, planes, keep);
        assert_eq!(half.origin.len() * 3, half.indices.len());
        assert_eq!(half.report.open_chains, 0, "{what}, {keep:?}: {:?}", half.report);
        let leaks = leaks(&half.positions, &half.indices);
        assert_eq!(leaks, 0, "{what}, {keep:?}, {planes:?}: {:?}", half.report);
        volume(&half.positions, &half.indices)
    });
    let sum = halves[0] + halves[1];
    assert!(
        (sum - whole).abs() <= whole.abs() * 1e-6 + 1e-12,
        "{what}: {halves:?} is not {whole}, {planes:?}"
    );
    halves[0]
}

/// Small, plain pseudo-random numbers (xorshift).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// From −1 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A number below `n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (((self.next() + 1.0) * 0.5 * n as f64) as usize).min(n - 1)
    }

    /// A plane that passes near the middle of a box of this centre and half size.
    pub(crate) fn plane(&mut self, centre: [f64; 3], half: [f64; 3]) -> Plane {
        let normal = [self.next(), self.next(), self.next()];
        let d = (0..3).map(|a| normal[a] * (centre[a] + half[a] * self.next() * 0.7)).sum();
        Plane::new(normal, d)
    }
}
