//! Occluders that are any triangles: patches of a surface, with the edges that their facets share.
//!
//! ```text
//! triangles ─ weld ─► facets   pairs that are nearly flat together become convex quads
//!                     edges    half-edges of opposite direction matched, what is left over has one facet
//!                     parts connected by edges ─ split at the median ─► patches of at most 128 facets
//!                     each patch: its own facets, and those of its part that share a vertex with it
//! ```

mod chunks;
mod curve;
mod facet;
mod layout;
mod split;

use alloc::vec::Vec;
pub(crate) use chunks::Chunks;

use facet::{Facet, paired};
use layout::{Layout, cone};
use split::Split;

use super::super::OcclusionError;
use super::super::raster::{Canvas, Connected, OcclusionBuffer};
use crate::Simd;
use crate::array::Each;
use crate::bounds::Aabb;
use crate::mesh::weld;
use crate::transform::Transform;

/// A few neighbouring triangles of a surface, drawn as one.
///
/// A pixel is covered where its triangles cover it together, and nothing of them ends in it. So
/// that no crack runs along the seam between two patches of a surface, the triangles around a patch
/// are kept too.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub(super) mesh: Connected,
}

impl Patch {
    /// Facets of a patch as a rule.
    pub const FACETS: usize = 128;

    /// Cuts a surface into patches of at most `most` facets, triangles or pairs of them that make a
    /// flat quad; [`FACETS`](Self::FACETS) is good: fewer find more and cost more. None is taken as
    /// one, and more than that as that. Positions that are equal are one vertex. `two_sided`
    /// triangles hide from both sides.
    ///
    /// Of more than two triangles at an edge, or of two that wind differently, only pairs that wind
    /// alike are joined; the others end there. Triangles with two equal corners are left out. Cost:
    /// about a microsecond a triangle; at most 48 bytes are kept of each in a mesh of ordinary
    /// shape.
    ///
    /// # Errors
    /// If an index is out of range, or a position is not finite.
    pub fn cut(
        positions: &[[f32; 3]],
        indices: &[u32],
        most: usize,
        two_sided: bool,
    ) -> Result<Vec<Self>, OcclusionError> {
        if let Some(&index) = indices.iter().find(|&&v| v as usize >= positions.len()) {
            return Err(OcclusionError::Index(index, positions.len()));
        }
        check_finite(positions)?;
        let same = weld(positions);
        let triangles = indices.as_chunks::<3>().0.iter();
        let triangles = triangles.map(|t| Facet::triangle(t.each(|v| same[v as usize])));
        let facets = paired(positions, triangles.filter(Facet::is_whole).collect());
        let mut layout = Layout::new(positions.len());
        let mut patches = Vec::new();
        let most = most.clamp(1, Self::FACETS);
        Split::new(positions, &facets, most).for_patches(|own, around| {
            let mut mesh = Connected::default();
            layout.lay_out(own, around, two_sided, &mut mesh);
            mesh.place(positions, layout.vertices());
            (mesh.axis, mesh.sine) = cone(positions, own);
            mesh.shrink();
            patches.push(Self { mesh });
        });
        Ok(patches)
    }

    /// One without facets.
    pub(crate) fn none() -> Self {
        Self { mesh: Connected::default() }
    }

    /// Its layout.
    pub(crate) fn connected(&mut self) -> &mut Connected {
        &mut self.mesh
    }

    /// Draws it into `buffer`. Nothing where a number is not finite, and before
    /// [`OcclusionBuffer::begin`].
    pub fn draw(&self, simd: Simd, buffer: &mut OcclusionBuffer, transform: &Transform) {
        self.draw_on(simd, &mut buffer.canvas(), transform);
    }

    /// Draws it onto a canvas.
    pub(crate) fn draw_on(&self, simd: Simd, canvas: &mut Canvas<'_>, transform: &Transform) {
        canvas.draw_connected(simd, &self.mesh, transform);
    }

