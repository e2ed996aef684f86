//! Cutting polygons into triangles.

use glam::{DVec2, DVec3};

use crate::blocks::make_room;

/// Points tested against a candidate ear, at most, for each corner of a polygon. Simple polygons of
/// up to some 250 corners stay well below; it keeps a hostile file from costing the cube of its
/// size.
const TESTS_PER_CORNER: usize = 512;

/// For a warning, after the count of [`Triangulator::fanned`].
pub(crate) const CONCAVE: &str = "concave polygons that cross themselves or are very large were \
     cut as fans, which may cover more than they do";

/// Cuts polygons of n corners into n − 2 triangles: a fan from the first corner where the polygon
/// is convex, ears where it is not (Meisters, *Polygons Have Ears*, 1975).
#[derive(Debug, Default)]
pub struct Triangulator {
    flat: Vec<DVec2>,
    ring: Vec<u32>,
    /// Concave polygons that had to be fanned all the same: self-intersecting or very large.
    pub fanned: u64,
}

impl Triangulator {
    /// Appends the triangles of `polygon`, which keep its winding. Fewer than three corners append
    /// nothing; corners beyond `positions` (not yet known) make a fan.
    #[inline]
    pub fn push<T: Copy + Into<f64>>(
        &mut self,
        polygon: &[u32],
        positions: &[[T; 3]],
        out: &mut Vec<u32>,
    ) {
        make_room(out, polygon.len().saturating_sub(2) * 3);
        match *polygon {
            [a, b, c] => out.extend([a, b, c]),
            [_, _, _, _, ..] => self.push_large(polygon, positions, out),
            _ => {}
        }
    }

    fn push_large<T: Copy + Into<f64>>(
        &mut self,
        polygon: &[u32],
        positions: &[[T; 3]],
        out: &mut Vec<u32>,
    ) {
        let known = polygon.iter().all(|&v| (v as usize) < positions.len());
        if !known || self.is_convex(polygon, positions) {
            return fan(polygon.iter().copied(), out);
        }
        self.cut_ears(polygon, out);
    }

    /// Whether no corner turns against the rest. Leaves the flattened polygon, counter-clockwise,
    /// in `flat`.
    fn is_convex<T: Copy + Into<f64>>(&mut self, polygon: &[u32], positions: &[[T; 3]]) -> bool {
        let point = |v: u32| DVec3::from(positions[v as usize].map(Into::into));
        let origin = point(polygon[0]);
        let around = |i: usize| point(polygon[i % polygon.len()]) - origin;
        // Newell's normal: right for any flat polygon, a fair mean for one that is not flat.
        let normal: DVec3 = (0..polygon.len()).map(|i| around(i).cross(around(i + 1))).sum();
        let size = normal.abs();
        // Dropping the axis along which the normal is longest keeps the winding, mirrored where
        // needed.
        let flatten = |p: DVec3| {
            let (flat, n) = if size.x >= size.y && size.x >= size.z {
                (DVec2::new(p.y, p.z), normal.x)
            } else if size.y >= size.z {
                (DVec2::new(p.z, p.x), normal.y)
            } else {
                (DVec2::new(p.x, p.y), normal.z)
            };
            if n < 0.0 { DVec2::new(flat.x, -flat.y) } else { flat }
        };
        self.flat.clear();
        self.flat.extend((0..polygon.len()).map(|i| flatten(around(i))));
        // A corner that turns back by next to nothing is rounding, not a notch.
        let slack = size.max_element() * 1e-7;
        let n = polygon.len();
        (0..n).all(|i| turn(self.flat[i], self.flat[(i + 1) % n], self.flat[(i + 2) % n]) >= -slack)
    }

    fn cut_ears(&mut self, polygon: &[u32], out: &mut Vec<u32>) {
        self.ring.clear();
        self.ring.extend(0..polygon.len() as u32);
        let mut tests = TESTS_PER_CORNER * polygon.len();
        let mut i = 0;
        let mut tried = 0;
        while self.ring.len() > 3 {
            let n = self.ring.len();
            if tried >= n || tests == 0 {
                self.fanned += 1;
                break;
            }
            let corner = [(i + n - 1) % n, i % n, (i + 1) % n].map(|k| self.ring[k]);
            if self.is_ear(corner, &mut tests) {
                out.extend(corner.map(|k| polygon[k as usize]));
                self.ring.remove(i % n);
                // Going on from the corner before keeps the triangles from all sharing one vertex.
                i = (i % n).max(1) - 1;
                tried = 0;
            } else {
                i += 1;
                tried += 1;
            }
        }
        fan(self.ring.iter().map(|&k| polygon[k as usize]), out);
    }

