//! Standing outside of a view: from where one sees it with what it culls, its frustum as a drawing,
//! and whether the scene must be cut open for that.

use std::ops::Range;

use cullet::bounds::Aabb;
use cullet::{Camera, Depth, Projection, Scene, View, view::CullFace};
use glam::DVec3;

use super::Picture;
use super::palette::{INK, PAPER};
use super::space::{Space, Surfaces, corners, framing, pixel_centre};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::parallel;
use crate::render::render;

/// The view, but that everything is shown in it: also what faces away, and all layers.
pub(super) fn from_outside(from: &View) -> View {
    let mut from = from.clone();
    from.cull_face = CullFace::None;
    from.layers = u32::MAX;
    from
}

/// Full angle from the lower edge to the upper one of pictures from outside.
const FOV: f64 = 48.0 * std::f64::consts::PI / 180.0;

/// How high the eye stands outside: in degrees above the level, the lowest first.
const HEIGHTS: [f64; 3] = [29.0, 52.0, 75.0];

/// Where to stand to see a view and what it culls.
#[derive(Clone, Debug)]
pub struct Outlook {
    /// From aside: of an eye outside of the scene, with all of the scene and the frustum in the
    /// picture; of one within, from behind and above it, with much of the scene before it, and so
    /// high that most of what the view sees is in sight, if there is such a height. The view
    /// itself, if the scene's numbers are so extreme that there is no such camera.
    pub from: View,
    /// Where from no height most of it is in sight: the height at which to cut the scene open, so
    /// that one looks from above into what the view sees. It is above the eye by a tenth of what
    /// the eye is above the ground.
    pub cut_at: Option<f64>,
}

impl Outlook {
    /// Finds it; the picture will be of `size`, at least 320 × 200. Costs up to five small frames.
    #[must_use]
    pub fn new(scene: &Scene, view: &View, size: [u32; 2]) -> Self {
        let (best, in_sight) = best_stand(scene, view);
        let size = [size[0].max(320), size[1].max(200)];
        let from = stand(scene, view, HEIGHTS[best], size).unwrap_or_else(|| view.clone());
        let eye = view.eye();
        let above = || 0.1 * above_ground(scene, eye).unwrap_or(0.2 * reach(scene));
        let covered = eye[3] != 0.0 && in_sight < IN_SIGHT;
        Self { from, cut_at: covered.then(|| eye[1] + above()) }
    }
}

/// The number of the lowest stand from which most of what a view sees is in sight, else of that
/// from which the most is; and how much that is.
fn best_stand(scene: &Scene, view: &View) -> (usize, f64) {
    if is_outside(scene, &Space::new(view)) {
        return (0, 1.0);
    }
    let Some(seen) = SightLines::new(scene, view) else { return (0, 1.0) };
    let mut best = (0, 0.0);
    for (i, height) in HEIGHTS.into_iter().enumerate() {
        let Some(from) = stand(scene, view, height, [320, 200]) else { continue };
        let share = seen.share_in_sight(scene, &from);
        if share > best.1 {
            best = (i, share);
        }
        if share >= IN_SIGHT {
            return (i, share);
        }
    }
    best
}

/// The view from outside at a height in degrees.
fn stand(scene: &Scene, view: &View, height: f64, size: [u32; 2]) -> Option<View> {
    let space = Space::new(view);
    let (near, direction) = space.ray(0.0, 0.0);
    let level = DVec3::new(direction.x, 0.0, direction.z);
    // A view straight down has no heading of its own.
    let heading = if level.length() > 0.1 { level.normalize() } else { DVec3::NEG_Z };
    let side = heading.cross(DVec3::Y);
    if is_outside(scene, &space) {
        let mut points = corners(scene, &contents(scene)).to_vec();
        points.extend(frustum_corners(scene, &space).into_iter().flatten());
        points.push(space.eye.truncate() / space.eye.w);
        let back = side * 0.9 - heading * 0.35 + DVec3::Y * 0.4;
        return framing(&points, back, FOV, size);
    }
    let reach = reach(scene);
    let (up, out) = height.to_radians().sin_cos();
    let target = near + heading * (0.30 * reach);
    let eye = target + (side * 0.25 - heading * out + DVec3::Y * up) * (0.84 * reach);
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let (near, far) = (reach * 1e-3, f64::INFINITY);
    let projection = Projection::Perspective { fov_y_radians: FOV, aspect, near, far };
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, size).ok()
}

/// Whether the eye is outside of the scene, and not so far off that this would be a dot.
fn is_outside(scene: &Scene, space: &Space) -> bool {
    let bounds = scene.extent();
    if bounds.is_empty() || space.eye.w == 0.0 {
        return false;
    }
    let eye = space.eye.truncate() / space.eye.w - DVec3::from(scene.origin());
    let [low, high] = [bounds.min, bounds.max].map(|v| DVec3::from(v.map(f64::from)));
    let off = eye.distance(eye.clamp(low, high));
    off > 0.0 && off < 6.0 * reach(scene)
}

