//! Meshes: construction, clusters, topology and repair, on shapes made here.

use std::collections::BTreeMap;

use cullet::bounds::{Aabb, Boxes};
use cullet::mesh::{
    Alpha, Cluster, Clustering, MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES, MeshError, NotSolid,
    Part, Topology, is_degenerate, orient_triangles,
};
use cullet::{Mesh, MeshData};
use cullet_testkit::soups::{Soup, ball_at, block, join, terrain, turned};
use proptest::prelude::*;

fn data((positions, indices): Soup) -> MeshData {
    MeshData { positions, indices, ..MeshData::default() }
}

fn part(first_triangle: u32, triangle_count: u32, material: u32) -> Part {
    Part { first_triangle, triangle_count, material, ..Part::default() }
}

/// Everything that is promised of clusters, from the mesh alone.
fn check(mesh: &Mesh, source: &MeshData) {
    let triangles = source.indices.len() / 3;
    let mut seen = vec![false; triangles];
    for (t, &original) in mesh.original_triangle().iter().enumerate() {
        assert!(
            !std::mem::replace(&mut seen[original as usize], true),
            "{original} is there twice"
        );
        let i = original as usize * 3;
        assert_eq!(mesh.triangle(t as u32), source.indices[i..i + 3]);
    }
    assert!(seen.into_iter().all(|s| s));
    let mut expected = 0;
    for (i, c) in mesh.clusters().iter().enumerate() {
        assert_eq!(c.first_triangle, expected);
        expected += c.triangle_count;
        assert!((1..=MAX_CLUSTER_TRIANGLES as u32).contains(&c.triangle_count));
        let part = mesh.parts()[c.part as usize];
        let mut vertices = Vec::new();
        for t in c.first_triangle..expected {
            let original = mesh.original_triangle()[t as usize];
            assert!(original >= part.first_triangle);
            assert!(original < part.first_triangle + part.triangle_count);
            vertices.extend(mesh.triangle(t));
            for p in mesh.corners(t) {
                assert!(mesh.bounds().contains(p));
                // Beyond its limit a batch holds a stand-in that is never culled.
                let far = p.iter().any(|v| v.abs() > Boxes::LIMIT);
                assert!(far || mesh.cluster_boxes().get(i).contains(p));
            }
            assert!(source.deformable || !is_degenerate(mesh.triangle(t), mesh.positions()));
        }
        vertices.sort_unstable();
        vertices.dedup();
        assert!(vertices.len() <= MAX_CLUSTER_VERTICES);
    }
    assert_eq!(expected + mesh.degenerate_count(), triangles as u32);
    for t in expected..triangles as u32 {
        assert!(is_degenerate(mesh.triangle(t), mesh.positions()));
    }
    assert_eq!(mesh.cluster_count() as usize, mesh.clusters().len());
}

#[test]
fn an_empty_mesh_is_a_mesh() {
    let mesh = Mesh::new(MeshData::default()).expect("empty is valid");
    assert!(mesh.clusters().is_empty() && mesh.bounds().is_empty());
    assert_eq!(mesh.parts().len(), 1);
    assert_eq!(mesh.solid(), Err(NotSolid::Empty));
    assert_eq!(mesh.topology(), Topology::default());
}

#[test]
fn clusters_keep_within_limits_and_parts() {
    let mut source = data(terrain(50));
    source.parts = vec![part(0, 1, 7), part(1, 0, 8), part(1, 3000, 7), part(3001, 1999, 9)];
    check(&Mesh::new(source.clone()).expect("valid"), &source);
}

#[test]
fn clusters_are_well_filled_and_tight() {
    let source = data(terrain(100));
    let mesh = Mesh::new(source.clone()).expect("valid");
    check(&mesh, &source);
    // 64 vertices of a grid hold 98 triangles at best.
    let filled = 20_000.0 / mesh.clusters().len() as f64;
    assert!(filled > 62.0, "{filled} triangles a cluster");
    let area = |b: &Aabb| (b.max[0] - b.min[0]) * (b.max[2] - b.min[2]);
    let covered: f32 = (0..mesh.clusters().len()).map(|c| area(&mesh.cluster_boxes().get(c))).sum();
    assert!(covered < 100.0 * 100.0 * 1.5, "boxes cover the sheet {} times", covered / 1e4);
}

