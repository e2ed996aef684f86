//! Boxes of eyes, cut into cells that are looked at from one point each.

use cullet::bounds::{Aabb, Boxes, Plane};
#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use cullet::view::FrustumPlane;
use cullet::{View, view::Frustum};

/// All eyes in a box, in world space.
///
/// One point is a box, and so is a rectangle. Where some `min` exceeds its `max` there is no eye;
/// where a number is NaN or infinite, the eyes may be anywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EyeBox {
    /// The lowest corner.
    pub min: [f64; 3],
    /// The highest corner.
    pub max: [f64; 3],
}

impl EyeBox {
    /// The box between two corners, taken as they are.
    #[must_use]
    pub const fn new(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min, max }
    }

    /// Around some points, `radius` farther on every side: the way of an eye that may stray so far.
    /// No eye for no points; with a NaN among the numbers, eyes may be anywhere.
    #[must_use]
    pub fn around(points: &[[f64; 3]], radius: f64) -> Self {
        let mut b = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        for p in points {
            if p.iter().any(|v| v.is_nan()) {
                return Self { min: [f64::NAN; 3], max: [f64::NAN; 3] };
            }
            for a in 0..3 {
                (b.min[a], b.max[a]) = (b.min[a].min(p[a]), b.max[a].max(p[a]));
            }
        }
        Self { min: b.min.map(|v| v - radius), max: b.max.map(|v| v + radius) }
    }

    /// Whether there is no eye in it. One with a NaN is not empty: what it holds is not known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let has_nan = self.min.iter().chain(&self.max).any(|v| v.is_nan());
        !has_nan && (0..3).any(|a| self.min[a] > self.max[a])
    }

    /// Whether a point is in the box, its surface included.
    #[must_use]
    pub fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|a| self.min[a] <= point[a] && point[a] <= self.max[a])
    }
}

/// Eyes in a box around a point, relative to the origin of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    pub(super) center: [f64; 3],
    pub(super) half: [f64; 3],
}

impl Cell {
    /// How far a box is from it.
    pub(super) fn distance(&self, b: &Aabb) -> f64 {
        let gap = |a: usize| {
            let below = f64::from(b.min[a]) - (self.center[a] + self.half[a]);
            let above = (self.center[a] - self.half[a]) - f64::from(b.max[a]);
            below.max(above).max(0.0)
        };
        let [x, y, z] = [gap(0), gap(1), gap(2)];
        (x * x + y * y + z * z).sqrt()
    }

    /// The half-spaces of the box with `margin` around it.
    pub(super) fn grown(&self, margin: f64) -> Frustum {
        let mut planes = [None; 6];
        for (i, plane) in planes.iter_mut().enumerate() {
            let (axis, sign) = (i / 2, if i % 2 == 0 { 1.0 } else { -1.0 });
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            *plane = Some(Plane::new(normal, sign * self.center[axis] + self.half[axis] + margin));
        }
        Frustum::from_planes(planes)
    }
}

/// The cells of a box: all of one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    all: Cell,
    counts: [u32; 3],
}

impl Cells {
    /// Cells whose sides are at most `side` long, but no more than `most` of them: then they are
    /// longer. `None` for boxes that are not finite, or so large that no bounds reach.
    pub(super) fn new(eyes: &EyeBox, origin: [f64; 3], side: f64, most: u32) -> Option<Self> {
        let mut all = Cell { center: [0.0; 3], half: [0.0; 3] };
        for a in 0..3 {
            let [low, high] = [eyes.min[a], eyes.max[a]].map(|v| v - origin[a]);
            let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
            // Rounding of these lines. A single point stays one.
            let far = eyes.min[a].abs().max(eyes.max[a].abs()) + origin[a].abs();
            let slack = if half > 0.0 || far > 1e6 { far * 1e-15 } else { 0.0 };
            (all.center[a], all.half[a]) = (center, half + slack);
            let far = center.abs() + half;
            if far.is_nan() || far >= f64::from(Boxes::LIMIT) {
                return None;
            }
        }
        let counts = |side: f64| {
            // Slack of a point is no reason for a second cell.
            all.half.map(|h| ((2.0 * h / side * (1.0 - 1e-9)).ceil()).clamp(1.0, 1e6) as u32)
        };
        let number = |c: [u32; 3]| c.iter().map(|&c| f64::from(c)).product::<f64>();
        let (mut side, mut best) = (side, counts(side));
        while number(best) > f64::from(most.max(1)) {
            side *= 1.0625;
            best = counts(side);
        }
        Some(Self { all, counts: best })
    }

    /// All of them as one.
    pub(super) fn whole(&self) -> Cell {
        self.all
    }

    /// Half the sides of each.
    pub(super) fn half(&self) -> [f64; 3] {
        core::array::from_fn(|a| {
            // They overlap by more than their centres round.
            self.all.half[a] / f64::from(self.counts[a])
                + if self.counts[a] > 1 { self.all.center[a].abs() * 1e-15 } else { 0.0 }
        })
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Cell> + '_ {
        let [x, y, z] = self.counts;
        let half = self.half();
        (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k]))).map(
            move |place| {
                let center = core::array::from_fn(|a| {
                    let share = (2.0 * f64::from(place[a]) + 1.0) / f64::from(self.counts[a]);
                    self.all.center[a] + self.all.half[a] * (share - 1.0)
                });
                Cell { center, half }
            },
        )
    }
}

/// The frustum of a view about its eye, to be carried to the eyes of a cell.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    planes: [Option<Plane>; 6],
    /// No point of the near rectangle is farther from the eye; infinite where that is not known.
    pub(super) near: f64,
}

impl Carried {
    /// `None` where lines of sight are parallel.
    pub(super) fn new(view: &View) -> Option<Self> {
        let [x, y, z, w] = view.eye();
        if w == 0.0 {
            return None;
        }
        let eye = [x / w, y / w, z / w];
        let frustum = view.frustum();
        let planes = FrustumPlane::ALL.map(|which| {
            let plane = frustum.plane(which)?;
            let slack = eye.iter().map(|v| v.abs()).sum::<f64>() + plane.d.abs();
            let d = -plane.distance(eye) + slack * 2e-15;
            Some(Plane { normal: plane.normal, d })
        });
        let corners = frustum.corners();
        let near = corners.map_or(f64::INFINITY, |corners| {
            let distance =
                |c: &[f64; 4]| (0..3).map(|a| (c[a] / c[3] - eye[a]).powi(2)).sum::<f64>().sqrt();
            corners[..4].iter().map(distance).fold(0.0, f64::max) * (1.0 + 1e-9)
        });
        Some(Self { planes, near })
    }

    /// The half-spaces that hold the frusta of all eyes of a cell: each plane moved outward by the
    /// cell's extent along its normal.
    pub(super) fn to(&self, cell: &Cell) -> Frustum {
        Frustum::from_planes(self.planes.map(|plane| {
            let plane = plane?;
            let (mut d, mut size) = (plane.d, plane.d.abs());
            for a in 0..3 {
                let along = plane.normal[a] * cell.center[a];
                let extent = plane.normal[a].abs() * cell.half[a];
                d += along + extent;
                size += along.abs() + extent;
            }
            Some(Plane { d: d + size * 1e-15, ..plane })
        }))
    }
}
