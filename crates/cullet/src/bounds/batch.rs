//! Boxes and spheres in batches, made ready for the conservative tests of
//! [`cull::frustum`](crate::cull::frustum).
//!
//! Items lie in blocks of sixteen: one row of sixteen numbers a coordinate, rows of one block side
//! by side, each row one cache line. A test reads them in one stream, and no vector load crosses a
//! line. A box is kept as −min and max, so that a plane test has no negative coefficient and picks
//! a row where it would have picked a sign.
//!
//! Stored bounds are never tighter than the given ones, and just so much wider that the f32 tests
//! need no error term. With u = 2⁻²⁴: a plane test sums |n|·y over three axes, where y is −min or
//! max, as y₀ + (b·y₁ + c·y₂), the plane being scaled so that the first coefficient is 1. Rounding
//! b and c to f32, two products and two sums lose at most 4u Σ|n||y|, and 2⁻¹⁴⁵ where a product
//! underflows. [`Boxes::set`] moves every coordinate outward by at least 14u|y| + 2⁻¹²⁷, which adds
//! 14u Σ|n||y| + 2⁻¹²⁷ to the sum. Comparing the sum with the offset is exact. The stored sum is
//! therefore never below the exact sum of the box that was given, and what is culled is outside.
//! The same growth serves the test for inside, whose sum takes the other corner.

use alloc::vec::Vec;

use crate::array::Each;
use crate::simd::dispatch_256;
use bytemuck::{Pod, Zeroable};
use fearless_simd::prelude::*;

use super::{Aabb, Sphere};

/// How many items a block holds: the lanes of the widest vector there is.
pub(crate) const LANES: usize = 16;

/// Sixteen boxes: rows −min x, y, z, then max x, y, z.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct BoxBlock(pub(crate) [[f32; LANES]; 6]);

/// Sixteen spheres: rows x, y, z and radius.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct SphereBlock(pub(crate) [[f32; LANES]; 4]);

/// 2⁻²⁰ = 16 u: 14 u are promised, the rest pays for the rounding of the widening itself.
const BOX_STEP: f32 = 1.0 / (1 << 20) as f32;

/// 2⁻¹⁹ = 32 u: the test of a plane loses up to 6 u, for its normal, three products and three sums.
const SPHERE_STEP: f32 = 1.0 / (1 << 19) as f32;

impl Block for BoxBlock {
    type Item = Aabb;
    const NAME: &'static str = "box";

    fn set(&mut self, lane: usize, b: &Aabb) {
        let ([x, y, z], [p, q, r]) = (b.min, b.max);
        let is_plain = |low: f32, high: f32| {
            (low.abs() < Boxes::LIMIT) & (high.abs() < Boxes::LIMIT) & (low <= high)
        };
        // One branch: most boxes are plain.
        let rows = if is_plain(x, p) & is_plain(y, q) & is_plain(z, r) {
            [-x, -y, -z, p, q, r].each(widen)
        } else {
            rows_of_invalid(b)
        };
        for (row, v) in self.0.iter_mut().zip(rows) {
            row[lane] = v;
        }
    }

    fn get(&self, lane: usize) -> Aabb {
        let at = |row: usize| self.0[row][lane];
        Aabb { min: [-at(0), -at(1), -at(2)], max: [at(3), at(4), at(5)] }
    }

    fn rows_mut(&mut self) -> &mut [[f32; LANES]] {
        &mut self.0
    }
}

impl Block for SphereBlock {
    type Item = Sphere;
    const NAME: &'static str = "sphere";

