//! Clip space: clipping on homogeneous coordinates, before the divide.
//!
//! A vertex behind the eye has w < 0, and dividing by it mirrors the vertex to the wrong side of
//! the screen: the line to it then leaves through infinity the other way. So primitives are clipped
//! while they are still homogeneous, where the clip volume −w ≤ x ≤ w, −w ≤ y ≤ w, 0 ≤ z ≤ w is a
//! convex cone and a line is a line (Blinn & Newell, *Clipping Using Homogeneous Coordinates*,
//! 1978). Everything that is left has w ≥ 0, and w > 0 but for the point where all four numbers are
//! 0.
//!
//! Three amounts of clipping: [`near`] alone, where what comes after copes with the sides;
//! [`full`]; and a [`GuardBand`], which cuts only what reaches far beyond the view. Planes carry
//! the numbers of [`FrustumPlane`], so outcodes mean the same before and after projection.

use cullet::Depth;
use cullet::view::FrustumPlane;

use super::ClipError;
use super::polygon::{Clipper, Vertex};
use super::region::{HalfSpace, Region, Scalar};

const NEAR: usize = FrustumPlane::Near as usize;
const FAR: usize = FrustumPlane::Far as usize;

/// The rows of the six planes, wider than the view by `wide` at the sides.
fn sides<T: Scalar>(depth: Depth, wide: T) -> [[T; 4]; 6] {
    let (o, i) = (T::ZERO, T::ONE);
    let (near, far) = match depth {
        Depth::Standard => ([o, o, -i, o], [o, o, i, -i]),
        Depth::Reversed => ([o, o, i, -i], [o, o, -i, o]),
    };
    [[-i, o, o, -wide], [i, o, o, -wide], [o, -i, o, -wide], [o, i, o, -wide], near, far]
}

fn region<T: Scalar>(depth: Depth, wide: T) -> Region<T, 4> {
    let mut region = Region::everything();
    for (number, row) in sides(depth, wide).into_iter().enumerate() {
        // Fails for no finite `wide`.
        if let Ok(side) = HalfSpace::new(row, T::ZERO) {
            region.set(number, side);
        }
    }
    region.cut_first(NEAR);
    region
}

/// The near plane alone, for those who clip the sides by the pixel. In a perspective view nothing
/// that is left has w ≤ 0.
#[must_use]
pub fn near<T: Scalar>(depth: Depth) -> Region<T, 4> {
    region(depth, T::ONE).only(1 << NEAR)
}

/// All six planes of the view.
#[must_use]
pub fn full<T: Scalar>(depth: Depth) -> Region<T, 4> {
    region(depth, T::ONE)
}

/// x/w, y/w and z/w; `None` where w is not above zero, for such a point has no place on the screen.
#[inline]
#[must_use]
pub fn divide<T: Scalar>(p: &[T; 4]) -> Option<[T; 3]> {
    (p[3] > T::ZERO).then(|| [p[0] / p[3], p[1] / p[3], p[2] / p[3]])
}

/// A view, and a band around it that need not be clipped because what comes after can count that
/// far.
///
/// Rejecting is by the view, cutting by the band (and by near and far, which have none): of
/// triangles that stick out of the view, few also reach the end of the band.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardBand<T> {
    band: Region<T, 4>,
    wide: T,
    depth: Depth,
}

impl<T: Scalar> GuardBand<T> {
    /// A band `wide` times as wide and high as the view; 1 is no band.
    ///
    /// # Errors
    /// [`ClipError::NoGuardBand`] if `wide` is below 1 or not finite.
    pub fn new(depth: Depth, wide: T) -> Result<Self, ClipError> {
        let w = wide.to_f64();
        if !(w >= 1.0 && w.is_finite()) {
            return Err(ClipError::NoGuardBand(w));
        }
        Ok(Self { band: region(depth, wide), wide, depth })
    }

    /// Region that primitives are cut to: the planes of the band, and near and far.
    #[must_use]
    pub fn region(&self) -> &Region<T, 4> {
        &self.band
    }

