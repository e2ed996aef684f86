//! Whether occluders are within what a mesh hides: proved by subdivision, and tried by samples.

use cullet::Mesh;
use cullet::bounds::Aabb;
use glam::DVec3;

use super::surface::{Shell, Surface, normal};
use super::voxels::touches;
use super::{OccluderPolygon, Occluders};
use crate::sample::fibonacci;

/// A place where an occluder hides something that the mesh does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Escape {
    /// A ray from a box to infinity crosses nothing that is drawn from outside.
    Box {
        /// Number of the box.
        index: u32,
        /// From where.
        point: [f64; 3],
        /// Direction of the line.
        direction: [f64; 3],
    },
    /// A point of a polygon is off the surface.
    OccluderPolygon {
        /// Number of the polygon.
        index: u32,
        /// The point.
        point: [f64; 3],
        /// How far off, in units of the mesh.
        distance: f64,
    },
    /// A triangle is none of the mesh's, or blocks from a side from which that is not drawn.
    Triangle {
        /// Number of the sheet; sheets for near eyes are counted after the others.
        sheet: u32,
        /// Number of the triangle in the sheet.
        index: u32,
        /// Its corners.
        corners: [[f32; 3]; 3],
    },
}

/// Result of [`validate`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Validation {
    /// Boxes of which every point was proved to be sealed off by a closed shell.
    pub proved_boxes: u32,
    /// Boxes for which there is no proof.
    pub unproved_boxes: Vec<u32>,
    /// Rays and points that were tried.
    pub samples: u64,
    /// Triangles that are the mesh's own, which is proof.
    pub proved_triangles: u32,
    /// Counterexamples, at most one for each occluder.
    pub escapes: Vec<Escape>,
    /// The farthest that a sampled point of a polygon is from the surface, in units of the mesh.
    pub farthest: f64,
}

impl Validation {
    /// All boxes are proved, and no sample speaks against any occluder.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.unproved_boxes.is_empty() && self.escapes.is_empty()
    }
}

/// Parts of a box that are looked at before the proof is given up.
const MOST_PIECES: u32 = 200_000;

/// Proves that occluders lie within what a mesh hides, without the grid by which they were made.
///
/// A box is proved if a closed shell has no triangle near it and seals its middle; else it is
/// halved and both halves are proved. A triangle is proved if the mesh has it. Independently of
/// shells, from `samples` points of each box a ray is shot outward, which must cross a triangle
/// that is drawn from there; and as many points of each polygon must be within its tolerance of a
/// triangle that faces as it does. Costs some 10 ns for each sample and triangle.
#[must_use]
pub fn validate(mesh: &Mesh, occluders: &Occluders, samples: u32) -> Validation {
    let surface = Surface::of(mesh);
    let shells = surface.shells();
    let mut found = Validation::default();
    let triangles: Vec<([DVec3; 3], bool)> =
        surface.triangles.iter().map(|t| (surface.corners(t), t.two_sided)).collect();
    for (index, b) in (0..).zip(&occluders.boxes) {
        let near = shells.iter().map(|s| (s, s.triangles.iter().collect())).collect();
        let mut left = MOST_PIECES;
        let [low, high] = [b.min, b.max].map(|p| DVec3::from(p.map(f64::from)));
        if b.is_empty() || !is_sealed(low, high, surface.margin() * 0.25, near, &mut left) {
            found.unproved_boxes.push(index);
        } else {
            found.proved_boxes += 1;
        }
        found.samples += u64::from(samples);
        found.escapes.extend(escape_of_box(&triangles, index, b, samples));
    }
    for (index, polygon) in (0..).zip(&occluders.polygons) {
        found.samples += u64::from(samples);
        let allowed = f64::from(polygon.tolerance) + surface.margin();
        let normal = plane_of(polygon);
        let mut worst: Option<(f64, DVec3)> = None;
        for i in 0..samples {
            let p = point_of(polygon, i);
            let off = distance(&triangles, p, normal, polygon.two_sided);
            if worst.is_none_or(|w| off > w.0) {
                worst = Some((off, p));
            }
        }
        let Some((distance, point)) = worst else { continue };
        found.farthest = found.farthest.max(distance);
        if distance > allowed {
            found.escapes.push(Escape::OccluderPolygon {
                index,
                point: point.to_array(),
                distance,
            });
        }
    }
    let own = surface.by_corners();
    for (number, sheet) in (0..).zip(occluders.sheets.iter().chain(&occluders.near)) {
        for (index, &corners) in (0..).zip(&sheet.triangles) {
            match own.serves(&corners, sheet.two_sided) {
                true => found.proved_triangles += 1,
                false => found.escapes.push(Escape::Triangle { sheet: number, index, corners }),
            }
        }
    }
    found
}

