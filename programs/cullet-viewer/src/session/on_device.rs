//! The graphics device as one that decides what is drawn.

use super::Session;
use crate::draw::DeviceFigures;

/// State of the device's decision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviceStatus {
    /// Why it cannot decide, if it cannot.
    pub refused: Option<String>,
    /// Whether it has what it decides with of the scene that is shown.
    pub ready: bool,
    /// Whether figures of the picture are still on their way.
    pub awaited: bool,
    /// Figures of its newest decision that is known.
    pub figures: DeviceFigures,
}

impl Session {
    /// Whether the graphics device decides what is drawn.
    #[must_use]
    pub fn by_device(&self) -> bool {
        // On a page it never does, and need not load what would tell of it.
        cfg!(not(target_arch = "wasm32"))
            && self.state.device.on
            && self.state.stages.on
            && self.device.ready
    }
}
