//! Convex polygons on the stack, clipped by planes, and the planes that separate two of them.

use glam::DVec3;

/// Most corners of a polygon. One with more is replaced by a rectangle around it, and a clip that
/// would make more is not done: both only keep more.
const MOST: usize = 12;

/// Most planes between two polygons.
const MOST_PLANES: usize = 26;

/// A convex polygon of up to [`MOST`] corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    len: usize,
    corners: [DVec3; MOST],
}

/// A half-space n·x ≥ d that is kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub(super) normal: DVec3,
    pub(super) d: f64,
}

/// Half-spaces, all of which are kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpaces {
    len: usize,
    list: [HalfSpace; MOST_PLANES],
}

impl HalfSpaces {
    pub(super) const NONE: Self =
        Self { len: 0, list: [HalfSpace { normal: DVec3::ZERO, d: 0.0 }; MOST_PLANES] };

    #[inline]
    pub(super) fn all(&self) -> &[HalfSpace] {
        &self.list[..self.len]
    }

    #[inline]
    pub(super) fn push(&mut self, normal: DVec3, d: f64) {
        if self.len < MOST_PLANES {
            self.list[self.len] = HalfSpace { normal, d };
            self.len += 1;
        }
    }
}

impl Polygon {
    /// A polygon, or where it has too many corners a rectangle around it.
    pub(super) fn around(corners: &[DVec3], normal: DVec3) -> Self {
        let mut made = Self { len: corners.len().min(MOST), corners: [DVec3::ZERO; MOST] };
        if corners.len() <= MOST {
            made.corners[..corners.len()].copy_from_slice(corners);
            return made;
        }
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let first = corners[0];
        let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
        for &c in corners {
            let at = DVec3::new(u.dot(c - first), v.dot(c - first), 0.0);
            (low, high) = (low.min(at), high.max(at));
        }
        made.len = 4;
        for (k, [x, y]) in [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]]
            .into_iter()
            .enumerate()
        {
            made.corners[k] = first + u * x + v * y;
        }
        made
    }

    #[inline]
    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.len]
    }

    /// Clips the polygon to a half-space. Returns false, and leaves the polygon undefined, where it
    /// reaches into the half-space by no more than the tolerance.
    #[inline]
    pub(super) fn clip(&mut self, normal: DVec3, d: f64, tolerance: f64) -> bool {
        let mut distances = [0.0; MOST];
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for (distance, corner) in distances.iter_mut().zip(self.corners()) {
            *distance = normal.dot(*corner) - d;
            low = low.min(*distance);
            high = high.max(*distance);
        }
        if high <= tolerance {
            return false;
        }
        if low < 0.0 {
            self.cut(&distances);
        }
        true
    }

    /// Sutherland and Hodgman, *Reentrant Polygon Clipping*, 1974.
    fn cut(&mut self, distances: &[f64; MOST]) {
        let mut out = [DVec3::ZERO; MOST];
        let mut len = 0;
        for k in 0..self.len {
            let next = if k + 1 == self.len { 0 } else { k + 1 };
            let (a, b) = (distances[k], distances[next]);
            if len + 2 > MOST {
                return;
            }
            if a >= 0.0 {
                out[len] = self.corners[k];
                len += 1;
            }
            if (a < 0.0) != (b < 0.0) && a != 0.0 && b != 0.0 {
                let (p, q) = (self.corners[k], self.corners[next]);
                out[len] = p + (q - p) * (a / (a - b));
                len += 1;
            }
        }
        (self.len, self.corners) = (len, out);
    }

    /// Clips the polygon to all of the half-spaces, as [`Self::clip`] does.
    #[inline]
    pub(super) fn clip_all(&mut self, planes: &HalfSpaces, tolerance: f64) -> bool {
        planes.all().iter().all(|p| self.clip(p.normal, p.d, tolerance))
    }

    /// The point with these weights, each 0 to 1: of a triangle of the fan about a corner, no
    /// matter how large.
    pub(super) fn point(&self, [which, u, v]: [f64; 3]) -> DVec3 {
        let triangles = self.len.saturating_sub(2).max(1);
        let k = ((which * triangles as f64) as usize).min(triangles - 1);
        let at = |k: usize| self.corners[k.min(self.len - 1)];
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let a = at(0);
        a + (at(k + 1) - a) * u + (at(k + 2) - a) * v
    }

    /// The longest line between two of its corners, from the first on.
    pub(super) fn longest(&self) -> DVec3 {
        let mut longest = DVec3::ZERO;
        for (k, &a) in self.corners().iter().enumerate() {
            for &b in &self.corners()[k + 1..] {
                if (b - a).length_squared() > longest.length_squared() {
                    longest = b - a;
                }
            }
        }
        longest
    }

    pub(super) fn centre(&self) -> DVec3 {
        self.corners().iter().sum::<DVec3>() / self.len as f64
    }
}

/// The planes through an edge of one polygon and a corner of the other that part them, the side of
/// `pass` kept: whatever a line through both meets beyond `pass` is in all of them (Teller and
/// Séquin, *Visibility Preprocessing for Interactive Walkthroughs*, 1991).
///
/// Both polygons are counter-clockwise as seen from where lines go, or both clockwise and `back`
/// true. `pass` is ahead of the plane of `source`. A plane that does not part them, for what was
/// rounded, is left out.
#[inline]
pub(super) fn separators(
    source: &Polygon,
    pass: &Polygon,
    back: bool,
    slack: f64,
    planes: &mut HalfSpaces,
) {
    planes.len = 0;
    // Each edge's plane turns about it from the corner that turns it the least.
    through_edges(source.corners(), pass.corners(), back, 1.0, slack, planes);
    through_edges(pass.corners(), source.corners(), back, -1.0, slack, planes);
}

#[inline(always)]
fn through_edges(
    edges: &[DVec3],
    others: &[DVec3],
    back: bool,
    sign: f64,
    slack: f64,
    planes: &mut HalfSpaces,
) {
    let mut last = edges[edges.len() - 1];
    let mut ways = [DVec3::ZERO; MOST];
    for &corner in edges {
        let (a, b) = if back { (corner, last) } else { (last, corner) };
        last = corner;
        let edge = b - a;
        let ways = &mut ways[..others.len()];
        ways.iter_mut().zip(others).for_each(|(way, &other)| *way = (other - a) * sign);
        let mut normal = edge.cross(ways[0]) * sign;
        for way in &ways[1..] {
            if normal.dot(*way) < 0.0 {
                normal = edge.cross(*way) * sign;
            }
        }
        let (squared, long) = (normal.length_squared(), edge.length_squared());
        // An edge or a height of next to nothing spans no plane that can be trusted.
        if long <= slack * slack || squared <= slack * slack * long {
            continue;
        }
        let size = squared.sqrt();
        let least = -slack * size;
        let parts = ways.iter().all(|&way| normal.dot(way) >= least)
            && edges.iter().all(|&o| normal.dot(a - o) * sign >= least);
        if parts {
            let normal = normal * (1.0 / size);
            planes.push(normal, normal.dot(a));
        }
    }
}
