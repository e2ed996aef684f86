//! The layout of patches: facets and edges in groups of eight, with numbers of sixteen bits.

use alloc::vec;
use alloc::vec::Vec;

use glam::DVec3;

use super::super::super::raster::{Connected, FACETS as LANES, MOST_VERTICES, NEVER};
use super::facet::{Facet, normal};
use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// The end of a list of half-edges.
const END: u16 = u16::MAX;

/// A half-edge that waits for its opposite: its vertices, the number of its facet, and the next one
/// whose lesser vertex is the same.
#[derive(Clone, Copy, Debug)]
struct HalfEdge {
    from: u16,
    to: u16,
    facet: u16,
    next: u16,
}

/// Lays out patches of a surface, one after the other: memory, of which a patch leaves none behind.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// For each vertex of the surface the last patch that has it, and its number there.
    patch_of: Vec<u32>,
    number_of: Vec<u16>,
    patches: u32,
    vertices: Vec<u32>,
    /// Half-edges, of which those without an opposite yet are in the list of their lesser vertex:
    /// such a list has three or four, and all that it touches is in the nearest cache.
    halves: Vec<HalfEdge>,
    /// For each vertex of the patch the first of its list.
    lists: Vec<u16>,
    /// Edges so far: facets on both sides and vertices.
    rows: Vec<[u16; 4]>,
}

impl Layout {
    /// For a surface of so many vertices.
    pub(crate) fn new(vertices: usize) -> Self {
        Self {
            patch_of: vec![0; vertices],
            number_of: vec![0; vertices],
            patches: 0,
            vertices: Vec::new(),
            halves: Vec::new(),
            lists: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Makes room for so many vertices.
    pub(crate) fn begin(&mut self, vertices: usize) {
        if self.patch_of.len() < vertices || self.patches > u32::MAX / 2 {
            let count = vertices.max(self.patch_of.len());
            self.patch_of.clear();
            self.patch_of.resize(count, 0);
            self.number_of.resize(count, 0);
            self.patches = 0;
        }
    }

    /// Lays out the own facets of a patch and those around it, both sorted as they are to be drawn;
    /// all that `to` had is overwritten but where its vertices are, which
    /// [`vertices`](Self::vertices) lists. Where those around are too many, none is kept: then all
    /// that borders on them counts as an end of the surface.
    pub(crate) fn lay_out(
        &mut self,
        own: &[Facet],
        around: &[Facet],
        two_sided: bool,
        to: &mut Connected,
    ) {
        let fits = self.try_lay_out(own, around, to) || self.try_lay_out(own, &[], to);
        assert!(fits, "{} facets in a patch", own.len());
        to.two_sided = two_sided;
    }

    /// The vertices of the patch that was laid out last, those of its own facets first.
    pub(crate) fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    fn try_lay_out(&mut self, own: &[Facet], around: &[Facet], to: &mut Connected) -> bool {
        self.patches += 1;
        self.vertices.clear();
        self.lists.clear();
        self.halves.clear();
        self.rows.clear();
        to.corners.clear();
        to.edges.clear();
        // Quads first.
        let kinds = [(own, true), (own, false), (around, true), (around, false)];
        let mut number = LANES as u16;
        let mut fits = true;
        for (kind, (list, quads)) in kinds.into_iter().enumerate() {
            let mut count = 0;
            for facet in list.iter().filter(|f| f.is_quad() == quads) {
                fits &= usize::from(number) + LANES < MOST_VERTICES
                    && self.vertices.len() + 4 + LANES <= MOST_VERTICES;
                if !fits {
                    break;
                }
                self.add_facet(facet, count, &mut to.corners);
                self.add_edges(facet, number);
                (number, count) = (number + 1, count + 1);
            }
            to.groups[kind] = count.div_ceil(LANES) as u16;
            number = number.next_multiple_of(LANES as u16);
            if kind == 1 {
                to.own_vertices = self.vertices.len();
            }
        }
        self.finish_edges(&mut to.edges);
        fits
    }

    /// The number of a vertex in the patch.
    fn number(&mut self, vertex: u32) -> u16 {
        let v = vertex as usize;
        if self.patch_of[v] != self.patches {
            self.patch_of[v] = self.patches;
            self.number_of[v] = self.vertices.len() as u16;
            self.vertices.push(vertex);
            self.lists.push(END);
        }
        self.number_of[v]
    }

    /// Adds the corners of a facet, of which there are `count` of its kind before it.
    fn add_facet(&mut self, facet: &Facet, count: usize, rows: &mut Vec<[u16; LANES]>) {
        let (lane, corners) = (count % LANES, facet.corners());
        if lane == 0 {
            // What fills up a group has one corner throughout.
            let first = self.number(corners[0]);
            rows.extend(core::iter::repeat_n([first; LANES], corners.len()));
        }
        let group = rows.len() - corners.len();
        for (k, &v) in corners.iter().enumerate() {
            rows[group + k][lane] = self.number(v);
        }
    }

    /// Matches the half-edges of a facet with those that run the other way, of facets before it,
    /// the first of them first.
    fn add_edges(&mut self, facet: &Facet, number: u16) {
        let corners = facet.corners();
        for k in 0..corners.len() {
            let [from, to] =
                [corners[k], corners[(k + 1) % corners.len()]].each(|v| self.number_of[v as usize]);
            let list = usize::from(from.min(to));
            let (mut before, mut at) = (END, self.lists[list]);
            while at != END {
                let held = self.halves[usize::from(at)];
                if held.from == to && held.to == from {
                    self.rows.push([held.facet, number, to, from]);
                    // It waits no longer.
                    self.link(list, before, held.next);
                    self.halves[usize::from(at)].from = END;
                    break;
                }
                (before, at) = (at, held.next);
            }
            if at == END {
                self.link(list, before, self.halves.len() as u16);
                self.halves.push(HalfEdge { from, to, facet: number, next: END });
            }
        }
    }

    /// Has a half-edge come behind another in a list, or first.
    fn link(&mut self, list: usize, before: u16, half: u16) {
        match before {
            END => self.lists[list] = half,
            _ => self.halves[usize::from(before)].next = half,
        }
    }

    /// Adds the edges with one facet, and puts all in groups.
    fn finish_edges(&mut self, edges: &mut Vec<[[u16; LANES]; 4]>) {
        for &HalfEdge { from, to, facet, .. } in &self.halves {
            if from != END {
                self.rows.push([facet, NEVER, from, to]);
            }
        }
        for rows in self.rows.chunks(LANES) {
            let mut eight = [[NEVER; LANES]; 4];
            for (lane, row) in rows.iter().enumerate() {
                for (k, number) in row.iter().enumerate() {
                    eight[k][lane] = *number;
                }
            }
            edges.push(eight);
        }
    }
}

/// The cone of the normals of the triangles of some facets.
pub(super) fn cone(positions: &[[f32; 3]], facets: &[Facet]) -> ([f32; 3], f32) {
    let normals = || {
        let triangles = facets.iter().flat_map(Facet::triangles);
        triangles.filter_map(|t| normal(positions, t).try_normalize())
    };
    let axis = normals().sum::<DVec3>().normalize_or_zero();
    let least = normals().map(|n| n.dot(axis)).fold(1.0, f64::min);
    // Normals of tiny triangles are off; an angle that is nearly right says nothing.
    let is_cone = axis != DVec3::ZERO && least > 0.02;
    let sine = if is_cone { (1.0 - least * least).max(0.0).sqrt() + 1e-4 } else { 2.0 };
    (axis.as_vec3().to_array(), sine as f32)
}
