//! Changes that an edit made to a scene, for a bake that goes on from earlier sets.

use std::collections::HashMap;

use cullet_io::baked::{SceneSets, hash, instance_marks};
use glam::DVec3;
use serde::Serialize;

use super::SampledError;
use super::near::NearTargets;
use super::targets::Granularity;
use super::tree::RayTree;
use crate::rows::{BitRows, ones, set};

/// An edit: what changed, and which cells see any of it.
///
/// A cell whose lines all end before they reach what changed sees what it saw: its set stays. The
/// set of any other keeps what stands as it stood, and is searched where things changed. What a new
/// instance hides is not taken out of it, for what no line finds again need not be hidden.
#[derive(Debug)]
pub(super) struct Edit {
    /// The sets of before in the numbers of now, without what changed.
    pub(super) before: BitRows,
    /// Estimates of before, one for each cell.
    pub(super) missing: Vec<f32>,
    /// Targets that are new or moved and take part.
    pub(super) targets: Vec<u32>,
    /// Where things changed, in the world.
    boxes: Vec<[DVec3; 2]>,
    /// Place in `boxes` of each changed target.
    box_of: HashMap<u32, u32>,
    /// Pairs of a cell and a box that it sees.
    views: Vec<(u32, u32)>,
    /// Cells that see something that changed, in the order in which that was found.
    eyes: Vec<u32>,
    touched: Vec<bool>,
    /// A bit for each target that a sweep looks for: what changed or was found since, and what
    /// stands beside it.
    swept: Vec<u64>,
    /// Rays that it is worth: as many for each pair that changed as the bake of before had for each
    /// of its pairs, some times over.
    pub(super) rays: u64,
    went: u32,
    /// Rays of the sets of before.
    pub(super) rays_before: u64,
    /// Hash of the sets of before.
    pub(super) key: u64,
}

/// Changes of an edit, in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct EditCounts {
    /// Instances that are new or moved and take part.
    pub came: u32,
    /// Instances of before that are no more, or moved.
    pub went: u32,
    /// Cells that see any of that.
    pub cells: u32,
}

/// Rays for each pair that changed, in those for each pair of a whole bake.
const RAYS: f64 = 3.0;

impl Edit {
    /// Holds a scene against the sets that were baked before.
    pub(super) fn new(
        tree: &RayTree<'_>,
        near: &NearTargets,
        before: &SceneSets,
    ) -> Result<Self, SampledError> {
        let by_instance = tree.targets().granularity() == Granularity::Instance;
        if before.marks.is_empty() || !by_instance {
            return Err(SampledError::Before);
        }
        let count = tree.targets().count();
        let marks = instance_marks(tree.scene);
        // Instances that are alike in everything are taken in their order.
        let mut left: HashMap<u64, Vec<u32>> = HashMap::new();
        for (index, mark) in (0_u32..).zip(&before.marks).collect::<Vec<_>>().into_iter().rev() {
            left.entry(mark.hash).or_default().push(index);
        }
        let mut now_of = vec![u32::MAX; before.marks.len()];
        let (mut boxes, mut box_of, mut targets) = (Vec::new(), HashMap::new(), Vec::new());
        for (index, mark) in (0..).zip(&marks).filter(|(_, mark)| mark.hash != 0) {
            match left.get_mut(&mark.hash).and_then(Vec::pop) {
                Some(old) => now_of[old as usize] = index,
                None => {
                    // What takes no part is kept everywhere, or nowhere.
                    let Some(bounds) = tree.target_bounds(index) else { continue };
                    box_of.insert(index, boxes.len() as u32);
                    boxes.push(bounds);
                    targets.push(index);
                }
            }
        }
        let rows = before.sets.cell_count();
        let mut kept = BitRows::new(rows, count);
        let mut views = Vec::new();
        let mut row = Vec::new();
        let mut gone = HashMap::new();
        let mut pairs = 0_u64;
        for cell in 0..rows {
            row.clear();
            before.sets.add_row_to(cell, &mut row);
            for old in ones(&row) {
                pairs += 1;
                match now_of.get(old as usize) {
                    Some(&u32::MAX) => {
                        let at = *gone.entry(old).or_insert_with(|| {
                            let [low, high] = before.marks[old as usize].bounds;
                            boxes.push([low, high].map(|v| DVec3::from(v.map(f64::from))));
                            boxes.len() as u32 - 1
                        });
                        views.push((cell, at));
                    }
                    Some(&now) => kept.set(cell, now),
                    None => {}
                }
            }
        }
        views.retain(|&(_, at)| boxes[at as usize].iter().all(|v| v.is_finite()));
        // What is new is expected to be seen from as many cells as others are.
        let known = before.marks.iter().filter(|mark| mark.hash != 0).count().max(1);
        let new = targets.len() as f64 * pairs as f64 / known as f64;
        let share = (views.len() as f64 + new) / pairs.max(1) as f64;
        let mut edit = Self {
            before: kept,
            missing: before.missing.clone(),
            swept: vec![0; (count as usize).div_ceil(64)],
            boxes,
            box_of,
            views,
            eyes: Vec::new(),
            touched: vec![false; rows as usize],
            rays: (before.rays as f64 * share * RAYS) as u64,
            went: (now_of.iter().zip(&before.marks))
                .filter(|(now, mark)| **now == u32::MAX && mark.hash != 0)
                .count() as u32,
            rays_before: before.rays,
            key: hash(&before.to_bytes()),
            targets,
        };
        let cells: Vec<u32> = edit.views.iter().map(|&(cell, _)| cell).collect();
        cells.into_iter().for_each(|cell| edit.touch(cell));
        for target in edit.targets.clone() {
            edit.sweep(target, near);
        }
        Ok(edit)
    }

    /// Changed instances, and the number of cells that are known to see any of them.
    pub(super) fn counts(&self) -> EditCounts {
        let (came, cells) = (self.targets.len() as u32, self.eyes.len() as u32);
        EditCounts { came, went: self.went, cells }
    }

    fn touch(&mut self, cell: u32) {
        if !std::mem::replace(&mut self.touched[cell as usize], true) {
            self.eyes.push(cell);
        }
    }

    fn sweep(&mut self, target: u32, near: &NearTargets) {
        set(&mut self.swept, target);
        near.of(target).for_each(|other| set(&mut self.swept, other));
    }

    /// Notes that a cell sees a target; whether that is news of the edit.
    pub(super) fn note(&mut self, cell: u32, target: u32, near: &NearTargets) -> bool {
        match self.box_of.get(&target) {
            Some(&at) => {
                self.views.push((cell, at));
                self.touch(cell);
            }
            None if !self.touches(cell) => return false,
            None => self.sweep(target, near),
        }
        true
    }

    /// Whether a cell sees something that changed.
    pub(super) fn touches(&self, cell: u32) -> bool {
        self.touched[cell as usize]
    }

    /// Whether the edit changed a target.
    pub(super) fn changed(&self, target: u32) -> bool {
        self.box_of.contains_key(&target)
    }

    /// A bit for each target that a sweep looks for.
    pub(super) fn swept(&self) -> &[u64] {
        &self.swept
    }

    /// Cells that see something that changed.
    pub(super) fn eyes(&self) -> &[u32] {
        &self.eyes
    }

    /// Pairs of a cell and a place that changed and that it sees, by number.
    pub(super) fn view(&self, number: u32) -> (u32, [DVec3; 2]) {
        let (cell, at) = self.views[number as usize];
        (cell, self.boxes[at as usize])
    }

    /// How many such pairs there are.
    pub(super) fn view_count(&self) -> u32 {
        self.views.len() as u32
    }
}
