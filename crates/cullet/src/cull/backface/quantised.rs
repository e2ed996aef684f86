//! Triangle planes quantised to 8 and 16 bits, for back-face tests in bulk.
//!
//! A triangle is back-facing where n·e − d·w < 0 for its plane n·x = d and the homogeneous eye (e, w):
//! the product of (n, −d) and (e, w). Quantised, a plane is scaled so that the largest of its four
//! numbers is 127 (or 32767) and rounded, the eye so that its largest is 8191. The product of the
//! rounded numbers is off by at most half a unit of every factor times its partner (in eight bits, by what
//! the planes of the mesh lost at most); a triangle is
//! culled only where the product is below minus that bound, so what is in doubt is kept.
//!
//! Eight bits are four bytes a triangle, and want an 8-bit dot product (AVX-512 VNNI). Sixteen bits are
//! eight bytes, and want no more than the 16-bit multiply-add that every x86-64 has.

use fearless_simd::{Level, Simd, dispatch, i16x8, i16x16, i32x4, i32x8, prelude::*, u8x16, u16x8};
use glam::{DVec3, DVec4};

use super::Facing;
use super::bulk::{self, Culled};
use crate::cull::Indices;

/// The largest number of a quantised eye: 14 bits and a sign, so that four products with 16-bit
/// planes fit into 32 bits.
const EYE_LIMIT: f64 = 8191.0;
/// A triangle whose area is below this share of the product of its edges gets a plane of zeros, which
/// no eye is behind: the rounding of its cross product, at most 4 × 2⁻⁵³ of that product, would turn
/// its normal by more than 4.5e-7.
const SLIVER: f64 = 1e-9;

/// Where the numbers of a set of planes are relative to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) centre: DVec3,
    /// What offsets are divided by, so that they are comparable to normals.
    pub(super) scale: f64,
}

impl Frame {
    pub(super) fn around(positions: &[[f32; 3]]) -> Self {
        let b = crate::bounds::Aabb::from_points(positions);
        if b.is_empty() {
            return Self { centre: DVec3::ZERO, scale: 1.0 };
        }
        let scale = DVec3::from(b.half_extent()).length();
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        Self { centre: b.center().into(), scale }
    }

    /// (n, −d) of a triangle with its largest number ±1; zeros for a sliver.
    pub(super) fn plane(&self, corners: [[f32; 3]; 3]) -> DVec4 {
        let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
        let (u, v) = (b - a, c - a);
        let n = u.cross(v);
        // Squares, and one scaling at the end: with roots, unit normals and calls of `round`, planes of a
        // deforming mesh took 120 ns each and not 40. Written so that NaN is a sliver.
        if n.length_squared() > u.length_squared() * v.length_squared() * (SLIVER * SLIVER) {
            let plane = n.extend(-n.dot(a - self.centre) / self.scale);
            plane * plane.abs().max_element().recip()
        } else {
            DVec4::ZERO
        }
    }

    /// The eye in units of the frame, its largest number ±[`EYE_LIMIT`]; `None` where it is not finite.
    fn eye(&self, eye: [f64; 4]) -> Option<[i32; 4]> {
        let e = self.relative(eye)?;
        Some((e * EYE_LIMIT).to_array().map(|v| v.round() as i32))
    }

    /// The eye in units of the frame, its largest number ±1; `None` where it is not finite, zero, or of
    /// negative weight.
    pub(super) fn relative(&self, eye: [f64; 4]) -> Option<DVec4> {
        let eye = DVec4::from(eye);
        let e = (eye.truncate() - self.centre * eye.w).extend(eye.w * self.scale);
        let largest = e.abs().max_element();
        // The largest of some NaN and a number may be the number.
        (eye.w >= 0.0 && largest > 0.0 && e.is_finite()).then(|| e / largest)
    }
}

