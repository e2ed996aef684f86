//! Nesting of the shells of a surface: it tells a cavity from a body wound inward.

use cullet::bounds::Aabb;
use cullet::exact::{area_sign, side_sign};

use crate::surface::Surface;

/// Boxes are looked at in groups of this many: a group that cannot hold a point is passed over.
const GROUP: usize = 64;

/// The triangles of each shell, and boxes to find the shells around a point.
pub(super) struct Nesting<'a> {
    surface: &'a Surface<'a>,
    /// Triangles by shell, and where each shell's end.
    triangles: Vec<u32>,
    end: Vec<u32>,
    boxes: Vec<Aabb>,
    groups: Vec<Aabb>,
}

impl<'a> Nesting<'a> {
    pub(super) fn new(surface: &'a Surface<'a>, shell_of: &[u32], shells: usize) -> Self {
        let mut end = vec![0u32; shells];
        let mut boxes = vec![Aabb::EMPTY; shells];
        for (t, &s) in shell_of.iter().enumerate() {
            end[s as usize] += 1;
            let b = &mut boxes[s as usize];
            *b = b.union(&Aabb::from_points(&surface.points(t)));
        }
        let mut total = 0;
        for e in &mut end {
            let count = *e;
            *e = total;
            total += count;
        }
        let mut triangles = vec![0u32; shell_of.len()];
        for (t, &s) in shell_of.iter().enumerate() {
            triangles[end[s as usize] as usize] = t as u32;
            end[s as usize] += 1;
        }
        let groups = boxes
            .chunks(GROUP)
            .map(|g| g.iter().fold(Aabb::EMPTY, |all, b| all.union(b)))
            .collect();
        Self { surface, triangles, end, boxes, groups }
    }

    fn triangles(&self, shell: u32) -> &[u32] {
        let start = shell.checked_sub(1).map_or(0, |s| self.end[s as usize]);
        &self.triangles[start as usize..self.end[shell as usize] as usize]
    }

    /// How often the other shells wind around the place of `shell`: 1 within one outward body, 0 in
    /// the open or in a cavity. Each shell counts as often as `weight` says: 0 leaves it out (it
    /// must where the shell is not closed), −1 turns it over.
    ///
    /// The place is judged at the six outermost vertices of the shell, and the lowest answer taken:
    /// a shell that only touches another from outside is not within it. Exact signs throughout.
    /// O(shells / 64 + triangles of the shells around it).
    pub(super) fn winding_around(&self, shell: u32, weight: impl Fn(u32) -> i32) -> i32 {
        let inner = &self.boxes[shell as usize];
        let around: Vec<(u32, i32)> = self
            .groups
            .iter()
            .enumerate()
            .filter(|(_, group)| holds(group, inner))
            .flat_map(|(g, _)| g * GROUP..((g + 1) * GROUP).min(self.boxes.len()))
            .filter(|&s| s != shell as usize && holds(&self.boxes[s], inner))
            .map(|s| (s as u32, weight(s as u32)))
            .filter(|&(_, weight)| weight != 0)
            .collect();
        let mut lowest = i32::MAX;
        for point in self.outermost(shell) {
            let winding = around.iter().map(|&(s, weight)| weight * self.winding(s, point)).sum();
            lowest = lowest.min(winding);
            if lowest < 1 {
                break;
            }
        }
        lowest
    }

    fn outermost(&self, shell: u32) -> [[f32; 3]; 6] {
        let first = self.triangles(shell).first().map(|&t| self.surface.points(t as usize)[0]);
        let mut found = [first.unwrap_or_default(); 6];
        for &t in self.triangles(shell) {
            for p in self.surface.points(t as usize) {
                for axis in 0..3 {
                    if p[axis] < found[axis][axis] {
                        found[axis] = p;
                    }
                    if p[axis] > found[axis + 3][axis] {
                        found[axis + 3] = p;
                    }
                }
            }
        }
        found
    }

    /// The winding number of a closed shell around a point: crossings of a ray along +x, counted
    /// with the sign of the side that is crossed. On the shell itself it is the number of one of
    /// its sides.
    fn winding(&self, shell: u32, point: [f32; 3]) -> i32 {
        let crossing = |&t: &u32| {
            let points = self.surface.points(t as usize);
            if points.iter().all(|p| p[0] < point[0]) {
                return 0;
            }
            let turns = turns_around(&points, point);
            // The triangle is ahead on the ray where the point is on its back (turns > 0).
            if turns != 0 && side_sign(&points, point) == -turns { turns } else { 0 }
        };
        self.triangles(shell).iter().map(crossing).sum()
    }
}

/// How often a triangle, seen along x, goes around the point: −1, 0 or 1. A point on an edge
/// belongs to one of the two triangles at it, whichever they are: an edge counts by the same
/// half-open rule from both its sides.
fn turns_around(points: &[[f32; 3]; 3], point: [f32; 3]) -> i32 {
    let mut turns = 0;
    for i in 0..3 {
        let (p, q) = (points[i], points[(i + 1) % 3]);
        let rises = p[2] <= point[2] && point[2] < q[2];
        let falls = q[2] <= point[2] && point[2] < p[2];
        if rises && area_sign(&[p, q, point], 0) > 0 {
            turns += 1;
        }
        if falls && area_sign(&[q, p, point], 0) > 0 {
            turns -= 1;
        }
    }
    turns
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.contains(inner.min) && outer.contains(inner.max)
}
