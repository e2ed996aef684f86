//! WebP's lossless stream (RFC 9649) of a picture in few colours.
//!
//! Its one transform is that of a palette, so that a pixel is one symbol; copies of what came
//! before take the rest. No library in Rust alone writes either: `image-webp` writes three symbols
//! a pixel and copies of the pixel before alone.

use super::bits::BitWriter;
use super::matches::{self, Token};
use super::prefix::PrefixCode;

/// Symbols of the first code: 256 indices, then lengths of copies.
const LENGTHS_FROM: usize = 256;
const GREENS: usize = LENGTHS_FROM + 24;
const DISTANCES: usize = 40;
/// Least number of colours: with fewer, several indices would share a byte, which saves nothing
/// once they are coded.
const LEAST_COLORS: usize = 17;
/// Distances up to this number are codes of places around a pixel.
const NEAR: usize = 120;

/// The stream of a picture as indices of a palette, row by row; index `palette.len()` is clear, of
/// which there may be some where `has_clear`.
pub(super) fn stream(
    indices: &[u8],
    [width, height]: [u32; 2],
    palette: &[[u8; 3]],
    has_clear: bool,
) -> Vec<u8> {
    let mut out = BitWriter::default();
    out.put(0x2F, 8);
    out.put(width - 1, 14);
    out.put(height - 1, 14);
    out.put(u32::from(has_clear), 1);
    out.put(0, 3);
    // A transform: of colour indices, by a table.
    out.put(0b111, 3);
    let table = table(palette, has_clear);
    out.put(table.len() as u32 - 1, 8);
    write_table(&table, &mut out);
    // No other transform; no cache of colours, and one set of codes for all of the picture.
    out.put(0, 1);
    out.put(0, 1);
    out.put(0, 1);
    write_indices(indices, width as usize, &mut out);
    out.finish()
}

/// Red, green, blue and alpha of each index, and as many more as it takes.
fn table(palette: &[[u8; 3]], has_clear: bool) -> Vec<[u8; 4]> {
    let mut table: Vec<[u8; 4]> = palette.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
    if has_clear {
        table.push([0; 4]);
    }
    while table.len() < LEAST_COLORS {
        table.push([0, 0, 0, 255]);
    }
    table
}

/// A picture of one row, in which each colour is less the one before.
fn write_table(table: &[[u8; 4]], out: &mut BitWriter) {
    let before = [[0; 4]].into_iter().chain(table.iter().copied());
    let steps: Vec<[u8; 4]> = (table.iter().zip(before))
        .map(|(color, before)| std::array::from_fn(|k| color[k].wrapping_sub(before[k])))
        .collect();
    out.put(0, 1);
    // Green has the lengths too.
    let code = |channel: usize, symbols: usize| {
        let mut counts = vec![0; symbols];
        steps.iter().for_each(|step| counts[usize::from(step[channel])] += 1);
        PrefixCode::new(&counts)
    };
    let codes = [code(1, GREENS), code(0, 256), code(2, 256), code(3, 256)];
    codes.iter().for_each(|code| code.write(out));
    PrefixCode::new(&[0; DISTANCES]).write(out);
    for step in &steps {
        for (code, channel) in codes.iter().zip([1, 0, 2, 3]) {
            code.put(usize::from(step[channel]), out);
        }
    }
}

/// The indices are the green of a picture without other channels.
fn write_indices(indices: &[u8], width: usize, out: &mut BitWriter) {
    let tokens = matches::split(indices, width);
    let (mut greens, mut distances) = (vec![0; GREENS], vec![0; DISTANCES]);
    for token in &tokens {
        match *token {
            Token::Literal(index) => greens[usize::from(index)] += 1,
            Token::Copy { length, distance } => {
                greens[LENGTHS_FROM + Prefix::of(length).symbol] += 1;
                distances[Prefix::of(code_of(distance, width)).symbol] += 1;
            }
        }
    }
    let (greens, distances) = (PrefixCode::new(&greens), PrefixCode::new(&distances));
    let none = PrefixCode::new(&[0; 256]);
    greens.write(out);
    [&none, &none, &none].iter().for_each(|code| code.write(out));
    distances.write(out);
    for token in &tokens {
        match *token {
            Token::Literal(index) => greens.put(usize::from(index), out),
            Token::Copy { length, distance } => {
                let length = Prefix::of(length);
                greens.put(LENGTHS_FROM + length.symbol, out);
                out.put(length.extra, length.bits);
                let distance = Prefix::of(code_of(distance, width));
                distances.put(distance.symbol, out);
                out.put(distance.extra, distance.bits);
            }
        }
    }
}

/// The number by which a distance is written: the four nearest places around a pixel have the first
/// ones.
fn code_of(distance: usize, width: usize) -> usize {
    let around = [width, 1, width + 1, width.wrapping_sub(1)];
    match around.iter().position(|&place| place == distance) {
        Some(place) => place + 1,
        None => distance + NEAR,
    }
}

/// A number from 1 on as a symbol and the bits that follow it.
struct Prefix {
    symbol: usize,
    extra: u32,
    bits: u32,
}

impl Prefix {
    fn of(number: usize) -> Self {
        let value = number as u32 - 1;
        if value < 4 {
            return Self { symbol: value as usize, extra: 0, bits: 0 };
        }
        let highest = value.ilog2();
        let bits = highest - 1;
        let symbol = 2 * highest + (value >> bits & 1);
        Self { symbol: symbol as usize, extra: value & ((1 << bits) - 1), bits }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_from_their_prefixes() {
        for number in (1..5000).chain([1 << 19, (1 << 20) - 1]) {
            let Prefix { symbol, extra, bits } = Prefix::of(number);
            // As a decoder reads it.
            let back = if symbol < 4 {
                symbol + 1
            } else {
                ((2 + (symbol & 1)) << ((symbol - 2) >> 1)) + extra as usize + 1
            };
            assert_eq!(back, number);
            assert!(symbol < DISTANCES && (bits == 0 || extra >> bits == 0));
        }
    }
}
