//! Balls of eyes.

use crate::array;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// A ball of eyes that levels are chosen for at once: none of them sees an error above the
/// threshold.
///
/// With a ball that is kept while the eye stays in it nothing flips, whatever the eye does in
/// there, and nothing is remembered but the ball. A ball around both eyes of a stereo view gives
/// both the same levels, and one around the camera's eye gives its shadow maps the levels that it
/// draws.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EyeBall {
    /// Centre, in world space.
    pub centre: [f64; 3],
    /// Radius in world units, from 0.
    pub radius: f64,
}

impl EyeBall {
    /// This ball, as long as `eye` is in it; else a ball of this radius around `eye`.
    #[must_use]
    pub fn follow(self, eye: [f64; 3], radius: f64) -> Self {
        let away = distance(self.centre, eye);
        if away <= self.radius { self } else { Self { centre: eye, radius } }
    }

    /// The smallest ball around two eyes.
    #[must_use]
    pub fn around(a: [f64; 3], b: [f64; 3]) -> Self {
        let centre = array::from_fn(|i| a[i] * 0.5 + b[i] * 0.5);
        Self { centre, radius: distance(a, b) * 0.5 }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_stays_while_the_eye_is_in_it() {
        let ball = EyeBall { centre: [1.0, 0.0, 0.0], radius: 2.0 };
        assert_eq!(ball.follow([2.5, 0.0, 0.0], 5.0), ball);
        let next = EyeBall { centre: [3.5, 0.0, 0.0], radius: 5.0 };
        assert_eq!(ball.follow([3.5, 0.0, 0.0], 5.0), next);
        let not_finite = EyeBall { centre: [f64::NAN; 3], radius: 1.0 };
        assert_eq!(not_finite.follow([0.0; 3], 1.0).centre, [0.0; 3]);
    }

    #[test]
    fn a_ball_around_two_eyes_touches_both() {
        let ball = EyeBall::around([0.0, 3.0, 0.0], [4.0, 3.0, 0.0]);
        assert_eq!(ball, EyeBall { centre: [2.0, 3.0, 0.0], radius: 2.0 });
    }
}
