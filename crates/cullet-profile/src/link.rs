//! The links of a frame.

use serde::Serialize;

/// A link of the chain that a frame goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Link {
    /// Pixels: doubled by a picture of twice the area, of the same view.
    Fill,
    /// Vertices: doubled by shading each twice.
    Transform,
    /// Uploads: doubled by writing the frame's into another buffer as well.
    Bus,
    /// The program: doubled by culling and recording twice, of which the second is dropped.
    Cpu,
}

impl Link {
    /// All of them, from the far end of the chain.
    pub const ALL: [Self; 4] = [Self::Fill, Self::Transform, Self::Bus, Self::Cpu];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fill => "fill",
            Self::Transform => "transform",
            Self::Bus => "bus",
            Self::Cpu => "cpu",
        }
    }
}
