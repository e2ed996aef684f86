//! Drawing occluders into the buffer.

use fearless_simd::{Level, dispatch};

use super::ask::Footprint;
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
        let screen = match &self.object {
            Some((last, screen)) if last == transform => screen.clone(),
            _ => {
                let screen = screen.of_object(transform, self.origin);
                self.object = Some((*transform, screen.clone()));
                screen
            }
        };
        if dispatch!(level, simd => self.whole_convex(simd, occluder, &screen)) {
            return;
        }
        if !self.project(&screen, &occluder.vertices) {
            return;
        }
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let clips = std::mem::take(&mut self.clips);
        if clips.iter().any(Clip::is_in_front) {
            self.cut_convex(level, occluder, &clips, &screen, orient);
        }
        self.clips = clips;
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
        let error = screen.error(reach(&patch.vertices));
        let clips = std::mem::take(&mut self.clips);
        let mut spots = std::mem::take(&mut self.spots);
        let mut faces = std::mem::take(&mut self.faces);
        spots.clear();
        spots
            .extend(clips.iter().map(|c| if c.is_in_front() { c.spot() } else { Spot::default() }));
        let whole = clips.iter().all(Clip::is_in_front);
        let sheet = Sheet {
            patch,
            clips: &clips,
            spots: &spots,
            error,
            doubt: whole.then(|| Doubt::of(&error, clips.iter())),
            orient,
        };
        let window = sheet.window();
        let nearest = sheet.nearest();
        if !self.is_covered(window, nearest) {
            faces.clear();
            let mut drawn = [false; 2];
            for number in 0..patch.triangles.len() {
                let face = self.triangle(level, &sheet, number);
                match face.side {
                    Side::Front => drawn[0] = true,
                    Side::Back => drawn[1] = true,
                    Side::Neither => {}
                }
                faces.push(face);
            }
            for (side, drawn) in [Side::Front, Side::Back].into_iter().zip(drawn) {
                if drawn && (side == Side::Front || patch.two_sided) {
                    self.fringe.begin(nearest, window);
                    self.edges(&sheet, &faces, side);
                    self.take_fringe();
                }
            }
        }
        self.clips = clips;
        self.spots = spots;
        self.faces = faces;
    }

    /// Whether nothing at most so near can add to the pixels of a window: no need to draw it.
    fn is_covered(&self, [min, max]: [[i32; 2]; 2], nearest: f32) -> bool {
        let last = self.size.map(|s| s as i32 - 1);
        if (0..2).any(|a| max[a] < 0 || min[a] > last[a]) {
            return true;
        }
        let pixel = |v: i32, a: usize| v.clamp(0, last[a]) as u32;
        self.covers(&Footprint {
            min: [pixel(min[0], 0), pixel(min[1], 1)],
            max: [pixel(max[0], 0), pixel(max[1], 1)],
            nearness: nearest,
        })
    }

    /// Draws a triangle if it is the patch's own, and says how it lies.
    fn triangle(&mut self, level: Level, sheet: &Sheet<'_>, number: usize) -> Face {
        let corners = sheet.patch.triangles[number].map(|v| v as usize);
        if let Some(doubt) = &sheet.doubt {
            let spots = corners.map(|v| sheet.spots[v]);
            return self.flat(level, sheet, number, &spots, spots, doubt);
        }
        let mut clipped = Vec::new();
        cut(corners.into_iter().map(|v| sheet.clips[v]), &mut clipped);
        if clipped.len() < 3 {
            return Face::default();
        }
        let doubt = Doubt::of(&sheet.error, clipped.iter());
        let spots: Vec<Spot> = clipped.iter().map(Clip::spot).collect();
        let fan = (1..spots.len() - 1).map(|k| [spots[0], spots[k], spots[k + 1]]);
        let Some(largest) = fan.max_by(|a, b| cross(*a).abs().total_cmp(&cross(*b).abs())) else {
            return Face::default();
        };
        self.flat(level, sheet, number, &spots, largest, &doubt)
    }

    /// A triangle, or what the near plane leaves of it, of which `largest` spans much.
    fn flat(
        &mut self,
        level: Level,
        sheet: &Sheet<'_>,
        number: usize,
        spots: &[Spot],
        largest: [Spot; 3],
        doubt: &Doubt,
    ) -> Face {
        let area = cross(largest) * sheet.orient;
        let slack = doubt.area(largest);
        let side = if area > slack {
            Side::Front
        } else if area < -slack {
            Side::Back
        } else {
            Side::Neither
        };
        if side == Side::Neither || (side == Side::Back && !sheet.patch.two_sided) {
            return Face { side, ..Face::default() };
        }
        let far = far(spots, doubt);
        let Some((min, max)) = on_screen(spots, self.size) else {
            return Face { side, far, ..Face::default() };
        };
        let plane = Plane::through(largest, [max[0] - min[0], max[1] - min[1]], self.size, doubt);
        if number < sheet.patch.own {
            self.outline.begin(self.size, min, max, doubt.pixels);
            if !self.outline.is_thin() {
                self.outline.plane(plane);
                let inner = if side == Side::Front { sheet.orient } else { -sheet.orient };
                for k in 0..spots.len() {
                    self.outline.edge(spots[k], spots[(k + 1) % spots.len()], inner);
                }
                self.fill(level);
            }
        }
        Face { plane, far, side }
    }

    /// Walks the edges of the triangles that show one side.
    fn edges(&mut self, sheet: &Sheet<'_>, faces: &[Face], side: Side) {
        let shows = |t: u32| faces.get(t as usize).filter(|f| f.side == side);
        for &[a, b, one, other] in &sheet.patch.edges {
            let along = match (shows(one), shows(other)) {
                (Some(one), Some(other)) => {
                    Along::Faces(&one.plane, one.far, &other.plane, other.far)
                }
                (None, None) => continue,
                _ => Along::Border,
            };
            if let Some(doubt) = &sheet.doubt {
                let [a, b] = [a, b].map(|v| sheet.spots[v as usize]);
                self.fringe.walk(&self.far, a, b, doubt.pixels, along);
                continue;
            }
            let [a, b] = [a, b].map(|v| sheet.clips[v as usize]);
            let (a, b) = match (a.is_in_front(), b.is_in_front()) {
                (true, true) => (a, b),
                (true, false) => (a, a.meet_near(&b)),
                (false, true) => (b.meet_near(&a), b),
                (false, false) => continue,
            };
            if a.w > 0.0 && b.w > 0.0 {
                let doubt = Doubt::of(&sheet.error, [&a, &b].into_iter());
                self.fringe.walk(&self.far, a.spot(), b.spot(), doubt.pixels, along);
            }
        }
        if sheet.doubt.is_some() {
            return;
        }
        // Where the near plane cuts a triangle, what shows that side ends.
        let mut clipped = Vec::new();
        for (corners, face) in sheet.patch.triangles.iter().zip(faces) {
            let corners = corners.map(|v| sheet.clips[v as usize]);
            if face.side == side && !corners.iter().all(Clip::is_in_front) {
                cut(corners.into_iter(), &mut clipped);
                let doubt = Doubt::of(&sheet.error, clipped.iter());
                for k in 0..clipped.len() {
                    let (a, b) = (&clipped[k], &clipped[(k + 1) % clipped.len()]);
                    if a.near == 0.0 && b.near == 0.0 {
                        let (a, b) = (a.spot(), b.spot());
                        self.fringe.walk(&self.far, a, b, doubt.pixels, Along::Border);
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

/// A patch on the screen.
struct Sheet<'a> {
    patch: &'a Patch,
    clips: &'a [Clip],
    /// The places of the corners that are in front.
    spots: &'a [Spot],
    /// How far the numbers of `clips` may be off.
    error: Clip,
    /// How far all spots may be off; `None` where a corner is not in front, and each is asked by itself.
    doubt: Option<Doubt>,
    orient: f64,
}

impl Sheet<'_> {
    /// The nearest of its corners, rounded upward; what the near plane cuts may be as near as anything.
    fn nearest(&self) -> f32 {
        let Some(doubt) = &self.doubt else { return f32::INFINITY };
        let most = self.spots.iter().fold(0.0_f64, |n, s| n.max(s.nearness)) + doubt.nearness;
        (most * (1.0 + 2.0_f64.powi(-20))) as f32
    }

    /// The pixels that its own triangles may touch: first column and row, last column and row.
    fn window(&self) -> [[i32; 2]; 2] {
        if self.doubt.is_none() {
            return [[0; 2], [i32::MAX; 2]];
        }
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &v in self.patch.triangles[..self.patch.own].iter().flatten() {
            let s = &self.spots[v as usize];
            (min, max) = ([min[0].min(s.x), min[1].min(s.y)], [max[0].max(s.x), max[1].max(s.y)]);
        }
        [min.map(|v| v.floor() as i32), max.map(|v| v.floor() as i32)]
    }
}

/// The largest absolute coordinate along each axis.
pub(super) fn reach(points: &[[f32; 3]]) -> [f32; 3] {
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
