//! The opaque triangles of a mesh, welded, and those of them that close off a space.

use std::collections::HashMap;

use cullet::Mesh;
use cullet::mesh::{Alpha, weld};
use glam::DVec3;

use crate::corners::turned;

/// A triangle that hides what is behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Welded vertices.
    pub(super) vertices: [u32; 3],
    /// Whether it is drawn from behind too.
    pub(super) two_sided: bool,
}

/// The opaque triangles of a mesh. Equal positions are one vertex, triangles that coincide are one.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) points: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    /// The largest coordinate, for rounding errors.
    pub(super) reach: f64,
    /// Triangles left out because they are blended or alpha-masked.
    pub(super) transparent: u32,
}

impl Surface {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let mut surface = Self::default();
        let welded = weld(mesh.positions());
        // The number of the point of each first vertex.
        let mut numbers: Vec<Option<u32>> = vec![None; welded.len()];
        let mut seen: HashMap<[u32; 3], usize> = HashMap::new();
        for t in 0..mesh.triangle_count() {
            let original = mesh.original_triangle()[t as usize];
            // The last that starts at or before it: empty parts start where the next one does.
            let part = mesh.parts().partition_point(|p| p.first_triangle <= original) - 1;
            let part = &mesh.parts()[part];
            if part.alpha != Alpha::Opaque {
                surface.transparent += 1;
                continue;
            }
            let first = t as usize * 3;
            let vertices = [0, 1, 2].map(|i| {
                let vertex = mesh.indices()[first + i] as usize;
                *numbers[welded[vertex] as usize].get_or_insert_with(|| {
                    surface.points.push(DVec3::from(mesh.positions()[vertex].map(f64::from)));
                    surface.points.len() as u32 - 1
                })
            });
            let [a, b, c] = vertices;
            if a == b || b == c || c == a {
                continue;
            }
            let mut key = vertices;
            key.sort_unstable();
            let at = *seen.entry(key).or_insert(surface.triangles.len());
            let Some(same) = surface.triangles.get_mut(at) else {
                surface.triangles.push(Triangle { vertices, two_sided: part.two_sided });
                continue;
            };
            // One that is wound the other way shows the side that this one lacks.
            let turn = vertices.iter().position(|&v| v == same.vertices[0]).unwrap_or(0);
            same.two_sided |= part.two_sided || vertices[(turn + 1) % 3] != same.vertices[1];
        }
        surface.reach = surface.points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        surface
    }

    pub(super) fn corners(&self, triangle: &Triangle) -> [DVec3; 3] {
        triangle.vertices.map(|v| self.points[v as usize])
    }

    /// Bound on the error of coordinates computed from those of the mesh, with plenty to spare: a
    /// margin for every comparison in f64, and 4 thousandths of what f32 rounds.
    pub(super) fn margin(&self) -> f64 {
        self.reach * f64::from_bits((1023 - 32) << 52) + f64::MIN_POSITIVE
    }

    /// The triangles by their corners.
    pub(super) fn by_corners(&self) -> ByCorners {
        let exact = |p: DVec3| key(p.to_array().map(|v| v as f32));
        let by = self.triangles.iter().map(|t| {
            let keys = turned(self.corners(t).map(exact));
            (keys, t.two_sided)
        });
        ByCorners { sides: by.collect() }
    }

    pub(super) fn area(&self) -> f64 {
        self.triangles.iter().map(|t| normal(&self.corners(t)).length() * 0.5).sum()
    }

    /// The closed shells that a point can be proved to be within.
    pub(super) fn shells(&self) -> Vec<Shell> {
        let edges = Edges::of(self);
        let live = edges.without_open(self.triangles.len());
        let mut shells = Vec::new();
        let mut taken: Vec<bool> = live.iter().map(|l| !l).collect();
        for first in 0..taken.len() {
            if std::mem::replace(&mut taken[first], true) {
                continue;
            }
            let mut of = vec![first as u32];
            let mut next = 0;
            while let Some(&t) = of.get(next) {
                next += 1;
                for e in edges.of_triangle[t as usize] {
                    for &(other, _) in edges.triangles(e) {
                        if !std::mem::replace(&mut taken[other as usize], true) {
                            of.push(other);
                        }
                    }
                }
            }
            shells.extend(Shell::new(self, &edges, &live, &of));
        }
        shells
    }
}

