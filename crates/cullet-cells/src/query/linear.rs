//! Linear part of a transform, in f64.

use cullet::Transform;
use glam::DMat3;

/// Returns the linear part of `transform`; nothing is rounded.
pub(super) fn linear(transform: &Transform) -> DMat3 {
    DMat3::from_cols_array_2d(&transform.linear.map(|column| column.map(f64::from)))
}
