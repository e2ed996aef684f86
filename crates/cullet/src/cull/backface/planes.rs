//! Triangle planes quantised to 8 bits, for back-face tests in bulk.
//!
//! A triangle is back-facing where n·e − d·w < 0 for its plane n·x = d and the homogeneous eye (e,
//! w): the product of (n, −d) and (e, w). Quantised, a plane is scaled so that the largest of its
//! four numbers is 127 and rounded, the eye so that its largest is 8191. The product of the rounded
//! numbers is off by at most what each factor lost times its partner; a triangle is culled only
//! where the product is below minus that bound, so what is in doubt is kept.
//!
//! With AVX-512 a product of bytes takes one instruction; at the other levels 16-bit multiply-adds
//! take two.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::simd::dispatch_256;
use fearless_simd::{Simd, i16x16, i32x8, prelude::*, u8x32, u16x16};
use glam::{DVec3, DVec4};

use super::Facing;

/// The largest number of a quantised eye: 14 bits and a sign, so that four products with 16-bit
/// planes fit into 32 bits.
const EYE_LIMIT: f64 = 8191.0;
/// A triangle whose area is below this share of the product of its edges gets a plane of zeros,
/// which no eye is behind: the rounding of its cross product, at most 4 × 2⁻⁵³ of that product,
/// would turn its normal by more than 4.5e-7.
const SLIVER: f64 = 1e-9;

/// Where the numbers of a set of planes are relative to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) centre: DVec3,
    /// Divisor of the offsets, so that they are comparable to normals.
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
        let [a, b, c] = corners.each(|p| DVec3::from(p.each(f64::from)));
        let (u, v) = (b - a, c - a);
        let n = u.cross(v);
        // Squares, and one scaling at the end: with roots, unit normals and calls of `round`,
        // planes of a deforming mesh took 120 ns each and not 40. Written so that NaN is a sliver.
        if n.length_squared() > u.length_squared() * v.length_squared() * (SLIVER * SLIVER) {
            let plane = n.extend(-n.dot(a - self.centre) / self.scale);
            plane * plane.abs().max_element().recip()
        } else {
            DVec4::ZERO
        }
    }

    /// The eye in units of the frame, its largest number ±[`EYE_LIMIT`]; `None` where it is not
    /// finite.
    fn eye(&self, eye: [f64; 4]) -> Option<[i32; 4]> {
        let e = self.relative(eye)?;
        Some((e * EYE_LIMIT).to_array().each(|v| v.round() as i32))
    }

    /// The eye in units of the frame, its largest number ±1; `None` where it is not finite, zero,
    /// or of negative weight.
    pub(super) fn relative(&self, eye: [f64; 4]) -> Option<DVec4> {
        let eye = DVec4::from(eye);
        let e = (eye.truncate() - self.centre * eye.w).extend(eye.w * self.scale);
        let largest = e.abs().max_element();
        // The largest of some NaN and a number may be the number.
        (eye.w >= 0.0 && largest > 0.0 && e.is_finite()).then(|| e / largest)
    }
}

/// Error of a plane before it was quantised, in f64: a thin triangle's normal is off by less than
/// 4.5e-7 (see SLIVER), times 4 products of up to 127 × 8191.
const SLACK: f64 = 5.0;

/// Planes of a mesh's triangles in four bytes each.
#[derive(Clone, Debug)]
pub struct Planes8 {
    frame: Frame,
    /// Each number plus 128: the dot product takes unsigned by signed bytes.
    bytes: Vec<[u8; 4]>,
    len: usize,
    /// Largest rounding of each of the four numbers, over all planes. It is at most one half. It is
    /// zero for the numbers of the normal where all normals lie along an axis, as those of boxes
    /// do. With one half for all meshes, triangles of a city seen from afar, near their horizon,
    /// would be kept for that half alone.
    rounded: DVec4,
}

/// An eye made ready for the [`Planes8`] of one mesh; see [`Planes8::eye`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneEye {
    eye: [i32; 4],
    /// Positive; products below its negative are culled.
    bound: i32,
}

impl PlaneEye {
    /// Returns the four numbers of the eye. A triangle is culled where their dot product with the
    /// numbers of its plane (its [bytes](Planes8::bytes) less 128) is below minus the
    /// [`bound`](Self::bound).
    #[must_use]
    pub fn numbers(&self) -> [i32; 4] {
        self.eye
    }

    /// Returns the most by which such a dot product may be off. It is positive.
    #[must_use]
    pub fn bound(&self) -> i32 {
        self.bound
    }

