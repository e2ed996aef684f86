//! Cuts of a [`Mesh`]: parts stay parts, and the caps are one more.

use cullet::bounds::Plane;
use cullet::mesh::{Alpha, Mesh, MeshData, Part};

use crate::cut::cut;
use crate::options::{CutError, CutInput, CutOptions};
use crate::result::{CutMesh, NO_ORIGIN};

/// A [`Mesh`] after a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutParts {
    /// Ready for [`Mesh::new`]: the parts that still have triangles, and after them one with the
    /// caps. Empty if nothing is left.
    pub data: MeshData,
    /// Original triangle of each triangle; [`NO_ORIGIN`] in caps.
    pub origin: Vec<u32>,
    /// The cut before its triangles were sorted into parts, for its report and its caps.
    pub cut: CutMesh,
}

/// Cuts a mesh in its own space. The caps become a part of the material `cap_material`, opaque and,
/// where any part is two-sided, two-sided too: a surface that is no solid may be wound either way.
/// `attributes` are `stride` numbers for each vertex as in [`CutInput`], and come back in
/// [`CutParts::cut`] for the vertices of [`CutParts::data`]; none is an empty slice and 0.
///
/// Costs [`cut`] and a copy of the index list.
///
/// # Errors
/// As [`cut`]; only a plane can be wrong, or the attributes not fit.
pub fn cut_mesh(
    mesh: &Mesh,
    attributes: &[f32],
    stride: usize,
    planes: &[Plane],
    options: &CutOptions,
    cap_material: u32,
) -> Result<CutParts, CutError> {
    let indices = mesh.original_indices();
    let input = CutInput { positions: mesh.positions(), indices: &indices, attributes, stride };
    let done = cut(&input, planes, options)?;
    let walls = done.origin.iter().position(|&o| o == NO_ORIGIN).unwrap_or(done.origin.len());
    // Untouched and cut triangles both ascend by origin, so each part has a range of either.
    let (untouched, touched) = done.origin[..walls].split_at(done.untouched);
    let mut data = MeshData {
        positions: done.positions.clone(),
        indices: Vec::with_capacity(done.indices.len()),
        deformable: mesh.is_deformable(),
        ..MeshData::default()
    };
    let mut origin = Vec::with_capacity(done.origin.len());
    let mut take = |data: &mut MeshData, range: std::ops::Range<usize>| {
        data.indices.extend_from_slice(&done.indices[range.start * 3..range.end * 3]);
        origin.extend_from_slice(&done.origin[range]);
    };
    for part in mesh.parts() {
        let (first, end) = (part.first_triangle, part.first_triangle + part.triangle_count);
        let before = data.indices.len() / 3;
        for (list, offset) in [(untouched, 0), (touched, done.untouched)] {
            let at = |limit| offset + list.partition_point(|&o| o < limit);
            take(&mut data, at(first)..at(end));
        }
        let count = data.indices.len() / 3 - before;
        if count > 0 {
            let (first_triangle, triangle_count) = (before as u32, count as u32);
            data.parts.push(Part { first_triangle, triangle_count, ..*part });
        }
    }
    if walls < done.origin.len() {
        take(&mut data, walls..done.origin.len());
        data.parts.push(Part {
            first_triangle: walls as u32,
            triangle_count: (done.origin.len() - walls) as u32,
            material: cap_material,
            two_sided: mesh.parts().iter().any(|p| p.two_sided),
            alpha: Alpha::Opaque,
        });
    }
    Ok(CutParts { data, origin, cut: done })
}
