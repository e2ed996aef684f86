//! Instances that will be needed along a motion, and from which distance on: for streaming.
//!
//! The way is cut into steps. The eyes of a step lie in the box around it, enlarged on every side
//! by the motion's uncertainty. Each box is searched for what may be seen from it and was not found
//! before.

use alloc::vec::Vec;

#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use cullet::{Handle, Scene};

use super::region::{EyeBox, Outlook, RegionCuller, RegionError, RegionState, RegionWork};

/// Rounding of distances along a way: they are lower bounds.
const ROUNDING: f64 = 1e-12;

/// A way of an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<'a> {
    /// Corners of the way, in world space; one alone is an eye that stays.
    pub points: &'a [[f64; 3]],
    /// How far along each axis the eye may stray from the way, in world units; at least 0.
    pub radius_world: f64,
    /// How far along the way is looked, in world units, at least 0; infinite or NaN is to its end.
    pub reach_world: f64,
}

impl<'a> Motion<'a> {
    /// All of a way, kept to exactly.
    #[must_use]
    pub const fn along(points: &'a [[f64; 3]]) -> Self {
        Self { points, radius_world: 0.0, reach_world: f64::INFINITY }
    }

    /// The corners of the way of an eye that goes straight on for some seconds, `velocity` world
    /// units in each.
    #[must_use]
    pub fn straight(start: [f64; 3], velocity: [f64; 3], seconds: f64) -> [[f64; 3]; 2] {
        [start, core::array::from_fn(|a| start[a] + velocity[a] * seconds)]
    }
}

/// An instance that will be needed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Needed {
    /// Which.
    pub handle: Handle,
    /// Nothing of it is seen before this distance along the way, in world units; 0 for what may be
    /// seen at the start.
    pub distance: f64,
}

/// Settings of queries for what will be needed along a motion.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct MotionQuery {
    /// Settings of the query for each step. Its `most_cells` are those of a step.
    pub region: RegionCuller,
    /// Length of a step, in world units, above 0. Distances are known to a step; cost is in
    /// proportion to their number. Default 4: two of the region's cells.
    pub step_world: f64,
    /// No more steps than this, at least 1; a longer way has longer ones. Default 1024.
    pub most_steps: u32,
}

impl Default for MotionQuery {
    fn default() -> Self {
        Self { region: RegionCuller::default(), step_world: 4.0, most_steps: 1024 }
    }
}

impl MotionQuery {
    /// Lists what may be seen along a way, in any direction, by the distance at which it first may
    /// be, then by slot.
    ///
    /// Nothing is missing that is seen from within reach: see [`RegionCuller::cull`] for what is
    /// kept besides. No distance is larger than that at which the instance is first seen; it is
    /// that of the step's beginning. No point is no eye, and needs nothing. Where a point or the
    /// radius is not finite the eye may be anywhere from there on, so that everything is needed.
    ///
    /// Cost: a region query for each step, of what was not found in those before. Returns the work
    /// of all.
    ///
    /// # Errors
    /// [`RegionError::Setting`] for a setting out of its range, or a radius or reach below 0.
    pub fn needed(
        &self,
        scene: &Scene,
        motion: &Motion<'_>,
        state: &mut RegionState,
        needed: &mut Vec<Needed>,
    ) -> Result<RegionWork, RegionError> {
        let outlook = Outlook::new(&self.region, None)?;
        let steps = self.steps(motion)?;
        needed.clear();
        state.begin(scene, outlook.layers);
        for (from, eyes) in steps {
            self.region.find(scene, &eyes, &outlook, state);
            let distance = from * (1.0 - ROUNDING);
            state.take_found(|slot| {
                needed.extend(scene.handle(slot).map(|handle| Needed { handle, distance }));
            });
        }
        Ok(state.work())
    }

    /// The steps of a way: the distance at which each begins, and its eyes.
    fn steps<'a>(
        &self,
        motion: &Motion<'a>,
    ) -> Result<impl Iterator<Item = (f64, EyeBox)> + 'a, RegionError> {
        let range = |what, value: f64, ok: bool, must| match ok {
            true => Ok(()),
            false => Err(RegionError::Setting { what, value, must }),
        };
        let (step, most) = (self.step_world, self.most_steps);
        range("step_world", step, step > 0.0 && step.is_finite(), "above 0 and finite")?;
        range("most_steps", most.into(), most > 0, "at least 1")?;
        let Motion { points, radius_world: radius, reach_world: reach } = *motion;
        range("radius_world", radius, radius >= 0.0 || radius.is_nan(), "at least 0")?;
        range("reach_world", reach, reach >= 0.0 || reach.is_nan(), "at least 0")?;
        let length: f64 = points.windows(2).map(|p| length(p[0], p[1])).sum();
        let step = match length.min(reach) / f64::from(most) {
            longer if longer.is_finite() => step.max(longer * (1.0 + 1e-9)),
            _ => step,
        };
        Ok(Steps {
            points,
            radius,
            reach,
            step,
            at: 0,
            along: 0.0,
            before: 0.0,
            is_done: points.is_empty(),
        })
    }
}

/// The steps that are left of a way.
struct Steps<'a> {
    points: &'a [[f64; 3]],
    radius: f64,
    reach: f64,
    step: f64,
    /// The stretch between two points, how much of it is behind, and how long those before are.
    at: usize,
    along: f64,
    before: f64,
    is_done: bool,
}

impl Iterator for Steps<'_> {
    type Item = (f64, EyeBox);

    /// A step goes on around corners, so that a way of many short stretches has no more steps than
    /// a straight one.
    fn next(&mut self) -> Option<Self::Item> {
        if self.is_done {
            return None;
        }
        let from = self.before + self.along;
        let mut left = self.step.min(self.reach - from);
        let mut eyes = EyeBox::around(&[self.place()], self.radius);
        loop {
            let Some(stretch) = self.points.get(self.at..self.at + 2) else {
                self.is_done = true;
                break;
            };
            let whole = length(stretch[0], stretch[1]);
            // A NaN or infinite length, radius or reach ends it: the eye may be anywhere.
            if !(whole.is_finite() && left.is_finite() && self.radius.is_finite()) {
                self.is_done = true;
                eyes = EyeBox::new([f64::NAN; 3], [f64::NAN; 3]);
                break;
            }
            if self.along + left < whole {
                self.along += left;
                eyes = joined(&eyes, &EyeBox::around(&[self.place()], self.radius));
                self.is_done = self.before + self.along >= self.reach;
                break;
            }
            left = (left - (whole - self.along)).max(0.0);
            eyes = joined(&eyes, &EyeBox::around(&[stretch[1]], self.radius));
            (self.at, self.along, self.before) = (self.at + 1, 0.0, self.before + whole);
        }
        Some((from, eyes))
    }
}

impl Steps<'_> {
    /// Where on the way it has come to.
    fn place(&self) -> [f64; 3] {
        let from = self.points[self.at];
        let Some(to) = self.points.get(self.at + 1) else { return from };
        let share = match length(from, *to) {
            whole if whole > 0.0 => self.along / whole,
            _ => 0.0,
        };
        core::array::from_fn(|a| from[a] + (to[a] - from[a]) * share)
    }
}

fn length(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).map(|a| (to[a] - from[a]).powi(2)).sum::<f64>().sqrt()
}

/// The box around two; a NaN in either stays.
fn joined(a: &EyeBox, b: &EyeBox) -> EyeBox {
    EyeBox::around(&[a.min, a.max, b.min, b.max], 0.0)
}