/// The corners of the near plane of a view, and beyond each the point to which the frustum is
/// drawn: of an eye outside of the scene, as far as that reaches along its line of sight.
fn frustum_corners(scene: &Scene, space: &Space) -> [[DVec3; 2]; 4] {
    let length = if is_outside(scene, space) {
        let (near, direction) = space.ray(0.0, 0.0);
        let bounds = contents(scene);
        let middle = DVec3::from(scene.origin()) + DVec3::from(bounds.center().map(f64::from));
        // Most scenes are rounder than their boxes.
        let half = DVec3::from(bounds.half_extent().map(f64::from)).dot(direction.abs());
        ((middle - near).dot(direction) + 0.6 * half).max(0.1 * reach(scene))
    } else {
        0.9 * reach(scene)
    };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| [space.ray(x, y).0, space.along(x, y, length)])
}

/// A ground or sky is left out of the bounds if all else reaches no farther than this share of it.
const SMALL_WITHIN: f64 = 0.4;

/// The bounds of the scene, but for a ground or sky that reaches far beyond all else.
pub(super) fn contents(scene: &Scene) -> Aabb {
    let size = |b: &Aabb| DVec3::from(b.half_extent()).length();
    let mut boxes = finite_bounds(scene);
    let extent = union(&boxes);
    if extent.is_empty() {
        return extent;
    }
    let limit = size(&extent) * 0.5;
    boxes.retain(|b| size(b) < limit);
    let contents = union(&boxes);
    // An instance that holds all others is a room, not a ground.
    let is_room = contents.is_empty() || size(&contents) > SMALL_WITHIN * size(&extent);
    if is_room { extent } else { contents }
}

/// The bounds of the scene, as [`Scene::extent`] finds them.
pub(super) fn extent(scene: &Scene) -> Aabb {
    union(&finite_bounds(scene))
}

fn union(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b))
}

/// Bounds of all instances that have some.
fn finite_bounds(scene: &Scene) -> Vec<Aabb> {
    let some = |slots: Range<usize>| -> Vec<Aabb> {
        let is_some = |&slot: &u32| !scene.is_removed(slot) && !scene.is_stand_in(slot);
        let slots = slots.map(|slot| slot as u32).filter(is_some);
        slots.map(|slot| scene.bounds(slot)).filter(Aabb::is_finite).collect()
    };
    parallel::tasks(scene.slot_count() as usize, 1024, &some).concat()
}

/// Half the diagonal of [`contents`].
fn reach(scene: &Scene) -> f64 {
    let contents = contents(scene);
    if contents.is_empty() { 1.0 } else { DVec3::from(contents.half_extent()).length().max(1e-6) }
}

