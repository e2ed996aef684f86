//! Ways of an eye: views from place to place, and steady starts and ends.

use cullet::{Camera, Depth, Projection, Scene, View};
use cullet_command::exit::Failure;
use cullet_draw::{PixelId, RenderOptions, Selection};
use glam::{DMat4, DVec3, DVec4};

/// From where to where one looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stand {
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
}

/// How a film is looked at: the angle, and from how near on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    pub(super) fov_y_radians: f64,
    pub(super) near: f64,
    pub(super) size: [u32; 2],
}

impl Lens {
    /// The view from a stand.
    pub(super) fn view(&self, stand: Stand) -> Result<View, Failure> {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
        let Self { fov_y_radians, near, .. } = *self;
        let projection =
            Projection::Perspective { fov_y_radians, aspect, near, far: f64::INFINITY };
        let camera = Camera::look_at(stand.eye, stand.target, projection);
        View::new(&camera, Depth::Reversed, self.size).map_err(Failure::input)
    }
}

/// Where a view stands, and a point at a distance along its line of sight.
pub(super) fn stand_of(view: &View, distance: f64) -> Option<Stand> {
    let [w, h] = view.viewport().map(|v| f64::from(v) * 0.5);
    let [x, y, z, one] = view.eye();
    let ray = view.ray([w, h]).filter(|_| one != 0.0)?;
    let eye = DVec3::new(x, y, z) / one;
    Some(Stand { eye, target: eye + DVec3::from(ray.direction) * distance })
}

/// How far the nearest surface is in the middle of a view, so that an eye may go there; infinite
/// where there is none.
pub(super) fn free_ahead(scene: &Scene, view: &View) -> f64 {
    let frame = cullet_draw::render(scene, view, Selection::All, &RenderOptions::default());
    let Some(Stand { eye, .. }) = stand_of(view, 1.0) else { return 0.0 };
    let [w, h] = [frame.width, frame.height];
    let mut nearest = f64::INFINITY;
    // The middle third both ways: an eye has a width.
    for y in h / 3..h - h / 3 {
        for x in w / 3..w - w / 3 {
            if frame.id(x, y) == PixelId::NONE {
                continue;
            }
            let depth = frame.depth[(y * w + x) as usize];
            if let Some(p) = point(view, [x, y], depth) {
                nearest = nearest.min(p.distance(eye));
            }
        }
    }
    nearest
}

/// The point of a pixel at a depth.
fn point(view: &View, [x, y]: [u32; 2], depth: f64) -> Option<DVec3> {
    let [w, h] = view.viewport().map(f64::from);
    let ndc = [(f64::from(x) + 0.5) * 2.0 / w - 1.0, 1.0 - (f64::from(y) + 0.5) * 2.0 / h];
    let inverse = DMat4::from_cols_array(&view.world_from_clip());
    let p = inverse * DVec4::new(ndc[0], ndc[1], depth, 1.0);
    let p = p.truncate() / p.w;
    p.is_finite().then_some(p)
}

/// From 0 to 1 with a slow start and a slow end: (3 − 2 t) t².
pub(super) fn ease(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    (3.0 - 2.0 * t) * t * t
}

/// A line through points, each as long in passing as it is from the next.
#[derive(Debug)]
pub(super) struct Track {
    points: Vec<DVec3>,
    /// From the first point to each.
    lengths: Vec<f64>,
}

impl Track {
    pub(super) fn new(points: Vec<DVec3>) -> Self {
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        Self { points, lengths }
    }

    /// Its length.
    pub(super) fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The point so far along it; its ends beyond them.
    pub(super) fn at(&self, along: f64) -> DVec3 {
        let next = self.lengths.partition_point(|l| *l <= along);
        let (Some(&last), Some(before)) = (self.points.last(), next.checked_sub(1)) else {
            return self.points.first().copied().unwrap_or_default();
        };
        if next >= self.points.len() {
            return last;
        }
        let t = (along - self.lengths[before]) / (self.lengths[next] - self.lengths[before]);
        self.points[before].lerp(self.points[next], t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_is_passed_at_one_speed() {
        let track = Track::new(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y * 3.0]);
        assert_eq!(track.length(), 4.0);
        assert_eq!(track.at(0.5), DVec3::X * 0.5);
        assert_eq!(track.at(2.5), DVec3::new(1.0, 1.5, 0.0));
        assert_eq!((track.at(-1.0), track.at(9.0)), (DVec3::ZERO, DVec3::new(1.0, 3.0, 0.0)));
    }

    #[test]
    fn what_is_ahead_is_measured() {
        let scene = cullet_scenes::build("office").unwrap().scene;
        let lens = Lens { fov_y_radians: 1.0, near: 0.05, size: [96, 54] };
        let stand = Stand { eye: DVec3::new(26.6, 1.7, 18.2), target: DVec3::new(26.6, 1.7, 0.0) };
        let view = lens.view(stand).unwrap();
        let back = stand_of(&view, 18.2).unwrap();
        assert!(back.eye.distance(stand.eye) < 1e-6 && back.target.distance(stand.target) < 1e-6);
        let free = free_ahead(&scene, &view);
        assert!(free > 0.2 && free < 60.0, "{free}");
    }

    #[test]
    fn a_way_begins_and_ends_slowly() {
        assert_eq!((ease(-1.0), ease(0.5), ease(2.0)), (0.0, 0.5, 1.0));
        assert!(ease(0.01) < 0.001 && ease(0.99) > 0.999);
    }
}
