//! Sides of meshes that name no parts.

use cullet::{Mesh, MeshData};
use cullet_testkit::soups::{self, Soup};

fn is_two_sided((positions, indices): Soup) -> bool {
    let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
    assert_eq!(mesh.parts().len(), 1);
    mesh.is_two_sided()
}

fn cube_at(x: f32) -> Soup {
    soups::block([x - 1.0, -1.0, -1.0], [x + 1.0, 1.0, 1.0])
}

fn inverted((positions, mut indices): Soup) -> Soup {
    indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    (positions, indices)
}

fn both((mut positions, mut indices): Soup, (others, more): Soup) -> Soup {
    let first = positions.len() as u32;
    positions.extend(others);
    indices.extend(more.iter().map(|i| i + first));
    (positions, indices)
}

#[test]
fn bodies_wound_outward_are_one_sided() {
    assert!(!is_two_sided(cube_at(0.0)));
    assert!(!is_two_sided(cube_at(1e6)));
    assert!(!is_two_sided(soups::ball(8, 12)));
    assert!(!is_two_sided(both(cube_at(-3.0), cube_at(3.0))));
    // Vertices that no triangle uses are no body.
    let (mut positions, indices) = cube_at(0.0);
    positions.push([9.0; 3]);
    assert!(!is_two_sided((positions, indices)));
}

#[test]
fn all_else_is_two_sided() {
    let (positions, indices) = cube_at(0.0);
    let open = (positions.clone(), indices[3..].to_vec());
    assert!(is_two_sided(open), "a missing triangle");
    assert!(is_two_sided(inverted(cube_at(0.0))), "wound inward");
    assert!(is_two_sided(both(cube_at(-3.0), inverted(cube_at(3.0)))), "one of two wound inward");
    let mut turned = indices.clone();
    turned.swap(0, 1);
    assert!(is_two_sided((positions.clone(), turned)), "one triangle turned");
    let split: Vec<[f32; 3]> = indices.iter().map(|&i| positions[i as usize]).collect();
    let count = split.len() as u32;
    assert!(is_two_sided((split, (0..count).collect())), "vertices split at every edge");
    assert!(is_two_sided((Vec::new(), Vec::new())), "nothing");
    // Two faces back to back enclose nothing.
    let flat = (positions.clone(), vec![0, 1, 2, 0, 2, 1]);
    assert!(is_two_sided(flat), "flat");
    let soft = MeshData { positions, indices, deformable: true, ..MeshData::default() };
    assert!(Mesh::new(soft).unwrap().is_two_sided(), "deformable");
}
