//! Fades from one level of detail to the next: for some time both are drawn, each in the pixels
//! that the other leaves, so that nothing pops and nothing is seen through.

use std::collections::BTreeMap;

use cullet::cull::detail::Detail;
use cullet::{
    Scene, Stage, View, Visible,
    draw::{DrawRange, SlotRange},
};

use crate::levels_alone::ranges_of;

/// The levels of a slot that go while others come.
#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Nothing: others stood for it.
    Nothing,
    /// All of it in full.
    Whole,
    /// Some clusters.
    Ranges(Vec<DrawRange>),
}

/// One slot on its way.
#[derive(Clone, Debug, PartialEq)]
struct Fade {
    /// How far it is: from 0 to 1.
    share: f64,
    old: Shape,
}

/// A decision, with what levels alone draw in its view, each instance as itself.
#[derive(Clone, Copy, Debug)]
pub struct Cut<'a> {
    /// The decision, with its reasons.
    pub visible: &'a Visible,
    /// The cut.
    pub alone: &'a Visible,
}

/// All that is fading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fades {
    slots: BTreeMap<u32, Fade>,
    going: Visible,
}

impl Cut<'_> {
    /// Returns the shape that is drawn of a slot, as far as levels decide that; `None` where
    /// another stage dropped it.
    fn shape(&self, scene: &Scene, slot: u32) -> Option<Shape> {
        let reason = self.visible.reasons.get(slot as usize).copied().flatten();
        let ranges = if scene.is_stand_in(slot) {
            match ranges_of(self.visible, slot) {
                [] => return Some(Shape::Nothing),
                own => own,
            }
        } else {
            match reason.map(|reason| reason.stage) {
                None => ranges_of(self.alone, slot),
                Some(Stage::Lod) => return Some(Shape::Nothing),
                Some(_) => return None,
            }
        };
        Some(if ranges.is_empty() { Shape::Whole } else { Shape::Ranges(ranges.to_vec()) })
    }

    /// Whether a slot was dropped by no more than levels.
    fn is_shown(&self, slot: u32) -> bool {
        let reason = self.visible.reasons.get(slot as usize).copied().flatten();
        reason.is_none_or(|reason| reason.stage == Stage::Lod)
    }

    /// Slots of which levels draw no more than some clusters, or nothing. With repetitions.
    fn candidates(&self, scene: &Scene) -> impl Iterator<Item = u32> {
        let replaced = (0..).zip(&self.visible.reasons);
        let replaced = replaced.filter(|(_, r)| r.is_some_and(|r| r.stage == Stage::Lod));
        let partial = self.alone.partial.iter().map(|r| r.slot);
        partial.chain(replaced.map(|(slot, _)| slot)).chain(scene.stand_in_slots())
    }
}

