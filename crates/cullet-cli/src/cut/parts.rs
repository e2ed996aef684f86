//! One mesh cut with what its vertices have besides positions.

use cullet::Mesh;
use cullet::bounds::Plane;
use cullet::clip::cut::{CapOptions, CutError, CutInput, CutMesh, CutOptions, NO_ORIGIN, cut};
use cullet::mesh::{Alpha, MeshData, Part};
use cullet_io::Attributes;

/// What remains of a mesh, its parts kept.
#[derive(Debug)]
pub(super) struct CutParts {
    /// Ready for [`Mesh::new`]: the parts that still have triangles, and after them one with the caps.
    pub(super) data: MeshData,
    pub(super) attributes: Attributes,
    /// The cut itself, its triangles in another order.
    pub(super) cut: CutMesh,
}

/// Caps that are flat and white, their texture laid along the plane in units of the mesh.
pub(super) fn caps(attributes: &Attributes, heal: f32) -> CapOptions {
    let normals = if attributes.normals.is_empty() { 0 } else { 3 };
    let mut template = vec![0.0; attributes.stride()];
    if !attributes.colors.is_empty() {
        let at = template.len() - 4;
        template[at..].fill(1.0);
    }
    CapOptions {
        heal,
        weld: 0.0,
        template,
        normal_at: (normals > 0).then_some(0),
        uv_at: (!attributes.uvs.is_empty()).then_some(normals),
    }
}

/// Cuts a mesh in its own space, attributes and all. The caps are a part of the material `cap_material`,
/// opaque, and two-sided where any part is: a surface that is no solid may be wound either way.
pub(super) fn cut_parts(
    mesh: &Mesh,
    attributes: &Attributes,
    planes: &[Plane],
    options: &CutOptions,
    cap_material: u32,
) -> Result<CutParts, CutError> {
    let indices = mesh.original_indices();
    let numbers = attributes.interleaved();
    let input = CutInput {
        positions: mesh.positions(),
        indices: &indices,
        attributes: &numbers,
        stride: attributes.stride(),
    };
    let done = cut(&input, planes, options)?;
    // The part of each triangle of the input; parts are ranges, in order.
    let parts = mesh.parts();
    let part_of = |origin: u32| match origin {
        NO_ORIGIN => parts.len(),
        _ => parts.partition_point(|p| p.first_triangle + p.triangle_count <= origin),
    };
    let mut data = MeshData {
        positions: done.positions.clone(),
        indices: Vec::with_capacity(done.indices.len()),
        deformable: mesh.is_deformable(),
        ..MeshData::default()
    };
    let mut sorted: Vec<Vec<u32>> = vec![Vec::new(); parts.len() + 1];
    for (t, &origin) in done.origin.iter().enumerate() {
        sorted[part_of(origin)].push(t as u32);
    }
    let cap = Part {
        first_triangle: 0,
        triangle_count: 0,
        material: cap_material,
        two_sided: parts.iter().any(|p| p.two_sided),
        alpha: Alpha::Opaque,
    };
    for (part, triangles) in parts.iter().chain([&cap]).zip(&sorted) {
        let first_triangle = (data.indices.len() / 3) as u32;
        for &t in triangles {
            data.indices.extend_from_slice(&done.indices[t as usize * 3..][..3]);
        }
        if !triangles.is_empty() {
            let triangle_count = triangles.len() as u32;
            data.parts.push(Part { first_triangle, triangle_count, ..*part });
        }
    }
    let attributes = attributes.like(&done.attributes);
    Ok(CutParts { data, attributes, cut: done })
}

#[cfg(test)]
mod tests {
    use cullet::mesh::Topology;

    use super::*;

