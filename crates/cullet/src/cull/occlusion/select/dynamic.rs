//! Occluders of a frame: triangles that the caller has only now, because they deform, or are made
//! on the fly.

use alloc::vec::Vec;

use super::super::OcclusionError;
use super::super::occluder::{Chunks, Patch, check_finite};
use super::super::query::BoxProjector;
use super::super::raster::OcclusionBuffer;
use super::list::rectangles;
use crate::Simd;
use crate::array::{self, Each};
use crate::bits;
use crate::bounds::{Boxes, LANES};
use crate::sort::{of_f32, sort};
use crate::transform::Transform;

/// A surface whose triangles are given anew whenever they change, without allocating once its
/// memory has grown.
///
/// [`Patch::cut`] prepares a surface that stays: it welds, pairs triangles to quads, and splits by
/// place. This takes triangles as they come: consecutive ones make a patch, so that they should lie
/// near one another, as they do in the order of a vertex cache; and vertices are one where they
/// have one index. It is as strict: nothing visible is ever hidden.
///
/// A patch is laid out when it is first drawn, and stays laid out as long as the indices are the
/// same, wherever the vertices go: what deforms pays for that once, and later for its positions
/// alone.
#[derive(Clone, Debug, Default)]
pub struct DynamicSurface {
    chunks: Chunks,
    positions: Vec<[f32; 3]>,
    two_sided: bool,
    boxes: Boxes,
    /// One for each chunk; more were in use.
    patches: Vec<Laid>,
    /// How often the indices have changed, and the positions.
    versions: [u64; 2],
    /// Complement of the nearness and number of each patch.
    order: Vec<u64>,
}

/// The patch of a chunk, as it was when it was drawn last.
#[derive(Clone, Debug)]
struct Laid {
    patch: Patch,
    /// Where its vertices are among those of the surface.
    vertices: Vec<u32>,
    /// The versions of the surface that it is of.
    versions: [u64; 2],
}

impl DynamicSurface {
    /// Takes other triangles. Those with two equal indices are left out. `two_sided` ones hide from
    /// both sides. Bounds are in the space of `positions`. Cost: linear in triangles and vertices;
    /// where the indices, the number of positions and `two_sided` are as they were, that of reading
    /// indices and positions once.
    ///
    /// # Errors
    /// If an index is out of range, or a position is not finite; then it has no triangle.
    pub fn set(
        &mut self,
        positions: &[[f32; 3]],
        indices: &[u32],
        two_sided: bool,
    ) -> Result<(), OcclusionError> {
        self.boxes.clear();
        check_finite(positions)?;
        if !self.chunks.has(positions.len(), indices) || self.two_sided != two_sided {
            self.versions[0] += 1;
            self.two_sided = two_sided;
            self.chunks.set(positions, indices)?;
            if self.patches.len() < self.chunks.count() {
                let none = Laid { patch: Patch::none(), vertices: Vec::new(), versions: [0; 2] };
                self.patches.resize(self.chunks.count(), none);
            }
        }
        self.versions[1] += 1;
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.boxes.resize(self.chunks.count());
        for chunk in 0..self.chunks.count() {
            self.boxes.set(chunk, &self.chunks.bounds(positions, chunk));
        }
        Ok(())
    }

    /// Draws it, standing at `transform`, nearest patches first, without those that are hidden by
    /// then. Nothing where a number is not finite, and before [`OcclusionBuffer::begin`].
    pub fn draw(&mut self, simd: Simd, buffer: &mut OcclusionBuffer, transform: &Transform) {
        let Some((screen, origin)) = buffer.screen() else { return };
        let projector = BoxProjector::of_object(screen, &screen.of_object(transform, origin));
        self.order.clear();
        let some: [u32; LANES] = array::from_fn(|i| i as u32);
        for first in (0..self.boxes.len()).step_by(LANES) {
            let numbers = some.each(|i| i + first as u32);
            let numbers = &numbers[..LANES.min(self.boxes.len() - first)];
            let r = rectangles(simd, projector.as_ref(), &self.boxes, numbers);
            let inside = ((1 << numbers.len()) - 1) & !u64::from(r.outside);
            self.order.extend(bits::ones(inside).map(|lane| {
                let is_bounded = r.bounded >> lane & 1 == 1;
                let nearness = if is_bounded { r.nearness[lane] } else { f32::INFINITY };
                u64::from(!of_f32(nearness)) << 32 | u64::from(numbers[lane])
            }));
        }
        sort(&mut self.order);
        let order = core::mem::take(&mut self.order);
        for some in order.chunks(LANES) {
            let mut numbers = [0; LANES];
            numbers.iter_mut().zip(some).for_each(|(to, &key)| *to = key as u32);
            let numbers = &numbers[..some.len()];
            let r = rectangles(simd, projector.as_ref(), &self.boxes, numbers);
            for (lane, &number) in numbers.iter().enumerate() {
                let is_bounded = r.bounded >> lane & 1 == 1;
                if !(is_bounded && buffer.covers(simd, &r.bounds(lane))) {
                    self.patch(number as usize).draw(simd, buffer, transform);
                }
            }
        }
        self.order = order;
    }

    /// The patch of a chunk, as it is now.
    fn patch(&mut self, chunk: usize) -> &Patch {
        let Laid { patch, vertices, versions } = &mut self.patches[chunk];
        if *versions != self.versions {
            let mesh = patch.connected();
            if versions[0] != self.versions[0] {
                self.chunks.lay_out(chunk, self.two_sided, mesh, vertices);
            }
            mesh.place(&self.positions, vertices);
            *versions = self.versions;
        }
        patch
    }
}
