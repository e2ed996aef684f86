//! The tables of a mesh's levels, as they lie in files.

use cullet::lod::{Group, Levels};
use cullet::mesh::{Cluster, Clustering, Part};
use cullet::{Mesh, MeshData};

use super::error::BakedError;
use super::hash::{Sum, hash};
use super::{LevelKind, Measured};
use crate::bytes::{of_u32s, put_f32s, put_u32s, to_f32s, to_u32s};

/// A cluster: a row of its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClusterRow {
    /// Its first triangle.
    pub first_triangle: u32,
    /// How many it has.
    pub triangle_count: u32,
    /// The group that it was made by simplifying, or `u32::MAX`.
    pub made_from: u32,
    /// The group that it was simplified in, or `u32::MAX`.
    pub replaced_by: u32,
}

/// Levels of a mesh as plain tables. Triangles are in the order of the clusters, clusters in that
/// of the parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelTables {
    /// How many triangles each part of the mesh has in all levels together.
    pub parts: Vec<u32>,
    /// Three vertices of the mesh a triangle.
    pub indices: Vec<u32>,
    /// The clusters.
    pub clusters: Vec<ClusterRow>,
    /// The groups.
    pub groups: Vec<Group>,
}

/// Bytes of a row of each table: triangle, cluster, group.
pub(crate) const ROWS: [(&str, usize); 3] =
    [("its indices", 12), ("its clusters", 16), ("its groups", 20)];

impl LevelTables {
    /// The tables of levels that a mesh holds; `None` if triangles of its parts are mixed, or some
    /// are in no cluster.
    #[must_use]
    pub fn of(held_by: &Mesh, levels: &Levels) -> Option<Self> {
        let clusters = held_by.clusters();
        let fits = held_by.degenerate_count() == 0
            && clusters.is_sorted_by_key(|c| c.part)
            && clusters.len() == levels.made_from().len();
        if !fits {
            return None;
        }
        let mut parts = vec![0; held_by.parts().len()];
        clusters.iter().for_each(|c| parts[c.part as usize] += c.triangle_count);
        let group = levels.made_from().iter().zip(levels.replaced_by());
        let row = |(c, (&made_from, &replaced_by)): (&Cluster, (&u32, &u32))| ClusterRow {
            first_triangle: c.first_triangle,
            triangle_count: c.triangle_count,
            made_from,
            replaced_by,
        };
        Some(Self {
            parts,
            indices: held_by.indices().to_vec(),
            clusters: clusters.iter().zip(group).map(row).collect(),
            groups: (0..levels.group_count()).map(|g| levels.group(g)).collect(),
        })
    }

    /// The mesh that holds the levels of `base`, and the levels.
    ///
    /// # Errors
    /// If they do not fit it, or are none: every number is checked.
    pub fn build(self, base: &Mesh) -> Result<(Mesh, Levels), BakedError> {
        let Self { parts: counts, indices, clusters: rows, groups } = self;
        let count = |what, found: u64, expected: u64| match found == expected {
            true => Ok(()),
            false => Err(BakedError::Count { what, found, expected }),
        };
        count("parts of the levels", counts.len() as u64, base.parts().len() as u64)?;
        let triangles = (indices.len() / 3) as u64;
        let total = counts.iter().map(|&n| u64::from(n)).sum();
        count("triangles of all levels", triangles, total)?;
        let mut first_triangle = 0;
        let part = |(part, &triangle_count): (&Part, &u32)| {
            let part = Part { first_triangle, triangle_count, ..*part };
            // No more than there are indices, as was just seen.
            first_triangle += triangle_count;
            part
        };
        let parts: Vec<Part> = base.parts().iter().zip(&counts).map(part).collect();
        let cluster = |row: &ClusterRow| {
            let after = parts.partition_point(|p| p.first_triangle <= row.first_triangle);
            // Of parts that begin at one triangle, the last has it. One that is in no part is
            // refused below.
            let part = after.saturating_sub(1) as u32;
            Cluster { first_triangle: row.first_triangle, triangle_count: row.triangle_count, part }
        };
        let clusters: Vec<Cluster> = rows.iter().map(cluster).collect();
        if let Some(at) =
            clusters.iter().position(|c| c.first_triangle.checked_add(c.triangle_count).is_none())
        {
            return Err(BakedError::Form(format!(
                "cluster {at} has more triangles than there are"
            )));
        }
        let order: Vec<u32> = (0..triangles as u32).collect();
        let data = MeshData {
            positions: base.positions().to_vec(),
            indices,
            parts,
            ..MeshData::default()
        };
        let held_by = Mesh::with_clusters(data, &Clustering { order, clusters })?;
        let made_from = rows.iter().map(|r| r.made_from).collect();
        let replaced_by = rows.iter().map(|r| r.replaced_by).collect();
        let levels = Levels::new(&held_by, &groups, made_from, replaced_by)?;
        Ok((held_by, levels))
    }

    /// The bytes of indices, clusters and groups: little-endian, row after row.
    #[must_use]
    pub fn to_bytes(&self) -> [Vec<u8>; 3] {
        let (mut clusters, mut groups) = (Vec::new(), Vec::new());
        for r in &self.clusters {
            let row = [r.first_triangle, r.triangle_count, r.made_from, r.replaced_by];
            put_u32s(&mut clusters, &row);
        }
        for g in &self.groups {
            let [x, y, z] = g.centre;
            put_f32s(&mut groups, &[x, y, z, g.radius, g.error]);
        }
        [of_u32s(&self.indices), clusters, groups]
    }

    /// Tables of such bytes; what they say is not looked at.
    ///
    /// # Errors
    /// If they are no whole rows.
    pub fn from_bytes(parts: Vec<u32>, bytes: [&[u8]; 3]) -> Result<Self, BakedError> {
        for (bytes, (what, row)) in bytes.iter().zip(ROWS) {
            if bytes.len() % row != 0 {
                return Err(BakedError::Size { what, bytes: bytes.len(), row });
            }
        }
        let [indices, clusters, groups] = bytes;
        let cluster = |&[first_triangle, triangle_count, made_from, replaced_by]: &[u32; 4]| {
            ClusterRow { first_triangle, triangle_count, made_from, replaced_by }
        };
        let group =
            |&[x, y, z, radius, error]: &[f32; 5]| Group { centre: [x, y, z], radius, error };
        Ok(Self {
            parts,
            indices: to_u32s(indices),
            clusters: to_u32s(clusters).as_chunks::<4>().0.iter().map(cluster).collect(),
            groups: to_f32s(groups).as_chunks::<5>().0.iter().map(group).collect(),
        })
    }
}

/// The sum of what is baked of a mesh: of the geometry, and for each of its levels of all that the
/// file says.
pub(crate) fn sum_of<'a>(
    geometry: u64,
    levels: impl Iterator<Item = (LevelKind, &'a Measured, &'a [u32], [&'a [u8]; 3])>,
) -> u64 {
    let mut sum = Sum::new(geometry);
    for (kind, measured, parts, bytes) in levels {
        sum.add(hash(kind.name().as_bytes()));
        let Measured { points, reverse_points, quantile, most_over, seed } = measured;
        sum.add(u64::from(*points) | u64::from(*reverse_points) << 32);
        [quantile.to_bits(), most_over.to_bits(), *seed].into_iter().for_each(|w| sum.add(w));
        sum.add(parts.len() as u64);
        parts.iter().for_each(|&n| sum.add(n.into()));
        bytes.into_iter().for_each(|bytes| sum.add(hash(bytes)));
    }
    sum.end()
}
