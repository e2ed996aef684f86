//! From where clusters are culled: sampled view points, and for each triangle the set of those that
//! see its back.
//!
//! The share of view points behind every triangle of a cluster estimates the probability that the
//! cluster is culled. Of two clusters together it is the intersection: an AND and a population
//! count.

use glam::DVec4;

use super::merge::Estimate;
use super::surface::{Frame, PartSurface};

/// A set of W × 64 view points.
pub(super) type Bits<const W: usize> = [u64; W];

/// How many are in a set.
pub(super) fn count<const W: usize>(bits: &Bits<W>) -> i64 {
    i64::from(bits.iter().map(|w| w.count_ones()).sum::<u32>())
}

/// The view points behind each triangle of a surface.
pub(super) struct Views<const W: usize> {
    pub(super) behind: Vec<Bits<W>>,
}

impl<const W: usize> Views<W> {
    /// For W × 64 view points. Some 0.1 µs a triangle for each 64 of them.
    pub(super) fn new(
        positions: &[[f32; 3]],
        surface: &PartSurface,
        frame: &Frame,
        points: &[DVec4],
    ) -> Self {
        // By coordinate, in f32: an estimate needs no more, and it fills the vector units.
        let axis = |k: usize| points.iter().map(|p| p[k] as f32).collect::<Vec<_>>();
        let [x, y, z, w] = [0, 1, 2, 3].map(axis);
        let behind = surface
            .corners
            .iter()
            .map(|c| {
                let (n, d) = frame.plane(c.map(|v| positions[v as usize]));
                let (n, d) = (n.as_vec3(), d as f32);
                std::array::from_fn(|word| {
                    let at = word * 64;
                    let mut value = [0.0f32; 64];
                    for i in 0..64 {
                        let j = at + i;
                        value[i] = n.x * x[j] + n.y * y[j] + n.z * z[j] - d * w[j];
                    }
                    // A triangle without area is behind nothing and in front of nothing: no
                    // hindrance.
                    value.iter().enumerate().fold(0, |b, (i, v)| b | u64::from(*v <= 0.0) << i)
                })
            })
            .collect();
        Self { behind }
    }

    /// For triangles that no view point is behind.
    pub(super) fn nowhere(triangles: usize) -> Self {
        Self { behind: vec![[0; W]; triangles] }
    }
}

impl<const W: usize> Estimate for Views<W> {
    type State = Bits<W>;

    fn unit(&self) -> i64 {
        W as i64 * 64
    }

    fn leaf(&self, triangle: u32) -> Bits<W> {
        self.behind[triangle as usize]
    }

    fn join(&self, a: &Bits<W>, b: &Bits<W>) -> Bits<W> {
        std::array::from_fn(|i| a[i] & b[i])
    }

    fn hits(&self, state: &Bits<W>) -> i64 {
        count(state)
    }
}
