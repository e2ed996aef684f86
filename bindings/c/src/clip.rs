//! Occlusion in clip space, for `cullet_moc.h`: vertices are x, y and w of a projection that the caller has made, whatever
//! it is.
//!
//! Clip space itself is the world here: x, y and w are its axes, the eye is its origin, and a view whose near plane lies at
//! a w shows it. So what is drawn and tested takes the same way, with the same proofs, as anywhere else.

use std::collections::HashMap;

use engine::cull::occlusion::{DynamicSurface, ScreenBounds, Visibility};
use engine::{Depth, Simd, Transform, View};

use crate::memory::{Layout, Out, Plain, read, value, vertices};
use crate::occlusion::{BUFFERS, Buffer, Occlusion, number_of};
use crate::status::{Error, Result, Status, call};

/// Triangles in clip space, or with a matrix that takes them there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ClipTriangles {
    /// x of the first vertex.
    pub vertices: *const f32,
    /// Bytes from one vertex to the next, a multiple of 4.
    pub stride: usize,
    /// Bytes from x to y, a multiple of 4.
    pub offset_y: usize,
    /// Bytes from x to w, or with a matrix from x to z; a multiple of 4.
    pub offset_zw: usize,
    /// Three a triangle; there must be as many vertices as they say.
    pub indices: *const u32,
    /// How many triangles.
    pub triangle_count: usize,
    /// 16 floats, column-major, that take x, y, z, 1 to clip space; NULL where vertices are x, y, w of clip space.
    pub clip_from_model: *const f32,
    /// What is culled by its winding on a screen with y upward: 0 nothing, 1 clockwise, 2 counter-clockwise.
    pub cull_winding: u32,
    /// 0.
    pub reserved: u32,
}

impl Plain for ClipTriangles {}

/// Frames after which the layout of triangles that are not drawn any more is forgotten.
const KEPT_FRAMES: u64 = 64;

/// The least near plane: nearness has 32 octaves from there on.
const LEAST_NEAR: f32 = 1e-3;

/// Memory of triangles in clip space.
#[derive(Debug, Default)]
pub(crate) struct Clip {
    near: f64,
    mirrored: bool,
    frame: u64,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// Surfaces by where their indices lie and how many there are, and the frame that last drew them.
    surfaces: HashMap<(usize, usize, bool), (DynamicSurface, u64)>,
}

impl Clip {
    /// Reads triangles; returns their transform to x, y, w. None of them leaves no index.
    ///
    /// # Safety
    /// As the header asks of the caller.
    unsafe fn read(&mut self, triangles: &ClipTriangles) -> Result<Transform> {
        let ClipTriangles { stride, offset_y: second, offset_zw: third, .. } = *triangles;
        let Some(index_count) = triangles.triangle_count.checked_mul(3) else {
            let message =
                format!("{} triangles: more than there is memory", triangles.triangle_count);
            return Err(Error::value(message));
        };
        if triangles.cull_winding > 2 {
            let message = format!("cull_winding is {}: it must be 0 to 2", triangles.cull_winding);
            return Err(Error::value(message));
        }
        let mut transform = Transform::IDENTITY;
        if !triangles.clip_from_model.is_null() {
            // SAFETY: the caller's promise.
            let m: [f32; 16] =
                unsafe { value("clip_from_model", triangles.clip_from_model.cast()) }?;
            let column = |c: usize| [m[c * 4], m[c * 4 + 1], m[c * 4 + 3]];
            transform.linear = [column(0), column(1), column(2)];
            transform.translation = column(3).map(f64::from);
        }
        self.positions.clear();
        self.indices.clear();
        // SAFETY: the caller's promise.
        let indices = unsafe { read("indices", triangles.indices, index_count) }?;
        let Some(first) = indices.iter().copied().min() else { return Ok(transform) };
        let last = indices.iter().copied().max().unwrap_or(first);
        let layout = Layout { stride, second, third };
        // SAFETY: the caller's promise.
        unsafe {
            vertices("vertices", triangles.vertices, layout, [first, last], &mut self.positions)
        }?;
        self.indices.extend(indices.iter().map(|i| i - first));
        if transform.rank() == 3 {
            return Ok(transform);
        }
        // A matrix that flattens the model, such as one whose w is the same everywhere, has no eye in the model's space.
        for p in &mut self.positions {
            *p = place(*p, &transform).map(|v| v as f32);
        }
        Ok(Transform::IDENTITY)
    }

