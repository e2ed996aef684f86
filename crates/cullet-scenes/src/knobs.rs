//! A single uneven body, as a scanned figure is.

use std::collections::HashMap;

use cullet::Transform;
use glam::DVec3;

use super::builder::{SceneBuilder, Sides};
use super::shapes::Shape;
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::Model;

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "knobs",
    about: "one closed ball with knobs and hollows, its triangles even in size and facing all ways, as \
            those of a scanned figure do",
    keys: &[KeyInfo {
        name: "n",
        about: "fineness: it has 12·n² triangles",
        default: 40,
        min: 2,
        max: 1000,
    }],
};

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let (positions, indices) = knobbly_ball(spec.get("n") as u16);
    let mut b = SceneBuilder::new(spec);
    let material = b.material("clay", 0xCFC8BC);
    let mesh = b.mesh("knobbly ball", &[(Shape { positions, indices }, material)], Sides::One)?;
    // Its lowest point is 1.15 below its middle at the most: three knobs of 0.05.
    b.add(mesh, Transform::from_translation([0.0, 1.15, 0.0]))?;
    Ok(b.finish())
}

/// Positions and indices of the ball of the scene `knobs`, around the origin: closed, wound
/// outward, of 12·n² triangles and 6·n² + 2 vertices. Its radius is 0.85 to 1.15.
///
/// Roots and polynomials alone make it, so it is the same on every machine. `n` of 0 gives nothing.
#[must_use]
pub fn knobbly_ball(n: u16) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    let mut known: HashMap<[u16; 3], u32> = HashMap::new();
    let mut indices = Vec::with_capacity(usize::from(n) * usize::from(n) * 36);
    for face in 0..6 {
        let (axis, high) = (face / 2, face % 2 == 1);
        let mut vertex = |u: u16, v: u16| {
            let mut at = [0; 3];
            at[axis] = if high { n } else { 0 };
            at[(axis + 1) % 3] = u;
            at[(axis + 2) % 3] = v;
            *known.entry(at).or_insert_with(|| {
                positions.push(knob(at.map(|v| 2.0 * f64::from(v) / f64::from(n) - 1.0)));
                positions.len() as u32 - 1
            })
        };
        for v in 0..n {
            for u in 0..n {
                let [a, b] = [vertex(u, v), vertex(u + 1, v)];
                let [c, d] = [vertex(u + 1, v + 1), vertex(u, v + 1)];
                // u, v and the outward axis are right-handed on the high face.
                let quad = if high { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
                indices.extend(quad);
            }
        }
    }
    (positions, indices)
}

/// A point of the cube's surface, moved to the ball.
fn knob(cube: [f64; 3]) -> [f32; 3] {
    // As wide in the middle of a face as at its edges, nearly: tan(π/4·t) by a cubic.
    let even = cube.map(|t| t * (0.8 + 0.2 * t * t));
    let d = DVec3::from(even).normalize();
    let r = 1.0 + 0.05 * (chebyshev(9, d.x) + chebyshev(8, d.y) + chebyshev(7, d.z));
    (d * r).as_vec3().to_array()
}

/// cos(n·acos x).
fn chebyshev(n: u32, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    for _ in 1..n {
        (before, now) = (now, 2.0 * x * now - before);
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_radius_and_edges_are_as_told() {
        for n in [1, 2, 9] {
            let (positions, indices) = knobbly_ball(n);
            let n = usize::from(n);
            assert_eq!((indices.len(), positions.len()), (36 * n * n, 6 * n * n + 2));
            for p in positions {
                let r = DVec3::from(p.map(f64::from)).length();
                assert!((0.849_99..1.150_01).contains(&r), "{r}");
            }
        }
        assert_eq!(knobbly_ball(0), (Vec::new(), Vec::new()));
    }
}
