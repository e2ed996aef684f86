//! Occluders beside boxes, without a scene: shapes that are drawn into an occlusion buffer.

use alloc::vec::Vec;

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Patch, Shape};
use cullet::view::ViewError;
use cullet::{Simd, Transform};

use crate::camera::view_of;
use crate::fault::has_room;

/// Occluders under fixed numbers, and the buffer that they are drawn into.
#[derive(Debug)]
pub struct Occluders {
    simd: Simd,
    buffer: OcclusionBuffer,
    /// Place of the occluder of each number; `None` once it was removed.
    places: Vec<Option<Transform>>,
    /// Shapes of all occluders with the numbers of those, and for each its box in the world and the
    /// pixels that it is worth drawing from.
    shapes: Vec<(Shape, u32)>,
    boxes: Boxes,
    least_pixels: Vec<f32>,
    keys: Vec<u128>,
    order: Vec<u32>,
}

/// Why an occluder is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// There is not enough memory.
    Memory,
    /// It has no triangle, or a number that is not finite or not there.
    Invalid,
}

impl Occluders {
    /// A buffer of so many pixels, at most 4096 each way; `None` for other sizes, and where memory
    /// does not suffice.
    pub fn new(size: [u32; 2]) -> Option<Self> {
        let [width, height] = size.map(|s| s as usize);
        if !has_room(width.checked_mul(height)?.checked_mul(4)?) {
            return None;
        }
        Some(Self {
            simd: Simd::best(),
            buffer: OcclusionBuffer::new(size).ok()?,
            places: Vec::new(),
            shapes: Vec::new(),
            boxes: Boxes::new(),
            least_pixels: Vec::new(),
            keys: Vec::new(),
            order: Vec::new(),
        })
    }

    /// Adds a box, which hides from all sides: least and greatest corner in its own space.
    ///
    /// # Errors
    /// If it is empty or not finite.
    pub fn add_box(&mut self, [a, b, c, x, y, z]: [f32; 6]) -> Result<u32, Refusal> {
        let convex = Convex::from_box(&Aabb::new([a, b, c], [x, y, z]));
        let convex = convex.map_err(|_| Refusal::Invalid)?;
        Ok(self.add([Shape::Convex(convex)]))
    }

    /// Adds triangles: a body where they close one that is convex, else a surface. `two_sided` ones
    /// hide from both sides, others from where they are wound counter-clockwise.
    ///
    /// # Errors
    /// If an index is out of range, a position is not finite, or memory does not suffice.
    pub fn add_triangles(
        &mut self,
        positions: &[[f32; 3]],
        indices: &[u32],
        two_sided: bool,
    ) -> Result<u32, Refusal> {
        if !has_room((positions.len() * 3 + indices.len()).saturating_mul(16)) {
            return Err(Refusal::Memory);
        }
        let is_short = indices.len() <= MOST_OF_BODY;
        if let Some(body) = is_short.then(|| Convex::from_mesh(positions, indices)).flatten() {
            return Ok(self.add([Shape::Convex(body)]));
        }
        let patches = Patch::cut(positions, indices, Patch::FACETS, two_sided);
        Ok(self.add(patches.map_err(|_| Refusal::Invalid)?.into_iter().map(Shape::Patch)))
    }

    fn add(&mut self, shapes: impl IntoIterator<Item = Shape>) -> u32 {
        let number = self.places.len() as u32;
        self.places.push(Some(Transform::IDENTITY));
        for shape in shapes {
            self.boxes.push(&shape.bounds());
            self.least_pixels.push(shape.worth_pixels());
            self.shapes.push((shape, number));
        }
        number
    }

    /// Places an occluder by a column-major matrix. O(shapes). False for one that is not there.
    pub fn set_matrix(&mut self, number: u32, matrix: &[f64; 16]) -> bool {
        let Some(Some(place)) = self.places.get_mut(number as usize) else { return false };
        *place = Transform::from_matrix(matrix);
        for (i, (shape, _)) in self.shapes.iter().enumerate().filter(|(_, (_, of))| *of == number) {
            self.boxes.set(i, &place.transform_box(&shape.bounds(), [0.0; 3]));
        }
        true
    }

    /// Removes an occluder, whose number is not given again. O(shapes). False for one that is not
    /// there.
    pub fn remove(&mut self, number: u32) -> bool {
        let place = self.places.get_mut(number as usize).and_then(Option::take);
        let mut kept = 0;
        for i in 0..self.shapes.len() {
            if self.shapes[i].1 != number {
                self.shapes.swap(kept, i);
                self.least_pixels.swap(kept, i);
                let bounds = self.boxes.get(i);
                self.boxes.set(kept, &bounds);
                kept += 1;
            }
        }
        self.shapes.truncate(kept);
        self.least_pixels.truncate(kept);
        self.boxes.resize(kept);
        place.is_some()
    }

    /// Turns the buffer to a camera, world to clip space, and draws all occluders, the nearest
    /// first, but for those that are hidden by then or too small to hide much. Depth is as a
    /// page has it. Returns how many shapes were drawn.
    ///
    /// # Errors
    /// If the matrix shows no volume; then the buffer stays as it was.
    pub fn draw(&mut self, matrix: [f64; 16], depth: u32) -> Result<usize, ViewError> {
        let view = view_of(matrix, depth, self.buffer.size())?;
        self.buffer.begin(&view, [0.0; 3]);
        let [x, y, z, w] = view.eye();
        self.keys.clear();
        for i in 0..self.boxes.len() {
            let b = self.boxes.get(i);
            // To the nearest point of the box; in a parallel view to its middle, along the view.
            let mut far = 0.0;
            for (a, eye) in [x, y, z].into_iter().enumerate() {
                let [min, max] = [b.min[a], b.max[a]].map(f64::from);
                let beyond = eye - eye.max(min).min(max);
                far += if w == 0.0 { -eye * (min + max) } else { beyond * beyond };
            }
            self.keys.push(u128::from(order_of(far)) << 32 | i as u128);
        }
        self.keys.sort_unstable();
        self.order.clear();
        self.order.extend(self.keys.iter().map(|&key| key as u32));
        let (simd, shapes, places) = (self.simd, &self.shapes, &self.places);
        Ok(self.buffer.draw_unless_hidden(
            simd,
            (&self.boxes, &self.least_pixels),
            &self.order,
            |buffer, i| {
                let (shape, number) = &shapes[i as usize];
                if let Some(place) = &places[*number as usize] {
                    shape.draw(simd, buffer, place);
                }
            },
        ))
    }

    /// The buffer.
    pub fn buffer(&self) -> &OcclusionBuffer {
        &self.buffer
    }
}

/// Corners of the longest list that is tried as a body.
const MOST_OF_BODY: usize = 256 * 32;

/// A number in the order of [`f64::total_cmp`].
fn order_of(v: f64) -> u64 {
    let bits = v.to_bits();
    bits ^ if v.is_sign_negative() { u64::MAX } else { 1 << 63 }
}
