//! The plan of a round: which units it has, from what is known when it begins.

use std::collections::VecDeque;

use super::edit::Edit;
use super::unit::{Discovery, LINES, Work};

/// Discoveries that a unit follows up.
pub(super) const FOLLOWED: usize = 64;

/// Rays that following one up takes, about; and those of a sweep of a cell that was never swept.
const RAYS_FOLLOWED: u64 = 18;
pub(super) const RAYS_SWEPT: u64 = 256;
/// Rays of a line around which is looked, where nothing is known: its own, and one to each target
/// beside what it meets.
pub(super) const RAYS_AROUND: u64 = 9;

/// Rays of a round: so many at least, and this part of all before. Rounds know nothing of what is
/// found meanwhile, so that large ones find the same again; small ones make threads wait and leave
/// many files.
const LEAST: u64 = 100_000;
const GROWTH: u64 = 16;

/// Shares of the rays of a round, in hundredths: at least these for lines without an aim, for lines
/// to targets by lot, and for lines around what is met; at most this for those that follow up.
/// Sweeps get what is left.
const FREE: u64 = 8;
const AIMED: u64 = 2;
const AIMED_AT_NEW: u64 = 12;
const AROUND: u64 = 55;
const FOLLOWING: u64 = 20;

/// Results of the sweeps of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sweep {
    /// How many there were.
    pub(super) times: u32,
    /// Rays of the last, and what was new, by weight.
    rays: u64,
    found: f64,
}

impl Sweep {
    /// Notes one more.
    pub(super) fn end(&mut self, rays: u64, found: f64) {
        *self = Self { times: self.times + 1, rays, found };
    }

    /// Returns the expected cost of the next sweep.
    fn cost(&self) -> u64 {
        if self.times == 0 { RAYS_SWEPT } else { self.rays.max(1) }
    }

    /// Returns the expected yield of the next sweep per ray; cells that were never swept come
    /// first.
    fn score(&self) -> f64 {
        match (self.times, self.rays) {
            (0, _) => f64::INFINITY,
            // A cell without a border costs nothing and finds nothing.
            (_, 0) => 0.0,
            (_, rays) => (self.found + 1.0) / (rays as f64 + 1.0),
        }
    }
}

impl Work {
    /// Rays that it is expected to take.
    pub(super) fn rays(&self, sweeps: &[Sweep], rays_around: u64) -> u64 {
        let lines = u64::from(LINES);
        match self {
            Self::Free => lines * 2,
            Self::Aimed => lines,
            Self::Around => lines * rays_around,
            Self::Follow(some) => some.len() as u64 * RAYS_FOLLOWED,
            Self::Sweep(cell) => sweeps[*cell as usize].cost(),
        }
    }

    /// How long it is expected to take, in rays without an aim, to cut rounds into even units: as
    /// measured on the built-in city. `rays_swept` is what sweeps took of late.
    pub(super) fn time(&self, sweeps: &[Sweep], rays_around: u64, rays_swept: u64) -> f64 {
        let rays = self.rays(sweeps, rays_around) as f64;
        match self {
            Self::Free | Self::Aimed => rays,
            Self::Follow(_) => rays * 1.1,
            Self::Around => rays * 1.6,
            Self::Sweep(cell) if sweeps[*cell as usize].times == 0 => rays_swept as f64 * 1.4,
            // Since its last sweep more is known to be seen, and so its border is longer by two
            // fifths.
            Self::Sweep(_) => rays * 1.4 * 1.4,
        }
    }
}

/// Discoveries that wait to be followed up: those that matter more come first, by the halves of
/// their weight.
#[derive(Debug)]
pub(super) struct Waiting {
    classes: [VecDeque<Discovery>; 16],
    count: usize,
}

/// Discoveries that wait; more are not. They take a quarter of a GiB.
const WAITING: usize = 1 << 23;

impl Waiting {
    pub(super) fn new() -> Self {
        Self { classes: std::array::from_fn(|_| VecDeque::new()), count: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The class of a weight of 0 to 1: how often it must be doubled.
    fn class(weight: f64) -> usize {
        let mut class = 0;
        let mut weight = weight;
        while weight < 1.0 && class < 15 {
            weight *= 2.0;
            class += 1;
        }
        class
    }

    pub(super) fn push(&mut self, discovery: Discovery, weight: f64) {
        if self.count < WAITING {
            self.classes[Self::class(weight)].push_back(discovery);
            self.count += 1;
        }
    }

    /// Takes the first of those that matter most; so many at the most.
    fn take(&mut self, most: usize) -> Vec<Discovery> {
        let mut taken = Vec::new();
        for class in &mut self.classes {
            let some = class.len().min(most - taken.len());
            taken.extend(class.drain(..some));
        }
        self.count -= taken.len();
        taken
    }
}

/// The units of the next round: what waits to be followed up is taken from the list, and the cells
/// whose last sweep found most are swept. `rays_around` is what a line around which is looked took
/// in the round before.
pub(super) fn plan(
    rays: u64,
    rays_around: u64,
    waiting: &mut Waiting,
    sweeps: &[Sweep],
    edit: Option<&Edit>,
) -> Vec<Work> {
    let size = LEAST.max(rays / GROWTH);
    let part = |hundredths: u64| size * hundredths / 100;
    let aimed = match edit {
        Some(edit) if edit.targets.is_empty() => 0,
        Some(edit) if edit.eyes().is_empty() => 100 - FREE - AROUND,
        Some(_) => AIMED_AT_NEW,
        None => AIMED,
    };
    let mut left = size - part(FREE) - part(aimed) - part(AROUND);
    let mut units = Vec::new();
    let most = part(FOLLOWING) / RAYS_FOLLOWED;
    let following = (waiting.len() as u64).min(most) as usize;
    left -= left.min(following as u64 * RAYS_FOLLOWED);
    let taken = waiting.take(following);
    units.extend(taken.chunks(FOLLOWED).map(|some| Work::Follow(some.to_vec())));
    let mut order: Vec<u32> = match edit {
        Some(edit) => edit.eyes().to_vec(),
        None => (0..sweeps.len() as u32).collect(),
    };
    order.sort_by(|&a, &b| {
        let [of_a, of_b] = [a, b].map(|cell| sweeps[cell as usize].score());
        of_b.total_cmp(&of_a).then(a.cmp(&b))
    });
    for cell in order {
        let cost = sweeps[cell as usize].cost();
        if left == 0 {
            break;
        }
        left -= left.min(cost);
        units.push(Work::Sweep(cell));
    }
    // What nobody else needs.
    let lines = u64::from(LINES);
    let count = |rays: u64, of_a_line: u64| rays.div_ceil(lines * of_a_line) as usize;
    let free = count(part(FREE) + left / 4, 2);
    let aimed = count(part(aimed), 1);
    let around = count(part(AROUND) + left - left / 4, rays_around);
    units.extend(std::iter::repeat_n(Work::Free, free));
    units.extend(std::iter::repeat_n(Work::Aimed, aimed));
    units.extend(std::iter::repeat_n(Work::Around, around));
    units
}
