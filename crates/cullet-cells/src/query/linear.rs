//! Linear part of a transform, and lengths, in f64.

use cullet::Transform;
#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use glam::{DMat3, DVec3};

/// Returns the linear part of `transform`; nothing is rounded.
pub(super) fn linear(transform: &Transform) -> DMat3 {
    DMat3::from_cols_array_2d(&transform.linear.map(|column| column.map(f64::from)))
}

/// Returns the length of `v`, to the bit that of glam, whose square root took a third of the time of queries on
/// the web without the standard library.
pub(super) fn length(v: DVec3) -> f64 {
    v.length_squared().sqrt()
}
