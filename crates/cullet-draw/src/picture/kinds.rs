//! A culling view seen from outside: everything it dropped in the colour of the kind of culling that
//! took it.

use cullet::bounds::Aabb;
use cullet::{Camera, Culler, Depth, Output, Projection, Scene, Stage, View, ViewState, Visible};
use glam::DVec3;

use super::Picture;
use super::canvas::text_width;
use super::map::{Fate, Legend, counts, fates};
use super::palette::{INK, PAPER};
use super::shaded::{light, linear};
use super::space::{Space, Surfaces};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::render::render;

/// Culls for `view`, stands behind it ([`fly_out`]) and draws the whole scene, each dropped thing in
/// the colour of the kind of culling that took it, with the frustum, and a legend where it would cover
/// less than a quarter. `size` is that of
/// the picture, at least 320 × 200.
///
/// Cost: the culling, two frames of the scene, and some 0.2 µs a pixel.
#[must_use]
pub fn kinds(scene: &Scene, view: &View, culler: &Culler, size: [u32; 2]) -> Picture {
    let culler =
        Culler { output: Output::Triangles, reasons: true, dropped: true, ..culler.clone() };
    let mut visible = Visible::default();
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    kinds_of(scene, view, &visible, &fly_out(scene, view, size))
}

/// [`kinds`] for a visible set that is known, with triangles, reasons and what was dropped, seen from a view of one's
/// choice. The picture has the size of that view.
#[must_use]
pub fn kinds_of(scene: &Scene, view: &View, visible: &Visible, from: &View) -> Picture {
    let seen = render(scene, view, Selection::All, &RenderOptions::default()).visible();
    // Everything is shown, also what faces away from the culling view: both sides, all layers.
    let mut from = from.clone();
    from.cull_face = cullet::CullFace::None;
    from.layers = u32::MAX;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(scene, &from, Selection::All, &options);
    let surfaces = Surfaces::new(scene, &frame.ids);
    let fates = fates(scene, visible, &seen);
    let triangles = TriangleFates::new(visible, &seen, &surfaces);
    let color = |id: PixelId| {
        let fate = match fates.get(id.slot as usize).copied().flatten() {
            Some(Fate::Dropped(stage)) if visible.triangle_ranges.is_empty() => {
                Fate::Dropped(stage)
            }
            None => Fate::Dropped(None),
            _ => triangles.of(id),
        };
        let [r, g, b] = fate.color().map(linear);
        DVec3::new(r, g, b)
    };
    let mut picture = light(scene, &frame, &from, &surfaces, color).halved();
    draw_frustum(&mut picture, scene, view, &from, &frame);
    let mut counts = counts(&fates);
    let mut shown = frame.ids.clone();
    shown.dedup();
    let facing_away = Fate::Dropped(Some(Stage::Backface));
    if shown.iter().any(|&id| id != PixelId::NONE && triangles.of(id) == facing_away) {
        counts.push((facing_away, 0));
    }
    explain(&mut picture, &counts);
    picture
}

/// Puts a legend into the corner, where it would cover less than a quarter of the picture.
pub(super) fn explain(picture: &mut Picture, counts: &[(Fate, u64)]) {
    let scale = if picture.width >= 900 { 2 } else { 1 };
    let legend = Legend { at: [26, 26], scale, ink: INK, paper: PAPER };
    let widest = text_width("in no layer of the view", scale) + 56;
    let high = legend.height(counts.len()) + 14;
    if widest * high * 4 < i64::from(picture.width) * i64::from(picture.height) {
        picture.fill([12, 12], [widest, high], PAPER, 0.86);
        legend.draw(picture, "the view and its culling", counts);
    }
}

