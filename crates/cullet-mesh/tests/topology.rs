//! Topology of shapes made here, against an oracle.

use std::collections::BTreeMap;

use cullet::mesh::{Alpha, Part};
use cullet::{Mesh, MeshData};
use cullet_mesh::{NotSolid, Topology, solid};
use cullet_testkit::soups::{Soup, ball_at, block, join, turned};
use proptest::prelude::*;

fn part(first_triangle: u32, triangle_count: u32, material: u32) -> Part {
    Part { first_triangle, triangle_count, material, ..Part::default() }
}

#[test]
fn an_empty_mesh_is_no_solid() {
    let mesh = Mesh::new(MeshData::default()).expect("empty is valid");
    assert_eq!(solid(&mesh), Err(NotSolid::Empty));
    assert_eq!(Topology::of_mesh(&mesh), Topology::default());
}

#[test]
fn a_block_is_a_solid_in_any_arrangement_of_parts() {
    let (positions, indices) = block([-1.0; 3], [2.0; 3]);
    let mut source = MeshData { positions, indices, ..MeshData::default() };
    source.parts = vec![part(0, 5, 0), part(5, 7, 1)];
    let mesh = Mesh::new(source.clone()).expect("valid");
    assert_eq!(solid(&mesh), Ok(()));
    let t = Topology::of_mesh(&mesh);
    assert_eq!((t.vertices, t.triangles, t.edges, t.shells), (8, 12, 18, 1));
    assert!((t.volume - 27.0).abs() < 1e-12);
    source.parts[1].alpha = Alpha::Masked;
    let mesh = Mesh::new(source).expect("valid");
    assert_eq!(solid(&mesh), Err(NotSolid::NotOpaque { part: 1 }));
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
    let why = |(p, i): &Soup| Topology::of(p, i).solid();
    let cube = block([0.0; 3], [1.0; 3]);
    let mut open = cube.clone();
    open.1.truncate(33);
    assert_eq!(why(&open), Err(NotSolid::Open { edges: 3 }));
    let touching = join([cube.clone(), block([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])]);
    assert_eq!(why(&touching), Err(NotSolid::NonManifold { edges: 1 }));
    let mut mixed = cube.clone();
    mixed.1.swap(1, 2);
    assert_eq!(why(&mixed), Err(NotSolid::Misoriented { edges: 3 }));
    assert_eq!(why(&turned(cube.clone())), Err(NotSolid::Inward { volume: -1.0 }));
    let one_bad = join([cube.clone(), turned(block([5.0; 3], [5.5; 3]))]);
    assert_eq!(why(&one_bad), Err(NotSolid::InwardShells { shells: 1, of: 2 }));
    // A tetrahedron squeezed into a plane: no volume, but rounding on the way to it.
    let flat = [[0.1, 0.3], [0.7, 0.2], [0.3, 0.9], [0.4, 0.6]].map(|[u, v]| [u, v, u]);
    let sides = vec![0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
    assert_eq!(why(&(flat.to_vec(), sides)), Err(NotSolid::NoVolume));
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
}
