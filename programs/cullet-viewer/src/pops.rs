//! Pops: instances that the lossy stages drew differently in the last picture than in the one
//! before.

use cullet::{Culler, Scene, Stage, View, Visible};

use crate::levels_alone::levels_alone;

/// Instances that changed from one decision to the next for no other reason than their size on the
/// screen; ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pops {
    /// Instances that were too small before.
    pub came: Vec<u32>,
    /// Instances that are too small now.
    pub went: Vec<u32>,
    /// Instances that are drawn at other levels of detail.
    pub changed: Vec<u32>,
    /// Result of levels alone on the scene, as of the last time it was computed.
    cut: Option<Box<Visible>>,
}

impl Pops {
    /// Goes on to the next decision, of the same scene, with the culler and view that it was made
    /// by. Cost: a sweep over the slots, and where levels are drawn a cull by these alone.
    pub(crate) fn follow(
        &mut self,
        scene: &Scene,
        [before, after]: [&Visible; 2],
        culler: &Culler,
        view: &View,
    ) {
        self.came.clear();
        self.went.clear();
        self.changed.clear();
        let small = |visible: &Visible, slot: usize| {
            visible.reasons.get(slot).copied().flatten().map(|r| r.stage == Stage::Detail)
        };
        for slot in 0..after.reasons.len().min(before.reasons.len()) {
            match (small(before, slot), small(after, slot)) {
                (Some(true), None) => self.came.push(slot as u32),
                (None, Some(true)) => self.went.push(slot as u32),
                _ => {}
            }
        }
        let cut = levels_alone(scene, (culler, view), after, true);
        if let (Some(old), Some(new)) = (&self.cut, &cut) {
            let kept = |slot: u32| small(after, slot as usize).is_none();
            self.changed = changed(old, new).into_iter().filter(|&slot| kept(slot)).collect();
        }
        self.cut = cut;
    }

    /// In words.
    #[must_use]
    pub fn text(&self) -> String {
        let n = |all: &[u32]| crate::numbers::grouped(all.len() as u64);
        format!(
            "since the picture before: {} came, {} went, {} changed level",
            n(&self.came),
            n(&self.went),
            n(&self.changed)
        )
    }
}

/// Slots of which two cuts draw different clusters.
fn changed(a: &Visible, b: &Visible) -> Vec<u32> {
    let mut out = Vec::new();
    let mut of_a = a.partial.chunk_by(|x, y| x.slot == y.slot).peekable();
    let mut of_b = b.partial.chunk_by(|x, y| x.slot == y.slot).peekable();
    loop {
        let next = [of_a.peek(), of_b.peek()].map(|own| own.map(|own| own[0].slot));
        let Some(slot) = next.into_iter().flatten().min() else { return out };
        let old = of_a.next_if(|own| own[0].slot == slot);
        let new = of_b.next_if(|own| own[0].slot == slot);
        if old != new {
            out.push(slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet::draw::DrawRange;

    use super::*;

    #[test]
    fn slots_whose_clusters_differ_are_changed() {
        let range =
            |slot, level, first_cluster| DrawRange { slot, level, first_cluster, cluster_count: 2 };
        let of =
            |partial: &[DrawRange]| Visible { partial: partial.to_vec(), ..Visible::default() };
        let a = of(&[range(1, 1, 0), range(1, 1, 4), range(2, 1, 0), range(5, 2, 0)]);
        // Another run, the same, another level, gone back to full, and new.
        let b = of(&[range(1, 1, 0), range(2, 1, 0), range(5, 1, 0), range(9, 1, 0)]);
        assert_eq!(changed(&a, &b), [1, 5, 9]);
        assert_eq!(changed(&b, &a), [1, 5, 9]);
        assert!(changed(&a, &a).is_empty());
    }
}
