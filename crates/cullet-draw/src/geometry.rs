//! Coverage and depth of a triangle at a sample: the definitions that the tiled renderer and its
//! slow twin share, so that they agree bit for bit.
//!
//! A triangle is drawn by the edge functions of its homogeneous corners (Olano & Greer, *Triangle
//! Scan Conversion Using 2D Homogeneous Coordinates*, 1997). Nothing is clipped and no vertex is
//! divided by w or snapped, so no edge ever moves, also where corners lie behind the eye.

use cullet::{
    Depth, Transform, View,
    view::{CullFace, FrontFace},
};

/// A point in clip space, its z already turned so that nearer is smaller (see [`Lens`]).
pub(crate) type Clip = [f64; 4];

/// A view as the renderer needs it.
#[derive(Clone, Debug)]
pub(crate) struct Lens {
    /// Rows of world to clip space. The row of z is negated in a reversed view, so that a smaller
    /// z/w is nearer in every view.
    pub(crate) rows: [[f64; 4]; 4],
    /// Range of z/w that is drawn: 0..1, or −1..0 in a reversed view.
    pub(crate) range: [f64; 2],
    /// Whether z was negated.
    reversed: bool,
    /// Whether lines of sight are parallel.
    pub(crate) parallel: bool,
    /// Whether a triangle that is counter-clockwise on the screen is seen from behind, by the view
    /// alone.
    flipped: bool,
    cull_face: CullFace,
    pub(crate) layers: u32,
}

impl Lens {
    pub(crate) fn new(view: &View) -> Self {
        let m = view.clip_from_world();
        let mut rows: [[f64; 4]; 4] =
            std::array::from_fn(|r| std::array::from_fn(|c| m[c * 4 + r]));
        let reversed = view.depth() == Depth::Reversed;
        if reversed {
            rows[2] = rows[2].map(|v| -v);
        }
        Self {
            rows,
            range: if reversed { [-1.0, 0.0] } else { [0.0, 1.0] },
            reversed,
            parallel: view.is_orthographic(),
            flipped: view.is_mirrored() != (view.front_face == FrontFace::Clockwise),
            cull_face: view.cull_face,
            layers: view.layers,
        }
    }

    /// A point of the world in clip space.
    pub(crate) fn clip(&self, [x, y, z]: [f64; 3]) -> Clip {
        self.rows.map(|r| r[0] * x + r[1] * y + r[2] * z + r[3])
    }

    /// The depth in NDC of an inner depth; the far value for the infinity of an empty pixel.
    pub(crate) fn ndc_depth(&self, inner: f64) -> f64 {
        match (self.reversed, inner.is_finite()) {
            (false, true) => inner,
            (false, false) => 1.0,
            // Adding zero turns −0 into 0.
            (true, true) => -inner + 0.0,
            (true, false) => 0.0,
        }
    }

    /// The view's matrix times that of a transform, in f64.
    pub(crate) fn object(&self, transform: &Transform) -> ObjectLens {
        let m = transform.to_matrix();
        let row = |r: [f64; 4]| {
            let dot = |c: usize| {
                r[0] * m[c * 4] + r[1] * m[c * 4 + 1] + r[2] * m[c * 4 + 2] + r[3] * m[c * 4 + 3]
            };
            [dot(0), dot(1), dot(2), dot(3)]
        };
        ObjectLens {
            rows: self.rows.map(row),
            flipped: self.flipped != (transform.determinant() < 0.0),
            cull_face: self.cull_face,
        }
    }
}

/// Object space to clip space, and which side of a surface this view and this instance show.
#[derive(Clone, Debug)]
pub(crate) struct ObjectLens {
    pub(crate) rows: [[f64; 4]; 4],
    flipped: bool,
    cull_face: CullFace,
}

impl ObjectLens {
    /// A vertex in clip space.
    #[inline]
    pub(crate) fn clip(&self, p: [f32; 3]) -> Clip {
        let [x, y, z] = p.map(f64::from);
        self.rows.map(|r| r[0] * x + r[1] * y + r[2] * z + r[3])
    }

    /// Whether a triangle that is counter-clockwise on the screen, or not, shows its front.
    #[inline]
    pub(crate) fn is_front(&self, counter_clockwise: bool) -> bool {
        counter_clockwise != self.flipped
    }

