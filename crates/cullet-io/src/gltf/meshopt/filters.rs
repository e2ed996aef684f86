//! Filters of decoded attributes: each turns an element into one of the same size.

use std::f32::consts::FRAC_1_SQRT_2;

/// Unit vectors of four components of one (`stride` 4) or two bytes (8); the fourth is passed
/// through.
pub(super) fn octahedral(data: &mut [u8], stride: usize) {
    for e in data.chunks_exact_mut(stride) {
        if stride == 4 {
            let v = [e[0], e[1], e[2]].map(|b| f32::from(b as i8));
            for (e, v) in e.iter_mut().zip(unfold(v)) {
                *e = (v * 127.0).round() as i8 as u8;
            }
        } else {
            let v = unfold([0, 2, 4].map(|i| f32::from(i16_at(e, i))));
            for (i, v) in v.into_iter().enumerate() {
                set_i16(e, i * 2, v * 32767.0);
            }
        }
    }
}

/// From the octahedron, in units of the third component, to the sphere.
fn unfold([x, y, one]: [f32; 3]) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let t = z.min(0.0);
    let (x, y) = (x - t.copysign(x), y - t.copysign(y));
    let len = (x * x + y * y + z * z).sqrt();
    [x / len, y / len, z / len]
}

/// Quaternions of four two-byte components: three and the scale with the index of the fourth.
pub(super) fn quaternion(data: &mut [u8]) {
    for e in data.chunks_exact_mut(8) {
        let last = i16_at(e, 6);
        let one = f32::from(last | 3);
        let [x, y, z] = [0, 2, 4].map(|i| f32::from(i16_at(e, i)) / one * FRAC_1_SQRT_2);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let largest = usize::from((last & 3).unsigned_abs());
        for (i, v) in [w, x, y, z].into_iter().enumerate() {
            set_i16(e, (largest + i) % 4 * 2, v * 32767.0);
        }
    }
}

/// Floats of an exponent in the high byte and a mantissa in the low three, both signed.
pub(super) fn exponential(data: &mut [u8]) {
    for e in data.chunks_exact_mut(4) {
        let v = i32::from_le_bytes([e[0], e[1], e[2], e[3]]);
        let (exponent, mantissa) = (v >> 24, v << 8 >> 8);
        let value = (2f64.powi(exponent) * f64::from(mantissa)) as f32;
        e.copy_from_slice(&value.to_le_bytes());
    }
}

fn i16_at(e: &[u8], at: usize) -> i16 {
    i16::from_le_bytes([e[at], e[at + 1]])
}

fn set_i16(e: &mut [u8], at: usize, value: f32) {
    e[at..at + 2].copy_from_slice(&(value.round() as i16).to_le_bytes());
}
