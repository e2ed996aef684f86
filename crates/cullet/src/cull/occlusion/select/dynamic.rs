//! Occluders of a frame: triangles that the caller has only now, because they deform, or are made on the fly.

use super::super::OcclusionError;
use super::super::occluder::{Facet, Layout, Patch, check_finite};
use super::super::query::BoxProjector;
use super::super::raster::{Connected, OcclusionBuffer};
use super::list::rectangles;
use crate::Simd;
use crate::bits;
use crate::bounds::{Boxes, LANES};
use crate::transform::Transform;

/// Triangles of a patch, consecutive ones of the list.
const TRIANGLES: usize = 128;

/// A surface that is laid out anew whenever it changes, without allocating once its memory has grown.
///
/// [`Patch::cut`] prepares a surface that stays: it welds, pairs triangles to quads, and splits by place. This takes
/// triangles as they come: consecutive ones make a patch, so that they should lie near one another, as they do in the order
/// of a vertex cache; and vertices are one where they have one index. It is as strict: nothing visible is ever hidden.
#[derive(Clone, Debug)]
pub struct DynamicSurface {
    patches: Vec<Patch>,
    /// How many of the patches are in use.
    count: usize,
    boxes: Boxes,
    layout: Layout,
    /// Triangles around each vertex, one vertex after the other.
    ends: Vec<u32>,
    around: Vec<u32>,
    /// The last patch that has a triangle, or has it around.
    patch_of: Vec<u32>,
    own: Vec<Facet>,
    rim: Vec<Facet>,
    order: Vec<(f32, u32)>,
}

impl Default for DynamicSurface {
    /// No triangle.
    fn default() -> Self {
        Self {
            patches: Vec::new(),
            count: 0,
            boxes: Boxes::default(),
            layout: Layout::new(0),
            ends: Vec::new(),
            around: Vec::new(),
            patch_of: Vec::new(),
            own: Vec::new(),
            rim: Vec::new(),
            order: Vec::new(),
        }
    }
}

impl DynamicSurface {
    /// Takes other triangles. Those with two equal indices are left out. `two_sided` ones hide from both sides. Cost: linear
    /// in triangles and vertices. Bounds are in the space of `positions`.
    ///
    /// # Errors
    /// If an index is out of range, or a position is not finite; then it has no triangle.
    pub fn set(
        &mut self,
        positions: &[[f32; 3]],
        indices: &[u32],
        two_sided: bool,
    ) -> Result<(), OcclusionError> {
        self.count = 0;
        self.boxes.clear();
        if let Some(&index) = indices.iter().find(|&&v| v as usize >= positions.len()) {
            return Err(OcclusionError::Index(index, positions.len()));
        }
        check_finite(positions)?;
        let triangles = indices.as_chunks::<3>().0;
        self.find_around(positions.len(), triangles);
        self.layout.begin(positions.len());
        for (number, first) in (1..).zip((0..triangles.len()).step_by(TRIANGLES)) {
            self.gather(number, first, triangles);
            if self.own.is_empty() {
                continue;
            }
            if self.count == self.patches.len() {
                self.patches.push(Patch::none());
            }
            let mesh: &mut Connected = self.patches[self.count].connected();
            self.layout.lay_out(positions, &self.own, &self.rim, two_sided, mesh);
            self.boxes.push(&self.patches[self.count].bounds());
            self.count += 1;
        }
        Ok(())
    }

    /// Draws it, standing at `transform`, nearest patches first, without those that are hidden by then. Nothing where a
    /// number is not finite, and before [`OcclusionBuffer::begin`].
    pub fn draw(&mut self, level: Simd, buffer: &mut OcclusionBuffer, transform: &Transform) {
        let Some((screen, origin)) = buffer.screen() else { return };
        let projector = BoxProjector::of_object(screen, &screen.of_object(transform, origin));
        self.order.clear();
        let some: [u32; LANES] = std::array::from_fn(|i| i as u32);
        for first in (0..self.count).step_by(LANES) {
            let numbers = some.map(|i| i + first as u32);
            let numbers = &numbers[..LANES.min(self.count - first)];
            let r = rectangles(level, projector.as_ref(), &self.boxes, numbers);
            let inside = ((1 << numbers.len()) - 1) & !u64::from(r.outside);
            self.order.extend(bits::ones(inside).map(|lane| {
                let is_bounded = r.bounded >> lane & 1 == 1;
                (if is_bounded { r.nearness[lane] } else { f32::INFINITY }, numbers[lane])
            }));
        }
        self.order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for some in self.order.chunks(LANES) {
            let mut numbers = [0; LANES];
            numbers.iter_mut().zip(some).for_each(|(to, (_, number))| *to = *number);
            let numbers = &numbers[..some.len()];
            let r = rectangles(level, projector.as_ref(), &self.boxes, numbers);
            for (lane, &number) in numbers.iter().enumerate() {
                let is_bounded = r.bounded >> lane & 1 == 1;
                if !(is_bounded && buffer.covers(level, &r.bounds(lane))) {
                    self.patches[number as usize].draw(level, &mut buffer.band(), transform);
                }
            }
        }
    }

    /// Lists the triangles around each vertex.
    fn find_around(&mut self, vertices: usize, triangles: &[[u32; 3]]) {
        self.patch_of.clear();
        self.patch_of.resize(triangles.len(), 0);
        self.ends.clear();
        self.ends.resize(vertices + 1, 0);
        for &v in triangles.as_flattened() {
            self.ends[v as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        // Filled from behind, each end becomes where its vertex begins.
        self.around.resize(triangles.len() * 3, 0);
        for (number, triangle) in triangles.iter().enumerate().rev() {
            for &v in triangle {
                self.ends[v as usize] -= 1;
                self.around[self.ends[v as usize] as usize] = number as u32;
            }
        }
    }

    /// Gathers the triangles of a patch, and those around it.
    fn gather(&mut self, number: u32, first: usize, triangles: &[[u32; 3]]) {
        self.own.clear();
        self.rim.clear();
        let end = triangles.len().min(first + TRIANGLES);
        self.patch_of[first..end].fill(number);
        for triangle in &triangles[first..end] {
            let facet = Facet::triangle(*triangle);
            if facet.is_whole() {
                self.own.push(facet);
            }
            for &v in triangle {
                let of = self.ends[v as usize] as usize..self.ends[v as usize + 1] as usize;
                for &other in &self.around[of] {
                    let patch_of = &mut self.patch_of[other as usize];
                    if *patch_of != number {
                        *patch_of = number;
                        let facet = Facet::triangle(triangles[other as usize]);
                        if facet.is_whole() {
                            self.rim.push(facet);
                        }
                    }
                }
            }
        }
    }
}
