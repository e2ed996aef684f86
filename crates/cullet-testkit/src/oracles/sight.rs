//! Triangles between two points, one after the other.

use cullet::mesh::Alpha;
use cullet::{Scene, Transform};
use cullet_cells::query::{BlockingSides, SightOptions};

use crate::vectors::{cross, dot};

/// A triangle that a segment crosses, or may cross.
#[derive(Clone, Copy, Debug)]
pub struct SightHit {
    /// The slot of its instance.
    pub slot: u32,
    /// Its original number.
    pub triangle: u32,
    /// Where on the way; NaN where that is not known.
    pub share: f64,
    /// Whether it crosses it beyond doubt.
    pub sure: bool,
}

/// All triangles that block a segment, by brute force: every triangle of every instance by the textbook's test in f64
/// (Möller & Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997), those that are crossed by less than
/// rounding can tell among them as doubtful.
pub fn sight_ref(
    scene: &Scene,
    from: [f64; 3],
    to: [f64; 3],
    options: &SightOptions,
) -> Vec<SightHit> {
    let mut hits = Vec::new();
    for slot in scene.slots() {
        let (mesh, flags, transform) = (scene.mesh(slot), scene.flags(slot), scene.transform(slot));
        let is_ignored =
            options.ignored.iter().flatten().any(|&h| scene.slot(h).is_ok_and(|s| s == slot));
        if is_ignored
            || scene.layers(slot) & options.layers == 0
            || flags.transparent
            || !scene.is_rigid(slot)
            || transform.rank() < 3
            || !transform.is_finite()
        {
            continue;
        }
        let corners = mesh.original_indices();
        for part in mesh.parts().iter().filter(|p| p.alpha == Alpha::Opaque) {
            let both = part.two_sided || flags.double_sided || options.sides == BlockingSides::Both;
            for triangle in part.first_triangle..part.first_triangle + part.triangle_count {
                let corners: [[f64; 3]; 3] = std::array::from_fn(|k| {
                    let v = corners[triangle as usize * 3 + k];
                    place(transform, mesh.positions()[v as usize])
                });
                let mirrored = transform.determinant() < 0.0;
                if let Some((share, front, sure)) = crosses(from, to, corners)
                    && (!sure || both || front != mirrored)
                {
                    hits.push(SightHit { slot, triangle, share, sure });
                }
            }
        }
    }
    hits
}

/// The image of a point.
pub fn place(transform: &Transform, p: [f32; 3]) -> [f64; 3] {
    let [x, y, z] = p.map(f64::from);
    let [a, b, c] = transform.linear.map(|c| c.map(f64::from));
    std::array::from_fn(|i| a[i] * x + b[i] * y + c[i] * z + transform.translation[i])
}

/// Share, whether from the front, whether beyond doubt.
fn crosses(from: [f64; 3], to: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Option<(f64, bool, bool)> {
    let is_apart = |i: usize| {
        let (low, high) = (from[i].min(to[i]), from[i].max(to[i]));
        [a, b, c].iter().all(|p| p[i] < low) || [a, b, c].iter().all(|p| p[i] > high)
    };
    if (0..3).any(is_apart) {
        return None;
    }
    let minus = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] - q[i]) };
    let (way, u_edge, v_edge, away) = (minus(to, from), minus(b, a), minus(c, a), minus(from, a));
    let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let place_error = largest(&[from, to, a, b, c].concat()) * 4e-15;
    let size = largest(&[way, u_edge, v_edge, away].concat());
    let p = cross(way, v_edge);
    let det = dot(u_edge, p);
    // Edges are off by what their ends are, products of three by their own rounding.
    let error = 12.0 * size * size * (place_error + size * 1e-15);
    let doubt = error / det.abs();
    let is_known = doubt < 0.05;
    if !is_known {
        return Some((f64::NAN, false, false));
    }
    let q = cross(away, u_edge);
    let (u, v, t) = (dot(away, p) / det, dot(way, q) / det, dot(v_edge, q) / det);
    // The error of a quotient, whose parts are below one where it matters.
    let doubt = 4.0 * doubt;
    let within = [u, v, 1.0 - u - v, t, 1.0 - t];
    if within.iter().any(|&x| x < -doubt) {
        return None;
    }
    Some((t, det > 0.0, within.iter().all(|&x| x > doubt)))
}
