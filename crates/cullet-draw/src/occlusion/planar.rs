//! Points and triangles in the image, by intervals that hold their true places.

use cullet::{Depth, Transform, View};

use super::interval::Interval;

/// A part of the image, in normalised device coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

impl Cell {
    pub(crate) fn centre(&self) -> [f64; 2] {
        [self.x, self.y].map(|r| r[0] * 0.5 + r[1] * 0.5)
    }

    pub(crate) fn quarters(&self) -> [Self; 4] {
        let [x, y] = self.centre();
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        [([x0, x], [y0, y]), ([x, x1], [y0, y]), ([x0, x], [y, y1]), ([x, x1], [y, y1])]
            .map(|(x, y)| Self { x, y })
    }

    /// Whether a rectangle may share a point with it.
    pub(crate) fn meets(&self, r: &Range) -> bool {
        r.x[0] <= self.x[1] && r.x[1] >= self.x[0] && r.y[0] <= self.y[1] && r.y[1] >= self.y[0]
    }
}

/// Bounds in the image; infinite where they are unknown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

impl Range {
    pub(crate) fn union(&self, other: &Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { x: join(self.x, other.x), y: join(self.y, other.y) }
    }
}

/// World space to clip space, z turned so that nearer is smaller.
#[derive(Clone, Debug)]
pub(crate) struct Projector {
    rows: [[Interval; 4]; 4],
    /// Range of z/w that the view shows.
    pub(crate) depth: [f64; 2],
}

impl Projector {
    pub(crate) fn new(view: &View) -> Self {
        let m = view.clip_from_world();
        let reversed = view.depth() == Depth::Reversed;
        let entry = |r: usize, c: usize| {
            let v = m[c * 4 + r];
            Interval::exactly(if reversed && r == 2 { -v } else { v })
        };
        let rows = std::array::from_fn(|r| std::array::from_fn(|c| entry(r, c)));
        Self { rows, depth: if reversed { [-1.0, 0.0] } else { [0.0, 1.0] } }
    }

    pub(crate) fn point(&self, transform: &Transform, p: [f32; 3]) -> Point {
        let p = p.map(|v| Interval::exactly(f64::from(v)));
        let linear = |c: usize, r: usize| Interval::exactly(f64::from(transform.linear[c][r]));
        let world: [Interval; 3] = std::array::from_fn(|r| {
            let turned = linear(0, r) * p[0] + linear(1, r) * p[1] + linear(2, r) * p[2];
            turned + Interval::exactly(transform.translation[r])
        });
        let row = |r: &[Interval; 4]| r[0] * world[0] + r[1] * world[1] + r[2] * world[2] + r[3];
        Point { clip: std::array::from_fn(|i| row(&self.rows[i])) }
    }
}

/// A point in clip space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) clip: [Interval; 4],
}

impl Point {
    /// Whether it is certainly in front of the eye.
    pub(crate) fn in_front(&self) -> bool {
        self.clip[3].is_positive()
    }

    /// Its place and depth in normalised device coordinates; anything where it may be beside the
    /// eye.
    pub(crate) fn ndc(&self) -> [Interval; 3] {
        let [x, y, z, w] = self.clip;
        if !self.in_front() {
            return [Interval::ALL; 3];
        }
        [x, y, z].map(|v| v.over(w))
    }

    pub(crate) fn range(&self) -> Range {
        let [x, y, _] = self.ndc();
        Range { x: [x.low, x.high], y: [y.low, y.high] }
    }
}

/// a·x + b·y + c over the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Affine([Interval; 3]);

impl Affine {
    /// All values over a part of the image. Each coordinate is used once, so no wider than need be.
    pub(crate) fn over(&self, cell: &Cell) -> Interval {
        let side = |r: [f64; 2]| Interval { low: r[0], high: r[1] };
        self.at(side(cell.x), side(cell.y))
    }

    pub(crate) fn at(&self, x: Interval, y: Interval) -> Interval {
        let [a, b, c] = self.0;
        a * x + b * y + c
    }

