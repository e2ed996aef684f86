//! Whether a mesh may be culled by the side that its triangles turn to the eye.

use super::{Mesh, NotSolid};

/// Why back-face culling has nothing to do with a mesh: both sides of all its triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSided {
    /// What keeps the mesh from being a solid, which would be one-sided by nature. `None` where it is a
    /// solid, and has been declared two-sided.
    pub defect: Option<NotSolid>,
}

impl std::fmt::Display for TwoSided {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.defect {
            Some(defect) => write!(f, "the mesh is two-sided and no solid: {defect}")?,
            None => write!(f, "the mesh is declared two-sided, though it is a solid")?,
        }
        write!(f, "; if its backs are never seen, declare it one-sided (set_two_sided(false))")
    }
}

impl std::error::Error for TwoSided {}

impl Mesh {
    /// Refuses a mesh none of whose parts is one-sided: culling its back faces would lose what is seen.
    /// Costs nothing for another mesh, and [`Mesh::solid`] for the reason.
    ///
    /// A mesh of parts of both kinds passes: its two-sided parts are to be kept.
    ///
    /// # Errors
    /// The defect that keeps the mesh from being a solid.
    pub fn require_one_sided(&self) -> Result<(), TwoSided> {
        if self.is_two_sided() { Err(TwoSided { defect: self.solid().err() }) } else { Ok(()) }
    }
}
