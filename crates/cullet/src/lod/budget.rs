//! A budget of triangles: the least threshold at which no more are drawn.

use alloc::vec::Vec;
use core::f64::consts::SQRT_2;

use super::{LevelEye, Levels, NO_GROUP};
use crate::array::{self, Each};
use crate::math;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// How many thresholds are tried, each a quarter of an octave above the one before: up to 55,000
/// times the first.
const STEPS: usize = 64;
const STEPS_PER_OCTAVE: u64 = 4;

/// Errors are taken for so much larger than they are, so that roundings here and in the choice
/// itself cannot have it draw more than was counted.
const OUTWARD: f64 = 1.0 + 1e-4;

/// The finest threshold where none is given: an eighth of a pixel.
const FINEST: f64 = 0.125;

/// How many triangles and clusters are drawn at each threshold.
type Drawn = [[i64; 2]; STEPS];

/// Totals of all that one stand-in stands for: the instances that are left, their clusters, and the
/// triangles drawn at each threshold.
#[derive(Clone, Copy, Debug)]
struct Below {
    instances: u64,
    clusters: u64,
    triangles: [u64; STEPS],
}

/// How many triangles a scene's instances come to at each of some thresholds, the memory to count
/// them in, and the threshold that was chosen last.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    finest: f64,
    all: [u64; STEPS],
    /// One total per stand-in, by its number.
    below: Vec<Below>,
    within: Within,
}

/// For groups of the levels counted last, the first threshold that each is within.
#[derive(Clone, Debug, Default)]
struct Within {
    /// One entry per group: [`UNSEEN`], or the number of its threshold, `STEPS` where it is within
    /// none. As long as the largest levels that were counted.
    of: Vec<u8>,
    /// The groups whose entries are not [`UNSEEN`]: only these are cleared.
    seen: Vec<u32>,
    pending: Vec<u32>,
}

/// In place of the number of a threshold.
const UNSEEN: u8 = u8::MAX;

impl Within {
    fn clear(&mut self, groups: usize) {
        self.seen.drain(..).for_each(|group| self.of[group as usize] = UNSEEN);
        self.of.resize(self.of.len().max(groups), UNSEEN);
        self.pending.clear();
    }

    /// Returns the threshold of a group. The first time it notes whether its inputs are to be
    /// visited.
    fn step(&mut self, levels: &Levels, eye: &LevelEye, group: u32) -> usize {
        let at = group as usize;
        if self.of[at] == UNSEEN {
            self.of[at] = first_within(eye, &levels.group(at));
            self.seen.push(group);
            if self.of[at] > 0 {
                self.pending.push(group);
            }
        }
        self.of[at].into()
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self { finest: FINEST, all: [0; STEPS], below: Vec::new(), within: Within::default() }
    }
}

impl Budget {
    /// Begins to count, from the wanted threshold up, of a scene where so many stand for others.
    pub(crate) fn begin(&mut self, pixels: f64, stand_ins: usize) {
        self.finest = if pixels > 0.0 && pixels.is_finite() { pixels } else { FINEST };
        self.all = [0; STEPS];
        self.below.clear();
        let none = Below { instances: 0, clusters: 0, triangles: [0; STEPS] };
        self.below.resize(stand_ins, none);
    }

    /// The threshold that eyes are to be made for.
    pub(crate) fn finest(&self) -> f64 {
        self.finest
    }

    /// Counts an instance without levels, that one of such a number stands for, if any does.
    pub(crate) fn add_whole(&mut self, by: u32, [triangles, clusters]: [u64; 2]) {
        self.put(by, [1, clusters], &[triangles; STEPS]);
    }

    /// Counts an instance with levels, of whose mesh there are so many triangles and clusters.
    pub(crate) fn add<'a>(
        &mut self,
        by: u32,
        [triangles, clusters]: [u64; 2],
        levels: impl Iterator<Item = &'a Levels>,
        eye: &LevelEye,
    ) {
        let mut least = [triangles; STEPS];
        self.lessen(&mut least, clusters, levels, eye);
        self.put(by, [1, clusters], &least);
    }

    /// Counts one that stands for others, after all of those below it: the less of its own levels
    /// and of all that.
    pub(crate) fn stand_in<'a>(
        &mut self,
        number: u32,
        above: u32,
        levels: impl Iterator<Item = &'a Levels>,
        eye: impl Fn() -> LevelEye,
    ) {
        let Some(below) = self.below.get(number as usize) else { return };
        let Below { instances, clusters, triangles: mut least } = *below;
        if instances > 0 {
            self.lessen(&mut least, clusters, levels, &eye());
            self.put(above, [instances, clusters], &least);
        }
    }

    /// Takes at each threshold what levels have, where that is less and in no more clusters than
    /// there are.
    fn lessen<'a>(
        &mut self,
        least: &mut [u64; STEPS],
        clusters: u64,
        levels: impl Iterator<Item = &'a Levels>,
        eye: &LevelEye,
    ) {
        for levels in levels {
            let mut counts: Drawn = [[0; 2]; STEPS];
            // Below this the finest are missing, and the mesh is drawn.
            let first = levels.count(eye, &mut self.within, &mut counts);
            let (mut drawn, mut drawn_clusters) = (0, 0);
            for (at, [more, more_clusters]) in counts.into_iter().enumerate() {
                drawn += more;
                drawn_clusters += more_clusters;
                if at >= first && drawn_clusters as u64 <= clusters {
                    least[at] = least[at].min(drawn as u64);
                }
            }
        }
    }

    /// Puts what is drawn to that of one that stands for it, or to all.
    fn put(&mut self, by: u32, [instances, clusters]: [u64; 2], least: &[u64; STEPS]) {
        let all = match self.below.get_mut(by as usize) {
            Some(below) => {
                below.instances += instances;
                below.clusters += clusters;
                &mut below.triangles
            }
            None => &mut self.all,
        };
        all.iter_mut().zip(least).for_each(|(n, least)| *n += least);
    }

    /// The least threshold at which no more than `most` triangles are drawn; the last one where
    /// there is none.
    pub(crate) fn pixels(&self, most: u64) -> f64 {
        let step = self.all.iter().position(|&n| n <= most).unwrap_or(STEPS - 1);
        self.finest * math::exp2(step as f64 / STEPS_PER_OCTAVE as f64)
    }
}

