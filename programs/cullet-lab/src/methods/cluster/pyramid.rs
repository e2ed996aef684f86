//! The pyramid: k planes through one apex.

use cullet::cull::backface::{ClusterEye, ClusterPlanes};
use fearless_simd::{Simd, prelude::*};
use glam::{DVec2, DVec3};

use super::lanes::{self, Lanes, Row, ZEROS};
use super::margin::margin;
use super::{ANGULAR_SLACK, Blocks, Bound, dot};

/// The region {e : g·(e − apex) < 0 for each of K generators g}: 12 + 12 K bytes. Six planes come
/// within some points of the ideal; three or four are worse than a circular cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid<const K: usize> {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// The generators; their conic hull holds all normals of the cluster.
    pub generators: [[f32; 3]; K],
}

impl<const K: usize> Bound for Pyramid<K> {
    type Batch = Blocks<Self>;

    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        const { assert!(K >= 4, "a parallelogram is not made a triangle by removing an edge") };
        let fit = planes.apex(0.0)?;
        // The slack of the test in f32, as an angle: every corner moves away from the middle, and
        // hulls of no width become squares of it.
        let farthest = fit.hull.iter().map(|p| DVec2::from(*p).length()).fold(1.0, f64::max);
        let wide = fit.widened(ANGULAR_SLACK * 4.0 * farthest);
        let mut polygon: Vec<DVec2> = wide.hull.iter().map(|p| DVec2::from(*p)).collect();
        while polygon.len() > K {
            remove_cheapest_edge(&mut polygon)?;
        }
        // Fewer corners than K: the last one repeats.
        let last = *polygon.last()?;
        polygon.resize(K, last);
        let generators = std::array::from_fn(|i| {
            DVec3::from(fit.lift(polygon[i].into())).normalize().as_vec3().into()
        });
        Some(Self { apex: DVec3::from(fit.point).as_vec3().into(), generators })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.way_from(self.apex);
        self.generators.iter().all(|g| dot(*g, w) < 0.0)
    }

    fn margin(&self, eye: [f64; 3]) -> f64 {
        let apex = DVec3::from(self.apex.map(f64::from));
        let w = DVec3::from(eye) - apex;
        let g = self.generators.map(|g| DVec3::from(g.map(f64::from)));
        let value = g.iter().map(|g| -g.dot(w)).fold(f64::INFINITY, f64::min);
        margin(value, 1.0 + 1e-6, 1.0, w.length(), apex)
    }
}

/// Sixteen pyramids.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct PyramidRows<const K: usize> {
    apex: [Row; 3],
    generators: [[Row; 3]; K],
}

impl<const K: usize> Lanes for Pyramid<K> {
    type Block = PyramidRows<K>;
    const NOTHING: PyramidRows<K> = PyramidRows { apex: ZEROS, generators: [ZEROS; K] };

    fn set_lane(&self, block: &mut PyramidRows<K>, lane: usize) {
        for k in 0..3 {
            block.apex[k][lane] = self.apex[k];
            for (rows, g) in block.generators.iter_mut().zip(self.generators) {
                rows[k][lane] = g[k];
            }
        }
    }

    #[inline(always)]
    fn test_lanes<S: Simd>(simd: S, block: &PyramidRows<K>, start: usize, eye: &ClusterEye) -> u64 {
        let w = lanes::to_eye(simd, &block.apex, start, eye);
        let zero = S::f32s::splat(simd, 0.0);
        let behind = |g: &[Row; 3]| lanes::dot::<S>(lanes::rows(simd, g, start), w).simd_lt(zero);
        let mut all = zero.simd_eq(zero);
        for g in &block.generators {
            all &= behind(g);
        }
        all.to_bitmask()
    }
}

/// Replaces the edge whose removal adds least area by the corner in which its neighbours meet.
/// `None` where no two neighbours meet outside.
fn remove_cheapest_edge(polygon: &mut Vec<DVec2>) -> Option<()> {
    let n = polygon.len();
    let corner = |i: usize| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| polygon[(i + k) % n]);
        // The edge b–c goes; a→b and d→c are drawn on until they meet.
        let (u, v) = (b - a, c - d);
        let turn = u.perp_dot(v);
        let along = (c - b).perp_dot(v) / turn;
        let meet = b + u * along;
        let area = (c - b).perp_dot(meet - b).abs();
        // The two turn towards each other by less than half a turn in all.
        (turn < -1e-12 * u.length() * v.length() && along >= 0.0).then_some((area, meet))
    };
    let (i, (_, meet)) =
        (0..n).filter_map(|i| Some((i, corner(i)?))).min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    polygon[(i + 1) % n] = meet;
    polygon.remove((i + 2) % n);
    Some(())
}
