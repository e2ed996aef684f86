//! A unit of work: some lines, their numbers drawn from a hash of what they are, and what they
//! found.
//!
//! Lines without an aim tell how much is missing; lines to things that were drawn by lot find the
//! small ones; what was found is followed up, past its outline, to what stands beside it and to the
//! cells around (after Wonka et al., *Guided Visibility Sampling*, 2006, and Bittner et al.,
//! *Adaptive Global Visibility Sampling*, 2009); and the border between what a cell sees and what
//! it is not known to see is swept again and again.

use std::collections::HashMap;

use glam::DVec3;

use super::cells::ViewCells;
use super::edit::Edit;
use super::line::{Finder, Sighting, Tracer};
use super::near::NearTargets;
use super::split::direction;
use super::tree::RayTree;
use crate::rows::{BitRows, has, ones, set};
use cullet_draw::Random;

/// Lines of a unit that follows nothing up.
pub(super) const LINES: u32 = 512;

/// Lines past the border of what was found.
const BORDER_LINES: u32 = 4;

/// Cells beside the one from where it was found, and targets beside it, that are tried.
const TRIED_CELLS: usize = 12;
const TRIED_TARGETS: usize = 6;

/// The solid angle from which on all things matter alike: a fifth of a pixel of the pictures that
/// check sets. What is smaller matters as it is larger, for the less often does a picture show it;
/// but never less than this.
const WHOLE_WEIGHT: f64 = 1e-4;
const LEAST_WEIGHT: f64 = 1.0 / 64.0;

/// Something that a cell was not known to see. It waits by the million, and is written to files: so
/// the two ends of the line are kept roughly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Discovery {
    pub(super) cell: u32,
    pub(super) target: u32,
    /// Where on the target, from the middle of the ball around it, in radii of that.
    pub(super) at: [f32; 3],
    /// Where the eye may be: along each side of the cell, in parts of 65,535.
    pub(super) eye: [u16; 3],
}

/// Work of a unit.
#[derive(Clone, Debug)]
pub(super) enum Work {
    /// Lines from random points of random cells, any way.
    Free,
    /// Lines to random points of random targets.
    Aimed,
    /// Lines from random points of random cells, any way; and from there to what stands beside that
    /// which they meet, and is not known to be seen.
    Around,
    /// Follows up earlier discoveries.
    Follow(Vec<Discovery>),
    /// From a cell to all that it is not known to see, and cells beside it do, or it sees what is
    /// beside.
    Sweep(u32),
}

/// Knowledge while a round runs, constant during it.
#[derive(Debug)]
pub(super) struct Known<'a> {
    pub(super) tree: &'a RayTree<'a>,
    pub(super) cells: &'a ViewCells,
    /// Cells that touch each cell.
    pub(super) beside: &'a [Vec<u32>],
    pub(super) near: &'a NearTargets,
    pub(super) visible: &'a BitRows,
    /// How each cell came to see what it sees, as far as that is kept.
    pub(super) witnesses: &'a [Vec<Discovery>],
    pub(super) open: &'a [bool],
    /// Lines keep to what it changed.
    pub(super) edit: Option<&'a Edit>,
}

/// Findings of a unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Findings {
    /// New discoveries of what cells see, each with the number of lines without an aim that saw it.
    pub(super) seen: Vec<(Discovery, u32)>,
    /// How often cells were looked from by lines without an aim; by cell, ascending.
    pub(super) looks: Vec<(u32, u32)>,
    /// Cells with a point out of all that is solid, not known before.
    pub(super) open: Vec<u32>,
    pub(super) rays: u64,
}

struct Collector<'a> {
    known: &'a Known<'a>,
    free: bool,
    looks: Vec<u32>,
    places: HashMap<(u32, u32), usize>,
    found: Findings,
}

impl Finder for Collector<'_> {
    fn look(&mut self, cell: u32) {
        if self.free {
            self.looks[cell as usize] += 1;
        }
    }

    fn see(&mut self, Sighting { cell, target, at, eye }: Sighting) {
        if has(self.known.visible.row(cell), target) {
            return;
        }
        let new = self.found.seen.len();
        let place = *self.places.entry((cell, target)).or_insert(new);
        if place == new {
            self.found.seen.push((self.known.discovery(cell, target, at, eye), 0));
        }
        self.found.seen[place].1 += u32::from(self.free);
    }
}

/// Lines of a unit, and what they find.
struct Lines<'a, 'b> {
    collector: Collector<'a>,
    tracer: &'b mut Tracer,
}

impl Lines<'_, '_> {
    /// A line both ways. Whether the point is out of all that is solid.
    fn both(&mut self, from: DVec3, direction: DVec3) -> bool {
        self.trace(from, direction, true).0
    }

