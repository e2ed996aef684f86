//! A volume that a mesh encloses, as convex pieces.

use cullet::bounds::Plane;
use glam::DVec3;

use cullet_io::reader::Convex;
use cullet_io::reader::Winding;

/// Corners within so much of a plane are on it, in world units.
pub(super) const ON: f64 = 1e-4;
/// Planes of a volume: each may cut all pieces there are.
const MOST_PLANES: usize = 128;
/// Pieces of a volume.
const MOST_PIECES: usize = 512;

/// Why a mesh is no volume.
pub(super) enum NoVolume {
    TooManyPlanes(usize),
    TooManyPieces,
    Empty,
}

impl std::fmt::Display for NoVolume {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooManyPlanes(count) => {
                write!(f, "has {count} planes; a room may have {MOST_PLANES}")
            }
            Self::TooManyPieces => write!(f, "falls into more than {MOST_PIECES} convex pieces"),
            Self::Empty => f.write_str("encloses no volume"),
        }
    }
}

/// Convex pieces of what triangles enclose, however they are wound: the box around them, cut at the
/// planes of the triangles where these lie, and of the parts those that a ray leaves through an odd
/// number of triangles.
///
/// # Errors
/// If there are too many planes or pieces, or nothing is enclosed.
pub(super) fn pieces(triangles: &[[DVec3; 3]]) -> Result<Vec<Convex>, NoVolume> {
    let mut planes: Vec<(Plane, Vec<usize>)> = Vec::new();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (number, [a, b, c]) in triangles.iter().enumerate() {
        (low, high) = (low.min(*a).min(*b).min(*c), high.max(*a).max(*b).max(*c));
        let Some(plane) = Plane::from_point_normal(*a, (*b - *a).cross(*c - *a)) else { continue };
        let same = |(other, _): &&mut (Plane, Vec<usize>)| {
            [a, b, c].iter().all(|p| other.distance(**p).abs() <= ON)
        };
        match planes.iter_mut().find(same) {
            Some((_, of)) => of.push(number),
            None => planes.push((plane, vec![number])),
        }
        if planes.len() > MOST_PLANES {
            return Err(NoVolume::TooManyPlanes(planes.len()));
        }
    }
    let whole = Convex::of_box(low.into(), high.into(), ON).ok_or(NoVolume::Empty)?;
    let mut pieces = vec![whole];
    for (plane, of) in &planes {
        let mut next = Vec::with_capacity(pieces.len() + 1);
        for piece in pieces {
            if of.iter().any(|&t| is_within(&triangles[t], &piece)) {
                let (front, back) = piece.cut(plane);
                next.extend(front.into_iter().chain(back));
            } else {
                next.push(piece);
            }
        }
        pieces = next;
        if pieces.len() > MOST_PIECES {
            return Err(NoVolume::TooManyPieces);
        }
    }
    pieces.retain(|piece| encloses(triangles, piece.middle().0));
    if pieces.is_empty() { Err(NoVolume::Empty) } else { Ok(pieces) }
}

/// Whether some of a triangle is in a piece.
fn is_within(triangle: &[DVec3; 3], piece: &Convex) -> bool {
    let mut left = Some(Winding(triangle.to_vec()));
    for (side, _) in piece.faces() {
        left = left.and_then(|w| w.behind_within(side, ON));
    }
    left.is_some_and(|w| w.0.len() >= 3 && w.width() > ON)
}

/// Whether most of three rays leave a point through an odd number of triangles. They are askew, so
/// that they meet no edge of what stands along the axes.
fn encloses(triangles: &[[DVec3; 3]], point: DVec3) -> bool {
    let rays = [[0.571, 0.313, 0.759], [-0.417, 0.831, 0.367], [0.229, -0.531, -0.816]];
    let is_odd = |ray: &[f64; 3]| {
        let ray = DVec3::from(*ray);
        let met = triangles.iter().filter(|[a, b, c]| {
            let (u, v, w) = (*a - point, *b - point, *c - point);
            // Volumes of the ray with each edge have one sign, and the triangle is ahead.
            let sides = [u.cross(v), v.cross(w), w.cross(u)].map(|n| n.dot(ray));
            let ahead = u.dot(v.cross(w)) * (sides[0] + sides[1] + sides[2]) > 0.0;
            ahead && (sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0))
        });
        met.count() % 2 == 1
    };
    rays.iter().filter(|ray| is_odd(ray)).count() >= 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sides of a prism over a polygon in x and z, from 0 to 3 in y; with `broken` half of them
    /// wound the wrong way.
    fn prism(polygon: &[[f64; 2]], broken: bool) -> Vec<[DVec3; 3]> {
        let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
        let mut out = Vec::new();
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            out.push([at(a, 0.0), at(b, 0.0), at(b, 3.0)]);
            out.push([at(a, 0.0), at(b, 3.0), at(a, 3.0)]);
            // Fans about the first corner, of which an L may have its inner one.
            let c = polygon[0];
            out.push([at(c, 0.0), at(b, 0.0), at(a, 0.0)]);
            out.push([at(c, 3.0), at(a, 3.0), at(b, 3.0)]);
        }
        if broken {
            out.iter_mut().step_by(2).for_each(|t| t.swap(0, 1));
        }
        out
    }

    #[test]
    fn an_l_is_two_boxes_however_it_is_wound() {
        // The inner corner first, so that its fans do not overlap.
        let l = [[2.0, 2.0], [2.0, 4.0], [0.0, 4.0], [0.0, 0.0], [5.0, 0.0], [5.0, 2.0]];
        for broken in [false, true] {
            let Ok(pieces) = pieces(&prism(&l, broken)) else { panic!("it is a volume") };
            let volume: f64 = pieces.iter().map(Convex::volume).sum();
            assert!((volume - 3.0 * (10.0 + 4.0)).abs() < 1e-6, "{volume}");
            assert!(pieces.len() <= 3, "{}", pieces.len());
        }
        let slanted = [[0.0, 0.0], [4.0, 0.0], [5.0, 3.0], [0.0, 3.0]];
        let Ok(one) = pieces(&prism(&slanted, false)) else { panic!("it is a volume") };
        assert_eq!(one.len(), 1);
        assert!((one[0].volume() - 3.0 * 13.5).abs() < 1e-6);
    }

    #[test]
    fn what_encloses_nothing_is_no_volume() {
        let flat = [[DVec3::ZERO, DVec3::X, DVec3::Y]];
        assert!(matches!(pieces(&flat), Err(NoVolume::Empty)));
        assert!(matches!(pieces(&[]), Err(NoVolume::Empty)));
    }
}
