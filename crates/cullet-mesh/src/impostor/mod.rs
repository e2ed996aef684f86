//! Impostors: a mesh as it looks from all around, in place of its triangles.
//!
//! An [`Impostor`] is an octahedral grid of frames, each a parallel view along one direction: how
//! much of each texel the mesh covers, how deep its surface lies there, which way it faces and of
//! which part it is. A renderer walks along the ray of a pixel until no frame near the ray's
//! direction sees past the point any more.
//!
//! After R. Brucks, *Octahedral Impostors*, 2018, and the visual hulls of A. Laurentini, *The
//! Visual Hull Concept for Silhouette-Based Image Understanding*, 1994.

mod atlas;
mod frame;
mod level;

pub use atlas::{IMPOSTOR_PARTS, Impostor, ImpostorError, Texel};
pub use frame::ImpostorFrame;
