//! The model whose triangles and clusters are tested.

/// Three radii from the middle, where the methods are compared.
pub(super) const EYE: [f64; 4] = [1.8, -0.9, 2.226, 1.0];
