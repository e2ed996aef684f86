//! The error of a group: how far sample points of the original are from what was made of them, and
//! how far points of that are from the original.

use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::inner_points;

use super::collapse::Points;
use crate::corners::turned;

/// Surface that a cluster stands for.
#[derive(Clone, Debug)]
pub(super) enum Carried {
    /// Its own triangles, from this one of the part on.
    Original(u32),
    Points(Points),
}

/// Input of a measurement of points of a simplified surface.
pub(super) struct Back<'a> {
    /// Positions that both index lists refer to.
    pub(super) positions: &'a [[f32; 3]],
    /// The triangles before and after.
    pub(super) before: &'a [u32],
    pub(super) after: &'a [u32],
    /// The original surface.
    pub(super) original: &'a SurfaceTree,
    /// Points on each triangle.
    pub(super) points: u32,
    pub(super) seed: u64,
}

/// A triangle with a point that is farther off than this share of the error so far is looked at
/// more closely.
const WARM: f32 = 0.6;

/// How far it is looked towards other points of the triangle, first far, then near.
const STEPS: [f32; 10] = [0.6, 0.5, 0.4, 0.4, 0.3, 0.3, 0.2, 0.2, 0.1, 0.1];

/// Returns the largest distance of points of the triangles after from the original, where it is
/// larger than an error that is known. Triangles that were there before were measured then.
pub(super) fn back(task: &Back<'_>, mut error: f32) -> f32 {
    let mut kept: Vec<[u32; 3]> = task.before.as_chunks().0.iter().map(|t| turned(*t)).collect();
    kept.sort_unstable();
    for (t, corners) in (0..).zip(task.after.as_chunks::<3>().0) {
        if kept.binary_search(&turned(*corners)).is_err() {
            error = farthest(task, t, corners.map(|v| task.positions[v as usize]), error);
        }
    }
    error
}

/// Measures points of one of the triangles after. Where one is nearly as far off as the farthest of
/// the group, goes on from it to where the triangle is farther off.
fn farthest(task: &Back<'_>, triangle: u32, corners: [[f32; 3]; 3], mut error: f32) -> f32 {
    let mut points = inner_points(corners, task.seed, triangle, task.points + STEPS.len() as u32);
    let mut last = u32::MAX;
    let mut off = |p: [f32; 3], near: f32| task.original.farther(p, near, &mut last).unwrap_or(0.0);
    let mut best = (0.0, [0.0; 3]);
    for p in points.by_ref().take(task.points as usize) {
        let distance = off(p, (error * WARM).max(best.0));
        if distance > best.0 {
            best = (distance, p);
        }
        error = error.max(distance);
    }
    // Nothing was that far off.
    if best.0 <= 0.0 {
        return error;
    }
    for (q, step) in points.zip(STEPS) {
        // Between the two, so within the triangle.
        let p = std::array::from_fn(|a| best.1[a] + (q[a] - best.1[a]) * step);
        let distance = off(p, best.0);
        if distance > best.0 {
            best = (distance, p);
        }
    }
    error.max(best.0)
}
