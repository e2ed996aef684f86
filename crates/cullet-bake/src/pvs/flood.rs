//! Cells that could be reached, judged by whole portals: quick, and never too few.

use super::openings::{Openings, Plane32};
use super::polygon::HalfSpaces;
use super::rows::{BitRows, has, meet, set};

/// Cells that a line through an opening may reach: through portals that are not wholly behind it, and that it is not
/// wholly ahead of.
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

/// Planes of a shaft at the most.
const LANES: usize = 16;

/// A shaft: planes in f32, side by side for tests of many at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaft {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    d: [f32; LANES],
    len: usize,
}

impl Shaft {
    /// As many of the planes as fit.
    pub(super) fn new(planes: &HalfSpaces) -> Self {
        let mut shaft = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            z: [0.0; LANES],
            d: [f32::MIN; LANES],
            len: 0,
        };
        for (k, plane) in planes.all().iter().take(LANES).enumerate() {
            shaft.x[k] = plane.normal.x as f32;
            shaft.y[k] = plane.normal.y as f32;
            shaft.z[k] = plane.normal.z as f32;
            shaft.d[k] = plane.d as f32;
            shaft.len = (k + 4) / 4 * 4;
        }
        shaft
    }

    /// Whether a box reaches into all of the half-spaces.
    #[inline]
    pub(super) fn meets(&self, b: &super::openings::Bounds, thin: f32) -> bool {
        let ([cx, cy, cz], [hx, hy, hz]) = (b.centre.to_array(), b.half.to_array());
        let mut k = 0;
        while k < self.len {
            let mut least = [0.0; 4];
            for lane in 0..4 {
                let (x, y, z) = (self.x[k + lane], self.y[k + lane], self.z[k + lane]);
                least[lane] = x * cx + y * cy + z * cz + x.abs() * hx + y.abs() * hy + z.abs() * hz
                    - self.d[k + lane];
            }
            if least[0].min(least[1]).min(least[2].min(least[3])) <= thin {
                return false;
            }
            k += 4;
        }
        true
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

/// What a flood through a shaft goes by.
#[derive(Clone, Copy, Debug)]
pub(super) struct FloodInput<'a> {
    pub(super) openings: &'a Openings,
    /// The cells that may be seen through each opening.
    pub(super) might: &'a BitRows,
    /// Cells that lie behind, and must be seen back through whatever is passed.
    pub(super) behind: [u32; 2],
    pub(super) shaft: &'a Shaft,
}

/// Which of `wanted` can be reached from a cell through a shaft, written to `reached`; whether any.
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
    let mut left = super::rows::count(wanted);
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
