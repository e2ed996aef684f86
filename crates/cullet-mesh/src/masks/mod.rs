//! Normal masks: two bytes a triangle, one AND to cull it.
//!
//! Zhang & Hoff, *Fast Backface Culling Using Normal Masks* (1997). The directions of space are cut
//! into 6·N² cells of a cube; a triangle carries the cell of its normal as one bit of 256 bytes.
//! Once a frame, the bits of all cells whose every normal is back-facing for every line of sight
//! are set; a triangle whose bit is set is back-facing.
//!
//! The paper calls its test of a cell by its four corners an approximation. It is exact: the
//! normals n that are back-facing for a cone of lines of sight with axis a and half-angle α, n·a ≥
//! sin α |n|, form a convex cone, and a cell is the positive hull of its corners.

mod cull;

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use cullet::Simd;
use cullet::bounds::Sphere;
use cullet::math;
use fearless_simd::{Level, dispatch, prelude::*};
use glam::{DVec3, DVec4};

/// The class of a normal: a byte of the [`BackfaceMask`] and a bit of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct NormalMask {
    /// The index of the byte in the [`BackfaceMask`].
    pub byte_offset: u8,
    /// The bit of that byte, as a mask. It is 0 for a triangle whose normal is not certain, which
    /// no mask culls.
    pub bit_mask: u8,
}

impl NormalMask {
    /// The class of triangles that no mask culls.
    pub const NEVER: Self = Self { byte_offset: u8::MAX, bit_mask: 0 };
}

/// The masks of many triangles, as two streams.
#[derive(Clone, Debug, Default)]
pub struct NormalMasks {
    byte_offset: Vec<u8>,
    bit_mask: Vec<u8>,
    len: usize,
}

impl NormalMasks {
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

    /// Sets the number of triangles; new ones are [`NormalMask::NEVER`] until they are set.
    pub fn resize(&mut self, len: usize) {
        // Padded to the widest vector of bytes; what is padded is never culled.
        let padded = len.next_multiple_of(64);
        for (stream, never) in [(&mut self.byte_offset, u8::MAX), (&mut self.bit_mask, 0)] {
            stream.truncate(len);
            stream.resize(padded, never);
        }
        self.len = len;
    }

    /// Replaces the mask of triangle `index`, as a deforming mesh does.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, mask: NormalMask) {
        assert!(index < self.len, "triangle {index} of {}", self.len);
        self.byte_offset[index] = mask.byte_offset;
        self.bit_mask[index] = mask.bit_mask;
    }

    /// The mask of triangle `index`.
    #[must_use]
    pub fn get(&self, index: usize) -> NormalMask {
        NormalMask { byte_offset: self.byte_offset[index], bit_mask: self.bit_mask[index] }
    }
}

/// Lines of sight within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewCone {
    /// The unit direction from the viewer to what is seen.
    pub axis: [f64; 3],
    /// The sine of the half-angle, in 0..1; 0 for parallel lines of sight.
    pub sine: f64,
}

impl ViewCone {
    /// Parallel lines of sight: an orthographic view. `None` for a direction of no length.
    #[must_use]
    pub fn parallel(direction: [f64; 3]) -> Option<Self> {
        Self::around(direction, 0.0)
    }

    /// Lines of sight within `half_angle` radians of `direction`; for a whole view, the angle to
    /// the *corner* of its frustum. `None` for a direction of no length, or an angle of π/2 or
    /// more.
    #[must_use]
    pub fn around(direction: [f64; 3], half_angle: f64) -> Option<Self> {
        let right = (0.0..std::f64::consts::FRAC_PI_2).contains(&half_angle);
        let axis = DVec3::from(direction).try_normalize().filter(|_| right)?;
        Some(Self { axis: axis.into(), sine: math::sin(half_angle) })
    }

    /// Lines of sight from a homogeneous eye (as [`View::eye`](cullet::View::eye), in the space of
    /// the sphere) to all points of a sphere. `None` where the eye is inside or on the sphere, its
    /// weight is negative, or something is not finite: then nothing may be culled. A sphere of
    /// radius 0 is a point, and a negative radius is no sphere.
    #[must_use]
    pub fn to_sphere(eye: [f64; 4], sphere: &Sphere) -> Option<Self> {
        let eye = DVec4::from(eye);
        // An infinite weight would put the eye at the origin.
        if !(eye.w >= 0.0 && eye.w.is_finite()) {
            return None;
        }
        if eye.w == 0.0 {
            return Self::parallel((-eye.truncate()).into());
        }
        let to = DVec3::from(sphere.center.map(f64::from)) - eye.truncate() / eye.w;
        let distance = to.length();
        let radius = f64::from(sphere.radius);
        // sin α = r/d: the tangent from the eye, not the angle at which the radius is seen.
        (radius >= 0.0 && distance > radius && distance.is_finite())
            .then(|| Self { axis: (to / distance).into(), sine: radius / distance })
    }
}