/// A view from behind and above another, that has its frustum and much of the scene before it. The
/// view itself, if the scene's numbers are so extreme that there is no such camera.
#[must_use]
pub fn fly_out(scene: &Scene, view: &View, size: [u32; 2]) -> View {
    let size = [size[0].max(320), size[1].max(200)];
    let space = Space::new(view);
    let (near, direction) = space.ray(0.0, 0.0);
    let reach = reach(scene);
    let level = DVec3::new(direction.x, 0.0, direction.z);
    // A view straight down has no heading of its own.
    let heading = if level.length() > 0.1 { level.normalize() } else { DVec3::NEG_Z };
    let side = heading.cross(DVec3::Y);
    let eye = near - heading * (0.42 * reach) + side * (0.22 * reach) + DVec3::Y * (0.42 * reach);
    let target = near + heading * (0.30 * reach);
    let projection = Projection::Perspective {
        fov_y_radians: 48f64.to_radians(),
        aspect: f64::from(size[0]) / f64::from(size[1]),
        near: reach * 1e-3,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at(eye, target, projection);
    View::new(&camera, Depth::Reversed, size).unwrap_or_else(|_| view.clone())
}

/// The radius of the scene, but for a ground or sky that reaches far beyond all else.
fn reach(scene: &Scene) -> f64 {
    let size = |b: &Aabb| DVec3::from(b.half_extent()).length();
    let extent = scene.extent();
    if extent.is_empty() {
        return 1.0;
    }
    let limit = size(&extent) * 0.5;
    let things =
        scene.slots().map(|s| scene.bounds(s)).filter(|b| b.is_finite() && size(b) < limit);
    let things = things.fold(Aabb::EMPTY, |a, b| a.union(&b));
    size(if things.is_empty() { &extent } else { &things }).max(1e-6)
}

/// What became of the triangles of instances that are kept.
struct TriangleFates<'a> {
    visible: &'a Visible,
    seen: &'a [PixelId],
    surfaces: &'a Surfaces<'a>,
}

impl<'a> TriangleFates<'a> {
    fn new(visible: &'a Visible, seen: &'a [PixelId], surfaces: &'a Surfaces<'a>) -> Self {
        Self { visible, seen, surfaces }
    }

    fn of(&self, id: PixelId) -> Fate {
        if self.seen.binary_search(&id).is_ok() {
            return Fate::Seen;
        }
        let Some(t) = self.surfaces.triangle(id) else { return Fate::Dropped(None) };
        let ranges = &self.visible.triangle_ranges;
        let i = ranges.partition_point(|r| r.slot < id.slot);
        let listed = ranges.get(i).filter(|r| r.slot == id.slot).is_some_and(|r| {
            let entries = r.first as usize..r.first as usize + r.count as usize;
            self.visible.triangles.get(entries).is_some_and(|t_of| t_of.binary_search(&t).is_ok())
        });
        // Without triangles, the instance speaks for them.
        if listed || self.visible.triangle_ranges.is_empty() {
            return Fate::Unseen;
        }
        Fate::Dropped(self.visible.stage_of(id.slot, t))
    }
}

/// Draws the edges of a view's frustum into a picture taken from another; where the scene hides them,
/// faintly.
pub(super) fn draw_frustum(
    picture: &mut Picture,
    scene: &Scene,
    view: &View,
    from: &View,
    frame: &Frame,
) {
    let (inner, outer) = (Space::new(view), Space::new(from));
    let length = 0.9 * reach(scene);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let near = corners.map(|[x, y]| inner.ray(x, y).0);
    let far = corners.map(|[x, y]| inner.along(x, y, length));
    let size = [picture.width, picture.height];
    for i in 0..4 {
        let j = (i + 1) % 4;
        for (a, b) in [(near[i], near[j]), (near[i], far[i]), (far[i], far[j])] {
            // In pieces, each with a depth of its own; the last thing drawn is a thin dark core.
            const PIECES: u32 = 256;
            for (width, color) in [(4.0, PAPER), (1.8, INK)] {
                for k in 0..PIECES {
                    let at = |k: u32| a.lerp(b, f64::from(k) / f64::from(PIECES));
                    let ends = (outer.project(at(k), size), outer.project(at(k + 1), size));
                    let (Some((p, depth)), Some((q, _))) = ends else { continue };
                    let [x, y] = [p[0] * 2.0, p[1] * 2.0];
                    let inside = x >= 0.0
                        && y >= 0.0
                        && x < f64::from(frame.width)
                        && y < f64::from(frame.height);
                    let pixel = y as usize * frame.width as usize + x as usize;
                    let hidden = inside && outer.nearer(frame.depth[pixel], depth);
                    picture.line(p, q, width, color, if hidden { 0.16 } else { 0.8 });
                }
            }
        }
    }
    let [x, y] = match outer.project(near[0].lerp(near[2], 0.5), size) {
        Some((p, _)) => p,
        None => return,
    };
    let ring: Vec<[f64; 2]> = (0..24)
        .map(|k| (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos())
        .map(|(s, c)| [x + c * 5.0, y + s * 5.0])
        .collect();
    picture.fill_convex(&ring, PAPER, 1.0);
    picture.outline(&ring, 1.6, INK, 1.0);
}
