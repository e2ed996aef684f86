//! Ellipsoids, as given and lowered to the ground.

use crate::array::Each;
use crate::bounds::ROUNDING;

/// An ellipsoid around the origin, with its axes along those of space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ellipsoid {
    pub(super) radii: [f64; 3],
}

impl Ellipsoid {
    /// The earth, in metres: WGS 84 in geocentric axes (EPSG:4978), with the north pole on +z.
    pub const WGS84: Self = Self { radii: [6_378_137.0, 6_378_137.0, 6_356_752.314_245_179] };

    /// Makes an ellipsoid of its three radii. One that is not above zero, or not finite, makes an
    /// ellipsoid that hides nothing.
    #[must_use]
    pub const fn new(radii: [f64; 3]) -> Self {
        Self { radii }
    }

    /// Returns the radii along x, y and z.
    #[must_use]
    pub const fn radii(&self) -> [f64; 3] {
        self.radii
    }

    /// Returns an ellipsoid of the same shape that lies at least `depth` below this one everywhere,
    /// for ground that goes below it. A negative `depth` is taken as 0, and NaN hides nothing.
    ///
    /// Where the normal is n, the plane that touches this ellipsoid has some distance h from the
    /// centre, which is at least the shortest radius, and that of the smaller one h times the scale:
    /// nearer by `depth` if the scale is 1 − depth / shortest radius. Radii that are each shorter by
    /// `depth` do not quite do: between the axes their ellipsoid comes nearer than that.
    #[must_use]
    pub fn lowered(&self, depth: f64) -> Self {
        let scale = self.level(depth);
        Self { radii: self.radii.each(|r| r * scale) }
    }

    /// Scale of the ellipsoid that is lowered by `depth`, rounded down; 1 where it is not lowered.
    pub(super) fn level(&self, depth: f64) -> f64 {
        if depth <= 0.0 { 1.0 } else { (1.0 - depth / self.bounds()[0]) * (1.0 - ROUNDING) }
    }

    /// The shortest and the longest radius.
    pub(super) fn bounds(&self) -> [f64; 2] {
        let [x, y, z] = self.radii;
        [x.min(y).min(z), x.max(y).max(z)]
    }

    /// Whether all radii are numbers above zero.
    pub(super) fn is_solid(&self) -> bool {
        self.radii.iter().all(|r| *r > 0.0 && r.is_finite())
    }
}
