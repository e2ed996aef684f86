//! Spatial order of triangles: compact groups of them, and the boxes of clusters.

use cullet::bounds::Aabb;

use super::merge::Limits;
use super::surface::PartSurface;

/// Halves triangles by the middle of their centres along the longest axis until each group is
/// within the limits; returns the group of each, and their number. O(n log n).
pub(super) fn split(surface: &PartSurface, limits: Limits) -> (Vec<u32>, usize) {
    let mut of = vec![0; surface.len()];
    let mut groups = 0;
    let mut all: Vec<([f64; 3], u32)> =
        surface.boxes.iter().zip(0..).map(|(b, t)| (b.center(), t)).collect();
    let mut vertices = Vec::new();
    // Groups still to be halved, as ranges.
    let mut open = Vec::new();
    open.push(0..all.len());
    while let Some(range) = open.pop() {
        let group = &mut all[range.clone()];
        vertices.clear();
        if group.len() <= limits.triangles {
            vertices.extend(group.iter().flat_map(|p| surface.corners[p.1 as usize]));
            vertices.sort_unstable();
            vertices.dedup();
            if vertices.len() <= limits.vertices {
                group.iter().for_each(|p| of[p.1 as usize] = groups);
                groups += u32::from(!group.is_empty());
                continue;
            }
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (c, _) in group.iter() {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(c[k]), high[k].max(c[k]));
            }
        }
        let side = [0, 1, 2].map(|k| high[k] - low[k]);
        let axis = (0..3).fold(0, |best, k| if side[k] > side[best] { k } else { best });
        let middle = group.len() / 2;
        group.select_nth_unstable_by(middle, |x, y| {
            x.0[axis].total_cmp(&y.0[axis]).then(x.1.cmp(&y.1))
        });
        open.extend([range.start + middle..range.end, range.start..range.start + middle]);
    }
    (of, groups as usize)
}

/// The box of each cluster.
pub(super) fn boxes(surface: &PartSurface, of: &[u32], clusters: usize) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::EMPTY; clusters];
    for (t, &c) in of.iter().enumerate() {
        boxes[c as usize] = boxes[c as usize].union(&surface.boxes[t]);
    }
    boxes
}
