//! Matrix of the cells that see each other.

use std::collections::VecDeque;

use super::super::Picture;
use super::super::canvas::{LINE, grouped, keys, keys_height};
use super::super::font::text_size;
use super::super::palette::{INK, PAPER, PROVED, UNSEEN, mix};
use crate::sort;

/// Neither sees the other.
const HIDDEN: [u8; 3] = [0x2B, 0x33, 0x3D];

/// Knowledge about a pair of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairShown {
    /// A line of sight is known.
    Visible,
    /// Neither that nor a proof that there is none.
    Undecided,
    /// There is none.
    Hidden,
}

impl PairShown {
    const ALL: [Self; 3] = [Self::Visible, Self::Undecided, Self::Hidden];

    /// Its colour in a matrix.
    #[must_use]
    pub const fn color(self) -> [u8; 3] {
        match self {
            Self::Visible => PROVED,
            Self::Undecided => UNSEEN,
            Self::Hidden => HIDDEN,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Visible => "proven visible",
            Self::Undecided => "undecided, and kept",
            Self::Hidden => "proven hidden",
        }
    }
}

/// An order of cells in which neighbours stand together: from one at the end of each part breadth
/// first, cells with few neighbours first. `neighbours` are the cells beside each.
#[must_use]
pub fn matrix_order(neighbours: &[Vec<u32>]) -> Vec<u32> {
    // Cuthill & McKee, Reducing the Bandwidth of Sparse Symmetric Matrices, 1969.
    let count = neighbours.len();
    let is_cell = |c: &&u32| (**c as usize) < count;
    let mut order = Vec::with_capacity(count);
    let mut placed = vec![false; count];
    let few_first =
        |cells: &[u32]| sort::sorted_by(cells, |&c| neighbours[c as usize].len() as u64);
    let all: Vec<u32> = (0..count as u32).collect();
    for start in few_first(&all) {
        if placed[start as usize] {
            continue;
        }
        // The cell farthest away is at an end.
        let mut seen = vec![false; count];
        let mut queue = VecDeque::from([start]);
        seen[start as usize] = true;
        let mut end = start;
        while let Some(cell) = queue.pop_front() {
            end = cell;
            for &next in neighbours[cell as usize].iter().filter(is_cell) {
                if !std::mem::replace(&mut seen[next as usize], true) && !placed[next as usize] {
                    queue.push_back(next);
                }
            }
        }
        queue.push_back(end);
        placed[end as usize] = true;
        while let Some(cell) = queue.pop_front() {
            order.push(cell);
            let next: Vec<u32> = neighbours[cell as usize]
                .iter()
                .filter(is_cell)
                .copied()
                .filter(|&n| !std::mem::replace(&mut placed[n as usize], true))
                .collect();
            queue.extend(few_first(&next));
        }
    }
    order
}

/// A matrix of cells: a row is what a cell sees, green where a line of sight is known, yellow where
/// nothing is and the pair is kept, dark where it is proven hidden; with the totals of pairs. Rows
/// and columns are in `order`.
///
/// A pixel that shares several pairs has the mean of their colours. `size` is that of the picture,
/// at least 200 wide; the height is at least the width and what the words need. Cost: O(cells²), a
/// call of `state` each.
#[must_use]
pub fn pvs_matrix(
    order: &[u32],
    state: impl Fn(u32, u32) -> PairShown,
    title: &str,
    size: [u32; 2],
) -> Picture {
    let width = size[0].max(200);
    let text = text_size(width);
    let line = (text * LINE).round() as i64;
    let gap = i64::from(width) / 40;
    let room = i64::from(width) - 2 * gap;
    let count = order.len();
    let mut totals = [0_u64; 3];
    let states: Vec<u8> = order
        .iter()
        .flat_map(|&a| order.iter().map(move |&b| (a, b)))
        .map(|(a, b)| {
            let is = state(a, b);
            let kind = PairShown::ALL.iter().position(|s| *s == is).unwrap_or(0);
            totals[kind] += u64::from(a != b);
            kind as u8
        })
        .collect();
    let whole = totals.iter().sum::<u64>().max(1);
    let entries: Vec<([u8; 3], String)> = PairShown::ALL
        .into_iter()
        .zip(totals)
        .map(|(s, n)| {
            let share = n as f64 / whole as f64 * 100.0;
            (s.color(), format!("{}: {} pairs, {share:.2} %", s.words(), grouped(n)))
        })
        .collect();
    let above = 2 * gap + line;
    let below = 2 * gap + keys_height(room, text, &entries);
    let height = i64::from(size[1]).max(above + below + 100);
    let side = room.min(height - above - below);
    let mut picture = Picture::new(width, height as u32, PAPER);
    picture.text([gap, gap], title, text, INK);
    let left = (i64::from(width) - side) / 2;
    // Of few cells each is as many pixels as all others.
    let side =
        if count > 0 && count as i64 <= side { side / count as i64 * count as i64 } else { side };
    picture.fill([left - 1, above - 1], [side + 2; 2], mix(INK, PAPER, 0.3), 1.0);
    let range = |at: i64| {
        let first = at as usize * count / side as usize;
        first..((at as usize + 1) * count / side as usize).max(first + 1).min(count)
    };
    for y in 0..side {
        for x in 0..side {
            let (mut sum, mut n) = ([0.0; 3], 0.0);
            for a in range(y) {
                for b in range(x) {
                    let color = PairShown::ALL[states[a * count + b] as usize].color();
                    // The mean of light, or what is rare would be lost.
                    (0..3).for_each(|c| sum[c] += f64::from(color[c]).powi(2));
                    n += 1.0;
                }
            }
            if n > 0.0 {
                let color = sum.map(|v| (v / n).sqrt().round() as u8);
                picture.fill([left + x, above + y], [1, 1], color, 1.0);
            }
        }
    }
    keys(&mut picture, [gap, above + side + gap], gap + room, text, INK, &entries);
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_stand_together_in_a_row_of_rooms() {
        // Rooms 0 4 1 3 2 in a row, and one alone.
        let neighbours = vec![vec![4], vec![4, 3], vec![3], vec![1, 2], vec![0, 1], vec![]];
        let order = matrix_order(&neighbours);
        let at = |c: u32| order.iter().position(|&o| o == c).unwrap() as i32;
        for (a, b) in [(0, 4), (4, 1), (1, 3), (3, 2)] {
            assert_eq!((at(a) - at(b)).abs(), 1, "{order:?}");
        }
        assert_eq!(order.len(), 6);
        assert!(matrix_order(&[vec![7]]) == [0] && matrix_order(&[]).is_empty());
    }

    #[test]
    fn a_matrix_has_the_colours_of_its_pairs() {
        let state = |a: u32, b: u32| match a.abs_diff(b) {
            0 | 1 => PairShown::Visible,
            2 => PairShown::Undecided,
            _ => PairShown::Hidden,
        };
        let picture = pvs_matrix(&[0, 1, 2, 3], state, "four", [240, 320]);
        let count = |color: [u8; 3]| picture.rgb.chunks_exact(3).filter(|c| **c == color).count();
        // Ten, four and two of sixteen squares.
        let squares = PairShown::ALL.map(|s| count(s.color()) as f64);
        assert!((squares[0] / squares[1] - 2.5).abs() < 0.1, "{squares:?}");
        assert!((squares[1] / squares[2] - 2.0).abs() < 0.1, "{squares:?}");
        assert!(pvs_matrix(&[], state, "", [0, 0]).width >= 200);
    }
}
