//! The probability of a cluster as the volume from which it is culled.
//!
//! Johannsen & Carter, *Clustered Backface Culling* (1998): of the normals of a cluster only their
//! box is kept, m' ≤ n ≤ m on each axis, and of the planes the least n·p. An eye at x from a local
//! origin c is behind all planes if the greatest value of n·x over the box, comb(m', m; x)·x, is at
//! most that least. In each octant around c this is one half-space, so the volume of the region
//! inside a box is a sum of eight boxes cut by a plane each.

use glam::DVec3;

use super::merge::Estimate;
use super::surface::{Frame, PartSurface};

/// The bound of a cluster, around the middle of its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Culling {
    /// The box of the normals.
    normals: [DVec3; 2],
    /// The box of the corners; its middle is the local origin.
    corners: [DVec3; 2],
    /// The least n·(p − c).
    least: f64,
}

impl Culling {
    fn of(n: DVec3, d: f64, corners: [DVec3; 3]) -> Self {
        let corners = [
            corners[0].min(corners[1]).min(corners[2]),
            corners[0].max(corners[1]).max(corners[2]),
        ];
        let middle = (corners[0] + corners[1]) * 0.5;
        Self { normals: [n, n], corners, least: d - n.dot(middle) }
    }

    fn middle(&self) -> DVec3 {
        (self.corners[0] + self.corners[1]) * 0.5
    }

    /// The least value about another origin: n·(p − c') = n·(p − c) − n·(c' − c), and the last is
    /// at most what the box of normals allows. To take the old value over would be wrong.
    fn least_about(&self, origin: DVec3) -> f64 {
        self.least - greatest(self.normals, origin - self.middle())
    }

    fn join(&self, other: &Self) -> Self {
        let unite = |a: [DVec3; 2], b: [DVec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let corners = unite(self.corners, other.corners);
        let middle = (corners[0] + corners[1]) * 0.5;
        Self {
            normals: unite(self.normals, other.normals),
            corners,
            least: self.least_about(middle).min(other.least_about(middle)),
        }
    }

    /// The share of a box from which the cluster is culled.
    fn share_of(&self, low: DVec3, high: DVec3) -> f64 {
        let size = high - low;
        let whole = size.x * size.y * size.z;
        if whole <= 0.0 {
            return 0.0;
        }
        let (low, high) = (low - self.middle(), high - self.middle());
        let mut volume = 0.0;
        for octant in 0..8 {
            // Distances from the origin along each axis, and what the farthest normal makes of one.
            let (mut from, mut to, mut weight) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
            for k in 0..3 {
                (from[k], to[k], weight[k]) = if octant >> k & 1 == 1 {
                    (low[k].max(0.0), high[k].max(0.0), self.normals[1][k])
                } else {
                    ((-high[k]).max(0.0), (-low[k]).max(0.0), -self.normals[0][k])
                };
            }
            let side = to - from;
            let block = side.x * side.y * side.z;
            if block > 0.0 {
                volume += block * share_below(weight * side, self.least - weight.dot(from));
            }
        }
        (volume / whole).clamp(0.0, 1.0)
    }
}

/// The greatest n·x over a box of normals.
fn greatest([low, high]: [DVec3; 2], x: DVec3) -> f64 {
    let pick = |k: usize| if x[k] > 0.0 { high[k] * x[k] } else { low[k] * x[k] };
    pick(0) + pick(1) + pick(2)
}

/// The share of the unit cube with slope·y ≤ level (Scardovelli & Zaleski, *Analytical Relations
/// Connecting Linear Interfaces and Volume Fractions in Rectangular Grids*, 2000).
fn share_below(slope: DVec3, level: f64) -> f64 {
    // Falling axes are turned round; then all rise.
    let level = level + slope.to_array().iter().map(|s| (-s).max(0.0)).sum::<f64>();
    let slope = slope.abs();
    let sum = slope.element_sum();
    if level <= 0.0 {
        return if sum == 0.0 && level == 0.0 { 1.0 } else { 0.0 };
    }
    if level >= sum {
        return 1.0;
    }
    let a = level / sum;
    if a > 0.5 {
        1.0 - share_below_half(slope / sum, 1.0 - a)
    } else {
        share_below_half(slope / sum, a)
    }
}

/// The same for slopes that are not negative, of sum 1, and a level of at most one half.
fn share_below_half(slope: DVec3, a: f64) -> f64 {
    let mut m = slope.to_array();
    m.sort_unstable_by(f64::total_cmp);
    // A flat axis would divide by zero; one that is nearly flat changes nothing that can be seen.
    let [m1, m2, m3] = m.map(|v| v.max(1e-6));
    let m12 = m1 + m2;
    let cubes = |with_third: f64| {
        (a * a * (3.0 * m12 - a) + m1 * m1 * (m1 - 3.0 * a) + m2 * m2 * (m2 - 3.0 * a) + with_third)
            / (6.0 * m1 * m2 * m3)
    };
    if a < m1 {
        a * a * a / (6.0 * m1 * m2 * m3)
    } else if a < m2 {
        a * (a - m1) / (2.0 * m2 * m3) + m1 * m1 / (6.0 * m2 * m3)
    } else if a < m12.min(m3) {
        cubes(0.0)
    } else if m12 <= m3 {
        (2.0 * a - m12) / (2.0 * m3)
    } else {
        // (a − m3)³, taken away.
        cubes(-(a - m3).powi(3))
    }
}

/// Against which box the volume is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Against {
    /// One box for all clusters.
    Fixed([DVec3; 2]),
    /// The box of the cluster, grown about its middle by so many of its diagonals on each side.
    Around(f64),
}

