//! Why sets of a scene cannot be made.

use thiserror::Error;

/// Why sets of a scene cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SampledError {
    /// The scene has no instance that could be seen or hide anything.
    #[error("none of {instances} instances has a place and a shape; there is nothing to bake")]
    Empty {
        /// How many instances there are.
        instances: u32,
    },
    /// The scene has more to be seen than a row has bits.
    #[error(
        "{targets} instances or clusters exceed the limit of {limit}; bake by instance, or in parts"
    )]
    Targets {
        /// How many there are.
        targets: u64,
        /// How many there may be.
        limit: u32,
    },
    /// A region for cells that is no box.
    #[error(
        "region {region} from {low:?} to {high:?} is no box: each low end must be a number below the high end"
    )]
    Region {
        /// Number of the region, from 0.
        region: usize,
        /// Its low ends.
        low: [f64; 3],
        /// Its high ends.
        high: [f64; 3],
    },
    /// A number of cells that cannot be made.
    #[error("{cells} cells; 1 to {limit} are possible, and at least one for each region")]
    Cells {
        /// How many cells were asked for.
        cells: u64,
        /// How many there may be.
        limit: u32,
    },
    /// Rows that would not fit the memory that they may take.
    #[error(
        "{cells} cells times {targets} instances or clusters need {bytes} bytes, above the limit of {limit}; \
        take fewer cells, or bake by instance"
    )]
    Rows {
        /// How many cells.
        cells: u32,
        /// How many bits a row has.
        targets: u32,
        /// The bytes that they would need.
        bytes: u64,
        /// The bytes that they may take.
        limit: u64,
    },
    /// Sets from which a bake cannot go on.
    #[error(
        "these sets do not say of which instances they are, or clusters were asked for; bake the whole scene again, \
        by instance"
    )]
    Before,
    /// A setting out of its range.
    #[error("{name} is {value}; {range}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The values that it may have.
        range: &'static str,
    },
}
