//! Peaks of the distance between two surfaces: uphill from the farthest of random points.
//!
//! Where a thin place of a surface is far from the other, few random points lie in it, and none at
//! its top. Of a floor of a house, of 5,000 points none was farther than 0.82 of what 800,000
//! found. So from the farthest ones, each of another triangle, the top is looked for in steps that
//! become smaller, as far as the triangle reaches.

use std::collections::HashMap;

use cullet_draw::surface::SurfacePoint;
use cullet_draw::surface::SurfaceTree;

/// How many triangles are climbed at the most.
const CLIMBED: usize = 24;
/// A point is high from this share of the largest distance that is known on.
const HIGH: f32 = 0.6;
/// The first step, in shares of the triangle, and the last.
const STEPS: [f32; 2] = [0.25, 1.0 / 512.0];
/// The most points that are looked at on the way up.
const TRIES: usize = 240;

/// The high points of a surface: of each triangle the farthest.
#[derive(Debug, Default)]
pub(super) struct Peaks {
    highest: HashMap<u32, (f32, [f32; 3])>,
    /// Where something near was found the last time.
    last: u32,
}

impl Peaks {
    /// The distance of a point, where it is high beside one that is known; it is remembered then.
    pub(super) fn add(
        &mut self,
        tree: &SurfaceTree,
        from: SurfacePoint,
        known: f32,
    ) -> Option<f32> {
        let distance = tree.farther(from.point, known * HIGH, &mut self.last)?;
        let highest = self.highest.entry(from.triangle).or_insert((distance, from.point));
        if distance > highest.0 {
            *highest = (distance, from.point);
        }
        Some(distance)
    }

    /// Points at tops, each with its triangle; `corners` are those of a triangle. In the order of
    /// triangles that were the farthest.
    pub(super) fn climb(
        self,
        tree: &SurfaceTree,
        corners: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> Vec<SurfacePoint> {
        let mut all: Vec<(u32, (f32, [f32; 3]))> = self.highest.into_iter().collect();
        // By number where equal: a map has no order.
        all.sort_unstable_by(|a, b| b.1.0.total_cmp(&a.1.0).then(a.0.cmp(&b.0)));
        all.truncate(CLIMBED);
        all.into_iter()
            .map(|(triangle, (height, point))| {
                let point = top(tree, &corners(triangle), point, height);
                SurfacePoint { point, triangle }
            })
            .collect()
    }
}

/// The top that is reached from a point of a triangle with a distance from the other surface.
fn top(tree: &SurfaceTree, corners: &[[f32; 3]; 3], start: [f32; 3], mut height: f32) -> [f32; 3] {
    let mut best = start;
    let (mut step, mut last) = (STEPS[0], 0);
    let mut tries = 0;
    while step >= STEPS[1] && tries < TRIES && height.is_finite() {
        let mut moved = false;
        for corner in corners {
            // Towards a corner never leaves the triangle; away from it goes towards a point of the
            // side across.
            for towards in [*corner, across(corners, corner)] {
                let point = [0, 1, 2].map(|a| best[a] + (towards[a] - best[a]) * step);
                tries += 1;
                let farther = tree.farther(point, height, &mut last);
                if let Some(distance) = farther.filter(|d| *d > height) {
                    (best, height, moved) = (point, distance, true);
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    best
}

/// The middle of the side across from a corner.
fn across(corners: &[[f32; 3]; 3], corner: &[f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|a| (corners[0][a] + corners[1][a] + corners[2][a] - corner[a]) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A surface that lies below a square of two triangles, and has a narrow pit.
    #[test]
    fn the_top_is_found_from_its_slope() {
        // A roof over the square from 0 to 1: at height 0 along its borders, 1 at (0.3, 0.31).
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.31, -1.0]];
        let pit = [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4];
        let tree = SurfaceTree::new(&positions, &pit);
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let square = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
        let mut peaks = Peaks::default();
        let mut known = 0.0_f32;
        let starts = [([0.6, 0.2, 0.0], 0), ([0.8, 0.5, 0.0], 0), ([0.2, 0.6, 0.0], 1)];
        for (point, triangle) in starts {
            if let Some(far) = peaks.add(&tree, SurfacePoint { point, triangle }, known) {
                known = known.max(far);
            }
        }
        let far = |point| tree.nearest(point, f32::INFINITY).unwrap().0;
        let tops = peaks.climb(&tree, |t| square[t as usize]);
        assert_eq!(tops.len(), 2);
        let highest = tops.iter().map(|top| far(top.point)).fold(0.0, f32::max);
        // By ten thousand points in a grid.
        let grid = (0..10_000).map(|i| [(i % 100) as f32 / 99.0, (i / 100) as f32 / 99.0, 0.0]);
        let all = grid.map(far).fold(0.0, f32::max);
        assert!(highest > 0.95 * all && highest > 1.2 * known, "{highest} of {all}, from {known}");
        assert!(tops.iter().all(|top| top.point.iter().all(|v| (-1e-6..=1.000_001).contains(v))));
    }

    #[test]
    fn what_is_low_is_not_remembered() {
        let tree = SurfaceTree::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2]);
        let mut peaks = Peaks::default();
        let low = SurfacePoint { point: [0.1, 0.1, 0.5], triangle: 0 };
        assert_eq!(peaks.add(&tree, low, 1.0), None);
        assert_eq!(peaks.add(&tree, low, 0.5), Some(0.5));
        // Nothing there to be near to.
        let none = SurfaceTree::new(&[], &[]);
        assert_eq!(Peaks::default().add(&none, low, 0.0), Some(f32::INFINITY));
    }
}