/// The bounds of single triangles.
pub(super) struct Volumes {
    pub(super) leaves: Vec<Culling>,
    pub(super) against: Against,
}

impl Volumes {
    pub(super) fn new(
        positions: &[[f32; 3]],
        surface: &PartSurface,
        frame: &Frame,
        against: Against,
    ) -> Self {
        let leaf = |c: &[u32; 3]| {
            let corners = c.map(|v| positions[v as usize]);
            let (n, d) = frame.plane(corners);
            Culling::of(n, d, corners.map(|p| frame.place(p)))
        };
        Self { leaves: surface.corners.iter().map(leaf).collect(), against }
    }
}

impl Estimate for Volumes {
    type State = Culling;

    fn unit(&self) -> i64 {
        1 << 24
    }

    fn leaf(&self, triangle: u32) -> Culling {
        self.leaves[triangle as usize]
    }

    fn join(&self, a: &Culling, b: &Culling) -> Culling {
        a.join(b)
    }

    fn hits(&self, state: &Culling) -> i64 {
        let share = match self.against {
            Against::Fixed([low, high]) => state.share_of(low, high),
            Against::Around(times) => {
                let [low, high] = state.corners;
                let margin = DVec3::splat((high - low).length() * times);
                state.share_of(low - margin, high + margin)
            }
        };
        (share * self.unit() as f64) as i64
    }
}

#[cfg(test)]
mod tests {
    use cullet_lab::methods::cluster::CullingRegion;
    use proptest::prelude::*;

    use super::*;

