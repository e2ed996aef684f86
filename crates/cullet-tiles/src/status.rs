//! Where a world stands.

use std::cmp::Ordering;

use crate::source::{TileError, TileId};

/// A tile that is to be loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Want {
    /// Which.
    pub tile: TileId,
    /// Bytes that it will take.
    pub bytes: u64,
    /// The error of what it shows, on the screen, in pixels; of finest tiles 0.
    pub pixels: f64,
    /// Whether it can be seen from where the eye is or is going to be, as far as is known: see
    /// [`TileSource::is_seen`](crate::TileSource::is_seen).
    pub is_seen: bool,
}

impl Want {
    /// Orders two tiles so that the one that matters more is less: first those that can be seen,
    /// then those that are more pixels off, then by name.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        let seen = other.is_seen.cmp(&self.is_seen);
        seen.then(other.pixels.total_cmp(&self.pixels)).then(self.tile.cmp(&other.tile))
    }
}

/// Where a world stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// Tiles of the scene that is in use.
    pub tiles: usize,
    /// Upper bound of the bytes that tiles and scenes take at any time until the next cut; never
    /// above the budget.
    pub bytes: u64,
    /// Tiles that are to be loaded next, in this order.
    pub wanted: Vec<Want>,
    /// Tiles that could not be loaded, each named once. They are not tried again until
    /// [`World::forgive`](crate::World::forgive).
    pub failed: Vec<TileError>,
    /// Tiles that were loaded until now.
    pub loaded: u64,
    /// Scenes that were built until now, and what the last took, in seconds.
    pub built: u64,
    /// Seconds that the last build took.
    pub build_seconds: f64,
    /// Whether the budget ended the cut before the error was small enough everywhere.
    pub is_cut_short: bool,
}
