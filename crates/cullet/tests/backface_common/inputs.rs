//! Views, transforms and triangles of any kind.

use cullet::{Camera, Depth, FrontFace, Projection, Transform, View};
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = f64> {
    -1.0..1.0f64
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(unit())
}

/// Any projection there is: symmetric, off-centre, orthographic, mirrored, near or without an end.
fn projection() -> impl Strategy<Value = Projection> {
    let far = prop_oneof![Just(f64::INFINITY), 10.0..1e5];
    let window = || (0.01..2.0f64, 0.01..2.0f64, unit(), unit(), any::<bool>());
    prop_oneof![
        (0.05..3.0f64, 0.2..4.0f64, 0.001..1.0f64, far.clone()).prop_map(
            |(fov_y_radians, aspect, near, far)| Projection::Perspective {
                fov_y_radians,
                aspect,
                near,
                far
            }
        ),
        (window(), 0.01..1.0f64, far).prop_map(|((w, h, x, y, mirror), near, far)| {
            let (left, right) = (x - w, x + w);
            let (left, right) = if mirror { (right, left) } else { (left, right) };
            Projection::OffCentre { left, right, bottom: y - h, top: y + h, near, far }
        }),
        (window(), -5.0..5.0f64, 1.0..1e3f64).prop_map(|((w, h, x, y, mirror), near, depth)| {
            let (left, right) = if mirror { (x + w, x - w) } else { (x - w, x + w) };
            let far = near + depth;
            Projection::Orthographic { left, right, bottom: y - h, top: y + h, near, far }
        }),
    ]
}

pub(crate) fn view() -> impl Strategy<Value = View> {
    let place = (vector(), 0..8i32).prop_map(|(v, e)| v.map(|v| v * 10f64.powi(e)));
    let depth = prop_oneof![Just(Depth::Standard), Just(Depth::Reversed)];
    let front = prop_oneof![Just(FrontFace::CounterClockwise), Just(FrontFace::Clockwise)];
    (place, vector(), projection(), depth, front).prop_filter_map(
        "no orientation",
        |(eye, direction, projection, depth, front)| {
            let camera = Camera { eye, direction, up: [0.1, 1.0, 0.2], projection };
            let mut view = View::new(&camera, depth, [640, 480]).ok()?;
            view.front_face = front;
            Some(view)
        },
    )
}

/// Affine, mirrored and sheared, near the eye or anywhere.
pub(crate) fn transform() -> impl Strategy<Value = Transform> {
    let linear = prop::array::uniform3(prop::array::uniform3(-2.0..2.0f32));
    let place = (vector(), 0..8i32).prop_map(|(v, e)| v.map(|v| v * 10f64.powi(e)));
    let diagonal = prop::array::uniform3(prop_oneof![-3.0..3.0f32, Just(0.0f32), Just(1e-6f32)])
        .prop_map(|d| Transform::from_scale_translation(d, [0.0; 3]).linear);
    (prop_oneof![linear, diagonal], place)
        .prop_map(|(linear, translation)| Transform { linear, translation })
}

/// Triangles of any size and place, some of them slivers.
pub(crate) fn corners() -> impl Strategy<Value = [[f32; 3]; 3]> {
    let point = || prop::array::uniform3(-1.0..1.0f32);
    (point(), point(), point(), -6..6i32, -8..1i32, any::<bool>()).prop_map(
        |(a, b, c, place, size, sliver)| {
            let (place, size) = (10f32.powi(place), 10f32.powi(size));
            let c = if sliver { [0, 1, 2].map(|i| b[i] * 0.5 + c[i] * 1e-6) } else { c };
            let at = |p: [f32; 3]| [0, 1, 2].map(|i| (a[i] + p[i] * size) * place);
            [at([0.0; 3]), at(b), at(c)]
        },
    )
}