    /// The corners of a triangle in clip space, if it may be in view and is not culled by its winding.
    fn corners(&self, triangle: &[u32], at: &Transform, cull: u32) -> Option<[[f64; 3]; 3]> {
        let corners: [[f64; 3]; 3] =
            std::array::from_fn(|i| place(self.positions[triangle[i] as usize], at));
        let outside = |distance: &dyn Fn([f64; 3]) -> f64| {
            corners
                .iter()
                .all(|&[x, y, w]| distance([x, y, w]) < -1e-12 * (x.abs() + y.abs() + w.abs()))
        };
        let is_outside = outside(&|[x, _, w]| w - x)
            || outside(&|[x, _, w]| w + x)
            || outside(&|[_, y, w]| w - y)
            || outside(&|[_, y, w]| w + y)
            || corners.iter().all(|c| c[2] < self.near);
        if is_outside {
            return None;
        }
        // Positive where the corners run counter-clockwise on the screen, also where some are behind the eye.
        let [a, b, c] = corners;
        let terms = [
            a[0] * (b[1] * c[2] - b[2] * c[1]),
            a[1] * (b[2] * c[0] - b[0] * c[2]),
            a[2] * (b[0] * c[1] - b[1] * c[0]),
        ];
        let doubt = 1e-12 * terms.iter().map(|t| t.abs()).sum::<f64>();
        let turn: f64 = terms.iter().sum();
        let is_culled = (cull == 1 && turn < -doubt) || (cull == 2 && turn > doubt);
        (!is_culled).then_some(corners)
    }
}

/// Where a transform takes a point.
fn place(p: [f32; 3], at: &Transform) -> [f64; 3] {
    std::array::from_fn(|a| {
        let of = |c: usize| f64::from(at.linear[c][a]) * f64::from(p[c]);
        of(0) + of(1) + of(2) + at.translation[a]
    })
}

/// The pixels that points touch, none of them nearer than `least_w`; bounds beyond the screen are outside.
fn bounds(size: [u32; 2], low: [f64; 2], high: [f64; 2], least_w: f64) -> Option<ScreenBounds> {
    // Pixels count from the top, y from the bottom; a little more than rounding comes to.
    let to_pixel = |ndc: f64, extent: u32| (ndc + 1.0) * 0.5 * f64::from(extent);
    let edges = [
        [to_pixel(low[0], size[0]), to_pixel(high[0], size[0])],
        [to_pixel(-high[1], size[1]), to_pixel(-low[1], size[1])],
    ];
    let mut found = ScreenBounds { min: [0; 2], max: [0; 2], nearness: (1.0 / least_w) as f32 };
    found.nearness = found.nearness.next_up();
    for a in 0..2 {
        let [low, high] = [edges[a][0] - 1e-3, edges[a][1] + 1e-3];
        if high < 0.0 || low > f64::from(size[a]) {
            return None;
        }
        let last = f64::from(size[a] - 1);
        found.min[a] = low.floor().clamp(0.0, last) as u32;
        found.max[a] = high.floor().clamp(0.0, last) as u32;
    }
    Some(found)
}

/// Empties a buffer for triangles in clip space, whose near plane is at `near_w`; below 0.001 it is there. Boxes are not to be
/// tested until the next `cullet_occlusion_begin`.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_clip_begin(buffer: Occlusion, near_w: f32) -> Status {
    call("cullet_clip_begin", || {
        if !near_w.is_finite() {
            return Err(Error::value(format!("near_w is {near_w}: it must be finite")));
        }
        let mut own = BUFFERS.get_mut(buffer.id)?;
        let Buffer { buffer, clip, begun, .. } = &mut *own;
        let near = f64::from(near_w.max(LEAST_NEAR));
        let mut clip_from_world = [0.0; 16];
        (clip_from_world[0], clip_from_world[5]) = (1.0, 1.0);
        (clip_from_world[11], clip_from_world[14]) = (1.0, near);
        let view = View::from_matrix(clip_from_world, Depth::Reversed, buffer.size())
            .map_err(|e| Error::new(Status::View, e.to_string()))?;
        buffer.begin(&view, [0.0; 3]);
        *begun = true;
        (clip.near, clip.mirrored) = (near, view.is_mirrored());
        clip.frame += 1;
        let frame = clip.frame;
        clip.surfaces.retain(|_, (_, last)| *last + KEPT_FRAMES > frame);
        Ok(())
    })
}

