//! The pyramid: k planes through one apex.

use glam::DVec2;

use super::eye::dot;
use super::fit::ANGULAR_SLACK;
use super::{ApexFit, Bound, ClusterEye, ClusterPlanes};

/// The region {e : g·(e − apex) < 0 for each of K generators g}: 12 + 12 K bytes. Six planes come within
/// some points of the ideal; three or four are worse than a circular cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid<const K: usize> {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// The generators; their conic hull holds all normals of the cluster.
    pub generators: [[f32; 3]; K],
}

impl<const K: usize> Bound for Pyramid<K> {
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        const { assert!(K >= 4, "a parallelogram is not made a triangle by removing an edge") };
        let fit = ApexFit::new(planes).ok()?;
        let mut polygon = fit.hull.clone();
        let centre = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
        // The slack of the test in f32, as an angle: every corner moves away from the middle, and hulls
        // of no width become squares of it.
        let slack = ANGULAR_SLACK * 4.0 * polygon.iter().map(|p| p.length()).fold(1.0, f64::max);
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let grown: Vec<DVec2> = polygon
            .iter()
            .flat_map(|p| corners.map(|(x, y)| *p + DVec2::new(x, y) * slack))
            .collect();
        polygon = convex_hull(&grown);
        while polygon.len() > K {
            remove_cheapest_edge(&mut polygon)?;
        }
        // Fewer corners than K: the last one repeats.
        let last = polygon.last().copied().unwrap_or(centre);
        polygon.resize(K, last);
        let generators = std::array::from_fn(|i| fit.lift(polygon[i]).normalize().as_vec3().into());
        Some(Self { apex: fit.apex.as_vec3().into(), generators })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.from(self.apex);
        self.generators.iter().all(|g| dot(*g, w) < 0.0)
    }
}

/// The corners of the convex hull, counter-clockwise (Andrew, *Another efficient algorithm for convex
/// hulls in two dimensions*, 1979).
pub(super) fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    // total_cmp puts −0 before 0, which no product of differences would agree with: points between two
    // ends of one x were lost.
    let mut sorted: Vec<DVec2> = points.iter().map(|p| *p + DVec2::ZERO).collect();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<DVec2> = Vec::with_capacity(sorted.len() + 1);
    for pass in 0..2 {
        let base = hull.len();
        for i in 0..sorted.len() {
            let p = if pass == 0 { sorted[i] } else { sorted[sorted.len() - 1 - i] };
            while hull.len() >= base + 2 {
                let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

/// Replaces the edge whose removal adds least area by the corner in which its neighbours meet. `None`
/// where no two neighbours meet outside.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the two faces of an edge, whose normals' x were zeros of both signs, one was lost.
    #[test]
    fn zeros_of_both_signs_are_one() {
        let points = [[-0.0, 1.0], [0.0, -1.0], [0.0, 1.0], [-0.0, -1.0], [0.0, 1.5]];
        let hull = convex_hull(&points.map(DVec2::from));
        assert_eq!(hull, [DVec2::new(0.0, -1.0), DVec2::new(0.0, 1.5)]);
    }
}
