//! Shapes as positions and indices, and what can be measured of them without the code under test.

use std::collections::HashMap;

use crate::Rng;
use crate::vectors::{cross, dot};

/// Positions, and three indices a triangle.
pub type Soup = (Vec<[f32; 3]>, Vec<u32>);

/// The box between two corners, wound outward.
pub fn block(min: [f32; 3], max: [f32; 3]) -> Soup {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { max[a] } else { min[a] });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    ((0..8).map(corner).collect(), indices)
}

/// The unit ball around the origin, wound outward: `rings` × `around` quads, triangles at the poles, which are one
/// vertex each, as the seam is.
pub fn ball(rings: u32, around: u32) -> Soup {
    let mut positions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    for r in 1..rings {
        let (s, c) = (std::f64::consts::PI * f64::from(r) / f64::from(rings)).sin_cos();
        for k in 0..around {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
            positions.push([s * cos, c, s * sin].map(|v| v as f32));
        }
    }
    let at = |r: u32, k: u32| 2 + (r - 1) * around + k % around;
    let mut indices = Vec::new();
    for k in 0..around {
        indices.extend([0, at(1, k + 1), at(1, k)]);
        indices.extend([1, at(rings - 1, k), at(rings - 1, k + 1)]);
        for r in 1..rings - 1 {
            let [a, b, c, d] = [at(r, k), at(r, k + 1), at(r + 1, k), at(r + 1, k + 1)];
            indices.extend([a, b, c, b, d, c]);
        }
    }
    (positions, indices)
}

/// Small triangles all over the unit ball, some of them slivers or points, wound outward; no vertex is shared.
pub fn facets(rng: &mut Rng, count: usize) -> Soup {
    let mut positions = Vec::new();
    for i in 0..count {
        let p = rng.vector(1.0);
        let length = dot(p, p).sqrt().max(1e-9);
        let p = p.map(|v| v / length);
        let (mut u, mut v) = (rng.vector(1.0), rng.vector(1.0));
        let size = if i % 50 == 0 { 1e-7 } else { 0.05 };
        for e in [&mut u, &mut v] {
            let along = dot(*e, p) * 0.7;
            (0..3).for_each(|k| e[k] = (e[k] - p[k] * along) * size);
        }
        if i % 70 == 0 {
            v = u;
        }
        if dot(cross(u, v), p) < 0.0 {
            (u, v) = (v, u);
        }
        let at = |e: [f64; 3]| std::array::from_fn(|k| (p[k] + e[k]) as f32);
        positions.extend([at([0.0; 3]), at(u), at(v)]);
    }
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

/// The ball, its radius 1 plus `bump` times a wave.
pub fn bumpy_ball(rings: u32, bump: f32) -> Soup {
    moved(ball(rings, rings * 2), |p| {
        let wave = (p[0] * 9.0).sin() + (p[1] * 11.0).sin() + (p[2] * 13.0).sin();
        p.map(|v| v * (1.0 + bump * wave))
    })
}

/// The ball of `rings` × 2 `rings` quads, of a radius, around a centre.
pub fn ball_at(center: [f32; 3], radius: f32, rings: u32) -> Soup {
    moved(ball(rings, rings * 2), |p| std::array::from_fn(|a| center[a] + radius * p[a]))
}

/// A ball with lumps, as a rabbit or an armadillo has limbs, of 4,680 triangles as the text of an OBJ file, which says
/// nothing of sides; without the last `missing` triangles, so that it is open.
pub fn lumpy_ball_as_obj(missing: usize) -> String {
    let (positions, mut indices) = moved(ball(40, 60), |p| {
        let (turn, polar) = (p[2].atan2(p[0]), p[1].clamp(-1.0, 1.0).acos());
        p.map(|v| v * (1.0 + 0.3 * (5.0 * turn).sin() * (6.0 * polar).sin()))
    });
    indices.truncate(indices.len() - missing * 3);
    let vertices = positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces =
        indices.chunks_exact(3).map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

/// A bumpy square sheet of `side`² quads, with a mean slope of about one half, that faces up.
pub fn terrain(side: u32) -> Soup {
    let mut positions = Vec::new();
    for y in 0..=side {
        for x in 0..=side {
            let (u, v) = (x as f32 * 0.11, y as f32 * 0.07);
            positions.push([x as f32, (u.sin() + v.cos()) * 4.0, y as f32]);
        }
    }
    let mut indices = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let a = y * (side + 1) + x;
            indices.extend([a, a + side + 1, a + 1, a + 1, a + side + 1, a + side + 2]);
        }
    }
    (positions, indices)
}