impl Levels {
    /// Adds to each threshold what more, or less, of this is drawn there than at the one before,
    /// for an eye that was made for the first of them. Returns the first threshold at which all
    /// that would be drawn is there.
    ///
    /// Goes from the coarsest groups down to those that are within the first threshold, as
    /// [`select`](Self::select) does: below them nothing is ever drawn.
    fn count(&self, eye: &LevelEye, within: &mut Within, counts: &mut Drawn) -> usize {
        let groups = self.group_count();
        within.clear(groups);
        // The list after the last group's: what no group simplified.
        let (mut list, mut high, mut first) = (groups, STEPS, 0);
        loop {
            for &cluster in self.inputs_of(list) {
                let low = match self.made_from[cluster as usize] {
                    NO_GROUP => 0,
                    group => within.step(self, eye, group),
                };
                if low < high {
                    let triangles = i64::from(self.triangles[cluster as usize]);
                    for (at, sign) in [(low, 1), (high, -1)] {
                        if let Some([all, clusters]) = counts.get_mut(at) {
                            *all += sign * triangles;
                            *clusters += sign;
                        }
                    }
                }
            }
            let Some(group) = within.pending.pop() else { return first };
            (list, high) = (group as usize, within.of[group as usize].into());
            if self.inputs_of(list).is_empty() {
                first = first.max(high);
            }
        }
    }
}

/// The number of the first threshold that a group is within; as many as there are where it is
/// within none.
fn first_within(eye: &LevelEye, group: &super::Group) -> u8 {
    let error = f64::from(group.error) * OUTWARD;
    let [nearest, reach] = [eye.nearest, eye.reach].each(f64::from);
    // Draws everything in full.
    if nearest < 0.0 {
        return STEPS as u8;
    }
    if error <= 0.0 {
        return 0;
    }
    let to: [f64; 3] = array::from_fn(|a| f64::from(group.centre[a]) - f64::from(eye.eye[a]));
    let away = to.iter().map(|v| v * v).sum::<f64>().sqrt() / OUTWARD;
    let free = away - (f64::from(group.radius) + f64::from(eye.ball)) * OUTWARD;
    let by_distance = if free > 0.0 { error * reach / free } else { f64::INFINITY };
    // In thresholds of the eye's.
    let threshold = (error / nearest).min(by_distance);
    // In place of a logarithm: its whole part is the exponent, and the quarters are compared with.
    if threshold <= 1.0 {
        return 0;
    }
    let exponent = (threshold.to_bits() >> 52) - 1023;
    let mantissa = f64::from_bits(threshold.to_bits() & (u64::MAX >> 12) | 1.0_f64.to_bits());
    let quarters = QUARTERS.iter().filter(|&&quarter| mantissa > quarter).count() as u64;
    (exponent * STEPS_PER_OCTAVE + quarters).min(STEPS as u64) as u8
}

/// Powers of two by quarters of an octave, from 1.
const QUARTERS: [f64; STEPS_PER_OCTAVE as usize] =
    [1.0, 1.189_207_115_002_721, SQRT_2, 1.681_792_830_507_429];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_those_of_the_logarithm() {
        // An eye for which a group's threshold is its error, grown by `OUTWARD`.
        let group = |error| super::super::Group { error, ..Default::default() };
        let eye = LevelEye { eye: [0.0; 3], nearest: 1.0, reach: 1.0, ball: 1.0 };
        let mut steps = [0; STEPS + 1];
        for k in 0..40_000 {
            let error = ((f64::from(k) - 8000.0) / 1500.0).exp2() as f32;
            let threshold = f64::from(error) * OUTWARD;
            let expected = (threshold.log2() * STEPS_PER_OCTAVE as f64).ceil();
            let expected = expected.clamp(0.0, STEPS as f64) as usize;
            assert_eq!(usize::from(first_within(&eye, &group(error))), expected, "{error}");
            steps[expected] += 1;
        }
        assert!(!steps.contains(&0), "{steps:?}");
    }
}
