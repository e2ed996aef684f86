//! Tables as they lie in a file: of levels, merged groups, occluders and impostors.

use std::ops::Range;

use cullet_mesh::Impostor;

use crate::baked::{BakedError, LevelTables, Occluders, ROWS, impostor_from_bytes};
use crate::gltf::ListedGroup;

/// Levels of a mesh: slices of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSlices<'a> {
    /// How many triangles of all levels each primitive of triangles has; they follow each other.
    pub parts: &'a [u32],
    /// The vertices of each triangle, in the order of the clusters: a cluster is a range to draw.
    pub indices: &'a [[u32; 3]],
    /// Four numbers per cluster: first triangle, triangle count, the group it was made by
    /// simplifying, the group it was simplified in; `u32::MAX` for none.
    pub clusters: &'a [[u32; 4]],
    /// Five numbers per group: centre and radius of a sphere around it, error.
    pub groups: &'a [[f32; 5]],
}

impl<'a> LevelSlices<'a> {
    pub(super) fn new(
        file: &'a [u8],
        parts: &'a [u32],
        tables: &[Range<usize>; 3],
    ) -> Result<Self, BakedError> {
        let [indices, clusters, groups] = tables;
        let what = |table: usize| ROWS[table].0;
        Ok(Self {
            parts,
            indices: cast(file, what(0), indices)?,
            clusters: cast(file, what(1), clusters)?,
            groups: cast(file, what(2), groups)?,
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

/// A merged group of instances: slices of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSlices<'a> {
    /// The vertices of all levels, around the origin of the group.
    pub positions: &'a [[f32; 3]],
    /// Their texture coordinates; empty where they have none.
    pub uvs: &'a [[f32; 2]],
    /// Their linear colours and alpha; empty where they have none.
    pub colors: &'a [[f32; 4]],
    /// Its levels, whose triangles are of these vertices.
    pub levels: LevelSlices<'a>,
}

impl<'a> GroupSlices<'a> {
    pub(super) fn new(file: &'a [u8], listed: &'a ListedGroup) -> Result<Self, BakedError> {
        let [uvs, colors] = match &listed.attributes {
            Some((ranges, _)) => ranges.clone(),
            None => [0..0, 0..0],
        };
        Ok(Self {
            positions: cast(file, "its positions", &listed.positions)?,
            uvs: cast(file, "its texture coordinates", &uvs)?,
            colors: cast(file, "its colours", &colors)?,
            levels: LevelSlices::new(file, &listed.parts, &listed.tables)?,
        })
    }
}

/// Occluders of a mesh: slices of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OccluderSlices<'a> {
    bytes: &'a [u8],
    /// Boxes within what the mesh seals off: low and high corner.
    pub boxes: &'a [[[f32; 3]; 2]],
    /// Boxes around what the shells that hold those seal off.
    pub sealed: &'a [[[f32; 3]; 2]],
    /// For each polygon how many corners it has, from how many sides it blocks, and the bits of its
    /// tolerance.
    pub polygons: &'a [[u32; 3]],
    /// For each sheet, those near after the others, how many triangles it has and from how many
    /// sides it blocks.
    pub sheets: &'a [[u32; 2]],
    /// How many of the sheets are not for near eyes alone.
    pub far_sheets: u32,
    /// The corners of all polygons, one after another.
    pub corners: &'a [[f32; 3]],
    /// The triangles of all sheets, one after another.
    pub triangles: &'a [[[f32; 3]; 3]],
    /// The share of the mesh's silhouette that they cover, 0 to 1.
    pub efficiency: f64,
}

impl<'a> OccluderSlices<'a> {
    /// Counts are held against the bytes that there are.
    pub(super) fn new(file: &'a [u8], range: &Range<usize>) -> Result<Self, BakedError> {
        let form = |what: &str| BakedError::Form(format!("its occluders: {what}"));
        let words: &[u32] = cast(file, "its occluders", range)?;
        let short = || form("has more polygons and sheets than bytes");
        let (head, rest) = words.split_first_chunk::<8>().ok_or_else(|| form("cut short"))?;
        let &[boxes, sealed, polygons, sheets, near, low, high, _] = head;
        // No count reaches 2^32, so that no product of two overflows.
        let size = |count: u64, row: u64| (count * row) as usize;
        let (rows, rest) = rest.split_at_checked(size(polygons.into(), 3)).ok_or_else(short)?;
        let all_sheets = u64::from(sheets) + u64::from(near);
        let (sheet_rows, numbers) = rest.split_at_checked(size(all_sheets, 2)).ok_or_else(short)?;
        let (polygons, sheet_rows) = (rows.as_chunks::<3>().0, sheet_rows.as_chunks::<2>().0);
        let corners: u64 = polygons.iter().map(|p| u64::from(p[0])).sum();
        let triangles: u64 = sheet_rows.iter().map(|s| u64::from(s[0])).sum();
        let expected = (u64::from(boxes) + u64::from(sealed)) * 6 + corners * 3 + triangles * 9;
        let found = numbers.len() as u64;
        if found != expected {
            return Err(BakedError::Count { what: "numbers of its occluders", found, expected });
        }
        let numbers: &[f32] = bytemuck::cast_slice(numbers);
        let (of_boxes, rest) = numbers.split_at(size(boxes.into(), 6));
        let (of_sealed, rest) = rest.split_at(size(sealed.into(), 6));
        let (of_corners, rest) = rest.split_at(size(corners, 3));
        Ok(Self {
            bytes: &file[range.clone()],
            boxes: bytemuck::cast_slice(of_boxes),
            sealed: bytemuck::cast_slice(of_sealed),
            polygons,
            sheets: sheet_rows,
            far_sheets: sheets,
            corners: bytemuck::cast_slice(of_corners),
            triangles: bytemuck::cast_slice(rest),
            efficiency: f64::from_bits(u64::from(low) | u64::from(high) << 32),
        })
    }

    /// The rows of the sheets that are not for near eyes alone.
    pub fn far(&self) -> impl Iterator<Item = &'a [u32; 2]> {
        self.sheets.iter().take(self.far_sheets as usize)
    }

    /// A copy, of which every number was looked at.
    ///
    /// # Errors
    /// If a number is not finite, or is none that it can be.
    pub fn to_tables(&self) -> Result<Occluders, BakedError> {
        Occluders::from_bytes(self.bytes)
    }
}

/// The impostor of a mesh: slices of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpostorSlices<'a> {
    bytes: &'a [u8],
    /// Frames along a side of the grid.
    pub grid: u32,
    /// Texels along a side of a frame.
    pub texels: u32,
    /// How far what is drawn is off at the most, in units of the mesh.
    pub error: f32,
    /// Coverage, part and depth of each texel, as in [`cullet_mesh::Impostor::shape`].
    pub shape: &'a [u16],
    /// Normal of each texel, as in [`cullet_mesh::Impostor::normals`].
    pub normals: &'a [u16],
}