/// How far the product of a quantised plane and eye may be from the true one.
fn error_bound(eye: [i32; 4], plane_limit: i32) -> i32 {
    let eye_sum: i32 = eye.iter().map(|v| v.abs()).sum();
    // Half of each factor's partner, and the product of the halves.
    (eye_sum + 4 * plane_limit) / 2 + slack(plane_limit) as i32
}

/// What a plane lost before it was quantised, in f64: a thin triangle's normal is off by less than
/// 4.5e-7 (see SLIVER), times 4 products of up to `plane_limit` × 8191.
fn slack(plane_limit: i32) -> f64 {
    f64::from(4 + plane_limit / 64)
}

/// Planes of a mesh's triangles in four bytes each.
#[derive(Clone, Debug)]
pub struct Planes8 {
    frame: Frame,
    /// Each number plus 128: the dot product takes unsigned by signed bytes.
    bytes: Vec<[u8; 4]>,
    len: usize,
    /// By how much each of the four numbers was rounded, at most: half, and nothing where all normals
    /// lie along an axis, as those of boxes do. Seen from afar near their horizon, those of a city would
    /// be kept for the half alone.
    rounded: DVec4,
}

/// An eye made ready for the [`Planes8`] of one mesh; see [`Planes8::eye`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneEye {
    eye: [i32; 4],
    /// What a product must be below the negative of.
    bound: i32,
}

impl PlaneEye {
    /// The eye for the other side of the triangles: what it culls, this one can never.
    #[must_use]
    pub(crate) fn turned(self) -> Self {
        Self { eye: self.eye.map(|v| -v), ..self }
    }
}

/// Planes of a mesh's triangles in eight bytes each.
#[derive(Clone, Debug)]
pub struct Planes16 {
    frame: Frame,
    /// (nx, ny) and (nz, −d), so that a multiply-add of pairs yields a triangle a lane.
    xy: Vec<[i16; 2]>,
    zd: Vec<[i16; 2]>,
    len: usize,
}

/// Triangles are padded to whole words of 64 with planes of zeros.
const PAD: usize = 64;

