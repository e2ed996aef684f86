//! Numbers as bytes, little-endian.

/// Appends `values`, little-endian.
pub(crate) fn put_u32s(out: &mut Vec<u8>, values: &[u32]) {
    out.reserve(values.len() * 4);
    for value in values {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

/// Appends `values`, little-endian.
pub(crate) fn put_f32s(out: &mut Vec<u8>, values: &[f32]) {
    out.reserve(values.len() * 4);
    for value in values {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

/// Appends `values`, little-endian.
pub(crate) fn put_f64s(out: &mut Vec<u8>, values: &[f64]) {
    out.reserve(values.len() * 8);
    for value in values {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

/// Returns the bytes of numbers.
pub(crate) fn of_u32s(values: &[u32]) -> Vec<u8> {
    let mut out = Vec::new();
    put_u32s(&mut out, values);
    out
}

/// Returns the bytes of numbers.
pub(crate) fn of_f32s(values: &[f32]) -> Vec<u8> {
    let mut out = Vec::new();
    put_f32s(&mut out, values);
    out
}

/// Returns the numbers that are whole.
pub(crate) fn to_u32s(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks::<4>().0.iter().map(|&v| u32::from_le_bytes(v)).collect()
}

/// Returns the numbers that are whole.
pub(crate) fn to_f32s(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|&v| f32::from_le_bytes(v)).collect()
}