/// A position by its bits; −0 is the same place as 0.
fn key(p: [f32; 3]) -> [u32; 3] {
    // Adding zero makes −0 into 0.
    p.map(|v| (v + 0.0).to_bits())
}

/// The triangles of a surface by their corners, and whether each is drawn from both sides.
#[derive(Debug)]
pub(super) struct ByCorners {
    sides: HashMap<[[u32; 3]; 3], bool>,
}

impl ByCorners {
    /// Whether a triangle blocks as one of the surface does.
    pub(super) fn serves(&self, corners: &[[f32; 3]; 3], two_sided: bool) -> bool {
        let [a, b, c] = corners.map(key);
        let same = self.sides.get(&turned([a, b, c]));
        let other = self.sides.get(&turned([a, c, b]));
        same.is_some_and(|both| *both || !two_sided) || other == Some(&true)
    }
}

/// Twice the area, along the normal.
pub(super) fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Triangles that meet at each edge, and their directions along it.
#[derive(Debug)]
pub(super) struct Edges {
    pub(super) of_triangle: Vec<[u32; 3]>,
    first: Vec<u32>,
    /// Triangle, and whether it runs from the lower vertex to the higher.
    list: Vec<(u32, bool)>,
}

impl Edges {
    pub(super) fn of(surface: &Surface) -> Self {
        let mut all = Vec::with_capacity(surface.triangles.len() * 3);
        for (t, triangle) in (0u32..).zip(&surface.triangles) {
            for k in 0..3 {
                let (a, b) = (triangle.vertices[k], triangle.vertices[(k + 1) % 3]);
                all.push((a.min(b), a.max(b), t, k, a < b));
            }
        }
        all.sort_unstable();
        let mut edges = Self {
            of_triangle: vec![[0; 3]; surface.triangles.len()],
            first: vec![0],
            list: Vec::with_capacity(all.len()),
        };
        for same in all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for &(_, _, t, k, up) in same {
                edges.of_triangle[t as usize][k] = edges.first.len() as u32 - 1;
                edges.list.push((t, up));
            }
            edges.first.push(edges.list.len() as u32);
        }
        edges
    }

    pub(super) fn triangles(&self, edge: u32) -> &[(u32, bool)] {
        let e = edge as usize;
        &self.list[self.first[e] as usize..self.first[e + 1] as usize]
    }

    /// Returns which triangles are left once all with a free edge are taken away, again and again:
    /// fins and open sheets go, shells that enclose a space stay.
    fn without_open(&self, triangles: usize) -> Vec<bool> {
        let mut live = vec![true; triangles];
        let mut count: Vec<u32> = self.first.windows(2).map(|w| w[1] - w[0]).collect();
        let mut open: Vec<u32> =
            (0..count.len() as u32).filter(|&e| count[e as usize] == 1).collect();
        while let Some(edge) = open.pop() {
            for &(t, _) in self.triangles(edge) {
                if !std::mem::replace(&mut live[t as usize], false) {
                    continue;
                }
                for e in self.of_triangle[t as usize] {
                    count[e as usize] -= 1;
                    if count[e as usize] == 1 {
                        open.push(e);
                    }
                }
            }
        }
        live
    }
}

/// Triangles without boundary, so that a path from a point within to one without must cross them.
///
/// Where as many triangles run along every edge one way as the other, the winding number is
/// defined: a path from outside to a point of winding number 1 or more crosses at least one
/// triangle from its front. Where triangles are drawn from both sides, any crossing will do, and an
/// odd number of crossings is proof.
#[derive(Clone, Debug)]
pub(super) struct Shell {
    pub(super) triangles: Vec<[DVec3; 3]>,
    pub(super) low: DVec3,
    pub(super) high: DVec3,
    two_sided: bool,
    signed: bool,
}

