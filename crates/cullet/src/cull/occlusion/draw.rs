//! Drawing convex occluders into the buffer.

use fearless_simd::Level;

use super::buffer::OcclusionBuffer;
use super::convex::Convex;
use super::plane::Plane;
use super::screen::{Clip, Doubt, ObjectScreen, Spot};
use crate::transform::Transform;

impl OcclusionBuffer {
    /// Draws a convex occluder. Nothing where a number is not finite, where the eye is within, and before
    /// [`begin`](Self::begin).
    pub fn draw_convex(&mut self, level: Level, occluder: &Convex, transform: &Transform) {
        let Some(screen) = &self.screen else { return };
        let screen = screen.of_object(transform, self.origin);
        if !self.project(&screen, &occluder.vertices) {
            return;
        }
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let clips = std::mem::take(&mut self.clips);
        if clips.iter().all(Clip::is_in_front) {
            self.whole_convex(level, occluder, &clips, &screen, orient);
        } else if clips.iter().any(Clip::is_in_front) {
            self.cut_convex(level, occluder, &clips, &screen, orient);
        }
        self.clips = clips;
    }

    fn whole_convex(
        &mut self,
        level: Level,
        occluder: &Convex,
        clips: &[Clip],
        screen: &ObjectScreen,
        orient: f64,
    ) {
        let mut spots = [Spot::default(); Convex::MAX_VERTICES];
        for (spot, clip) in spots.iter_mut().zip(clips) {
            *spot = clip.spot();
        }
        let spots = &spots[..clips.len()];
        let doubt = Doubt::of(&screen.error(reach(&occluder.vertices)), clips.iter());
        let Some((min, max)) = on_screen(spots, self.size) else { return };
        let most = spots.iter().fold(0.0_f64, |n, s| n.max(s.nearness)) + doubt.nearness;
        let window = [min, max].map(|c| c.map(|v| v.floor() as i32));
        if self.is_covered(window, (most * (1.0 + 2.0_f64.powi(-20))) as f32) {
            return;
        }
        self.outline.begin(self.size, min, max, doubt.pixels);
        let mut seen = [0_u64; Convex::MAX_VERTICES * 2 / 64 + 1];
        for (face, corners) in occluder.spread.iter().enumerate() {
            let corners = corners.map(|v| spots[v as usize]);
            if cross(corners) * orient > doubt.area(corners) {
                seen[face / 64] |= 1 << (face % 64);
                let reach = [max[0] - min[0], max[1] - min[1]];
                self.outline.plane(Plane::through(corners, reach, self.size, &doubt));
            }
        }
        let is_seen = |face: u32| seen[face as usize / 64] >> (face % 64) & 1 == 1;
        for &[from, to, winds, other] in &occluder.edges {
            let (from, to) = (spots[from as usize], spots[to as usize]);
            match (is_seen(winds), is_seen(other)) {
                (true, false) => self.outline.edge(from, to, orient),
                (false, true) => self.outline.edge(from, to, -orient),
                _ => {}
            }
        }
        self.fill(level);
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
        let error = screen.error(reach(&occluder.vertices));
        let mut spots = Vec::with_capacity(16);
        for face in 0..occluder.face_count() {
            let corners = occluder.face(face);
            cut(corners.iter().map(|&v| clips[v as usize]), &mut spots);
            let doubt = Doubt::of(&error, spots.iter());
            let spots: Vec<Spot> = spots.iter().map(Clip::spot).collect();
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
        self.outline.begin(self.size, min, max, doubt.pixels);
        self.outline.plane(plane);
        for k in 0..spots.len() {
            self.outline.edge(spots[k], spots[(k + 1) % spots.len()], orient);
        }
        self.fill(level);
    }

    /// Takes points before the divide; `false` where a number is not finite.
    fn project(&mut self, screen: &ObjectScreen, points: &[[f32; 3]]) -> bool {
        self.clips.clear();
        self.clips.extend(points.iter().map(|&p| screen.clip(p)));
        self.clips.iter().all(|c| c.is_finite() && (!c.is_in_front() || c.spot().is_finite()))
    }
}

/// The largest absolute coordinate along each axis.
fn reach(points: &[[f32; 3]]) -> [f32; 3] {
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

/// Cuts a polygon at the near plane.
fn cut(corners: impl Iterator<Item = Clip> + Clone, out: &mut Vec<Clip>) {
    out.clear();
    let Some(mut before) = corners.clone().last() else { return };
    for corner in corners {
        if corner.is_in_front() != before.is_in_front() {
            let meet = if corner.is_in_front() {
                corner.meet_near(&before)
            } else {
                before.meet_near(&corner)
            };
            out.push(meet);
        }
        if corner.is_in_front() {
            out.push(corner);
        }
        before = corner;
    }
    // Only a view whose near plane goes through its eye leaves such a corner.
    if out.iter().any(|c| c.w <= 0.0) {
        out.clear();
    }
}