impl Planes8 {
    /// The planes of a triangle list, counter-clockwise fronts.
    ///
    /// # Panics
    /// If an index is not below the number of positions.
    #[must_use]
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let mut planes = Self::unset(positions, indices.len() / 3);
        planes.update(positions, indices, 0..indices.len() / 3);
        planes
    }

    /// Room for `len` triangles of a mesh with these positions, none of which is culled until it is
    /// [set](Self::set).
    #[must_use]
    pub(crate) fn unset(positions: &[[f32; 3]], len: usize) -> Self {
        let frame = Frame::around(positions);
        let bytes = vec![[128; 4]; len.next_multiple_of(PAD)];
        Self { frame, bytes, len, rounded: DVec4::ZERO }
    }

    /// Replaces the plane of triangle `index`, as a deforming mesh does. Right wherever the corners
    /// are; finest within the box of the positions that the set was made of.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, corners: [[f32; 3]; 3]) {
        assert!(index < self.len, "triangle {index} of {}", self.len);
        let p = self.frame.plane(corners) * 127.0;
        // To the nearest: a cast rounds down, in one instruction where `round` is a call.
        let bytes = p.to_array().map(|v| (v + 128.5) as u8);
        let stored = DVec4::from(bytes.map(f64::from)) - 128.0;
        self.rounded = self.rounded.max((p - stored).abs());
        self.bytes[index] = bytes;
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The numbers of plane `index`, unbiased.
    fn get(&self, index: usize) -> [i32; 4] {
        self.bytes[index].map(|v| i32::from(v) - 128)
    }

    /// Sets bit i of `culled` where triangle i is proved back-facing from the homogeneous `eye`, given
    /// in the space of the mesh (as [`ObjectEye`](super::ObjectEye) has it); bits beyond the last
    /// triangle are 0. An eye that is not finite, or of negative weight, culls nothing. The same at every
    /// level.
    pub fn cull(&self, level: Level, eye: [f64; 4], culled: &mut Vec<u64>) {
        bulk::cull(&self.seen(eye), level, culled);
    }

    /// How many triangles [`cull`](Self::cull) culls.
    #[must_use]
    pub fn count(&self, level: Level, eye: [f64; 4]) -> u64 {
        bulk::count(&self.seen(eye), level)
    }

    /// Lists the triangles that are *not* culled, ascending.
    pub fn keep(&self, level: Level, eye: [f64; 4], kept: &mut Indices) {
        bulk::keep(&self.seen(eye), level, kept);
    }

    /// The eye as [`cull_words`](Self::cull_words) takes it, made once for a mesh and view. `None`, which
    /// culls nothing, as for [`cull`](Self::cull).
    ///
    /// `facing` is what the words are to say: which triangles are seen from their [`Facing::Back`], or
    /// from their [`Facing::Front`]; `Edge` has no eye. `doubt` is by how much more than this module's own
    /// rounding the eye and the planes may be off: a share of the eye's largest number in units of the
    /// mesh times that of a plane's. It is what a renderer's rounding of vertices amounts to; 0 takes
    /// eye and triangles as exact, and `None` is the answer where it is NaN or above 2⁻⁹.
    #[must_use]
    pub fn eye(&self, eye: [f64; 4], facing: Facing, doubt: f64) -> Option<PlaneEye> {
        let eye = self.frame.eye(eye)?;
        // Written so that NaN is too much.
        let extra = (0.0..=1.0 / 512.0).contains(&doubt).then_some(doubt * 127.0 * EYE_LIMIT)?;
        // As `error_bound`, with what the planes' numbers really lost.
        let eye_size = DVec4::from(eye.map(|v| f64::from(v.abs()) + 0.5));
        let lost = self.rounded.dot(eye_size) + 2.0 * 127.0 + slack(127) + extra;
        let bound = lost.ceil() as i32 + 1;
        // To see a triangle from the front is to see it from behind with every sign turned.
        match facing {
            Facing::Back => Some(PlaneEye { eye, bound }),
            Facing::Front => Some(PlaneEye { eye, bound }.turned()),
            Facing::Edge => None,
        }
    }

    /// Fills words `first..` of the mask of what is culled, as many as `culled` has: the answers of
    /// [`cull`](Self::cull) for a range of triangles. The same at every level.
    ///
    /// # Panics
    /// If the words reach beyond the last triangle's.
    pub fn cull_words(&self, level: Level, eye: &PlaneEye, first: usize, culled: &mut [u64]) {
        Seen { planes: self, eye: Some(*eye) }.fill(level, first, culled);
    }

    /// Lists, ascending, the triangles that are *not* culled among those of some words: triangles
    /// 64 · w to 64 · w + 63 where bit w of `words` is set. For clusters of 64 triangles of which only
    /// some want a test of each triangle. Bits beyond the last word are ignored. The same at every level.
    pub fn keep_in_words(&self, level: Level, eye: &PlaneEye, words: &[u64], kept: &mut Indices) {
        bulk::keep_in(&Seen { planes: self, eye: Some(*eye) }, level, words, kept);
    }

    fn seen(&self, eye: [f64; 4]) -> Seen<'_, Self, PlaneEye> {
        Seen { planes: self, eye: self.eye(eye, Facing::Back, 0.0) }
    }

    /// The oracle of [`cull`](Self::cull): one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, eye: [f64; 4]) -> Vec<u64> {
        let mut culled = vec![0; self.len.div_ceil(64)];
        if let Some(PlaneEye { eye, bound }) = self.eye(eye, Facing::Back, 0.0) {
            for i in 0..self.len {
                let p = self.get(i);
                let value: i32 = (0..4).map(|k| p[k] * eye[k]).sum();
                culled[i / 64] |= u64::from(value + bound < 0) << (i % 64);
            }
        }
        culled
    }
}

