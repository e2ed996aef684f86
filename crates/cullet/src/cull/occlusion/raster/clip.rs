//! Clipping of polygons by the near plane.

use alloc::vec::Vec;

use super::screen::Clip;

/// Clips a polygon by the near plane.
pub(crate) fn clip_near(polygon: &mut Vec<Clip>, other: &mut Vec<Clip>) {
    clip(polygon, other);
    // Only a view whose near plane goes through its eye leaves such a corner.
    if polygon.iter().any(|c| c.w <= 0.0) {
        polygon.clear();
    }
}

/// Clips a polygon: what is not before the near plane stays.
fn clip(polygon: &mut Vec<Clip>, other: &mut Vec<Clip>) {
    if polygon.iter().all(|c| c.height() >= 0.0) {
        return;
    }
    other.clear();
    for (k, corner) in polygon.iter().enumerate() {
        let before = &polygon[(k + polygon.len() - 1) % polygon.len()];
        match (before.height() >= 0.0, corner.height() >= 0.0) {
            (true, false) => other.push(before.meet_near(corner)),
            (false, true) => other.extend([corner.meet_near(before), *corner]),
            (true, true) => other.push(*corner),
            (false, false) => {}
        }
    }
    core::mem::swap(polygon, other);
}
