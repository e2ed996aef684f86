//! Convex bodies made smaller: what is left of one when all its faces move inward.
//!
//! What is left is not built as a body of its own. It is drawn as the same body under another
//! transform, whose image lies within it: so its faces stay exactly flat and its corners exactly
//! convex, as drawing takes them to be, and nothing is allocated. Of a box, however scaled and
//! sheared, that image is all that is left; of any other body it is the larger of two: the body
//! made smaller along the axes of its mesh, or evenly about its middle.

use cullet::Transform;
use cullet::cull::occlusion::Convex;
use glam::{DMat3, DVec3};

use super::super::linear::{length, linear};

/// A face whose three corners span less, as a share of the square of the body's size, has a normal
/// of which rounding leaves too little.
const LEAST_AREA: f64 = 1e-7;

/// Error that rounding causes in the distance of a face from the middle, as a share of the body's
/// size. The normal of a face of [`LEAST_AREA`] is off by some 1e-7.
const ROUNDING: f64 = 4e-7;

/// How much further than asked for faces move, as a share of the body's size: more than
/// [`ROUNDING`] and that of the linear part to f32.
const MARGIN: f64 = 2e-6;

/// Times that the scale along the axes is sought by halving.
const HALVINGS: u32 = 6;

/// The faces of a body in the world, about the mean of its corners, which is within: the middle of
/// its box need not be.
struct Faces<'a> {
    body: &'a Convex,
    linear: DMat3,
    /// In the space of the mesh.
    middle: DVec3,
    /// No corner is farther from the middle.
    size: f64,
}

impl<'a> Faces<'a> {
    /// `None` for polygons and for what is not finite.
    fn new(body: &'a Convex, transform: &Transform) -> Option<Self> {
        if !is_closed(body) || !transform.is_finite() {
            return None;
        }
        let sum: DVec3 = body.vertices().iter().map(|v| DVec3::from(v.map(f64::from))).sum();
        let middle = sum / body.vertices().len() as f64;
        let mut faces = Self { body, linear: linear(transform), middle, size: 0.0 };
        faces.size = faces.corners().map(|v| length(faces.linear * v)).fold(0.0, f64::max);
        (faces.size > 0.0 && faces.size.is_finite()).then_some(faces)
    }

    fn corner(&self, vertex: u32) -> DVec3 {
        DVec3::from(self.body.vertices()[vertex as usize].map(f64::from)) - self.middle
    }

    /// All corners from the middle, not transformed.
    fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.body.vertices().len() as u32).map(|v| self.corner(v))
    }

    /// The unit normal of each face, outward, and its distance from the middle; `None` for a face
    /// that rounding hides.
    fn planes(&self) -> impl Iterator<Item = Option<(DVec3, f64)>> + '_ {
        self.body.faces().map(|(corners, _)| {
            let [a, b, c] = corners.map(|v| self.linear * self.corner(v));
            let normal = (b - a).cross(c - a);
            let area = length(normal);
            if area.is_nan() || area < LEAST_AREA * self.size * self.size {
                return None;
            }
            // The middle is within, so that mirrored bodies need no word.
            let normal = normal / area;
            let distance = normal.dot(a);
            Some(if distance < 0.0 { (-normal, -distance) } else { (normal, distance) })
        })
    }

    /// Whether the body under another linear part, its middle where it was, lies behind all of its
    /// own faces once each has moved inward by the extent of `by` along its normal.
    fn holds(&self, linear: DMat3, by: DVec3) -> bool {
        self.planes().all(|plane| {
            let Some((normal, distance)) = plane else { return false };
            let most = distance - normal.abs().dot(by) - ROUNDING * self.size;
            let along = linear.transpose() * normal;
            most > 0.0 && self.corners().all(|v| along.dot(v) <= most)
        })
    }

    /// The linear part with the axes of the mesh scaled, as a [`Transform`] has it.
    fn scaled(&self, scale: DVec3) -> DMat3 {
        let m = self.linear;
        let column = |c: DVec3| c.as_vec3().as_dvec3();
        DMat3::from_cols(
            column(m.x_axis * scale.x),
            column(m.y_axis * scale.y),
            column(m.z_axis * scale.z),
        )
    }

    /// Scale about the middle that leaves each face far enough inside.
    fn even_scale(&self, by: DVec3) -> Option<f64> {
        self.planes().try_fold(1.0_f64, |scale, plane| {
            let (normal, distance) = plane?;
            let inward = normal.abs().dot(by) + MARGIN * self.size;
            (distance > inward).then(|| scale.min(1.0 - inward / distance))
        })
    }

    /// Scales along the axes of the mesh: those that a box has, taken on towards nothing until the
    /// body fits.
    fn axis_scales(&self, by: DVec3) -> Option<DVec3> {
        let m = self.linear;
        let across = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let mut shares = [0.0; 3];
        for (share, normal) in shares.iter_mut().zip(across) {
            let length = length(normal);
            if length.is_nan() || length <= 0.0 {
                return None;
            }
            let normal = normal / length;
            let along = m.transpose() * normal;
            let half = self.corners().map(|v| along.dot(v).abs()).fold(0.0, f64::max);
            *share = (normal.abs().dot(by) + MARGIN * self.size) / half;
        }
        let shares = DVec3::from(shares);
        let least = 1.0 / shares.max_element();
        if least.is_nan() || least <= 1.0 {
            return None;
        }
        let at = |times: f64| DVec3::ONE - shares * times;
        let fits = |times: f64| self.holds(self.scaled(at(times)), by);
        if fits(1.0) {
            return Some(at(1.0));
        }
        let (mut low, mut high, mut found) = (1.0, least, None);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if fits(middle) {
                (high, found) = (middle, Some(at(middle)));
            } else {
                low = middle;
            }
        }
        found
    }
}

