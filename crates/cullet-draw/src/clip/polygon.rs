//! Polygons cut by planes, with whatever their vertices carry.
//!
//! Sutherland & Hodgman, *Reentrant Polygon Clipping*, 1974: the polygon is cut by one plane after
//! another, each going once around it, keeping what is inside and putting a vertex where an edge
//! crosses. Two steps are added. Outcodes say which planes to cut by at all. And a cut vertex
//! inherits the side of its edge's ends where they agree, so that rounding cannot put a vertex
//! between two inside ones outside; a triangle that needs no cut by a plane and its neighbour that
//! does then still agree, bit for bit, about the edge that they share.
//!
//! **On a plane is inside.** A vertex on the plane stays, is not doubled, and where a plane only
//! touches a polygon, at a corner or along an edge, from outside, nothing is left. A polygon that
//! lies in the plane is kept whole.

use super::region::{HalfSpace, Region, Scalar};

/// A vertex: where it is, and how to interpolate it with all that goes along.
///
/// Every array of at least `D` numbers is one: the first `D` are the position, the rest attributes.
/// Where their number is known at run time only, clip triangles with three weights as attributes,
/// (1, 0, 0) to (0, 0, 1), and apply the weights that come out to what there is.
pub trait Vertex<T, const D: usize>: Copy {
    /// Position that is tested against the planes.
    fn position(&self) -> [T; D];

    /// The vertex at parameter `t` from `self` (0) to `to` (1), with its attributes.
    #[must_use]
    fn between(&self, to: &Self, t: T) -> Self;
}

impl<T: Scalar, const D: usize, const N: usize> Vertex<T, D> for [T; N] {
    #[inline]
    fn position(&self) -> [T; D] {
        const { assert!(N >= D, "a vertex has no fewer numbers than its space has dimensions") };
        std::array::from_fn(|i| self[i])
    }

    #[inline]
    fn between(&self, to: &Self, t: T) -> Self {
        std::array::from_fn(|i| self[i] + (to[i] - self[i]) * t)
    }
}

/// Cuts polygons; keeps its memory from one to the next.
///
/// It has room for 64 vertices from the first polygon on. A convex polygon of n vertices cut by k
/// planes has at most n + k, so triangles and quads allocate once against any region; larger
/// polygons do until the largest has been seen.
#[derive(Clone, Debug)]
pub struct Clipper<V> {
    from: Ring<V>,
    to: Ring<V>,
}

/// A polygon in buffers that only grow: what is beyond `len` is left over from before.
#[derive(Clone, Debug)]
struct Ring<V> {
    vertices: Vec<V>,
    codes: Vec<u32>,
    len: usize,
}

impl<V: Copy> Ring<V> {
    const EMPTY: Self = Self { vertices: Vec::new(), codes: Vec::new(), len: 0 };
    const ROOM: usize = 64;

    /// Makes room for so many vertices; `any` fills it, for safe code has no memory without a
    /// value.
    #[inline]
    fn reserve(&mut self, len: usize, any: V) {
        if self.vertices.len() < len {
            self.grow(len.max(Self::ROOM), any);
        }
    }

    #[cold]
    fn grow(&mut self, len: usize, any: V) {
        self.vertices.resize(len, any);
        self.codes.resize(len, 0);
    }

    /// There must be room.
    fn push(&mut self, vertex: V) {
        self.vertices[self.len] = vertex;
        self.len += 1;
    }

    fn get(&self) -> (&[V], &[u32]) {
        (&self.vertices[..self.len], &self.codes[..self.len])
    }
}

