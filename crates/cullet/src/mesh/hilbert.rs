//! The Hilbert curve: an order of cells in which neighbours in the order are neighbours in space.

const BITS: u32 = 16;
/// Cells along each axis.
pub(super) const CELLS: u32 = 1 << BITS;

/// The number of a cell along the curve; its coordinates are below [`CELLS`].
///
/// Skilling, *Programming the Hilbert Curve*, 2004: from axes to the transposed index.
pub(super) fn index(mut x: [u32; 3]) -> u64 {
    let mut bit = CELLS >> 1;
    while bit > 1 {
        let below = bit - 1;
        for i in 0..3 {
            // Where the bit is set turn the axis around, else exchange it with the first. As masks:
            // the bits are as good as random, so branches on them would miss half the time.
            let set = 0u32.wrapping_sub(u32::from(x[i] & bit != 0));
            let swap = (x[0] ^ x[i]) & below & !set;
            x[0] ^= swap | (below & set);
            x[i] ^= swap;
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flip = 0;
    let mut bit = CELLS >> 1;
    while bit > 1 {
        flip ^= (bit - 1) & 0u32.wrapping_sub(u32::from(x[2] & bit != 0));
        bit >>= 1;
    }
    let [x, y, z] = x.map(|v| spread(v ^ flip));
    x << 2 | y << 1 | z
}

/// The bits of a 16-bit number, three apart.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    v = (v | v << 16) & 0x0000_00FF_0000_00FF;
    v = (v | v << 8) & 0x0000_F00F_0000_F00F;
    v = (v | v << 4) & 0x000C_30C3_000C_30C3;
    (v | v << 2) & 0x0249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::index;

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        // The cells of a corner cube of 8³ come first, one step apart.
        let mut cells: Vec<(u64, [u32; 3])> = (0..512u32)
            .map(|i| [i & 7, i >> 3 & 7, i >> 6])
            .map(|cell| (index(cell), cell))
            .collect();
        cells.sort_unstable();
        assert!(cells.iter().map(|c| c.0).eq(0..512));
        for pair in cells.windows(2) {
            let step: u32 = (0..3).map(|a| pair[0].1[a].abs_diff(pair[1].1[a])).sum();
            assert_eq!(step, 1, "{pair:?}");
        }
    }
}