    /// The planes of the view and those of the band that a point is outside of: comparisons with
    /// ±w, no products but w times the width.
    #[inline]
    #[must_use]
    pub fn outcodes(&self, p: &[T; 4]) -> [u32; 2] {
        let [x, y, z, w] = *p;
        let g = w * self.wide;
        let bit = |outside: bool, i: usize| u32::from(outside) << i;
        let depth = match self.depth {
            Depth::Standard => bit(z < T::ZERO, NEAR) | bit(z > w, FAR),
            Depth::Reversed => bit(z > w, NEAR) | bit(z < T::ZERO, FAR),
        };
        let around = |w: T| bit(x < -w, 0) | bit(x > w, 1) | bit(y < -w, 2) | bit(y > w, 3) | depth;
        [around(w), around(g)]
    }

    /// The part of a polygon within the band; nothing where the outcodes prove that all of it is
    /// outside one plane of the view. A polygon within the band comes back as it is. See
    /// [`Clipper::clip`].
    #[inline]
    pub fn clip<'a, V: Vertex<T, 4>>(&self, clipper: &'a mut Clipper<V>, polygon: &[V]) -> &'a [V] {
        clipper.clip_coded(&self.band, polygon, |p| self.outcodes(p), |p, _| self.outcodes(p)[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcodes_are_those_of_the_regions() {
        for depth in [Depth::Standard, Depth::Reversed] {
            let guard = GuardBand::new(depth, 3.0_f32).unwrap();
            let full = full::<f32>(depth);
            for i in 0..7_i32.pow(4) {
                let p = [0, 1, 2, 3].map(|k| (i / 7_i32.pow(k) % 7 - 3) as f32 * 0.7);
                assert_eq!(guard.outcodes(&p), [full.outcode(&p), guard.band.outcode(&p)], "{p:?}");
            }
        }
    }

    #[test]
    fn a_triangle_through_the_eye_plane_keeps_what_is_in_front() {
        // The third corner is behind the eye; divided, it would lie at (−2, 2), above the other
        // two.
        let triangle = [[-1.0, -0.5, 0.5, 1.0], [1.0, -0.5, 0.5, 1.0], [2.0, -2.0, -1.5, -1.0]];
        let mut clipper = Clipper::<[f64; 4]>::new();
        let near = clipper.clip(&near(Depth::Standard), &triangle).to_vec();
        assert_eq!(near.len(), 4);
        for region in [full(Depth::Standard), GuardBand::new(Depth::Standard, 8.0).unwrap().band] {
            let cut = clipper.clip(&region, &triangle).to_vec();
            assert!(cut.len() >= 3);
            for p in cut.iter().chain(&near) {
                let [_, y, z] = divide(p).unwrap();
                assert!(y <= -0.5 && z >= -1e-15, "above the edge in front: {p:?}");
            }
        }
    }

    #[test]
    fn a_band_spares_what_sticks_out_of_the_view() {
        let guard = GuardBand::new(Depth::Reversed, 4.0_f32).unwrap();
        let mut clipper = Clipper::new();
        let out = [[0.0, 0.0, 0.5, 1.0], [3.0, 0.0, 0.5, 1.0], [0.0, 3.0, 0.5, 1.0]];
        assert_eq!(guard.clip(&mut clipper, &out), out);
        assert_eq!(clipper.clip(&full(Depth::Reversed), &out).len(), 4);
        let beside = out.map(|[x, y, z, w]| [x + 1.5, y, z, w]);
        assert_eq!(
            guard.clip(&mut clipper, &beside).len(),
            0,
            "outside of the view, though in the band"
        );
        let far_out = [[0.0, 0.0, 0.5, 1.0], [8.0, 0.0, 0.5, 1.0], [0.0, 1.0, 0.5, 1.0]];
        assert_eq!(guard.clip(&mut clipper, &far_out).len(), 4);
        assert!(GuardBand::new(Depth::Standard, 0.5).is_err());
        assert!(GuardBand::new(Depth::Standard, f64::NAN).is_err());
    }

    #[test]
    fn a_point_without_w_has_no_place() {
        assert_eq!(divide(&[1.0, 2.0, 0.5, 2.0]), Some([0.5, 1.0, 0.25]));
        for w in [0.0, -1.0, f64::NAN] {
            assert_eq!(divide(&[1.0, 2.0, 0.5, w]), None);
        }
    }
}