/// Whether `body` has an inside: it is not a polygon.
pub(super) fn is_closed(body: &Convex) -> bool {
    body.faces().nth(2).is_some()
}

/// Returns a transform under which `body` lies within what is left of it, as it stands at
/// `transform`, once each face has moved inward by the extent of a box of half sides `by`, in world
/// units, along its normal: wherever in such a box around a point of the shrunk body one is, one is
/// within the body.
///
/// `None` where nothing is left, or too little to be sure of; for polygons, which have no inside;
/// and where a number is not finite. Exact for boxes but for some millionths of their size. Cost:
/// faces times corners.
pub(super) fn shrunk(body: &Convex, by: [f64; 3], transform: &Transform) -> Option<Transform> {
    let faces = Faces::new(body, transform)?;
    let by = DVec3::from(by);
    if by == DVec3::ZERO {
        // What is flat has no inside.
        let has_depth = |(_, distance)| distance > ROUNDING * faces.size;
        return faces.planes().all(|plane| plane.is_some_and(has_depth)).then_some(*transform);
    }
    // A NaN fails here, and something negative would grow it.
    if !(by.min_element() >= 0.0 && by.is_finite()) {
        return None;
    }
    let even = faces.even_scale(by).map(DVec3::splat);
    let axes = faces.axis_scales(by);
    let scales = [axes, even];
    let best = scales.into_iter().flatten().max_by(|a, b| {
        let volume = |s: &DVec3| s.x * s.y * s.z;
        volume(a).total_cmp(&volume(b))
    })?;
    let linear = faces.scaled(best);
    if !faces.holds(linear, by) {
        return None;
    }
    let column = |c: DVec3| c.as_vec3().into();
    let translation = DVec3::from(transform.translation) + (faces.linear - linear) * faces.middle;
    translation.is_finite().then(|| Transform {
        linear: [column(linear.x_axis), column(linear.y_axis), column(linear.z_axis)],
        translation: translation.into(),
    })
}