impl<V: Copy> Default for Clipper<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Copy> Clipper<V> {
    /// A clipper that has no memory yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { from: Ring::EMPTY, to: Ring::EMPTY }
    }

    /// The part of a polygon within a region: its vertices in the order they came in, none where
    /// nothing is left. A polygon of fewer than three vertices is nothing.
    ///
    /// A convex polygon gives a convex one. Of one that is not, parts that the cut separates stay
    /// joined by edges that run to and fro along the plane, as Sutherland & Hodgman's always do;
    /// they enclose no area, so filling is right. A vertex with a NaN position is kept, and cuts
    /// nothing; an edge longer than the largest number gives infinite vertices.
    ///
    /// Planes are taken in ascending order, in clip space the near one first: what is behind the
    /// eye is outside of many planes, and beyond them no more once it is gone. Cost: an outcode a
    /// vertex, and for every plane that some vertex is outside of, one walk around the polygon.
    pub fn clip<T: Scalar, const D: usize>(&mut self, region: &Region<T, D>, polygon: &[V]) -> &[V]
    where
        V: Vertex<T, D>,
    {
        let codes = |p: &_| [region.outcode(p); 2];
        self.clip_coded(region, polygon, codes, |p, bits| region.outcode_of(p, bits))
    }

    /// Both parts of a polygon at a plane, the inside one first, with the same vertices bit for bit
    /// where they meet. A vertex on the plane is of both; a part that only touches the plane is
    /// nothing, and a polygon that lies in it is inside. The rules are those of
    /// [`clip`](Self::clip), whose inside this is.
    pub fn split<T: Scalar, const D: usize>(
        &mut self,
        side: &HalfSpace<T, D>,
        polygon: &[V],
    ) -> [&[V]; 2]
    where
        V: Vertex<T, D>,
    {
        (self.from.len, self.to.len) = (0, 0);
        let Some(&last) = polygon.last().filter(|_| polygon.len() > 2) else { return [&[], &[]] };
        self.from.reserve(polygon.len() * 2, last);
        self.to.reserve(polygon.len() * 2, last);
        let (mut below, mut above) = (false, false);
        let mut last = (last, side.height(&last.position()));
        for &vertex in polygon {
            let height = side.height(&vertex.position());
            let (was_out, is_out) = (last.1 > T::ZERO, height > T::ZERO);
            if was_out != is_out {
                let [p, q] = if is_out { [last.0, vertex] } else { [vertex, last.0] };
                if let Some(t) = side.crossing(&p.position(), &q.position()) {
                    let cut = p.between(&q, t);
                    self.from.push(cut);
                    self.to.push(cut);
                }
            }
            if is_out {
                self.to.push(vertex);
            } else {
                self.from.push(vertex);
                if height == T::ZERO {
                    self.to.push(vertex);
                }
            }
            below |= !is_out && height != T::ZERO;
            above |= is_out;
            last = (vertex, height);
        }
        if !above || self.to.len < 3 {
            self.to.len = 0;
        }
        if (above && !below) || self.from.len < 3 {
            self.from.len = 0;
        }
        [self.from.get().0, self.to.get().0]
    }

    /// [`clip`](Self::clip) by the outcodes of the caller: those by which all may be rejected at
    /// once, and those of the region; `recode` gives the latter of a cut vertex, at least the
    /// requested bits.
    #[inline]
    pub(super) fn clip_coded<T: Scalar, const D: usize>(
        &mut self,
        region: &Region<T, D>,
        polygon: &[V],
        codes: impl Fn(&[T; D]) -> [u32; 2],
        recode: impl Fn(&[T; D], u32) -> u32,
    ) -> &[V]
    where
        V: Vertex<T, D>,
    {
        self.from.len = 0;
        if polygon.len() < 3 {
            return &[];
        }
        self.from.reserve(polygon.len(), polygon[0]);
        let (mut or, mut and) = (0, u32::MAX);
        let to = self.from.vertices.iter_mut().zip(&mut self.from.codes);
        for ((to, to_code), vertex) in to.zip(polygon) {
            let [rejecting, code] = codes(&vertex.position());
            (*to, *to_code) = (*vertex, code);
            and &= rejecting;
            or |= code;
        }
        if and != 0 {
            return &[];
        }
        self.from.len = polygon.len();
        let first = region.first();
        for mut left in [or & first, or & !first] {
            while left != 0 {
                self.cut(region, left.trailing_zeros() as usize, &recode);
                left &= left - 1;
            }
        }
        self.from.get().0
    }

    /// Cuts what there is by one plane.
    #[inline]
    fn cut<T: Scalar, const D: usize>(
        &mut self,
        region: &Region<T, D>,
        number: usize,
        recode: &impl Fn(&[T; D], u32) -> u32,
    ) where
        V: Vertex<T, D>,
    {
        let (side, bit) = (region.side(number), 1_u32 << number);
        let (vertices, codes) = self.from.get();
        let (mut or, mut and) = (0, bit);
        for code in codes {
            or |= code;
            and &= code;
        }
        if or & bit == 0 {
            return;
        }
        let mut len = 0;
        if and == 0 {
            // At most a crossing and itself for each vertex.
            self.to.reserve(vertices.len() * 2, vertices[0]);
            let (to, to_codes) = (&mut self.to.vertices[..], &mut self.to.codes[..]);
            let mut crossings = 0;
            let mut last = vertices.len() - 1;
            for i in 0..vertices.len() {
                if (codes[i] ^ codes[last]) & bit != 0 {
                    let [p, q] = if codes[i] & bit == 0 { [i, last] } else { [last, i] };
                    let ends = [vertices[p].position(), vertices[q].position()];
                    if let Some(t) = side.crossing(&ends[0], &ends[1]) {
                        let cut = vertices[p].between(&vertices[q], t);
                        let mut code = codes[p] & codes[q];
                        let differ = (codes[p] ^ codes[q]) & !bit;
                        if differ != 0 {
                            code |= recode(&cut.position(), differ) & differ;
                        }
                        (to[len], to_codes[len]) = (cut, code);
                        len += 1;
                        crossings += 1;
                    }
                }
                // Written whether it stays or not: no branch to guess.
                (to[len], to_codes[len]) = (vertices[i], codes[i]);
                len += usize::from(codes[i] & bit == 0);
                last = i;
            }
            // Without a crossing all that is left may be on the plane: a touch from outside.
            let touches =
                crossings == 0 && to[..len].iter().all(|v| side.height(&v.position()) >= T::ZERO);
            if touches || len < 3 {
                len = 0;
            }
        }
        self.to.len = len;
        std::mem::swap(&mut self.from, &mut self.to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::oracles::clip::clip_polygon_ref;

    fn left_of(x: f64) -> Region<f64, 2> {
        Region::new([HalfSpace::new([1.0, 0.0], x).unwrap()]).unwrap()
    }

    #[test]
    fn a_triangle_loses_its_corner_and_keeps_its_attributes() {
        let mut clipper = Clipper::new();
        let triangle = [[0.0, 0.0, 10.0], [4.0, 0.0, 50.0], [0.0, 4.0, 10.0]];
        let cut = clipper.clip(&left_of(1.0), &triangle);
        assert_eq!(cut, [[0.0, 0.0, 10.0], [1.0, 0.0, 20.0], [1.0, 3.0, 20.0], [0.0, 4.0, 10.0]]);
    }

    #[test]
    fn on_the_plane_is_inside_and_a_touch_is_nothing() {
        let mut clipper = Clipper::new();
        // A corner, and an edge, on the plane x = 1.
        let square = [[-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [-1.0, 2.0]];
        assert_eq!(clipper.clip(&left_of(1.0), &square), square);
        assert_eq!(clipper.clip(&left_of(-1.0), &square), [] as [[f64; 2]; 0]);
        let corner = [[1.0, 0.0], [2.0, -1.0], [2.0, 1.0]];
        assert_eq!(clipper.clip(&left_of(1.0), &corner), [] as [[f64; 2]; 0]);
        // A vertex on the plane between two that the plane parts is not doubled.
        let through = [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let kept = clipper.clip(&left_of(1.0), &through);
        assert_eq!(kept, [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]]);
        // All of it on the plane.
        let wall = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]];
        let region = Region::new([HalfSpace::new([1.0, 0.0, 0.0], 1.0).unwrap()]).unwrap();
        assert_eq!(Clipper::new().clip(&region, &wall), wall);
        assert_eq!(clip_polygon_ref(&region.planes(), &wall), wall);
    }

    #[test]
    fn both_parts_meet_and_what_touches_is_of_one() {
        let at = HalfSpace::new([1.0, 0.0], 1.0).unwrap();
        let mut clipper = Clipper::new();
        let triangle = [[0.0, 0.0, 10.0], [4.0, 0.0, 50.0], [0.0, 4.0, 10.0]];
        let [inside, outside] = clipper.split(&at, &triangle);
        assert_eq!(
            inside,
            [[0.0, 0.0, 10.0], [1.0, 0.0, 20.0], [1.0, 3.0, 20.0], [0.0, 4.0, 10.0]]
        );
        assert_eq!(outside, [[1.0, 0.0, 20.0], [4.0, 0.0, 50.0], [1.0, 3.0, 20.0]]);
        // An edge on the plane, from either side, and all of it on the plane.
        let left = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let right = [[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
        let on = [[1.0, 0.0], [1.0, 2.0], [1.0, 1.0]];
        let mut clipper = Clipper::<[f64; 2]>::new();
        let none: [[f64; 2]; 0] = [];
        assert_eq!(clipper.split(&at, &left), [&left[..], &none]);
        assert_eq!(clipper.split(&at, &right), [&none[..], &right]);
        assert_eq!(clipper.split(&at, &on), [&on[..], &none]);
        assert_eq!(clipper.split(&at, &left[..2]), [&none[..], &none]);
        let broken = [[f64::NAN, 0.0], [0.0, 0.0], [0.0, 1.0]];
        assert_eq!(clipper.split(&at, &broken)[0].len(), 3);
        // Through a vertex: it is of both.
        let square = [[0.0, 0.0], [1.0, -1.0], [2.0, 0.0], [1.0, 1.0]];
        let [inside, outside] = clipper.split(&at, &square);
        assert_eq!((inside.len(), outside.len()), (3, 3));
    }

    #[test]
    fn what_is_not_a_number_is_kept() {
        let mut clipper = Clipper::new();
        let broken = [[f64::NAN, 0.0], [0.0, 0.0], [0.0, 1.0]];
        assert_eq!(clipper.clip(&left_of(1.0), &broken).len(), 3);
        assert_eq!(clipper.clip(&left_of(1.0), &broken[..2]).len(), 0);
        assert_eq!(clipper.clip(&left_of(1.0), &[]).len(), 0);
    }
}
