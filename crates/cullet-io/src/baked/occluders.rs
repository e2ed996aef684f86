//! Occluders that were baked for a mesh.

use cullet::bounds::Aabb;
use cullet::costs::OccluderCosts;
use cullet::cull::occlusion::Occluder;
use glam::DVec3;

/// Occluders baked for a mesh, in the space of the mesh: what `cullet_bake::occluders` makes. None
/// at all where it found none, which is worth knowing too.
///
/// A sum keeps damage out, but no reader can tell in little time whether they lie within what the
/// mesh hides: who takes them trusts who wrote the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Occluders {
    /// Boxes within what the mesh seals off. They overlap each other. They block for every eye
    /// outside of [`sealed`](Self::sealed), which [`boxes_hold`](Self::boxes_hold) tests.
    pub boxes: Vec<Aabb>,
    /// Boxes around all that the shells which hold [`boxes`](Self::boxes) seal off: a room, seen
    /// from within, hides nothing that is in it.
    pub sealed: Vec<Aabb>,
    /// Convex polygons in the surface.
    pub polygons: Vec<OccluderPolygon>,
    /// Triangles of the mesh, of one side and of two.
    pub sheets: Vec<OccluderSheet>,
    /// Triangles of the mesh for eyes for which the boxes do not [hold](Self::boxes_hold); without
    /// boxes, none. They take the place of boxes and of [`sheets`](Self::sheets).
    pub near: Vec<OccluderSheet>,
    /// The share of the mesh's silhouette that they cover, 0 to 1; 0 where it was not measured.
    pub efficiency: f64,
}

/// Pixels at which costs are compared: those of an instance that pays for its drawing.
const PIXELS: f32 = 10_000.0;
/// The share of its mesh's silhouette that occluders must hide to be taken for it.
const LEAST_EFFICIENCY: f64 = 0.9;

impl Occluders {
    /// Whether there is nothing to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.polygons.is_empty() && self.sheets.is_empty()
    }

    /// Whether the boxes may be used by a view: `near` is a box, in the space of the mesh, around
    /// the view's eye and its near rectangle (what the near plane cuts away hides nothing), of an
    /// orthographic view the rectangle alone. Not if it meets [`sealed`](Self::sealed), nor if it
    /// is empty or NaN.
    ///
    /// A view that draws back faces alone ([`CullFace::Front`](cullet::view::CullFace::Front)), or
    /// takes clockwise triangles for the front, must use neither boxes nor polygons of a one-sided
    /// mesh.
    #[must_use]
    pub fn boxes_hold(&self, near: &Aabb) -> bool {
        let apart = |b: &Aabb| (0..3).any(|a| near.min[a] > b.max[a] || near.max[a] < b.min[a]);
        !near.is_empty() && self.sealed.iter().all(apart)
    }

    /// Whether they hide nearly all that their mesh does. Those off the axes count for nothing: the
    /// engine leaves them out.
    #[must_use]
    pub fn hide_enough(&self) -> bool {
        self.efficiency >= LEAST_EFFICIENCY && self.polygons.iter().all(|p| p.tolerance == 0.0)
    }

    /// Triangles of the mesh that stand for themselves, those for near eyes not counted.
    #[must_use]
    pub fn own_triangles(&self) -> u64 {
        self.sheets.iter().map(|s| s.triangles.len() as u64).sum()
    }
}

/// Whether an occluder costs less than half of what `own`, that of a mesh's own triangles, does.
#[must_use]
pub fn pays(occluder: &Occluder, own: &Occluder) -> bool {
    let costs = OccluderCosts::default();
    occluder.cost(&costs, PIXELS) * 2.0 < own.cost(&costs, PIXELS)
}

/// A convex polygon in the surface of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OccluderPolygon {
    /// Corners, counter-clockwise seen from the front, as the triangles that it stands for.
    pub points: Vec<[f32; 3]>,
    /// Whether those are drawn from both sides, so that it blocks from both; else only from its
    /// front.
    pub two_sided: bool,
    /// How far the surface may be from the polygon, in units of the mesh: its depth must be taken
    /// that much farther away, along the normal. 0 where it lies in the surface exactly.
    pub tolerance: f32,
}

impl OccluderPolygon {
    /// The least slope, sine of the angle between a ray and the plane, at which a polygon with a
    /// [`tolerance`](Self::tolerance) is proved to block a ray.
    pub const LEAST_SLOPE: f64 = 1.0 / 64.0;

    /// Whether the polygon may be used by an eye: (e, 1), or (direction, 0) of an orthographic
    /// view, in the space of the mesh. Not from behind if it has one side, and not too near its
    /// plane if it has a tolerance; never for NaN.
    #[must_use]
    pub fn holds_from(&self, eye: [f64; 4]) -> bool {
        let [x, y, z, w] = eye;
        let points = || self.points.iter().map(|p| DVec3::from(p.map(f64::from)));
        let Some(first) = points().next() else { return false };
        // Newell's sum, which no three corners in line can spoil.
        let corners: Vec<DVec3> = points().map(|p| p - first).collect();
        let normal: DVec3 =
            (0..corners.len()).map(|i| corners[i].cross(corners[(i + 1) % corners.len()])).sum();
        let normal = normal.normalize_or_zero();
        let towards = |p: DVec3| DVec3::new(x, y, z) - p * w;
        points().all(|p| {
            let way = towards(p);
            let height = way.dot(normal);
            let height = if self.two_sided { height.abs() } else { height };
            let least = if self.tolerance > 0.0 { Self::LEAST_SLOPE * way.length() } else { 0.0 };
            height > least
        })
    }
}

/// Triangles of a mesh that stand for themselves, whatever their slope: exact, but more expensive
/// to draw than a box or polygon. Where they share an edge they are to be drawn as one surface, or
/// a strict rasteriser leaves a seam.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OccluderSheet {
    /// Corners, wound as in the mesh.
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// Whether they are drawn from both sides, so that they block from both; else only from their
    /// front.
    pub two_sided: bool,
}
