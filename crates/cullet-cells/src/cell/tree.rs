//! A small tree over the pieces of cells: which of them may hold a point, or touch a box.
//!
//! Eight boxes a node, compared side by side: with two a node, whether each was met could not be
//! predicted, and finding a point among 10,000 took three times as long.

use alloc::vec;
use alloc::vec::Vec;

/// Boxes of a node.
const WIDE: usize = 8;
/// A child that is a piece.
const PIECE: u32 = 1 << 31;
/// Halved three times a level, 2³² pieces are eleven levels deep; each leaves at the most seven
/// others to do.
const DEEPEST: usize = 96;

/// Boxes of pieces and of other nodes.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Corners of the children's boxes by axis, rounded outward: the lowest here, the highest in
    /// `max`. A missing child has an inverted infinite box, which no finite box meets.
    min: [[f32; WIDE]; 3],
    max: [[f32; WIDE]; 3],
    /// Nodes, and pieces with [`PIECE`].
    children: [u32; WIDE],
}

/// A box in f64.
pub(super) type Bounds = [[f64; 3]; 2];

/// A tree of boxes, halved at the middle piece along their longest side.
#[derive(Clone, Debug, Default)]
pub(super) struct PieceTree {
    /// The first is the root; there is none without pieces.
    nodes: Vec<Node>,
}

impl PieceTree {
    /// Over boxes, by their numbers. O(n·log n).
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self::default();
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        if !boxes.is_empty() {
            tree.build(boxes, &mut order);
        }
        tree
    }

    fn build(&mut self, boxes: &[Bounds], order: &mut [u32]) -> u32 {
        let at = self.nodes.len();
        self.nodes.push(Node {
            min: [[f32::INFINITY; WIDE]; 3],
            max: [[f32::NEG_INFINITY; WIDE]; 3],
            children: [PIECE; WIDE],
        });
        let mut parts = vec![order];
        while parts.len() < WIDE {
            let longest = |part: &&mut [u32]| part.len();
            let Some((largest, len)) =
                parts.iter().map(longest).enumerate().max_by_key(|&(_, len)| len)
            else {
                break;
            };
            if len < 2 {
                break;
            }
            let part = parts.swap_remove(largest);
            let (low, high) = halve(boxes, part);
            parts.push(low);
            parts.push(high);
        }
        for (lane, part) in parts.into_iter().enumerate() {
            let all = around(boxes, part);
            let child = if part.len() == 1 { part[0] | PIECE } else { self.build(boxes, part) };
            let node = &mut self.nodes[at];
            node.children[lane] = child;
            for a in 0..3 {
                node.min[a][lane] = round_down(all[0][a]);
                node.max[a][lane] = round_up(all[1][a]);
            }
        }
        at as u32
    }

    /// Visits the pieces whose boxes touch a box.
    #[inline]
    pub(super) fn visit(&self, [min, max]: &Bounds, mut each: impl FnMut(u32)) {
        // Rounded outward, as the nodes are: compared in f32.
        let (min, max) = (min.map(round_down), max.map(round_up));
        let (mut stack, mut left) = ([0_u32; DEEPEST], usize::from(!self.nodes.is_empty()));
        while left > 0 {
            left -= 1;
            let node = &self.nodes[stack[left] as usize];
            let mut met = [true; WIDE];
            for a in 0..3 {
                for (lane, met) in met.iter_mut().enumerate() {
                    *met &= (node.min[a][lane] <= max[a]) & (node.max[a][lane] >= min[a]);
                }
            }
            let mut lanes = 0_u32;
            for (lane, met) in met.into_iter().enumerate() {
                lanes |= u32::from(met) << lane;
            }
            while lanes != 0 {
                let child = node.children[lanes.trailing_zeros() as usize];
                lanes &= lanes - 1;
                if child & PIECE != 0 {
                    each(child & !PIECE);
                } else {
                    stack[left] = child;
                    left += 1;
                }
            }
        }
    }
}

/// The box around some boxes.
fn around(boxes: &[Bounds], part: &[u32]) -> Bounds {
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for &piece in part {
        let [min, max] = &boxes[piece as usize];
        for a in 0..3 {
            all[0][a] = all[0][a].min(min[a]);
            all[1][a] = all[1][a].max(max[a]);
        }
    }
    all
}

/// Two halves along the longest side.
fn halve<'a>(boxes: &[Bounds], part: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
    let all = around(boxes, part);
    let side = |a: usize| all[1][a] - all[0][a];
    let axis = (1..3).fold(0, |longest, a| if side(a) > side(longest) { a } else { longest });
    let middle = |piece: u32| boxes[piece as usize][0][axis] + boxes[piece as usize][1][axis];
    let half = part.len() / 2;
    let by_middle = |a: &u32, b: &u32| middle(*a).total_cmp(&middle(*b)).then(a.cmp(b));
    part.select_nth_unstable_by(half, by_middle);
    part.split_at_mut(half)
}

/// Returns the largest f32 not above `v`. NaN stays NaN.
fn round_down(v: f64) -> f32 {
    let f = v as f32;
    if f64::from(f) > v { f.next_down() } else { f }
}

/// Returns the smallest f32 not below `v`. NaN stays NaN.
fn round_up(v: f64) -> f32 {
    let f = v as f32;
    if f64::from(f) < v { f.next_up() } else { f }
}
