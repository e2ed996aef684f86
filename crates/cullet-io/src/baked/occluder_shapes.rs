//! Baked occluders as the engine draws them, and as triangles.

use cullet::MeshData;
use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, Occluder, OcclusionError, Patch, Shape};
use cullet::mesh::Part;

use super::occluders::{OccluderSheet, Occluders};

impl Occluders {
    /// The occluders as a mesh, to save or draw: boxes with `box_material`, wound outward and
    /// one-sided; then polygons and triangles with `polygon_material`, with the sides they block
    /// from. Empty for none.
    #[must_use]
    pub fn to_data(&self, box_material: u32, polygon_material: u32) -> MeshData {
        let mut data = MeshData::default();
        for b in &self.boxes {
            let first = data.positions.len() as u32;
            data.positions.extend(box_corners(b));
            for [a, b, c, d] in BOX_QUADS {
                data.indices.extend([a, b, c, a, c, d].map(|v| first + v as u32));
            }
        }
        let part = |data: &MeshData, material, two_sided| {
            let first_triangle = data.parts.iter().map(|p: &Part| p.triangle_count).sum();
            let triangle_count = (data.indices.len() / 3) as u32 - first_triangle;
            Part { first_triangle, triangle_count, material, two_sided, ..Part::default() }
        };
        let boxes = part(&data, box_material, false);
        data.parts.push(boxes);
        for two_sided in [false, true] {
            for polygon in self.polygons.iter().filter(|p| p.two_sided == two_sided) {
                let first = data.positions.len() as u32;
                data.positions.extend(&polygon.points);
                for k in 2..polygon.points.len() as u32 {
                    data.indices.extend([first, first + k - 1, first + k]);
                }
            }
            for sheet in self.sheets.iter().filter(|s| s.two_sided == two_sided) {
                let first = data.positions.len() as u32;
                data.positions.extend(sheet.triangles.as_flattened());
                data.indices.extend(first..data.positions.len() as u32);
            }
            let polygons = part(&data, polygon_material, two_sided);
            data.parts.push(polygons);
        }
        data.parts.retain(|p| p.triangle_count > 0);
        data
    }

    /// The engine's occluder: boxes and polygons drawn by their outline, triangles as patches of a
    /// surface. Polygons with a [tolerance](super::OccluderPolygon::tolerance) are left out, for
    /// the engine does not test whether they [hold](super::OccluderPolygon::holds_from) from its
    /// eye.
    ///
    /// # Errors
    /// Where something here is not finite or has no extent, which a baker does not make.
    pub fn to_engine(&self) -> Result<Occluder, OcclusionError> {
        let boxes = self.boxes.iter().map(Convex::from_box);
        let exact = self.polygons.iter().filter(|p| p.tolerance == 0.0);
        let polygons = exact.map(|p| match p.two_sided {
            true => Convex::from_polygon(&p.points),
            false => Convex::from_one_sided_polygon(&p.points),
        });
        let mut shapes: Vec<Shape> =
            boxes.chain(polygons).map(|c| c.map(Shape::Convex)).collect::<Result<_, _>>()?;
        shapes.extend(patches(&self.sheets)?);
        let near = patches(&self.near)?;
        Ok(Occluder::new(shapes).with_sealed(self.sealed.clone()).with_near(near))
    }
}

fn patches(sheets: &[OccluderSheet]) -> Result<Vec<Shape>, OcclusionError> {
    let mut shapes = Vec::new();
    for sheet in sheets {
        let positions = sheet.triangles.as_flattened();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let patches = Patch::cut(positions, &indices, Patch::FACETS, sheet.two_sided)?;
        shapes.extend(patches.into_iter().map(Shape::Patch));
    }
    Ok(shapes)
}

/// The sides of a box, wound outward; bit `a` of a corner's number is set where axis `a` is at its
/// maximum.
pub const BOX_QUADS: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The corners of a box, numbered so.
#[must_use]
pub fn box_corners(b: &Aabb) -> [[f32; 3]; 8] {
    std::array::from_fn(|i| [0, 1, 2].map(|a| if i >> a & 1 == 1 { b.max[a] } else { b.min[a] }))
}
