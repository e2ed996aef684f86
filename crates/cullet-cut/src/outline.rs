//! The section as filled outlines: the borders of the caps.

use cullet::bounds::Plane;
use glam::DVec3;

use crate::hash::{QuickMap, key};
use crate::result::{Cap, CutMesh};
use crate::sides;

/// A closed line around covered parts of a plane, or around a hole in them: counter-clockwise, seen
/// from where the plane's normal points, around what the surface winds around once. Filling all
/// outlines of a cap by the non-zero rule gives what it covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Its points in order; the last is joined to the first.
    pub points: Vec<[f32; 3]>,
}

/// Two directions along a plane and its normal, right-handed and of unit length: the second leans
/// towards +Y, or towards −Z where the plane is level. `None` where the plane is none.
#[must_use]
pub fn section_frame(plane: &Plane) -> Option<[[f64; 3]; 3]> {
    sides::prepare(&[*plane]).ok().map(|p| p[0].frame())
}

impl CutMesh {
    /// The outlines of a cap of this mesh. O(triangles of the cap).
    ///
    /// # Panics
    /// If the cap is of another mesh, with more triangles.
    #[must_use]
    pub fn outlines(&self, cap: &Cap) -> Vec<Outline> {
        let mut places: QuickMap<[u32; 3], u32> = QuickMap::default();
        let mut points = Vec::new();
        let mut net: QuickMap<[u32; 2], i32> = QuickMap::default();
        let mut order = Vec::new();
        for t in self.indices[cap.triangles.start * 3..cap.triangles.end * 3].chunks_exact(3) {
            let corner = |i: usize| self.positions[t[i % 3] as usize];
            let p: [u32; 3] = std::array::from_fn(|i| {
                *places.entry(key(corner(i))).or_insert_with(|| {
                    points.push(corner(i));
                    points.len() as u32 - 1
                })
            });
            for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
                let way = if a < b { 1 } else { -1 };
                let pair = [a.min(b), a.max(b)];
                *net.entry(pair).or_insert_with(|| {
                    order.push(pair);
                    0
                }) += way;
            }
        }
        let mut next: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        for pair in order {
            let n = net[&pair];
            let [a, b] = if n > 0 { pair } else { [pair[1], pair[0]] };
            (0..n.abs()).for_each(|_| next[a as usize].push(b));
        }
        let mut outlines = Vec::new();
        for start in 0..points.len() as u32 {
            while let Some(mut at) = next[start as usize].pop() {
                let mut line = vec![points[start as usize]];
                // As many edges leave a place as come to it, so the way ends where it began.
                while at != start {
                    line.push(points[at as usize]);
                    let Some(to) = next[at as usize].pop() else { break };
                    at = to;
                }
                outlines.push(Outline { points: line });
            }
        }
        outlines
    }

    /// The area of a cap, in squared units of the mesh: what is covered twice counts twice, and
    /// what is inside out counts negative.
    ///
    /// # Panics
    /// If the cap is of another mesh, with more triangles.
    #[must_use]
    pub fn cap_area(&self, cap: &Cap, plane: &Plane) -> f64 {
        let Some([_, _, n]) = section_frame(plane) else { return 0.0 };
        let triangles =
            self.indices[cap.triangles.start * 3..cap.triangles.end * 3].chunks_exact(3);
        let area = |t: &[u32]| {
            let at = |i: usize| DVec3::from(self.positions[t[i] as usize].map(f64::from));
            (at(1) - at(0)).cross(at(2) - at(0)).dot(DVec3::from(n)) * 0.5
        };
        triangles.map(area).sum()
    }
}

/// The area that an outline encloses, in squared units: negative around a hole.
#[must_use]
pub fn outline_area(outline: &Outline, plane: &Plane) -> f64 {
    let Some([u, v, _]) = section_frame(plane) else { return 0.0 };
    let Some(&first) = outline.points.first() else { return 0.0 };
    let first = DVec3::from(first.map(f64::from));
    let flat = |p: &[f32; 3]| {
        let p = DVec3::from(p.map(f64::from)) - first;
        [p.dot(DVec3::from(u)), p.dot(DVec3::from(v))]
    };
    let points: Vec<[f64; 2]> = outline.points.iter().map(flat).collect();
    let twice = |(i, a): (usize, &[f64; 2])| {
        let b = points[(i + 1) % points.len()];
        a[0] * b[1] - a[1] * b[0]
    };
    points.iter().enumerate().map(twice).sum::<f64>() * 0.5
}