    /// Whether a triangle of a part with this sidedness is drawn.
    #[inline]
    pub(crate) fn draws(&self, counter_clockwise: bool, two_sided: bool) -> bool {
        two_sided
            || match self.cull_face {
                CullFace::None => true,
                CullFace::Back => self.is_front(counter_clockwise),
                CullFace::Front => !self.is_front(counter_clockwise),
            }
    }
}

/// Whether a transform maps space to a line or a point: nothing under it has an area. Exact,
/// because a product of two f32 numbers is exact in f64.
pub(crate) fn is_flat(transform: &Transform) -> bool {
    let [x, y, z] = transform.linear.map(|c| c.map(f64::from));
    [(x, y), (y, z), (z, x)].into_iter().all(|(a, b)| cross(a, b) == [0.0; 3])
}

/// Whether a triangle has an area in object space: false for repeated corners, and where the cross
/// product of its sides is exactly zero in f64.
#[inline]
pub(crate) fn has_area(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (u, v) = (sub(b, a), sub(c, a));
    cross(u, v) != [0.0; 3]
}

/// A triangle ready to be tested at samples.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// Edge function i at a sample (X, Y) is x·X + (y·Y + w): positive inside. It belongs to the
    /// edge opposite to corner i.
    pub(crate) edges: [[f64; 3]; 3],
    /// The least value of each edge function that counts as inside: 0 where the edge is a top or a
    /// left one and so owns the samples exactly on it, else the smallest number above 0.
    pub(crate) least: [f64; 3],
    /// z and w of the corners.
    pub(crate) z: [f64; 3],
    /// See `z`.
    pub(crate) w: [f64; 3],
}

/// The smallest f64 above zero.
const ABOVE_ZERO: f64 = f64::from_bits(1);

impl Surface {
    /// The surface between three points, and whether it is counter-clockwise on the screen; `None`
    /// where the eye sees it edge-on, or a coordinate is not finite.
    #[inline]
    pub(crate) fn new(corners: [Clip; 3]) -> Option<(Self, bool)> {
        // One order of corners for a triangle, however it is wound and wherever it starts:
        // neighbours then evaluate a shared edge alike, and duplicates tie in depth, bit for bit.
        let [mut a, mut b, mut c] = corners;
        let mut even = true;
        let mut sort = |p: &mut Clip, q: &mut Clip| {
            if *q < *p {
                std::mem::swap(p, q);
                even = !even;
            }
        };
        sort(&mut a, &mut b);
        sort(&mut b, &mut c);
        sort(&mut a, &mut b);
        let [bc, ac, ab] = [edge(&b, &c), edge(&a, &c), edge(&a, &b)];
        // The 3×3 determinant of (x, y, w): its sign is the winding on the screen, for any signs of
        // w.
        let determinant = a[0] * bc[0] + a[1] * bc[1] + a[3] * bc[2];
        // NaN and infinity end here too.
        if !(determinant.abs() > 0.0 && determinant.is_finite()) {
            return None;
        }
        let positive = determinant > 0.0;
        let negated = |e: [f64; 3]| e.map(|v| -v);
        // Negation is exact, so both triangles of an edge see one value with opposite signs.
        let edges = if positive { [bc, negated(ac), ab] } else { [negated(bc), ac, negated(ab)] };
        let least = edges.map(|e| {
            // Inside lies towards (x, y). A left edge has its inside to the right; a top edge is
            // level and has its inside below.
            let owns = e[0] > 0.0 || (e[0] == 0.0 && e[1] < 0.0);
            if owns { 0.0 } else { ABOVE_ZERO }
        });
        let surface = Self { edges, least, z: [a[2], b[2], c[2]], w: [a[3], b[3], c[3]] };
        Some((surface, positive == even))
    }

    /// The edge functions at a sample.
    #[inline]
    pub(crate) fn at(&self, x: f64, y: f64) -> [f64; 3] {
        self.edges.map(|e| e[0] * x + (e[1] * y + e[2]))
    }

    /// Whether a sample with these edge functions is covered.
    #[inline]
    pub(crate) fn covers(&self, e: [f64; 3]) -> bool {
        e[0] >= self.least[0] && e[1] >= self.least[1] && e[2] >= self.least[2]
    }

