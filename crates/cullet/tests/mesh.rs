//! Meshes: construction, clusters and regions, on shapes made here.

use cullet::bounds::{Aabb, Boxes};
use cullet::mesh::{
    Cluster, Clustering, MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES, MeshError, Part, Regions,
    connected_regions, is_degenerate,
};
use cullet::{Mesh, MeshData};
use cullet_testkit::soups::{Soup, block, terrain};
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

/// Triangles among few points, so that edges meet often; some points are in one place.
fn soup() -> impl Strategy<Value = Soup> {
    let coordinate = prop_oneof![Just(0.0f32), Just(-0.0), Just(1.0), Just(2.0)];
    let points = prop::collection::vec(prop::array::uniform3(coordinate), 4..14);
    points.prop_flat_map(|p| {
        let n = p.len() as u32;
        (Just(p), prop::collection::vec(0..n, 0..120))
    })
}

/// The slow oracle: any two chosen triangles with two positions in common get one number, until nothing changes.
fn regions_ref(
    positions: &[[f32; 3]],
    indices: &[u32],
    chosen: impl Fn(usize) -> bool,
) -> Vec<u32> {
    let corners = |t: usize| [0, 1, 2].map(|i| positions[indices[t * 3 + i] as usize]);
    let is_taken = |t: usize| {
        let [a, b, c] = corners(t);
        a != b && b != c && c != a && chosen(t)
    };
    let mut of: Vec<u32> = (0..indices.len() as u32 / 3)
        .map(|t| if is_taken(t as usize) { t } else { Regions::NONE })
        .collect();
    for a in 0..of.len() {
        for b in (0..a).filter(|&b| is_taken(a) && is_taken(b)) {
            let shared = corners(a).iter().filter(|p| corners(b).contains(p)).count();
            let (old, new) = (of[a], of[b]);
            if shared >= 2 {
                of.iter_mut().filter(|o| **o == old).for_each(|o| *o = new);
            }
        }
    }
    let mut numbers = Vec::new();
    for o in of.iter_mut().filter(|o| **o != Regions::NONE) {
        let at = numbers.iter().position(|n| n == o);
        let at = at.unwrap_or_else(|| {
            numbers.push(*o);
            numbers.len() - 1
        });
        *o = at as u32;
    }
    of
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(200)))]

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
    fn regions_equal_the_oracle((positions, indices) in soup(), left_out in 1usize..9) {
        let chosen = |t: usize| t % left_out != 1;
        let found = connected_regions(&positions, &indices, chosen);
        prop_assert_eq!(&found.of, &regions_ref(&positions, &indices, chosen));
        for (region, count) in (0..).zip(&found.triangles) {
            prop_assert_eq!(found.of.iter().filter(|r| **r == region).count(), *count as usize);
        }
    }
}