#[test]
fn degenerate_triangles_go_to_the_end() {
    let mut source = data(block([0.0; 3], [1.0; 3]));
    source.positions.push([0.5, 0.0, 0.0]);
    // Between the good ones: repeated indices, and three points on one edge.
    source.indices.splice(6..6, [3, 3, 5, 0, 8, 1]);
    let mesh = Mesh::new(source.clone()).expect("valid");
    check(&mesh, &source);
    assert_eq!((mesh.degenerate_count(), mesh.triangle_count()), (2, 14));
    assert_eq!(mesh.original_triangle()[12..], [2, 3]);
    source.deformable = true;
    let mesh = Mesh::new(source.clone()).expect("valid");
    check(&mesh, &source);
    assert_eq!(mesh.degenerate_count(), 0, "vertices that move may give it area");
}

#[test]
fn only_degenerate_triangles_make_no_cluster() {
    let mesh = Mesh::new(data((vec![[1.0; 3]; 3], vec![0, 1, 2]))).expect("valid");
    assert!(mesh.clusters().is_empty() && mesh.bounds().is_empty());
    assert_eq!(mesh.degenerate_count(), 1);
}

#[test]
fn huge_and_tiny_coordinates_are_ordered_without_trouble() {
    for scale in [f32::MAX, 1e-44, 1.0] {
        let (mut positions, indices) = terrain(12);
        positions.iter_mut().flatten().for_each(|v| *v = *v / 16.0 * scale);
        let source = data((positions, indices));
        check(&Mesh::new(source.clone()).expect("finite"), &source);
    }
}

#[test]
fn bad_data_is_refused_by_name() {
    let good = data(block([0.0; 3], [1.0; 3]));
    let mut bad = good.clone();
    bad.positions[3][1] = f32::NAN;
    assert!(matches!(Mesh::new(bad), Err(MeshError::NotFinite { vertex: 3, .. })));
    let mut bad = good.clone();
    bad.indices[4] = 8;
    assert_eq!(Clustering::spatial(&bad), Err(MeshError::Index { at: 4, index: 8, vertices: 8 }));
    bad.indices.pop();
    assert_eq!(Mesh::new(bad).err(), Some(MeshError::NotTriangles(35)));
    for parts in [vec![part(0, 11, 0)], vec![part(1, 11, 0)], vec![part(0, u32::MAX, 0)]] {
        let bad = MeshData { parts, ..good.clone() };
        assert!(matches!(Mesh::new(bad), Err(MeshError::Parts { .. })));
    }
}

#[test]
fn clusterings_from_elsewhere_are_checked() {
    let source = data(block([0.0; 3], [1.0; 3]));
    let good = Clustering::spatial(&source).expect("valid");
    assert!(Mesh::with_clusters(source.clone(), &good).is_ok());
    let refused = |change: &dyn Fn(&mut Clustering)| {
        let mut bad = good.clone();
        change(&mut bad);
        assert!(
            matches!(Mesh::with_clusters(source.clone(), &bad), Err(MeshError::Clustering(_))),
            "{bad:?}"
        );
    };
    refused(&|c| c.order[0] = c.order[1]);
    refused(&|c| c.order[0] = 12);
    refused(&|c| {
        c.order.pop();
        c.clusters[0].triangle_count -= 1;
    });
    refused(&|c| c.clusters[0].triangle_count -= 1);
    refused(&|c| c.clusters[0].part = 1);
    refused(&|c| c.clusters.insert(0, Cluster { first_triangle: 0, triangle_count: 0, part: 0 }));
    refused(&|c| c.clusters[0].triangle_count = u32::MAX);
    let large = data(terrain(10));
    let mut one = Clustering { order: (0..200).collect(), clusters: Vec::new() };
    one.clusters.push(Cluster { first_triangle: 0, triangle_count: 100, part: 0 });
    one.clusters.push(Cluster { first_triangle: 100, triangle_count: 100, part: 0 });
    let error = Mesh::with_clusters(large, &one).expect_err("66 vertices");
    assert!(error.to_string().contains("66 vertices; 64"), "{error}");
}

