//! Findings of units, as the bytes of a file.

use super::unit::{Discovery, Findings};
use cullet_io::baked::hash;

/// First bytes of such a file.
const MAGIC: &[u8; 8] = b"SAMPUNT1";
/// Bytes of what was seen, and of the looks of a cell.
const SEEN: usize = 4 + 4 + 12 + 6 + 4;
const LOOKS: usize = 8;

/// The bytes of a file: little-endian, with a sum at the end.
pub(super) fn write(units: &[Findings]) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    for unit in units {
        let counts = [unit.seen.len(), unit.looks.len(), unit.open.len()].map(|n| n as u64);
        [&counts[..], &[unit.rays]].concat().iter().for_each(|n| out.extend(n.to_le_bytes()));
        for (Discovery { cell, target, at, eye }, lines) in &unit.seen {
            [cell, target].iter().for_each(|n| out.extend(n.to_le_bytes()));
            at.iter().for_each(|v| out.extend(v.to_le_bytes()));
            eye.iter().for_each(|v| out.extend(v.to_le_bytes()));
            out.extend(lines.to_le_bytes());
        }
        let looks = unit.looks.iter().flat_map(|&(cell, looks)| [cell, looks]);
        looks.chain(unit.open.iter().copied()).for_each(|n| out.extend(n.to_le_bytes()));
    }
    out.extend(hash(&out).to_le_bytes());
    out
}

/// Reads the bytes of so many units; `None` where they are not whole, or name cells or targets
/// beyond those that there are.
pub(super) fn read(bytes: &[u8], units: usize, limits: [u32; 2]) -> Option<Vec<Findings>> {
    let (body, sum) = bytes.split_last_chunk::<8>()?;
    if u64::from_le_bytes(*sum) != hash(body) {
        return None;
    }
    let mut rest = body.strip_prefix(MAGIC)?;
    let mut out = Vec::new();
    for _ in 0..units {
        let mut head = [0; 4];
        for n in &mut head {
            *n = u64::from_le_bytes(take(&mut rest)?);
        }
        let [seen, looks, open, rays] = head;
        let of = |count: u64, size: usize| usize::try_from(count).ok()?.checked_mul(size);
        let need = of(seen, SEEN)?.checked_add(of(looks, LOOKS)?)?.checked_add(of(open, 4)?)?;
        // Before anything is made for them.
        if need > rest.len() {
            return None;
        }
        let mut unit = Findings { rays, ..Findings::default() };
        for _ in 0..seen {
            let [cell, target] = [take(&mut rest)?, take(&mut rest)?].map(u32::from_le_bytes);
            let (mut at, mut eye) = ([0.0; 3], [0; 3]);
            for v in &mut at {
                *v = f32::from_le_bytes(take(&mut rest)?);
            }
            for v in &mut eye {
                *v = u16::from_le_bytes(take(&mut rest)?);
            }
            let lines = u32::from_le_bytes(take(&mut rest)?);
            unit.seen.push((Discovery { cell, target, at, eye }, lines));
        }
        let mut int = || take(&mut rest).map(u32::from_le_bytes);
        for _ in 0..looks {
            unit.looks.push((int()?, int()?));
        }
        for _ in 0..open {
            unit.open.push(int()?);
        }
        let mut cells = (unit.seen.iter().map(|(d, _)| d.cell))
            .chain(unit.looks.iter().map(|l| l.0))
            .chain(unit.open.iter().copied());
        let sound = cells.all(|c| c < limits[0])
            && unit.seen.iter().all(|(d, _)| d.target < limits[1])
            && unit.seen.iter().all(|(d, _)| d.at.iter().all(|v| v.is_finite()));
        if !sound {
            return None;
        }
        out.push(unit);
    }
    rest.is_empty().then_some(out)
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk::<N>()?;
    *rest = after;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found() -> Vec<Findings> {
        let seen = Discovery { cell: 2, target: 8, at: [0.5, -1.0, 0.25], eye: [0, 7, 65_535] };
        let one = Findings {
            seen: vec![(seen, 3), (Discovery { cell: 1, ..seen }, 0)],
            looks: vec![(0, 9), (2, 1)],
            open: vec![1],
            rays: 77,
        };
        vec![one, Findings::default()]
    }

    #[test]
    fn what_units_found_comes_back_from_its_bytes() {
        assert_eq!(read(&write(&found()), 2, [3, 9]), Some(found()));
        assert_eq!(read(&write(&[]), 0, [3, 9]), Some(Vec::new()));
    }

    #[test]
    fn damaged_bytes_and_those_of_another_scene_are_none() {
        let bytes = write(&found());
        for at in 0..bytes.len() {
            assert_eq!(read(&bytes[..at], 2, [3, 9]), None, "cut at {at}");
            let mut odd = bytes.clone();
            odd[at] ^= 4;
            assert_eq!(read(&odd, 2, [3, 9]), None, "odd at {at}");
        }
        for (units, limits) in [(1, [3, 9]), (3, [3, 9]), (2, [2, 9]), (2, [3, 8])] {
            assert_eq!(read(&bytes, units, limits), None, "{units} {limits:?}");
        }
    }
}