    /// Two tetrahedra in two parts, with a normal, texture coordinates and a colour that are linear in x.
    fn mesh() -> (Mesh, Attributes) {
        let mut data = MeshData::default();
        for (number, x) in [0.0f32, 4.0].into_iter().enumerate() {
            let base = data.positions.len() as u32;
            data.positions.extend([
                [x, 0.0, 0.0],
                [x + 2.0, 0.0, 0.0],
                [x, 1.0, 0.0],
                [x, 0.0, 1.0],
            ]);
            data.indices.extend([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3].map(|i| base + i));
            data.parts.push(Part {
                first_triangle: number as u32 * 4,
                triangle_count: 4,
                material: number as u32,
                two_sided: false,
                alpha: Alpha::Opaque,
            });
        }
        let of = |f: fn(f32) -> f32| data.positions.iter().map(move |p| f(p[0]));
        let attributes = Attributes {
            normals: of(|x| x).map(|x| [x, 0.0, 1.0]).collect(),
            uvs: of(|x| x / 8.0).map(|u| [u, 0.5]).collect(),
            colors: of(|x| x / 8.0).map(|r| [r, 0.25, 0.0, 1.0]).collect(),
        };
        (Mesh::new(data).expect("two tetrahedra"), attributes)
    }

    #[test]
    fn attributes_follow_and_caps_are_flat() {
        let (mesh, attributes) = mesh();
        let planes = [Plane::new([1.0, 0.0, 0.0], 5.0)];
        let options = CutOptions { caps: Some(caps(&attributes, 0.0)), ..CutOptions::default() };
        let done = cut_parts(&mesh, &attributes, &planes, &options, 7).expect("a plane");
        let (data, a) = (&done.data, &done.attributes);
        assert_eq!(data.parts.iter().map(|p| p.material).collect::<Vec<_>>(), [0, 1, 7]);
        assert_eq!(data.parts[0].triangle_count, 4);
        let cap = data.parts[2];
        let corners = |p: Part| {
            let first = p.first_triangle as usize * 3;
            data.indices[first..first + p.triangle_count as usize * 3].to_vec()
        };
        for part in &data.parts[..2] {
            for v in corners(*part) {
                let (v, x) = (v as usize, data.positions[v as usize][0]);
                assert!((a.normals[v][0] - x).abs() < 1e-5 && a.normals[v][2] == 1.0);
                assert!((a.uvs[v][0] - x / 8.0).abs() < 1e-6);
                assert!((a.colors[v][0] - x / 8.0).abs() < 1e-6);
            }
        }
        let area = |v: &[u32], at: &dyn Fn(u32) -> [f32; 2]| {
            let [a, b, c] = [0, 1, 2].map(|i| at(v[i]));
            ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
        };
        for t in corners(cap).chunks_exact(3) {
            for &v in t {
                assert_eq!(a.normals[v as usize], [1.0, 0.0, 0.0]);
                assert_eq!(a.colors[v as usize], [1.0; 4]);
            }
            // The plane's own lengths: areas are those of the cap.
            let flat = area(t, &|v| a.uvs[v as usize]);
            let real = area(t, &|v| [data.positions[v as usize][1], data.positions[v as usize][2]]);
            assert!((flat - real).abs() < 1e-6 && real > 0.0);
        }
        assert_eq!(Topology::of(&data.positions, &data.indices).boundary_edges, 0);
    }

    #[test]
    fn it_is_the_library_s_cut_where_there_is_nothing_to_carry() {
        let (mesh, _) = mesh();
        let planes = [Plane::new([1.0, 0.3, 0.1], 4.4), Plane::new([-1.0, 0.0, 0.2], -0.2)];
        let none = Attributes::default();
        let options = CutOptions { caps: Some(caps(&none, 0.0)), ..CutOptions::default() };
        let ours = cut_parts(&mesh, &none, &planes, &options, 7).expect("planes");
        let theirs = cullet::clip::cut::cut_mesh(&mesh, &planes, &options, 7).expect("planes");
        assert_eq!(ours.data, theirs.data);
        assert!(ours.attributes.is_empty());
    }
}
