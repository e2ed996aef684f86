//! Who decides what is drawn, and what is shown of how the graphics device does.

use serde::{Deserialize, Serialize};

/// The graphics device as one that decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnDevice {
    /// Whether it decides in place of the CPU, where it can.
    pub on: bool,
    /// Whether the right part of a wipe is what the CPU decides, rather than everything.
    pub compare: bool,
    /// The level of the depth pyramid that is shown: 0 is half as wide as the picture.
    pub level: u32,
}

impl OnDevice {
    /// Levels of the largest pyramid there is.
    pub const MOST_LEVELS: u32 = 16;

    /// How many levels the pyramid of a picture has.
    #[must_use]
    pub fn levels(size: [u32; 2]) -> u32 {
        let side = size[0].max(size[1]).max(1);
        side.next_power_of_two().ilog2().clamp(1, Self::MOST_LEVELS)
    }

    /// The level that is shown of a picture's pyramid, and its size.
    #[must_use]
    pub fn shown(&self, size: [u32; 2]) -> (u32, [u32; 2]) {
        let level = self.level.min(Self::levels(size) - 1);
        (level, size.map(|side| side.max(1).div_ceil(2 << level)))
    }
}
