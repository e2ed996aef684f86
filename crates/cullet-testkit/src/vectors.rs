//! Vectors in plain f64.

/// The scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Direction `i` of `count` of a Fibonacci lattice, which covers the sphere evenly.
pub fn fibonacci(i: usize, count: usize) -> [f64; 3] {
    let z = (2 * i + 1) as f64 / count as f64 - 1.0;
    let angle = i as f64 * 2.399_963_229_728_653;
    let r = (1.0 - z * z).sqrt();
    [r * angle.cos(), r * angle.sin(), z]
}

/// A column-major matrix times a column.
pub fn multiply(m: &[f64; 16], v: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|r| (0..4).map(|c| m[c * 4 + r] * v[c]).sum())
}

/// n·e − d·w in f64, positive in front, and the size of its terms.
pub fn front(corners: [[f32; 3]; 3], eye: [f64; 4]) -> (f64, f64) {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let n = cross(std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    let e: [f64; 3] = std::array::from_fn(|k| eye[k] - a[k] * eye[3]);
    let terms = [n[0] * e[0], n[1] * e[1], n[2] * e[2]];
    (terms.iter().sum(), terms.iter().map(|t| t.abs()).sum())
}