#[test]
fn a_block_is_a_solid_in_any_arrangement_of_parts() {
    let mut source = data(block([-1.0; 3], [2.0; 3]));
    source.parts = vec![part(0, 5, 0), part(5, 7, 1)];
    let mesh = Mesh::new(source.clone()).expect("valid");
    assert_eq!(mesh.solid(), Ok(()));
    let t = mesh.topology();
    assert_eq!((t.vertices, t.triangles, t.edges, t.shells), (8, 12, 18, 1));
    assert!((t.volume - 27.0).abs() < 1e-12);
    source.parts[1].alpha = Alpha::Masked;
    let mesh = Mesh::new(source).expect("valid");
    assert_eq!(mesh.solid(), Err(NotSolid::NotOpaque { part: 1 }));
}

#[test]
fn welding_joins_split_vertices_and_signed_zeros() {
    let (positions, indices) = block([-0.0; 3], [1.0; 3]);
    let mut split: Vec<[f32; 3]> = indices.iter().map(|&i| positions[i as usize]).collect();
    split.iter_mut().step_by(2).flatten().filter(|v| **v == 0.0).for_each(|v| *v = 0.0);
    let soup: Vec<u32> = (0..36).collect();
    assert_eq!(Topology::of(&split, &soup).solid(), Ok(()));
    let unwelded = Topology::of_indices(&split, &soup);
    assert_eq!((unwelded.boundary_edges, unwelded.shells), (36, 12));
}

