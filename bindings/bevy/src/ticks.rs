//! Changes since a system ran last, asked of many rows of a table at once.

use bevy_ecs::change_detection::{MAX_CHANGE_AGE, Tick};
use bevy_ecs::system::SystemChangeTick;

/// How many rows are asked at once.
pub(crate) const ROWS: usize = 64;

/// How many rows are asked first whether any of them changed at all.
pub(crate) const RUN: usize = 16 * ROWS;

/// From how many rows on a table is worth being shared out to threads, where little is asked of
/// each.
pub(crate) const MANY: usize = 1 << 17;

/// The time since a system ran last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since {
    now: u32,
    age: u32,
}

impl Since {
    pub(crate) fn new(ticks: &SystemChangeTick) -> Self {
        let (now, last) = (ticks.this_run().get(), ticks.last_run().get());
        Self { now, age: now.wrapping_sub(last).min(MAX_CHANGE_AGE) }
    }

    /// [`Tick::is_newer_than`], without what is the same for all.
    #[inline(always)]
    fn holds(self, tick: Tick) -> bool {
        self.now.wrapping_sub(tick.get()) < self.age
    }

    /// Whether any of the rows changed.
    #[inline]
    pub(crate) fn any(self, rows: &[Tick]) -> bool {
        // Without a way out: so the compiler takes several rows at once.
        rows.iter().fold(0, |any, &tick| any | u32::from(self.holds(tick))) != 0
    }

    /// One bit a row: it changed. At most [`ROWS`] rows.
    #[inline]
    pub(crate) fn bits(self, rows: &[Tick]) -> u64 {
        rows.iter()
            .enumerate()
            .fold(0, |bits, (row, &tick)| bits | u64::from(self.holds(tick)) << row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_newer_is_what_bevy_takes_for_newer() {
        let numbers = [0, 1, 5, 6, 7, 1 << 20, MAX_CHANGE_AGE - 1, MAX_CHANGE_AGE, u32::MAX];
        for (&last, &now) in numbers.iter().flat_map(|a| numbers.iter().map(move |b| (a, b))) {
            let since = Since { now, age: now.wrapping_sub(last).min(MAX_CHANGE_AGE) };
            for tick in numbers.map(Tick::new) {
                let expected = tick.is_newer_than(Tick::new(last), Tick::new(now));
                assert_eq!(since.holds(tick), expected, "{tick:?} {last} {now}");
                assert_eq!(since.any(&[tick]), expected);
                assert_eq!(since.bits(&[Tick::new(last), tick]) >> 1, u64::from(expected));
            }
        }
    }
}