    /// Points of a grid in the unit cube.
    fn grid(n: u32) -> impl Iterator<Item = DVec3> {
        (0..n * n * n).map(move |i| {
            (DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) + 0.5)
                / f64::from(n)
        })
    }

    #[test]
    fn the_share_below_a_plane_is_that_of_a_grid() {
        let slopes = [
            [1.0, 2.0, 4.0],
            [-1.0, 2.0, -0.5],
            [1.0, 1.0, 1.0],
            [0.0, 0.0, 1.0],
            [0.0, -3.0, 2.0],
            [0.2, 0.3, 0.31],
        ];
        for slope in slopes.map(DVec3::from_array) {
            for step in -20..=40 {
                let level = f64::from(step) * 0.13;
                let counted = grid(40).filter(|y| slope.dot(*y) <= level).count() as f64 / 64e3;
                let computed = share_below(slope, level);
                assert!((counted - computed).abs() < 0.03, "{slope} {level}: {counted} {computed}");
            }
        }
        assert_eq!(share_below(DVec3::ZERO, 0.0), 1.0);
        assert_eq!(share_below(DVec3::ZERO, -0.1), 0.0);
    }

    #[test]
    fn a_joint_volume_is_within_what_both_cull() {
        let frame = |n: [f64; 3], p: [f64; 3]| {
            let (n, p) = (DVec3::from(n).normalize(), DVec3::from(p));
            let (u, v) = n.any_orthonormal_pair();
            let corners = [p, p + u * 0.1, p + v * 0.1];
            Culling::of(n, n.dot(p), corners)
        };
        let a = frame([0.1, 0.2, 1.0], [0.3, 0.1, 0.2]);
        let b = frame([-0.3, 0.1, 1.0], [-0.2, 0.4, 0.1]);
        let joint = a.join(&b);
        let (low, high) = (DVec3::splat(-2.0), DVec3::splat(2.0));
        let inside = |c: &Culling, x: DVec3| greatest(c.normals, x - c.middle()) <= c.least;
        let mut counted = 0;
        for y in grid(40) {
            let x = low + y * 4.0;
            if inside(&joint, x) {
                counted += 1;
                assert!(inside(&a, x) && inside(&b, x), "{x}");
            }
        }
        let share = joint.share_of(low, high);
        assert!(share > 0.2 && (share - f64::from(counted) / 64e3).abs() < 0.02, "{share}");
        let half = a.share_of(low, high);
        assert!(half > share && half < 0.6, "{half}");
    }

    /// The share as that of a polyhedron: the greatest n·x over a box of normals is that of one of
    /// its eight corners, so the region is where all eight half-spaces meet.
    fn share_ref(c: &Culling, low: DVec3, high: DVec3) -> f64 {
        let half_spaces = (0..8usize).map(|i| {
            let n: [f64; 3] = std::array::from_fn(|k| c.normals[i >> k & 1][k]);
            (n, c.least + DVec3::from(n).dot(c.middle()))
        });
        let region = CullingRegion::clip(half_spaces, low.into(), high.into());
        region.volume() / (high - low).to_array().iter().product::<f64>()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn the_share_is_that_of_the_polyhedron(
            planes in prop::collection::vec(
                (prop::array::uniform3(-1.0..1.0f64), prop::array::uniform3(-0.5..0.5f64)), 1..4),
            lean in 0.0..2.0f64,
            low in prop::array::uniform3(-3.0..-0.5f64),
            high in prop::array::uniform3(-0.4..3.0f64),
        ) {
            // Leaning one way, or few joint clusters would have a region.
            let leaf = |(n, p): &([f64; 3], [f64; 3])| {
                let n = (DVec3::from(*n) + DVec3::new(0.3, 1.0, -0.5) * lean).normalize_or(DVec3::Y);
                let (p, (u, v)) = (DVec3::from(*p), n.any_orthonormal_pair());
                Culling::of(n, n.dot(p), [p, p + u * 0.1, p + v * 0.1])
            };
            let joint = planes.iter().map(leaf).reduce(|a, b| a.join(&b));
            let joint = joint.expect("one plane at least");
            let (low, high) = (DVec3::from(low), DVec3::from(high));
            let (got, expected) = (joint.share_of(low, high), share_ref(&joint, low, high));
            prop_assert!((got - expected).abs() < 1e-5, "{got} {expected} {joint:?}");
        }
    }

    #[test]
    fn the_polyhedron_of_one_plane_is_half_the_box() {
        let n = DVec3::new(0.6, 0.0, 0.8);
        let c = Culling::of(n, 0.0, [DVec3::ZERO, DVec3::Y, -DVec3::Y]);
        let (low, high) = (DVec3::splat(-1.0), DVec3::splat(1.0));
        assert!((share_ref(&c, low, high) - 0.5).abs() < 1e-12);
        assert!((c.share_of(low, high) - 0.5).abs() < 1e-5);
    }
}