    /// The eye for the other side of the triangles: what it culls, this one can never.
    fn turned(self) -> Self {
        Self { eye: self.eye.each(|v| -v), ..self }
    }
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
        let bytes = p.to_array().each(|v| (v + 128.5) as u8);
        let stored = DVec4::from(bytes.each(f64::from)) - 128.0;
        self.rounded = self.rounded.max((p - stored).abs());
        self.bytes[index] = bytes;
    }

    /// Replaces the planes of the triangles of `range` by those of moved vertices; `positions` and
    /// `indices` are the whole mesh's. As [`set`](Self::set).
    ///
    /// # Panics
    /// If the range reaches beyond the planes or the indices, or an index beyond the positions.
    pub fn update(&mut self, positions: &[[f32; 3]], indices: &[u32], range: Range<usize>) {
        let triangles = &indices[range.start * 3..range.end * 3];
        for (i, t) in range.zip(triangles.as_chunks::<3>().0) {
            self.set(i, t.each(|v| positions[v as usize]));
        }
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

    /// The plane of each triangle, (n, −d) in units of the mesh with 128 added to each number; for
    /// tests elsewhere, as on a graphics device. All 128 is a plane that no eye is behind, and none
    /// of them is 0.
    #[must_use]
    pub fn bytes(&self) -> &[[u8; 4]] {
        &self.bytes[..self.len]
    }

    /// The largest number of a homogeneous eye in units of the mesh: what the `doubt` of
    /// [`eye`](Self::eye) is a share of. `None` where there is no eye.
    #[must_use]
    pub fn size_of_eye(&self, eye: [f64; 4]) -> Option<f64> {
        self.frame.relative(eye)?;
        let eye = DVec4::from(eye);
        let away = (eye.truncate() - self.frame.centre * eye.w).abs().max_element();
        Some(away.max(eye.w * self.frame.scale))
    }

    /// The homogeneous eye, in the space of the mesh (as [`ObjectEye`](super::ObjectEye) has it),
    /// made ready once for a mesh and view. `None`, for which nothing is culled, where it is not
    /// finite, zero, or of negative weight.
    ///
    /// `facing` is what the words are to say: which triangles are seen from their [`Facing::Back`],
    /// or from their [`Facing::Front`]; `Edge` has no eye. `doubt` is by how much more than this
    /// module's own rounding the eye and the planes may be off: a share of the eye's largest number
    /// in units of the mesh times that of a plane's. It is what a renderer's rounding of vertices
    /// amounts to; 0 takes eye and triangles as exact, and `None` is the answer where it is NaN or
    /// above 2⁻⁹.
    #[must_use]
    pub fn eye(&self, eye: [f64; 4], facing: Facing, doubt: f64) -> Option<PlaneEye> {
        let eye = self.frame.eye(eye)?;
        // Written so that NaN is too much.
        let extra = (0.0..=1.0 / 512.0).contains(&doubt).then_some(doubt * 127.0 * EYE_LIMIT)?;
        // Error of each factor times its partner, and the product of both.
        let eye_size = DVec4::from(eye.each(|v| f64::from(v.abs()) + 0.5));
        let lost = self.rounded.dot(eye_size) + 2.0 * 127.0 + SLACK + extra;
        let bound = lost.ceil() as i32 + 1;
        // To see a triangle from the front is to see it from behind with every sign turned.
        match facing {
            Facing::Back => Some(PlaneEye { eye, bound }),
            Facing::Front => Some(PlaneEye { eye, bound }.turned()),
            Facing::Edge => None,
        }
    }

    /// Fills words `first..` of the mask of culled triangles, as many as `culled` has: bit i of
    /// word w is set where triangle 64 · w + i is proved to be seen from behind (or from the side
    /// that the eye was made for); bits beyond the last triangle are 0. The same at every level.
    ///
    /// # Panics
    /// If the words reach beyond the last triangle's.
    pub fn cull_words(&self, simd: crate::Simd, eye: &PlaneEye, first: usize, culled: &mut [u64]) {
        self.test_words(simd, eye, first, culled, &mut []);
    }

    /// Fills `culled` like [`cull_words`](Self::cull_words), and fills `doubt` with the triangles
    /// that are neither culled nor proved to be kept. Those are nearly edge-on, or have no plane.
    /// `doubt` is as long as `culled`, or empty where it is not wanted.
    pub(crate) fn test_words(
        &self,
        simd: crate::Simd,
        &PlaneEye { eye, bound }: &PlaneEye,
        first: usize,
        culled: &mut [u64],
        doubt: &mut [u64],
    ) {
        let bytes = &self.bytes[first * 64..(first + culled.len()) * 64];
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = simd.0.as_avx512() {
            return test_avx512(avx512, bytes, eye, bound, culled, doubt);
        }
        if doubt.is_empty() {
            dispatch_256!(simd, simd => test::<_, false>(simd, bytes, eye, bound, culled, doubt));
        } else {
            dispatch_256!(simd, simd => test::<_, true>(simd, bytes, eye, bound, culled, doubt));
        }
    }

    /// The oracle of [`cull_words`](Self::cull_words): all words, one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, &PlaneEye { eye, bound }: &PlaneEye) -> Vec<u64> {
        let mut culled = vec![0; self.len.div_ceil(64)];
        for i in 0..self.len {
            let p = self.bytes[i].each(|v| i32::from(v) - 128);
            let value: i32 = (0..4).map(|k| p[k] * eye[k]).sum();
            culled[i / 64] |= u64::from(value + bound < 0) << (i % 64);
        }
        culled
    }
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    fn test_avx512(
        avx512: Avx512,
        planes: &[[u8; 4]],
        eye: [i32; 4],
        bound: i32,
        culled: &mut [u64],
        doubt: &mut [u64],
    ) {
        use crate::array;
        use core::arch::x86_64::*;
        use fearless_simd::u8x64;
        // The eye as high·128 + low, each a signed byte; low in −64..64.
        let low = eye.each(|v| (v + 64).rem_euclid(128) - 64);
        let packed = |v: [i32; 4]| _mm512_set1_epi32(i32::from_le_bytes(v.each(|b| b as i8 as u8)));
        let high: [i32; 4] = array::from_fn(|k| (eye[k] - low[k]) / 128);
        let (eye_high, eye_low) = (packed(high), packed(low));
        // Planes are biased by 128, which adds 128 times the sum of the eye to every product. What
        // is a multiple of 128 goes in before the high half is shifted, the rest into the
        // comparison.
        let start = bound - 128 * eye.iter().sum::<i32>();
        let rest = start.rem_euclid(128);
        let (below, above) = (_mm512_set1_epi32(-rest), _mm512_set1_epi32(2 * bound - rest));
        let start = _mm512_set1_epi32(start.div_euclid(128));
        for (i, (planes, culled)) in planes.as_chunks::<64>().0.iter().zip(culled).enumerate() {
            let bytes: &[u8] = planes.as_flattened();
            let values: [__m512i; 4] = array::from_fn(|quarter| {
                let p: __m512i = u8x64::from_slice(avx512, &bytes[quarter * 64..][..64]).into();
                let high = _mm512_slli_epi32::<7>(_mm512_dpbusd_epi32(start, p, eye_high));
                _mm512_dpbusd_epi32(high, p, eye_low)
            });
            *culled = 0;
            for (quarter, value) in values.into_iter().enumerate() {
                *culled |= u64::from(_mm512_cmplt_epi32_mask(value, below)) << (quarter * 16);
            }
            if let Some(doubt) = doubt.get_mut(i) {
                let mut front = 0;
                for (quarter, value) in values.into_iter().enumerate() {
                    front |= u64::from(_mm512_cmpgt_epi32_mask(value, above)) << (quarter * 16);
                }
                *doubt = !(*culled | front);
            }
        }
    }
);

