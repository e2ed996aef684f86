//! The Hilbert curve: an order of cells in which neighbours in the order are neighbours in space.
//!
//! Hamilton & Rau-Chaplin, *Compact Hilbert Indices*, 2008: on each level the curve through the eight
//! octants is the Gray code, turned so that it enters at corner `e` and runs along axis `d`. The 24 pairs
//! of these are the states of a table; three bits of position choose a digit and the next state.

const BITS: u32 = 16;
/// Cells along each axis.
pub(super) const CELLS: u32 = 1 << BITS;

/// For each state (8 d + e) and octant: the digit, and above it the next state.
const TABLE: [u8; 24 * 8] = table();

/// The number of a cell along the curve; its coordinates are below [`CELLS`].
pub(super) fn index([x, y, z]: [u32; 3]) -> u64 {
    let octants = spread(x) | spread(y) << 1 | spread(z) << 2;
    let (mut state, mut index) = (0, 0);
    for level in (0..BITS).rev() {
        let octant = (octants >> (3 * level)) as usize & 7;
        let entry = TABLE[state << 3 | octant];
        index = index << 3 | u64::from(entry & 7);
        state = usize::from(entry >> 3);
    }
    index
}

const fn table() -> [u8; 24 * 8] {
    let mut table = [0; 24 * 8];
    let mut i = 0;
    while i < table.len() {
        let (d, e, octant) = (i as u32 >> 6, i as u32 >> 3 & 7, i as u32 & 7);
        // The octant as the untwisted curve has it, and its place in the Gray code.
        let gray = rotate_left(octant ^ e, 3 - (d + 1) % 3);
        let digit = gray ^ gray >> 1 ^ gray >> 2;
        // Where the curve enters that octant, and along which axis it leaves.
        let even = (digit.saturating_sub(1)) & !1;
        let enter = even ^ even >> 1;
        let ones = if digit & 1 == 1 { digit } else { digit.saturating_sub(1) }.trailing_ones();
        let next_e = e ^ rotate_left(enter, (d + 1) % 3);
        let next_d = (d + ones % 3 + 1) % 3;
        table[i] = ((next_d << 3 | next_e) << 3 | digit) as u8;
        i += 1;
    }
    table
}

/// Of three bits, by 0 to 3.
const fn rotate_left(v: u32, by: u32) -> u32 {
    (v << by | v >> (3 - by)) & 7
}

/// The bits of a 16-bit number, three apart.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    v = (v | v << 16) & 0xFF00_00FF;
    v = (v | v << 8) & 0x00F0_0F00_F00F;
    v = (v | v << 4) & 0x0C30_C30C_30C3;
    (v | v << 2) & 0x2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::index;

    /// Cells of any size, 16 to an axis of the corner that holds them.
    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        for shift in [0, 5, 12] {
            let mut cells: Vec<(u64, [u32; 3])> = (0..4096u32)
                .map(|i| [i & 15, i >> 4 & 15, i >> 8])
                .map(|cell| (index(cell.map(|v| v << shift)) >> (3 * shift), cell))
                .collect();
            cells.sort_unstable();
            assert!(cells.iter().map(|c| c.0).eq(0..4096));
            for pair in cells.windows(2) {
                let step: u32 = (0..3).map(|a| pair[0].1[a].abs_diff(pair[1].1[a])).sum();
                assert_eq!(step, 1, "{pair:?}");
            }
        }
    }
}