impl<'a> ImpostorSlices<'a> {
    /// Sizes are held against the bytes that there are.
    pub(super) fn new(file: &'a [u8], range: &Range<usize>) -> Result<Self, BakedError> {
        let what = "its impostor";
        let words: &[u32] = cast(file, what, range)?;
        let size = || BakedError::Size { what, bytes: range.len(), row: 64 };
        let (head, planes) = words.split_first_chunk::<16>().ok_or_else(size)?;
        let count = Impostor::texel_count([head[0], head[1]])?;
        let (found, expected) = (planes.len() as u64, count as u64);
        if found != expected {
            return Err(BakedError::Count { what: "texels of its impostor", found, expected });
        }
        let planes: &[u16] = bytemuck::cast_slice(planes);
        let (shape, normals) = planes.split_at(count);
        let (bytes, error) = (&file[range.clone()], f32::from_bits(head[9]));
        Ok(Self { bytes, grid: head[0], texels: head[1], error, shape, normals })
    }

    /// A copy, of which every number was looked at.
    ///
    /// # Errors
    /// If it says what no impostor is.
    pub fn to_impostor(&self) -> Result<Impostor, BakedError> {
        impostor_from_bytes(self.bytes)
    }
}

/// Rows of a table, which is whole rows.
fn cast<'a, T: bytemuck::AnyBitPattern>(
    file: &'a [u8],
    what: &'static str,
    range: &Range<usize>,
) -> Result<&'a [T], BakedError> {
    // Of nothing it does not matter where it lies.
    if range.is_empty() {
        return Ok(&[]);
    }
    let unaligned = BakedError::Unaligned { what, at: range.start };
    bytemuck::try_cast_slice(&file[range.clone()]).map_err(|_| unaligned)
}
