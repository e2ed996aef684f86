//! Cameras of the model, and moving between keys.

use cullet::math;
use cullet::{Camera, Projection, Transform};
use glam::DVec3;

use super::{Lens, PathError};
use cullet_io::{CameraNode, Model};

/// A place and an orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub(super) eye: DVec3,
    pub(super) direction: DVec3,
    pub(super) up: DVec3,
}

impl Pose {
    /// Between two poses: straight for the eye, along the arc for direction and up.
    pub(super) fn between(&self, other: &Self, t: f64) -> Self {
        Self {
            eye: self.eye.lerp(other.eye, t),
            direction: arc(self.direction, other.direction, t),
            up: arc(self.up, other.up, t),
        }
    }

    fn of(t: &Transform) -> Self {
        let column = |c: usize| DVec3::from(t.linear[c].map(f64::from));
        Self { eye: t.translation.into(), direction: -column(2), up: column(1) }
    }
}

/// The direction a part `t` of the way from `a` to `b`; along a straight line, so not at even
/// speed, where they are nearly opposite or have no direction.
fn arc(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    let (a, b) = (a.normalize_or(a), b.normalize_or(b));
    let angle = math::acos(a.dot(b).clamp(-1.0, 1.0));
    let sin = math::sin(angle);
    if sin < 1e-6 {
        return a.lerp(b, t);
    }
    (a * math::sin((1.0 - t) * angle) + b * math::sin(t * angle)) / sin
}

/// `count` times from the first to the last, evenly; and which keys each lies between, and how far
/// on. Keys ascend in time.
pub(super) fn sample(times: &[f64], count: usize) -> Vec<(usize, usize, f64)> {
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Vec::new() };
    let at = |i: usize| {
        let t = first + (last - first) * i as f64 / (count.max(2) - 1) as f64;
        let next = times.partition_point(|k| *k <= t).min(times.len() - 1);
        let key = next.saturating_sub(1);
        let step = times[next] - times[key];
        let part = if step > 0.0 { ((t - times[key]) / step).clamp(0.0, 1.0) } else { 1.0 };
        (key, next, part)
    };
    (0..count).map(at).collect()
}

/// At most `count` of `len`, evenly spread, the first and the last among them if there are two or
/// more.
pub(super) fn spread(len: usize, count: usize) -> impl Iterator<Item = usize> {
    let taken = count.min(len);
    (0..taken).map(move |i| if taken == 1 { 0 } else { i * (len - 1) / (taken - 1) })
}

/// The cameras of `camera:NAME`, or of all with `*`.
pub(super) fn model_cameras(
    model: &Model,
    name: &str,
    lens: &Lens,
    count: usize,
) -> Result<Vec<Camera>, PathError> {
    let known = || match model.cameras.len() {
        0 => "it has none: try orbit, walk or fly".to_owned(),
        n => {
            let names: Vec<_> = model.cameras.iter().take(40).map(|c| c.name.as_str()).collect();
            let more = if n > 40 { format!(" and {} more", n - 40) } else { String::new() };
            format!("it has {}{more}", names.join(", "))
        }
    };
    let no_camera = || PathError::NoCamera { name: name.to_owned(), known: known() };
    if name == "*" {
        if model.cameras.is_empty() {
            return Err(no_camera());
        }
        let one = |i: usize| {
            let node = &model.cameras[i];
            let (_, first) =
                node.keys.first().ok_or_else(|| PathError::NoKeys(node.name.clone()))?;
            camera(node, &Pose::of(first), lens)
        };
        return spread(model.cameras.len(), count).map(one).collect();
    }
    let node = model.cameras.iter().find(|c| c.name == name).ok_or_else(no_camera)?;
    let mut keys = node.keys.clone();
    keys.sort_by(|a, b| a.0.total_cmp(&b.0));
    let times: Vec<f64> = keys.iter().map(|k| k.0).collect();
    let samples = match keys.len() {
        0 => return Err(PathError::NoKeys(name.to_owned())),
        1 => sample(&times, 1),
        _ => sample(&times, count),
    };
    let pose = |key: usize| Pose::of(&keys[key].1);
    let at = |(a, b, t): &(usize, usize, f64)| camera(node, &pose(*a).between(&pose(*b), *t), lens);
    samples.iter().map(at).collect()
}

/// The camera of a node in a pose. Its own near and far are kept unless the caller gives others.
fn camera(node: &CameraNode, pose: &Pose, lens: &Lens) -> Result<Camera, PathError> {
    let o = &lens.overrides;
    let mut projection = node.projection;
    match &mut projection {
        Projection::Perspective { fov_y_radians, aspect, near, far } => {
            *fov_y_radians = o.fov_degrees.map_or(*fov_y_radians, f64::to_radians);
            // The picture has the shape of the viewport: a file's aspect would stretch it.
            *aspect = lens.aspect;
            *near = o.near.unwrap_or(*near);
            *far = o.far.unwrap_or(*far);
        }
        Projection::OffCentre { .. } | Projection::Orthographic { .. }
            if o.fov_degrees.is_some() =>
        {
            return Err(PathError::NoFov(node.name.clone()));
        }
        Projection::OffCentre { left, right, bottom, top, near, far } => {
            // The window lies on the near plane, so it moves with it.
            let by = o.near.map_or(1.0, |n| n / *near);
            [left, right, bottom, top].into_iter().for_each(|v| *v *= by);
            *near *= by;
            *far = o.far.unwrap_or(*far);
        }
        Projection::Orthographic { left, right, bottom, top, near, far } => {
            let middle = (*left + *right) * 0.5;
            let half = (*top - *bottom).abs() * 0.5 * lens.aspect * (*right - *left).signum();
            (*left, *right) = (middle - half, middle + half);
            *near = o.near.unwrap_or(*near);
            *far = o.far.unwrap_or(*far);
        }
    }
    let Pose { eye, direction, up } = *pose;
    Ok(Camera { eye: eye.into(), direction: direction.into(), up: up.into(), projection })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_begin_and_end_at_the_keys() {
        assert_eq!(sample(&[], 3), []);
        assert_eq!(sample(&[5.0], 1), [(0, 0, 1.0)]);
        let s = sample(&[0.0, 1.0, 3.0], 4);
        assert_eq!(s, [(0, 1, 0.0), (1, 2, 0.0), (1, 2, 0.5), (1, 2, 1.0)]);
        // Two keys at one time are a cut.
        assert_eq!(sample(&[0.0, 1.0, 1.0, 2.0], 3)[1], (2, 3, 0.0));
    }

    #[test]
    fn spread_takes_the_ends() {
        assert_eq!(spread(5, 16).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        assert_eq!(spread(100, 3).collect::<Vec<_>>(), [0, 49, 99]);
        assert_eq!(spread(100, 1).collect::<Vec<_>>(), [0]);
        assert_eq!(spread(0, 3).count(), 0);
    }

    #[test]
    fn arcs_are_even() {
        let half = arc(DVec3::X, DVec3::Y * 2.0, 1.0 / 3.0);
        assert!((half.x - (std::f64::consts::PI / 6.0).cos()).abs() < 1e-12);
        assert!(arc(DVec3::X, -DVec3::X, 0.25).is_finite());
        assert!(arc(DVec3::ZERO, DVec3::X, 0.5).is_finite());
    }
}