    pub(crate) fn at_point(&self, [x, y]: [f64; 2]) -> Interval {
        self.at(Interval::exactly(x), Interval::exactly(y))
    }
}

/// A triangle in the image, by homogeneous edge functions, so that corners behind the eye need no
/// clipping (Olano & Greer, *Triangle Scan Conversion Using 2D Homogeneous Coordinates*, 1997).
///
/// With all three edge functions positive at (x, y), (x, y, 1) is a sum of the corners' (x, y, w)
/// with positive weights: the ray meets the triangle, and in front of the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projected {
    /// Positive inside; number i is opposite to corner i.
    pub(crate) edges: [Affine; 3],
    /// Depth of its plane: z/w is affine over the image in every projection.
    pub(crate) plane: Affine,
    /// Depths of its corners, infinite where one may be beside the eye.
    pub(crate) depths: [f64; 2],
    pub(crate) range: Range,
}

impl Projected {
    /// The triangle, and whether it is counter-clockwise on the screen; `None` where that is not
    /// certain.
    pub(crate) fn new(p: &[Point; 3]) -> Option<(Self, bool)> {
        let line = |a: &Point, b: &Point| {
            let ([ax, ay, _, aw], [bx, by, _, bw]) = (a.clip, b.clip);
            [ay * bw - aw * by, aw * bx - ax * bw, ax * by - ay * bx]
        };
        let lines = [line(&p[1], &p[2]), line(&p[2], &p[0]), line(&p[0], &p[1])];
        let [x, y, _, w] = p[0].clip;
        let determinant = x * lines[0][0] + y * lines[0][1] + w * lines[0][2];
        if determinant.has_zero() {
            return None;
        }
        let ccw = determinant.is_positive();
        let edges = if ccw { lines } else { lines.map(|l| l.map(|v| -v)) };
        let size = if ccw { determinant } else { -determinant };
        let [z0, z1, z2] = [p[0].clip[2], p[1].clip[2], p[2].clip[2]];
        let term = |i: usize| (z0 * edges[0][i] + z1 * edges[1][i] + z2 * edges[2][i]).over(size);
        let plane = Affine([term(0), term(1), term(2)]);
        let d = p.each_ref().map(|p| p.ndc()[2]);
        Some((
            Self {
                edges: edges.map(Affine),
                plane,
                depths: [
                    d[0].low.min(d[1].low).min(d[2].low),
                    d[0].high.max(d[1].high).max(d[2].high),
                ],
                range: range_of(p),
            },
            ccw,
        ))
    }

    /// Whether it certainly has no point in common with a cell.
    pub(crate) fn misses(&self, cell: &Cell) -> bool {
        !cell.meets(&self.range) || self.edges.iter().any(|e| e.over(cell).high < 0.0)
    }

    /// Whether it certainly covers all of a cell.
    pub(crate) fn covers(&self, cell: &Cell) -> bool {
        self.edges.iter().all(|e| e.over(cell).low >= 0.0)
    }

    /// Whether it certainly covers a point, and not with its rim.
    pub(crate) fn holds(&self, at: [f64; 2]) -> bool {
        self.edges.iter().all(|e| e.at_point(at).is_positive())
    }

    /// Whether it certainly does not cover a point.
    pub(crate) fn leaves(&self, at: [f64; 2]) -> bool {
        self.edges.iter().any(|e| e.at_point(at).high < 0.0)
    }

    /// Bounds of its depth over its part of a cell.
    pub(crate) fn depth_over(&self, cell: &Cell) -> Interval {
        let plane = self.plane.over(cell);
        Interval { low: plane.low.max(self.depths[0]), high: plane.high.min(self.depths[1]) }
    }
}

/// Bounds of a triangle in the image.
pub(crate) fn range_of(p: &[Point; 3]) -> Range {
    p[0].range().union(&p[1].range()).union(&p[2].range())
}
