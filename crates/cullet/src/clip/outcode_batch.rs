//! Outcodes of many points: f32 where it is sure, f64 where it is not.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::outcode::ObjectRegion;
use super::region::bits;

/// Points at a time: enough for whole vectors at any level, and few enough that one doubtful point costs
/// little.
const BLOCK: usize = 64;

/// A plane in f32.
#[derive(Clone, Copy, Default)]
struct Narrow {
    n: [f32; 3],
    d: f32,
    /// f32 may be wrong within this of the plane: a part for each axis, to be multiplied with the largest
    /// absolute coordinate, and the rest.
    doubt_per: [f32; 3],
    doubt: f32,
    bit: u32,
}

/// What f32 may be off by, relative to the terms of n·p − d: each number of the plane is rounded once, each
/// product once, and each of three sums, 5 units of 6e-8 for the first term, more than the last; the margins are
/// themselves reckoned in f32, and those of the f64 test are smaller by far.
const PART: f64 = 16.0 * f32::EPSILON as f64;

impl Narrow {
    fn new(region: &ObjectRegion, number: usize) -> Self {
        let plane = region.plane(number);
        let doubt_per = plane.normal.abs() * PART + plane.error_per * 4.0;
        let doubt = plane.d.abs() * PART + plane.error * 4.0;
        // What is too small for f32 must not round to no doubt at all.
        let up = |v: f64| (v * (1.0 + PART)) as f32 + f32::MIN_POSITIVE;
        Self {
            n: plane.normal.to_array().map(|v| v as f32),
            d: plane.d as f32,
            doubt_per: doubt_per.to_array().map(up),
            doubt: up(doubt),
            bit: 1 << number,
        }
    }
}

impl ObjectRegion {
    /// The planes of `active` that each point is proved outside of, one word a point, in place of what
    /// `codes` held. A triangle may be rejected where the words of its corners share a bit.
    ///
    /// Sixty-four points at a time are tested in f32, with a margin in which f32 could be wrong; where a point is
    /// within it, its sixty-four are tested again as [`outcode`](Self::outcode) does, so that the answer is that one's
    /// at every level.
    pub fn outcodes_into(
        &self,
        level: Level,
        points: &[[f32; 3]],
        active: u32,
        codes: &mut Vec<u32>,
    ) {
        // Every word is overwritten.
        codes.resize(points.len(), 0);
        let active = active & self.present();
        let mut planes = [Narrow::default(); 32];
        let mut count = 0;
        for i in bits(active) {
            planes[count] = Narrow::new(self, i);
            count += 1;
        }
        let planes = &planes[..count];
        dispatch!(level, simd => blocks(simd, self, active, planes, points, codes));
    }
}

#[inline(always)]
fn blocks<S: Simd>(
    simd: S,
    region: &ObjectRegion,
    active: u32,
    planes: &[Narrow],
    points: &[[f32; 3]],
    codes: &mut [u32],
) {
    let (whole, rest) = points.as_chunks::<BLOCK>();
    let (blocks, rest_codes) = codes.as_chunks_mut::<BLOCK>();
    for (points, codes) in whole.iter().zip(blocks) {
        if !sure(simd, planes, points, codes) {
            slow(region, active, points, codes);
        }
    }
    slow(region, active, rest, rest_codes);
}

/// Writes the codes of a block; `false` where f32 cannot be sure of them.
#[inline(always)]
fn sure<S: Simd>(
    simd: S,
    planes: &[Narrow],
    points: &[[f32; 3]; BLOCK],
    codes: &mut [u32; BLOCK],
) -> bool {
    let lanes = S::f32s::LEN;
    let mut axes = [[0.0_f32; BLOCK]; 3];
    for (i, p) in points.iter().enumerate() {
        (axes[0][i], axes[1][i], axes[2][i]) = (p[0], p[1], p[2]);
    }
    let mut most = [0.0; 3];
    for (most, axis) in most.iter_mut().zip(&axes) {
        let mut largest = S::f32s::splat(simd, 0.0);
        for part in axis.chunks_exact(lanes) {
            largest = largest.max(S::f32s::from_slice(simd, part).abs());
        }
        *most = largest.as_slice().iter().fold(0.0, |a, &b| f32::max(a, b));
    }
    let mut margins = [0.0; 32];
    for (margin, p) in margins.iter_mut().zip(planes) {
        let [x, y, z] = [0, 1, 2].map(|i| p.doubt_per[i] * most[i]);
        *margin = x + y + z + p.doubt;
    }
    let mut certain = S::mask32s::splat(simd, true);
    for (at, codes) in (0..BLOCK).step_by(lanes).zip(codes.chunks_exact_mut(lanes)) {
        let load = |axis: &[f32; BLOCK]| S::f32s::from_slice(simd, &axis[at..at + lanes]);
        let (x, y, z) = (load(&axes[0]), load(&axes[1]), load(&axes[2]));
        let mut code = S::u32s::splat(simd, 0);
        for (p, &margin) in planes.iter().zip(&margins) {
            // Fused or not, as the level has it: within the margin either way.
            let splat = |v| S::f32s::splat(simd, v);
            let height = x.mul_add(
                splat(p.n[0]),
                y.mul_add(splat(p.n[1]), z.mul_add(splat(p.n[2]), splat(-p.d))),
            );
            let bit = S::u32s::splat(simd, p.bit);
            code |= height.simd_gt(0.0).select(bit, S::u32s::splat(simd, 0));
            // False for a NaN.
            certain &= height.abs().simd_gt(margin);
        }
        code.store_slice(codes);
    }
    certain.all_true()
}

#[cold]
fn slow(region: &ObjectRegion, active: u32, points: &[[f32; 3]], codes: &mut [u32]) {
    codes.fill(0);
    // Plane by plane, so that its numbers stay in registers.
    for i in bits(active) {
        let plane = region.plane(i);
        for (code, p) in codes.iter_mut().zip(points) {
            *code |= u32::from(plane.is_outside(DVec3::from(p.map(f64::from)))) << i;
        }
    }
}
