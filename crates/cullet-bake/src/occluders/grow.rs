//! Blocks of cells pushed out to the surface, and rounded so that they stay within it.

use cullet::bounds::Aabb;
use glam::DVec3;

use super::voxels::touches;

/// Pushes each side of a box outward by up to `limit`, as far as no triangle of a shell is met.
///
/// The box is within what the shells seal, and no path that crosses none of their triangles leaves
/// that; so the larger box is within it too. Sides are pushed in turn, those first that have the
/// farthest to go in proportion to the box.
pub(super) fn push_out(
    low: DVec3,
    high: DVec3,
    limit: DVec3,
    margin: f64,
    triangles: &[[DVec3; 3]],
) -> [DVec3; 2] {
    let (mut low, mut high) = (low, high);
    let near: Vec<[DVec3; 3]> = triangles
        .iter()
        .filter(|t| touches(t, low - limit, high + limit, margin))
        .copied()
        .collect();
    for axis in 0..3 {
        for up in [true, false] {
            // The slab ahead of the side, its own cross-section widened so that no triangle slips
            // by.
            let (mut from, mut to) = (low - DVec3::splat(margin), high + DVec3::splat(margin));
            let sign = if up { 1.0 } else { -1.0 };
            let side = if up { high[axis] } else { low[axis] };
            if up {
                (from[axis], to[axis]) = (side, side + limit[axis]);
            } else {
                (from[axis], to[axis]) = (side - limit[axis], side);
            }
            let mut free = limit[axis];
            for t in &near {
                let ahead = nearest(t, from, to, axis, up).map(|at| (at - side) * sign);
                free = free.min(ahead.unwrap_or(free));
            }
            let free = (free - 2.0 * margin).max(0.0);
            if up {
                high[axis] += free;
            } else {
                low[axis] -= free;
            }
        }
    }
    [low, high]
}

/// The first place along an axis where a triangle is within a box; `None` if it is nowhere.
fn nearest(t: &[DVec3; 3], low: DVec3, high: DVec3, axis: usize, up: bool) -> Option<f64> {
    let min = t[0].min(t[1]).min(t[2]);
    let max = t[0].max(t[1]).max(t[2]);
    if min.cmpgt(high).any() || max.cmplt(low).any() {
        return None;
    }
    let mut polygon = t.to_vec();
    for a in 0..3 {
        polygon = cut(&polygon, |p| p[a] - low[a]);
        polygon = cut(&polygon, |p| high[a] - p[a]);
    }
    let along = polygon.iter().map(|p| p[axis]);
    if up { along.reduce(f64::min) } else { along.reduce(f64::max) }
}

/// The part of a convex polygon where a linear function is not negative.
pub(super) fn cut<P>(polygon: &[P], side: impl Fn(&P) -> f64) -> Vec<P>
where
    P: Copy
        + std::ops::Add<Output = P>
        + std::ops::Sub<Output = P>
        + std::ops::Mul<f64, Output = P>,
{
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (d, e) = (side(&p), side(&q));
        if d >= 0.0 {
            kept.push(p);
        }
        if (d < 0.0) != (e < 0.0) {
            kept.push(p + (q - p) * (d / (d - e)));
        }
    }
    kept
}

/// The largest box of f32 numbers within a box; `None` if it has no volume.
pub(super) fn rounded_in(low: DVec3, high: DVec3) -> Option<Aabb> {
    let up = |v: f64| if f64::from(v as f32) < v { (v as f32).next_up() } else { v as f32 };
    let down = |v: f64| if f64::from(v as f32) > v { (v as f32).next_down() } else { v as f32 };
    let b = Aabb { min: low.to_array().map(up), max: high.to_array().map(down) };
    (0..3).all(|a| b.min[a] < b.max[a]).then_some(b)
}