    fn set(&mut self, lane: usize, s: &Sphere) {
        let beyond = |v: f32| v.is_nan() || v.abs() >= Boxes::LIMIT;
        let whole = beyond(s.radius) || s.center.iter().any(|&v| beyond(v));
        let (center, radius) = if s.radius < 0.0 {
            ([0.0; 3], -Spheres::REACH)
        } else if whole {
            ([0.0; 3], Spheres::REACH)
        } else {
            let reach = s.center.iter().map(|v| v.abs()).sum::<f32>() + s.radius;
            // 33/32: the rounding of this line itself.
            let growth = reach * (SPHERE_STEP * (33.0 / 32.0)) + f32::MIN_POSITIVE;
            (s.center, (s.radius + growth).next_up())
        };
        for axis in 0..3 {
            self.0[axis][lane] = center[axis];
        }
        self.0[3][lane] = radius;
    }

    fn get(&self, lane: usize) -> Sphere {
        let at = |row: usize| self.0[row][lane];
        Sphere { center: [at(0), at(1), at(2)], radius: at(3) }
    }

    fn rows_mut(&mut self) -> &mut [[f32; LANES]] {
        &mut self.0
    }
}

/// Rows of a box that is empty, not finite or beyond the limit.
#[cold]
fn rows_of_invalid(b: &Aabb) -> [f32; 6] {
    // A NaN means keep, whatever the other numbers say; so it is tested first.
    let nan = b.min.iter().chain(&b.max).any(|v| v.is_nan());
    if !nan && b.is_empty() { [-Boxes::LIMIT; 6] } else { [Boxes::LIMIT; 6] }
}

/// Moves a coordinate outward by 16u|v|: it is positive that way, as −min and max are.
fn widen(v: f32) -> f32 {
    v + (v.abs() * BOX_STEP + f32::MIN_POSITIVE)
}

/// Sixteen items of a batch, a row of sixteen numbers for each coordinate. Boxes and spheres have
/// one.
pub trait Block: Pod + sealed::Sealed {
    /// The item that a block holds sixteen of.
    type Item;
    /// Name of one item.
    #[doc(hidden)]
    const NAME: &'static str;

    /// Stores an item in a lane, a little larger than it is given.
    #[doc(hidden)]
    fn set(&mut self, lane: usize, item: &Self::Item);

    /// The item of a lane, as it is stored.
    #[doc(hidden)]
    fn get(&self, lane: usize) -> Self::Item;

    #[doc(hidden)]
    fn rows_mut(&mut self) -> &mut [[f32; LANES]];
}

mod sealed {
    /// Sealed: the tests know every kind of block.
    pub trait Sealed {}
    impl Sealed for super::BoxBlock {}
    impl Sealed for super::SphereBlock {}
}

/// A growable batch of boxes or spheres, in blocks of sixteen. They are stored a little larger than
/// given, which is what makes the tests of a batch conservative.
#[derive(Clone, Debug)]
pub struct Batch<B> {
    blocks: Vec<B>,
    len: usize,
}

/// A batch of axis-aligned boxes: 24 bytes each, stored one part in a million larger than given. A
/// box with a coordinate that is not finite becomes the whole of space; an empty box stays empty,
/// and every frustum that has a plane culls it.
pub type Boxes = Batch<BoxBlock>;

/// A batch of spheres: 16 bytes each, stored larger by two parts in a million of the radius and of
/// the distance from the origin. One that is not finite, or reaches [`Boxes::LIMIT`], becomes the
/// whole of space; one with a negative radius is empty, and every frustum that has a plane culls
/// it.
pub type Spheres = Batch<SphereBlock>;

impl Boxes {
    /// A box with a coordinate of this size or more, or a coordinate that is not finite, is stored
    /// as ±this in every direction: no frustum culls it. Chosen so that no plane test can overflow.
    pub const LIMIT: f32 = 1e18;
}

impl Spheres {
    /// The radius that stands for the whole of space, and, negated, for an empty sphere: more than
    /// any plane's distance from any point within [`Boxes::LIMIT`].
    const REACH: f32 = 8.0 * Boxes::LIMIT;
}

