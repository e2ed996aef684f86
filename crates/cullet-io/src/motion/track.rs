//! Values over time: what an animation does to one property of one node.

use std::ops::{Add, Mul};

use cullet::math;
use glam::{DAffine3, DQuat, DVec3, DVec4};

/// The transform of a node relative to its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Local {
    /// A matrix, which no animation can move.
    Matrix(DAffine3),
    /// Scale, then rotation, then translation.
    Parts { translation: DVec3, rotation: DQuat, scale: DVec3 },
}

impl Local {
    pub(crate) fn affine(&self) -> DAffine3 {
        match *self {
            Self::Matrix(m) => m,
            Self::Parts { translation, rotation, scale } => {
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }

    /// Returns the transform with one property set to its value on `track` at `time`.
    pub(crate) fn moved(self, track: &Track, time: f64) -> Self {
        let (mut scale, mut rotation, mut translation) = match self {
            Self::Parts { translation, rotation, scale } => (scale, rotation, translation),
            // Not allowed; the parts that no track gives are then those of the identity.
            Self::Matrix(_) => (DVec3::ONE, DQuat::IDENTITY, DVec3::ZERO),
        };
        let v = track.at(time);
        match track.property {
            Property::Translation => translation = v.truncate(),
            Property::Rotation => rotation = DQuat::from_vec4(unit(v)),
            Property::Scale => scale = v.truncate(),
        }
        Self::Parts { translation, rotation, scale }
    }
}

/// Property of a node that a track moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Property {
    Translation,
    Rotation,
    Scale,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Linear,
    Step,
    /// Each key has three values: tangent in, value, tangent out.
    Cubic,
}

impl Interpolation {
    /// How many values a key has.
    pub(crate) fn values(self) -> usize {
        if self == Self::Cubic { 3 } else { 1 }
    }
}

/// The values of one property of one node over time.
#[derive(Debug)]
pub(crate) struct Track {
    pub(crate) node: u32,
    pub(crate) property: Property,
    pub(crate) interpolation: Interpolation,
    /// Seconds, ascending, at least one.
    pub(crate) times: Vec<f64>,
    /// One value a time, or three.
    pub(crate) values: Vec<DVec4>,
}

impl Track {
    /// The value at a time; before the first key and after the last it stays.
    pub(crate) fn at(&self, time: f64) -> DVec4 {
        let mix = |a: DVec4, b: DVec4, s: f64| match self.property {
            Property::Rotation => slerp(unit(a), unit(b), s),
            _ => a.lerp(b, s),
        };
        sample(self.interpolation, &self.times, time, |i| self.values[i], mix)
    }
}

/// The morph weights of one node over time.
#[derive(Debug)]
pub(crate) struct WeightTrack {
    pub(crate) node: u32,
    pub(crate) interpolation: Interpolation,
    /// Seconds, ascending, at least one.
    pub(crate) times: Vec<f64>,
    /// How many weights make a value, at least one.
    pub(crate) targets: usize,
    /// One value a time, or three, each of `targets` weights.
    pub(crate) values: Vec<f32>,
}

impl WeightTrack {
    /// The weights at a time; before the first key and after the last they stay.
    pub(crate) fn at(&self, time: f64) -> Vec<f32> {
        let weight = |k: usize| {
            let value = |i: usize| f64::from(self.values[i * self.targets + k]);
            sample(self.interpolation, &self.times, time, value, |a, b, s| a + (b - a) * s) as f32
        };
        (0..self.targets).map(weight).collect()
    }
}

/// Follows keys, of which `value` gives the values one after the other; `mix` goes straight from
/// one to the next.
fn sample<V: Copy + Add<Output = V> + Mul<f64, Output = V>>(
    interpolation: Interpolation,
    times: &[f64],
    time: f64,
    value: impl Fn(usize) -> V,
    mix: impl Fn(V, V, f64) -> V,
) -> V {
    let key = |i: usize| match interpolation {
        Interpolation::Cubic => value(i * 3 + 1),
        _ => value(i),
    };
    let after = times.partition_point(|&t| t <= time);
    if after == 0 {
        return key(0);
    }
    let i = after - 1;
    if after == times.len() {
        return key(i);
    }
    let span = times[after] - times[i];
    let s = (time - times[i]) / span;
    match interpolation {
        Interpolation::Step => key(i),
        Interpolation::Linear => mix(key(i), key(after), s),
        Interpolation::Cubic => {
            // Hermite, as appendix C of the specification has it.
            let (out, into) = (value(i * 3 + 2) * span, value(after * 3) * span);
            let (s2, s3) = (s * s, s * s * s);
            key(i) * (2.0 * s3 - 3.0 * s2 + 1.0)
                + out * (s3 - 2.0 * s2 + s)
                + key(after) * (3.0 * s2 - 2.0 * s3)
                + into * (s3 - s2)
        }
    }
}

/// A turn of length one; of zeros, which turn nothing, the identity.
fn unit(v: DVec4) -> DVec4 {
    v.try_normalize().unwrap_or(DVec4::W)
}

/// The turn that is a share `s` of the way from one to another, along the shorter arc.
///
/// (Shoemake, *Animating Rotation with Quaternion Curves*, 1985.)
fn slerp(a: DVec4, b: DVec4, s: f64) -> DVec4 {
    let cosine = a.dot(b);
    let (b, cosine) = if cosine < 0.0 { (-b, -cosine) } else { (b, cosine) };
    // Of nearly the same turns the sine is lost, and the arc is straight.
    if cosine > 1.0 - 1e-9 {
        return a.lerp(b, s).normalize();
    }
    let angle = math::acos(cosine);
    (a * math::sin((1.0 - s) * angle) + b * math::sin(s * angle)) / math::sin(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, times: &[f64], xs: &[f64]) -> Track {
        Track {
            node: 0,
            property: Property::Translation,
            interpolation,
            times: times.to_vec(),
            values: xs.iter().map(|&x| DVec4::new(x, 0.0, 0.0, 0.0)).collect(),
        }
    }

    #[test]
    fn linear_and_step_and_beyond_the_ends() {
        let linear = track(Interpolation::Linear, &[1.0, 3.0], &[10.0, 20.0]);
        let x = |t: &Track, time| t.at(time).x;
        assert_eq!(
            [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| x(&linear, t)),
            [10.0, 10.0, 15.0, 20.0, 20.0]
        );
        let step = track(Interpolation::Step, &[1.0, 3.0], &[10.0, 20.0]);
        let before = 3f64.next_down();
        assert_eq!([1.0, 2.9, before, 3.0].map(|t| x(&step, t)), [10.0, 10.0, 10.0, 20.0]);
    }

    #[test]
    fn a_cubic_with_the_tangents_of_a_line_is_that_line() {
        // Slope 5: tangents are per second.
        let values = [5.0, 10.0, 5.0, 5.0, 20.0, 5.0];
        let cubic = track(Interpolation::Cubic, &[1.0, 3.0], &values);
        for time in [1.0, 1.25, 1.9, 2.5, 3.0] {
            assert!((cubic.at(time).x - (5.0 * time + 5.0)).abs() < 1e-12, "{time}");
        }
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let rotation = Track {
            property: Property::Rotation,
            values: vec![DVec4::new(0.0, 0.0, 0.0, 1.0), DVec4::new(0.0, -half, 0.0, -half)],
            ..track(Interpolation::Linear, &[0.0, 1.0], &[])
        };
        let turned = DQuat::from_vec4(unit(rotation.at(0.5))) * DVec3::X;
        assert!(turned.abs_diff_eq(DVec3::new(half, 0.0, -half), 1e-12), "{turned}");
    }

    #[test]
    fn weights_go_each_their_own_way() {
        let mut track = WeightTrack {
            node: 0,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 2.0],
            targets: 2,
            values: vec![0.0, 1.0, 1.0, -1.0],
        };
        assert_eq!(track.at(0.5), [0.25, 0.5]);
        assert_eq!(track.at(7.0), [1.0, -1.0]);
        // In, value and out of each key, two weights each; the tangents are flat.
        track.interpolation = Interpolation::Cubic;
        track.values = vec![0., 0., 0., 1., 0., 0., 0., 0., 1., -1., 0., 0.];
        assert_eq!(track.at(1.0), [0.5, 0.0]);
        assert_eq!(track.at(2.0), [1.0, -1.0]);
    }
}
