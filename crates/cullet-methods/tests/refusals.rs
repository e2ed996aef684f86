//! What back-face culling refuses, with a reason, and what it keeps because nothing is proved.

use cullet::Level;
use cullet::bounds::Sphere;
use cullet::cull::backface::{BackfaceMask, EllipticCone, MaskGrid, Planes8, Planes16, ViewCone};
use cullet::mesh::{Mesh, MeshData, NotSolid, Part, TwoSided};
use cullet_methods::cluster::ClusterBounds;
use cullet_methods::{Groups, Planes32};

const FAR: [f64; 4] = [3.0, 5.0, 7.0, 1.0];

/// A tetrahedron wound outward.
fn solid() -> MeshData {
    MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        ..MeshData::default()
    }
}

fn bounds(mesh: &Mesh) -> Result<ClusterBounds<EllipticCone>, TwoSided> {
    ClusterBounds::of_mesh(mesh)
}

#[test]
fn two_sided_meshes_are_refused_with_their_defect() {
    let mut mesh = Mesh::new(solid()).expect("a mesh");
    // Not declared at all is two-sided.
    let error = bounds(&mesh).expect_err("two-sided");
    assert_eq!(error, TwoSided { defect: None });
    mesh.set_two_sided(false);
    assert_eq!(bounds(&mesh).expect("one-sided").len(), mesh.clusters().len());

    let mut open = solid();
    open.indices.truncate(9);
    let error = bounds(&Mesh::new(open).expect("a mesh")).expect_err("two-sided");
    assert_eq!(error.defect, Some(NotSolid::Open { edges: 3 }));
    assert_eq!(
        error.to_string(),
        "the mesh is two-sided and no solid: it is open: 3 boundary edges; if its backs are never \
         seen, declare it one-sided (set_two_sided(false))"
    );

    let mut inward = solid();
    inward.indices.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
    let error = bounds(&Mesh::new(inward).expect("a mesh")).expect_err("two-sided");
    assert!(matches!(error.defect, Some(NotSolid::Inward { .. })), "{error}");
}

#[test]
fn two_sided_parts_are_kept() {
    let mut data = solid();
    let part = Part { triangle_count: 2, ..Part::default() };
    data.parts = vec![part, Part { first_triangle: 2, two_sided: true, material: 1, ..part }];
    let mesh = Mesh::new(data).expect("a mesh");
    // Each triangle a cluster would be culled alone; the two of the second part are not.
    let bounds = bounds(&mesh).expect("partly one-sided");
    let behind_all = [0.2, 0.2, 0.2, 1.0];
    assert_eq!(bounds.count(Level::new(), behind_all), 1);
}

#[test]
fn numbers_out_of_range_are_refused_or_keep_everything() {
    let sphere = |radius: f32| Sphere { center: [0.0; 3], radius };
    // A point has one line of sight; from itself, none.
    let cone = ViewCone::to_sphere(FAR, &sphere(0.0)).expect("a point");
    assert_eq!(cone.sine, 0.0);
    assert_eq!(ViewCone::to_sphere([0.0, 0.0, 0.0, 1.0], &sphere(0.0)), None);
    for radius in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(ViewCone::to_sphere(FAR, &sphere(radius)), None, "{radius}");
    }

    let data = solid();
    let (positions, indices) = (&data.positions, &data.indices);
    let planes = (
        Planes8::new(positions, indices),
        Planes16::new(positions, indices),
        Planes32::new(positions, indices),
    );
    let mut mesh = Mesh::new(solid()).expect("a mesh");
    mesh.set_two_sided(false);
    let bounds = bounds(&mesh).expect("one-sided");
    let groups = Groups::kd(positions, indices, 2);
    let grid = MaskGrid::new(16).expect("in range");
    let level = Level::new();
    let mut eyes = vec![[0.0; 4], [3.0, 5.0, 7.0, -1.0]];
    for k in 0..4 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut eye = FAR;
            eye[k] = bad;
            eyes.push(eye);
        }
    }
    for eye in eyes {
        assert_eq!(planes.0.count(level, eye), 0, "{eye:?}");
        assert_eq!(planes.1.count(level, eye), 0, "{eye:?}");
        assert_eq!(planes.2.count(level, eye), 0, "{eye:?}");
        assert_eq!(bounds.count(level, eye), 0, "{eye:?}");
        assert_eq!(ViewCone::to_sphere(eye, &sphere(1.0)), None, "{eye:?}");
        assert!(groups.masks(level, &grid, eye).all(|m| m == BackfaceMask::NOTHING), "{eye:?}");
    }
    assert_eq!(planes.0.count(level, FAR), 3);
}
