//! Masks for k × k sectors of a frustum: lines of sight that differ less, so more classes culled.
//!
//! The scene is taken sector by sector (Zhang & Hoff, 1997, section 4): what lies in several
//! sectors is back-facing only where it is in all of them.

use cullet::bounds::Sphere;
use cullet::view::FrustumPlane;
use cullet::{Simd, view::Frustum};
use cullet_mesh::{BackfaceMask, MaskGrid, ViewCone};
use glam::{DMat3, DVec3};
use thiserror::Error;

/// Why a mask of corner directions cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SectorError {
    /// The corner directions of a frustum say nothing about what lies outside of it, and shadow and
    /// reflection views draw what lies outside of the camera's.
    #[error("corner directions serve camera views alone; use a cone for shadows and reflections")]
    NotACameraView,
    /// There are no sectors, or the frustum has not four sides that meet in an eye.
    #[error("the view has no four lines of sight at its corners")]
    NoCorners,
}

/// View whose triangles a mask is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaskUse {
    /// A camera: what is outside of its frustum is not seen.
    Camera,
    /// A shadow or reflection view of the same triangles.
    ShadowOrReflection,
}

/// The mask of what a camera's frustum sees, by its four corner directions: tighter than its cone,
/// and right only for triangles that are not wholly outside of the frustum.
///
/// # Errors
/// If the view is no camera's, or its sides do not meet in four lines of sight.
pub fn mask_of_corners(
    grid: &MaskGrid,
    simd: Simd,
    directions: &[[f64; 3]; 4],
    purpose: MaskUse,
) -> Result<BackfaceMask, SectorError> {
    if purpose != MaskUse::Camera {
        return Err(SectorError::NotACameraView);
    }
    let [a, b, c, d] = directions.map(|d| Some(grid.mask(simd, Some(&ViewCone::parallel(d)?))));
    let all = || Some(a?.and(&b?).and(&c?).and(&d?));
    all().ok_or(SectorError::NoCorners)
}

/// The directions of the four edges of a frustum, from the eye outward, in the order of a walk
/// around it; `None` for parallel sides.
#[must_use]
pub fn corner_directions(frustum: &Frustum) -> Option<[[f64; 3]; 4]> {
    let side = |p| frustum.plane(p).map(|p| DVec3::from(p.normal));
    let (l, r) = (side(FrustumPlane::Left)?, side(FrustumPlane::Right)?);
    let (b, t) = (side(FrustumPlane::Bottom)?, side(FrustumPlane::Top)?);
    let near = side(FrustumPlane::Near)?;
    let edge = |p: DVec3, q: DVec3| {
        // The near plane's normal points back to the eye.
        let d = p.cross(q).try_normalize()?;
        Some(if d.dot(near) > 0.0 { (-d).into() } else { d.into() })
    };
    // Opposite sides that are parallel meet nowhere.
    (l.cross(r).length() > 1e-12 && b.cross(t).length() > 1e-12).then_some(())?;
    Some([edge(l, b)?, edge(b, r)?, edge(r, t)?, edge(t, l)?])
}

/// The masks of the sectors of one camera view.
#[derive(Clone, Debug)]
pub struct SectorMasks {
    k: usize,
    /// Row by row from the first corner.
    masks: Vec<BackfaceMask>,
    /// Unit normals of the k + 1 planes between columns and between rows, towards the next.
    walls: [Vec<DVec3>; 2],
}

/// The masks of k × k sectors of the frustum whose corner directions are given, as
/// [`corner_directions`] has them. Cost: k² times
/// [`mask_of_corners`].
///
/// # Errors
/// If the view is no camera's, k is 0, or the directions are not those of the corners of a
/// parallelogram, in the order of a walk around it.
pub fn mask_of_sectors(
    grid: &MaskGrid,
    simd: Simd,
    directions: &[[f64; 3]; 4],
    k: usize,
    purpose: MaskUse,
) -> Result<SectorMasks, SectorError> {
    if purpose != MaskUse::Camera {
        return Err(SectorError::NotACameraView);
    }
    let [a, b, c, d] = directions.map(DVec3::from);
    // The corners of a parallelogram across the view: a − b + c = d once each is scaled.
    let scale = DMat3::from_cols(a, -b, c).inverse() * d;
    if k == 0 || !(scale.min_element() > 0.0 && scale.is_finite()) {
        return Err(SectorError::NoCorners);
    }
    let (a, b) = (a * scale.x, b * scale.y);
    let part = |i: usize| i as f64 / k as f64;
    let at = |column: usize, row: usize| a + (b - a) * part(column) + (d - a) * part(row);
    let mut masks = Vec::with_capacity(k * k);
    for row in 0..k {
        for column in 0..k {
            let corners =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| at(column + x, row + y).to_array());
            masks.push(mask_of_corners(grid, simd, &corners, purpose)?);
        }
    }
    // Towards the next wall, whichever way the walk goes.
    let wall = |p: DVec3, q: DVec3, next: DVec3| {
        let n = p.cross(q).normalize();
        if n.dot(next) < 0.0 { -n } else { n }
    };
    let (across, up) = (b - a, d - a);
    let columns = (0..=k).map(|i| wall(at(i, 0), at(i, k), across)).collect();
    let rows = (0..=k).map(|i| wall(at(0, i), at(k, i), up)).collect();
    Ok(SectorMasks { k, masks, walls: [columns, rows] })
}

impl SectorMasks {
    /// Sectors along a side.
    #[must_use]
    pub fn side(&self) -> usize {
        self.k
    }

    /// The mask of one sector: right for what is seen in it.
    ///
    /// # Panics
    /// If `column` or `row` is not below [`side`](Self::side).
    #[must_use]
    pub fn sector(&self, column: usize, row: usize) -> &BackfaceMask {
        assert!(column < self.k && row < self.k, "sector ({column}, {row}) of {} squared", self.k);
        &self.masks[row * self.k + column]
    }

    /// The mask for what lies in a sphere: the classes that are back-facing in every sector which
    /// the sphere may reach into. `None` where it reaches into none, being outside of the view.
    ///
    /// `eye` is the position of the viewer, in the space of the sphere and of the corner
    /// directions. A non-finite sphere is in every sector.
    #[must_use]
    pub fn for_sphere(&self, eye: [f64; 3], sphere: &Sphere) -> Option<BackfaceMask> {
        let centre = DVec3::from(sphere.center.map(f64::from)) - DVec3::from(eye);
        // Rounding of the distances, in f64.
        let reach = f64::from(sphere.radius) + centre.length() * 1e-12;
        let reached = |walls: &[DVec3], i: usize| {
            let (before, after) = (walls[i].dot(centre), walls[i + 1].dot(centre));
            // Written so that NaN reaches.
            !(before < -reach || after > reach)
        };
        let [columns, rows] = &self.walls;
        let mut all: Option<BackfaceMask> = None;
        for row in (0..self.k).filter(|&i| reached(rows, i)) {
            for column in (0..self.k).filter(|&i| reached(columns, i)) {
                let mask = self.sector(column, row);
                all = Some(all.map_or_else(|| mask.clone(), |a| a.and(mask)));
            }
        }
        all
    }
}