    fn is_ear(&self, corner: [u32; 3], tests: &mut usize) -> bool {
        let [a, b, c] = corner.map(|k| self.flat[k as usize]);
        if turn(a, b, c) <= 0.0 {
            *tests = tests.saturating_sub(1);
            return false;
        }
        for &k in &self.ring {
            let p = self.flat[k as usize];
            *tests = tests.saturating_sub(1);
            // A bridge to a hole visits a point twice; that alone does not spoil an ear.
            let is_corner = p == a || p == b || p == c;
            let inside = turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            if inside && !is_corner {
                return false;
            }
        }
        true
    }
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn fan(mut corners: impl Iterator<Item = u32>, out: &mut Vec<u32>) {
    let (Some(first), Some(mut last)) = (corners.next(), corners.next()) else { return };
    for corner in corners {
        out.extend([first, last, corner]);
        last = corner;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(positions: &[[f32; 3]], indices: &[u32]) -> (f64, f64) {
        let point = |v: u32| DVec3::from(positions[v as usize].map(f64::from));
        indices
            .chunks_exact(3)
            .map(|t| (point(t[1]) - point(t[0])).cross(point(t[2]) - point(t[0])) * 0.5)
            .fold((0.0, 0.0), |(signed, sum), n| (signed + n.z, sum + n.length()))
    }

    fn cut(positions: &[[f32; 3]]) -> (Vec<u32>, u64) {
        let polygon: Vec<u32> = (0..positions.len() as u32).collect();
        let (mut t, mut out) = (Triangulator::default(), Vec::new());
        t.push(&polygon, positions, &mut out);
        (out, t.fanned)
    }

    #[test]
    fn convex_polygons_are_fans() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&square).0, [0, 1, 2, 0, 2, 3]);
    }

    #[test]
    fn a_notch_is_not_covered() {
        // An arrow head whose fan from corner 0 would run outside.
        let arrow = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.5, 1.0, 0.0]];
        let (indices, fanned) = cut(&[arrow[1], arrow[2], arrow[3], arrow[0]]);
        let (signed, sum) = area(&[arrow[1], arrow[2], arrow[3], arrow[0]], &indices);
        assert_eq!((indices.len(), fanned), (6, 0));
        assert!((signed - 1.5).abs() < 1e-9 && (sum - 1.5).abs() < 1e-9, "{signed} {sum}");
    }

    #[test]
    fn combs_keep_their_area_in_every_orientation() {
        // Teeth of width 1 and height 3 on a bar of height 1, then the same seen from behind.
        let mut comb = vec![[0.0f32, 0.0, 0.0], [9.0, 0.0, 0.0]];
        for k in (0..5).rev() {
            let x = k as f32 * 2.0;
            comb.extend([[x + 1.0, 4.0, 0.0], [x, 4.0, 0.0]]);
            if k > 0 {
                comb.extend([[x, 1.0, 0.0], [x - 1.0, 1.0, 0.0]]);
            }
        }
        let expected = 9.0 + 15.0;
        for flip in [1.0f64, -1.0] {
            if flip < 0.0 {
                comb.reverse();
            }
            for turned in 0..comb.len() {
                comb.rotate_left(1);
                let (indices, fanned) = cut(&comb);
                let (signed, sum) = area(&comb, &indices);
                assert_eq!((indices.len(), fanned), ((comb.len() - 2) * 3, 0), "{turned}");
                assert!((signed - flip * expected).abs() < 1e-9, "{turned}: {signed}");
                assert!((sum - expected).abs() < 1e-9, "{turned}: {sum}");
            }
        }
    }

    #[test]
    fn self_intersecting_polygons_end_in_a_fan() {
        let bow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&bow).0.len(), 6);
        let flat = [[0.0, 0.0, 0.0]; 7];
        assert_eq!(cut(&flat).0.len(), 15);
    }

    #[test]
    fn hostile_polygons_end_soon() {
        // A long spiral has few ears, far apart.
        let spiral: Vec<[f32; 3]> = (0..20_000)
            .map(|i| {
                let (a, r) = (i as f32 * 0.01, if i % 2 == 0 { 1.0 } else { 2.0 } + i as f32);
                [r * a.cos(), r * a.sin(), 0.0]
            })
            .collect();
        assert_eq!(cut(&spiral).0.len(), (spiral.len() - 2) * 3);
    }
}
