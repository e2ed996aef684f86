//! The settings of the cut-away.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How far beyond the scene planes may stand, in half extents: at 1 they touch it.
pub const REACH: f64 = 1.05;

/// The shape that cuts the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A plane.
    #[default]
    Plane,
    /// An upright box.
    Box,
}

/// Part of a cut scene that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The part behind the plane, or inside the box.
    #[default]
    Inside,
    /// The rest.
    Outside,
}

/// How the scene is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CutAway {
    /// Whether it is.
    pub on: bool,
    /// Shape that cuts.
    pub shape: Shape,
    /// The plane's normal, of any length but 0.
    pub normal: [f64; 3],
    /// Where the plane stands along its normal: −1 and 1 are the ends of the scene, 0 is its
    /// middle.
    pub at: f64,
    /// The box's low corner, each axis as `at`.
    pub low: [f64; 3],
    /// The box's high corner.
    pub high: [f64; 3],
    /// Part that is shown.
    pub part: Part,
    /// Whether the cut is closed, where it can be.
    pub caps: bool,
    /// Whether the outlines of the cut are drawn, as in a section drawing.
    pub outlines: bool,
}

impl Default for CutAway {
    fn default() -> Self {
        Self {
            on: false,
            shape: Shape::Plane,
            normal: [1.0, 0.0, 0.0],
            at: 0.0,
            low: [0.0, -REACH, 0.0],
            high: [REACH; 3],
            part: Part::Inside,
            caps: true,
            outlines: true,
        }
    }
}

impl CutAway {
    /// Checks every number; the error names the invalid one, its value, and what it must be.
    ///
    /// # Errors
    /// If a number is not finite or out of its range.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        let length = DVec3::from(self.normal).length();
        if !(1e-6..=1e6).contains(&length) {
            return Err(("the length of cut.normal", length, "between 1e-6 and 1e6"));
        }
        let places = self.low.iter().chain(&self.high).chain([&self.at]);
        for v in places {
            if !(-2.0..=2.0).contains(v) {
                return Err(("a place of cut", *v, "between -2 and 2"));
            }
        }
        Ok(())
    }
}
