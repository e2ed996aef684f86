//! Godot's values as the engine's.

use cullet::Transform;
use cullet::bounds::Aabb;
use godot::builtin::{Aabb as GodotAabb, Transform3D, Vector3};

/// Returns a transform as the engine has it.
pub(crate) fn transform(t: &Transform3D) -> Transform {
    let linear = [t.basis.col_a(), t.basis.col_b(), t.basis.col_c()].map(array);
    Transform { linear, translation: array(t.origin).map(f64::from) }
}

/// Returns the components of a vector.
pub(crate) fn array(v: Vector3) -> [f32; 3] {
    [v.x, v.y, v.z]
}

/// Returns the components of a point in f64.
pub(crate) fn point(v: Vector3) -> [f64; 3] {
    array(v).map(f64::from)
}

/// Grown bounds of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Grown {
    /// World units on every side.
    pub(crate) margin: f32,
    /// Whether the node turns around its own origin as the camera moves, so that only a ball around
    /// the origin holds it.
    pub(crate) is_ball: bool,
}

/// Returns a box in world space around `local`, which lies in the space of `at`; `None` where the
/// numbers make none, so that the node is kept whatever happens.
pub(crate) fn world_box(local: &GodotAabb, at: &Transform3D, grown: Grown) -> Option<Aabb> {
    let t = transform(at);
    let (low, size) = (array(local.position).map(f64::from), array(local.size).map(f64::from));
    let half = size.map(|s| s.abs() * 0.5);
    let centre: [f64; 3] = std::array::from_fn(|a| low[a] + size[a] * 0.5);
    let linear = t.linear.map(|column| column.map(f64::from));
    let (mut min, mut max) = ([0.0; 3], [0.0; 3]);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    // Turned about its origin, a point stays within its own distance from it, at the largest scale.
    let reach = length(std::array::from_fn(|a| centre[a].abs() + half[a]));
    let ball = reach * linear.map(length).into_iter().fold(0.0, f64::max);
    for row in 0..3 {
        let middle = t.translation[row] + (0..3).map(|c| linear[c][row] * centre[c]).sum::<f64>();
        let extent = (0..3).map(|c| linear[c][row].abs() * half[c]).sum::<f64>();
        let (middle, extent) =
            if grown.is_ball { (t.translation[row], ball) } else { (middle, extent) };
        // Graphics cards compute places in f32: some units in the last place of the largest term.
        let terms = t.translation[row].abs() + ball + middle.abs() + extent;
        let slack = f64::from(grown.margin.max(0.0)) + terms * 4.0 * f64::from(f32::EPSILON);
        min[row] = middle - extent - slack;
        max[row] = middle + extent + slack;
    }
    let is_known = min.iter().chain(&max).all(|v| v.is_finite()) && !grown.margin.is_nan();
    let bounds = is_known.then(|| Aabb::rounded_out(min, max))?;
    (bounds.is_finite() && !bounds.is_empty()).then_some(bounds)
}

/// Whether every number of a transform is finite.
pub(crate) fn is_finite(t: &Transform3D) -> bool {
    let axes = [t.basis.col_a(), t.basis.col_b(), t.basis.col_c(), t.origin];
    axes.into_iter().all(|v| array(v).iter().all(|c| c.is_finite()))
}
