//! The test after projection, as graphics hardware does it: the winding on the screen.

use cullet::cull::backface::Facing;
use cullet::{Transform, View, view::FrontFace};
use glam::DVec3;

/// Whether what is counter-clockwise in object space is clockwise on the screen (y up): a mirrored
/// projection or a mirrored instance does that, both together do not. The sign of the transform's
/// determinant is exact.
#[must_use]
pub fn flips_winding(view: &View, transform: &Transform) -> bool {
    view.is_mirrored() != transform.is_mirrored()
}

/// Twice the signed area of a triangle on the screen: the z of its normal in normalised device
/// coordinates with y up, positive for counter-clockwise. Only of use where every w was above 0.
#[must_use]
pub fn ndc_normal_z(ndc: &[[f64; 2]; 3]) -> f64 {
    let [a, b, c] = *ndc;
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the side of a triangle that is seen, from its corners in clip space.
///
/// The determinant of (x, y, w) of the corners decides: it is [`ndc_normal_z`] times all three w
/// where those are positive, and it stays right where some corner is beside or behind the eye
/// (Olano & Greer, *Triangle Scan Conversion using 2D Homogeneous Coordinates*, 1997). `flipped`
/// comes from [`flips_winding`]. A triangle within rounding of edge-on, or not finite, is
/// [`Facing::Edge`].
#[must_use]
pub fn screen_facing(clip: &[[f64; 4]; 3], flipped: bool, front_face: FrontFace) -> Facing {
    let [a, b, c] = clip.map(|p| DVec3::new(p[0], p[1], p[3]));
    let value = a.dot(b.cross(c));
    let size = |p: f64, q: f64, r: f64, s: f64| (p * s).abs() + (q * r).abs();
    let sizes =
        DVec3::new(size(b.y, b.z, c.y, c.z), size(b.z, b.x, c.z, c.x), size(b.x, b.y, c.x, c.y));
    let error = a.abs().dot(sizes) * (8.0 * f64::EPSILON) + f64::MIN_POSITIVE;
    Facing::from_value(if flipped { -value } else { value }, error, front_face)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CCW: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

    fn clip(ndc: [[f64; 2]; 3], w: [f64; 3]) -> [[f64; 4]; 3] {
        std::array::from_fn(|i| [ndc[i][0] * w[i], ndc[i][1] * w[i], 0.5 * w[i], w[i]])
    }

    #[test]
    fn counter_clockwise_with_y_up_has_a_positive_normal() {
        assert_eq!(ndc_normal_z(&CCW), 1.0);
        let front = screen_facing(&clip(CCW, [1.0, 2.0, 3.0]), false, FrontFace::default());
        assert_eq!(front, Facing::Front);
    }

    #[test]
    fn mirroring_and_winding_each_turn_the_answer() {
        let c = clip(CCW, [1.0; 3]);
        assert_eq!(screen_facing(&c, true, FrontFace::CounterClockwise), Facing::Back);
        assert_eq!(screen_facing(&c, false, FrontFace::Clockwise), Facing::Back);
        assert_eq!(screen_facing(&c, true, FrontFace::Clockwise), Facing::Front);
    }

    #[test]
    fn a_corner_behind_the_eye_turns_the_normal_but_not_the_determinant() {
        // A floor below the eye, seen from above, that reaches behind it: x right, w forward, y =
        // −1.
        let clip = [[-1.0, -1.0, 0.0, 2.0], [1.0, -1.0, 0.0, 2.0], [0.0, -1.0, 0.0, -3.0]];
        // Before the eye the same plane shows the order left, right, far.
        let ahead = [clip[0], clip[1], [0.0, -1.0, 0.0, 9.0]];
        let ndc = |c: [[f64; 4]; 3]| c.map(|p| [p[0] / p[3], p[1] / p[3]]);
        assert!(ndc_normal_z(&ndc(ahead)) > 0.0);
        assert_eq!(screen_facing(&ahead, false, FrontFace::default()), Facing::Front);
        // The corner behind exchanges the order in which the plane is walked: its back is seen.
        assert_eq!(screen_facing(&clip, false, FrontFace::default()), Facing::Back);
        assert!(ndc_normal_z(&ndc(clip)) > 0.0);
    }

    #[test]
    fn edge_on_and_nan_are_kept() {
        let edge = clip([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], [1.0; 3]);
        assert_eq!(screen_facing(&edge, false, FrontFace::default()), Facing::Edge);
        let nan = clip([[f64::NAN, 0.0], [1.0, 1.0], [2.0, 0.0]], [1.0; 3]);
        assert_eq!(screen_facing(&nan, false, FrontFace::default()), Facing::Edge);
    }
}
