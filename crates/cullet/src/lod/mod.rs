//! Levels of detail: meshes of fewer triangles, each with a bound on how far it is from the
//! original, and the choice among them for an eye.
//!
//! [`Levels`] are clusters, each made by simplifying a [`Group`] of finer ones. A cluster is drawn
//! if the group that it was made from is within the threshold, and the group that it was simplified
//! in is beyond it: of each place of the surface just one level is drawn, and neighbours meet as
//! they did when they were simplified together. A chain of whole meshes is the same with one group
//! for each level.
//!
//! A group is over the threshold iff the eye is in a sphere around it, so that choosing asks for
//! nothing else. That the result is closed rests on the errors and spheres growing from each group
//! to those made of it, which [`Levels::new`] demands.
//!
//! Lossy, so off unless [asked for](crate::Culler::lod): what is drawn is off by up to the
//! threshold, in pixels, if the errors of the groups were measured.
//!
//! After H. Hoppe, *View-dependent refinement of progressive meshes*, 1997; P. Cignoni et al.,
//! *Batched Multi Triangulation*, 2005; B. Karis et al., *Nanite: A Deep Dive*, 2021.

mod budget;
mod choose;
mod eye;
mod levels;
mod steps;

pub(crate) use budget::Budget;
pub use choose::Selection;
pub use eye::{LevelEye, Lod, PixelScale};
pub use levels::{Group, Levels, LevelsError, NO_GROUP};
