//! Findings of some cells, as a value and as the bytes of a file.

use glam::DVec3;

use super::lines::{Found, Line};
use cullet_io::baked::hash;

/// Findings of some cells of a round of a [`Bake`](super::Bake): a pure function of graph,
/// settings, round and cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnitResult {
    /// Pairs of cells that are hidden from each other.
    pub(super) hidden: Vec<[u32; 2]>,
    /// Openings through which less is seen than was thought, and what is not, a row each.
    pub(super) closed: Vec<u32>,
    pub(super) closed_rows: Vec<u64>,
    pub(super) found: Found,
}

/// The first bytes of a file of a unit.
const MAGIC: &[u8; 8] = b"PVSUNIT1";

impl UnitResult {
    /// Adds what a cell's work found.
    pub(super) fn append(&mut self, other: Self) {
        self.hidden.extend(other.hidden);
        self.closed.extend(other.closed);
        self.closed_rows.extend(other.closed_rows);
        self.found.append(&other.found);
    }

    /// The bytes of its file: little-endian, with a checksum at the end.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let found = &self.found;
        let mut out = MAGIC.to_vec();
        let counts = [
            self.hidden.len(),
            self.closed.len(),
            self.closed_rows.len(),
            found.lines.len(),
            found.cells.len(),
        ];
        counts.iter().for_each(|&n| out.extend((n as u64).to_le_bytes()));
        self.hidden.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
        self.closed.iter().for_each(|v| out.extend(v.to_le_bytes()));
        self.closed_rows.iter().for_each(|v| out.extend(v.to_le_bytes()));
        for line in &found.lines {
            out.extend(line.opening.to_le_bytes());
            for v in [line.point, line.direction].map(|v| v.to_array()).as_flattened() {
                out.extend(v.to_le_bytes());
            }
        }
        found.cells.iter().chain(&found.ends).for_each(|v| out.extend(v.to_le_bytes()));
        out.extend(hash(&out).to_le_bytes());
        out
    }

    /// Reads such bytes; `None` where they are not whole, or name what a graph of so many openings
    /// and cells, with rows of `width` words, does not have.
    pub(super) fn from_bytes(
        bytes: &[u8],
        openings: u32,
        cells: u32,
        width: usize,
    ) -> Option<Self> {
        let (body, sum) = bytes.split_last_chunk::<8>()?;
        if u64::from_le_bytes(*sum) != hash(body) {
            return None;
        }
        let mut rest = body.strip_prefix(MAGIC)?;
        let mut counts = [0_usize; 5];
        for count in &mut counts {
            *count = usize::try_from(u64::from_le_bytes(take(&mut rest)?)).ok()?;
        }
        let [hidden, closed, rows, lines, along] = counts;
        let sizes = [(hidden, 8), (closed, 4), (rows, 8), (lines, 4 + 48 + 4), (along, 4)];
        let need =
            sizes.iter().try_fold(0_usize, |sum, &(n, size)| sum.checked_add(n.checked_mul(size)?));
        if need? != rest.len() || rows != closed.checked_mul(width)? {
            return None;
        }
        let mut int = || take(&mut rest).map(u32::from_le_bytes);
        let mut made = Self::default();
        for _ in 0..hidden {
            made.hidden.push([int()?, int()?]);
        }
        for _ in 0..closed {
            made.closed.push(int()?);
        }
        for _ in 0..rows {
            made.closed_rows.push(u64::from_le_bytes(take(&mut rest)?));
        }
        for _ in 0..lines {
            let opening = u32::from_le_bytes(take(&mut rest)?);
            let mut v = [0.0; 6];
            for v in &mut v {
                *v = f64::from_le_bytes(take(&mut rest)?);
            }
            let [point, direction] = [DVec3::from_slice(&v), DVec3::from_slice(&v[3..])];
            made.found.lines.push(Line { opening, point, direction });
        }
        let mut int = || take(&mut rest).map(u32::from_le_bytes);
        for _ in 0..along {
            made.found.cells.push(int()?);
        }
        for _ in 0..lines {
            made.found.ends.push(int()?);
        }
        let found = &made.found;
        let sound = made.hidden.iter().flatten().chain(&found.cells).all(|&c| c < cells)
            && made.closed.iter().all(|&o| o < openings)
            && found.lines.iter().all(|l| l.opening < openings)
            && found.ends.is_sorted()
            && found.ends.last().is_none_or(|&end| end as usize == found.cells.len());
        sound.then_some(made)
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk::<N>()?;
    *rest = after;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result() -> UnitResult {
        let mut found = Found::default();
        let line = Line { opening: 3, point: DVec3::new(0.1, 2.0, -3.0), direction: DVec3::Y };
        found.push(line, &[1, 2, 5]);
        found.push(line, &[]);
        UnitResult { hidden: vec![[0, 5]], closed: vec![2, 3], closed_rows: vec![7, 9], found }
    }

    #[test]
    fn a_unit_comes_back_from_its_bytes() {
        let bytes = result().to_bytes();
        assert_eq!(UnitResult::from_bytes(&bytes, 4, 6, 1), Some(result()));
    }

    #[test]
    fn a_damaged_or_foreign_unit_is_none() {
        let bytes = result().to_bytes();
        for at in 0..bytes.len() {
            assert_eq!(UnitResult::from_bytes(&bytes[..at], 4, 6, 1), None, "cut at {at}");
            let mut odd = bytes.clone();
            odd[at] ^= 4;
            assert_eq!(UnitResult::from_bytes(&odd, 4, 6, 1), None, "odd at {at}");
        }
        for (openings, cells, width) in [(3, 6, 1), (4, 5, 1), (4, 6, 2)] {
            assert_eq!(UnitResult::from_bytes(&bytes, openings, cells, width), None);
        }
    }
}
