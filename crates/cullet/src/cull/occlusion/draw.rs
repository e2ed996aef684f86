//! Drawing occluders into the buffer.

use fearless_simd::Level;

use super::buffer::OcclusionBuffer;
use super::convex::Convex;
use super::fringe::Along;
use super::patch::{Face, Patch, Side};
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
        let doubt = Doubt::of(screen, reach(&occluder.vertices), clips.iter());
        let Some((min, max)) = on_screen(spots, self.size) else { return };
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
        let reach = reach(&occluder.vertices);
        let mut spots = Vec::with_capacity(16);
        for face in 0..occluder.face_count() {
            let corners = occluder.face(face);
            cut(corners.iter().map(|&v| clips[v as usize]), &mut spots);
            let doubt = Doubt::of(screen, reach, spots.iter());
            let spots: Vec<Spot> = spots.iter().map(Clip::spot).collect();
            self.polygon(level, &spots, orient, &doubt);
        }
    }

    /// Draws a convex polygon by its own edges, where it winds as `orient` says.
    fn polygon(
        &mut self,
        level: Level,
        spots: &[Spot],
        orient: f64,
        doubt: &Doubt,
    ) -> Option<Face> {
        if spots.len() < 3 {
            return None;
        }
        let (min, max) = on_screen(spots, self.size)?;
        // A cut triangle has four corners at most; the largest fan triangle gives the plane.
        let fan = (1..spots.len() - 1).map(|k| [spots[0], spots[k], spots[k + 1]]);
        let corners = fan.max_by(|a, b| cross(*a).abs().total_cmp(&cross(*b).abs()))?;
        if cross(corners) * orient <= doubt.area(corners) {
            return None;
        }
        let reach = [max[0] - min[0], max[1] - min[1]];
        let plane = Plane::through(corners, reach, self.size, doubt);
        self.outline.begin(self.size, min, max, doubt.pixels);
        self.outline.plane(plane);
        for k in 0..spots.len() {
            self.outline.edge(spots[k], spots[(k + 1) % spots.len()], orient);
        }
        self.fill(level);
        Some(Face { plane, far: far(spots, doubt), side: Side::Front })
    }

    /// Draws a patch of a surface. Nothing where a number is not finite, and before
    /// [`begin`](Self::begin).
    pub fn draw_patch(&mut self, level: Level, patch: &Patch, transform: &Transform) {
        let Some(screen) = &self.screen else { return };
        let screen = screen.of_object(transform, self.origin);
        if !self.project(&screen, &patch.vertices) {
            return;
        }
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let reach = reach(&patch.vertices);
        let clips = std::mem::take(&mut self.clips);
        let mut faces = std::mem::take(&mut self.faces);
        faces.clear();
        let mut drawn = [false; 2];
        for (number, corners) in patch.triangles.iter().enumerate() {
            let face = self.triangle(
                level,
                corners.map(|v| &clips[v as usize]),
                (&screen, reach, orient),
                number < patch.own,
                patch.two_sided,
            );
            match face.side {
                Side::Front => drawn[0] = true,
                Side::Back => drawn[1] = true,
                Side::Neither => {}
            }
            faces.push(face);
        }
        for (side, drawn) in [Side::Front, Side::Back].into_iter().zip(drawn) {
            if drawn && (side == Side::Front || patch.two_sided) {
                self.edges(patch, &clips, &faces, side, &screen, reach);
                self.take_fringe();
            }
        }
        self.clips = clips;
        self.faces = faces;
    }

    /// Draws a triangle where `draw`, and says how it lies.
    fn triangle(
        &mut self,
        level: Level,
        corners: [&Clip; 3],
        (screen, reach, orient): (&ObjectScreen, [f32; 3], f64),
        draw: bool,
        two_sided: bool,
    ) -> Face {
        let mut spots = [Spot::default(); 4];
        let mut count = 3;
        let mut clipped = Vec::new();
        let doubt;
        if corners.iter().all(|c| c.is_in_front()) {
            for (spot, clip) in spots.iter_mut().zip(corners) {
                *spot = clip.spot();
            }
            doubt = Doubt::of(screen, reach, corners.into_iter());
        } else {
            cut(corners.into_iter().copied(), &mut clipped);
            if clipped.len() < 3 {
                return Face::default();
            }
            count = clipped.len().min(4);
            for (spot, clip) in spots.iter_mut().zip(&clipped) {
                *spot = clip.spot();
            }
            doubt = Doubt::of(screen, reach, clipped.iter());
        }
        let spots = &spots[..count];
        let fan = (1..count - 1).map(|k| [spots[0], spots[k], spots[k + 1]]);
        let Some(largest) = fan.max_by(|a, b| cross(*a).abs().total_cmp(&cross(*b).abs())) else {
            return Face::default();
        };
        let area = cross(largest) * orient;
        let side = if area > doubt.area(largest) {
            Side::Front
        } else if area < -doubt.area(largest) {
            Side::Back
        } else {
            Side::Neither
        };
        if side == Side::Neither || (side == Side::Back && !two_sided) {
            return Face { side, ..Face::default() };
        }
        let Some((min, max)) = on_screen(spots, self.size) else {
            return Face { side, far: far(spots, &doubt), ..Face::default() };
        };
        let plane = Plane::through(largest, [max[0] - min[0], max[1] - min[1]], self.size, &doubt);
        if draw {
            self.outline.begin(self.size, min, max, doubt.pixels);
            if !self.outline.is_thin() {
                self.outline.plane(plane);
                let inner = if side == Side::Front { orient } else { -orient };
                for k in 0..count {
                    self.outline.edge(spots[k], spots[(k + 1) % count], inner);
                }
                self.fill(level);
            }
        }
        Face { plane, far: far(spots, &doubt), side }
    }

    /// Walks the edges of the triangles that show one side.
    fn edges(
        &mut self,
        patch: &Patch,
        clips: &[Clip],
        faces: &[Face],
        side: Side,
        screen: &ObjectScreen,
        reach: [f32; 3],
    ) {
        let shows = |t: u32| faces.get(t as usize).filter(|f| f.side == side);
        for &[a, b, one, other] in &patch.edges {
            let along = match (shows(one), shows(other)) {
                (Some(one), Some(other)) => {
                    Along::Faces(&one.plane, one.far, &other.plane, other.far)
                }
                (None, None) => continue,
                _ => Along::Border,
            };
            let [a, b] = [a, b].map(|v| clips[v as usize]);
            let (a, b) = match (a.is_in_front(), b.is_in_front()) {
                (true, true) => (a, b),
                (true, false) => (a, a.meet_near(&b)),
                (false, true) => (b.meet_near(&a), b),
                (false, false) => continue,
            };
            if a.w > 0.0 && b.w > 0.0 {
                let doubt = Doubt::of(screen, reach, [&a, &b].into_iter());
                self.fringe.walk(a.spot(), b.spot(), doubt.pixels, along);
            }
        }
        // Where the near plane cuts a triangle, what shows that side ends.
        let mut clipped = Vec::new();
        for (corners, face) in patch.triangles.iter().zip(faces) {
            let corners = corners.map(|v| clips[v as usize]);
            if face.side == side && !corners.iter().all(Clip::is_in_front) {
                cut(corners.into_iter(), &mut clipped);
                let doubt = Doubt::of(screen, reach, clipped.iter());
                for k in 0..clipped.len() {
                    let (a, b) = (&clipped[k], &clipped[(k + 1) % clipped.len()]);
                    if a.near == 0.0 && b.near == 0.0 {
                        self.fringe.walk(a.spot(), b.spot(), doubt.pixels, Along::Border);
                    }
                }
            }
        }
    }

    /// Takes points before the divide; `false` where a number is not finite.
    fn project(&mut self, screen: &ObjectScreen, points: &[[f32; 3]]) -> bool {
        self.clips.clear();
        self.clips.extend(points.iter().map(|&p| screen.clip(p)));
        let has_place = |c: &Clip| {
            let spot = c.spot();
            spot.x.is_finite() && spot.y.is_finite() && spot.nearness.is_finite()
        };
        self.clips.iter().all(|c| c.is_finite() && (!c.is_in_front() || has_place(c)))
    }
}

/// The largest absolute coordinate along each axis.
fn reach(points: &[[f32; 3]]) -> [f32; 3] {
    points.iter().fold([0.0; 3], |r, p| std::array::from_fn(|a| r[a].max(p[a].abs())))
}

fn cross([a, b, c]: [Spot; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

fn far(spots: &[Spot], doubt: &Doubt) -> f32 {
    let least = spots.iter().fold(f64::INFINITY, |n, s| n.min(s.nearness)) - doubt.nearness;
    Plane::level(least).value
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
