//! Portals as an eye sees them: polygons relative to it, whose edges know which plane they lie on.

use alloc::vec::Vec;

use glam::DVec3;

/// Share of the size of a polygon by which planes are moved out when it is cut: far more than
/// rounding.
pub(super) const SLACK: f64 = 1e-9;
/// An edge whose ends the eye sees nearer together than this, in radians, makes no plane: it would
/// be off by more than [`SLACK`].
const LEAST_ANGLE: f64 = 1e-6;

/// A corner, and the plane that the edge to the next one lies on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) p: DVec3,
    pub(super) plane: u32,
}

/// Cuts a polygon by n·x ≤ d; the new edge lies on plane `label`. Returns whether something is
/// left.
pub(super) fn cut(
    polygon: &mut Vec<Corner>,
    (n, d): (DVec3, f64),
    label: u32,
    cut: &mut Vec<Corner>,
) -> bool {
    let height = |corner: &Corner| n.dot(corner.p) - d;
    if polygon.iter().all(|corner| height(corner) <= 0.0) {
        return true;
    }
    cut.clear();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (ha, hb) = (height(a), height(b));
        let crossing = || a.p + (b.p - a.p) * (ha / (ha - hb));
        if ha <= 0.0 {
            cut.push(*a);
            if hb > 0.0 {
                cut.push(Corner { p: crossing(), plane: label });
            }
        } else if hb <= 0.0 {
            cut.push(Corner { p: crossing(), plane: a.plane });
        }
    }
    core::mem::swap(polygon, cut);
    polygon.len() >= 3
}

/// The plane through the eye and the edge from `a` to `b`, of unit length and pointing out of a
/// polygon that the eye sees counter-clockwise; `None` where it would be off by too much.
pub(super) fn side(a: DVec3, b: DVec3) -> Option<DVec3> {
    let normal = a.cross(b);
    let length = normal.length();
    (length > a.length() * b.length() * LEAST_ANGLE).then(|| normal / length)
}

/// The planes of the rectangle of the screen around a polygon, left, right, bottom and top,
/// pointing out; `None` where it reaches beside or behind the eye. `rows` are x, y and w of clip
/// space.
pub(super) fn rectangle(polygon: &[Corner], rows: &[DVec3; 3]) -> Option<[DVec3; 4]> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in polygon {
        let [x, y, w] = rows.map(|row| row.dot(corner.p));
        // Of the size of what it is a sum of, or it is rounding.
        if w <= rows[2].abs().dot(corner.p.abs()) * LEAST_ANGLE {
            return None;
        }
        for (a, v) in [x / w, y / w].into_iter().enumerate() {
            min[a] = min[a].min(v);
            max[a] = max[a].max(v);
        }
    }
    let [x, y, w] = *rows;
    let out = |v: f64| v.abs().max(1.0) * SLACK;
    Some([
        w * (min[0] - out(min[0])) - x,
        x - w * (max[0] + out(max[0])),
        w * (min[1] - out(min[1])) - y,
        y - w * (max[1] + out(max[1])),
    ])
    .map(|planes| planes.map(DVec3::normalize))
}
