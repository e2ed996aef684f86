//! How far an eye may move before the test of a cone can change: a value of the bound that changes
//! no faster than the eye moves, less what rounding may hide.

use glam::DVec3;

/// The margin of a cone through an apex: `value` changes by at most `steepness` a unit, is positive
/// behind and negative elsewhere, and is off by at most a few roundings of `size` times the way to
/// the apex and the apex itself.
pub(super) fn margin(value: f64, steepness: f64, size: f64, way: f64, apex: DVec3) -> f64 {
    // The eye may go as far as twice its way; f32 rounds by 6e-8, the test 7 of it, and the squares
    // of less than 1e-18 nothing.
    let error = size * (3e-6 * way + 5e-7 * apex.length()) + 4e-18;
    ((value.abs() - error) / steepness).max(0.0)
}

pub(super) fn elliptic_margin(apex: [f32; 3], vectors: [[f32; 3]; 3], eye: [f64; 3]) -> f64 {
    let [axis, s, t] = vectors.map(|v| DVec3::from(v.map(f64::from)));
    let apex = DVec3::from(apex.map(f64::from));
    let w = DVec3::from(eye) - apex;
    // The least of −g·w over the normals g = axis + β s + γ t of the cone, which is as steep as the
    // longest of them.
    let value = -axis.dot(w) - s.dot(w).hypot(t.dot(w));
    let widest = s.length_squared() + t.length_squared();
    let across = s.length_squared() - t.length_squared();
    let widest = 0.5 * (widest + across.hypot(2.0 * s.dot(t)));
    let skew = axis.dot(s).hypot(axis.dot(t));
    let steepness = (axis.length_squared() + 2.0 * skew + widest).sqrt() * (1.0 + 1e-12);
    margin(value, steepness, axis.length() + s.length() + t.length(), w.length(), apex)
}