/// The bits of the classes that are back-facing in a view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BackfaceMask {
    bytes: [u8; 256],
}

impl BackfaceMask {
    /// Culls nothing: what holds where the eye is inside the sphere.
    pub const NOTHING: Self = Self { bytes: [0; 256] };

    /// Whether the triangles of this class are back-facing.
    #[must_use]
    pub fn culls(&self, mask: NormalMask) -> bool {
        self.bytes[mask.byte_offset as usize] & mask.bit_mask != 0
    }

    /// The 256 bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8; 256] {
        &self.bytes
    }

    /// The classes back-facing in both: for a triangle that lies in two sectors.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self { bytes: std::array::from_fn(|i| self.bytes[i] & other.bytes[i]) }
    }
}

/// The cells of a cube with N cells along an edge; made once, shared by all meshes and views.
#[derive(Clone, Debug)]
pub struct MaskGrid {
    n: u32,
    /// Unit normals of the (N+1)² corners of the cells of each face, padded to [`PAD`].
    corners: [Vec<f32>; 3],
}

/// Corners are padded to whole words of 64 bits.
const PAD: usize = 64;
/// How much more than sin α a corner must reach. It covers, in radians: the rounding of a corner to
/// f32 (1e-7), of its product with the axis (4e-7), and of a triangle's normal (see [`encode`]).
///
/// [`encode`]: MaskGrid::encode_triangle
const MARGIN: f32 = 2e-6;
/// A triangle whose area is smaller than this share of the product of its edges has a normal too
/// uncertain for a class: the rounding of its cross product, at most 4 × 2⁻⁵³ of that product,
/// would turn it by more than 5e-7.
const SLIVER: f64 = 1e-9;

impl MaskGrid {
    /// The largest N whose classes fit into 256 bytes less one.
    pub const MAX_CELLS: u32 = 18;

    /// A grid with `n` cells along an edge of the cube; `None` if `n` is not in 1..=18.
    #[must_use]
    pub fn new(n: u32) -> Option<Self> {
        if !(1..=Self::MAX_CELLS).contains(&n) {
            return None;
        }
        let mut corners: [Vec<f32>; 3] = Default::default();
        let along = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
        for face in 0..6 {
            for row in 0..=n {
                for column in 0..=n {
                    let normal = on_face(face, along(column), along(row)).normalize();
                    for axis in 0..3 {
                        corners[axis].push(normal[axis] as f32);
                    }
                }
            }
        }
        for stream in &mut corners {
            stream.resize(stream.len().next_multiple_of(PAD), 0.0);
        }
        Some(Self { n, corners })
    }

    /// Cells along an edge of the cube.
    #[must_use]
    pub fn cells(&self) -> u32 {
        self.n
    }

    /// Classes of normals: 6·N².
    #[must_use]
    pub fn classes(&self) -> u32 {
        6 * self.n * self.n
    }

    /// The class of a normal of any length; [`NormalMask::NEVER`] for one without a direction. The
    /// normal is taken as certain: see [`encode_triangle`](Self::encode_triangle) for one that is
    /// not.
    #[must_use]
    pub fn encode(&self, normal: [f64; 3]) -> NormalMask {
        let m = normal.map(f64::abs);
        let major = usize::from(m[1] > m[0]);
        let major = if m[2] > m[major] { 2 } else { major };
        if !(m[major] > 0.0 && normal.iter().all(|v| v.is_finite())) {
            return NormalMask::NEVER;
        }
        let face = major as u32 * 2 + u32::from(normal[major] < 0.0);
        let cell = |v: f64| {
            let t = (v / m[major] + 1.0) * 0.5 * f64::from(self.n);
            (t as u32).min(self.n - 1)
        };
        let (column, row) = (cell(normal[(major + 1) % 3]), cell(normal[(major + 2) % 3]));
        let class = (face * self.n + row) * self.n + column;
        NormalMask { byte_offset: (class / 8) as u8, bit_mask: 1 << (class % 8) }
    }

    /// The class of a triangle wound counter-clockwise; [`NormalMask::NEVER`] where it is a sliver
    /// so thin that rounding leaves its normal in doubt, has no area, or is not finite.
    #[must_use]
    pub fn encode_triangle(&self, corners: [[f32; 3]; 3]) -> NormalMask {
        let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        // Written so that NaN is a sliver.
        if normal.length_squared() > u.length_squared() * v.length_squared() * (SLIVER * SLIVER) {
            self.encode(normal.into())
        } else {
            NormalMask::NEVER
        }
    }

    /// The classes of a triangle list, in its order; `masks` is overwritten.
    ///
    /// # Panics
    /// If an index is not below the number of positions.
    pub fn encode_triangles(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        masks: &mut NormalMasks,
    ) {
        masks.resize(indices.len() / 3);
        self.update(positions, indices, 0..masks.len(), masks);
    }

