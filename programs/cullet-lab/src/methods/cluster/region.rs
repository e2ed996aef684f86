//! The culling volume of a cluster as a polyhedron.
//!
//! All eyes behind some planes form a convex region, seldom closed; inside a box it is a convex
//! polyhedron. It is what Johannsen & Carter, *Clustered Backface Culling* (1998), measure the
//! quality of a cluster by: its share of the box is the probability that an eye anywhere in the box
//! culls it. This is the slow and plain form, for pictures and as an oracle.

use cullet::cull::backface::ClusterPlanes;
use glam::DVec3;

use super::NormalBox;

/// Corners nearer to a plane than this share of the box's size lie on it: rounding must not make
/// faces of no width.
const ON_PLANE: f64 = 1e-12;

/// A face of a [`CullingRegion`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegionFace {
    /// Its corners, counter-clockwise seen from outside; numbers of [`CullingRegion::vertices`].
    pub vertices: Vec<u32>,
    /// Half-space that bounds it; `None` for a side of the box.
    pub half_space: Option<u32>,
}

/// The part of a box that lies in some half-spaces: a convex polyhedron, or nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CullingRegion {
    vertices: Vec<[f64; 3]>,
    faces: Vec<RegionFace>,
}

impl CullingRegion {
    /// The points x of the box with n·x ≤ d for every half-space (n, d); normals have any length.
    ///
    /// Empty where the half-spaces have no common volume in the box, flat ones included; where the
    /// box is empty, flat or not finite; and where a half-space is not finite, for such a one
    /// proves nothing. A normal of zero length holds everywhere or nowhere. Each half-space is
    /// tried on every corner there is by then, so the cost is O(h²) for h half-spaces that all
    /// bound the region.
    #[must_use]
    pub fn clip(
        half_spaces: impl IntoIterator<Item = ([f64; 3], f64)>,
        low: [f64; 3],
        high: [f64; 3],
    ) -> Self {
        let size = DVec3::from(high) - DVec3::from(low);
        // Written so that NaN is no box.
        if !(size.min_element() > 0.0 && size.is_finite()) {
            return Self::default();
        }
        let mut region = Self::of_box(low, high);
        let reach = DVec3::from(low).abs().max(DVec3::from(high).abs()).length();
        for (number, (n, d)) in (0..).zip(half_spaces) {
            let (n, d) = (DVec3::from(n), d);
            let length = n.length();
            if !(length.is_finite() && d.is_finite()) {
                return Self::default();
            }
            if length == 0.0 {
                if d < 0.0 {
                    return Self::default();
                }
                continue;
            }
            region.cut(n / length, d / length, reach * ON_PLANE, number);
            if region.is_empty() {
                return Self::default();
            }
        }
        region.drop_unused();
        region
    }

    /// The ideal region of a cluster: the points behind all its planes. Empty where no eye is
    /// proved behind them ([`ClusterPlanes::is_complete`]), and for a cluster without planes.
    #[must_use]
    pub fn of_planes(planes: &ClusterPlanes, low: [f64; 3], high: [f64; 3]) -> Self {
        if planes.is_empty() || !planes.is_complete() {
            return Self::default();
        }
        Self::clip(planes.half_spaces(), low, high)
    }

    /// The region that Johannsen and Carter's bound proves, up to the rounding of its test.
    #[must_use]
    pub fn of_normal_box(bound: &NormalBox, low: [f64; 3], high: [f64; 3]) -> Self {
        Self::clip(bound.half_spaces(), low, high)
    }