    /// The box around its own triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.mesh.bounds
    }

    /// The facets that are its own, and then those around them, as serde keeps them.
    #[cfg(feature = "serde")]
    pub(super) fn facets(&self) -> [Vec<[u32; 4]>; 2] {
        use super::super::raster::corners_of;
        let mut lists = [Vec::new(), Vec::new()];
        let mut rest = &self.mesh.corners[..];
        for (kind, &groups) in self.mesh.groups.iter().enumerate() {
            let (rows, more) = rest.split_at(corners_of(kind) * usize::from(groups));
            rest = more;
            for group in rows.chunks(corners_of(kind)) {
                for lane in 0..group[0].len() {
                    let at = |k: usize| u32::from(group[k.min(group.len() - 1)][lane]);
                    let facet = Facet { corners: [0, 1, 2, 3].each(at) };
                    if facet.is_whole() {
                        lists[kind / 2].push(facet.corners);
                    }
                }
            }
        }
        lists
    }

    /// One of facets that were kept.
    #[cfg(feature = "serde")]
    pub(super) fn from_facets(
        positions: &[[f32; 3]],
        own: &[[u32; 4]],
        around: &[[u32; 4]],
        two_sided: bool,
    ) -> Result<Self, OcclusionError> {
        check_finite(positions)?;
        let count = own.len();
        if count > Self::FACETS {
            let end = count as u32;
            return Err(OcclusionError::Range { start: 0, end, count: Self::FACETS });
        }
        let [own, around] = [own, around].each(|list| -> Vec<Facet> {
            let facets = list.iter().map(|&corners| Facet { corners });
            facets.filter(Facet::is_whole).collect()
        });
        let mut mesh = Connected::default();
        let mut layout = Layout::new(positions.len());
        layout.lay_out(&own, &around, two_sided, &mut mesh);
        mesh.place(positions, layout.vertices());
        (mesh.axis, mesh.sine) = cone(positions, &own);
        mesh.shrink();
        Ok(Self { mesh })
    }

    /// Its vertices, those of the triangles around it included.
    #[cfg(feature = "serde")]
    pub(super) fn vertices(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        let [x, y, z] = &self.mesh.places;
        (0..x.len()).map(|v| [x[v], y[v], z[v]])
    }
}

pub(crate) fn check_finite(positions: &[[f32; 3]]) -> Result<(), OcclusionError> {
    // All of them without a branch: one after the other takes four times as long.
    let is_finite = positions.as_flattened().iter().fold(true, |all, v| all & v.is_finite());
    if is_finite {
        return Ok(());
    }
    match positions.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        Some(vertex) => Err(OcclusionError::NotFinite { vertex, position: positions[vertex] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::raster::{FACETS as LANES, NEVER};
    use super::*;

    /// A grid of quads, two triangles each.
    fn grid(n: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let at = |x: u32, y: u32| y * (n + 1) + x;
        let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, 0.0]));
        let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        let indices = cells.flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [a, b, c, a, c, d]
        });
        (points.collect(), indices.collect())
    }

    #[test]
    fn a_grid_becomes_quads_of_which_only_those_at_its_rim_have_open_edges() {
        let (positions, indices) = grid(40);
        let patches = Patch::cut(&positions, &indices, Patch::FACETS, false).unwrap();
        let mut own = 0;
        for Patch { mesh } in &patches {
            assert!(mesh.groups[1] == 0 && mesh.groups[3] == 0, "{:?}", mesh.groups);
            assert!(mesh.sine < 0.01 && mesh.axis[2] > 0.99);
            let end = LANES as u16 * (1 + mesh.groups[0]);
            let mut open = 0;
            for rows in &mesh.edges {
                for lane in 0..LANES {
                    let [f, g] = [rows[0][lane], rows[1][lane]];
                    let is_own = [f, g].iter().any(|&f| f != NEVER && f < end);
                    open += u32::from(is_own && (f == NEVER || g == NEVER));
                }
            }
            let b = mesh.bounds;
            let touches = (0..2).any(|a| b.min[a] == 0.0 || b.max[a] == 40.0);
            assert_eq!(open > 0, touches, "{open} of {b:?}");
            let whole = mesh.corners[..usize::from(mesh.groups[0]) * 4].as_chunks::<4>().0;
            own += whole
                .iter()
                .map(|q| (0..LANES).filter(|&l| q[0][l] != q[1][l]).count())
                .sum::<usize>();
        }
        assert_eq!(own, 1600);
    }

    #[test]
    fn a_triangle_of_a_grid_takes_48_bytes_at_most() {
        let (positions, indices) = grid(100);
        let patches = Patch::cut(&positions, &indices, Patch::FACETS, false).unwrap();
        let bytes: usize = patches.iter().map(|p| p.mesh.bytes()).sum();
        assert!(bytes <= 48 * indices.len() / 3, "{}", bytes * 3 / indices.len());
    }

    #[test]
    fn a_fan_of_too_many_keeps_no_facets_around() {
        let count = 9000;
        let point = |i: u32| {
            let angle = i as f32 / count as f32 * core::f32::consts::TAU;
            [angle.cos(), angle.sin(), 0.0]
        };
        let positions: Vec<_> = (0..count).map(point).chain([[0.0; 3]]).collect();
        let indices: Vec<u32> = (0..count).flat_map(|i| [i, (i + 1) % count, count]).collect();
        let patches = Patch::cut(&positions, &indices, Patch::FACETS, true).unwrap();
        assert!(patches.iter().all(|p| p.mesh.groups[2..] == [0, 0]));
        assert!(patches.len() >= 9000 / 256);
    }
}
