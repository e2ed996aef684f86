//! Meshes of the engine.

use cullet::mesh::{Alpha, Part};
use cullet::{Mesh, MeshData};

use crate::Rng;
use crate::soups::{self, Soup};

/// The data of a mesh of one part, which is one-sided.
pub fn one_sided_data((positions, indices): Soup) -> MeshData {
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, ..Part::default() }];
    MeshData { positions, indices, parts, ..MeshData::default() }
}

/// A mesh of one part, which is one-sided.
pub fn one_sided(soup: Soup) -> Mesh {
    made(one_sided_data(soup))
}

/// A mesh of these parts; of one two-sided part where there are none.
pub fn of_parts((positions, indices): Soup, parts: Vec<Part>) -> Mesh {
    made(MeshData { positions, indices, parts, ..MeshData::default() })
}

fn made(data: MeshData) -> Mesh {
    Mesh::new(data).expect("a good mesh")
}

/// The box between two corners, one-sided.
pub fn block(min: [f32; 3], max: [f32; 3]) -> Mesh {
    one_sided(soups::block(min, max))
}

/// The unit ball of `rings` × 2 `rings` quads, one-sided, of many clusters.
pub fn ball(rings: u32) -> Mesh {
    one_sided(soups::ball(rings, rings * 2))
}

/// A regular tetrahedron, one-sided.
pub fn tetrahedron() -> Mesh {
    Mesh::new(MeshData {
        positions: vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        parts: vec![Part { triangle_count: 4, ..Part::default() }],
        ..MeshData::default()
    })
    .expect("a good mesh")
}

/// A bumpy sphere of some hundred triangles, one-sided or not, sometimes with degenerate triangles.
pub fn blob(rng: &mut Rng) -> Mesh {
    let (rings, segments) = (6 + rng.below(8) as u32, 6 + rng.below(10) as u32);
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..segments {
            let (a, b) = (
                std::f64::consts::PI * f64::from(i) / f64::from(rings),
                std::f64::consts::TAU * f64::from(j) / f64::from(segments),
            );
            let r = rng.range(0.8, 1.2);
            positions.push(
                [r * a.sin() * b.cos(), r * a.cos(), r * a.sin() * b.sin()].map(|v| v as f32),
            );
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..segments {
            let k = (j + 1) % segments;
            let (a, b) = (i * segments + j, i * segments + k);
            let (c, d) = (a + segments, b + segments);
            indices.extend([a, b, c, b, d, c]);
        }
    }
    if rng.below(3) == 0 {
        indices.extend([0, 0, 1, 2, 3, 2]);
    }
    let triangles = (indices.len() / 3) as u32;
    let half = triangles / 2;
    let parts = vec![
        Part { triangle_count: half, two_sided: rng.below(3) == 0, ..Part::default() },
        Part {
            first_triangle: half,
            triangle_count: triangles - half,
            material: 1,
            two_sided: rng.below(3) == 0,
            ..Part::default()
        },
    ];
    Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).expect("a good mesh")
}

/// Triangles anywhere, in parts of every kind, some of them sharing edges, some without area.
pub fn of_all_kinds(rng: &mut Rng, triangles: u32) -> Mesh {
    let vertices = triangles + 2;
    let grid = rng.chance(0.3);
    let positions = (0..vertices)
        .map(|_| {
            std::array::from_fn(|_| {
                let v = rng.range(-3.0, 3.0);
                // On a coarse grid, edges meet samples and planes meet planes.
                (if grid { (v * 2.0).round() * 0.5 } else { v }) as f32
            })
        })
        .collect();
    let indices: Vec<u32> =
        (0..triangles * 3).map(|_| rng.below(u64::from(vertices)) as u32).collect();
    let mut parts = Vec::new();
    let mut first = 0;
    while first < triangles {
        let count = (1 + rng.below(5) as u32).min(triangles - first);
        parts.push(Part {
            first_triangle: first,
            triangle_count: count,
            material: parts.len() as u32,
            two_sided: rng.chance(0.5),
            alpha: [Alpha::Opaque, Alpha::Opaque, Alpha::Masked, Alpha::Blended]
                [rng.below(4) as usize],
        });
        first += count;
    }
    of_parts((positions, indices), parts)
}
