//! Drawing convex occluders into the buffer.

use fearless_simd::{Level, dispatch};

use super::band::Band;
use super::buffer::OcclusionBuffer;
use super::convex::Convex;
use super::cut::cut_near;
use super::plane::Plane;
use super::screen::{Clip, Doubt, ObjectScreen, Spot};
use crate::transform::Transform;

impl OcclusionBuffer {
    /// Draws a convex occluder. Nothing where a number is not finite, where the eye is within, and before
    /// [`begin`](Self::begin).
    pub fn draw_convex(&mut self, level: Level, occluder: &Convex, transform: &Transform) {
        self.band().draw_convex(level, occluder, transform);
    }
}

impl Band<'_> {
    /// Draws what lies in it of a convex occluder, as [`OcclusionBuffer::draw_convex`] does.
    pub fn draw_convex(&mut self, level: Level, occluder: &Convex, transform: &Transform) {
        let Some(screen) = self.object_screen(transform) else { return };
        if dispatch!(level, simd => self.whole_convex(simd, occluder, &screen)) {
            return;
        }
        if !self.project(&screen, &occluder.vertices) {
            return;
        }
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let clips = std::mem::take(&mut self.pen.clips);
        if clips.iter().any(Clip::is_in_front) {
            self.cut_convex(level, occluder, &clips, &screen, orient);
        }
        self.pen.clips = clips;
    }

    /// The screen of an object; `None` where the buffer has none yet.
    pub(super) fn object_screen(&mut self, transform: &Transform) -> Option<ObjectScreen> {
        if let Some((last, screen)) = &self.pen.object
            && last == transform
        {
            return Some(screen.clone());
        }
        let screen = self.screen?.of_object(transform, self.origin);
        self.pen.object = Some((*transform, screen.clone()));
        Some(screen)
    }

    /// One that crosses the near plane: each face by itself, since where the plane opens the body one looks
    /// through it.
    fn cut_convex(
        &mut self,
        level: Level,
        occluder: &Convex,
        clips: &[Clip],
        screen: &ObjectScreen,
        orient: f64,
    ) {
        let error = screen.error(occluder.reach);
        let (mut polygon, mut other) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for face in 0..occluder.face_count() {
            let corners = occluder.face(face);
            polygon.clear();
            polygon.extend(corners.iter().map(|&v| clips[v as usize]));
            cut_near(&mut polygon, &mut other);
            let doubt = Doubt::of(&error, polygon.iter());
            let spots: Vec<Spot> = polygon.iter().map(Clip::spot).collect();
            self.polygon(level, &spots, orient, &doubt);
        }
    }

    /// Draws a convex polygon by its own edges, where it winds as `orient` says.
    fn polygon(&mut self, level: Level, spots: &[Spot], orient: f64, doubt: &Doubt) {
        let Some((min, max)) = on_screen(spots, self.size) else { return };
        // A cut triangle has four corners at most; the largest fan triangle gives the plane.
        let fan = (1..spots.len().max(2) - 1).map(|k| [spots[0], spots[k], spots[k + 1]]);
        let Some(corners) = fan.max_by(|a, b| cross(*a).abs().total_cmp(&cross(*b).abs())) else {
            return;
        };
        if cross(corners) * orient <= doubt.area(corners) {
            return;
        }
        let reach = [max[0] - min[0], max[1] - min[1]];
        let plane = Plane::through(corners, reach, self.size, doubt);
        let rows = self.pixel_rows();
        let outline = &mut self.pen.outline;
        outline.begin(self.size, rows, min, max, doubt.pixels);
        outline.plane(plane);
        for k in 0..spots.len() {
            outline.edge(spots[k], spots[(k + 1) % spots.len()], orient);
        }
        self.fill(level);
    }

    /// Takes points before the divide; `false` where a number is not finite.
    fn project(&mut self, screen: &ObjectScreen, points: &[[f32; 3]]) -> bool {
        let clips = &mut self.pen.clips;
        clips.clear();
        clips.extend(points.iter().map(|&p| screen.clip(p)));
        clips.iter().all(|c| c.is_finite() && (!c.is_in_front() || c.spot().is_finite()))
    }
}

/// The largest absolute coordinate along each axis.
pub(super) fn reach(points: &[[f32; 3]]) -> [f32; 3] {
    points.iter().fold([0.0; 3], |r, p| std::array::from_fn(|a| r[a].max(p[a].abs())))
}

fn cross([a, b, c]: [Spot; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// The box around spots; `None` where it misses the screen, or a number is not finite.
fn on_screen(spots: &[Spot], size: [u32; 2]) -> Option<([f64; 2], [f64; 2])> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for s in spots {
        (min, max) = ([min[0].min(s.x), min[1].min(s.y)], [max[0].max(s.x), max[1].max(s.y)]);
        if !(s.x.is_finite() && s.y.is_finite()) {
            return None;
        }
    }
    let [width, height] = size.map(f64::from);
    let on = max[0] >= -1.0 && max[1] >= -1.0 && min[0] <= width + 1.0 && min[1] <= height + 1.0;
    on.then_some((min, max))
}
