//! Views of every kind and what stands in them, for properties of proptest.

use cullet::{Camera, Depth, Projection, Transform, View, view::FrontFace};
use glam::{DMat3, DMat4, DQuat, DVec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// How a property is tried: cases enough to meet each kind of projection many times, few enough for seconds;
/// always the same, unless `CULLET_CASES` sets more.
pub fn config(n: u32) -> ProptestConfig {
    let cases = crate::cases(n);
    let rng_seed = if cases > n { RngSeed::Random } else { RngSeed::Fixed(1) };
    ProptestConfig {
        cases,
        rng_seed,
        max_global_rejects: cases * 8,
        max_local_rejects: 1 << 20,
        // Nothing is written beside the sources; a failing case prints its own numbers.
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// In the cube from −`reach` to `reach`.
pub fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    [-reach..reach, -reach..reach, -reach..reach].prop_map(DVec3::from)
}

/// Generates directions of unit length.
pub fn direction() -> impl Strategy<Value = DVec3> {
    vector(1.0).prop_filter_map("no direction", |v| {
        (v.length() > 0.1 && v.length() < 1.0).then(|| v.normalize())
    })
}

/// About any axis.
pub fn rotation() -> impl Strategy<Value = DQuat> {
    (direction(), -3.1..3.1).prop_map(|(axis, angle)| DQuat::from_axis_angle(axis, angle))
}

/// Either way.
pub fn depth() -> impl Strategy<Value = Depth> {
    prop_oneof![Just(Depth::Standard), Just(Depth::Reversed)]
}

fn far() -> impl Strategy<Value = f64> {
    prop_oneof![3.0..1000.0, Just(f64::INFINITY)]
}

/// Every kind of projection, mirrored windows among them, near at 0.1 to 2 units.
pub fn projection() -> impl Strategy<Value = Projection> {
    let window = || (-1.0..0.8, 0.2..1.5, -1.0..0.8, 0.2..1.5, any::<bool>(), any::<bool>());
    let place = |(x, w, y, h, flip_x, flip_y): (f64, f64, f64, f64, bool, bool)| {
        let (l, r) = if flip_x { (x + w, x) } else { (x, x + w) };
        let (b, t) = if flip_y { (y + h, y) } else { (y, y + h) };
        (l, r, b, t)
    };
    prop_oneof![
        (0.1..2.8, 0.3..3.0, 0.1..2.0, far()).prop_map(|(fov_y_radians, aspect, near, far)| {
            Projection::Perspective { fov_y_radians, aspect, near, far }
        }),
        (window(), 0.1..2.0, far()).prop_map(move |(w, near, far)| {
            let (left, right, bottom, top) = place(w);
            Projection::OffCentre { left, right, bottom, top, near, far }
        }),
        (window(), -5.0..5.0, 0.5..100.0).prop_map(move |(w, near, depth)| {
            let (left, right, bottom, top) = place(w);
            Projection::Orthographic { left, right, bottom, top, near, far: near + depth }
        }),
    ]
}

/// A camera of any projection within `reach` units of the origin.
pub fn camera(reach: f64) -> impl Strategy<Value = Camera> {
    (vector(reach), direction(), direction(), projection())
        .prop_filter("up along direction", |(_, d, up, _)| d.cross(*up).length() > 0.1)
        .prop_map(|(eye, d, up, projection)| Camera {
            eye: eye.into(),
            direction: (d * 3.0).into(),
            up: (up * 0.5).into(),
            projection,
        })
}

/// The same camera with every length times `s`.
pub fn scaled(c: &Camera, s: f64) -> Camera {
    let projection = match c.projection {
        Projection::Perspective { fov_y_radians, aspect, near, far } => {
            Projection::Perspective { fov_y_radians, aspect, near: near * s, far: far * s }
        }
        Projection::OffCentre { left, right, bottom, top, near, far } => Projection::OffCentre {
            left: left * s,
            right: right * s,
            bottom: bottom * s,
            top: top * s,
            near: near * s,
            far: far * s,
        },
        Projection::Orthographic { left, right, bottom, top, near, far } => {
            Projection::Orthographic {
                left: left * s,
                right: right * s,
                bottom: bottom * s,
                top: top * s,
                near: near * s,
                far: far * s,
            }
        }
    };
    Camera { eye: c.eye.map(|v| v * s), projection, ..*c }
}

/// Tiny, ordinary, large and huge worlds.
pub fn scale() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1e-12), Just(1e-3), Just(1.0), Just(1e7), Just(1e17)]
}

