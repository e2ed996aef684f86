//! Why a cluster has no region of eyes behind it.

use cullet::cull::backface::ClusterPlanes;
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
    /// Its normals span half of space, or so nearly that a region would be too small to gain by.
    #[error("its normals span half of space or nearly so")]
    Hemisphere,
    /// There is a region, but too thin for an apex to be found in it.
    #[error("its region is too thin for an apex")]
    NoApex,
}

/// Whether an apex bound (a cone or a pyramid) of these planes has a region, or the reason why no
/// eye is proved behind them all. Costs as a fit without its shape; the bounds themselves say no
/// more than `None`.
///
/// A box of normals ([`NormalBox`](super::NormalBox)) needs no apex, and may have a region where
/// this is [`NoRegion::Hemisphere`] or [`NoRegion::NoApex`].
///
/// # Errors
/// The reason.
pub fn region(planes: &ClusterPlanes) -> Result<(), NoRegion> {
    let (largest, radius) = (planes.largest(), planes.radius());
    // Where all triangles are in doubt, that is what is amiss.
    if !planes.is_complete() {
        Err(NoRegion::NotCertain)
    } else if planes.is_empty() {
        Err(NoRegion::Empty)
    } else if largest > ClusterPlanes::LARGEST {
        Err(NoRegion::TooLarge { largest, limit: ClusterPlanes::LARGEST })
    } else if radius < ClusterPlanes::SMALLEST {
        Err(NoRegion::TooSmall { radius, limit: ClusterPlanes::SMALLEST })
    } else if planes.axis().is_none() {
        Err(NoRegion::Hemisphere)
    } else {
        planes.apex(0.0).map(|_| ()).ok_or(NoRegion::NoApex)
    }
}
