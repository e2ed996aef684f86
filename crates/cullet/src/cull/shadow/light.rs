//! Lights, and the parts of space that they reach.

use glam::DVec3;

use crate::array;
use crate::bounds::{Plane, ROUNDING, unit};
use crate::math;

/// A light that casts shadows, in the coordinates of the view's frustum and of the casters.
///
/// A number that makes no light keeps every caster: a direction that is zero or not finite, a
/// position that is not finite. A NaN range counts as none, a NaN angle as no cone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// Parallel rays, as of the sun.
    Directional {
        /// The way the light travels; any length but zero.
        direction: [f64; 3],
    },
    /// A light that shines all around.
    Point {
        /// Where it is.
        position: [f64; 3],
        /// How far it reaches, in world units; infinite for no limit. One that is not above zero
        /// lights nothing.
        range: f64,
    },
    /// A light that shines into a cone.
    Spot {
        /// Where it is: the tip of the cone.
        position: [f64; 3],
        /// The way it shines, the axis of the cone; any length but zero.
        direction: [f64; 3],
        /// The angle between the axis and the side of the cone, where light ends altogether. From a
        /// right angle on it is no cone, and the light counts as a point light; one that is not
        /// above zero lights nothing.
        half_angle_radians: f64,
        /// The reach of the light, in world units; infinite for no limit. One that is not above
        /// zero lights nothing.
        range: f64,
    },
}

/// Where all rays of a light meet, at infinity for a directional one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Apex {
    /// The point, or the unit vector towards it.
    pub(super) point: DVec3,
    pub(super) at_infinity: bool,
}

/// Known reach of a light.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reach {
    /// Nothing is lit.
    Nothing,
    /// The numbers make no light.
    Unknown,
    /// Some of space is lit.
    Lit(Lit),
}

/// Region that a light reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lit {
    pub(super) apex: Apex,
    /// ∞ where there is no limit.
    pub(super) range: f64,
    /// The axis and the half angle, if there is a cone.
    cone: Option<(DVec3, f64)>,
}

impl Light {
    /// A cone is held in a pyramid of so many sides. Eight are up to 8 % farther from the axis than
    /// the cone; sixteen would be 2 %, and take half of the planes that a region may have.
    pub(super) const CONE_SIDES: usize = 8;

    /// The light of a map that is drawn with this homogeneous eye: it stands where that looks from,
    /// whatever place or direction it has itself; its range and its cone stay.
    #[cfg(feature = "shadows")]
    pub(crate) fn seen_from(self, [x, y, z, w]: [f64; 4]) -> Self {
        if w == 0.0 {
            return Self::Directional { direction: [-x, -y, -z] };
        }
        let position = [x / w, y / w, z / w];
        match self {
            Self::Directional { .. } => Self::Point { position, range: f64::INFINITY },
            Self::Point { range, .. } => Self::Point { position, range },
            Self::Spot { direction, half_angle_radians, range, .. } => {
                Self::Spot { position, direction, half_angle_radians, range }
            }
        }
    }

    /// Returns the same light in coordinates relative to `origin`.
    #[must_use]
    pub fn relative_to(self, origin: [f64; 3]) -> Self {
        let moved = |p: [f64; 3]| array::from_fn(|a| p[a] - origin[a]);
        match self {
            Self::Directional { .. } => self,
            Self::Point { position, range } => Self::Point { position: moved(position), range },
            Self::Spot { position, direction, half_angle_radians, range } => {
                Self::Spot { position: moved(position), direction, half_angle_radians, range }
            }
        }
    }

    pub(super) fn reach(&self) -> Reach {
        match *self {
            Self::Directional { direction } => {
                let Some(towards) = unit(-DVec3::from(direction)) else { return Reach::Unknown };
                let apex = Apex { point: towards, at_infinity: true };
                Reach::Lit(Lit { apex, range: f64::INFINITY, cone: None })
            }
            Self::Point { position, range } => around(position, range),
            Self::Spot { position, direction, half_angle_radians, range } => {
                if half_angle_radians <= 0.0 {
                    return Reach::Nothing;
                }
                let reach = around(position, range);
                let Reach::Lit(lit) = reach else { return reach };
                let Some(axis) = unit(DVec3::from(direction)) else { return Reach::Unknown };
                let cone = (half_angle_radians < core::f64::consts::FRAC_PI_2)
                    .then_some((axis, half_angle_radians));
                Reach::Lit(Lit { cone, ..lit })
            }
        }
    }
}

fn around(position: [f64; 3], range: f64) -> Reach {
    let point = DVec3::from(position);
    if range <= 0.0 {
        return Reach::Nothing;
    }
    if !point.is_finite() {
        return Reach::Unknown;
    }
    let range = if range.is_nan() { f64::INFINITY } else { range };
    Reach::Lit(Lit { apex: Apex { point, at_infinity: false }, range, cone: None })
}

impl Lit {
    /// Half-spaces that hold the cone: planes through its tip that touch it all around.
    pub(super) fn cone(&self) -> Option<[Plane; Light::CONE_SIDES]> {
        let (axis, half_angle) = self.cone?;
        let (tip, (u, v)) = (self.apex.point, axis.any_orthonormal_pair());
        let (sine, cosine) = math::sin_cos(half_angle);
        Some(array::from_fn(|side| {
            let turn = core::f64::consts::TAU * side as f64 / Light::CONE_SIDES as f64;
            let across = u * math::cos(turn) + v * math::sin(turn);
            let n = across * cosine - axis * sine;
            // The normal is off by some roundings, each per unit of distance: here for the tip's;
            // where the plane cuts a body, the body's slack is for its own.
            let slack = tip.abs().element_sum() * ROUNDING;
            Plane { normal: n.into(), d: n.dot(tip) + slack }
        }))
    }
}