impl Planes16 {
    /// The planes of a triangle list, counter-clockwise fronts.
    ///
    /// # Panics
    /// If an index is not below the number of positions.
    #[must_use]
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let frame = Frame::around(positions);
        let len = indices.len() / 3;
        let zeros = vec![[0; 2]; len.next_multiple_of(PAD)];
        let mut planes = Self { frame, xy: zeros.clone(), zd: zeros, len };
        planes.update(positions, indices, 0..len);
        planes
    }

    /// Replaces the plane of triangle `index`; see [`Planes8::set`].
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, corners: [[f32; 3]; 3]) {
        assert!(index < self.len, "triangle {index} of {}", self.len);
        let p = self.frame.plane(corners) * 32767.0;
        // As in eight bits; the bias keeps what is cast positive.
        let [x, y, z, d] = p.to_array().map(|v| ((v + 32768.5) as i32 - 32768) as i16);
        self.xy[index] = [x, y];
        self.zd[index] = [z, d];
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The oracle of [`cull`](Self::cull): one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, eye: [f64; 4]) -> Vec<u64> {
        let mut culled = vec![0; self.len.div_ceil(64)];
        if let Some(eye) = self.frame.eye(eye) {
            let bound = error_bound(eye, 32767);
            for i in 0..self.len {
                let p = [self.xy[i][0], self.xy[i][1], self.zd[i][0], self.zd[i][1]];
                let value: i32 = (0..4).map(|k| i32::from(p[k]) * eye[k]).sum();
                culled[i / 64] |= u64::from(value + bound < 0) << (i % 64);
            }
        }
        culled
    }

    /// As [`Planes8::cull`].
    pub fn cull(&self, level: Level, eye: [f64; 4], culled: &mut Vec<u64>) {
        bulk::cull(&self.seen(eye), level, culled);
    }

    /// How many triangles [`cull`](Self::cull) culls.
    #[must_use]
    pub fn count(&self, level: Level, eye: [f64; 4]) -> u64 {
        bulk::count(&self.seen(eye), level)
    }

    /// Lists the triangles that are *not* culled, ascending.
    pub fn keep(&self, level: Level, eye: [f64; 4], kept: &mut Indices) {
        bulk::keep(&self.seen(eye), level, kept);
    }

    fn seen(&self, eye: [f64; 4]) -> Seen<'_, Self, [i32; 4]> {
        Seen { planes: self, eye: self.frame.eye(eye) }
    }
}

/// Planes and an eye, which culls nothing where it is none.
struct Seen<'a, P, E> {
    planes: &'a P,
    eye: Option<E>,
}

impl Culled for Seen<'_, Planes8, PlaneEye> {
    fn len(&self) -> usize {
        self.planes.len
    }

    fn fill(&self, level: Level, first: usize, out: &mut [u64]) {
        let Some(PlaneEye { eye, bound }) = self.eye else { return out.fill(0) };
        let bytes = &self.planes.bytes[first * 64..(first + out.len()) * 64];
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = level.as_avx512() {
            return cull8_avx512(avx512, bytes, eye, bound, out);
        }
        dispatch!(level, simd => cull8(simd, bytes, eye, bound, out));
    }
}

impl Culled for Seen<'_, Planes16, [i32; 4]> {
    fn len(&self) -> usize {
        self.planes.len
    }

    fn fill(&self, level: Level, first: usize, out: &mut [u64]) {
        let Some(eye) = self.eye else { return out.fill(0) };
        let range = first * 64..(first + out.len()) * 64;
        let (xy, zd) = (&self.planes.xy[range.clone()], &self.planes.zd[range]);
        dispatch!(level, simd => cull16(simd, xy, zd, eye, error_bound(eye, 32767), out));
    }
}

