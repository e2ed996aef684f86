//! Positions of the vertices of a file: exact where they are far from zero, and refused only where a
//! face uses one that is not finite.

use crate::blocks::push;
use crate::builder::Builder;
use crate::polygon::Triangulator;

/// Distance from zero from which coordinates are kept in f64: f32 has steps of 1/64 there. National
/// grids and the globe are beyond it, in metres.
pub(crate) const FAR: f64 = 131_072.0;

/// Vertices looked at for an origin, at most.
const SAMPLE: usize = 1024;

/// A vertex with a coordinate that is not finite in 32 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotFinite {
    pub(crate) vertex: u32,
    pub(crate) axis: usize,
    pub(crate) value: f32,
    /// Where the vertex stands in the file.
    pub(crate) at: u64,
}

/// The positions of a file's vertices, in its order.
#[derive(Debug, Default)]
pub(crate) struct Positions {
    near: Vec<[f32; 3]>,
    /// All of them instead of `near`, once one is far from zero.
    far: Vec<[f64; 3]>,
    /// In the order of their vertices. They stand as zeros in the list.
    not_finite: Vec<NotFinite>,
}

impl Positions {
    pub(crate) fn with_capacity(vertices: usize) -> Self {
        Self { near: Vec::with_capacity(vertices), ..Self::default() }
    }

    pub(crate) fn len(&self) -> usize {
        self.near.len() + self.far.len()
    }

    /// Appends a vertex that stands at a place of the file.
    #[inline]
    pub(crate) fn push(&mut self, position: [f64; 3], at: u64) {
        let small = position.map(|v| v as f32);
        let is_near = |v: f64| v.abs() < FAR;
        if self.far.is_empty() && position.iter().all(|&v| is_near(v)) {
            push(&mut self.near, small);
        } else {
            self.push_far(position, small, at);
        }
    }

    #[cold]
    fn push_far(&mut self, position: [f64; 3], small: [f32; 3], at: u64) {
        let bad = small.iter().position(|v| !v.is_finite());
        if let Some(axis) = bad {
            let vertex = self.len() as u32;
            push(&mut self.not_finite, NotFinite { vertex, axis, value: small[axis], at });
        } else if self.far.is_empty() {
            self.far = std::mem::take(&mut self.near).iter().map(|p| p.map(f64::from)).collect();
        }
        match bad {
            None => push(&mut self.far, position),
            Some(_) if self.far.is_empty() => push(&mut self.near, [0.0; 3]),
            Some(_) => push(&mut self.far, [0.0; 3]),
        }
    }

    /// Cuts a polygon into triangles.
    #[inline]
    pub(crate) fn cut(&self, by: &mut Triangulator, polygon: &[u32], out: &mut Vec<u32>) {
        if self.far.is_empty() {
            by.push(polygon, &self.near, out);
        } else {
            by.push(polygon, &self.far, out);
        }
    }

    /// The first of `used` that is not finite.
    pub(crate) fn first_bad(&self, used: &[u32]) -> Option<NotFinite> {
        let find = |v: &u32| {
            let found = self.not_finite.binary_search_by_key(v, |bad| bad.vertex);
            found.ok().map(|i| self.not_finite[i])
        };
        used.iter().filter(|_| !self.not_finite.is_empty()).find_map(find)
    }

    /// The positions from an origin, and the origin: whole numbers, and 0 along each axis whose
    /// coordinates are near zero. Whatever is not finite is used by no face and warned of.
    pub(crate) fn finish(self, builder: &mut Builder<'_>) -> ([f64; 3], Vec<[f32; 3]>) {
        let Self { mut near, far, not_finite } = self;
        if let Some(first) = not_finite.first() {
            let (count, vertex) = (not_finite.len(), first.vertex);
            let message = format!(
                "{count} vertices that no face uses are not finite, the first of them number {vertex} \
                 (from 0)"
            );
            builder.warn("file", message);
        }
        if far.is_empty() {
            near.shrink_to_fit();
            return ([0.0; 3], near);
        }
        // The median: a few vertices astray do not move it.
        let step = far.len().div_ceil(SAMPLE);
        let origin = std::array::from_fn(|axis| {
            let mut sample: Vec<f64> = far.iter().step_by(step).map(|p| p[axis]).collect();
            sample.sort_unstable_by(f64::total_cmp);
            let origin = sample[sample.len() / 2].round();
            // From there all must fit f32, too.
            let fits = far.iter().all(|p| ((p[axis] - origin) as f32).is_finite());
            if origin.abs() < FAR || !fits { 0.0 } else { origin }
        });
        let from_there = |p: &[f64; 3]| std::array::from_fn(|axis| (p[axis] - origin[axis]) as f32);
        (origin, far.iter().map(from_there).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LoadOptions;

    fn finish(list: &[[f64; 3]]) -> ([f64; 3], Vec<[f32; 3]>) {
        let mut positions = Positions::default();
        for (at, &p) in list.iter().enumerate() {
            positions.push(p, at as u64);
        }
        assert_eq!(positions.len(), list.len());
        positions.finish(&mut Builder::new("", &LoadOptions::default()))
    }

    #[test]
    fn what_is_near_stays_as_it_is() {
        let (origin, positions) = finish(&[[0.1, -131_071.99, 3.0], [1e-40, 0.0, 7.7]]);
        assert_eq!(origin, [0.0; 3]);
        assert_eq!(positions, [[0.1, -131_071.99, 3.0], [1e-40, 0.0, 7.7]]);
    }

    #[test]
    fn what_is_far_is_exact_from_an_origin() {
        let list = [[5.0, 0.5, 0.0], [500_000.01, 0.5, 0.0], [500_000.02, 0.25, 4e6 + 0.001]];
        let (origin, positions) = finish(&list);
        assert_eq!(origin, [500_000.0, 0.0, 0.0]);
        for (p, wanted) in positions.iter().zip(list) {
            for axis in 0..3 {
                let found = origin[axis] + f64::from(p[axis]);
                assert!(
                    (found - wanted[axis]).abs() <= wanted[axis].abs() / 1e7 && axis > 0
                        || (found - wanted[axis]).abs() < 0.02
                );
            }
        }
        assert!((f64::from(positions[1][0]) - 0.01).abs() < 1e-9);
    }

    #[test]
    fn what_fits_f32_from_zero_alone_stays_there() {
        let (origin, positions) = finish(&[[3e38, 0.0, 2e6], [-3e38, 0.0, 2e6], [3e38, 0.0, 2e6]]);
        assert_eq!(origin, [0.0, 0.0, 2e6]);
        assert_eq!(positions[1], [-3e38, 0.0, 0.0]);
    }

    #[test]
    fn a_vertex_that_is_not_finite_is_found_where_it_is_used() {
        let mut positions = Positions::default();
        positions.push([0.0, f64::NAN, 0.0], 7);
        positions.push([1.0, 2.0, 3.0], 8);
        positions.push([1.0, 2.0, 1e39], 9);
        positions.push([1e6, 2.0, 3.0], 10);
        positions.push([f64::INFINITY, 2.0, 3.0], 11);
        assert_eq!(positions.first_bad(&[1, 3]), None);
        let bad = positions.first_bad(&[1, 2, 0]).expect("2 is not finite");
        assert_eq!((bad.vertex, bad.axis, bad.at), (2, 2, 9));
        assert_eq!(positions.first_bad(&[4]).map(|b| b.at), Some(11));
        assert_eq!(positions.len(), 5);
    }
}
