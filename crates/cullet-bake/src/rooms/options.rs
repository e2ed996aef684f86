//! Settings, figures and errors of finding cells.

use cullet::Handle;
use thiserror::Error;

/// Settings of [`find_cells`](super::find_cells). Lengths are in world units; the defaults are for
/// metres.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FindOptions {
    /// Side of a voxel, above 0. It should be no more than half as thick as the walls: walls that
    /// are thinner than a voxel (slanted ones, than 1.7) are open all over. Costs its inverse third
    /// power. Default: half as thick as the thinner walls, and larger where that would be more than
    /// [`AUTO_VOXELS`](Self::AUTO_VOXELS).
    pub voxel: Option<f64>,
    /// Two basins are one cell if the way between them is at least so wide as a share of the
    /// narrower of them, 0 to 1. Lower cuts less. Default 0.75.
    pub merge: f64,
    /// Half the width below which a basin is no room of its own, from 0. Default 0.35.
    pub smallest: f64,
    /// Instances that hide nothing because they move: leafs of doors. Default: none.
    pub ignored: Vec<Handle>,
    /// Instances in none of these layers hide nothing: cells are for views of just these layers.
    /// Default: all.
    pub layers: u32,
}

impl FindOptions {
    /// Most voxels.
    pub const MOST_VOXELS: u64 = 1 << 26;
    /// Most voxels of a size that was not given.
    pub const AUTO_VOXELS: u64 = 12_000_000;

    /// The same with voxels of a given size.
    #[must_use]
    pub fn with_voxel(self, voxel: f64) -> Self {
        Self { voxel: Some(voxel), ..self }
    }

    /// The same with instances that hide nothing.
    #[must_use]
    pub fn with_ignored(self, ignored: Vec<Handle>) -> Self {
        Self { ignored, ..self }
    }
}

impl Default for FindOptions {
    fn default() -> Self {
        Self { voxel: None, merge: 0.75, smallest: 0.35, ignored: Vec::new(), layers: u32::MAX }
    }
}

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FindStep {
    /// Steps that are done.
    pub done: u32,
    /// Count of all steps.
    pub of: u32,
}

/// Figures of cells that were found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FoundFigures {
    /// Side of a voxel, in world units.
    pub voxel: f64,
    /// Voxels along each axis.
    pub counts: [u32; 3],
    /// Voxels that no closed mesh touches or holds: where an eye may be.
    pub free: u64,
    /// Voxels that surfaces of closed meshes touch.
    pub touched: u64,
    /// Voxels wholly within a closed mesh.
    pub solid: u64,
    /// Sides between two touched voxels, and how many of them are proven closed.
    pub sides: [u64; 2],
    /// Instances that are closed, opaque and large enough to hide.
    pub walls: u32,
    /// Instances in all.
    pub instances: u32,
}

/// Why no cells can be found.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RoomsError {
    /// Nothing is closed.
    #[error(
        "none of {instances} instances is a closed, opaque mesh that could be a wall, so no room is closed; \
         `cullet info SCENE --all` lists meshes that are open"
    )]
    NoWalls {
        /// How many instances there are.
        instances: u32,
    },
    /// A setting out of its range.
    #[error("{name} is {value}; it must be {range}")]
    Setting {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Allowed range.
        range: &'static str,
    },
    /// Too many voxels.
    #[error(
        "{} x {} x {} voxels of {voxel:.3e} exceed the limit of {}; try voxels of {fits:.3e} or more",
        Grouped(.counts[0]), Grouped(.counts[1]), Grouped(.counts[2]), Grouped(*limit)
    )]
    TooMany {
        /// Side of a voxel.
        voxel: f64,
        /// Voxels along each axis.
        counts: [u64; 3],
        /// Most voxels.
        limit: u64,
        /// A size that fits.
        fits: f64,
    },
    /// Too many triangles in voxels.
    #[error(
        "walls have so many triangles that {} come into voxels of {voxel:.3}, over the limit of {}; try larger voxels",
        Grouped(*found), Grouped(*limit)
    )]
    TooDense {
        /// How many pairs of triangles and voxels there are.
        found: u64,
        /// Side of a voxel.
        voxel: f64,
        /// Most of them.
        limit: u64,
    },
    /// All that is free hangs together without a narrow place.
    #[error(
        "all {} free voxels of {voxel:.3} are one cell: the scene is open, or its rooms are open to each other as wide \
         as they are, or walls are thinner than a voxel; try smaller voxels",
        Grouped(*free)
    )]
    OneCell {
        /// Free voxels.
        free: u64,
        /// Side of a voxel.
        voxel: f64,
    },
    /// The caller asked to stop.
    #[error("stopped before cells were found")]
    Stopped,
}

/// A count with its thousands apart, as the commands write theirs.
struct Grouped(u64);

impl std::fmt::Display for Grouped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = self.0.to_string();
        for (at, digit) in digits.char_indices() {
            if at > 0 && (digits.len() - at).is_multiple_of(3) {
                f.write_str("\u{202f}")?;
            }
            write!(f, "{digit}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_in_errors_have_their_thousands_apart() {
        let many = RoomsError::TooMany {
            voxel: 0.1,
            counts: [1234, 20, 1_000_000],
            limit: 512,
            fits: 1.0,
        };
        let text = many.to_string().replace('\u{202f}', "'");
        assert!(text.starts_with("1'234 x 20 x 1'000'000 voxels"), "{text}");
        assert!(text.contains("the limit of 512;"), "{text}");
        let dense = RoomsError::TooDense { found: 70_000_000, voxel: 0.1, limit: 67_108_864 };
        let text = dense.to_string().replace('\u{202f}', "'");
        assert!(
            text.contains("that 70'000'000 come") && text.contains("limit of 67'108'864"),
            "{text}"
        );
    }
}
