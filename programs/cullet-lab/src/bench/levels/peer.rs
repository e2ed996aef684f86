//! The peer: meshoptimizer's own library of cluster levels, whose errors are the simplifier's.

use cullet::lod::{Group, LevelEye};
use meshopt::{ClodMesh, VertexDataAdapter, clod_build, clod_default_config};

use super::models::Whole;

/// Clusters of its levels, each with the group it was made from, if any, and the one it was
/// simplified in.
#[derive(Debug, Default)]
pub(super) struct PeerLevels {
    clusters: Vec<PeerCluster>,
    groups: Vec<Group>,
}

#[derive(Debug)]
struct PeerCluster {
    indices: Vec<u32>,
    made_from: Option<u32>,
    group: u32,
}

impl PeerLevels {
    /// Its levels of a mesh, by its own defaults for clusters of 128 triangles.
    pub(super) fn new(mesh: &Whole) -> Result<Self, meshopt::Error> {
        let bytes = meshopt::typed_to_bytes(&mesh.positions);
        let vertices = VertexDataAdapter::new(bytes, 12, 0)?;
        let mut made = Self::default();
        clod_build(
            clod_default_config(128),
            &ClodMesh::new(&mesh.indices, &vertices),
            |group, clusters| {
                let number = made.groups.len() as u32;
                let bounds = group.simplified;
                made.groups.push(Group {
                    centre: bounds.center,
                    radius: bounds.radius,
                    error: bounds.error,
                });
                made.clusters.extend(clusters.iter().map(|c| PeerCluster {
                    indices: c.indices.to_vec(),
                    made_from: u32::try_from(c.refined).ok(),
                    group: number,
                }));
                number as i32
            },
        );
        Ok(made)
    }

    /// The corners of the triangles that it draws where its errors are taken so many times.
    pub(super) fn cut(&self, eye: &LevelEye, factor: f32) -> Vec<u32> {
        let over = |g: u32| {
            let group = self.groups[g as usize];
            // The last groups' is the largest number there is, and stays so.
            eye.is_over(&Group { error: (group.error * factor).min(f32::MAX), ..group })
        };
        self.clusters
            .iter()
            .filter(|c| over(c.group) && c.made_from.is_none_or(|g| !over(g)))
            .flat_map(|c| &c.indices)
            .copied()
            .collect()
    }
}
