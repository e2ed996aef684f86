//! The planes of a frustum, prepared for tests of boxes.

use crate::array::Each;
use crate::bounds::{Aabb, Block, BoxBlock, Boxes, Plane, Side, round_down, round_up};
use crate::transform::Transform;
use crate::view::Frustum;

/// One plane for boxes, scaled so that its coefficient on the axis of the first row is 1.
///
/// The corner of a box nearest to the inside has n·x = −(y₀ + b·y₁ + c·y₂) with y from these rows
/// of a block (−min where n > 0, max elsewhere): the box is outside iff that sum plus `d` is
/// negative. The opposite corner, of rows (r + 3) mod 6, has n·x = z₀ + b·z₁ + c·z₂.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cull::frustum) struct BoxPlane {
    rows: [u8; 3],
    number: u8,
    pub(in crate::cull::frustum) b: f32,
    pub(in crate::cull::frustum) c: f32,
    /// The offset, rounded up: +∞ where the plane may reject nothing.
    pub(in crate::cull::frustum) d: f32,
    /// The offset, rounded down: −∞ where nothing may be called inside.
    pub(in crate::cull::frustum) inside: f32,
}

/// Beyond this a plane's offset says nothing about items within [`Boxes::LIMIT`].
const FAR_OFF: f64 = Boxes::LIMIT as f64 / 2.0;

/// Largest contribution of a coefficient flushed to zero, within [`Boxes::LIMIT`].
pub(super) const FLUSHED: f64 = f32::MIN_POSITIVE as f64 * Boxes::LIMIT as f64 * 4.0;

/// Offsets of a plane whose exact offset is `d`, give or take `slack`: rounded up, and down.
pub(super) fn offsets(d: f64, slack: f64) -> (f32, f32) {
    // A few units of f64 for the arithmetic that made d.
    let slack = slack + d.abs() * 1e-15;
    let outside = if d > -FAR_OFF { round_up(d + slack) } else { f32::INFINITY };
    let inside =
        if d > -FAR_OFF { round_down((d - slack).min(FAR_OFF)) } else { f32::NEG_INFINITY };
    // + 0.0: a sum with −0 could be −0, whose sign bit is set though it is not negative.
    (outside + 0.0, inside + 0.0)
}

impl BoxPlane {
    /// A plane that rejects nothing and has nothing inside.
    const NEVER: Self = Self {
        rows: [0, 1, 2],
        number: u8::MAX,
        b: 0.0,
        c: 0.0,
        d: f32::INFINITY,
        inside: f32::NEG_INFINITY,
    };

    fn new(number: usize, plane: &Plane) -> Self {
        let (n, number) = (plane.normal, number as u8);
        let size = |a: usize| n[a].abs();
        let first = (0..3).fold(0, |best, a| if size(a) > size(best) { a } else { best });
        let axes = [[0, 1, 2], [1, 0, 2], [2, 0, 1]][first];
        let unit = size(first);
        if !n.iter().all(|v| v.is_finite()) || unit == 0.0 || plane.d.is_nan() {
            return Self { number, ..Self::NEVER };
        }
        let mut slack = 0.0;
        let mut coefficient = |axis: usize| {
            let v = size(axis) / unit;
            if v != 0.0 && v < f64::from(f32::MIN_POSITIVE) {
                slack += FLUSHED;
                return 0.0;
            }
            v as f32
        };
        let (b, c) = (coefficient(axes[1]), coefficient(axes[2]));
        let (d, inside) = offsets(plane.d / unit, slack);
        let rows = axes.each(|a| if n[a] < 0.0 { a + 3 } else { a } as u8);
        Self { rows, number, b, c, d, inside }
    }

    /// The rows of the corner nearest to the inside, each below 6.
    #[inline(always)]
    pub(in crate::cull::frustum) fn near_rows(&self) -> [usize; 3] {
        let rows = self.rows.each(usize::from);
        // Once a plane, so that loads from these rows need no check of their own.
        assert!(rows[0] < 6 && rows[1] < 6 && rows[2] < 6);
        rows
    }

    /// The rows of the opposite corner, each below 6.
    #[inline(always)]
    pub(in crate::cull::frustum) fn far_rows(&self) -> [usize; 3] {
        self.near_rows().each(|r| (r + 3) % 6)
    }

    /// Whether the plane rejects the box in `lane` of a block: the very arithmetic of the fast
    /// paths.
    fn rejects(&self, block: &BoxBlock, lane: usize) -> bool {
        let y = self.near_rows().each(|r| block.0[r][lane]);
        y[0] + (y[1] * self.b + y[2] * self.c) + self.d < 0.0
    }

