//! Bounds of morphed meshes: the base shape's box, and how far each target pulls.

use cullet::bounds::Aabb;
use glam::DVec3;

use super::{DeformError, F32_LOSS, F32_UNDERFLOW};

/// A mesh with shapes to morph to: vertex v is drawn at `positionᵥ + Σ weightᵢ · targetᵢᵥ`.
#[derive(Clone, Copy, Debug)]
pub struct Morphs<'a> {
    /// Vertex positions of the base shape.
    pub positions: &'a [[f32; 3]],
    /// For each target the displacement of every vertex.
    pub targets: &'a [&'a [[f32; 3]]],
}

impl Morphs<'_> {
    pub(super) fn check(&self) -> Result<(), DeformError> {
        let vertices = self.positions.len();
        let wrong = self.targets.iter().enumerate().find(|(_, t)| t.len() != vertices);
        wrong.map_or(Ok(()), |(i, t)| {
            let what = format!("displacements of target {i}");
            Err(DeformError::Length { what, count: t.len(), vertices })
        })
    }

    /// Where every vertex is drawn under some weights: evaluated in f64, rounded at the end. The
    /// slow truth that [`MorphBounds::bounds`] is held against. Targets beyond the weights have
    /// weight 0, and weights beyond the targets do not matter.
    ///
    /// # Errors
    /// As [`MorphBounds::new`].
    pub fn pose(&self, weights: &[f32]) -> Result<Vec<[f32; 3]>, DeformError> {
        self.check()?;
        let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        let place = |(vertex, p): (usize, &[f32; 3])| {
            let pulled = self.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0);
            let sum = pulled.fold(point(*p), |sum, (t, w)| sum + point(t[vertex]) * f64::from(*w));
            sum.as_vec3().to_array()
        };
        Ok(self.positions.iter().enumerate().map(place).collect())
    }
}

/// The box of a base shape, and for each target the box of its displacements: bounds of a morphed
/// mesh for the cost of its targets, not of its vertices.
///
/// Weights may have any sign and size. The box is exact for one target that moves everything alike,
/// and looser the more targets move different places at once.
#[derive(Clone, Debug)]
pub struct MorphBounds {
    base: Aabb,
    targets: Vec<Aabb>,
}

impl MorphBounds {
    /// Takes the boxes. O(vertices × targets). A mesh without vertices has empty bounds; a position
    /// that is not finite makes all bounds [`Aabb::EVERYTHING`], a displacement those under a
    /// weight that is not 0.
    ///
    /// # Errors
    /// If a target has not one displacement for each vertex.
    pub fn new(morphs: &Morphs<'_>) -> Result<Self, DeformError> {
        morphs.check()?;
        let targets = morphs.targets.iter().map(|t| Aabb::from_points(t)).collect();
        Ok(Self { base: Aabb::from_points(morphs.positions), targets })
    }

    /// The box around the mesh under `weights`, in the mesh's space, rounded outward: it holds
    /// every vertex though the morphing be done in f32. Targets beyond the weights have weight 0,
    /// and weights beyond the targets do not matter. O(targets).
    ///
    /// [`Aabb::EVERYTHING`] where a weight is not finite.
    #[must_use]
    pub fn bounds(&self, weights: &[f32]) -> Aabb {
        if self.base.is_empty() {
            return Aabb::EMPTY;
        }
        let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        let (mut min, mut max) = (point(self.base.min), point(self.base.max));
        let mut size = min.abs().max(max.abs());
        for (target, &w) in self.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            let w = f64::from(w);
            let (a, b) = (point(target.min) * w, point(target.max) * w);
            if !(a.is_finite() && b.is_finite()) {
                return Aabb::EVERYTHING;
            }
            (min, max) = (min + a.min(b), max + a.max(b));
            size += a.abs().max(b.abs());
        }
        // Each target is one more sum, and one more rounding of all before it.
        let loss = F32_LOSS + self.targets.len() as f64 * (F32_LOSS / 16.0);
        let slack = size * loss + F32_UNDERFLOW;
        let (min, max) = (min - slack, max + slack);
        if !(min.is_finite() && max.is_finite()) {
            return Aabb::EVERYTHING;
        }
        Aabb::rounded_out(min.into(), max.into())
    }
}
