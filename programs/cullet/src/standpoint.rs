//! Where to stand before a model that was cut open, to look into it.

use cullet::View;
use cullet::bounds::Aabb;
use cullet_command::exit::Failure;
use cullet_cut::{Keep, ModelOptions};
use cullet_io::Model;
use cullet_scenes::paths;
use glam::{DMat3, DVec3};

/// The vertical field of view: narrow, so that the cut keeps its shape.
const FOV_DEGREES: f64 = 35.0;

/// The view from a point to another; without, from where the model was opened.
pub fn stand(
    model: &Model,
    whole: &Aabb,
    options: &ModelOptions<'_>,
    eye: Option<([f64; 3], [f64; 3])>,
    size: [u32; 2],
) -> Result<View, Failure> {
    let (eye, target) = eye.unwrap_or_else(|| place(model, whole, options, size));
    let overrides =
        paths::Overrides { fov_degrees: Some(FOV_DEGREES), ..paths::Overrides::default() };
    let camera = paths::look_at(model, eye, target, size, &overrides).map_err(Failure::usage)?;
    View::new(&camera, overrides.depth, size).map_err(Failure::usage)
}

/// After so many moves nothing changes that could be seen.
const RECENTRINGS: usize = 3;

/// Above and to the side of the cut, far enough for all that is left.
fn place(
    model: &Model,
    whole: &Aabb,
    options: &ModelOptions<'_>,
    size: [u32; 2],
) -> ([f64; 3], [f64; 3]) {
    let left = model.scene.extent();
    let shown = if left.is_empty() { whole } else { &left };
    let centre = DVec3::from(shown.center());
    let reach = DVec3::from(shown.half_extent()).length().max(1e-6);
    // A region's faces point all ways; of a box the corner towards +X, +Y and +Z is opened.
    let mut open = DVec3::ZERO;
    if let [plane] = options.planes {
        open = DVec3::from(plane.normal).normalize_or_zero();
        if options.keep == Keep::Outside {
            open = -open;
        }
    }
    let towards = if open.y.abs() > 0.8 {
        // From the longer side, which then lies along the picture's width.
        let half = shown.half_extent();
        let long = if half[0] >= half[2] { [0.28, 0.75] } else { [0.75, 0.28] };
        open * 1.1 + DVec3::new(long[0], 0.0, long[1])
    } else if open == DVec3::ZERO {
        DVec3::new(0.6, 0.6, 0.8)
    } else {
        let side = open.cross(DVec3::Y).normalize_or(DVec3::X);
        open + DVec3::Y * 0.5 - side * 0.45
    };
    let towards = towards.normalize();
    let right = DVec3::Y.cross(towards).normalize_or(DVec3::X);
    let up = towards.cross(right);
    let high = (FOV_DEGREES * 0.5).to_radians().tan() * 0.92;
    let wide = high * f64::from(size[0]) / f64::from(size[1]);
    let mut target = centre + DVec3::from(model.scene.origin());
    // So far that every vertex is within the picture, with a little air.
    let far_enough = |target: DVec3| {
        let mut distance = reach * 1e-3;
        each_vertex(model, |p| {
            let from = p - target;
            let aside = (from.dot(right).abs() / wide).max(from.dot(up).abs() / high);
            // False for what is not finite.
            if aside + from.dot(towards) > distance {
                distance = aside + from.dot(towards);
            }
        });
        distance
    };
    let mut distance = far_enough(target);
    // Nearer parts look larger, so the middle of the box is not that of the picture: moved there, there is
    // room to come nearer.
    for _ in 0..RECENTRINGS {
        let (mut low, mut top) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        each_vertex(model, |p| {
            let from = p - target;
            let depth = distance - from.dot(towards);
            for (i, axis) in [right, up].into_iter().enumerate() {
                let v = from.dot(axis) / depth;
                (low[i], top[i]) = (low[i].min(v), top[i].max(v));
            }
        });
        let shift = |i: usize| (low[i] + top[i]) * 0.5 * distance;
        let moved = target + right * shift(0) + up * shift(1);
        if !moved.is_finite() {
            break;
        }
        (target, distance) = (moved, far_enough(moved));
    }
    ((target + towards * distance).into(), target.into())
}

/// Every vertex of every instance in the world.
fn each_vertex(model: &Model, mut visit: impl FnMut(DVec3)) {
    for slot in model.scene.slots() {
        let t = model.scene.transform(slot);
        let linear = DMat3::from_cols_array_2d(&t.linear.map(|c| c.map(f64::from)));
        for &p in model.scene.mesh(slot).positions() {
            visit(linear * DVec3::from(p.map(f64::from)) + DVec3::from(t.translation));
        }
    }
}
