//! The links of a frame, and how the work of one is doubled.

use serde::Serialize;

/// A link of the chain that a frame goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Link {
    /// Pixels: doubled by a picture of twice the area, of the same view and the same draws.
    Fill,
    /// Triangles and their vertices: doubled by drawing all again where no pixel passes the depth
    /// test.
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
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fill => "fill",
            Self::Transform => "transform",
            Self::Bus => "bus",
            Self::Cpu => "cpu",
        }
    }
}

/// A way to make a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The plain frame.
    Plain,
    /// The frame with the work of a link doubled.
    Doubled(Link),
    /// The frame with each draw again, of no instance: the cost of recording and handing in the
    /// draws of a doubled [transform](Link::Transform), which is not its own work.
    EmptyDraws,
    /// The frame with each draw again into a single pixel: the vertices alone of a doubled
    /// transform.
    VerticesAgain,
    /// The frame with another culler, by its number.
    Culled(usize),
}

impl Way {
    /// Whether a link's work is doubled.
    #[must_use]
    pub fn doubles(self, link: Link) -> bool {
        self == Self::Doubled(link)
    }

    /// How many instances draws that follow the frame's own have, of so many; `None` where there
    /// are no such draws.
    #[must_use]
    pub fn again(self, instances: u32) -> Option<u32> {
        match self {
            Self::Doubled(Link::Transform) | Self::VerticesAgain => Some(instances),
            Self::EmptyDraws => Some(0),
            _ => None,
        }
    }
}
