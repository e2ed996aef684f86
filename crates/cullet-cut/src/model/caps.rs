//! Attributes of the vertices of caps besides positions.

use cullet_io::Attributes;

use crate::options::CapOptions;

/// Caps that are flat and white, their texture laid along the plane in units of the mesh.
/// Distances are in units of the mesh.
pub(super) fn caps(attributes: &Attributes, heal: f32, weld: f32) -> CapOptions {
    let normals = if attributes.normals.is_empty() { 0 } else { 3 };
    let mut template = vec![0.0; attributes.stride()];
    if !attributes.colors.is_empty() {
        let at = template.len() - 4;
        template[at..].fill(1.0);
    }
    CapOptions {
        heal,
        weld,
        template,
        normal_at: (normals > 0).then_some(0),
        uv_at: (!attributes.uvs.is_empty()).then_some(normals),
    }
}

#[cfg(test)]
mod tests {
    use cullet::Mesh;
    use cullet::bounds::Plane;
    use cullet::mesh::{Alpha, MeshData, Part};
    use cullet_mesh::Topology;

    use super::*;
    use crate::mesh::cut_mesh;
    use crate::options::CutOptions;

    /// Two tetrahedra in two parts, with a normal, texture coordinates and a colour that are linear
    /// in x.
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
        let options =
            CutOptions { caps: Some(caps(&attributes, 0.0, 0.0)), ..CutOptions::default() };
        let numbers = attributes.interleaved();
        let done =
            cut_mesh(&mesh, &numbers, attributes.stride(), &planes, &options, 7).expect("a plane");
        let (data, a) = (&done.data, &attributes.like(&done.cut.attributes));
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
}
