//! Triangles of one draw, prepared to be tested one by one. Pure computation.
//!
//! Zhang & Hoff, *Fast Backface Culling Using Normal Masks* (1997), planned their test for hardware
//! that keeps its lists of polygons: two bytes a triangle beside them, 256 bytes a frame, one AND.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::Sphere;
use cullet::cull::backface::Planes8;
use cullet_mesh::{MaskGrid, NormalMask};
use glam::DVec3;

use super::error::GpuError;

/// Triangles that a workgroup tests.
const BLOCK: u32 = 256;
/// A triangle is too thin for its class, so that others need not be doubted as much as it, where so
/// few are thinner,
const THIN: usize = 64;
/// or where its inscribed circle is so much smaller than those of half of all.
const THINNER: f64 = 8.0;
/// The bit of a mask that is always set: no grid has as many classes. What has it is never drawn.
pub(crate) const NO_AREA: NormalMask = NormalMask { byte_offset: 254, bit_mask: 1 };
/// The same as a plane: no other has a number as low.
const NO_AREA_PLANE: [u8; 4] = [0; 4];
/// Size code of triangles without a certain size: they are kept.
const NO_SIZE: u8 = u8::MAX;

/// A run of at most 256 triangles of one group: 16 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct TriangleBlock {
    /// The first of them.
    pub first: u32,
    /// How many there are, at least one.
    pub count: u32,
    /// The number of their group: which mask they are tested with.
    pub mask: u32,
    /// Nothing.
    pub padding: u32,
}

/// Sizes that decide how certain it is which side of triangles is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Around all triangles.
    pub(crate) sphere: Sphere,
    /// The radius of the largest circle inscribed in a triangle.
    pub(crate) largest: f64,
    /// No triangle that has a class has a smaller one.
    pub(crate) smallest: f64,
}

/// Triangles that are drawn together and from their front alone, prepared to be tested: the class
/// of each normal in two bytes, each plane in four and the size of each in one.
///
/// In groups, each of which gets a mask of its own each frame: the smaller a group, the more it
/// culls.
#[derive(Clone, Debug)]
pub struct Triangles {
    indices: Vec<u32>,
    classes: Vec<NormalMask>,
    planes: Planes8,
    bytes: Vec<[u8; 4]>,
    sizes: Vec<u8>,
    blocks: Vec<TriangleBlock>,
    groups: Vec<Sphere>,
    grid: MaskGrid,
    shape: Shape,
}

impl Triangles {
    /// Triangles with counter-clockwise fronts, in one group. O(n log n).
    ///
    /// What has two corners at one place is never drawn. What is not finite, or so thin that its
    /// side is not certain, is kept. Two-sided triangles belong into a draw of their own, which is
    /// not tested.
    ///
    /// # Errors
    /// If an index is not below the number of positions, or does not belong to a whole triangle.
    pub fn new(positions: &[[f32; 3]], indices: &[u32], grid: &MaskGrid) -> Result<Self, GpuError> {
        Self::with_groups(positions, indices, grid, &[(indices.len() / 3) as u32])
    }

    /// The same in groups that follow each other, of so many triangles each.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the groups have more or fewer triangles than there are.
    pub fn with_groups(
        positions: &[[f32; 3]],
        indices: &[u32],
        grid: &MaskGrid,
        groups: &[u32],
    ) -> Result<Self, GpuError> {
        let triangles = check(positions.len(), indices, groups)?;
        let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
        let radii: Vec<f64> = triangles.iter().map(|t| inscribed(corners(t))).collect();
        let shape = shape(positions, indices, &radii);
        let planes = Planes8::new(positions, indices);
        let mut made = Self {
            indices: indices.to_vec(),
            classes: Vec::with_capacity(triangles.len()),
            bytes: planes.bytes().iter().map(known).collect(),
            planes,
            sizes: Vec::with_capacity(triangles.len()),
            blocks: Vec::new(),
            groups: Vec::with_capacity(groups.len()),
            grid: grid.clone(),
            shape,
        };
        for (i, (triangle, radius)) in triangles.iter().zip(radii).enumerate() {
            let corners = corners(triangle);
            let class = if has_equal_corners(&corners) {
                made.bytes[i] = NO_AREA_PLANE;
                NO_AREA
            } else if radius >= shape.smallest {
                grid.encode_triangle(corners)
            } else {
                NormalMask::NEVER
            };
            made.classes.push(class);
            made.sizes.push(size_code(radius, shape.largest));
        }
        let mut points = Vec::new();
        let mut first = 0;
        for (mask, count) in (0..).zip(groups) {
            let end = first + count;
            points.clear();
            let own = &triangles[first as usize..end as usize];
            points.extend(own.iter().flat_map(corners));
            made.groups.push(Sphere::from_points(&points));
            while first < end {
                let count = BLOCK.min(end - first);
                made.blocks.push(TriangleBlock { first, count, mask, padding: 0 });
                first += count;
            }
        }
        Ok(made)
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.classes.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.classes.is_empty()
    }

