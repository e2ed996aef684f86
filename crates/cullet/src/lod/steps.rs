//! How often the triangles of each cluster were simplified: the number of its level.

use alloc::vec;
use alloc::vec::Vec;

use super::{Levels, NO_GROUP};

impl Levels {
    /// For each cluster, how many simplifications lie between it and the original: 0 for the
    /// original's clusters; of a chain the number of the level; of a hierarchy its depth, the
    /// longest way where there are several.
    ///
    /// O(clusters), in no order that matters; for tables and pictures, not for each frame.
    #[must_use]
    pub fn steps(&self) -> Vec<u32> {
        let groups = self.group_count();
        // The coarser groups that each one leads to, and how many finer ones have not been counted
        // yet.
        let (mut leads_to, mut waiting) = (vec![Vec::new(); groups], vec![0u32; groups]);
        for (&from, &by) in self.made_from().iter().zip(self.replaced_by()) {
            if from != NO_GROUP && by != NO_GROUP {
                leads_to[from as usize].push(by);
                waiting[by as usize] += 1;
            }
        }
        let mut steps = vec![1u32; groups];
        let mut ready: Vec<u32> = (0..).zip(&waiting).filter(|g| *g.1 == 0).map(|g| g.0).collect();
        // A group that leads to itself, which no bake makes, is never ready and stays as it is.
        while let Some(group) = ready.pop() {
            for &by in &leads_to[group as usize] {
                steps[by as usize] = steps[by as usize].max(steps[group as usize] + 1);
                waiting[by as usize] -= 1;
                if waiting[by as usize] == 0 {
                    ready.push(by);
                }
            }
        }
        let step = |&from: &u32| if from == NO_GROUP { 0 } else { steps[from as usize] };
        self.made_from().iter().map(step).collect()
    }
}