    /// The depth z/w at a sample with these edge functions. They are the weights of the corners,
    /// none negative where the sample is covered, so the depth stays between those of corners in
    /// front of the eye.
    #[inline]
    pub(crate) fn depth(&self, e: [f64; 3]) -> f64 {
        (e[0] * self.z[0] + e[1] * self.z[1] + e[2] * self.z[2])
            / (e[0] * self.w[0] + e[1] * self.w[1] + e[2] * self.w[2])
    }

    /// Whether no sample within these bounds is covered. Exact: floating-point rounding is
    /// monotone, so an edge function is largest at one corner of the bounds as computed, too.
    #[inline]
    pub(crate) fn misses(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        self.edges.iter().zip(self.least).any(|(e, least)| {
            let x = if e[0] > 0.0 { high[0] } else { low[0] };
            let y = if e[1] > 0.0 { high[1] } else { low[1] };
            e[0] * x + (e[1] * y + e[2]) < least
        })
    }

    /// A depth that no covered sample is nearer than; −∞ where a corner is not in front of the eye.
    #[inline]
    pub(crate) fn nearest(&self) -> f64 {
        if !self.w.iter().all(|&w| w > 0.0) {
            return f64::NEG_INFINITY;
        }
        // A weighted mean of the corners' depths, as computed, may lie outside of their range by a
        // few units of 1.1e-16 of the largest.
        let d: [f64; 3] = std::array::from_fn(|i| self.z[i] / self.w[i]);
        let size = d[0].abs().max(d[1].abs()).max(d[2].abs());
        d[0].min(d[1]).min(d[2]) - 1e-14 * size
    }
}

/// The cross product of two points in (x, y, w): the line through them. Swapping the points negates
/// it exactly.
#[inline]
fn edge(a: &Clip, b: &Clip) -> [f64; 3] {
    [a[1] * b[3] - a[3] * b[1], a[3] * b[0] - a[0] * b[3], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_of_neighbours_cancel_exactly() {
        let [a, b] = [[0.1, 0.7, 0.3, 1.9], [-0.4, 0.23, 0.9, 3.1]];
        let [c, d] = [[1.3, -0.6, 0.2, 0.7], [-2.0, 0.9, 0.1, 1.1]];
        let (s, _) = Surface::new([a, b, c]).unwrap();
        let (t, _) = Surface::new([b, a, d]).unwrap();
        let negated = |e: [f64; 3]| e.map(|v| -v);
        assert!(s.edges.iter().any(|e| t.edges.iter().any(|f| *e == negated(*f))));
    }

    #[test]
    fn order_of_corners_changes_the_winding_alone() {
        let [a, b, c] = [[0.0, 0.0, 0.1, 1.0], [1.0, 0.0, 0.2, 1.0], [0.0, 1.0, 0.3, 2.0]];
        let (first, ccw) = Surface::new([a, b, c]).unwrap();
        assert!(ccw);
        for (corners, winding) in
            [([b, c, a], true), ([c, a, b], true), ([b, a, c], false), ([c, b, a], false)]
        {
            let (s, ccw) = Surface::new(corners).unwrap();
            assert_eq!((s.edges, s.z, ccw), (first.edges, first.z, winding));
        }
    }

    #[test]
    fn edge_on_and_non_finite_are_nothing() {
        let a = [0.0, 0.0, 0.0, 1.0];
        assert!(Surface::new([a, [1.0, 1.0, 0.0, 1.0], [2.0, 2.0, 0.0, 1.0]]).is_none());
        assert!(Surface::new([a, [1.0, f64::NAN, 0.0, 1.0], [2.0, 0.0, 0.0, 1.0]]).is_none());
        assert!(Surface::new([a, [1.0, f64::INFINITY, 0.0, 1.0], [2.0, 0.0, 0.0, 1.0]]).is_none());
    }

    #[test]
    fn flat_transforms_have_rank_one_or_none() {
        let flat = |linear| is_flat(&Transform { linear, translation: [0.0; 3] });
        assert!(flat([[0.0; 3]; 3]));
        assert!(flat([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0; 3]]));
        assert!(!flat([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]));
        assert!(!flat(Transform::IDENTITY.linear));
    }
}