/// Any affine transform: turned, sheared by unequal scales, mirrored, almost and wholly singular.
pub fn transform() -> impl Strategy<Value = Transform> {
    let factor = || prop_oneof![4 => 0.2..5.0, 2 => -5.0..-0.2, 1 => 1e-7..1e-4, 1 => Just(0.0)];
    (rotation(), rotation(), [factor(), factor(), factor()], vector(10.0)).prop_map(
        |(q, r, s, t)| {
            let m = DMat3::from_quat(q) * DMat3::from_diagonal(s.into()) * DMat3::from_quat(r);
            Transform {
                linear: m.to_cols_array_2d().map(|c| c.map(|v| v as f32)),
                translation: t.into(),
            }
        },
    )
}

/// The view of a camera.
///
/// # Panics
///
/// For a camera that makes none.
pub fn view_of(camera: &Camera, depth: Depth) -> View {
    View::new(camera, depth, [640, 480]).expect("a random camera makes a view")
}

/// Its matrix.
pub fn clip_from_world(view: &View) -> DMat4 {
    DMat4::from_cols_array(&view.clip_from_world())
}

/// The point at these coordinates in the volume: 0..1 from left to right, bottom to top, near to
/// far (at most 50 times the near distance from the near plane), by the camera alone.
///
/// # Panics
///
/// For a camera that has no axes.
pub fn point_in(camera: &Camera, at: [f64; 3]) -> DVec3 {
    let [r, u, back] = camera.basis().expect("a random camera has axes").map(DVec3::from);
    let (l, rt, b, t, near, far, perspective) = match camera.projection {
        Projection::Perspective { fov_y_radians, aspect, near, far } => {
            let h = near * (fov_y_radians * 0.5).tan();
            (-h * aspect, h * aspect, -h, h, near, far, true)
        }
        Projection::OffCentre { left, right, bottom, top, near, far } => {
            (left, right, bottom, top, near, far, true)
        }
        Projection::Orthographic { left, right, bottom, top, near, far } => {
            (left, right, bottom, top, near, far, false)
        }
    };
    let far = if perspective { far.min(near * 51.0) } else { far };
    let distance = near + (far - near) * at[2];
    let spread = if perspective { distance / near } else { 1.0 };
    let (x, y) = (l + (rt - l) * at[0], b + (t - b) * at[1]);
    DVec3::from(camera.eye) + (r * x + u * y) * spread - back * distance
}

/// Numbers of which many coincide, so that vertices lie on planes; and numbers of which none do.
pub fn number() -> impl Strategy<Value = f64> {
    prop_oneof![(-4..=4_i32).prop_map(f64::from), -4.0..4.0f64]
}

/// A point of such numbers.
pub fn point<const D: usize>() -> impl Strategy<Value = [f64; D]> {
    prop::collection::vec(number(), D).prop_map(|v| std::array::from_fn(|i| v[i]))
}

fn array() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.0..1.0f64)
}

fn distant_place() -> impl Strategy<Value = [f64; 3]> {
    (array(), 0..8i32).prop_map(|(v, e)| v.map(|v| v * 10f64.powi(e)))
}

/// Every kind of projection, in wider ranges than [`projection`]: near at 0.001, narrow and very wide.
fn extreme_projection() -> impl Strategy<Value = Projection> {
    let far = prop_oneof![Just(f64::INFINITY), 10.0..1e5];
    let window = || (0.01..2.0f64, 0.01..2.0f64, -1.0..1.0f64, -1.0..1.0f64, any::<bool>());
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

/// A view of any projection, from anywhere up to 1e7 units away.
pub fn distant_view() -> impl Strategy<Value = View> {
    let front = prop_oneof![Just(FrontFace::CounterClockwise), Just(FrontFace::Clockwise)];
    (distant_place(), array(), extreme_projection(), depth(), front).prop_filter_map(
        "no orientation",
        |(eye, direction, projection, depth, front)| {
            let camera = Camera { eye, direction, up: [0.1, 1.0, 0.2], projection };
            let mut view = View::new(&camera, depth, [640, 480]).ok()?;
            view.front_face = front;
            Some(view)
        },
    )
}

/// Affine, mirrored and sheared, near the origin or up to 1e7 units away.
pub fn distant_transform() -> impl Strategy<Value = Transform> {
    let linear = prop::array::uniform3(prop::array::uniform3(-2.0..2.0f32));
    let diagonal = prop::array::uniform3(prop_oneof![-3.0..3.0f32, Just(0.0f32), Just(1e-6f32)])
        .prop_map(|d| Transform::from_scale_translation(d, [0.0; 3]).linear);
    (prop_oneof![linear, diagonal], distant_place())
        .prop_map(|(linear, translation)| Transform { linear, translation })
}

/// Triangles of any size and place, some of them slivers.
pub fn corners() -> impl Strategy<Value = [[f32; 3]; 3]> {
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