/// A box from (−1, 0, −1) to (1, 1, 1), its faces cut into `sub` × `sub` quads that share no vertices with the next face.
pub fn divided_block(sub: u32) -> Soup {
    let (mut positions, mut indices) = Soup::default();
    for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
        let first = positions.len() as u32;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in 0..=sub {
            for j in 0..=sub {
                let mut p = [0.0; 3];
                p[axis] = side as f32 * 2.0 - 1.0;
                p[u] = i as f32 / sub as f32 * 2.0 - 1.0;
                p[v] = j as f32 / sub as f32 * 2.0 - 1.0;
                p[1] = p[1] * 0.5 + 0.5;
                positions.push(p);
            }
        }
        let at = |i: u32, j: u32| first + i * (sub + 1) + j;
        for i in 0..sub {
            for j in 0..sub {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let quad = if side == 1 { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
                indices.extend(quad);
            }
        }
    }
    (positions, indices)
}

/// Small triangles that share nothing, in a cube ten units wide.
pub fn scattered(triangles: u32) -> Soup {
    let mut rng = Rng(1);
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let corner: [f64; 3] = std::array::from_fn(|_| rng.range(0.0, 10.0));
        positions.extend((0..3).map(|_| corner.map(|c| (c + rng.range(0.0, 0.3)) as f32)));
    }
    (positions, (0..triangles * 3).collect())
}

/// Several shapes as one.
pub fn join(soups: impl IntoIterator<Item = Soup>) -> Soup {
    let (mut positions, mut indices) = Soup::default();
    for (p, i) in soups {
        let base = positions.len() as u32;
        positions.extend(p);
        indices.extend(i.into_iter().map(|i| i + base));
    }
    (positions, indices)
}

/// Every vertex moved.
pub fn moved((mut positions, indices): Soup, to: impl Fn([f32; 3]) -> [f32; 3]) -> Soup {
    positions.iter_mut().for_each(|p| *p = to(*p));
    (positions, indices)
}

/// Every triangle turned over.
pub fn turned((positions, mut indices): Soup) -> Soup {
    indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    (positions, indices)
}

/// Three vertices of its own for each triangle.
pub fn unshared((positions, indices): &Soup) -> Soup {
    let positions: Vec<_> = indices.iter().map(|&i| positions[i as usize]).collect();
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

/// Edges, by position, that triangles do not run along as often one way as the other.
pub fn leaks(positions: &[[f32; 3]], indices: &[u32]) -> usize {
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

/// The signed volume that the triangles enclose, seen from the origin: positive where they are wound outward.
pub fn volume(positions: &[[f32; 3]], indices: &[u32]) -> f64 {
    let det = |t: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|i| positions[t[i] as usize].map(f64::from));
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    indices.chunks_exact(3).map(det).sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_shapes_are_closed_and_wound_outward() {
        let pi = std::f64::consts::PI;
        let closed = [
            (block([-1.0, 0.0, 0.0], [1.0, 1.0, 3.0]), 6.0, 12),
            (divided_block(3), 4.0, 108),
            (ball(60, 120), pi * 4.0 / 3.0, 2 * 120 * 59),
            (bumpy_ball(60, 0.0), pi * 4.0 / 3.0, 2 * 120 * 59),
            (ball_at([3.0, 1.0, -2.0], 2.0, 60), pi * 32.0 / 3.0, 2 * 120 * 59),
            (join([ball(4, 5), moved(ball(4, 5), |p| p.map(|v| v + 4.0))]), 0.0, 60),
        ];
        for ((positions, indices), expected, triangles) in closed {
            assert_eq!(indices.len() / 3, triangles);
            assert_eq!(leaks(&positions, &indices), 0);
            let found = volume(&positions, &indices);
            assert!(found > 0.0 && (expected == 0.0 || (found / expected - 1.0).abs() < 0.01));
            let (positions, indices) = turned((positions, indices));
            assert!((volume(&positions, &indices) + found).abs() < 1e-9);
            let (apart, each) = unshared(&(positions, indices));
            assert_eq!((leaks(&apart, &each), apart.len()), (0, triangles * 3));
        }
        let (positions, indices) = terrain(5);
        assert_eq!(leaks(&positions, &indices), 20);
        let (positions, indices) = scattered(9);
        assert_eq!(leaks(&positions, &indices), 27);
    }
}
