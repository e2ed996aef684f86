//! Proof that a convex body stands between two boxes.
//!
//! Let O be convex, and a a point outside of it. The points b whose segment ab meets O are a convex
//! set: all that is in the cone from a over O and not before O. So where the segments from a to all
//! corners of a box B meet O, those to all points of B do. The same holds of a, with b fixed. Hence
//! the segments between the corners of two boxes, 64 at the most, prove it for those between any
//! two of their points. The inside of O is convex too: it is that which every segment is proved to
//! pass through, so that none merely grazes O.
//!
//! Everything is computed in f64, with bounds on what rounding does to it, and the bound that
//! proves less is taken.

use alloc::vec::Vec;

use cullet::cull::occlusion::Convex;
use cullet::{Transform, exact};
use glam::DVec3;

use super::linear::{length, linear};

/// The corners of a box, each once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    all: [DVec3; 8],
    count: usize,
}

impl Corners {
    pub(super) fn of(min: DVec3, max: DVec3) -> Self {
        let mut corners = Self { all: [min; 8], count: 0 };
        for i in 0..8 {
            let high = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit == 1);
            // Along an axis without extent low and high are one.
            if (0..3).any(|a| high[a] && min[a] == max[a]) {
                continue;
            }
            corners.all[corners.count] =
                DVec3::from_array(core::array::from_fn(|a| if high[a] { max[a] } else { min[a] }));
            corners.count += 1;
        }
        corners
    }

    fn iter(&self) -> impl Iterator<Item = DVec3> {
        self.all[..self.count].iter().copied()
    }
}

/// A plane by three points, of which each difference is known within an error.
#[derive(Clone, Copy, Debug)]
struct Face {
    corner: DVec3,
    /// Normal of the plane: the cross product of two edges, not scaled to unit length.
    normal: DVec3,
    /// Lengths of those two edges.
    edges: [f64; 2],
    error: f64,
}

impl Face {
    fn new([p, q, r]: [DVec3; 3], turn: f64, error: f64) -> Self {
        let (u, v) = (q - p, r - p);
        Self { corner: p, normal: u.cross(v) * turn, edges: [length(u), length(v)], error }
    }

    /// The lowest and the highest value that the true normal has with x − corner: positive is the
    /// side that the normal points to.
    fn span(&self, x: DVec3) -> [f64; 2] {
        let w = x - self.corner;
        let ([u, v], away) = (self.edges, length(w));
        // A determinant of three edges: to first order each may be off by the error, times the
        // lengths of the other two; half as much again for the rest. And less than sixteen
        // roundings.
        let slack = self.error * (u * v + v * away + away * u) * 1.5
            + u * v * away * (16.0 * f64::EPSILON)
            + f64::MIN_POSITIVE;
        let value = self.normal.dot(w);
        [value - slack, value + slack]
    }

    /// The lowest and the highest value of any corner of a box.
    fn span_of(&self, corners: &Corners) -> [f64; 2] {
        let spans = corners.iter().map(|c| self.span(c));
        spans.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [l, h]| {
            [if l < low { l } else { low }, if h > high { h } else { high }]
        })
    }
}

/// Whether it is proved that a convex occluder, put where `transform` says relative to `origin`,
/// blocks every segment from a point of `a` to one of `b`, both relative to `origin`: both boxes
/// lie outside of it, and every segment passes through it, through that of a one-sided polygon from
/// its front.
pub(super) fn blocks(
    convex: &Convex,
    transform: &Transform,
    origin: [f64; 3],
    [a, b]: [&Corners; 2],
) -> bool {
    // A flattened body has no inside.
    let turn = f64::from(exact::determinant_sign(&transform.linear));
    if turn == 0.0 || !transform.is_finite() {
        return false;
    }
    let m = linear(transform);
    let (translation, origin) = (DVec3::from(transform.translation), DVec3::from(origin));
    let shift = translation - origin;
    let mut size = 0.0_f64;
    let mut vertices = Vec::with_capacity(convex.vertices().len());
    for &p in convex.vertices() {
        let p = DVec3::from(p.map(f64::from));
        let reach =
            m.x_axis.abs() * p.x.abs() + m.y_axis.abs() * p.y.abs() + m.z_axis.abs() * p.z.abs();
        size = size.max((reach + translation.abs() + origin.abs()).max_element());
        vertices.push(m * p + shift);
    }
    // Six roundings along each axis, for each of two corners.
    let error = size * (16.0 * f64::EPSILON);
    let at = |v: u32| vertices[v as usize];
    if !(size.is_finite() && vertices.iter().all(|v| v.is_finite())) {
        return false;
    }
    let mut faces = convex.faces();
    if convex.faces().nth(2).is_some() {
        let mut planes = faces.map(|(spread, _)| Face::new(spread.map(at), turn, error));
        return passes_solid(&mut planes, a, b);
    }
    // A polygon is passed from its front, or from the back that it may have.
    faces.any(|(spread, rim)| {
        let plane = Face::new(spread.map(at), turn, error);
        plane.span_of(a)[0] > 0.0
            && plane.span_of(b)[1] < 0.0
            && (0..rim.len()).all(|k| {
                let [p, q] = [rim[k], rim[(k + 1) % rim.len()]].map(at);
                // The plane through the eye and the edge, which points away from the polygon.
                a.iter().all(|eye| Face::new([eye, p, q], turn, error).span_of(b)[1] < 0.0)
            })
    })
}

/// The same of half-spaces whose common part is a body.
fn passes_solid(faces: &mut impl Iterator<Item = Face>, a: &Corners, b: &Corners) -> bool {
    let mut outside = [false; 2];
    // The part of each segment that is inside of all faces so far.
    let mut parts = [[[0.0_f64, 1.0_f64]; 8]; 8];
    for face in faces {
        let mut above = [[0.0; 8]; 2];
        for (side, corners) in [a, b].into_iter().enumerate() {
            let mut least = f64::INFINITY;
            for (i, x) in corners.iter().enumerate() {
                let [low, high] = face.span(x);
                // Of the values along a segment the highest that they may have are linear as well,
                // so what is below zero by them is truly below.
                above[side][i] = high;
                least = if low > least { least } else { low };
            }
            outside[side] |= least > 0.0;
        }
        for i in 0..a.count {
            for j in 0..b.count {
                let (from, to) = (above[0][i], above[1][j]);
                let part = &mut parts[i][j];
                match (from <= 0.0, to <= 0.0) {
                    (true, true) => {}
                    (false, true) => {
                        let enter = from / (from - to) * (1.0 + 4.0 * f64::EPSILON);
                        // NaN stays: it proves nothing.
                        part[0] = if enter <= part[0] { part[0] } else { enter };
                    }
                    (true, false) => {
                        let leave = from / (from - to) * (1.0 - 4.0 * f64::EPSILON);
                        part[1] = if leave >= part[1] { part[1] } else { leave };
                    }
                    (false, false) => return false,
                }
            }
        }
    }
    let passes = |i: usize, j: usize| parts[i][j][0] <= parts[i][j][1];
    outside == [true; 2] && (0..a.count).all(|i| (0..b.count).all(|j| passes(i, j)))
}
