//! One line, and what every cell that it passes sees along it.

use glam::DVec3;

use super::cells::{Stay, ViewCells};
use super::tree::{Passed, RayTree};

/// Target that an eye in a cell sees along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sighting {
    pub(super) cell: u32,
    pub(super) target: u32,
    /// Where on the target.
    pub(super) at: DVec3,
    /// Where the eye may be.
    pub(super) eye: DVec3,
}

/// Buffers that lines use again and again.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    ahead: Vec<Passed>,
    behind: Vec<Passed>,
    stays: Vec<Stay>,
    /// Where on the line, what, and whether who looks along and against the line sees it.
    passed: Vec<(f64, u32, [bool; 2])>,
}

/// Receiver of what is found along a line.
pub(super) trait Finder {
    /// An eye in a cell looked along the line once, whether it saw anything or not.
    fn look(&mut self, cell: u32);
    /// It saw something.
    fn see(&mut self, sighting: Sighting);
}

impl Tracer {
    /// Follows a line from a point to what stops it, or both ways: one ray or two. Whether the
    /// point is out of all that is solid, as far as these tell, and how far ahead the line goes.
    pub(super) fn trace(
        &mut self,
        tree: &RayTree<'_>,
        cells: &ViewCells,
        (from, direction): (DVec3, DVec3),
        both: bool,
        finder: &mut impl Finder,
    ) -> (bool, f64) {
        let ahead = tree.cast(from, direction, &mut self.ahead);
        let mut open = ahead.open;
        self.behind.clear();
        let (mut first, mut behind) = (0.0, None);
        if both {
            let cast = tree.cast(from, -direction, &mut self.behind);
            open |= cast.open;
            (first, behind) = (-cast.end(), Some(cast));
        }
        let last = ahead.end();
        cells.along(from, direction, [first, last], &mut self.stays);
        // Shorter stays than this are rounding.
        let Some(extent) =
            self.stays.iter().map(|s| s.enter.abs().max(s.leave.abs())).reduce(f64::max)
        else {
            return (open, last);
        };
        let least = extent * 1e-9;
        self.passed.clear();
        self.passed.extend(self.ahead.iter().map(|p| (p.distance, p.target, p.seen)));
        let turned = |p: &Passed| (-p.distance, p.target, [p.seen[1], p.seen[0]]);
        self.passed.extend(self.behind.iter().map(turned));
        // One-sided faces that the ray behind passed from their backs stop who looks along the line
        // from beyond them, and those that the ray ahead passed who looks back.
        let along_from =
            behind.and_then(|cast| cast.back).map_or(f64::NEG_INFINITY, |b| -b.distance);
        let against_to = ahead.back.map_or(f64::INFINITY, |b| b.distance);
        let ends = [
            ahead.hit.map(|h| (h.distance, h.target)),
            behind.and_then(|cast| cast.hit).map(|h| (-h.distance, h.target)),
        ];
        for stay in &self.stays {
            let ranges = [
                [stay.enter.max(along_from), stay.leave],
                [stay.enter, stay.leave.min(against_to)],
            ];
            for (way, [low, high]) in ranges.into_iter().enumerate() {
                if high - low <= least {
                    continue;
                }
                finder.look(stay.cell);
                let mut see = |place: f64, target: u32, low: f64, high: f64| {
                    let (at, eye) =
                        (from + direction * place, from + direction * ((low + high) * 0.5));
                    finder.see(Sighting { cell: stay.cell, target, at, eye });
                };
                if let Some((place, target)) = ends[way] {
                    see(place, target, low, high);
                }
                for &(place, target, seen) in &self.passed {
                    let (low, high) =
                        if way == 0 { (low, high.min(place)) } else { (low.max(place), high) };
                    if seen[way] && high - low > least {
                        see(place, target, low, high);
                    }
                }
            }
        }
        (open, last)
    }
}