#[test]
fn every_reason_not_to_be_solid() {
    let solid = |(p, i): &Soup| Topology::of(p, i).solid();
    let cube = block([0.0; 3], [1.0; 3]);
    let mut open = cube.clone();
    open.1.truncate(33);
    assert_eq!(solid(&open), Err(NotSolid::Open { edges: 3 }));
    let touching = join([cube.clone(), block([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])]);
    assert_eq!(solid(&touching), Err(NotSolid::NonManifold { edges: 1 }));
    let mut mixed = cube.clone();
    mixed.1.swap(1, 2);
    assert_eq!(solid(&mixed), Err(NotSolid::Misoriented { edges: 3 }));
    assert_eq!(solid(&turned(cube.clone())), Err(NotSolid::Inward { volume: -1.0 }));
    let one_bad = join([cube.clone(), turned(block([5.0; 3], [5.5; 3]))]);
    assert_eq!(solid(&one_bad), Err(NotSolid::InwardShells { shells: 1, of: 2 }));
    // A tetrahedron squeezed into a plane: no volume, but rounding on the way to it.
    let flat = [[0.1, 0.3], [0.7, 0.2], [0.3, 0.9], [0.4, 0.6]].map(|[u, v]| [u, v, u]);
    let sides = vec![0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
    assert_eq!(solid(&(flat.to_vec(), sides)), Err(NotSolid::NoVolume));
}

#[test]
fn a_cavity_is_not_an_inward_shell() {
    let room = |inner| join([block([0.0; 3], [10.0; 3]), inner]);
    let hollow = room(turned(ball_at([5.0; 3], 3.0, 8)));
    assert_eq!(Topology::of(&hollow.0, &hollow.1).solid(), Ok(()));
    // A body in the cavity is right outward, and wrong inward.
    let body = |inner| join([room(turned(ball_at([5.0; 3], 3.0, 8))), inner]);
    let good = body(ball_at([5.0; 3], 1.0, 6));
    assert_eq!(Topology::of(&good.0, &good.1).solid(), Ok(()));
    let bad = body(turned(ball_at([5.0; 3], 1.0, 6)));
    assert_eq!(Topology::of(&bad.0, &bad.1).inward_shells, 1);
    // Beside it on the same wall: touching is not being inside.
    let touching = room(turned(block([10.0, 2.0, 2.0], [11.0, 3.0, 3.0])));
    assert_eq!(Topology::of(&touching.0, &touching.1).inward_shells, 1);
}

#[test]
fn degenerate_triangles_and_bad_indices_are_no_part_of_the_surface() {
    let (positions, mut indices) = block([0.0; 3], [1.0; 3]);
    indices.extend([0, 0, 1, 2, 99, 3, 7]);
    assert_eq!(Topology::of(&positions, &indices).triangles, 12);
    let nan = Topology::of(&[[f32::NAN; 3], [0.0; 3], [1.0; 3]], &[0, 1, 2, 0, 2, 1]);
    assert_eq!(nan.solid(), Err(NotSolid::NoVolume));
}

#[test]
fn a_moebius_strip_has_one_side_and_is_left_alone() {
    // Five quads around, the last joined upside down.
    let quads = 5;
    let mut positions = Vec::new();
    for i in 0..quads {
        let a = i as f32 / quads as f32 * std::f32::consts::TAU;
        let (s, c) = (a / 2.0).sin_cos();
        for half in [-0.3f32, 0.3] {
            let r = 1.0 + half * c;
            positions.push([r * a.cos(), half * s, r * a.sin()]);
        }
    }
    let mut indices = Vec::new();
    for i in 0..quads {
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 < quads { [a + 2, b + 2] } else { [1, 0] };
        indices.extend([a, b, c, b, d, c]);
    }
    let before = indices.clone();
    let repair = orient_triangles(&positions, &mut indices);
    assert_eq!((repair.left, repair.triangles_turned), (1, 0));
    assert_eq!(before, indices);
}

#[test]
fn repair_turns_what_is_wrong_and_nothing_else() {
    let mut soup = join([
        block([0.0; 3], [10.0; 3]),
        // A cavity, rightly inward, and a body in it, wrongly so.
        turned(ball_at([5.0; 3], 3.0, 8)),
        turned(block([4.5; 3], [5.5; 3])),
        // Beside it: wholly inward; and with two triangles turned.
        turned(ball_at([20.0, 5.0, 5.0], 2.0, 6)),
        block([30.0; 3], [31.0; 3]),
        // An open sheet with one triangle turned.
        terrain(4),
    ]);
    let last = soup.1.len();
    let sheet = last - 4 * 4 * 6;
    for triangle in [sheet / 3 - 1, sheet / 3 - 5, last / 3 - 3] {
        soup.1.swap(triangle * 3 + 1, triangle * 3 + 2);
    }
    let repair = orient_triangles(&soup.0, &mut soup.1);
    assert_eq!(repair.shells, 6);
    assert_eq!((repair.made_consistent, repair.turned_outward, repair.cavities), (2, 2, 1));
    assert_eq!((repair.left, repair.triangles_turned), (0, 12 + 6 * 2 * 10 + 2 + 1));
    let closed = Topology::of(&soup.0, &soup.1[..sheet]);
    assert_eq!(closed.solid(), Ok(()));
    assert_eq!(Topology::of(&soup.0, &soup.1).misoriented_edges, 0);
    let again = orient_triangles(&soup.0, &mut soup.1);
    assert_eq!(again.triangles_turned, 0, "what is right stays");
}

#[test]
fn an_oriented_mesh_keeps_its_clusters_and_numbers() {
    let source = data(turned(ball_at([1.0, 2.0, 3.0], 2.0, 20)));
    let mesh = Mesh::new(source).expect("valid");
    assert!(matches!(mesh.solid(), Err(NotSolid::Inward { .. })));
    let (fixed, repair) = mesh.clone().oriented();
    assert_eq!(fixed.solid(), Ok(()));
    assert_eq!((repair.turned_outward, repair.triangles_turned), (1, mesh.triangle_count()));
    assert_eq!(fixed.original_triangle(), mesh.original_triangle());
    assert_eq!(fixed.clusters(), mesh.clusters());
}

/// The slow oracle: edges in a map, welding by comparing with every vertex before.
fn topology_ref(positions: &[[f32; 3]], indices: &[u32]) -> [u32; 7] {
    let weld = |v: u32| {
        let p = positions[v as usize];
        positions.iter().position(|q| *q == p).expect("itself")
    };
    let triangles: Vec<[usize; 3]> = indices
        .chunks_exact(3)
        .map(|t| [weld(t[0]), weld(t[1]), weld(t[2])])
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    let mut edges: BTreeMap<(usize, usize), Vec<(usize, bool)>> = BTreeMap::new();
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            edges.entry((p.min(q), p.max(q))).or_default().push((i, p < q));
        }
    }
    let mut shell: Vec<usize> = (0..triangles.len()).collect();
    for uses in edges.values() {
        for u in uses {
            let (old, new) = (shell[u.0], shell[uses[0].0]);
            shell.iter_mut().filter(|s| **s == old).for_each(|s| *s = new);
        }
    }
    shell.sort_unstable();
    shell.dedup();
    fn count<T>(
        edges: &BTreeMap<T, Vec<(usize, bool)>>,
        is: fn(&[(usize, bool)]) -> bool,
    ) -> usize {
        edges.values().filter(|uses| is(uses)).count()
    }
    let mut vertices: Vec<usize> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    [
        vertices.len(),
        triangles.len(),
        edges.len(),
        count(&edges, |u| u.len() == 1),
        count(&edges, |u| u.len() > 2),
        count(&edges, |u| u.len() == 2 && u[0].1 == u[1].1),
        shell.len(),
    ]
    .map(|n| n as u32)
}

