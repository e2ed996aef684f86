//! Why a cluster has no region of eyes behind it.

use thiserror::Error;

/// Why no eye can be proved behind all planes of a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoRegion {
    /// It has no triangle with an area, so no plane.
    #[error("no triangle has an area")]
    Empty,
    /// Rounding leaves the normal of a triangle in doubt, or a corner is not finite.
    #[error("a triangle is too thin, or not finite: its normal is not certain")]
    NotCertain,
    /// Its coordinates are larger than the tests can square in f32.
    #[error("a coordinate of {largest:e} is beyond the limit of {limit:e}")]
    TooLarge {
        /// The largest coordinate.
        largest: f64,
        /// The limit.
        limit: f64,
    },
    /// It is smaller than the tests can square in f32.
    #[error("a radius of {radius:e} is below the limit of {limit:e}")]
    TooSmall {
        /// Half the diagonal of its box.
        radius: f64,
        /// The limit.
        limit: f64,
    },
    /// Its normals span half of space, or so nearly that a region is not worth having.
    #[error("its normals span half of space or nearly so")]
    Hemisphere,
    /// There is a region, but too thin for an apex to be found in it.
    #[error("its region is too thin for an apex")]
    NoApex,
}