    /// Whether the box is on the inner side of the plane.
    fn contains(&self, block: &BoxBlock, lane: usize) -> bool {
        let z = self.far_rows().each(|r| block.0[r][lane]);
        z[0] + (z[1] * self.b + z[2] * self.c) <= self.inside
    }
}

/// A frustum made ready for tests of boxes: its planes in f32, scaled and sorted.
///
/// Made once a view, from a frustum in the coordinates of the boxes (see
/// [`Frustum::relative_to`]). Offsets are rounded towards keep. A plane with a NaN or no direction
/// rejects nothing, and nothing is inside it.
#[derive(Clone, Debug)]
pub struct Planes {
    planes: [BoxPlane; Frustum::MAX_PLANES],
    count: usize,
}

impl Planes {
    /// Prepares the planes of `frustum`.
    #[must_use]
    pub fn new(frustum: &Frustum) -> Self {
        Self::of(frustum.planes().map(|(number, plane)| (number, *plane)))
    }

    /// Prepares the planes of `frustum` whose bits are set in `wanted`, in the space of an object:
    /// see [`Frustum::to_object_space`].
    pub(crate) fn in_object_space(frustum: &Frustum, transform: &Transform, wanted: u32) -> Self {
        Self::of(frustum.planes_in_object_space(transform, wanted))
    }

    fn of(all: impl Iterator<Item = (usize, Plane)>) -> Self {
        let mut planes = Self { planes: [BoxPlane::NEVER; Frustum::MAX_PLANES], count: 0 };
        for ((number, plane), to) in all.zip(&mut planes.planes) {
            *to = BoxPlane::new(number, &plane);
            planes.count += 1;
        }
        planes
    }

    /// Where one box lies, by the arithmetic of the batch tests: one box gets here the answer that
    /// it gets in a batch.
    #[must_use]
    pub fn classify_box(&self, b: &Aabb) -> Side {
        self.side(&alone(b), 0)
    }

    /// The planes that a box is not proved inside of: a bit for the number of each.
    pub(crate) fn straddled(&self, b: &Aabb) -> u32 {
        let block = alone(b);
        let straddled = self.box_planes().iter().filter(|p| !p.contains(&block, 0));
        straddled.fold(0, |bits, p| bits | 1 << p.number)
    }

    /// The number of the first plane that rejects box `index` of a batch, or
    /// [`VISIBLE`](super::VISIBLE).
    ///
    /// # Panics
    /// If `index` is not below the batch's length.
    #[must_use]
    pub(crate) fn first_rejecting(&self, boxes: &Boxes, index: usize) -> u8 {
        let block = &boxes.blocks()[index / 16];
        let first = self.box_planes().iter().find(|p| p.rejects(block, index % 16));
        first.map_or(super::VISIBLE, |p| p.number)
    }

    /// Where box `index` of a batch lies.
    ///
    /// # Panics
    /// If `index` is not below the batch's length.
    #[must_use]
    pub fn classify_stored(&self, boxes: &Boxes, index: usize) -> Side {
        self.side(&boxes.blocks()[index / 16], index % 16)
    }

    pub(in crate::cull::frustum) fn box_planes(&self) -> &[BoxPlane] {
        &self.planes[..self.count]
    }

    /// Where the box in `lane` of a block lies.
    fn side(&self, block: &BoxBlock, lane: usize) -> Side {
        if self.box_planes().iter().any(|p| p.rejects(block, lane)) {
            Side::Outside
        } else if self.box_planes().iter().all(|p| p.contains(block, lane)) {
            Side::Inside
        } else {
            Side::Straddling
        }
    }
}

/// A block with a box in its first lane.
fn alone(b: &Aabb) -> BoxBlock {
    let mut block: BoxBlock = bytemuck::Zeroable::zeroed();
    block.set(0, b);
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_leave_the_slack_on_either_side_and_little_more() {
        for (d, slack) in [(1.0, 0.25), (-3.0, 1e-9), (0.1, 0.0), (1e6, 0.5)] {
            let (outside, inside) = offsets(d, slack);
            let over = [f64::from(outside) - (d + slack), d - slack - f64::from(inside)];
            assert!(over.iter().all(|&v| v >= 0.0 && v <= d.abs() * 1e-6), "{d} {slack}: {over:?}");
        }
    }
}