    /// Its corners.
    #[must_use]
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// Its faces; those of the box are among them.
    #[must_use]
    pub fn faces(&self) -> &[RegionFace] {
        &self.faces
    }

    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Its volume in cubed units, exact but for f64 rounding: the sum of its tetrahedra around a
    /// corner.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let Some(apex) = self.vertices.first().map(|v| DVec3::from(*v)) else { return 0.0 };
        let at = |v: u32| DVec3::from(self.vertices[v as usize]) - apex;
        let fan = |face: &RegionFace| -> f64 {
            let a = at(face.vertices[0]);
            face.vertices[1..].windows(2).map(|w| a.dot(at(w[0]).cross(at(w[1])))).sum()
        };
        (self.faces.iter().map(fan).sum::<f64>() / 6.0).max(0.0)
    }

    fn of_box(low: [f64; 3], high: [f64; 3]) -> Self {
        let corner =
            |i: usize| std::array::from_fn(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        // Counter-clockwise from outside; bit k of a corner says on which side of axis k it is.
        const SIDES: [[u32; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let face = |v: [u32; 4]| RegionFace { vertices: v.to_vec(), half_space: None };
        Self { vertices: (0..8).map(corner).collect(), faces: SIDES.map(face).to_vec() }
    }

    /// Takes away what is on the far side of a plane, and closes the cut.
    fn cut(&mut self, n: DVec3, d: f64, on_plane: f64, number: u32) {
        let side: Vec<f64> = self
            .vertices
            .iter()
            .map(|v| n.dot(DVec3::from(*v)) - d)
            .map(|s| if s.abs() <= on_plane { 0.0 } else { s })
            .collect();
        let used = || self.faces.iter().flat_map(|f| &f.vertices).map(|&v| side[v as usize]);
        if used().all(|s| s <= 0.0) {
            return;
        }
        if used().all(|s| s >= 0.0) {
            *self = Self::default();
            return;
        }
        let faces = std::mem::take(&mut self.faces);
        // Both faces of an edge take the same new corner, so that the solid stays closed.
        let mut cuts: Vec<([u32; 2], u32)> = Vec::new();
        let mut rim: Vec<u32> = Vec::new();
        for face in faces {
            let mut kept = Vec::with_capacity(face.vertices.len() + 1);
            for (i, &a) in face.vertices.iter().enumerate() {
                let b = face.vertices[(i + 1) % face.vertices.len()];
                let (sa, sb) = (side[a as usize], side[b as usize]);
                if sa <= 0.0 {
                    kept.push(a);
                    if sa == 0.0 {
                        rim.push(a);
                    }
                }
                if sa * sb < 0.0 {
                    let edge = [a.min(b), a.max(b)];
                    let known = cuts.iter().find(|c| c.0 == edge).map(|c| c.1);
                    let new = known.unwrap_or_else(|| {
                        let [p, q] = edge.map(|v| DVec3::from(self.vertices[v as usize]));
                        let [sp, sq] = edge.map(|v| side[v as usize]);
                        self.vertices.push(p.lerp(q, sp / (sp - sq)).into());
                        let new = self.vertices.len() as u32 - 1;
                        cuts.push((edge, new));
                        new
                    });
                    kept.push(new);
                    rim.push(new);
                }
            }
            // A face that only touches the plane from outside has no inner corner.
            let inner = |v: &u32| side.get(*v as usize).is_some_and(|s| *s < 0.0);
            if kept.len() >= 3 && kept.iter().any(inner) {
                self.faces.push(RegionFace { vertices: kept, ..face });
            }
        }
        rim.sort_unstable();
        rim.dedup();
        let at = |v: u32| DVec3::from(self.vertices[v as usize]);
        let middle = rim.iter().map(|&v| at(v)).sum::<DVec3>() / rim.len() as f64;
        let (x, y) = n.any_orthonormal_pair();
        let angle = |v: u32| (at(v) - middle).dot(y).atan2((at(v) - middle).dot(x));
        // x, y, n are right-handed, so rising angles run counter-clockwise seen along −n.
        rim.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
        if rim.len() >= 3 {
            self.faces.push(RegionFace { vertices: rim, half_space: Some(number) });
        }
    }

    /// Corners that were cut away leave the list.
    fn drop_unused(&mut self) {
        let mut new = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        for v in self.faces.iter_mut().flat_map(|f| &mut f.vertices) {
            let old = *v as usize;
            if new[old] == u32::MAX {
                new[old] = vertices.len() as u32;
                vertices.push(self.vertices[old]);
            }
            *v = new[old];
        }
        self.vertices = vertices;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LOW: [f64; 3] = [-1.0; 3];
    const HIGH: [f64; 3] = [1.0; 3];

    fn is_closed(region: &CullingRegion) -> bool {
        let mut edges = std::collections::BTreeMap::new();
        for face in region.faces() {
            let v = &face.vertices;
            for i in 0..v.len() {
                let (a, b) = (v[i], v[(i + 1) % v.len()]);
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        edges.values().all(|sum| *sum == 0)
    }

    /// The share of a grid of points that is in all half-spaces: plain and slow.
    fn volume_ref(half_spaces: &[([f64; 3], f64)]) -> f64 {
        let n = 30;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let points = (0..n * n * n).map(|i| DVec3::new(at(i % n), at(i / n % n), at(i / n / n)));
        let inside = |p: &DVec3| half_spaces.iter().all(|(m, d)| DVec3::from(*m).dot(*p) <= *d);
        points.filter(inside).count() as f64 * 8.0 / f64::from(n * n * n)
    }

    #[test]
    fn volumes_of_known_bodies() {
        let clip = |h: &[([f64; 3], f64)]| CullingRegion::clip(h.iter().copied(), LOW, HIGH);
        assert_eq!(clip(&[]).volume(), 8.0);
        assert_eq!(clip(&[([2.0, 0.0, 0.0], 0.0)]).volume(), 4.0);
        // A plane through four corners, and one that cuts a corner off.
        assert!((clip(&[([1.0, 1.0, 0.0], 0.0)]).volume() - 4.0).abs() < 1e-12);
        assert!((clip(&[([1.0, 1.0, 1.0], -2.0)]).volume() - 1.0 / 6.0).abs() < 1e-12);
        // The same plane twice, and the box's own.
        assert_eq!(clip(&[([0.0, 1.0, 0.0], 0.5); 2]).volume(), 6.0);
        assert_eq!(clip(&[([0.0, 0.0, 1.0], 1.0)]), clip(&[]));
        let octahedron: Vec<_> = (0..8)
            .map(|i| (std::array::from_fn(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 }), 1.0))
            .collect();
        let octahedron = clip(&octahedron);
        assert!((octahedron.volume() - 4.0 / 3.0).abs() < 1e-12 && is_closed(&octahedron));
        assert_eq!((octahedron.vertices().len(), octahedron.faces().len()), (6, 8));
    }

    #[test]
    fn what_has_no_volume_is_empty() {
        let x = [1.0, 0.0, 0.0];
        let clip = |h: &[([f64; 3], f64)]| CullingRegion::clip(h.iter().copied(), LOW, HIGH);
        for h in [
            vec![(x, -1.0)],
            vec![(x, 0.0), ([-1.0, 0.0, 0.0], 0.0)],
            vec![(x, f64::NAN)],
            vec![([f64::INFINITY, 0.0, 0.0], 1.0)],
            vec![([0.0; 3], -1.0)],
        ] {
            let region = clip(&h);
            assert!(region.is_empty() && region.volume() == 0.0, "{h:?}");
        }
        assert_eq!(clip(&[([0.0; 3], 0.0)]).volume(), 8.0);
        assert!(CullingRegion::clip([], HIGH, LOW).is_empty());
        assert!(CullingRegion::clip([], LOW, [1.0, f64::NAN, 1.0]).is_empty());
        assert!(CullingRegion::of_planes(&ClusterPlanes::new([]), LOW, HIGH).is_empty());
    }

    #[test]
    fn the_region_of_the_bound_is_inside_the_ideal() {
        let bent = [
            [[0.0, 0.0, 0.0], [0.3, 0.0, 0.05], [0.0, 0.3, 0.08]],
            [[0.3, 0.0, 0.05], [0.3, 0.3, -0.1], [0.0, 0.3, 0.08]],
        ];
        let planes = ClusterPlanes::new(bent);
        let bound = <NormalBox as crate::methods::cluster::Bound>::fit(&planes).unwrap();
        let ideal = CullingRegion::of_planes(&planes, LOW, HIGH);
        let inner = CullingRegion::of_normal_box(&bound, LOW, HIGH);
        assert!(inner.volume() > 1.0 && inner.volume() < ideal.volume());
        for v in inner.vertices() {
            assert!(planes.height([v[0], v[1], v[2], 1.0]) < 1e-9, "{v:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn volumes_are_those_of_a_grid(
            h in prop::collection::vec((prop::array::uniform3(-1.0..1.0f64), -0.3..1.0f64), 1..12)
        ) {
            let region = CullingRegion::clip(h.iter().copied(), LOW, HIGH);
            let (got, expected) = (region.volume(), volume_ref(&h));
            prop_assert!((got - expected).abs() < 0.25, "{got} {expected}");
            prop_assert!(is_closed(&region));
            for v in region.vertices() {
                for (n, d) in &h {
                    prop_assert!(DVec3::from(*n).dot(DVec3::from(*v)) <= d + 1e-9);
                }
            }
        }
    }
}
