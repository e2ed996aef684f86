//! A unit of work: some lines, their numbers drawn from a hash of what they are, and what they found.
//!
//! Lines without an aim tell how much is missing; lines to things that were drawn by lot find the small ones; and what was
//! found is followed up, to what is beside it and to the cells around (after Wonka et al., *Guided Visibility Sampling*,
//! 2006, and Bittner et al., *Adaptive Global Visibility Sampling*, 2009).

use std::collections::HashMap;

use glam::DVec3;

use super::cells::ViewCells;
use super::line::{Finder, Sighting, Tracer};
use super::split::direction;
use super::tree::RayTree;
use crate::random::Random;
use crate::rows::{BitRows, has};

/// Lines of a unit that follows nothing up.
pub(super) const LINES: u32 = 512;

/// Lines past the border of what was found.
const BORDER_LINES: u32 = 4;

/// Cells beside the one from where it was found, that are tried.
const TRIED_CELLS: usize = 6;

/// Something that a cell was not known to see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Discovery {
    pub(super) cell: u32,
    pub(super) target: u32,
    pub(super) at: DVec3,
    pub(super) eye: DVec3,
}

/// What a unit does.
#[derive(Clone, Debug)]
pub(super) enum Work {
    /// Lines from random points of random cells, any way.
    Free,
    /// Lines to random points of random targets.
    Aimed,
    /// What was found before is followed up.
    Follow(Vec<Discovery>),
}

/// What is known while a round runs; nobody changes it meanwhile.
#[derive(Debug)]
pub(super) struct Known<'a> {
    pub(super) tree: &'a RayTree<'a>,
    pub(super) cells: &'a ViewCells,
    /// Of each cell those that touch it.
    pub(super) beside: &'a [Vec<u32>],
    pub(super) visible: &'a BitRows,
    /// What was seen by one line without an aim, and by none with one before.
    pub(super) once: &'a BitRows,
    pub(super) open: &'a [bool],
}

/// What a unit found.
#[derive(Debug, Default)]
pub(super) struct Findings {
    /// What cells see that was new, or seen once; with how many lines without an aim saw it.
    pub(super) seen: Vec<(Discovery, u32)>,
    /// How often each cell was looked from by lines without an aim; empty for none.
    pub(super) looks: Vec<u32>,
    /// Cells with a point out of all that is solid, not known before.
    pub(super) open: Vec<u32>,
    pub(super) rays: u64,
}

struct Collector<'a> {
    known: &'a Known<'a>,
    free: bool,
    places: HashMap<(u32, u32), usize>,
    found: Findings,
}

impl Finder for Collector<'_> {
    fn look(&mut self, cell: u32) {
        if self.free {
            self.found.looks[cell as usize] += 1;
        }
    }

    fn see(&mut self, Sighting { cell, target, at, eye }: Sighting) {
        let is_known = has(self.known.visible.row(cell), target);
        if is_known && !(self.free && has(self.known.once.row(cell), target)) {
            return;
        }
        let new = self.found.seen.len();
        let place = *self.places.entry((cell, target)).or_insert(new);
        if place == new {
            self.found.seen.push((Discovery { cell, target, at, eye }, 0));
        }
        self.found.seen[place].1 += u32::from(self.free);
    }
}

impl Known<'_> {
    /// Does a unit, by random numbers of its own.
    pub(super) fn run(&self, work: &Work, random: &mut Random, tracer: &mut Tracer) -> Findings {
        let free = matches!(work, Work::Free);
        let looks = if free { vec![0; self.cells.len() as usize] } else { Vec::new() };
        let found = Findings { looks, ..Findings::default() };
        let mut collector = Collector { known: self, free, places: HashMap::new(), found };
        let mut trace = |from: DVec3, direction: DVec3| {
            if direction.length_squared() == 0.0 {
                return false;
            }
            collector.found.rays += 2;
            tracer.trace(self.tree, self.cells, from, direction, &mut collector)
        };
        let mut open = Vec::new();
        match work {
            Work::Free => {
                for _ in 0..LINES {
                    let cell = random.below(self.cells.len());
                    if trace(self.point_in(cell, random), direction(random))
                        && !self.open[cell as usize]
                    {
                        open.push(cell);
                    }
                }
            }
            Work::Aimed => {
                for k in 0..LINES {
                    let target = random.below(self.tree.targets().count());
                    let Some(at) = self.tree.point_of(target, random) else { continue };
                    if k % 2 == 0 {
                        let from = self.point_in(random.below(self.cells.len()), random);
                        trace(from, (at - from).normalize_or_zero());
                    } else if let Some(ball) = self.tree.ball(target) {
                        // A little off the surface, on the one side or the other.
                        let way = direction(random);
                        trace(at + way * (ball.radius * 1e-4), way);
                    }
                }
            }
            Work::Follow(list) => {
                for discovery in list {
                    self.follow(discovery, random, &mut trace);
                }
            }
        }
        Findings { open, ..collector.found }
    }

    fn follow(
        &self,
        found: &Discovery,
        random: &mut Random,
        trace: &mut impl FnMut(DVec3, DVec3) -> bool,
    ) {
        let &Discovery { cell, target, at, eye } = found;
        let mut aim = |from: DVec3, to: DVec3| trace(from, (to - from).normalize_or_zero());
        let distance = eye.distance(at);
        let ball = self.tree.ball(target);
        for k in 0..BORDER_LINES {
            let aside = direction(random);
            let to = match ball {
                // Just past its outline, as far as that is a ball's; then near where it was hit.
                Some(ball) if k % 2 == 0 => {
                    ball.center + aside * (ball.radius * (0.8 + 0.4 * random.unit()))
                }
                _ => at + aside * (distance * 0.1 * random.unit()),
            };
            aim(eye, to);
        }
        let from = self.point_in(cell, random);
        aim(from, self.tree.point_of(target, random).unwrap_or(at));
        let beside = &self.beside[cell as usize];
        let first = random.below(beside.len().max(1) as u32) as usize;
        let without = (0..beside.len()).map(|k| beside[(first + k) % beside.len()]);
        let without = without.filter(|&n| !has(self.visible.row(n), target));
        for (k, other) in without.take(TRIED_CELLS).enumerate() {
            let to = if k % 2 == 0 { Some(at) } else { self.tree.point_of(target, random) };
            let from = self.point_in(other, random);
            aim(from, to.unwrap_or(at));
        }
    }

    fn point_in(&self, cell: u32, random: &mut Random) -> DVec3 {
        let [low, high] = self.cells.boxes()[cell as usize];
        low + (high - low) * DVec3::from(random.three())
    }
}