    /// A line from one point to another and on.
    fn aim(&mut self, from: DVec3, to: DVec3) {
        self.trace(from, (to - from).normalize_or_zero(), false);
    }

    fn trace(&mut self, from: DVec3, direction: DVec3, both: bool) -> (bool, f64) {
        if direction.length_squared() == 0.0 {
            return (false, f64::INFINITY);
        }
        let known = self.collector.known;
        self.collector.found.rays += 1 + u64::from(both);
        self.tracer.trace(known.tree, known.cells, (from, direction), both, &mut self.collector)
    }
}

impl Known<'_> {
    /// Does a unit, by random numbers of its own.
    pub(super) fn run(&self, work: &Work, random: &mut Random, tracer: &mut Tracer) -> Findings {
        let free = matches!(work, Work::Free);
        let looks = if free { vec![0; self.cells.len() as usize] } else { Vec::new() };
        let found = Findings::default();
        let collector = Collector { known: self, free, looks, places: HashMap::new(), found };
        let mut lines = Lines { collector, tracer };
        let mut open = Vec::new();
        match work {
            Work::Free => {
                for _ in 0..LINES {
                    let Some(cell) = self.eye(random) else { break };
                    if lines.both(self.point_in(cell, random), direction(random))
                        && !self.open[cell as usize]
                    {
                        open.push(cell);
                    }
                }
            }
            Work::Aimed => {
                for k in 0..LINES {
                    let target = match self.edit {
                        Some(edit) => {
                            edit.targets[random.below(edit.targets.len() as u32) as usize]
                        }
                        None => random.below(self.tree.targets().count()),
                    };
                    let Some(at) = self.tree.point_of(target, random) else { continue };
                    if k % 2 == 0 {
                        let cell = random.below(self.cells.len());
                        lines.aim(self.point_in(cell, random), at);
                    } else if let Some(ball) = self.tree.ball(target) {
                        // A little off the surface, on the one side or the other.
                        let way = direction(random);
                        lines.both(at + way * (ball.radius * 1e-4), way);
                    }
                }
            }
            Work::Around => {
                for _ in 0..LINES {
                    self.around(random, &mut lines);
                }
            }
            Work::Follow(list) => {
                for discovery in list {
                    self.follow(discovery, random, &mut lines);
                }
            }
            Work::Sweep(cell) => {
                let border = self.border(*cell);
                // Small ones now and then.
                let is_due = |target: u32, random: &mut Random| {
                    random.unit() <= self.weight(*cell, target).max(LEAST_WEIGHT)
                };
                // Where a cell beside sees something, this one sees it most likely from near there.
                for &other in &self.beside[*cell as usize] {
                    for witness in &self.witnesses[other as usize] {
                        if has(&border, witness.target) && is_due(witness.target, random) {
                            let (at, eye) = self.ends(witness);
                            lines.aim(self.point_near(*cell, eye, random), at);
                        }
                    }
                }
                for target in ones(&border) {
                    if !is_due(target, random) {
                        continue;
                    }
                    let Some(at) = self.tree.point_of(target, random) else { continue };
                    lines.aim(self.point_in(*cell, random), at);
                }
            }
        }
        let Collector { found, looks, .. } = lines.collector;
        let looks = (0..).zip(looks).filter(|&(_, n)| n > 0).collect();
        Findings { open, looks, ..found }
    }

    /// A cell by lot; after an edit one that sees what changed.
    fn eye(&self, random: &mut Random) -> Option<u32> {
        let Some(edit) = self.edit else { return Some(random.below(self.cells.len())) };
        let eyes = edit.eyes();
        (!eyes.is_empty()).then(|| eyes[random.below(eyes.len() as u32) as usize])
    }

    fn around(&self, random: &mut Random, lines: &mut Lines<'_, '_>) {
        let (cell, eye, way) = match self.edit {
            Some(edit) if edit.view_count() == 0 => return,
            // Through where something changed.
            Some(edit) => {
                let (cell, [low, high]) = edit.view(random.below(edit.view_count()));
                let eye = self.point_in(cell, random);
                let through = low + (high - low) * DVec3::from(random.three());
                (cell, eye, (through - eye).normalize_or_zero())
            }
            None => {
                let cell = random.below(self.cells.len());
                (cell, self.point_in(cell, random), direction(random))
            }
        };
        let (_, far) = lines.trace(eye, way, false);
        if far == f64::INFINITY {
            return;
        }
        let row = self.visible.row(cell);
        for (_, target) in self.near.at(eye + way * far) {
            if has(row, target) {
                continue;
            }
            let Some(to) = self.tree.point_of(target, random) else { continue };
            lines.aim(eye, to);
        }
    }

    fn follow(&self, found: &Discovery, random: &mut Random, lines: &mut Lines<'_, '_>) {
        let &Discovery { cell, target, .. } = found;
        let (at, eye) = self.ends(found);
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
            lines.aim(eye, to);
        }
        let row = self.visible.row(cell);
        for other in self.near.of(target).filter(|&n| !has(row, n)).take(TRIED_TARGETS) {
            let Some(to) = self.tree.point_of(other, random) else { continue };
            lines.aim(eye, to);
        }
        let from = self.point_in(cell, random);
        lines.aim(from, self.tree.point_of(target, random).unwrap_or(at));
        let beside = &self.beside[cell as usize];
        let first = random.below(beside.len().max(1) as u32) as usize;
        let without = (0..beside.len()).map(|k| beside[(first + k) % beside.len()]);
        let without = without.filter(|&n| !has(self.visible.row(n), target));
        // What stands as it stood is no news to a cell that sees nothing of an edit.
        let news = |n: u32| self.edit.is_none_or(|edit| edit.touches(n) || edit.changed(target));
        let without = without.filter(|&n| news(n));
        for (k, other) in without.take(TRIED_CELLS).enumerate() {
            let to = if k % 4 < 3 { Some(at) } else { self.tree.point_of(target, random) };
            let from = self.point_near(other, eye, random);
            lines.aim(from, to.unwrap_or(at));
        }
    }

    /// Returns what a cell is not known to see, though cells beside it do, or it sees something
    /// near it: a bit for each target.
    fn border(&self, cell: u32) -> Vec<u64> {
        let row = self.visible.row(cell);
        let mut border = vec![0; row.len()];
        for &other in &self.beside[cell as usize] {
            border.iter_mut().zip(self.visible.row(other)).for_each(|(b, o)| *b |= o);
        }
        for target in ones(row) {
            self.near.of(target).for_each(|n| set(&mut border, n));
        }
        border.iter_mut().zip(row).for_each(|(b, known)| *b &= !known);
        if let Some(edit) = self.edit {
            border.iter_mut().zip(edit.swept()).for_each(|(b, swept)| *b &= swept);
        }
        border
    }

    /// How much it would matter that a cell's set lacked a target, 0 to 1: by the solid angle that
    /// it can take at the most.
    pub(super) fn weight(&self, cell: u32, target: u32) -> f64 {
        let Some(ball) = self.tree.ball(target) else { return 0.0 };
        let [low, high] = self.cells.boxes()[cell as usize];
        let distance = ball.center.distance_squared(ball.center.clamp(low, high));
        // Of the disc that it shows; 1 where the eye may be in it.
        let angle = ball.radius * ball.radius / distance.max(ball.radius * ball.radius);
        (angle * (std::f64::consts::PI / WHOLE_WEIGHT)).min(1.0)
    }

    fn discovery(&self, cell: u32, target: u32, at: DVec3, eye: DVec3) -> Discovery {
        let [low, high] = self.cells.boxes()[cell as usize];
        let share = ((eye - low) / (high - low)).clamp(DVec3::ZERO, DVec3::ONE);
        let eye = (share * f64::from(u16::MAX)).to_array().map(|v| v as u16);
        let at = match self.tree.ball(target) {
            Some(ball) => ((at - ball.center) / ball.radius.max(f64::MIN_POSITIVE)).to_array(),
            None => [0.0; 3],
        };
        Discovery { cell, target, at: at.map(|v| v as f32), eye }
    }

    /// Where on the target, and where the eye.
    fn ends(&self, of: &Discovery) -> (DVec3, DVec3) {
        let [low, high] = self.cells.boxes()[of.cell as usize];
        let share = DVec3::from(of.eye.map(f64::from)) / f64::from(u16::MAX);
        let eye = low + (high - low) * share;
        let at = self
            .tree
            .ball(of.target)
            .map_or(eye, |ball| ball.center + DVec3::from(of.at.map(f64::from)) * ball.radius);
        (at, eye)
    }

    /// A point of a cell, most likely near another point.
    fn point_near(&self, cell: u32, near: DVec3, random: &mut Random) -> DVec3 {
        let [low, high] = self.cells.boxes()[cell as usize];
        let (nearest, any, away) =
            (near.clamp(low, high), self.point_in(cell, random), random.unit());
        nearest + (any - nearest) * (away * away)
    }

    fn point_in(&self, cell: u32, random: &mut Random) -> DVec3 {
        let [low, high] = self.cells.boxes()[cell as usize];
        low + (high - low) * DVec3::from(random.three())
    }
}
