//! Boxes and spheres in batches: one stream per coordinate, made ready for the conservative tests of
//! [`cull::frustum`](crate::cull::frustum).
//!
//! What is stored is never tighter than what was given. Each coordinate is moved outward by eight
//! units in its last place (and a box with a NaN or infinite coordinate becomes [`Boxes::LIMIT`] in
//! every direction), because that is just what makes an f32 plane test conservative: the rounding
//! error of n·x is at most 3.1 u Σ|nᵢ||xᵢ| (u = 2⁻²⁴), rounding the plane's normal to f32 adds one u
//! more, and moving each xᵢ by 8u|xᵢ| away from the plane is worth 8u Σ|nᵢ||xᵢ|. So the tests need no
//! error term, and a stored box can give no NaN.

use super::{Aabb, Sphere};

/// A growable batch of axis-aligned boxes, as six streams.
#[derive(Clone, Debug, Default)]
pub struct Boxes {
    pub(crate) streams: [Vec<f32>; 6],
    len: usize,
}

/// Streams are padded to a multiple of this many entries, the widest vector there is.
pub(crate) const LANES: usize = 16;

impl Boxes {
    /// Coordinates beyond this size, or not finite, are stored as this size: such a box is kept by
    /// every frustum that reaches less far. Chosen so that no plane test can overflow.
    pub const LIMIT: f32 = 1e18;

    /// An empty batch.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A batch of the boxes of `boxes`, in their order.
    #[must_use]
    pub fn from_slice(boxes: &[Aabb]) -> Self {
        let mut batch = Self::new();
        batch.extend_from_slice(boxes);
        batch
    }

    /// How many boxes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all boxes, keeps the memory.
    pub fn clear(&mut self) {
        self.streams.iter_mut().for_each(Vec::clear);
        self.len = 0;
    }

    /// Appends boxes.
    pub fn extend_from_slice(&mut self, boxes: &[Aabb]) {
        let first = self.len;
        self.resize(first + boxes.len());
        for (i, b) in boxes.iter().enumerate() {
            self.set(first + i, b);
        }
    }

    /// Appends one box.
    pub fn push(&mut self, b: &Aabb) {
        self.resize(self.len + 1);
        self.set(self.len - 1, b);
    }

    /// Sets the number of boxes; new ones are points at the origin until they are set.
    pub fn resize(&mut self, len: usize) {
        let padded = len.next_multiple_of(LANES);
        for s in &mut self.streams {
            s.resize(padded, 0.0);
        }
        self.len = len;
    }

    /// Replaces box `index`. A box with a NaN coordinate becomes the whole of space; an empty box stays
    /// empty, which means that no answer about it matters to the caller.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, b: &Aabb) {
        assert!(index < self.len, "box {index} of a batch of {}", self.len);
        let nan = b.min.iter().chain(&b.max).any(|v| v.is_nan());
        let b = if nan { &Aabb::EVERYTHING } else { b };
        for axis in 0..3 {
            self.streams[axis][index] = widen(b.min[axis], -1.0);
            self.streams[axis + 3][index] = widen(b.max[axis], 1.0);
        }
    }

    /// Box `index` as it is stored, a little larger than it was given.
    #[must_use]
    pub fn get(&self, index: usize) -> Aabb {
        let at = |s: usize| self.streams[s][index];
        Aabb { min: [at(0), at(1), at(2)], max: [at(3), at(4), at(5)] }
    }

    /// The six streams, min x, y, z then max x, y, z, each of [`len`](Self::len) entries.
    #[must_use]
    pub fn streams(&self) -> [&[f32]; 6] {
        std::array::from_fn(|s| &self.streams[s][..self.len])
    }
}

/// 2^-20 = 16 u: 8 u for the tests and as much to cover the rounding of the widening itself.
const RELATIVE_STEP: f32 = 1.0 / (1 << 20) as f32;

/// Moves `v` by 8u|v| in the direction of `sign`, within ±[`Boxes::LIMIT`].
fn widen(v: f32, sign: f32) -> f32 {
    (v + sign * (v.abs() * RELATIVE_STEP + f32::MIN_POSITIVE)).clamp(-Boxes::LIMIT, Boxes::LIMIT)
}

/// A growable batch of spheres, as four streams.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    pub(crate) streams: [Vec<f32>; 4],
    len: usize,
}

impl Spheres {
    /// An empty batch.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A batch of the spheres of `spheres`, in their order.
    #[must_use]
    pub fn from_slice(spheres: &[Sphere]) -> Self {
        let mut batch = Self::new();
        batch.resize(spheres.len());
        for (i, s) in spheres.iter().enumerate() {
            batch.set(i, s);
        }
        batch
    }

    /// How many spheres there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no sphere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Sets the number of spheres; new ones are points at the origin until they are set.
    pub fn resize(&mut self, len: usize) {
        let padded = len.next_multiple_of(LANES);
        for s in &mut self.streams {
            s.resize(padded, 0.0);
        }
        self.len = len;
    }

    /// Replaces sphere `index`; one that is not finite becomes the whole of space. The radius grows by
    /// what the test may lose to rounding: 16 u of the centre's distance and of the radius itself.
    ///
    /// # Panics
    /// If `index` is not below [`len`](Self::len).
    pub fn set(&mut self, index: usize, sphere: &Sphere) {
        assert!(index < self.len, "sphere {index} of a batch of {}", self.len);
        let finite = sphere.center.iter().all(|v| v.is_finite() && v.abs() < Boxes::LIMIT)
            && sphere.radius.is_finite();
        let (center, radius) =
            if finite { (sphere.center, sphere.radius) } else { ([0.0; 3], Boxes::LIMIT) };
        let reach = center.iter().map(|v| v.abs()).sum::<f32>();
        for axis in 0..3 {
            self.streams[axis][index] = center[axis];
        }
        self.streams[3][index] = widen(radius + reach * RELATIVE_STEP, 1.0);
    }

    /// Sphere `index` as it is stored, a little larger than it was given.
    #[must_use]
    pub fn get(&self, index: usize) -> Sphere {
        let at = |s: usize| self.streams[s][index];
        Sphere { center: [at(0), at(1), at(2)], radius: at(3) }
    }
}