/// The form without products of bytes. A plane is two lanes of 16 bits, (x, y) and (z, d): their
/// low bytes against the eye's x and z, their high bytes against y and w. (Bytes widened to a
/// register of their own took 2.5 times as long, products of bytes with the eye in two halves 1.5
/// times.)
#[inline(always)]
fn test<S: Simd, const DOUBT: bool>(
    simd: S,
    planes: &[[u8; 4]],
    eye: [i32; 4],
    bound: i32,
    culled: &mut [u64],
    doubt: &mut [u64],
) {
    let [x, y, z, w] = eye.each(|v| v as i16);
    let pairs = |a, b| i16x16::simd_from(simd, [a, b, a, b, a, b, a, b, a, b, a, b, a, b, a, b]);
    let (low, high) = (pairs(x, z), pairs(y, w));
    let low_byte = u16x16::splat(simd, 0xff);
    // Planes are biased by 128, which adds 128 times the sum of the eye to every product.
    let bias = 128 * eye.iter().sum::<i32>();
    let (below, above) = (i32x8::splat(simd, bias - bound), i32x8::splat(simd, bias + bound));
    for (i, (planes, culled)) in planes.as_chunks::<64>().0.iter().zip(culled).enumerate() {
        let bytes: &[u8] = planes.as_flattened();
        let (mut back, mut front) = (0, 0);
        for group in 0..8 {
            let p: u16x16<S> = u8x32::from_slice(simd, &bytes[group * 32..][..32]).bitcast();
            let (of_low, of_high): (i16x16<S>, i16x16<S>) =
                ((p & low_byte).bitcast(), (p >> 8).bitcast());
            let value = of_low.pairwise_dot_product(low) + of_high.pairwise_dot_product(high);
            back |= value.simd_lt(below).to_bitmask() << (group * 8);
            if DOUBT {
                front |= value.simd_gt(above).to_bitmask() << (group * 8);
            }
        }
        *culled = back;
        if DOUBT && let Some(doubt) = doubt.get_mut(i) {
            *doubt = !(back | front);
        }
    }
}
