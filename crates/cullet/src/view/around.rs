//! One frustum around several.

use super::frustum::Frustum;
use crate::bounds::{Plane, ROUNDING};

impl Frustum {
    /// A frustum of at most six planes that holds all of `frusta`: what two eyes, or a ring of cameras, see
    /// between them. Of the planes of one kind (left, near, ...) it takes the one that has to be moved out
    /// least to hold the others; a plane that would have to be moved without end is left out, and so is
    /// every plane where a frustum has no [`corners`](Self::corners). Of no frusta: everything.
    #[must_use]
    pub fn around(frusta: &[Self]) -> Self {
        let mut around = Self::everything();
        let corners: Option<Vec<_>> = frusta.iter().map(Self::corners).collect();
        let Some(corners) = corners else { return around };
        for kind in 0..6 {
            let candidates = frusta.iter().filter_map(|f| f.planes().find(|p| p.0 == kind));
            let moved = candidates.filter_map(|(_, plane)| {
                let plane = plane.normalized()?;
                let d = corners.iter().flatten().try_fold(plane.d, |d, corner| {
                    let along = |c: &[f64; 4]| (0..3).map(|a| plane.normal[a] * c[a]).sum::<f64>();
                    let reach: f64 = (0..3).map(|a| (plane.normal[a] * corner[a]).abs()).sum();
                    match corner[3] {
                        // A direction: the plane must not face it. Its own far edge runs along it.
                        0.0 if along(corner) > reach * ROUNDING => None,
                        0.0 => Some(d),
                        // Corners are rounded: some units of what was summed are given away.
                        _ => Some(d.max(along(corner) + reach * ROUNDING)),
                    }
                })?;
                Some((d - plane.d, Plane { d, ..plane }))
            });
            let least = moved.min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, plane)) = least.filter(|p| p.1.d.is_finite()) {
                around.set(kind, plane);
            }
        }
        around
    }
}
