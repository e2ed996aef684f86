//! Groups whose levels are made, and what is done with their surfaces.

use cullet::mesh::Part;

use crate::gather::{Corner, Gathered, Surface, is_alike};

/// A group whose levels are made.
#[derive(Debug, PartialEq)]
pub(super) struct Made {
    pub(super) origin: [f64; 3],
    pub(super) radius: f32,
    /// From fine to coarse, with what they were found to be off.
    pub(super) levels: Vec<(Surface, f32)>,
}

impl Surface {
    /// Several surfaces of the same kinds of parts as one.
    pub(super) fn join<'a>(
        surfaces: impl Iterator<Item = (&'a Self, [f64; 3])>,
        kinds: &[Part],
    ) -> Self {
        let mut out = Gathered::new();
        for (surface, moved) in surfaces {
            for part in &surface.parts {
                let Some(kind) = kinds.iter().position(|k| is_alike(k, part)) else { continue };
                let range = part.first_triangle as usize * 3..;
                let indices = &surface.indices[range][..part.triangle_count as usize * 3];
                for t in indices.as_chunks::<3>().0 {
                    let corners = t.map(|v| {
                        let (p, values) = surface.corner(v, &mut out);
                        let place = |a: usize| (f64::from(p[a]) + moved[a]) as f32;
                        ([place(0), place(1), place(2)], values)
                    });
                    out.add(kind, corners);
                }
            }
        }
        out.finish(kinds)
    }

    /// A vertex, as a corner of what is gathered.
    fn corner(&self, vertex: u32, to: &mut Gathered) -> Corner {
        let values = self.values.get(vertex as usize).map_or(0, |values| to.number(values));
        (self.positions[vertex as usize], values)
    }

    pub(super) fn triangle_count(&self) -> u64 {
        (self.indices.len() / 3) as u64
    }

    /// Some of its triangles: those of a list of its vertices, which are sorted by part.
    pub(super) fn with_triangles(&self, indices: &[u32]) -> Self {
        let mut part_of = vec![0u32; self.positions.len()];
        for (number, part) in (0..).zip(&self.parts) {
            let range = part.first_triangle as usize * 3..;
            for &v in &self.indices[range][..part.triangle_count as usize * 3] {
                part_of[v as usize] = number;
            }
        }
        let mut out = Gathered::new();
        for t in indices.as_chunks::<3>().0 {
            // All corners are of one part.
            let corners = t.map(|v| self.corner(v, &mut out));
            out.add(part_of[t[0] as usize] as usize, corners);
        }
        out.finish(&self.parts)
    }
}
