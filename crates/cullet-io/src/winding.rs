//! Convex polygons in f64, cut by planes.

use cullet::bounds::Plane;
use glam::DVec3;

/// Distance within which a corner is on a plane, in units of the map. Planes and corners of maps
/// are f32, off by some thousandths where a map is thousands of units large.
pub const ON: f64 = 0.01;

/// A convex polygon in a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Winding(pub Vec<DVec3>);

/// Result of cutting a polygon by a plane.
#[derive(Debug)]
pub enum Cut {
    /// All is in front.
    Front,
    /// All is behind.
    Back,
    /// All is on it.
    On,
    /// A part on each side.
    Both(Winding, Winding),
}

impl Winding {
    /// A square in a plane, counter-clockwise from its front, about the point of it that is nearest
    /// to `centre`, reaching `reach` to each side at least.
    pub fn square(plane: &Plane, centre: DVec3, reach: f64) -> Self {
        let normal = DVec3::from(plane.normal);
        let middle = centre - normal * plane.distance(centre);
        let (aside, up) = normal.any_orthonormal_pair();
        let corner = |x: f64, y: f64| middle + aside * (x * reach) + up * (y * reach);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let square = Self(corners.to_vec());
        if square.area().dot(normal) < 0.0 { square.reversed() } else { square }
    }

    /// The same, seen from behind.
    pub fn reversed(mut self) -> Self {
        self.0.reverse();
        self
    }

    /// Twice the area, along the normal of the side from which it is counter-clockwise.
    pub fn area(&self) -> DVec3 {
        let first = self.0[0];
        self.0.windows(2).fold(DVec3::ZERO, |sum, w| sum + (w[0] - first).cross(w[1] - first))
    }

    /// Width: twice the area over the longest diagonal, at least half of what a ruler says.
    pub fn width(&self) -> f64 {
        let far = |a: &DVec3| self.0.iter().map(|b| a.distance_squared(*b)).fold(0.0, f64::max);
        let longest = self.0.iter().map(far).fold(0.0, f64::max).sqrt();
        if longest > 0.0 { self.area().length() / longest } else { 0.0 }
    }

    /// Cuts it. A corner within [`ON`] of the plane is on both sides and makes no new one.
    pub fn cut(&self, plane: &Plane) -> Cut {
        self.cut_within(plane, ON)
    }

    /// Cuts like [`cut`](Self::cut), but corners within `on` of the plane count as on it.
    pub fn cut_within(&self, plane: &Plane, on: f64) -> Cut {
        let distances: Vec<f64> = self.0.iter().map(|p| plane.distance(*p)).collect();
        let front = distances.iter().any(|d| *d > on);
        let back = distances.iter().any(|d| *d < -on);
        match (front, back) {
            (true, false) => return Cut::Front,
            (false, true) => return Cut::Back,
            (false, false) => return Cut::On,
            (true, true) => {}
        }
        let (mut before, mut behind) = (Vec::new(), Vec::new());
        for (i, (&p, &d)) in self.0.iter().zip(&distances).enumerate() {
            let next = (i + 1) % self.0.len();
            if d >= -on {
                before.push(p);
            }
            if d <= on {
                behind.push(p);
            }
            let e = distances[next];
            if d > on && e < -on || d < -on && e > on {
                let between = p.lerp(self.0[next], d / (d - e));
                before.push(between);
                behind.push(between);
            }
        }
        Cut::Both(Self(before), Self(behind))
    }

    /// The part behind a plane; `None` if there is none.
    pub fn behind(self, plane: &Plane) -> Option<Self> {
        self.behind_within(plane, ON)
    }

    /// Returns the same as [`behind`](Self::behind), but corners within `on` of the plane count as
    /// on it.
    pub fn behind_within(self, plane: &Plane, on: f64) -> Option<Self> {
        match self.cut_within(plane, on) {
            Cut::Back | Cut::On => Some(self),
            Cut::Front => None,
            Cut::Both(_, behind) => Some(behind),
        }
    }