/// Draws the edges of a view's frustum into a picture taken from another, finer from the eye to the
/// near plane; where the scene hides them, faintly. Returns points along them.
pub(super) fn draw_frustum(
    picture: &mut Picture,
    scene: &Scene,
    view: &View,
    from: &View,
    frame: &Frame,
) -> Vec<[f64; 2]> {
    let (inner, outer) = (Space::new(view), Space::new(from));
    let edges = frustum_corners(scene, &inner);
    let size = [picture.width, picture.height];
    let eye = (inner.eye.w != 0.0).then(|| inner.eye.truncate() / inner.eye.w);
    let mut lines = Vec::new();
    for i in 0..4 {
        let ([near, far], [next_near, next_far]) = (edges[i], edges[(i + 1) % 4]);
        lines.extend(eye.map(|eye| (eye, near, 1.0)));
        lines.extend([(near, next_near, 1.8), (near, far, 1.8), (far, next_far, 1.8)]);
    }
    let mut points = Vec::new();
    let mut runs = Vec::new();
    for (a, b, width) in lines {
        // In segments, each with a depth of its own; those alike are one line, or their ends would
        // show.
        const SEGMENTS: u32 = 256;
        let at = |k: u32| a.lerp(b, f64::from(k) / f64::from(SEGMENTS));
        let mut run: Option<([f64; 2], [f64; 2], bool)> = None;
        for k in 0..SEGMENTS {
            let ends = (outer.project(at(k), size), outer.project(at(k + 1), size));
            let (Some((p, depth)), Some((q, _))) = ends else { continue };
            let [x, y] = p.map(|v| v * 2.0);
            let within =
                x >= 0.0 && y >= 0.0 && x < f64::from(frame.width) && y < f64::from(frame.height);
            let pixel = y as usize * frame.width as usize + x as usize;
            let hidden = within && outer.nearer(frame.depth[pixel], depth);
            points.push(p);
            match &mut run {
                Some((_, end, same)) if *same == hidden && *end == p => *end = q,
                _ => {
                    runs.extend(run.map(|run| (run, width)));
                    run = Some((p, q, hidden));
                }
            }
        }
        runs.extend(run.map(|run| (run, width)));
    }
    // A thin dark core in a pale rim, which all lines have before any has its core.
    for (rim, color) in [(2.2, PAPER), (0.0, INK)] {
        for ((p, q, hidden), width) in &runs {
            picture.line(*p, *q, width + rim, color, if *hidden { 0.16 } else { 0.8 });
        }
    }
    let seat = eye.unwrap_or_else(|| edges[0][0].lerp(edges[2][0], 0.5));
    let Some(([x, y], _)) = outer.project(seat, size) else { return points };
    let ring: Vec<[f64; 2]> = (0..24)
        .map(|k| (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos())
        .map(|(s, c)| [x + c * 5.0, y + s * 5.0])
        .collect();
    picture.fill_convex(&ring, PAPER, 1.0);
    picture.outline(&ring, 1.6, INK, 1.0);
    points
}

/// From how small a picture it is decided whether a scene is opened.
const SMALL: [u32; 2] = [160, 90];
/// This share of what a view sees is most of it.
const IN_SIGHT: f64 = 0.5;

fn draw_all(scene: &Scene, view: &View) -> Frame {
    render(scene, view, Selection::All, &RenderOptions::default())
}

/// Points of the surfaces that a view sees, and normals of the sides that it sees.
struct SightLines(Vec<(DVec3, DVec3)>);

impl SightLines {
    /// `None` if the view is so extreme that it cannot be made small.
    fn new(scene: &Scene, view: &View) -> Option<Self> {
        let mut small = View::from_matrix(view.clip_from_world(), view.depth(), SMALL).ok()?;
        (small.layers, small.front_face, small.cull_face) =
            (view.layers, view.front_face, view.cull_face);
        let (frame, space) = (draw_all(scene, &small), Space::new(&small));
        let surfaces = Surfaces::new(scene, &frame.ids);
        let shown = (0..frame.ids.len()).filter(|&at| frame.ids[at] != PixelId::NONE);
        let point = |at: usize| {
            let [x, y] = pixel_centre(at as u32 % SMALL[0], at as u32 / SMALL[0], SMALL);
            let (p, n) = (space.point(x, y, frame.depth[at]), surfaces.normal(frame.ids[at]));
            (p, space.turned(n, p))
        };
        Some(Self(shown.map(point).collect()))
    }

    /// How many of them are in another view, from the same side and with nothing before them, as a
    /// share; 1 of none.
    fn share_in_sight(&self, scene: &Scene, from: &View) -> f64 {
        let from = from_outside(from);
        let (frame, space) = (draw_all(scene, &from), Space::new(&from));
        let size = [frame.width, frame.height];
        let eye = space.eye.truncate();
        let in_sight = |(p, n): &&(DVec3, DVec3)| {
            let Some(([x, y], _)) = space.project(*p, size) else { return false };
            if n.dot(eye - *p) <= 0.0 {
                return false;
            }
            if !(x >= 0.0 && y >= 0.0 && x < f64::from(size[0]) && y < f64::from(size[1])) {
                return false;
            }
            let pixel = y as usize * size[0] as usize + x as usize;
            let [x, y] = pixel_centre(x as u32, y as u32, size);
            // A pixel of a small frame stands for all around it.
            space.point(x, y, frame.depth[pixel]).distance(eye) > p.distance(eye) * 0.97
        };
        let count = self.0.iter().filter(in_sight).count();
        if self.0.is_empty() { 1.0 } else { count as f64 / self.0.len() as f64 }
    }
}

/// How far below a point the next surface is.
fn above_ground(scene: &Scene, [x, y, z, _]: [f64; 4]) -> Option<f64> {
    let reach = 2.0 * reach(scene);
    let projection = Projection::Perspective {
        fov_y_radians: 1e-3,
        aspect: 1.0,
        near: reach * 1e-6,
        far: f64::INFINITY,
    };
    let (direction, up) = ([0.0, -1.0, 0.0], [0.0, 0.0, -1.0]);
    let camera = Camera { eye: [x, y, z], direction, up, projection };
    let down = from_outside(&View::new(&camera, Depth::Reversed, [1, 1]).ok()?);
    let frame = draw_all(scene, &down);
    let ground = Space::new(&down).point(0.0, 0.0, frame.depth[0]);
    (frame.ids[0] != PixelId::NONE).then_some(y - ground.y)
}