fearless_simd::kernel!(
    fn cull8_avx512(
        avx512: Avx512,
        planes: &[[u8; 4]],
        eye: [i32; 4],
        bound: i32,
        culled: &mut [u64],
    ) {
        use core::arch::x86_64::*;
        use fearless_simd::u8x64;
        // The eye as high·128 + low, each a signed byte; low in −64..64.
        let low = eye.map(|v| (v + 64).rem_euclid(128) - 64);
        let packed = |v: [i32; 4]| _mm512_set1_epi32(i32::from_le_bytes(v.map(|b| b as i8 as u8)));
        let high: [i32; 4] = std::array::from_fn(|k| (eye[k] - low[k]) / 128);
        let (eye_high, eye_low) = (packed(high), packed(low));
        // Planes are biased by 128, which adds 128 times the sum of the eye to every product. What is
        // a multiple of 128 goes in before the high half is shifted, the rest into the comparison.
        let start = bound - 128 * eye.iter().sum::<i32>();
        let limit = _mm512_set1_epi32(-start.rem_euclid(128));
        let start = _mm512_set1_epi32(start.div_euclid(128));
        for (planes, culled) in planes.as_chunks::<64>().0.iter().zip(culled) {
            let bytes: &[u8] = planes.as_flattened();
            *culled = 0;
            for quarter in 0..4 {
                let p: __m512i = u8x64::from_slice(avx512, &bytes[quarter * 64..][..64]).into();
                let high = _mm512_slli_epi32::<7>(_mm512_dpbusd_epi32(start, p, eye_high));
                let value = _mm512_dpbusd_epi32(high, p, eye_low);
                *culled |= u64::from(_mm512_cmplt_epi32_mask(value, limit)) << (quarter * 16);
            }
        }
    }
);

/// The 8-bit form without an 8-bit dot product: bytes are widened to pairs of 16 bits.
#[inline(always)]
fn cull8<S: Simd>(simd: S, planes: &[[u8; 4]], eye: [i32; 4], bound: i32, culled: &mut [u64]) {
    let e = eye.map(|v| v as i16);
    let eye = i16x8::simd_from(simd, [e[0], e[1], e[2], e[3], e[0], e[1], e[2], e[3]]);
    let bias = i16x8::splat(simd, 128);
    for (planes, culled) in planes.as_chunks::<64>().0.iter().zip(culled) {
        let bytes: &[u8] = planes.as_flattened();
        *culled = 0;
        for group in 0..16 {
            let p = u8x16::from_slice(simd, &bytes[group * 16..][..16]);
            let (a, b) = p.widen();
            let product = |v: u16x8<S>| {
                let v: i16x8<S> = v.bitcast();
                (v - bias).pairwise_dot_product(eye)
            };
            // Two halves a triangle, in neighbouring lanes.
            let (a, b) = (product(a), product(b));
            let value = a.unzip_low(b) + a.unzip_high(b) + i32x4::splat(simd, bound);
            *culled |= value.simd_lt(i32x4::splat(simd, 0)).to_bitmask() << (group * 4);
        }
    }
}

#[inline(always)]
fn cull16<S: Simd>(
    simd: S,
    xy: &[[i16; 2]],
    zd: &[[i16; 2]],
    eye: [i32; 4],
    bound: i32,
    culled: &mut [u64],
) {
    let [x, y, z, w] = eye.map(|v| v as i16);
    let pair =
        |a: i16, b: i16| i16x16::simd_from(simd, [a, b, a, b, a, b, a, b, a, b, a, b, a, b, a, b]);
    let (eye_xy, eye_zd) = (pair(x, y), pair(z, w));
    let bound = i32x8::splat(simd, bound);
    let words = xy.as_chunks::<64>().0.iter().zip(zd.as_chunks::<64>().0);
    for ((xy, zd), culled) in words.zip(culled) {
        let (xy, zd) = (xy.as_flattened(), zd.as_flattened());
        *culled = 0;
        for group in 0..8 {
            let load = |s: &[i16]| i16x16::from_slice(simd, &s[group * 16..][..16]);
            let value = load(xy).pairwise_dot_product(eye_xy)
                + load(zd).pairwise_dot_product(eye_zd)
                + bound;
            *culled |= value.simd_lt(i32x8::splat(simd, 0)).to_bitmask() << (group * 8);
        }
    }
}
