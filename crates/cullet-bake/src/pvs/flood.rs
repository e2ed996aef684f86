//! Cells that could be reached, judged by whole portals: quick, and never too few.

use glam::Vec4;

use super::openings::{Bounds, Openings, Plane32};
use super::polygon::HalfSpaces;
use crate::rows::{BitRows, has, meet, set};

/// Cells that a line through an opening may reach: through portals that are not wholly behind it,
/// and that it is not wholly ahead of.
pub(super) fn candidates(openings: &Openings, through: u32, row: &mut [u64], stack: &mut Vec<u32>) {
    let opening = openings.get(through);
    let (plane, bounds) = (openings.plane32(through), openings.bounds(through));
    let thin = openings.tolerance32;
    set(row, opening.to);
    stack.clear();
    stack.push(opening.to);
    while let Some(cell) = stack.pop() {
        for next in openings.leaving(cell) {
            let ahead = openings.bounds(next);
            let to = ahead.to;
            if to == opening.from || has(row, to) || plane.reach(ahead) <= thin {
                continue;
            }
            let other = openings.plane32(next);
            let behind = Plane32 { normal: -other.normal, d: -other.d };
            if behind.reach(bounds) > thin {
                set(row, to);
                stack.push(to);
            }
        }
    }
}

/// Fours of planes of a shaft at the most; what a shaft has more of is passed over.
const FOURS: usize = 4;

/// Four planes side by side, with the absolute values of their normals.
#[derive(Clone, Copy, Debug)]
struct Four {
    normals: [Vec4; 3],
    sizes: [Vec4; 3],
    d: Vec4,
}

/// A shaft: planes in f32, tested four at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaft {
    fours: [Four; FOURS],
    len: usize,
}

impl Shaft {
    /// Keeps as many of the planes as fit.
    pub(super) fn new(planes: &HalfSpaces) -> Self {
        // A plane that everything is ahead of.
        let none = Four { normals: [Vec4::ZERO; 3], sizes: [Vec4::ZERO; 3], d: Vec4::MIN };
        let mut shaft =
            Self { fours: [none; FOURS], len: planes.all().len().div_ceil(4).min(FOURS) };
        for (k, plane) in planes.all().iter().take(FOURS * 4).enumerate() {
            let four = &mut shaft.fours[k / 4];
            for (axis, &n) in plane.normal.as_vec3().as_ref().iter().enumerate() {
                four.normals[axis][k % 4] = n;
                four.sizes[axis][k % 4] = n.abs();
            }
            four.d[k % 4] = plane.d as f32;
        }
        shaft
    }

    /// Whether a box reaches into all of the half-spaces.
    #[inline]
    pub(super) fn meets(&self, b: &Bounds, thin: f32) -> bool {
        let (c, h) = (b.centre.to_array().map(Vec4::splat), b.half.to_array().map(Vec4::splat));
        let thin = Vec4::splat(thin);
        self.fours[..self.len].iter().all(|four| {
            let [x, y, z] = &four.normals;
            let [sx, sy, sz] = &four.sizes;
            let middle = *x * c[0] + *y * c[1] + *z * c[2];
            let reach = *sx * h[0] + *sy * h[1] + *sz * h[2];
            !(middle + reach - four.d).cmple(thin).any()
        })
    }
}

/// Reused memory of floods.
#[derive(Debug, Default)]
pub(super) struct FloodScratch {
    stamps: Vec<u32>,
    stamp: u32,
    stack: Vec<u32>,
}

impl FloodScratch {
    pub(super) fn new(cells: u32) -> Self {
        Self { stamps: vec![0; cells as usize], ..Self::default() }
    }
}

/// Input of a flood through a shaft.
#[derive(Clone, Copy, Debug)]
pub(super) struct FloodInput<'a> {
    pub(super) openings: &'a Openings,
    /// The cells that may be seen through each opening.
    pub(super) might: &'a BitRows,
    /// Cells that lie behind, and must be seen back through whatever is passed.
    pub(super) behind: [u32; 2],
    pub(super) shaft: &'a Shaft,
}

/// Writes to `reached` those of `wanted` that can be reached from a cell through a shaft, and
/// returns whether there are any.
pub(super) fn flood(
    input: &FloodInput<'_>,
    from: u32,
    wanted: &[u64],
    reached: &mut [u64],
    scratch: &mut FloodScratch,
) -> bool {
    let FloodInput { openings, might, behind, shaft } = *input;
    let thin = openings.tolerance32;
    reached.fill(0);
    scratch.stamp = scratch.stamp.wrapping_add(1);
    if scratch.stamp == 0 {
        scratch.stamps.fill(0);
        scratch.stamp = 1;
    }
    scratch.stamps[from as usize] = scratch.stamp;
    scratch.stack.clear();
    scratch.stack.push(from);
    let mut left = crate::rows::count(wanted);
    let all = left;
    while let Some(cell) = scratch.stack.pop() {
        for next in openings.leaving(cell) {
            let bounds = openings.bounds(next);
            let to = bounds.to;
            if scratch.stamps[to as usize] == scratch.stamp || !shaft.meets(bounds, thin) {
                continue;
            }
            let back = might.row(bounds.reverse);
            if !has(back, behind[0]) || !has(back, behind[1]) || !meet(might.row(next), wanted) {
                continue;
            }
            scratch.stamps[to as usize] = scratch.stamp;
            if has(wanted, to) {
                set(reached, to);
                left -= 1;
                // Nothing is left to be found out.
                if left == 0 {
                    return true;
                }
            }
            scratch.stack.push(to);
        }
    }
    left < all
}
