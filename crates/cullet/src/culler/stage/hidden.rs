//! Testing what is left against the buffer, by groups of 4,096 slots: as many of them a job as make
//! jobs of about the same length.

use alloc::vec::Vec;
use core::array;

use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{GROUP, Instances, groups, slots};
use crate::cull::occlusion::{BoxTests, OcclusionBuffer, Visibility};
use crate::funnel::{Reason, Stage};
use crate::jobs::{self, MOST};
use crate::scene::{Scene, Tally};

/// Reason for which an instance is dropped.
pub(super) const HIDDEN: Reason = Reason { stage: Stage::Occlusion, detail: 0 };

/// The fewest live words that are worth a job.
const LEAST_WORDS: f32 = 48.0;

/// Words of some groups that follow each other.
struct Groups<'a> {
    /// The number of the first word.
    first: usize,
    alive: &'a mut [u64],
    inside: &'a mut [u64],
    whole: &'a mut [u64],
    /// Words that are alive; afterwards the first `kept`.
    live: &'a mut [u32],
    kept: usize,
    /// How many tests it took, and what those dropped hold.
    tests: u64,
    dropped: Tally,
}

/// Drops what is hidden of all that is left; how many tests it took, and what those dropped hold.
/// Sets the bits in `whole` of those of which no part can be hidden.
pub(super) fn test(
    frame: &Frame<'_>,
    against: &BoxTests<'_>,
    set: &mut Instances,
    whole: &mut Vec<u64>,
    log: &mut Log<'_>,
    buffer: &OcclusionBuffer,
) -> (u64, Tally) {
    whole.resize(set.alive.len(), 0);
    let scene = frame.scene;
    let count = match log.wants_reasons() {
        true => 1,
        // What is hidden by large nodes takes next to no time: some more jobs even that out.
        false => jobs::split(frame.jobs, set.live.len() as f32, LEAST_WORDS, 4),
    };
    let mut some = split(set, whole, count);
    if count > 1 {
        jobs::each(frame.jobs, &mut some[..count], |some| {
            if let Some(some) = some {
                some.test(scene, against, buffer, None);
            }
        });
    } else if let [Some(all), ..] = &mut some {
        all.test(scene, against, buffer, Some(log));
    }
    let (mut tests, mut dropped) = (0, Tally::default());
    let mut parts = [(0, 0); MOST];
    for (part, some) in parts.iter_mut().zip(some.iter().flatten()) {
        *part = (some.live.len(), some.kept);
        tests += some.tests;
        dropped += some.dropped;
    }
    let (mut from, mut to) = (0, 0);
    for (len, kept) in parts {
        set.live.copy_within(from..from + kept, to);
        (from, to) = (from + len, to + kept);
    }
    set.live.truncate(to);
    (tests, dropped)
}

/// Splits words at groups, so that parts have about as many live ones.
fn split<'a>(
    set: &'a mut Instances,
    whole: &'a mut [u64],
    count: usize,
) -> [Option<Groups<'a>>; MOST] {
    let Instances { alive, inside, live } = set;
    let (mut alive, mut inside, mut whole) = (&mut alive[..], &mut inside[..], whole);
    let (mut live, mut first) = (&mut live[..], 0);
    array::from_fn(|part| {
        let left = count.checked_sub(part).filter(|&left| left > 0)?;
        let at = live.get(live.len() / left).map_or(usize::MAX, |&w| w as usize / GROUP * GROUP);
        let end = if left == 1 { usize::MAX } else { at };
        let words = end.saturating_sub(first).min(alive.len());
        let own = live.partition_point(|&w| (w as usize) < end);
        let next = first + words;
        let take = |of: &mut &'a mut [u64]| {
            let (own, rest) = core::mem::take(of).split_at_mut(words);
            *of = rest;
            own
        };
        let (own_alive, own_inside, own_whole) =
            (take(&mut alive), take(&mut inside), take(&mut whole));
        let (own_live, rest) = core::mem::take(&mut live).split_at_mut(own);
        live = rest;
        let some = Groups {
            first,
            alive: own_alive,
            inside: own_inside,
            whole: own_whole,
            live: own_live,
            kept: 0,
            tests: 0,
            dropped: Tally::default(),
        };
        first = next;
        Some(some)
    })
}

impl Groups<'_> {
    fn test(
        &mut self,
        scene: &Scene,
        against: &BoxTests<'_>,
        buffer: &OcclusionBuffer,
        mut log: Option<&mut Log<'_>>,
    ) {
        let Self { alive, inside, live, .. } = self;
        let hierarchy = scene.hierarchy();
        let mut first = 0;
        while first < live.len() {
            let start = live[first] as usize / GROUP * GROUP;
            let of_group = first..first + groups(&live[first..]).next().map_or(1, <[u32]>::len);
            let own = start - self.first;
            let own = own..(own + GROUP).min(alive.len());
            let words = start..start + own.len();
            let (mut left, mut whole) = ([0; GROUP], [0; GROUP]);
            let of_scene = alive[own.clone()].iter().zip(&scene.exempt()[words]);
            left.iter_mut()
                .zip(of_scene)
                .for_each(|(left, (alive, exempt))| *left = alive & !exempt);
            let stood_in = stand_ins_unseen(scene, buffer, start, &mut left);
            let mut dropped = left;
            let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
            self.tests += against.group(nodes, boxes, start / GROUP, &mut left, &mut whole);
            dropped.iter_mut().zip(&left).for_each(|(dropped, left)| *dropped &= !left);
            dropped.iter_mut().zip(&stood_in).for_each(|(dropped, unseen)| *dropped |= unseen);
            self.dropped += scene.tally_of_words(start, &dropped[..own.len()]);
            self.whole[own.clone()].copy_from_slice(&whole[..own.len()]);
            let of_words = alive[own.clone()].iter_mut().zip(&dropped);
            let any_left = of_words.fold(0, |any, (alive, dropped)| {
                *alive &= !dropped;
                any | *alive
            });
            if let Some(log) = log.as_mut().filter(|log| log.wants_reasons()) {
                for (word, &dropped) in (start..).zip(&dropped) {
                    slots(word, dropped).for_each(|slot| log.drop_slot(slot, HIDDEN));
                }
            }
            // No later stage looks at a word of which all is hidden.
            if any_left == 0 {
                inside[own].fill(0);
            } else {
                for at in of_group.clone() {
                    let word = live[at] as usize - self.first;
                    if alive[word] == 0 {
                        inside[word] = 0;
                    } else {
                        live[self.kept] = live[at];
                        self.kept += 1;
                    }
                }
            }
            first = of_group.end;
        }
    }
}

/// Takes out of the words of a group the instances that stand for others, which have no box in the
/// hierarchy; one bit for each of them that is hidden or outside.
fn stand_ins_unseen(
    scene: &Scene,
    buffer: &OcclusionBuffer,
    start: usize,
    left: &mut [u64; GROUP],
) -> [u64; GROUP] {
    let mut unseen = [0; GROUP];
    let Some(stands) = scene.stand_ins() else { return unseen };
    for ((word, left), unseen) in (start..).zip(left).zip(&mut unseen) {
        let own = *left & stands.word(word);
        *left &= !own;
        let is_unseen = |slot: &u32| buffer.test_box(&scene.bounds(*slot)) != Visibility::Visible;
        *unseen = slots(word, own).filter(is_unseen).fold(0, |all, s| all | 1 << (s % 64));
    }
    unseen
}
