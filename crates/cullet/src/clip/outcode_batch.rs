//! Outcodes of many points: f32 where it is sure, f64 where it is not.

use fearless_simd::{Level, Simd, dispatch};
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

/// Writes the code of each point.
pub(super) fn fill(
    level: Level,
    region: &ObjectRegion,
    active: u32,
    points: &[[f32; 3]],
    codes: &mut [u32],
) {
    let mut planes = [Narrow::default(); 32];
    let mut count = 0;
    for i in bits(active) {
        planes[count] = Narrow::new(region, i);
        count += 1;
    }
    let planes = &planes[..count];
    dispatch!(level, simd => blocks(simd, region, active, planes, points, codes));
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
///
/// Plain loops over arrays of fixed length: compiled once for each level, they become vectors.
#[inline(always)]
fn sure<S: Simd>(
    _: S,
    planes: &[Narrow],
    points: &[[f32; 3]; BLOCK],
    codes: &mut [u32; BLOCK],
) -> bool {
    let (mut x, mut y, mut z) = ([0.0_f32; BLOCK], [0.0_f32; BLOCK], [0.0_f32; BLOCK]);
    for i in 0..BLOCK {
        [x[i], y[i], z[i]] = points[i];
    }
    let largest = |v: &[f32; BLOCK]| {
        let mut most = [0.0_f32; 16];
        for i in 0..BLOCK {
            let a = v[i].abs();
            most[i % 16] = if a > most[i % 16] { a } else { most[i % 16] };
        }
        most.into_iter().fold(0.0, f32::max)
    };
    let most = [largest(&x), largest(&y), largest(&z)];
    let mut doubtful = [0_u32; BLOCK];
    *codes = [0; BLOCK];
    for p in planes {
        let margin = p.doubt_per[0] * most[0]
            + p.doubt_per[1] * most[1]
            + p.doubt_per[2] * most[2]
            + p.doubt;
        for i in 0..BLOCK {
            let height = p.n[0] * x[i] + p.n[1] * y[i] + p.n[2] * z[i] - p.d;
            codes[i] |= if height > 0.0 { p.bit } else { 0 };
            // From its opposite, so that NaN is doubtful.
            doubtful[i] |= u32::from(!(height.abs() > margin));
        }
    }
    doubtful.iter().fold(0, |a, b| a | b) == 0
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