    /// Replaces the masks of the triangles of `range` by those of moved vertices; `positions` and
    /// `indices` are the whole mesh's. Zhang & Hoff leave what deforms to others; but a triangle's
    /// mask depends on its own corners alone, so that those which moved can be replaced in place.
    ///
    /// # Panics
    /// If the range reaches beyond the masks or the indices, or an index beyond the positions.
    pub fn update(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<usize>,
        masks: &mut NormalMasks,
    ) {
        let triangles = &indices[range.start * 3..range.end * 3];
        for (i, t) in range.zip(triangles.as_chunks::<3>().0) {
            masks.set(i, self.encode_triangle(t.map(|v| positions[v as usize])));
        }
    }

    /// The mask of a cone of lines of sight; [`BackfaceMask::NOTHING`] for `None`.
    ///
    /// Conservative for every triangle all of whose points are seen along lines in the cone.
    #[must_use]
    pub fn mask(&self, simd: Simd, cone: Option<&ViewCone>) -> BackfaceMask {
        let Some(cone) = cone else { return BackfaceMask::NOTHING };
        let axis = cone.axis.map(|v| v as f32);
        // Rounded up, so that less is culled.
        let threshold = (cone.sine as f32).next_up() + MARGIN;
        let mut bits = [0; CORNER_WORDS];
        dispatch!(narrow(simd), simd => corner_bits(simd, &self.corners, axis, threshold, &mut bits));
        self.cells_of_corners(&bits)
    }

    /// A cell is back-facing where its four corners are.
    fn cells_of_corners(&self, bits: &[u64; CORNER_WORDS]) -> BackfaceMask {
        let n = self.n as usize;
        let row_bits = |row: usize| {
            let at = row * (n + 1);
            let (word, shift) = (at / 64, at % 64);
            // Two words at once, so that a row may straddle them.
            let pair = u128::from(bits[word]) | u128::from(bits[word + 1]) << 64;
            (pair >> shift) as u32
        };
        let mut mask = BackfaceMask::NOTHING;
        // Cells of all faces and rows follow each other: a queue of bits, emptied by the byte.
        let (mut queue, mut queued, mut byte) = (0u64, 0, 0);
        for face in 0..6 {
            let mut below = row_bits(face * (n + 1));
            below &= below >> 1;
            for row in 1..=n {
                let mut above = row_bits(face * (n + 1) + row);
                above &= above >> 1;
                let cells = u64::from(below & above) & ((1 << n) - 1);
                queue |= cells << queued;
                queued += n;
                while queued >= 8 {
                    mask.bytes[byte] = queue as u8;
                    (queue, queued, byte) = (queue >> 8, queued - 8, byte + 1);
                }
                below = above;
            }
        }
        if queued > 0 {
            mask.bytes[byte] = queue as u8;
        }
        mask
    }
}

/// Words for 6·19² corners, and one to read beyond the end.
const CORNER_WORDS: usize = (6 * 19 * 19usize).div_ceil(64) + 1;

/// Bit i: corner i reaches `threshold` along `axis`.
#[inline(always)]
fn corner_bits<S: fearless_simd::Simd>(
    simd: S,
    corners: &[Vec<f32>; 3],
    axis: [f32; 3],
    threshold: f32,
    bits: &mut [u64; CORNER_WORDS],
) {
    let [ax, ay, az] = axis.map(|v| fearless_simd::f32x16::splat(simd, v));
    let threshold = fearless_simd::f32x16::splat(simd, threshold);
    let [xs, ys, zs] = corners;
    let words = xs.chunks_exact(PAD).zip(ys.chunks_exact(PAD)).zip(zs.chunks_exact(PAD));
    for (word, ((x, y), z)) in bits.iter_mut().zip(words) {
        *word = 0;
        for i in 0..4 {
            let at = i * 16..i * 16 + 16;
            let load = |s: &[f32]| fearless_simd::f32x16::from_slice(simd, &s[at.clone()]);
            let along = load(x) * ax + load(y) * ay + load(z) * az;
            *word |= along.simd_gt(threshold).to_bitmask() << (i * 16);
        }
    }
}

/// Returns the level with vectors of 256 bits at the most: AVX2 also where the machine has AVX-512.
fn narrow(simd: Simd) -> Level {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = simd.level().as_avx2() {
        return Level::Avx2(avx2);
    }
    simd.level()
}

/// The point (u, v) of a face of the cube [-1, 1]³; faces are +x, −x, +y, −y, +z, −z.
fn on_face(face: u32, u: f64, v: f64) -> DVec3 {
    let major = face as usize / 2;
    let mut p = [0.0; 3];
    p[major] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    p[(major + 1) % 3] = u;
    p[(major + 2) % 3] = v;
    p.into()
}
