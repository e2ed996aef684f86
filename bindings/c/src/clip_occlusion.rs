//! Occlusion in clip space, for `cullet_moc.h`.
//!
//! Clip space itself is the world here: x, y and w are its axes, the eye is its origin, and a view
//! whose near plane lies at a w shows it. So what is drawn and tested takes the same way, with the
//! same proofs, as anywhere else.

use engine::cull::occlusion::Visibility;
use engine::{Depth, Simd, View};

use crate::clip::{ClipTriangles, bounds};
use crate::memory::{Out, value};
use crate::occlusion::{BUFFERS, Buffer, Occlusion, number_of};
use crate::status::{Error, Status, call};

/// Frames after which the layout of triangles that are not drawn any more is forgotten.
const KEPT_FRAMES: u64 = 64;

/// The least near plane: nearness has 32 octaves from there on.
const LEAST_NEAR: f32 = 1e-3;

/// Empties a buffer for triangles in clip space, whose near plane is at `near_w`; below 0.001 it is
/// there. Boxes are not to be tested until the next `cullet_occlusion_begin`.
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

/// Draws triangles in clip space as occluders, and writes a `cullet_found` into `result`, unless
/// that is NULL: outside where none of them can be seen, else visible. Needs `cullet_clip_begin`.
/// How a set of triangles is drawn is worked out once and kept by where its indices lie, for as
/// long as it is drawn every now and then.
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

/// Tests a rectangle of the screen, in normalised device coordinates with y upward, as near as
/// `least_w`, and writes a `cullet_found`. Hidden is proved for all of it. Visible where a number
/// is NaN, and this side of the near plane.
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

/// Tests triangles in clip space, and writes a `cullet_found`: hidden where each that may be seen
/// is proved to be. Each is tested by its rectangle and its nearest corner, so that large slanted
/// ones are found less.
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