/// Whether every point of a box is proved to be sealed. `near` are the triangles of each shell that
/// may touch it.
fn is_sealed(
    low: DVec3,
    high: DVec3,
    margin: f64,
    near: Vec<(&Shell, Vec<&[DVec3; 3]>)>,
    left: &mut u32,
) -> bool {
    let mut here = Vec::new();
    for (shell, triangles) in near {
        // A shell that is not even around a part of the box says nothing about it.
        if high.cmplt(shell.low).any() || low.cmpgt(shell.high).any() {
            continue;
        }
        let touching: Vec<_> =
            triangles.into_iter().filter(|t| touches(t, low, high, margin)).collect();
        if !touching.is_empty() {
            here.push((shell, touching));
        } else if shell.seals((low + high) * 0.5) {
            return true;
        }
    }
    if here.is_empty() || *left == 0 {
        return false;
    }
    *left -= 1;
    let axis = (high - low).max_position();
    let middle = (low[axis] + high[axis]) * 0.5;
    if middle <= low[axis] || middle >= high[axis] {
        return false;
    }
    let (mut below, mut above) = (high, low);
    below[axis] = middle;
    above[axis] = middle;
    // A shell without a triangle here that seals nothing here seals nothing in a part of here
    // either.
    is_sealed(low, below, margin, here.clone(), left) && is_sealed(above, high, margin, here, left)
}

/// Number `i` of a sequence that fills the unit interval evenly, whatever its length.
fn sequence(i: u32, k: usize) -> f64 {
    // Roberts' generalised golden ratio of three dimensions, and its powers.
    const STEPS: [f64; 3] =
        [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_1];
    (f64::from(i) * STEPS[k] + 0.5).fract()
}

fn escape_of_box(
    triangles: &[([DVec3; 3], bool)],
    index: u32,
    b: &Aabb,
    samples: u32,
) -> Option<Escape> {
    let [low, high] = [b.min, b.max].map(|p| DVec3::from(p.map(f64::from)));
    (0..samples).find_map(|i| {
        // The first eight are the corners, where a box is nearest to the surface.
        let share = match i {
            0..8 => [0, 1, 2].map(|k| f64::from(i >> k & 1)),
            _ => [0, 1, 2].map(|k| sequence(i, k)),
        };
        let from = low + (high - low) * DVec3::from(share);
        let way = fibonacci(i as usize, samples as usize);
        let blocked = triangles.iter().any(|(t, two_sided)| crosses(t, *two_sided, from, way));
        let escape = Escape::Box { index, point: from.to_array(), direction: way.to_array() };
        (!blocked).then_some(escape)
    })
}

/// Whether a ray outward crosses a triangle that is drawn for an eye that looks the other way. Rays
/// through an edge cross both its triangles.
fn crosses(t: &[DVec3; 3], two_sided: bool, from: DVec3, way: DVec3) -> bool {
    let [a, b, c] = t.map(|p| p - from);
    let [u, v, w] = [way.dot(b.cross(c)), way.dot(c.cross(a)), way.dot(a.cross(b))];
    let error = a.length_squared().max(b.length_squared()).max(c.length_squared()) * 1e-14;
    let ahead = a.dot((b - a).cross(c - a));
    let out = u.min(v).min(w) >= -error && ahead >= 0.0;
    let into = u.max(v).max(w) <= error && ahead <= 0.0;
    out || into && two_sided
}

fn plane_of(polygon: &OccluderPolygon) -> DVec3 {
    let points: Vec<DVec3> = polygon.points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let Some(&first) = points.first() else { return DVec3::ZERO };
    points.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum::<DVec3>().normalize_or_zero()
}

/// Point `i` of a polygon: its corners first, then points of one triangle of it after another.
fn point_of(polygon: &OccluderPolygon, i: u32) -> DVec3 {
    let n = polygon.points.len();
    let point = |k: usize| DVec3::from(polygon.points[k].map(f64::from));
    if n < 3 || (i as usize) < n {
        return if n == 0 { DVec3::NAN } else { point(i as usize % n) };
    }
    let k = 1 + i as usize % (n - 2);
    let (mut s, mut t) = (sequence(i, 0), sequence(i, 1));
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    point(0) + (point(k) - point(0)) * s + (point(k + 1) - point(0)) * t
}

/// How far a point is from the nearest triangle that faces as `facing`, or the other way if it is
/// drawn from both sides. A polygon that blocks from both sides needs triangles that do.
fn distance(triangles: &[([DVec3; 3], bool)], p: DVec3, facing: DVec3, both: bool) -> f64 {
    let mut least = f64::INFINITY;
    for (t, two_sided) in triangles {
        let along = normal(t).dot(facing);
        let serves = if both { *two_sided && along != 0.0 } else { along > 0.0 || *two_sided };
        if serves {
            least = least.min((nearest(t, p) - p).length());
        }
    }
    least
}

/// The point of a triangle that is nearest to `p` (Ericson, *Real-Time Collision Detection*, 2005,
/// 5.1.5, by another way: the plane if `p` is over the triangle, else the nearest edge).
fn nearest(t: &[DVec3; 3], p: DVec3) -> DVec3 {
    let n = normal(t);
    let over = (0..3).all(|k| n.dot((t[(k + 1) % 3] - t[k]).cross(p - t[k])) >= 0.0);
    if over && n != DVec3::ZERO {
        let n = n.normalize();
        return p - n * (p - t[0]).dot(n);
    }
    let on_edge = |k: usize| {
        let (a, edge) = (t[k], t[(k + 1) % 3] - t[k]);
        let share = (p - a).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        a + edge * share.clamp(0.0, 1.0)
    };
    let mut best = on_edge(0);
    for k in 1..3 {
        let q = on_edge(k);
        if (q - p).length_squared() < (best - p).length_squared() {
            best = q;
        }
    }
    best
}