impl Boxes {
    /// Replaces all boxes by `items[order[0]]`, `items[order[1]]` and so on: what setting them one
    /// by one gives, sixteen at a time.
    ///
    /// # Panics
    /// If `order` has a number that is not below the length of `items`.
    pub fn gather(&mut self, simd: crate::Simd, items: &[Aabb], order: &[u32]) {
        self.resize(order.len());
        let (whole, rest) = order.as_chunks::<LANES>();
        dispatch_256!(simd, simd => gather_blocks(simd, &mut self.blocks, whole, items));
        let first = whole.len() * LANES;
        for (i, &from) in rest.iter().enumerate() {
            self.set(first + i, &items[from as usize]);
        }
    }

    /// Replaces all boxes by `stored[order[0]]` and so on, which were read from a batch and so are
    /// wide enough.
    pub(crate) fn gather_stored(&mut self, stored: &[Aabb], order: &[u32]) {
        self.resize(order.len());
        for (i, &from) in order.iter().enumerate() {
            self.set_stored(i, &stored[from as usize]);
        }
    }

    /// Puts `stored[order[i]]`, read from a batch, into place `to[i]`, for all i.
    pub(crate) fn scatter_stored(&mut self, stored: &[Aabb], order: &[u32], to: &[u32]) {
        for (&from, &to) in order.iter().zip(to) {
            self.set_stored(to as usize, &stored[from as usize]);
        }
    }

    fn set_stored(&mut self, index: usize, b: &Aabb) {
        let block = &mut self.blocks[index / LANES].0;
        for axis in 0..3 {
            block[axis][index % LANES] = -b.min[axis];
            block[axis + 3][index % LANES] = b.max[axis];
        }
    }
}

/// Fills blocks with the items of each sixteen numbers of `order`, as setting them would.
#[inline(always)]
fn gather_blocks<S: Simd>(
    simd: S,
    blocks: &mut [BoxBlock],
    order: &[[u32; LANES]],
    items: &[Aabb],
) {
    for (block, order) in blocks.iter_mut().zip(order) {
        for (lane, &from) in order.iter().enumerate() {
            let Aabb { min, max } = items[from as usize];
            for axis in 0..3 {
                block.0[axis][lane] = -min[axis];
                block.0[axis + 3][lane] = max[axis];
            }
        }
        if !widen_block(simd, block) {
            for (lane, &from) in order.iter().enumerate() {
                block.set(lane, &items[from as usize]);
            }
        }
    }
}

/// Widens sixteen plain boxes, or leaves them and returns `false` if any of them is not plain.
#[inline(always)]
fn widen_block<S: Simd>(simd: S, block: &mut BoxBlock) -> bool {
    let limit = S::f32s::splat(simd, Boxes::LIMIT);
    let zero = S::f32s::splat(simd, 0.0);
    for at in (0..LANES).step_by(S::f32s::LEN) {
        for axis in 0..3 {
            let low = S::f32s::from_slice(simd, &block.0[axis][at..at + S::f32s::LEN]);
            let high = S::f32s::from_slice(simd, &block.0[axis + 3][at..at + S::f32s::LEN]);
            // False for a NaN, and max < min has a negative sum.
            let plain =
                low.abs().simd_lt(limit) & high.abs().simd_lt(limit) & (low + high).simd_ge(zero);
            if !plain.all_true() {
                return false;
            }
        }
    }
    let step = S::f32s::splat(simd, BOX_STEP);
    let least = S::f32s::splat(simd, f32::MIN_POSITIVE);
    for row in &mut block.0 {
        for at in (0..LANES).step_by(S::f32s::LEN) {
            let part = &mut row[at..at + S::f32s::LEN];
            let v = S::f32s::from_slice(simd, part);
            (v + (v.abs() * step + least)).store_slice(part);
        }
    }
    true
}

impl<B> Default for Batch<B> {
    fn default() -> Self {
        Self { blocks: Vec::new(), len: 0 }
    }
}

impl<B: Block> Batch<B> {
    /// An empty batch.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A batch of the items of a slice, in their order.
    #[must_use]
    pub fn from_slice(items: &[B::Item]) -> Self {
        let mut batch = Self::new();
        batch.extend_from_slice(items);
        batch
    }

