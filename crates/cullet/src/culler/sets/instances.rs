//! The working set of instances: bits in words of 64 slots.

use alloc::vec::Vec;

use super::super::frame::Frame;
use super::super::log::Log;
use crate::bits;
use crate::bounds::LANES;
use crate::funnel::{Reason, Stage};
use crate::scene::{Scene, Tally};
use crate::sort::sort;

/// Instances that are still there.
///
/// A view mostly sees a small part of a scene, so only the words that hold something are ever
/// looked at, unless reasons are wanted: those are for what is not seen.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Instances {
    /// One bit a slot: still there, and known to be inside the frustum.
    pub(in super::super) alive: Vec<u64>,
    pub(in super::super) inside: Vec<u64>,
    /// The words of the two that are not zero, ascending.
    pub(in super::super) live: Vec<u32>,
}

impl Instances {
    /// Forgets the last view's.
    pub(in super::super) fn clear(&mut self, words: usize) {
        for live in groups(&self.live) {
            // Words between them are zero anyway.
            let range = live[0] as usize..live[live.len() - 1] as usize + 1;
            self.alive[range.clone()].fill(0);
            self.inside[range].fill(0);
        }
        self.live.clear();
        self.alive.resize(words, 0);
        self.inside.resize(words, 0);
    }

    /// Takes the instances of one word: those that are there, in a layer of the view, and not
    /// outside.
    pub(in super::super) fn take(
        &mut self,
        frame: &Frame<'_>,
        word: usize,
        visible: u64,
        inside: u64,
        all_in: bool,
    ) {
        let scene = frame.scene;
        let exempt = scene.exempt()[word];
        let stands_in = scene.stand_ins().map_or(0, |s| s.word(word));
        let mut alive = (visible | exempt) & scene.hierarchy().present()[word] & !stands_in;
        if !all_in {
            for bit in bits::ones(alive) {
                let slot = (word * 64 + bit) as u32;
                if scene.layers(slot) & frame.view.layers == 0 {
                    alive &= !(1 << bit);
                }
            }
        }
        if alive != 0 {
            self.alive[word] = alive;
            self.inside[word] = inside | exempt;
            self.live.push(word as u32);
        }
    }

    /// Takes all words of `group` at once, as [`take`](Self::take) does one word. The caller
    /// ensures that no instance of the group is exempt, stands for others or is in no layer of the
    /// view. `visible` and `inside` have one entry for each word of the group.
    pub(in super::super) fn take_group(
        &mut self,
        scene: &Scene,
        group: usize,
        visible: &[u64],
        inside: &[u64],
    ) {
        let range = group * GROUP..(group + 1) * GROUP;
        let alive = &mut self.alive[range.clone()];
        let present = &scene.hierarchy().present()[range.clone()];
        for ((alive, visible), present) in alive.iter_mut().zip(visible).zip(present) {
            *alive = visible & present;
        }
        self.inside[range.clone()].copy_from_slice(inside);
        if alive.contains(&0) {
            let words = range.filter(|&word| self.alive[word] != 0);
            self.live.extend(words.map(|word| word as u32));
        } else {
            self.live.extend(range.start as u32..range.end as u32);
        }
    }

    /// Takes one slot.
    pub(in super::super) fn take_slot(&mut self, slot: u32, inside: bool) {
        let (word, bit) = (slot as usize / 64, 1 << (slot % 64));
        self.alive[word] = bit;
        self.inside[word] = if inside { bit } else { 0 };
        self.live.push(word as u32);
    }

    /// Takes out a slot that is there.
    pub(in super::super) fn drop_slot(&mut self, slot: u32) {
        self.alive[slot as usize / 64] &= !(1 << (slot % 64));
    }

    /// Puts in slots that were not there, in any order, of which it is not known whether they are
    /// inside the frustum.
    pub(in super::super) fn put_in(&mut self, slots: impl Iterator<Item = u32>) {
        let known = self.live.len();
        for slot in slots {
            let word = slot as usize / 64;
            if self.alive[word] == 0 && self.live[..known].binary_search(&(word as u32)).is_err() {
                self.live.push(word as u32);
            }
            self.alive[word] |= 1 << (slot % 64);
            self.inside[word] &= !(1 << (slot % 64));
        }
        sort(&mut self.live);
    }

    /// Whether the instance of a slot is still there.
    pub(in super::super) fn has(&self, slot: u32) -> bool {
        bits::get(&self.alive, slot as usize)
    }

    /// Drops the instances that `drops` names among those of a word, exempt ones apart; returns
    /// what they hold.
    pub(in super::super) fn filter(
        &mut self,
        scene: &Scene,
        stage: Stage,
        log: &mut Log<'_>,
        mut drops: impl FnMut(usize, u64) -> u64,
    ) -> Tally {
        let (mut sum, mut emptied) = (Tally::default(), false);
        for &word in &self.live {
            let word = word as usize;
            let tested = self.alive[word] & !scene.exempt()[word];
            let dropped = drops(word, tested);
            if dropped == 0 {
                continue;
            }
            self.alive[word] &= !dropped;
            emptied |= self.alive[word] == 0;
            sum += scene.tally_of_bits(word, dropped);
            if log.wants_reasons() {
                slots(word, dropped).for_each(|s| log.drop_slot(s, Reason { stage, detail: 0 }));
            }
        }
        if emptied {
            let (alive, inside) = (&self.alive, &mut self.inside);
            self.live.retain(|&word| {
                let keeps = alive[word as usize] != 0;
                if !keeps {
                    // Words that are not live are zero.
                    inside[word as usize] = 0;
                }
                keeps
            });
        }
        sum
    }

    /// Totals of all instances that are left.
    pub(in super::super) fn tally(&self, scene: &Scene) -> Tally {
        let mut sum = Tally::default();
        for live in groups(&self.live) {
            let words = live[0] as usize..live[live.len() - 1] as usize + 1;
            sum += scene.tally_of_words(words.start, &self.alive[words]);
        }
        sum
    }
}

/// Words of a group: those of the 4,096 slots below one node of 4,096.
pub(in super::super) const GROUP: usize = LANES * LANES * LANES / 64;

/// The live words of each group that has any.
pub(in super::super) fn groups(live: &[u32]) -> impl Iterator<Item = &[u32]> {
    let mut rest = live;
    core::iter::from_fn(move || {
        let group = rest.first()? / GROUP as u32;
        let most = &rest[..rest.len().min(GROUP)];
        // Of what is wide in view most groups are whole, which takes one look.
        let count = match most.last().is_some_and(|w| w / GROUP as u32 == group) {
            true => most.len(),
            false => most.partition_point(|w| w / GROUP as u32 == group),
        };
        let (own, others) = rest.split_at(count);
        rest = others;
        Some(own)
    })
}

/// The slots of the bits that are set in a word.
pub(in super::super) fn slots(word: usize, value: u64) -> impl Iterator<Item = u32> {
    bits::ones(value).map(move |bit| (word * 64 + bit) as u32)
}
