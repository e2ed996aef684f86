//! Groups of levels of detail in steps of a grid, and the eye as they take it: which are over the
//! threshold, in integers.

use bytemuck::{Pod, Zeroable};
use cullet::lod::{Group, LevelEye, Levels, NO_GROUP};
use glam::DVec3;

use super::grid::{Grid, MOST};

/// Errors are in such parts of a step, and so is the reach of one.
const PARTS: f64 = 256.0;
/// An eye that is farther away is brought here, which is nearer to all that lies on the grid.
const FARTHEST: f64 = 1_073_741_824.0;

/// A [`Group`] on a [`Grid`]: 16 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridGroup {
    /// Centre of its sphere, in steps.
    pub centre: [i16; 3],
    /// Nothing.
    pub padding: u16,
    /// Radius of a sphere around its own, in steps.
    pub radius: u32,
    /// Its error, in parts of 1/256 of a step.
    pub error: u32,
}

/// An eye on the grid of a mesh, with the threshold: 32 bytes, as they lie on the device. The
/// default draws everything in full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GroupEye {
    /// Where the eye is, in steps, at most 2³⁰ from zero.
    pub at: [i32; 3],
    /// From how far an error is as large as the threshold: 1/256 of it.
    pub reach: u32,
    /// Errors below this are below the threshold, wherever the eye is.
    pub least: u32,
    /// Radius of the ball of eyes; with the most there is, everything is as near.
    pub ball: u32,
    /// Nothing.
    pub padding: [u32; 2],
}

impl Default for GroupEye {
    fn default() -> Self {
        Self { at: [0; 3], reach: 0, least: 0, ball: u32::MAX, padding: [0; 2] }
    }
}

impl GroupEye {
    /// An eye in the space of a mesh.
    #[must_use]
    pub fn new(eye: &LevelEye, grid: &Grid) -> Self {
        // What is above all, and what is not a number, is the most or 0: `as` sees to that.
        let least = ((f64::from(eye.nearest) * PARTS / grid.step).floor() + 1.0).max(0.0) as u32;
        let at = (DVec3::from(eye.eye.map(f64::from)) - DVec3::from(grid.origin)) / grid.step;
        let reach = (f64::from(eye.reach) * PARTS).ceil();
        // Two for the rounding of the eye and of what is subtracted.
        let ball = (f64::from(eye.ball) / grid.step).ceil() + 2.0;
        // Written so that NaN is near.
        if !(at.is_finite() && reach < f64::from(u32::MAX) && ball < f64::from(u32::MAX)) {
            return Self { least, ..Self::default() };
        }
        let most = DVec3::splat(FARTHEST);
        let at = at.round().clamp(-most, most).to_array().map(|v| v as i32);
        Self { at, reach: reach as u32, least, ball: ball as u32, padding: [0; 2] }
    }
}

impl GridGroup {
    /// The groups of some levels on a grid that has all of their centres.
    ///
    /// What was simplified further is in a sphere within the coarser one's, and has no larger an
    /// error; here, too: so exactly one of two such is drawn at each place, as long as all
    /// arithmetic from here on is exact, or grows with radius and error.
    #[must_use]
    pub fn of(levels: &Levels, grid: &Grid) -> Vec<Self> {
        let on_grid = |group: Group| {
            let centre = group.centre.map(f64::from);
            let steps = (DVec3::from(centre) - DVec3::from(grid.origin)) / grid.step;
            let steps = steps.clamp(DVec3::splat(-MOST), DVec3::splat(MOST)).round();
            let radius = f64::from(group.radius) / grid.step + 1.0;
            let error = f64::from(group.error) * PARTS / grid.step;
            Self {
                centre: steps.to_array().map(|v| v as i16),
                radius: radius.ceil() as u32,
                error: error.ceil() as u32,
                padding: 0,
            }
        };
        let mut all: Vec<Self> =
            (0..levels.group_count()).map(|g| on_grid(levels.group(g))).collect();
        let pairs = || levels.made_from().iter().zip(levels.replaced_by());
        // From finer to coarser ones, as often as there may be steps between them.
        for _ in 0..all.len() {
            let mut grown = false;
            for (&fine, &coarse) in pairs().filter(|(f, c)| **f != NO_GROUP && **c != NO_GROUP) {
                let (fine, coarse) = (all[fine as usize], &mut all[coarse as usize]);
                let apart = |a: usize| f64::from(fine.centre[a]) - f64::from(coarse.centre[a]);
                let apart = DVec3::new(apart(0), apart(1), apart(2)).length().ceil() as u32;
                let radius = fine.radius.saturating_add(apart);
                grown |= radius > coarse.radius || fine.error > coarse.error;
                coarse.radius = coarse.radius.max(radius);
                coarse.error = coarse.error.max(fine.error);
            }
            if !grown {
                break;
            }
        }
        all
    }

    /// Whether its error may be over the threshold. The device's shader does the same.
    #[must_use]
    pub fn is_over(&self, eye: &GroupEye) -> bool {
        let reach = u64::from(self.error) * u64::from(eye.reach);
        let reach = u32::try_from(reach >> 16).unwrap_or(u32::MAX).saturating_add(1);
        let far = self.radius.saturating_add(eye.ball).saturating_add(reach);
        let square = |v: u32| u64::from(v) * u64::from(v);
        let away: u64 = (0..3).map(|a| square(eye.at[a].abs_diff(i32::from(self.centre[a])))).sum();
        self.error >= eye.least && away <= square(far)
    }
}