    /// How many items there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all items, keeps the memory.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    /// Appends items.
    pub fn extend_from_slice(&mut self, items: &[B::Item]) {
        let first = self.len;
        self.resize(first + items.len());
        for (i, item) in items.iter().enumerate() {
            self.set(first + i, item);
        }
    }

    /// Appends one item.
    pub fn push(&mut self, item: &B::Item) {
        self.resize(self.len + 1);
        self.set(self.len - 1, item);
    }

    /// Sets the number of items; new ones are points at the origin until they are set.
    pub fn resize(&mut self, len: usize) {
        self.blocks.resize(len.div_ceil(LANES), B::zeroed());
        // Lanes that a shorter batch leaves behind would come back as they were when it grows
        // again.
        if len < self.len
            && let Some(block) = self.blocks.get_mut(len / LANES)
        {
            block.rows_mut().iter_mut().for_each(|row| row[len % LANES..].fill(0.0));
        }
        self.len = len;
    }

    /// Replaces item `index`; for non-finite and empty ones see [`Boxes`] and [`Spheres`].
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, item: &B::Item) {
        assert!(index < self.len, "{} {index} of a batch of {}", B::NAME, self.len);
        self.blocks[index / LANES].set(index % LANES, item);
    }

    /// Item `index` as it is stored, a little larger than it was given.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    #[must_use]
    pub fn get(&self, index: usize) -> B::Item {
        assert!(index < self.len, "{} {index} of a batch of {}", B::NAME, self.len);
        self.blocks[index / LANES].get(index % LANES)
    }

    /// The numbers as they lie in memory. For each sixteen boxes: sixteen of −min x, of −min y, of
    /// −min z, of max x, of max y, of max z; for each sixteen spheres: of x, of y, of z, of the
    /// radius. Lanes past the last item are zero.
    #[must_use]
    pub fn as_floats(&self) -> &[f32] {
        bytemuck::cast_slice(&self.blocks)
    }

    pub(crate) fn blocks(&self) -> &[B] {
        &self.blocks
    }

    /// The blocks, to be written; written bounds must contain their items.
    pub(crate) fn blocks_mut(&mut self) -> &mut [B] {
        &mut self.blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_boxes_hold_the_given_ones() {
        for v in [0.0, 1e-40, -1e-30, 1.0, -123.456, 9.9e17, -9.9e17] {
            let given = Aabb::new([v; 3], [v; 3]);
            let got = Boxes::from_slice(&[given]).get(0);
            assert!(got.min[0] < v && v < got.max[0], "{v:e} in {got:?}");
        }
    }

    #[test]
    fn invalid_boxes_become_everything_or_stay_empty() {
        let limit = Boxes::LIMIT;
        let mut invalid = Aabb::new([0.0; 3], [1.0; 3]);
        invalid.max[1] = f32::NAN;
        let infinite = Aabb::new([f32::INFINITY; 3], [f32::INFINITY; 3]);
        let batch = Boxes::from_slice(&[invalid, Aabb::EVERYTHING, infinite, Aabb::EMPTY]);
        for i in 0..3 {
            assert_eq!(batch.get(i), Aabb::new([-limit; 3], [limit; 3]), "box {i}");
        }
        assert!(batch.get(3).is_empty());
        // Items that were read back can be stored again.
        let again = Boxes::from_slice(&[batch.get(0), batch.get(3)]);
        assert_eq!(again.get(0), batch.get(0));
        assert!(again.get(1).is_empty());
    }

    #[test]
    fn a_batch_that_shrank_grows_with_points_at_the_origin() {
        let mut batch = Boxes::from_slice(&[Aabb::new([1.0; 3], [2.0; 3]); 20]);
        batch.resize(3);
        batch.resize(20);
        assert_eq!(batch.get(3).max, [0.0; 3]);
        assert!(batch.get(2).max[0] >= 2.0);
    }
}
