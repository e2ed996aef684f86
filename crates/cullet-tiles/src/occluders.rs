//! Occluders that a file has baked.

use cullet::OccluderCosts;
use cullet::bounds::Aabb;
use cullet::cull::occlusion::Occluder;
use cullet_bake::occluders::{Occluders, Polygon, Sheet};
use cullet_io::baked::{OccluderPolygon, OccluderSheet, OccluderTables};

/// Pixels at which costs are compared: those of an instance that pays for its drawing.
const PIXELS: f32 = 10_000.0;
/// The share of its mesh's silhouette that occluders must hide to be taken for it.
const LEAST_EFFICIENCY: f64 = 0.9;

/// Whether an occluder costs less than half of what a mesh's own triangles do.
#[must_use]
pub fn pays(occluder: &Occluder, own: &Occluder) -> bool {
    let costs = OccluderCosts::default();
    occluder.cost(&costs, PIXELS) * 2.0 < own.cost(&costs, PIXELS)
}

/// Whether occluders hide nearly all that their mesh does: the engine would leave out those off the axes, and `efficiency` is the
/// share of its silhouette that they cover.
#[must_use]
pub fn hide_enough(occluders: &Occluders, efficiency: f64) -> bool {
    efficiency >= LEAST_EFFICIENCY && occluders.polygons.iter().all(|p| p.tolerance == 0.0)
}

/// Occluders of a file, as they were made.
#[must_use]
pub fn from_tables(tables: &OccluderTables) -> Occluders {
    let sides = |&[min, max]: &[[f32; 3]; 2]| Aabb { min, max };
    let sheet =
        |s: &OccluderSheet| Sheet { triangles: s.triangles.clone(), two_sided: s.two_sided };
    let polygon = |p: &OccluderPolygon| Polygon {
        points: p.points.clone(),
        two_sided: p.two_sided,
        tolerance: p.tolerance,
    };
    Occluders {
        boxes: tables.boxes.iter().map(sides).collect(),
        sealed: tables.sealed.iter().map(sides).collect(),
        polygons: tables.polygons.iter().map(polygon).collect(),
        sheets: tables.sheets.iter().map(sheet).collect(),
        near: tables.near.iter().map(sheet).collect(),
    }
}
