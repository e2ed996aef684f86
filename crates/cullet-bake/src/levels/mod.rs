//! Levels of detail whose error is measured, not believed: a simplifier's own number is no bound.

mod attributes;
mod chain;
pub(crate) mod collapse;
mod cut;
mod data;
pub mod error;
mod group;
mod hierarchy;
mod measure;
mod options;
mod original;
mod part;
mod peaks;
mod sheet;
mod sphere;
pub(crate) mod tighten;
mod weld;
mod within;

pub use attributes::{MAX_EXTENT, VertexValues};
pub(crate) use chain::chain_of;
pub use chain::{ChainOptions, build_chain};
pub use data::{Group, LevelsData, NO_GROUP};
pub use error::LevelsError;
pub use hierarchy::build_hierarchy;
pub use options::{ErrorSource, HierarchyOptions};
pub use within::{Within, WithinOptions, simplify_within};