/// Draws triangles in clip space as occluders, and writes a `cullet_found` into `result`, unless that is NULL: outside where
/// none of them can be seen, else visible. Needs `cullet_clip_begin`. How a set of triangles is drawn is worked out once
/// and kept by where its indices lie, for as long as it is drawn every now and then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_clip_draw(
    buffer: Occlusion,
    triangles: *const ClipTriangles,
    result: *mut u32,
) -> Status {
    call("cullet_clip_draw", || {
        // SAFETY: as the header asks of the caller.
        let triangles = unsafe { value("triangles", triangles) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("result", result, usize::from(!result.is_null())) }?;
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.check()?;
        let Buffer { buffer, clip, .. } = &mut *own;
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { clip.read(&triangles) }?;
        let cull = triangles.cull_winding;
        let mut all = clip.indices.chunks_exact(3);
        let is_seen = all.any(|t| clip.corners(t, &transform, cull).is_some());
        if is_seen {
            // What is outward by its winding looks clockwise under one mirror, and not under two.
            let looks_clockwise = clip.mirrored ^ (transform.determinant() < 0.0);
            let turned = cull != 0 && (looks_clockwise ^ (cull == 2));
            if turned {
                clip.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
            }
            let key = (triangles.indices.addr(), clip.indices.len(), turned);
            let (surface, last) = clip.surfaces.entry(key).or_default();
            *last = clip.frame;
            surface
                .set(&clip.positions, &clip.indices, cull == 0)
                .map_err(|e| Error::value(e.to_string()))?;
            surface.draw(Simd::best(), buffer, &transform);
        }
        let found = if is_seen { Visibility::Visible } else { Visibility::Outside };
        if out.room() > 0 {
            out.set(0, number_of(found).into());
        }
        Ok(())
    })
}

/// Tests a rectangle of the screen, in normalised device coordinates with y upward, as near as `least_w`, and writes a
/// `cullet_found`. Hidden is proved for all of it. Visible where a number is NaN, and this side of the near plane.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_clip_test_rect(
    buffer: Occlusion,
    x_min: f32,
    y_min: f32,
    x_max: f32,
    y_max: f32,
    least_w: f32,
    result: *mut u32,
) -> Status {
    call("cullet_clip_test_rect", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("result", result) }?;
        let own = BUFFERS.get(buffer.id)?;
        own.check()?;
        let numbers = [x_min, y_min, x_max, y_max, least_w].map(f64::from);
        let [x_min, y_min, x_max, y_max, w] = numbers;
        let found = if numbers.iter().any(|v| v.is_nan()) {
            Visibility::Visible
        } else {
            match bounds(own.buffer.size(), [x_min, y_min], [x_max, y_max], w) {
                None => Visibility::Outside,
                Some(_) if w < own.clip.near => Visibility::Visible,
                Some(bounds) => own.buffer.test_bounds(Simd::best(), &bounds),
            }
        };
        out.set(0, number_of(found).into());
        Ok(())
    })
}

/// Tests triangles in clip space, and writes a `cullet_found`: hidden where each that may be seen is proved to be. Each is
/// tested by its rectangle and its nearest corner, so that large slanted ones are found less.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_clip_test_triangles(
    buffer: Occlusion,
    triangles: *const ClipTriangles,
    result: *mut u32,
) -> Status {
    call("cullet_clip_test_triangles", || {
        // SAFETY: as the header asks of the caller.
        let triangles = unsafe { value("triangles", triangles) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("result", result) }?;
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.check()?;
        let Buffer { buffer, clip, .. } = &mut *own;
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { clip.read(&triangles) }?;
        let mut found = Visibility::Outside;
        for triangle in clip.indices.chunks_exact(3) {
            let Some(corners) = clip.corners(triangle, &transform, triangles.cull_winding) else {
                continue;
            };
            let least_w = corners.iter().fold(f64::INFINITY, |w, c| w.min(c[2]));
            let is_bounded = corners.as_flattened().iter().all(|v| v.is_finite());
            if !is_bounded || least_w < clip.near {
                found = Visibility::Visible;
                break;
            }
            let ndc = corners.map(|[x, y, w]| [x / w, y / w]);
            let low = [0, 1].map(|a| ndc.iter().fold(f64::INFINITY, |m, p| m.min(p[a])));
            let high = [0, 1].map(|a| ndc.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[a])));
            let of = bounds(buffer.size(), low, high, least_w);
            match of.map(|bounds| buffer.test_bounds(Simd::best(), &bounds)) {
                None | Some(Visibility::Outside) => {}
                Some(Visibility::Hidden) => found = Visibility::Hidden,
                Some(Visibility::Visible) => {
                    found = Visibility::Visible;
                    break;
                }
            }
        }
        out.set(0, number_of(found).into());
        Ok(())
    })
}
