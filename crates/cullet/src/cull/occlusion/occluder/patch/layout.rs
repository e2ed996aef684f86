//! The layout of patches: facets and edges in groups of eight, with numbers of sixteen bits.

use glam::DVec3;

use super::super::super::raster::{Connected, FACETS as LANES, MOST_VERTICES, NEVER};
use super::facet::{Facet, NONE, edges, normal};
use crate::bounds::Aabb;

/// Lays out patches of a surface, one after the other; memory for it.
pub(super) struct Layout<'a> {
    positions: &'a [[f32; 3]],
    /// For each vertex the last patch that has it, and its number there.
    patch_of: Vec<u32>,
    number_of: Vec<u16>,
    patches: u32,
}

impl<'a> Layout<'a> {
    pub(super) fn new(positions: &'a [[f32; 3]]) -> Self {
        let count = positions.len();
        Self { positions, patch_of: vec![0; count], number_of: vec![0; count], patches: 0 }
    }

    /// Lays out the own facets of a patch and those around it, both sorted as they are to be drawn. Where those around are
    /// too many, none is kept: then all that borders on them counts as an end of the surface.
    pub(super) fn lay_out(
        &mut self,
        own: &[Facet],
        around: &[Facet],
        two_sided: bool,
    ) -> Connected {
        // Quads first.
        let split = |list: &[Facet]| -> [Vec<Facet>; 2] {
            let (quads, triangles) = list.iter().partition(|f| f.is_quad());
            [quads, triangles]
        };
        let [[own_quads, own_triangles], [quads, triangles]] = [own, around].map(split);
        let kinds = [own_quads, own_triangles, quads, triangles];
        match self.lay_out_kinds(&kinds, two_sided) {
            Some(laid) => laid,
            None => {
                let [own_quads, own_triangles, ..] = kinds;
                let own = [own_quads, own_triangles, Vec::new(), Vec::new()];
                self.lay_out_kinds(&own, two_sided).expect("a patch has few facets of its own")
            }
        }
    }

    fn lay_out_kinds(&mut self, kinds: &[Vec<Facet>; 4], two_sided: bool) -> Option<Connected> {
        self.patches += 1;
        let mut vertices: Vec<u32> = Vec::new();
        let mut own_vertices = 0;
        for (kind, list) in kinds.iter().enumerate() {
            for &v in list.iter().flat_map(Facet::corners) {
                if self.patch_of[v as usize] != self.patches {
                    self.patch_of[v as usize] = self.patches;
                    self.number_of[v as usize] = vertices.len() as u16;
                    vertices.push(v);
                    if vertices.len() > MOST_VERTICES - LANES {
                        return None;
                    }
                }
            }
            if kind == 1 {
                own_vertices = vertices.len();
            }
        }
        let groups = kinds.each_ref().map(|list| list.len().div_ceil(LANES) as u16);
        if groups.iter().map(|&g| usize::from(g)).sum::<usize>() >= MOST_VERTICES / LANES {
            return None;
        }
        let number = |v: u32| self.number_of[v as usize];
        let mut corners = Vec::new();
        let mut numbers = Vec::new();
        let mut first = LANES as u16;
        for list in kinds {
            for group in list.chunks(LANES) {
                for k in 0..group[0].corners().len() {
                    corners.push(std::array::from_fn(|lane| match group.get(lane) {
                        Some(facet) => number(facet.corners[k]),
                        None => number(group[0].corners[0]),
                    }));
                }
                numbers.extend((first..).take(group.len()));
                first += LANES as u16;
            }
        }
        // By numbers in the patch, so that it is the same wherever its vertices come from.
        let all = kinds.iter().flatten();
        let all: Vec<Facet> =
            all.map(|f| Facet { corners: f.corners.map(|v| u32::from(number(v))) }).collect();
        let of = |f: u32| if f == NONE { NEVER } else { numbers[f as usize] };
        let mut rows: Vec<[u16; 4]> = edges(&all)
            .iter()
            .map(|e| {
                let ([f, g], [a, b]) = (e.facets.map(of), e.vertices.map(|v| v as u16));
                [f, g, a, b]
            })
            .collect();
        // Those of facets that are drawn together come together.
        rows.sort_unstable();
        let edges = rows
            .chunks(LANES)
            .map(|rows| {
                let row = |k: usize| {
                    std::array::from_fn(|lane| {
                        rows.get(lane).map_or(NEVER, |row: &[u16; 4]| row[k])
                    })
                };
                [0, 1, 2, 3].map(row)
            })
            .collect();
        let padded = vertices.len().next_multiple_of(LANES);
        let places: Vec<[f32; 3]> = vertices.iter().map(|&v| self.positions[v as usize]).collect();
        let axis_of = |a: usize| {
            let mut of: Vec<f32> = places.iter().map(|p| p[a]).collect();
            of.resize(padded, of.last().copied().unwrap_or_default());
            of
        };
        let (axis, sine) = self.cone(kinds[..2].iter().flatten());
        Some(Connected {
            bounds: Aabb::from_points(&places[..own_vertices]),
            around: Aabb::from_points(&places),
            places: [0, 1, 2].map(axis_of),
            own_vertices,
            corners,
            groups,
            edges,
            two_sided,
            axis,
            sine,
        })
    }

    /// The cone of the normals of the triangles of some facets.
    fn cone<'f>(&self, facets: impl Iterator<Item = &'f Facet>) -> ([f32; 3], f32) {
        let normals: Vec<DVec3> = facets
            .flat_map(Facet::triangles)
            .filter_map(|t| normal(self.positions, t).try_normalize())
            .collect();
        let axis = normals.iter().sum::<DVec3>().normalize_or_zero();
        let least = normals.iter().map(|n| n.dot(axis)).fold(1.0, f64::min);
        // Normals of tiny triangles are off; an angle that is nearly right says nothing.
        let is_cone = axis != DVec3::ZERO && least > 0.02;
        let sine = if is_cone { (1.0 - least * least).max(0.0).sqrt() + 1e-4 } else { 2.0 };
        (axis.as_vec3().to_array(), sine as f32)
    }
}
