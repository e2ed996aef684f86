//! Tables of levels as they lie in a file.

use crate::baked::{BakedError, LevelTables, ROWS};
use crate::gltf::ListedLevels;

/// Levels of a mesh: slices of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSlices<'a> {
    /// How many triangles of all levels each primitive of triangles has; they follow each other.
    pub parts: &'a [u32],
    /// The vertices of each triangle, in the order of the clusters: a cluster is a range to draw.
    pub indices: &'a [[u32; 3]],
    /// Of each cluster: first triangle, how many, the group it was made by simplifying, the group it was simplified in;
    /// `u32::MAX` for none.
    pub clusters: &'a [[u32; 4]],
    /// Of each group: centre and radius of a sphere around it, error.
    pub groups: &'a [[f32; 5]],
}

impl<'a> LevelSlices<'a> {
    pub(super) fn new(file: &'a [u8], listed: &'a ListedLevels) -> Result<Self, BakedError> {
        let [indices, clusters, groups] = &listed.tables;
        Ok(Self {
            parts: &listed.parts,
            indices: cast(file, 0, indices.start, indices.end)?,
            clusters: cast(file, 1, clusters.start, clusters.end)?,
            groups: cast(file, 2, groups.start, groups.end)?,
        })
    }

    /// A copy, of which levels can be built. What they say is not looked at.
    ///
    /// # Errors
    /// None that tables which lie in a file can have.
    pub fn to_tables(&self) -> Result<LevelTables, BakedError> {
        let bytes = [
            bytemuck::cast_slice(self.indices),
            bytemuck::cast_slice(self.clusters),
            bytemuck::cast_slice(self.groups),
        ];
        LevelTables::from_bytes(self.parts.to_vec(), bytes)
    }
}

/// Rows of a table, which is whole rows.
fn cast<T: bytemuck::AnyBitPattern>(
    file: &[u8],
    table: usize,
    start: usize,
    end: usize,
) -> Result<&[T], BakedError> {
    let what = ROWS[table].0;
    let unaligned = BakedError::Unaligned { what, at: start };
    bytemuck::try_cast_slice(&file[start..end]).map_err(|_| unaligned)
}
