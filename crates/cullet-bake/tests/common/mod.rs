//! Shapes, checks and models that several test programs use.
#![allow(dead_code, reason = "each test program uses its own share")]

use cullet::mesh::{Clustering, Part};
use cullet::{Mesh, MeshData};
use cullet_bake::clusters::ClusterOptions;
use cullet_testkit::data;

/// One-sided data of one part.
pub(crate) fn one_sided(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> MeshData {
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, ..Part::default() }];
    MeshData { positions, indices, parts, ..MeshData::default() }
}

/// A closed surface around the origin, wound outward: a ball of `rings` × 2 `rings` quads, whose radius is
/// 1 plus `bump` times a wave.
pub(crate) fn ball(rings: u32, bump: f32) -> MeshData {
    let around = rings * 2;
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..around {
            let (polar, azimuth) = (
                i as f32 / rings as f32 * std::f32::consts::PI,
                j as f32 / around as f32 * std::f32::consts::TAU,
            );
            let r = if i == 0 || i == rings { 0.0 } else { polar.sin() };
            let p = [r * azimuth.cos(), polar.cos(), r * azimuth.sin()];
            let wave = (p[0] * 9.0).sin() + (p[1] * 11.0).sin() + (p[2] * 13.0).sin();
            positions.push(p.map(|v| v * (1.0 + bump * wave)));
        }
    }
    let at = |i: u32, j: u32| i * around + j % around;
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            if i > 0 {
                indices.extend([a, b, c]);
            }
            if i + 1 < rings {
                indices.extend([a, c, d]);
            }
        }
    }
    one_sided(positions, indices)
}

/// Triangles that share nothing, in a cube.
pub(crate) fn soup(triangles: u32) -> MeshData {
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let corner: [f32; 3] = std::array::from_fn(|_| random() * 10.0);
        positions.extend((0..3).map(|_| corner.map(|c| c + random() * 0.3)));
    }
    one_sided(positions, (0..triangles * 3).collect())
}

/// Makes a mesh of the clustering, which checks that it is a permutation within the limits of a mesh, and
/// holds it against those of the options.
pub(crate) fn check(data: &MeshData, clustering: &Clustering, options: &ClusterOptions) -> Mesh {
    let mesh = Mesh::with_clusters(data.clone(), clustering).expect("a valid clustering");
    for c in mesh.clusters() {
        let range = c.first_triangle..c.first_triangle + c.triangle_count;
        let mut vertices: Vec<u32> = range.flat_map(|t| mesh.triangle(t)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        assert!(c.triangle_count <= options.max_triangles, "{c:?}");
        assert!(vertices.len() <= options.max_vertices as usize, "{c:?}: {}", vertices.len());
    }
    mesh
}

/// A model of the shared test data as one one-sided mesh, or `None` where it is not there.
pub(crate) fn model(name: &str) -> Option<MeshData> {
    let path = data(name)?;
    let options =
        cullet_io::LoadOptions { two_sided: Some(false), ..cullet_io::LoadOptions::default() };
    let model = cullet_io::load(&path, &options).expect("a model that loads");
    let mesh = model.scene.mesh(0);
    // In the order of the file, as a user has it.
    let mut indices = vec![0; mesh.indices().len()];
    for (triangle, &t) in mesh.indices().chunks_exact(3).zip(mesh.original_triangle()) {
        indices[t as usize * 3..][..3].copy_from_slice(triangle);
    }
    Some(one_sided(mesh.positions().to_vec(), indices))
}
