//! Decoding of `EXT_meshopt_compression`, after the bitstream appendix of its specification
//! (Arseny Kapoulkine and Jasper St. Pierre, Khronos, 2020).
//!
//! Written here rather than bound to the C++ library: a loader of unknown files is the last place
//! for memory errors, and the program builds without a C++ compiler.

mod attributes;
mod filters;
mod indices;

#[cfg(test)]
mod tests;

use crate::bytes::of_u32s;

/// The most that a byte can grow to: in a block of 256 elements, one byte of header stands for 64
/// deltas of zero.
pub(super) const MOST_EXPANSION: usize = 64;

/// Kind of data that the bytes encode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Elements of any size.
    Attributes,
    /// Indices of a triangle list.
    Triangles,
    /// Indices of anything.
    Indices,
}

/// Filter applied to attributes after decoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// Nothing.
    None,
    /// Unit vectors from an octahedron.
    Octahedral,
    /// Unit quaternions from three components.
    Quaternion,
    /// Floats from exponent and mantissa.
    Exponential,
}

/// Checks the layout, and that `encoded` bytes can hold so many elements: before anything is
/// allocated for them.
///
/// # Errors
/// Names the defect and the limit.
pub(super) fn check(
    mode: Mode,
    filter: Filter,
    count: usize,
    stride: usize,
    encoded: usize,
) -> Result<(), String> {
    let stride_ok = match (mode, filter) {
        (Mode::Attributes, Filter::None | Filter::Exponential) => {
            stride.is_multiple_of(4) && (4..=256).contains(&stride)
        }
        (Mode::Attributes, Filter::Octahedral) => stride == 4 || stride == 8,
        (Mode::Attributes, Filter::Quaternion) => stride == 8,
        (_, Filter::None) => stride == 2 || stride == 4,
        _ => return Err(format!("mode {mode:?} goes with no filter, not {filter:?}")),
    };
    if !stride_ok {
        return Err(format!(
            "a byteStride of {stride} does not fit {mode:?} and filter {filter:?}"
        ));
    }
    if mode == Mode::Triangles && !count.is_multiple_of(3) {
        return Err(format!("{count} indices do not make whole triangles"));
    }
    let least = match mode {
        Mode::Attributes => {
            count.saturating_mul(stride).div_ceil(MOST_EXPANSION) + 1 + attributes::tail(stride)
        }
        Mode::Triangles => count / 3 + 1 + indices::TRIANGLES_TAIL,
        Mode::Indices => count + 1 + indices::SEQUENCE_TAIL,
    };
    if encoded < least {
        return Err(format!(
            "{count} elements of {stride} bytes need {least} compressed bytes or more, but there are {encoded}"
        ));
    }
    Ok(())
}

/// Decompresses `count` elements of `stride` bytes, whose layout [`check`] has passed.
///
/// # Errors
/// If the bytes end early, go on too long or are of another kind.
pub(super) fn decode(
    bytes: &[u8],
    mode: Mode,
    filter: Filter,
    count: usize,
    stride: usize,
) -> Result<Vec<u8>, String> {
    check(mode, filter, count, stride, bytes.len())?;
    match mode {
        Mode::Attributes => {
            let mut out = attributes::decode(bytes, count, stride)?;
            match filter {
                Filter::None => {}
                Filter::Octahedral => filters::octahedral(&mut out, stride),
                Filter::Quaternion => filters::quaternion(&mut out),
                Filter::Exponential => filters::exponential(&mut out),
            }
            Ok(out)
        }
        Mode::Triangles => indices::triangles(bytes, count).map(|v| narrow(&v, stride)),
        Mode::Indices => indices::sequence(bytes, count).map(|v| narrow(&v, stride)),
    }
}

/// Indices as bytes, two or four each.
fn narrow(indices: &[u32], stride: usize) -> Vec<u8> {
    if stride == 4 {
        return of_u32s(indices);
    }
    let mut out = Vec::with_capacity(indices.len() * 2);
    indices.iter().for_each(|&i| out.extend_from_slice(&(i as u16).to_le_bytes()));
    out
}

/// Reads bytes from the front.
struct ByteReader<'a> {
    rest: &'a [u8],
}

impl<'a> ByteReader<'a> {
    /// The stream after its header byte and before its tail, and the tail.
    fn open(bytes: &'a [u8], header: u8, tail: usize) -> Result<(Self, &'a [u8]), String> {
        match bytes.split_first() {
            Some((&h, _)) if h != header => {
                Err(format!("the stream starts with {h:#04x}, expected {header:#04x}"))
            }
            Some((_, rest)) if rest.len() >= tail => {
                let (rest, tail) = rest.split_at(rest.len() - tail);
                Ok((Self { rest }, tail))
            }
            _ => Err(format!("the stream has {} bytes, too few for its ends", bytes.len())),
        }
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(n).ok_or("the stream ends early")?;
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|b| b[0])
    }

    /// An unsigned LEB128 of at most 32 bits.
    fn varint(&mut self) -> Result<u32, String> {
        let mut value = 0u32;
        for shift in (0..35).step_by(7) {
            let b = self.byte()?;
            value |= u32::from(b & 0x7F) << shift;
            if b < 0x80 {
                return Ok(value);
            }
        }
        Err("an index has more than 32 bits".into())
    }

    fn finish(self) -> Result<(), String> {
        match self.rest.len() {
            0 => Ok(()),
            n => Err(format!("the stream has {n} bytes too many")),
        }
    }
}
