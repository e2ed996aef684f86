//! A row of the table: one workload at one SIMD level, and what its time is held against.

use std::fmt;

use serde::Serialize;

/// One workload at one SIMD level.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Like `frustum/boxes/1e5/30%`: what, how many, how much of it is visible.
    pub name: String,
    /// The SIMD level.
    pub level: &'static str,
    /// How many items.
    pub items: usize,
    /// How many of them are visible.
    pub visible: usize,
    /// Time an item, of the fastest pass.
    pub ns_per_item: f64,
    /// The time that this one is compared with.
    #[serde(flatten)]
    pub yardstick: Yardstick,
    /// Whether the answer was that of the scalar oracle.
    pub checked: bool,
    /// Another way to the same answer in the same run, and how many times its time is this one's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub versus: Option<(&'static str, f64)>,
}

/// Yardstick of a time.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Yardstick {
    /// Reading what must be read.
    Streaming {
        /// Bytes that must be read for an item.
        bytes_per_item: usize,
        /// Time to read those bytes at the best level in the same run.
        limit_ns_per_item: f64,
        /// The two times' ratio: 1 is the fastest that can be.
        limit_ratio: f64,
    },
    /// Another way to do the same, or half as much, timed in turns with it.
    Other {
        /// Which.
        ratio_to: String,
        /// The two times' ratio: below 1 is faster than the other.
        ratio: f64,
    },
}

/// A row of the table but for its times.
#[derive(Clone, Debug)]
pub(super) struct Workload {
    /// Value of [`Measured::name`].
    pub(super) name: String,
    /// Value of [`Measured::level`].
    pub(super) level: &'static str,
    /// Value of [`Measured::items`].
    pub(super) items: usize,
    /// Value of [`Measured::visible`].
    pub(super) visible: usize,
    /// Value of [`Measured::checked`].
    pub(super) checked: bool,
}

impl Workload {
    /// Compares the workload's time with the time of reading `bytes` for each item, in nanoseconds
    /// for all items.
    pub(super) fn streaming(self, bytes: usize, [limit, time]: [f64; 2]) -> Measured {
        let yardstick = Yardstick::Streaming {
            bytes_per_item: bytes,
            limit_ns_per_item: limit / self.items as f64,
            limit_ratio: time / limit,
        };
        self.measured(time, yardstick)
    }

    /// Compares the workload's time with the time of another way, in nanoseconds for all items.
    pub(super) fn against(self, [other, time]: [f64; 2], ratio_to: &str) -> Measured {
        let yardstick = Yardstick::Other { ratio_to: ratio_to.to_owned(), ratio: time / other };
        self.measured(time, yardstick)
    }

    fn measured(self, time: f64, yardstick: Yardstick) -> Measured {
        let Self { name, level, items, visible, checked } = self;
        let ns_per_item = time / items as f64;
        Measured { name, level, items, visible, ns_per_item, yardstick, checked, versus: None }
    }
}

#[cfg(test)]
impl Yardstick {
    /// How many times as long as what it is held against.
    pub(super) fn ratio(&self) -> f64 {
        match self {
            Self::Streaming { limit_ratio: ratio, .. } | Self::Other { ratio, .. } => *ratio,
        }
    }
}

impl Measured {
    /// The heading of [`Display`](fmt::Display)'s columns, which depend on the yardstick.
    pub fn heading(&self) -> &'static str {
        match self.yardstick {
            Yardstick::Streaming { .. } => {
                "workload                               level   ns/item  bytes  streaming GB/s  x limit  checked"
            }
            Yardstick::Other { .. } => {
                "workload                               level         ms  visible  checked  times another"
            }
        }
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let checked = if self.checked { "yes" } else { "NO" };
        let ms = self.ns_per_item * self.items as f64 * 1e-6;
        match &self.yardstick {
            Yardstick::Streaming { bytes_per_item, limit_ns_per_item, limit_ratio } => write!(
                f,
                "{:<38} {:<7} {:>7.3} {:>6} {:>15.1} {:>8.2}  {checked}",
                self.name,
                self.level,
                self.ns_per_item,
                bytes_per_item,
                *bytes_per_item as f64 / limit_ns_per_item,
                limit_ratio,
            )?,
            Yardstick::Other { ratio_to, ratio } => write!(
                f,
                "{:<38} {:<7} {ms:>8.3} {:>8}  {checked:<7}  {ratio:.3} x {ratio_to}",
                self.name, self.level, self.visible,
            )?,
        }
        self.versus.map_or(Ok(()), |(name, times)| write!(f, "      {times:.1} x {name}"))
    }
}
