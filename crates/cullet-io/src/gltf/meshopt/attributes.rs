//! Mode 0: elements as byte-wise deltas, in groups of 16.

use super::ByteReader;

const HEADER: u8 = 0xA0;
/// The header of version 1.
const NEWER: u8 = 0xA1;
const GROUP: usize = 16;
const MOST_BLOCK_BYTES: usize = 8192;
const MOST_BLOCK_ELEMENTS: usize = 256;

/// The size of the tail: the baseline element, padded in front to 32 bytes.
pub(super) fn tail(stride: usize) -> usize {
    stride.max(32)
}

/// Decodes `count` elements of `stride` bytes.
pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    if bytes.first() == Some(&NEWER) {
        return Err(
            "its stream has the newer form that only KHR_meshopt_compression has, and that \
                    is not read; `gltfpack -ce ext` writes the older one"
                .into(),
        );
    }
    let (mut reader, tail) = ByteReader::open(bytes, HEADER, tail(stride))?;
    let mut last = tail[tail.len() - stride..].to_vec();
    let mut out = vec![0u8; count * stride];
    let most = ((MOST_BLOCK_BYTES / stride) & !(GROUP - 1)).min(MOST_BLOCK_ELEMENTS);
    for block in out.chunks_mut(most * stride) {
        let elements = block.len() / stride;
        for (k, last) in last.iter_mut().enumerate() {
            channel(&mut reader, block, elements, k, stride, last)?;
        }
    }
    reader.finish()?;
    Ok(out)
}

/// Byte `k` of every element of a block.
fn channel(
    reader: &mut ByteReader<'_>,
    block: &mut [u8],
    elements: usize,
    k: usize,
    stride: usize,
    last: &mut u8,
) -> Result<(), String> {
    let groups = elements.div_ceil(GROUP);
    let header = reader.take(groups.div_ceil(4))?;
    for g in 0..groups {
        let deltas = match header[g / 4] >> (g % 4 * 2) & 3 {
            0 => [0; GROUP],
            1 => packed(reader, 2)?,
            2 => packed(reader, 4)?,
            _ => {
                let mut raw = [0; GROUP];
                raw.copy_from_slice(reader.take(GROUP)?);
                raw
            }
        };
        let first = g * GROUP;
        for (i, &delta) in deltas.iter().enumerate().take(elements - first) {
            // Zigzag: the lowest bit is the sign.
            *last = last.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
            block[(first + i) * stride + k] = *last;
        }
    }
    Ok(())
}

/// A group of `bits` a delta, highest first; all ones stand for a whole byte that follows.
fn packed(reader: &mut ByteReader<'_>, bits: usize) -> Result<[u8; GROUP], String> {
    let codes = reader.take(GROUP * bits / 8)?;
    let sentinel = (1u8 << bits) - 1;
    let mut out = [0; GROUP];
    for (i, out) in out.iter_mut().enumerate() {
        let bit = i * bits;
        let code = codes[bit / 8] >> (8 - bits - bit % 8) & sentinel;
        *out = if code == sentinel { reader.byte()? } else { code };
    }
    Ok(out)
}
