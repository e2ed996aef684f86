//! What a surface is like once equal positions are welded: closed, manifold, consistently wound?

use thiserror::Error;

/// Why a mesh is not a solid; the first reason found, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NotSolid {
    /// It has no triangle that covers anything.
    #[error("it has no triangles")]
    Empty,
    /// A part is blended or alpha-masked.
    #[error("part {part} is not opaque")]
    NotOpaque {
        /// Which part.
        part: u32,
    },
    /// Edges with one triangle.
    #[error("it is open: {edges} boundary edges")]
    Open {
        /// How many.
        edges: u32,
    },
    /// Edges with more than two triangles.
    #[error("it is not manifold: {edges} edges with more than two triangles")]
    NonManifold {
        /// How many.
        edges: u32,
    },
    /// Edges whose two triangles run along them in the same direction.
    #[error("its winding is inconsistent: {edges} misoriented edges")]
    Misoriented {
        /// How many.
        edges: u32,
    },
    /// Wound inward: the volume is negative.
    #[error("it is wound inward: its volume is {volume:e}")]
    Inward {
        /// The signed volume.
        volume: f64,
    },
    /// It encloses nothing.
    #[error("it encloses no volume")]
    NoVolume,
}

/// Facts about a surface whose equal positions are welded. The caller's vertices are not changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Topology {
    /// Distinct positions that some triangle uses.
    pub vertices: u32,
    /// Triangles left after dropping those that welding makes degenerate.
    pub triangles: u32,
    /// Distinct edges.
    pub edges: u32,
    /// Edges of one triangle.
    pub boundary_edges: u32,
    /// Edges of more than two triangles.
    pub non_manifold_edges: u32,
    /// Edges whose two triangles run along them in the same direction.
    pub misoriented_edges: u32,
    /// Pieces connected by edges.
    pub shells: u32,
    /// Signed volume, about the middle of the surface: positive when wound outward.
    pub volume: f64,
}

impl Topology {
    /// The topology of a triangle list.
    #[must_use]
    pub fn of(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let _ = (positions, indices);
        Self::default()
    }

    /// Whether the surface bounds a solid, opacity apart, or the first reason why not.
    ///
    /// # Errors
    /// The reason.
    pub fn solid(&self) -> Result<(), NotSolid> {
        if self.triangles == 0 {
            return Err(NotSolid::Empty);
        }
        Ok(())
    }
}
