//! Boxes to cull, and views that see so many of them.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Planes, count_boxes};
use cullet::{Camera, Projection, Simd, view::Frustum};

/// Half the side of the cube that the items lie in.
pub(super) const HALF: f32 = 1000.0;

/// Numbers in 0..1 (Marsaglia, *Xorshift RNGs*, 2003).
pub(super) struct Random(u64);

impl Random {
    pub(super) const fn new() -> Self {
        Self(0x1234_5678_9abc_def1)
    }

    pub(super) fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// A point of the cube that reaches as far as `half` from its middle.
    pub(super) fn point<const D: usize>(&mut self, half: f32) -> [f32; D] {
        std::array::from_fn(|_| (self.next() * 2.0 - 1.0) * half)
    }
}

/// How boxes lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// Anywhere in a cube.
    Random,
    /// In 200 heaps, dense in their middles, in shuffled order.
    Clustered,
}

impl Layout {
    pub(super) const ALL: [Self; 2] = [Self::Random, Self::Clustered];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Clustered => "clustered",
        }
    }

    /// So many boxes, with sides of up to 10.
    pub(super) fn boxes(self, len: usize) -> Vec<Aabb> {
        const HEAPS: usize = 200;
        let mut random = Random::new();
        let heaps: Vec<_> = match self {
            Self::Random => Vec::new(),
            Self::Clustered => (0..HEAPS).map(|_| random.point(HALF)).collect(),
        };
        let mut one = || {
            let min = if heaps.is_empty() {
                random.point(HALF)
            } else {
                let heap = heaps[(random.next() * HEAPS as f32) as usize];
                // The sum of four is nearly a bell, some 23 wide.
                heap.map(|v| v + 40.0 * ((0..4).map(|_| random.next()).sum::<f32>() - 2.0))
            };
            Aabb { min, max: min.map(|v| v + random.next() * 10.0) }
        };
        (0..len).map(|_| one()).collect()
    }
}

/// So many boxes anywhere, ready for batch tests.
pub(crate) fn random_boxes(len: usize) -> Boxes {
    Boxes::from_slice(&Layout::Random.boxes(len))
}

/// The camera `back` behind the middle of the cube, that looks there.
pub(super) fn camera(back: f64) -> Camera {
    let along = [0.6, -0.3, -0.742];
    let projection = Projection::Perspective {
        fov_y_radians: 1.0,
        aspect: 16.0 / 9.0,
        near: 0.1,
        far: 10.0 * f64::from(HALF),
    };
    Camera { eye: along.map(|v| -v * back), direction: along, up: [0.0, 1.0, 0.0], projection }
}

/// The planes of a camera.
pub(crate) fn planes_of(camera: &Camera) -> Planes {
    Planes::new(&frustum_of(camera))
}

/// The frustum of a camera.
pub(super) fn frustum_of(camera: &Camera) -> Frustum {
    camera.frustum().expect("a plain camera")
}

/// The camera that sees about `percent` of the items: it moves back from the far corner of their
/// cube until it does.
pub(super) fn camera_that_sees(
    percent: usize,
    mut count: impl FnMut(&Frustum) -> usize,
    len: usize,
) -> Camera {
    let half = f64::from(HALF);
    let (mut low, mut high) = (-2.0 * half, 6.0 * half);
    for _ in 0..24 {
        let middle = (low + high) / 2.0;
        if count(&frustum_of(&camera(middle))) * 100 < percent * len {
            low = middle;
        } else {
            high = middle;
        }
    }
    camera(high)
}

/// [`camera_that_sees`] for boxes.
pub(crate) fn camera_over(percent: usize, boxes: &Boxes) -> Camera {
    let count = |frustum: &Frustum| count_boxes(Simd::best(), &Planes::new(frustum), boxes);
    camera_that_sees(percent, count, boxes.len())
}

/// Like `1e5`.
pub(super) fn size_name(len: usize) -> String {
    let power = len.checked_ilog10().unwrap_or(0);
    match len / 10_usize.pow(power) {
        digit if digit * 10_usize.pow(power) == len => format!("{digit}e{power}"),
        _ => len.to_string(),
    }
}
