//! Triangles in clip space: vertices are x, y and w of a projection that the caller has made,
//! whatever it is.

use std::collections::HashMap;

use engine::Transform;
use engine::cull::occlusion::{DynamicSurface, ScreenBounds};

use crate::memory::{Layout, Plain, read, reserved, value, vertices};
use crate::status::{Error, Result};

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
    /// 16 floats, column-major, that take x, y, z, 1 to clip space; NULL where vertices are x, y, w
    /// of clip space.
    pub clip_from_model: *const f32,
    /// Winding that is culled on a screen with y upward: 0 nothing, 1 clockwise, 2
    /// counter-clockwise.
    pub cull_winding: u32,
    /// 0.
    pub reserved: u32,
}

impl Plain for ClipTriangles {}

/// Memory of triangles in clip space.
#[derive(Debug, Default)]
pub(crate) struct Clip {
    /// Where the near plane is, in w.
    pub(crate) near: f64,
    pub(crate) mirrored: bool,
    pub(crate) frame: u64,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<u32>,
    /// Surfaces by where their indices lie and how many there are, and the frame that last drew
    /// them.
    pub(crate) surfaces: HashMap<(usize, usize, bool), (DynamicSurface, u64)>,
}

impl Clip {
    /// Reads triangles; returns their transform to x, y, w. None of them leaves no index.
    ///
    /// # Safety
    /// As the header asks of the caller.
    pub(crate) unsafe fn read(&mut self, triangles: &ClipTriangles) -> Result<Transform> {
        let ClipTriangles { stride, offset_y: second, offset_zw: third, .. } = *triangles;
        reserved("triangles->reserved", triangles.reserved)?;
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
        // A matrix that flattens the model, such as one whose w is the same everywhere, has no eye
        // in the model's space.
        for p in &mut self.positions {
            *p = place(*p, &transform).map(|v| v as f32);
        }
        Ok(Transform::IDENTITY)
    }

    /// The corners of a triangle in clip space, if it may be in view and is not culled by its
    /// winding.
    pub(crate) fn corners(
        &self,
        triangle: &[u32],
        at: &Transform,
        cull: u32,
    ) -> Option<[[f64; 3]; 3]> {
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
        // Positive where the corners run counter-clockwise on the screen, also where some are
        // behind the eye.
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

/// The pixels that points touch, none of them nearer than `least_w`; bounds beyond the screen are
/// outside.
pub(crate) fn bounds(
    size: [u32; 2],
    low: [f64; 2],
    high: [f64; 2],
    least_w: f64,
) -> Option<ScreenBounds> {
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
