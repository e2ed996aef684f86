//! Shapes and directions that benches, calibration, figures and lectures share.

/// Direction `i` of `count` of a Fibonacci lattice: spread evenly over all directions.
#[must_use]
pub fn fibonacci(i: usize, count: usize) -> [f64; 3] {
    // The golden angle.
    const TURN: f64 = 2.399_963_229_728_653;
    let z = (2 * i + 1) as f64 / count as f64 - 1.0;
    let (sin, cos) = (i as f64 * TURN).sin_cos();
    let r = (1.0 - z * z).sqrt();
    [r * cos, r * sin, z]
}

/// A ball with waves on it, of `len` triangles, within the unit sphere; in strips of 32 quads, so
/// that runs of 64 triangles are clusters.
#[must_use]
pub fn bumpy_ball(len: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    const STRIP: usize = 32;
    let strips = len.div_ceil(2 * STRIP);
    // Blocks of 4 rows by 8 columns in a grid twice as wide as high.
    let high = ((strips as f64).sqrt().ceil() as usize).max(1);
    let wide = strips.div_ceil(high);
    let (rows, columns) = (high * 4, wide * 8);
    let mut positions = Vec::with_capacity((rows + 1) * (columns + 1));
    for row in 0..=rows {
        let (ring, y) = (row as f64 / rows as f64 * std::f64::consts::PI).sin_cos();
        for column in 0..=columns {
            let (z, x) = (column as f64 / columns as f64 * std::f64::consts::TAU).sin_cos();
            let (x, z) = (x * ring, z * ring);
            let r = 0.9 + 0.03 * ((9.0 * x).sin() + (7.0 * y).sin() + (8.0 * z).sin());
            positions.push([x * r, y * r, z * r].map(|v| v as f32));
        }
    }
    let mut indices = Vec::with_capacity(strips * STRIP * 6);
    for strip in 0..strips {
        let (top, left) = (strip / wide * 4, strip % wide * 8);
        for quad in 0..STRIP {
            let (row, column) = (top + quad / 8, left + quad % 8);
            let at = |r: usize, c: usize| ((row + r) * (columns + 1) + column + c) as u32;
            let [a, b, c, d] = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
            indices.extend([a, b, d, a, d, c]);
        }
    }
    indices.truncate(len * 3);
    (positions, indices)
}