    /// Both as one where they share an edge and are convex together, in one plane with this normal.
    pub fn joined(&self, other: &Self, normal: DVec3) -> Option<Self> {
        let same = |a: DVec3, b: DVec3| a.distance_squared(b) <= ON * ON;
        let (n, m) = (self.0.len(), other.0.len());
        let (i, j) = (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).find(|&(i, j)| {
            same(self.0[i], other.0[(j + 1) % m]) && same(self.0[(i + 1) % n], other.0[j])
        })?;
        // From the end of the shared edge round this one, then round the other, without its edge.
        let mut corners: Vec<DVec3> = (1..=n).map(|k| self.0[(i + k) % n]).collect();
        corners.extend((2..m).map(|k| other.0[(j + k) % m]));
        let count = corners.len();
        let joined = Self(
            (0..count)
                .filter(|&k| {
                    // Corners that the cut made on a straight edge go again.
                    let [a, b, c] = [k + count - 1, k, k + 1].map(|k| corners[k % count]);
                    off(a, c, b, normal) < -1e-9 || off(a, c, b, normal) > ON
                })
                .map(|k| corners[k])
                .collect(),
        );
        (joined.0.len() >= 3 && joined.is_convex(normal)).then_some(joined)
    }

    fn is_convex(&self, normal: DVec3) -> bool {
        let count = self.0.len();
        (0..count).all(|k| {
            let [a, b] = [k, k + 1].map(|k| self.0[k % count]);
            self.0.iter().all(|p| off(a, b, *p, normal) >= -ON)
        })
    }
}

/// How far `p` lies to the inner side of the edge from `a` to `b` of a polygon that is
/// counter-clockwise about `normal`.
fn off(a: DVec3, b: DVec3, p: DVec3, normal: DVec3) -> f64 {
    normal.cross(b - a).normalize_or_zero().dot(p - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Plane = Plane::new([0.0, 0.0, 1.0], 3.0);

    fn x(at: f64) -> Plane {
        Plane::new([1.0, 0.0, 0.0], at)
    }

    #[test]
    fn squares_are_counter_clockwise_and_where_they_should_be() {
        for normal in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, -0.8]] {
            let plane = Plane::new(normal, 7.0);
            let square = Winding::square(&plane, DVec3::new(1.0, 2.0, 3.0), 10.0);
            assert!(square.area().dot(normal.into()) > 799.0);
            assert!(square.0.iter().all(|p| plane.distance(*p).abs() < 1e-9));
        }
    }

    #[test]
    fn parts_make_the_whole_and_join_again() {
        let square = Winding::square(&UP, DVec3::ZERO, 10.0);
        let Cut::Both(front, back) = square.cut(&x(2.0)) else { panic!("it is cut") };
        assert!((front.area().z - 320.0).abs() < 1e-9 && (back.area().z - 480.0).abs() < 1e-9);
        let joined = front.joined(&back, DVec3::Z).expect("they are convex together");
        assert!((joined.area().z - 800.0).abs() < 1e-9);
        assert_eq!(joined.0.len(), 4);
        // An L is not convex.
        let Cut::Both(_, half) = front.cut(&Plane::new([0.0, 1.0, 0.0], 0.0)) else { panic!() };
        assert_eq!(back.joined(&half, DVec3::Z), None);
        assert!(matches!(square.cut(&x(10.005)), Cut::Back));
        assert!(matches!(square.cut(&x(-11.0)), Cut::Front));
        assert!(matches!(square.cut(&UP), Cut::On));
        assert_eq!(square.behind(&x(-11.0)), None);
    }

    #[test]
    fn slivers_are_narrow() {
        let sliver = Winding(vec![DVec3::ZERO, DVec3::X * 100.0, DVec3::new(50.0, 0.001, 0.0)]);
        assert!(sliver.width() < 0.0011);
        assert!(Winding::square(&UP, DVec3::ZERO, 1.0).width() > 1.0);
    }
}
