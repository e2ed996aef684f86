//! Levels of detail whose error is measured, not believed: a simplifier's own number is no bound.

#[cfg(feature = "meshopt")]
mod chain;
mod data;
pub mod error;
#[cfg(feature = "meshopt")]
mod group;
#[cfg(feature = "meshopt")]
mod hierarchy;
#[cfg(feature = "meshopt")]
mod measure;
#[cfg(feature = "meshopt")]
mod options;
#[cfg(feature = "meshopt")]
mod original;
#[cfg(feature = "meshopt")]
mod part;
#[cfg(feature = "meshopt")]
mod peaks;
#[cfg(feature = "meshopt")]
mod sheet;
#[cfg(feature = "meshopt")]
pub mod simplifier;
#[cfg(feature = "meshopt")]
mod sphere;
#[cfg(feature = "meshopt")]
mod weld;
#[cfg(feature = "meshopt")]
mod within;

#[cfg(feature = "meshopt")]
pub(crate) use chain::chain_of;
#[cfg(feature = "meshopt")]
pub use chain::{ChainOptions, build_chain};
pub use data::{Group, LevelsData, NO_GROUP};
pub use error::LevelsError;
#[cfg(feature = "meshopt")]
pub use hierarchy::build_hierarchy;
#[cfg(feature = "meshopt")]
pub use options::{ErrorSource, HierarchyOptions};
#[cfg(feature = "meshopt")]
pub use within::{Within, WithinOptions, simplify_within};