/// Ways to leave a shell; of no special direction, so that they rarely meet an edge.
const WAYS: [[f64; 3]; 10] = [
    [0.573_1, 0.314_7, 0.756_7],
    [-0.421_9, 0.811_3, -0.404_1],
    [0.157_9, -0.690_7, 0.705_7],
    [0.871_3, -0.217_3, -0.439_9],
    [-0.707_3, -0.353_9, -0.611_9],
    [-0.283_1, 0.513_7, 0.810_1],
    [0.611_3, 0.737_9, -0.286_3],
    [-0.913_7, 0.131_3, 0.384_7],
    [0.327_1, -0.919_3, -0.218_9],
    [-0.111_7, -0.457_3, -0.882_1],
];

impl Shell {
    /// `None` where it proves nothing: edges with an odd number of triangles, or one-sided
    /// triangles that are wound inconsistently.
    fn new(surface: &Surface, edges: &Edges, live: &[bool], of: &[u32]) -> Option<Self> {
        let two_sided = of.iter().all(|&t| surface.triangles[t as usize].two_sided);
        let (mut signed, mut even) = (true, true);
        for e in of.iter().flat_map(|&t| edges.of_triangle[t as usize]) {
            let (mut count, mut up) = (0, 0);
            for &(t, rises) in edges.triangles(e) {
                count += u32::from(live[t as usize]);
                up += u32::from(live[t as usize] && rises);
            }
            signed &= 2 * up == count;
            even &= count % 2 == 0;
        }
        if !(signed || even && two_sided) {
            return None;
        }
        let triangles: Vec<_> =
            of.iter().map(|&t| surface.corners(&surface.triangles[t as usize])).collect();
        let corners = || triangles.iter().flatten();
        let low = corners().fold(DVec3::INFINITY, |m, &p| m.min(p));
        let high = corners().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
        Some(Self { low, high, two_sided, signed, triangles })
    }

    /// Whether all ways from outside to `p` are proved to cross the shell where it is drawn. Doubt
    /// is no. Three rays must agree; those that pass an edge too closely are replaced.
    pub(super) fn seals(&self, p: DVec3) -> bool {
        if !(p.cmpgt(self.low).all() && p.cmplt(self.high).all()) {
            return false;
        }
        let mut agreed = None;
        let mut votes = 0;
        for way in WAYS {
            let Some([net, odd]) = self.crossings(p, DVec3::from(way)) else { continue };
            // Without a winding number the net count says nothing, and may differ from ray to ray.
            let crossings = [if self.signed { net } else { 0 }, odd];
            if *agreed.get_or_insert(crossings) != crossings {
                return false;
            }
            votes += 1;
            if votes == 3 {
                break;
            }
        }
        let Some([net, odd]) = agreed.filter(|_| votes == 3) else { return false };
        self.signed && (net >= 1 || net != 0 && self.two_sided) || self.two_sided && odd == 1
    }

    /// How often a ray leaves, less how often it enters; and 1 if the number of both is odd. `None`
    /// where it cannot be told from rounding.
    fn crossings(&self, from: DVec3, way: DVec3) -> Option<[i32; 2]> {
        // Of products of three: some 20 roundings of 1.1e-16 each.
        const ERROR: f64 = 1e-14;
        let (mut net, mut all) = (0, 0);
        for t in &self.triangles {
            let [a, b, c] = t.map(|p| p - from);
            let [u, v, w] = [way.dot(b.cross(c)), way.dot(c.cross(a)), way.dot(a.cross(b))];
            let far = a.length_squared().max(b.length_squared()).max(c.length_squared());
            let error = far * ERROR;
            if u.max(v).max(w) > error && u.min(v).min(w) < -error {
                continue;
            }
            let out = a.dot((b - a).cross(c - a));
            if u.abs().min(v.abs()).min(w.abs()) <= error || out.abs() <= far * far.sqrt() * ERROR {
                // A triangle wholly behind cannot be met, whatever the rounding.
                if [a, b, c].iter().all(|p| p.dot(way) < 0.0) {
                    continue;
                }
                return None;
            }
            let leaves = u > 0.0;
            // The triangle's plane is ahead where both have the same sign.
            if leaves == (out > 0.0) {
                net += if leaves { 1 } else { -1 };
                all += 1;
            }
        }
        Some([net, all % 2])
    }
}
