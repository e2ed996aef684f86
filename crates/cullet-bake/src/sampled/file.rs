//! Sampled sets as a file has them.

use cullet_cells::pvs::{Targets, VisibleSets};
use cullet_io::baked::SceneSets;

use super::sets::ScenePvs;

impl ScenePvs {
    /// The sets as a scene takes them. Of an instance that was baked by clusters, the set holds it
    /// where it holds any of them.
    #[must_use]
    pub fn to_sets(&self) -> SceneSets {
        let count = (0..).take_while(|&index| self.targets.range(index).is_some()).count() as u32;
        let rows: Vec<Vec<u64>> = (0..self.visible.rows())
            .map(|cell| {
                let mut row = vec![0; (count as usize).div_ceil(64)];
                for index in 0..count {
                    let mut range = self.targets.range(index).into_iter().flatten();
                    if range.any(|target| self.visible.has(cell, target)) {
                        row[index as usize / 64] |= 1_u64 << (index % 64);
                    }
                }
                row
            })
            .collect();
        let rows = rows.iter().map(Vec::as_slice);
        SceneSets {
            cells: self.cells.clone(),
            sets: VisibleSets::from_rows(Targets::Instances, count, rows),
            missing: self.missing.clone(),
            scene_hash: self.scene_hash,
            rays: self.rays,
            marks: self.marks.clone(),
        }
    }

    /// The bytes of a file: a [container](cullet_io::baked::Container).
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        self.to_sets().to_bytes()
    }
}
