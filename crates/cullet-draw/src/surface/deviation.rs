//! How far a simplified surface is from the original, both ways, found without anything that made
//! it.

use cullet_mesh::Topology;

use super::distance::SurfaceTree;
use super::quantile::LargestDistances;
use super::samples::surface_points;
use crate::sort;

/// The share of a surface that may be farther than the error that is stated: 0.1 %.
pub const SHARE_ABOVE: f64 = 0.001;

/// A surface that is measured: positions, and three indices a triangle.
pub type SurfaceSlices<'a> = (&'a [[f32; 3]], &'a [u32]);

/// Distances between an original and a simplified surface, in their units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The largest distance of all points: random ones and the corners of triangles, of either
    /// surface to the other. Infinite where just one of them is empty.
    pub max: f32,
    /// Bound that 99.9 % of the random points of the original, and of the simplified surface, stay
    /// within: the larger of both.
    pub p999: f32,
    /// How many points were measured.
    pub points: u64,
    /// Edges of one triangle once equal positions are welded: of the original, of the simplified
    /// surface.
    pub open_edges: [u32; 2],
}

/// Measures from `samples` points of each surface, evenly distributed by area, and from all corners
/// of its triangles. The same for the same `seed`, other than which what is measured must have used
/// for measurements of its own.
///
/// Some microsecond a point; memory for both surfaces' trees and for the points.
///
/// ```
/// use cullet_draw::surface::deviation;
///
/// // A roof, and the floor below it.
/// let roof = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, -1.0, 0.5]];
/// let floor = roof.map(|[x, y, _]| [x, y, 0.0]);
/// let triangles = [0, 1, 2, 1, 0, 3];
/// let found = deviation((&roof, &triangles), (&floor, &triangles), 10_000, 1);
/// assert_eq!((found.max, found.open_edges), (0.5, [4, 4]));
/// assert!(found.p999 < 0.5);
/// ```
#[must_use]
pub fn deviation(
    original: SurfaceSlices<'_>,
    simplified: SurfaceSlices<'_>,
    samples: usize,
    seed: u64,
) -> Deviation {
    let there = one_way(original, simplified, samples, seed);
    let back = one_way(simplified, original, samples, seed.wrapping_add(1));
    Deviation {
        max: there.max.max(back.max),
        p999: there.p999.max(back.p999),
        points: there.points + back.points,
        open_edges: [original, simplified].map(|(p, i)| Topology::of(p, i).boundary_edges),
    }
}

struct OneWay {
    max: f32,
    p999: f32,
    points: u64,
}

fn one_way(from: SurfaceSlices<'_>, to: SurfaceSlices<'_>, samples: usize, seed: u64) -> OneWay {
    let tree = SurfaceTree::new(to.0, to.1);
    let mut last = 0;
    let points = surface_points(from.0, from.1, samples, seed);
    let mut largest = LargestDistances::new(points.len(), SHARE_ABOVE, 0.0);
    for p in &points {
        // Most are as near as others before them.
        if let Some(distance) = tree.farther(p.point, largest.quantile(), &mut last) {
            largest.push(distance);
        }
    }
    let p999 = largest.quantile();
    let mut max = largest.max();
    let mut corners = sort::sorted_by(from.1, |&v| v.into());
    corners.dedup();
    let mut measured = points.len() as u64;
    for &v in &corners {
        let Some(&point) = from.0.get(v as usize).filter(|p| p.iter().all(|v| v.is_finite()))
        else {
            continue;
        };
        measured += 1;
        max = tree.farther(point, max, &mut last).map_or(max, |distance| max.max(distance));
    }
    OneWay { max, p999, points: measured }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::nearest_ref;
    use cullet_testkit::soups;

    #[test]
    fn both_ways_count_and_so_do_the_few_points_that_are_far() {
        let (positions, indices) = soups::ball(12, 24);
        // A slice of an eighth is missing: nothing of the rest is off, but the original is.
        let open = &indices[66 * 3..];
        let whole = (&positions[..], &indices[..]);
        let found = deviation(whole, (&positions, open), 20_000, 5);
        assert_eq!(found.open_edges, [0, 24]);
        let reversed = deviation((&positions, open), whole, 20_000, 5);
        assert!((0.3..0.45).contains(&found.max), "{found:?}");
        assert!((found.max - reversed.max).abs() < 0.02, "{found:?}, {reversed:?}");
        assert!(found.p999 > 0.3 && found.p999 <= found.max);
        let same = deviation(whole, whole, 20_000, 5);
        assert!(same.max < 1e-6 && same.p999 <= same.max);
        assert_eq!(same.points, 2 * (20_000 + positions.len() as u64));
    }

    #[test]
    fn figures_are_those_of_a_slow_measurement() {
        let (positions, indices) = soups::bumpy_ball(10, 0.2);
        let (other, list) = soups::ball(7, 9);
        let found = deviation((&positions, &indices), (&other, &list), 1500, 5);
        let slow = |a: SurfaceSlices<'_>, b: SurfaceSlices<'_>, seed| {
            let points = surface_points(a.0, a.1, 1500, seed);
            let far = |p| nearest_ref(b.0, b.1, p).expect("not empty").0 as f32;
            let mut all: Vec<f32> = points.iter().map(|p| far(p.point)).collect();
            all.sort_unstable_by(f32::total_cmp);
            let corners = a.0.iter().map(|&p| far(p)).fold(0.0, f32::max);
            (all[1498], all[1499].max(corners))
        };
        let there = slow((&positions, &indices), (&other, &list), 5);
        let back = slow((&other, &list), (&positions, &indices), 6);
        assert!((found.p999 - there.0.max(back.0)).abs() < 1e-6);
        assert!((found.max - there.1.max(back.1)).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_infinitely_far_from_something() {
        let (positions, indices) = soups::ball(4, 8);
        let found = deviation((&positions, &indices), (&[], &[]), 100, 1);
        assert_eq!((found.max, found.p999), (f32::INFINITY, f32::INFINITY));
        let none = deviation((&[], &[]), (&[], &[]), 100, 1);
        assert_eq!((none.max, none.points), (0.0, 0));
    }
}