/// Whether `body`, as it stands at `transform`, is proved to be farther than `distance` from a box
/// of half sides `by` around a point: by one of its faces. False where a number is not finite.
pub(super) fn is_apart(
    body: &Convex,
    transform: &Transform,
    point: [f64; 3],
    by: [f64; 3],
    distance: f64,
) -> bool {
    let Some(faces) = Faces::new(body, transform) else { return false };
    let middle = DVec3::from(transform.translation) + faces.linear * faces.middle;
    let (to, by) = (DVec3::from(point) - middle, DVec3::from(by));
    let slack = ROUNDING * (faces.size + length(to));
    faces
        .planes()
        .flatten()
        .any(|(normal, d)| normal.dot(to) - normal.abs().dot(by) - d > distance + slack)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::bounds::Aabb;

    fn corners_of(body: &Convex, at: &Transform) -> Vec<DVec3> {
        let place =
            |p: &[f32; 3]| linear(at) * DVec3::from(p.map(f64::from)) + DVec3::from(at.translation);
        body.vertices().iter().map(place).collect()
    }

    #[test]
    fn a_box_loses_what_is_asked_on_every_side_whatever_its_scale() {
        let body = Convex::from_box(&Aabb::new([3.0, 0.0, -1.0], [5.0, 1.0, 1.0])).unwrap();
        let at = Transform::from_scale_translation([4.0, -20.0, 0.5], [1e6, 7.0, -3.0]);
        let smaller = shrunk(&body, [0.25, 1.0, 0.125], &at).unwrap();
        let before = at.transform_box(&body.bounds(), at.translation);
        let after = smaller.transform_box(&body.bounds(), at.translation);
        for (axis, by) in [0.25, 1.0, 0.125].into_iter().enumerate() {
            for (a, b) in
                [(after.min[axis], before.min[axis] + by), (before.max[axis] - by, after.max[axis])]
            {
                assert!(a >= b - 1e-6 && a < b + 1e-3, "{axis}: {a} {b}");
            }
        }
        // Two of its half sides are 4 and 0.5: half a unit leaves nothing of it.
        assert_eq!(shrunk(&body, [0.0, 0.0, 0.5], &at), None);
        assert_eq!(shrunk(&body, [f64::NAN, 0.0, 0.0], &at), None);
        assert_eq!(shrunk(&body, [0.1, -0.1, 0.0], &at), None);
        assert_eq!(shrunk(&body, [0.0; 3], &at), Some(at));
    }

    #[test]
    fn polygons_and_flat_bodies_leave_nothing() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let polygon = Convex::from_polygon(&square).unwrap();
        let flat = Convex::from_box(&Aabb::new([0.0; 3], [1.0, 1.0, 0.0])).unwrap();
        let cube = Convex::from_box(&Aabb::new([0.0; 3], [1.0; 3])).unwrap();
        let flattened = Transform::from_scale_translation([1.0, 0.0, 1.0], [0.0; 3]);
        for (body, at) in
            [(&polygon, Transform::IDENTITY), (&flat, Transform::IDENTITY), (&cube, flattened)]
        {
            assert_eq!(shrunk(body, [1e-3; 3], &at), None);
            assert_eq!(shrunk(body, [0.0; 3], &at), None);
        }
        // As deep as rounding at any size is none; a small body has an inside.
        let scaled = |scale| Transform::from_scale_translation(scale, [0.0; 3]);
        assert_eq!(shrunk(&cube, [0.0; 3], &scaled([1e6, 1e6, 0.1])), None);
        assert!(shrunk(&cube, [0.0; 3], &scaled([1e-6; 3])).is_some());
    }

    #[test]
    fn what_is_as_far_as_asked_is_not_farther() {
        let cube = Convex::from_box(&Aabb::new([-0.5; 3], [0.5; 3])).unwrap();
        let is_apart = |x: f64, distance| {
            is_apart(&cube, &Transform::IDENTITY, [x, 0.1, 0.2], [0.25; 3], distance)
        };
        for x in [1.0, 1e3, 1e6] {
            let gap = x - 0.75;
            assert!(!is_apart(x, gap) && !is_apart(x, gap * (1.0 + 1e-6)), "{x}");
            assert!(!is_apart(x, gap - 1e-8 * x) && is_apart(x, gap - 1e-5 * x), "{x}");
        }
    }

    #[test]
    fn bodies_of_any_kind_lie_in_what_is_left_of_them() {
        // A gabled house, sheared; a pyramid; an eight-sided drum.
        let house = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [4.0, 0.0, 6.0],
            [0.0, 0.0, 6.0],
            [0.0, 2.0, 0.0],
            [4.0, 2.0, 0.0],
            [4.0, 2.0, 6.0],
            [0.0, 2.0, 6.0],
            [2.0, 3.5, 0.0],
            [2.0, 3.5, 6.0],
        ];
        let house_faces: [&[u32]; 7] = [
            &[0, 1, 2, 3],
            &[0, 4, 8, 5, 1],
            &[2, 6, 9, 7, 3],
            &[1, 5, 6, 2],
            &[3, 7, 4, 0],
            &[8, 9, 6, 5],
            &[4, 7, 9, 8],
        ];
        let pyramid: [&[u32]; 5] = [&[0, 1, 2, 3], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]];
        let pyramid_corners = [
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
            [1.0, 0.0, 1.0],
            [-1.0, 0.0, 1.0],
            [0.0, 3.0, 0.0],
        ];
        let build = |corners: &[[f32; 3]], faces: &[&[u32]]| {
            let fan = |f: &&[u32]| (2..f.len()).flat_map(|k| [f[0], f[k - 1], f[k]]).collect();
            let indices: Vec<Vec<u32>> = faces.iter().map(fan).collect();
            Convex::from_mesh(corners, &indices.concat()).unwrap()
        };
        let sheared = Transform {
            linear: [[1.0, 0.2, 0.0], [-0.3, 1.5, 0.1], [0.0, 0.4, -2.0]],
            translation: [10.0, 0.0, 5.0],
        };
        for (body, least) in
            [(build(&house, &house_faces), 0.3), (build(&pyramid_corners, &pyramid), 0.1)]
        {
            for at in [Transform::IDENTITY, sheared] {
                for by in [[0.1; 3], [0.2, 0.0, 0.05]] {
                    let smaller = shrunk(&body, by, &at).unwrap();
                    let faces = Faces::new(&body, &at).unwrap();
                    let middle = DVec3::from(at.translation) + faces.linear * faces.middle;
                    for corner in corners_of(&body, &smaller) {
                        for plane in faces.planes() {
                            let (normal, distance) = plane.unwrap();
                            let reach = normal.abs().dot(DVec3::from(by));
                            assert!(normal.dot(corner - middle) + reach <= distance);
                        }
                    }
                    let share = smaller.determinant() / at.determinant();
                    assert!(share > least && share < 1.0, "{share}");
                }
            }
        }
    }

    #[test]
    fn a_body_is_apart_from_a_box_by_one_of_its_faces() {
        let body = Convex::from_box(&Aabb::new([0.0; 3], [1.0; 3])).unwrap();
        let at = Transform::from_translation([100.0, 0.0, 0.0]);
        let apart = |x: f64, by: f64, distance: f64| {
            is_apart(&body, &at, [x, 0.5, 0.5], [by, 0.0, 0.0], distance)
        };
        assert!(apart(98.0, 0.5, 1.4) && !apart(98.0, 0.5, 1.6));
        assert!(!apart(100.5, 0.0, 0.0) && !apart(f64::NAN, 0.0, 0.0));
    }
}
