//! Topology and clusters of the shared test models, against the table in their README.

use cullet::{Mesh, MeshData};
use cullet_mesh::{NotSolid, Topology, solid};
use cullet_testkit::models::model;

/// Triangles, boundary edges and non-manifold edges, as the README has them by index.
fn counts(name: &str, expected: [u32; 3]) -> Option<Topology> {
    let (positions, indices) = model(name)?;
    let t = Topology::of_indices(&positions, &indices);
    let triangles = (indices.len() / 3) as u32;
    assert_eq!([triangles, t.boundary_edges, t.non_manifold_edges], expected, "{name}");
    Some(Topology::of(&positions, &indices))
}

#[test]
fn open_models_have_the_boundaries_of_the_table() {
    if let Some(t) = counts("stanford-bunny/bun_zipper.ply", [69_451, 223, 0]) {
        assert_eq!((t.vertices, t.boundary_edges, t.misoriented_edges), (34_834, 223, 0));
        assert!(t.volume > 0.0);
        assert_eq!(t.solid(), Err(NotSolid::Open { edges: 223 }));
    }
    counts("stanford-bunny/bun_zipper_res2.ply", [16_301, 123, 150]);
    counts("stanford-bunny/bun_zipper_res3.ply", [3_851, 60, 141]);
    counts("stanford-bunny/bun_zipper_res4.ply", [948, 26, 70]);
    if let Some(t) = counts("happy-buddha/buddha-100k.obj", [100_000, 0, 50]) {
        assert_eq!(t.solid(), Err(NotSolid::NonManifold { edges: 50 }));
    }
    if let Some(t) = counts("classic-meshes/teapot.obj", [6_320, 1_036, 0]) {
        assert_eq!(t.boundary_edges, 160);
    }
    counts("classic-meshes/suzanne.obj", [968, 42, 1]);
    counts("classic-meshes/beetle.obj", [2_053, 296, 47]);
    if let Some(t) = counts("classic-meshes/woody.obj", [1_267, 119, 0]) {
        assert_eq!(t.volume, 0.0, "all of it is flat");
    }
    if let Some(t) = counts("broken/truck-misoriented.obj", [4_770, 1_388, 54]) {
        assert_eq!(t.misoriented_edges, 64);
        assert!(t.volume < 0.0);
    }
}

#[test]
fn sponza_falls_into_the_pieces_of_the_table() {
    if let Some(t) = counts("crytek-sponza/crytek-sponza.ply", [262_267, 94_155, 0]) {
        assert_eq!((t.shells, t.boundary_edges), (1_489, 24_999));
    }
}

#[test]
fn closed_models_are_solids() {
    let models = [
        ("stanford-bunny/bunny-closed-7k.off", 6_966),
        ("armadillo/armadillo.obj", 86_482),
        ("classic-meshes/spot.obj", 5_856),
        ("classic-meshes/cow.obj", 5_804),
        ("classic-meshes/fandisk.obj", 12_946),
        ("classic-meshes/rocker-arm.obj", 20_088),
    ];
    for (name, triangles) in models {
        let Some((positions, indices)) = model(name) else { continue };
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).expect(name);
        assert_eq!((mesh.triangle_count(), solid(&mesh)), (triangles, Ok(())), "{name}");
        let filled = f64::from(triangles - mesh.degenerate_count()) / mesh.clusters().len() as f64;
        assert!(filled > 60.0, "{name}: {filled} triangles a cluster");
    }
}
