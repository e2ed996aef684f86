//! Standing outside of a view: from where one sees it with what it culls, its frustum as a drawing, and whether the
//! scene must be cut open for that.

use cullet::bounds::Aabb;
use cullet::{Camera, CullFace, Depth, Projection, Scene, View};
use glam::DVec3;

use super::Picture;
use super::palette::{INK, PAPER};
use super::space::{Space, corners, framing, pixel_centre};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
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

/// A view from aside that shows another: of an eye outside of the scene, with all of the scene and the
/// frustum in the picture; of one within, from behind and above it, with much of the scene before it. The view
/// itself, if the scene's numbers are so extreme that there is no such camera.
#[must_use]
pub fn fly_out(scene: &Scene, view: &View, size: [u32; 2]) -> View {
    let size = [size[0].max(320), size[1].max(200)];
    let space = Space::new(view);
    let (near, direction) = space.ray(0.0, 0.0);
    let level = DVec3::new(direction.x, 0.0, direction.z);
    // A view straight down has no heading of its own.
    let heading = if level.length() > 0.1 { level.normalize() } else { DVec3::NEG_Z };
    let side = heading.cross(DVec3::Y);
    if is_outside(scene, &space) {
        let mut points = corners(scene, &things(scene)).to_vec();
        points.extend(frustum_corners(scene, &space).into_iter().flatten());
        let back = side * 0.9 - heading * 0.35 + DVec3::Y * 0.4;
        return framing(&points, back, FOV, size).unwrap_or_else(|| view.clone());
    }
    let reach = reach(scene);
    let eye = near - heading * (0.42 * reach) + side * (0.22 * reach) + DVec3::Y * (0.42 * reach);
    let target = near + heading * (0.30 * reach);
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let (near, far) = (reach * 1e-3, f64::INFINITY);
    let projection = Projection::Perspective { fov_y_radians: FOV, aspect, near, far };
    let camera = Camera::look_at(eye, target, projection);
    View::new(&camera, Depth::Reversed, size).unwrap_or_else(|_| view.clone())
}

/// Whether the eye is outside of all that stands in the scene, and not so far off that this would be a dot.
fn is_outside(scene: &Scene, space: &Space) -> bool {
    let bounds = things(scene);
    if bounds.is_empty() || space.eye.w == 0.0 {
        return false;
    }
    let eye = space.eye.truncate() - DVec3::from(scene.origin());
    let (low, high) =
        (DVec3::from(bounds.min.map(f64::from)), DVec3::from(bounds.max.map(f64::from)));
    let off = eye.distance(eye.clamp(low, high));
    off > 0.0 && off < 6.0 * reach(scene)
}

/// The corners of the near plane of a view, and beyond each the point to which the frustum is drawn: of an
/// eye outside of the scene, as far as that reaches along its line of sight.
fn frustum_corners(scene: &Scene, space: &Space) -> [[DVec3; 2]; 4] {
    let length = if is_outside(scene, space) {
        let (near, direction) = space.ray(0.0, 0.0);
        let along = |p: &DVec3| (*p - near).dot(direction);
        corners(scene, &things(scene)).iter().map(along).fold(0.1 * reach(scene), f64::max)
    } else {
        0.9 * reach(scene)
    };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| [space.ray(x, y).0, space.along(x, y, length)])
}

/// The bounds of the scene, but for a ground or sky that reaches far beyond all else.
fn things(scene: &Scene) -> Aabb {
    let size = |b: &Aabb| DVec3::from(b.half_extent()).length();
    let extent = scene.extent();
    if extent.is_empty() {
        return extent;
    }
    let limit = size(&extent) * 0.5;
    let things =
        scene.slots().map(|s| scene.bounds(s)).filter(|b| b.is_finite() && size(b) < limit);
    let things = things.fold(Aabb::EMPTY, |a, b| a.union(&b));
    if things.is_empty() { extent } else { things }
}

/// Half the diagonal of [`things`].
fn reach(scene: &Scene) -> f64 {
    let things = things(scene);
    if things.is_empty() { 1.0 } else { DVec3::from(things.half_extent()).length().max(1e-6) }
}

/// Draws the edges of a view's frustum into a picture taken from another; where the scene hides them,
/// faintly. Returns points along them.
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
    let mut points = Vec::new();
    for i in 0..4 {
        let ([near, far], [next_near, next_far]) = (edges[i], edges[(i + 1) % 4]);
        for (a, b) in [(near, next_near), (near, far), (far, next_far)] {
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
                    points.push(p);
                }
            }
        }
    }
    let Some(([x, y], _)) = outer.project(edges[0][0].lerp(edges[2][0], 0.5), size) else {
        return points;
    };
    let ring: Vec<[f64; 2]> = (0..24)
        .map(|k| (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos())
        .map(|(s, c)| [x + c * 5.0, y + s * 5.0])
        .collect();
    picture.fill_convex(&ring, PAPER, 1.0);
    picture.outline(&ring, 1.6, INK, 1.0);
    points
}

/// From how small pictures it is decided whether a scene is opened.
const SMALL: [u32; 2] = [160, 90];
/// A scene is opened where less than this share of what a view sees is seen from outside.
const SEEN_FROM_OUTSIDE: f64 = 0.5;

/// The height at which to cut a scene open, so that one looks from above into what a view sees; `None` where a
/// good part of that is seen from outside ([`fly_out`]) as it is.
///
/// It is a little above the eye: a tenth of what the eye is above the ground. Cost: three small frames.
#[must_use]
pub fn opening(scene: &Scene, view: &View) -> Option<f64> {
    let eye = view.eye();
    if eye[3] == 0.0 || is_outside(scene, &Space::new(view)) {
        return None;
    }
    let small = View::from_matrix(&view.clip_from_world(), view.depth(), SMALL).ok()?;
    let outside = from_outside(&fly_out(scene, view, [320, 200]));
    let draw = |view: &View| render(scene, view, Selection::All, &RenderOptions::default());
    let (inner, outer) = (draw(&small), draw(&outside));
    let (here, there) = (Space::new(&small), Space::new(&outside));
    let size = [outer.width, outer.height];
    let (mut all, mut shown) = (0u32, 0u32);
    for at in (0..inner.ids.len()).filter(|&at| inner.ids[at] != PixelId::NONE) {
        let [x, y] = pixel_centre(at as u32 % SMALL[0], at as u32 / SMALL[0], SMALL);
        let p = here.point(x, y, inner.depth[at]);
        all += 1;
        let Some(([px, py], _)) = there.project(p, size) else { continue };
        if !(px >= 0.0 && py >= 0.0 && px < f64::from(size[0]) && py < f64::from(size[1])) {
            continue;
        }
        let pixel = py as usize * size[0] as usize + px as usize;
        let [qx, qy] = pixel_centre(px as u32, py as u32, size);
        let before = there.point(qx, qy, outer.depth[pixel]);
        let from = there.eye.truncate();
        // A pixel of the small frame stands for all of it.
        shown += u32::from(before.distance(from) > p.distance(from) * 0.97);
    }
    let covered = f64::from(shown) < SEEN_FROM_OUTSIDE * f64::from(all);
    covered.then(|| eye[1] + 0.1 * above_ground(scene, eye).unwrap_or(0.2 * reach(scene)))
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
    let frame = render(scene, &down, Selection::All, &RenderOptions::default());
    let ground = Space::new(&down).point(0.0, 0.0, frame.depth[0]);
    (frame.ids[0] != PixelId::NONE).then(|| y - ground.y)
}
