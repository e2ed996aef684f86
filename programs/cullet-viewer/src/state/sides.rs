//! The switch over what a file says of the sides of its triangles.

use serde::{Deserialize, Serialize};

/// Sides that a scene's triangles are taken to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Sides that the file declares; where its format says nothing, solids have one and all else
    /// has two.
    #[default]
    Automatic,
    /// One, whatever the file says: a back that is in sight is then dropped.
    OneSided,
    /// Two, whatever the file says: no back face is culled.
    TwoSided,
}

impl Sides {
    /// All of them, with what a menu says.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (
            Self::Automatic,
            "automatic",
            "As the file declares; where it says nothing, solids are one-sided and all else is two-sided",
        ),
        (
            Self::OneSided,
            "one-sided",
            "Every triangle has a front alone, whatever the file says: for scans with small holes, whose insides nobody \
             sees. Where a back is in sight the picture changes",
        ),
        (
            Self::TwoSided,
            "two-sided",
            "Every triangle is drawn from both sides, whatever the file says: no back face is culled",
        ),
    ];

    /// The same as [`cullet_io::LoadOptions::two_sided`] has it.
    #[must_use]
    pub fn two_sided(self) -> Option<bool> {
        match self {
            Self::Automatic => None,
            Self::OneSided => Some(false),
            Self::TwoSided => Some(true),
        }
    }
}

/// Differences of a scene from its file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Alteration {
    /// Sides that its triangles are taken to have.
    pub sides: Sides,
    /// Portals, ascending, that are shut though the file has them open, or the other way around.
    pub doors: Vec<u32>,
}