/// Triangles among few points, so that edges meet often; some points are in one place.
fn soup() -> impl Strategy<Value = Soup> {
    let coordinate = prop_oneof![Just(0.0f32), Just(-0.0), Just(1.0), Just(2.0)];
    let points = prop::collection::vec(prop::array::uniform3(coordinate), 4..14);
    points.prop_flat_map(|p| {
        let n = p.len() as u32;
        (Just(p), prop::collection::vec(0..n, 0..120))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(200)))]

    #[test]
    fn topology_equals_the_oracle((positions, indices) in soup()) {
        let t = Topology::of(&positions, &indices);
        let counts = [
            t.vertices, t.triangles, t.edges, t.boundary_edges, t.non_manifold_edges,
            t.misoriented_edges, t.shells,
        ];
        prop_assert_eq!(counts, topology_ref(&positions, &indices));
    }

    #[test]
    fn any_soup_is_cut_into_valid_clusters((positions, mut indices) in soup(), deformable: bool) {
        indices.truncate(indices.len() / 3 * 3);
        let source = MeshData { positions, indices, deformable, ..MeshData::default() };
        let mesh = Mesh::new(source.clone()).expect("valid");
        check(&mesh, &source);
        let clustering = Clustering::spatial(&source).expect("valid");
        prop_assert!(Mesh::with_clusters(source, &clustering).is_ok());
    }

    #[test]
    fn repair_undoes_any_turning_of_a_solid(turn in prop::collection::vec(any::<bool>(), 128)) {
        // The larger part of each shell decides nothing here: the volume does.
        let good = join([ball_at([0.0; 3], 2.0, 5), block([5.0; 3], [6.0; 3])]);
        let mut soup = good.clone();
        for (triangle, turn) in soup.1.chunks_exact_mut(3).zip(&turn) {
            if *turn {
                triangle.swap(1, 2);
            }
        }
        orient_triangles(&soup.0, &mut soup.1);
        prop_assert_eq!(Topology::of(&soup.0, &soup.1).solid(), Ok(()));
        prop_assert_eq!(soup.1, good.1);
    }

    #[test]
    fn repair_never_adds_a_misoriented_edge((positions, mut indices) in soup()) {
        let before = Topology::of(&positions, &indices);
        let repair = orient_triangles(&positions, &mut indices);
        let after = Topology::of(&positions, &indices);
        prop_assert!(after.misoriented_edges <= before.misoriented_edges);
        prop_assert_eq!(after.misoriented_edges == 0, repair.left == 0);
        prop_assert_eq!(after.edges, before.edges);
    }
}