impl Fades {
    /// Goes on to the next decision of the same scene; those `without` change at once. Costs a
    /// sweep over what is not drawn in full, and of instances that stand for others and come one
    /// over the slots.
    pub fn follow(
        &mut self,
        scene: &Scene,
        [before, after]: [Cut<'_>; 2],
        without: impl Fn(u32) -> bool,
    ) {
        let mut slots: Vec<u32> = before.candidates(scene).chain(after.candidates(scene)).collect();
        slots.sort_unstable();
        slots.dedup();
        for slot in slots {
            let both = (before.shape(scene, slot), after.shape(scene, slot));
            let (Some(old), Some(new)) = both else {
                self.slots.remove(&slot);
                continue;
            };
            if old == new {
                continue;
            }
            // What comes with the edge of the picture, or from behind something, was not there
            // before in another form.
            let is_new = || !scene.stood_for_by(slot).into_iter().any(|s| before.is_shown(s));
            if without(slot) || old == Shape::Nothing && scene.is_stand_in(slot) && is_new() {
                self.slots.remove(&slot);
                continue;
            }
            match self.slots.get_mut(&slot) {
                // It turns back where it is.
                Some(fade) if fade.old == new => *fade = Fade { share: 1.0 - fade.share, old },
                // What it is on its way to is another now.
                Some(_) => {}
                None => {
                    self.slots.insert(slot, Fade { share: 0.0, old });
                }
            }
        }
        self.collect();
    }

    /// Lets time pass, of which a fade takes `seconds`. True while something is fading.
    pub fn advance(&mut self, dt: f64, seconds: f64) -> bool {
        if self.slots.is_empty() {
            return false;
        }
        let step = if seconds > 0.0 { dt / seconds } else { 1.0 };
        self.slots.retain(|_, fade| {
            fade.share += step;
            fade.share < 1.0
        });
        self.collect();
        true
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether nothing fades.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// How many instances fade.
    #[must_use]
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Returns the instances that fade out: to be drawn in the pixels that the
    /// [shares](Self::shares) leave.
    #[must_use]
    pub fn going(&self) -> &Visible {
        &self.going
    }

    /// The slots that fade, and the share of the pixels in which what comes is drawn already.
    pub fn shares(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.slots.iter().map(|(&slot, fade)| (slot, fade.share))
    }

    fn collect(&mut self) {
        self.going.whole.clear();
        self.going.partial.clear();
        for (&slot, fade) in &self.slots {
            match &fade.old {
                Shape::Nothing => {}
                Shape::Whole => self.going.whole.push(SlotRange { first: slot, count: 1 }),
                Shape::Ranges(ranges) => self.going.partial.extend_from_slice(ranges),
            }
        }
    }
}

/// Returns the share of its pixels in which an instance is drawn because of its size.
#[must_use]
pub fn share_by_size(scene: &Scene, view: &View, detail: &Detail, slot: u32) -> f64 {
    let rect = view.project_box(&scene.bounds(slot), scene.origin());
    let size = rect.map(|rect| [rect.width(), rect.height()]);
    detail.weight(size, f64::from(scene.size_weight(slot)))
}

#[cfg(test)]
mod tests {
    use cullet::Reason;

    use super::*;

    fn at(slot: u32, level: u32, first_cluster: u32) -> DrawRange {
        DrawRange { slot, level, first_cluster, cluster_count: 2 }
    }

    /// A result of four slots.
    fn of(partial: &[DrawRange], reasons: [Option<Stage>; 4]) -> Visible {
        let reasons = reasons.map(|r| r.map(|stage| Reason { stage, detail: 0 })).to_vec();
        Visible { partial: partial.to_vec(), reasons, ..Visible::default() }
    }

    fn shares(fades: &Fades) -> Vec<(u32, f64)> {
        fades.shares().collect()
    }

    #[test]
    fn what_changes_its_level_fades_and_what_comes_into_sight_does_not() {
        let scene = cullet_scenes::build("solids").unwrap().scene;
        let hidden = Some(Stage::Occlusion);
        let a = of(&[at(0, 1, 0), at(1, 1, 0), at(2, 1, 0)], [None, None, hidden, None]);
        // Another cut, the same, out of hiding with another cut, and from full to a level.
        let b = of(&[at(0, 1, 4), at(1, 1, 0), at(2, 1, 4), at(3, 1, 0)], [None; 4]);
        let cut = |v| Cut { visible: v, alone: v };
        let mut fades = Fades::default();
        fades.follow(&scene, [cut(&a), cut(&b)], |_| false);
        assert_eq!(shares(&fades), [(0, 0.0), (3, 0.0)]);
        assert_eq!(fades.going().partial, [at(0, 1, 0)]);
        assert_eq!(fades.going().whole, [SlotRange { first: 3, count: 1 }]);
        assert!(fades.advance(0.1, 0.4));
        // One turns back, the other goes on.
        let c = of(&[at(0, 1, 0), at(1, 1, 0), at(2, 1, 4), at(3, 1, 0)], [None; 4]);
        fades.follow(&scene, [cut(&b), cut(&c)], |_| false);
        assert_eq!(shares(&fades), [(0, 0.75), (3, 0.25)]);
        assert_eq!(fades.going().partial, [at(0, 1, 4)]);
        assert!(fades.advance(0.1, 0.4));
        assert_eq!((shares(&fades), fades.len()), (vec![(3, 0.5)], 1));
        // One that is dropped fades no more.
        let d = of(&c.partial, [None, None, None, hidden]);
        fades.follow(&scene, [cut(&c), cut(&d)], |_| false);
        assert!(fades.is_empty() && fades.going().whole.is_empty());
        assert!(!fades.advance(0.1, 0.4));
        fades.follow(&scene, [cut(&a), cut(&b)], |slot| slot == 0);
        assert_eq!(shares(&fades), [(3, 0.0)], "one that fades by its size changes at once");
        fades.advance(0.1, 0.0);
        assert!(fades.is_empty(), "no time is at once");
    }

    #[test]
    fn what_others_stood_for_comes_from_nothing() {
        let scene = cullet_scenes::build("solids").unwrap().scene;
        let (a, b) = (of(&[], [Some(Stage::Lod), None, None, None]), of(&[], [None; 4]));
        let cut = |v| Cut { visible: v, alone: v };
        let mut fades = Fades::default();
        fades.follow(&scene, [cut(&a), cut(&b)], |_| false);
        assert_eq!(shares(&fades), [(0, 0.0)]);
        assert_eq!(*fades.going(), Visible::default());
        fades.follow(&scene, [cut(&b), cut(&a)], |_| false);
        assert_eq!(shares(&fades), [(0, 1.0)]);
    }
}
