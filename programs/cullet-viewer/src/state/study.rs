//! The settings of the study of back faces.

use cullet_mesh::MaskGrid;
use serde::{Deserialize, Serialize};

/// The most groups of triangles with a mask each.
pub const MOST_GROUPS: u32 = 1_024;

/// Bound that culls back faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum By {
    /// None is studied.
    #[default]
    None,
    /// Normal masks: a bit for each class of directions, a mask for each group of triangles.
    Masks,
    /// A round cone of normals for each cluster.
    Cones,
    /// An elliptic cone for each cluster.
    Elliptic,
    /// A box around the normals of each cluster.
    Boxes,
    /// A pyramid of four sides for each cluster.
    Pyramids,
}

impl By {
    /// All of them, with what a menu says.
    pub const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::None, "off", "Nothing is studied."),
        (
            Self::Masks,
            "normal masks",
            "One bit for each class of normals, and a mask for each group of triangles.",
        ),
        (
            Self::Cones,
            "round cones",
            "The cone around the normals of each cluster, as most engines have it.",
        ),
        (
            Self::Elliptic,
            "elliptic cones",
            "A cone that is wider one way: what this library culls clusters by.",
        ),
        (
            Self::Boxes,
            "normal boxes",
            "The box around the normals of each cluster, as in clustered back-face culling.",
        ),
        (Self::Pyramids, "pyramids", "Four planes around the normals of each cluster."),
    ];
}

/// Settings of the study of back faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Study {
    /// Whether the cube of directions is shown.
    pub cube: bool,
    /// Cells along an edge of the cube.
    pub cells: u32,
    /// Into how many groups the triangles of the inspected instance are put for masks.
    pub groups: u32,
    /// Bound that is studied.
    pub by: By,
}

impl Default for Study {
    fn default() -> Self {
        Self { cube: false, cells: 8, groups: 16, by: By::None }
    }
}

impl Study {
    /// Checks every number; the error names the invalid one, its value, and what it must be.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        if !(1..=MaskGrid::MAX_CELLS).contains(&self.cells) {
            return Err(("study.cells", f64::from(self.cells), "between 1 and 18"));
        }
        if !(1..=MOST_GROUPS).contains(&self.groups) {
            return Err(("study.groups", f64::from(self.groups), "between 1 and 1024"));
        }
        Ok(())
    }
}