    /// Three indices a triangle.
    #[must_use]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The class of each normal.
    #[must_use]
    pub fn classes(&self) -> &[NormalMask] {
        &self.classes
    }

    /// The plane of each, as [`Planes8::bytes`] has it.
    #[must_use]
    pub fn planes(&self) -> &[[u8; 4]] {
        &self.bytes
    }

    /// The size of each: the largest inscribed circle is at most (4 + the lowest two bits) / 4
    /// times 2 to the power of the others as large as its own; 255 where that is not known.
    #[must_use]
    pub fn sizes(&self) -> &[u8] {
        &self.sizes
    }

    /// Runs of at most 256, in order and without gap.
    #[must_use]
    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// The sphere around each group.
    #[must_use]
    pub fn groups(&self) -> &[Sphere] {
        &self.groups
    }

    /// The cells of normals.
    #[must_use]
    pub fn grid(&self) -> &MaskGrid {
        &self.grid
    }

    pub(crate) fn quantised(&self) -> &Planes8 {
        &self.planes
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }
}

/// The triangles of indices that can be used.
fn check<'a>(
    vertices: usize,
    indices: &'a [u32],
    groups: &[u32],
) -> Result<&'a [[u32; 3]], GpuError> {
    let limit = u64::from(u32::MAX) * 4;
    let bytes = size_of_val(indices) as u64;
    if bytes > limit {
        return Err(GpuError::TooLarge { what: "indices of triangles", bytes, limit });
    }
    let (triangles, rest) = indices.as_chunks::<3>();
    let grouped: u64 = groups.iter().map(|count| u64::from(*count)).sum();
    if !rest.is_empty() || grouped != triangles.len() as u64 {
        return Err(GpuError::Groups { indices: indices.len(), grouped });
    }
    match indices.iter().find(|index| **index as usize >= vertices) {
        Some(&index) => Err(GpuError::Index { index, vertices }),
        None => Ok(triangles),
    }
}

/// A plane, or one that no eye is behind where a mesh that is not finite made it what stands for no
/// area.
fn known(plane: &[u8; 4]) -> [u8; 4] {
    if *plane == NO_AREA_PLANE { [128; 4] } else { *plane }
}

/// Whether a renderer moves two corners to the same point, however it rounds: then no sample is
/// inside.
fn has_equal_corners([a, b, c]: &[[f32; 3]; 3]) -> bool {
    a == b || b == c || c == a
}

/// The radius of the circle inscribed in a triangle; NaN for one that is a point, or not finite.
fn inscribed(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
    let (u, v) = (b - a, c - a);
    u.cross(v).length() / (u.length() + v.length() + (c - b).length())
}

fn shape(positions: &[[f32; 3]], indices: &[u32], radii: &[f64]) -> Shape {
    let mut radii: Vec<f64> = radii.iter().copied().filter(|r| *r > 0.0 && r.is_finite()).collect();
    radii.sort_unstable_by(f64::total_cmp);
    let at = |place: usize| radii.get(place).copied().unwrap_or(1.0);
    let used: Vec<[f32; 3]> = indices.iter().map(|i| positions[*i as usize]).collect();
    Shape {
        sphere: Sphere::from_points(&used),
        largest: radii.last().copied().unwrap_or(1.0),
        smallest: at(radii.len() / THIN).max(at(radii.len() / 2) / THINNER),
    }
}

/// A size, as [`Triangles::sizes`] has it.
fn size_code(radius: f64, largest: f64) -> u8 {
    let ratio = largest / radius;
    // Written so that NaN has no size; a little more for the rounding of both.
    let fits = |code: &u8| ratio * (1.0 + 1e-12) <= ratio_of(*code);
    (0..NO_SIZE).find(fits).unwrap_or(NO_SIZE)
}

/// The ratio that a code stands for.
pub(crate) fn ratio_of(code: u8) -> f64 {
    f64::from(4 + (code & 3)) / 4.0 * f64::from(u32::from(code >> 2)).exp2()
}
