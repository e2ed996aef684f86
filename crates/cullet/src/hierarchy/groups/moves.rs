//! Groups whose things move: boxes that grow, and are fitted again.

use std::ops::Range;

use super::{Groups, GroupsError};
use crate::bits;
use crate::bounds::{Aabb, Boxes, LANES};

impl Groups {
    /// Moves a thing: gives it other bounds. The groups above grow as far as they must, and so are right at
    /// any time; [`refit`](Self::refit) makes them tight again. O(depth) at most, mostly O(1).
    ///
    /// # Errors
    /// If there is no such thing.
    pub fn set_bounds(&mut self, item: u32, bounds: &Aabb) -> Result<(), GroupsError> {
        let Some(&place) = self.place_of_item.get(item as usize) else {
            let items = self.items.len() as u32;
            return Err(GroupsError::NoItem { group: Self::NONE, item, items });
        };
        let place = place as usize;
        self.boxes.set(place, bounds);
        bits::set(&mut self.holes, place, is_hole(&self.boxes, place));
        let rows = rows_of(&self.boxes, place);
        let mut node = self.node_of_place[place] as usize;
        bits::set(&mut self.loose, node, true);
        loop {
            let held = rows_of(&self.node_boxes, node);
            let grown: [f32; 6] = std::array::from_fn(|r| larger(held[r], rows[r]));
            // A thing alone may have left a larger box behind, so this is asked even if nothing grew.
            if grown != held {
                set_rows(&mut self.node_boxes, node, grown);
            }
            self.note_alone(node);
            let count = self.nodes[node].places().len();
            if node == 0 || (grown == held && count > 1) {
                return Ok(());
            }
            node = self.nodes[node].parent as usize;
        }
    }

    /// Gives all things other bounds, by their number, and fits all groups to them: for a world in which
    /// most things move.
    ///
    /// # Panics
    /// If there is not one box a thing.
    pub fn set_all(&mut self, bounds: &[Aabb]) {
        assert_eq!(bounds.len(), self.items.len(), "boxes of things");
        self.boxes.gather(self.level, bounds, &self.items);
        self.fit_to_new();
    }

    /// [`set_all`](Self::set_all) from boxes that are stored already: see [`over`](Self::over).
    ///
    /// # Panics
    /// If there is not one box a thing.
    pub fn set_all_stored(&mut self, boxes: &Boxes) {
        assert_eq!(boxes.len(), self.items.len(), "boxes of things");
        let staged: Vec<_> = (0..boxes.len()).map(|i| boxes.get(i)).collect();
        self.boxes.gather_stored(&staged, &self.items);
        self.fit_to_new();
    }

    fn fit_to_new(&mut self) {
        for place in 0..self.items.len() {
            bits::set(&mut self.holes, place, is_hole(&self.boxes, place));
        }
        self.fit();
    }

    /// Fits all groups to what is in them; also those whose box was [given](Self::give_bounds).
    pub fn fit(&mut self) {
        // Children come after their parents.
        (0..self.nodes.len()).rev().for_each(|node| self.fit_node(node));
        self.loose.fill(0);
    }

    /// Fits the groups above all things that were set since the last time. The cost is that of the groups
    /// that change and their members, and of a bit a group.
    pub fn refit(&mut self) {
        for word in (0..self.loose.len()).rev() {
            // From the highest down: a parent may be in the same word.
            while self.loose[word] != 0 {
                let bit = 63 - self.loose[word].leading_zeros() as usize;
                self.loose[word] &= !(1 << bit);
                let node = word * 64 + bit;
                let before = rows_of(&self.node_boxes, node);
                self.fit_node(node);
                if node != 0 && rows_of(&self.node_boxes, node) != before {
                    bits::set(&mut self.loose, self.nodes[node].parent as usize, true);
                }
            }
        }
    }

    pub(super) fn fit_node(&mut self, node: usize) {
        let n = self.nodes[node];
        let mut rows = [-Boxes::LIMIT; 6];
        largest(&self.boxes, n.own(), &mut rows);
        largest(&self.node_boxes, n.child_range(), &mut rows);
        set_rows(&mut self.node_boxes, node, rows);
        self.note_alone(node);
    }

    pub(super) fn note_alone(&mut self, node: usize) {
        let n = &self.nodes[node];
        let alone = n.end - n.first == 1
            && rows_of(&self.node_boxes, node) == rows_of(&self.boxes, n.first as usize);
        bits::set(&mut self.alone, node, alone);
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

pub(super) fn rows_of(boxes: &Boxes, index: usize) -> [f32; 6] {
    boxes.blocks()[index / LANES].0.map(|row| row[index % LANES])
}

/// For rows that are wide enough already.
fn set_rows(boxes: &mut Boxes, index: usize, rows: [f32; 6]) {
    let block = &mut boxes.blocks_mut()[index / LANES].0;
    block.iter_mut().zip(rows).for_each(|(row, v)| row[index % LANES] = v);
}

fn is_hole(boxes: &Boxes, index: usize) -> bool {
    boxes.blocks()[index / LANES].0[3][index % LANES] == -Boxes::LIMIT
}

/// Enlarges rows by those of some boxes: −min and max, so that the largest is the box around all.
fn largest(boxes: &Boxes, range: Range<usize>, rows: &mut [f32; 6]) {
    let mut at = range.start;
    while at < range.end {
        let end = ((at / LANES + 1) * LANES).min(range.end);
        let block = &boxes.blocks()[at / LANES].0;
        let lanes = at % LANES..at % LANES + (end - at);
        for (row, to) in block.iter().zip(&mut *rows) {
            *to = row[lanes.clone()].iter().fold(*to, |a, &v| larger(a, v));
        }
        at = end;
    }
}
