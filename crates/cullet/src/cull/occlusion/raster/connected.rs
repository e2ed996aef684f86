//! A patch of a surface, laid out for drawing: its facets in groups of eight, and their edges.

use alloc::vec::Vec;

use crate::bounds::Aabb;

/// Facets, vertices or edges that are drawn together.
pub(crate) const LANES: usize = 8;

/// The number of a facet that is never drawn: the other side of an edge that has one facet.
pub(crate) const NEVER: u16 = 0;

/// The most numbers of vertices, those that clipping adds included, and of facets.
pub(super) const NUMBERS: usize = 4096;

/// A patch may have so many vertices, so that there is room for what clipping adds, and facets.
pub(crate) const MOST_VERTICES: usize = NUMBERS / 2;

/// Some facets of a surface, its *own*, and those *around* that share a vertex with one, with the
/// edges of both.
///
/// A facet is a triangle, or two that make a convex quad, the diagonal from the first corner to the
/// third.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Connected {
    /// x, y and z of the vertices, first those of its own facets; the last is repeated up to a
    /// whole number of lanes.
    pub(crate) places: [Vec<f32>; 3],
    pub(crate) own_vertices: usize,
    /// Rows of a corner of eight facets: four rows of a group of quads, three of triangles. What
    /// fills up a group has the same corner throughout.
    pub(crate) corners: Vec<[u16; LANES]>,
    /// Groups of its own quads, its own triangles, quads around, triangles around. A facet's number
    /// is eight, and eight for each group before its own, and its lane.
    pub(crate) groups: [u16; 4],
    /// Rows of eight edges: the facets on both sides, [`NEVER`] where there is none, and the two
    /// vertices. What fills up has `NEVER` on both sides.
    pub(crate) edges: Vec<[[u16; LANES]; 4]>,
    pub(crate) two_sided: bool,
    /// The box around its own facets, and around all.
    pub(crate) bounds: Aabb,
    pub(crate) around: Aabb,
    /// The middle of the normals of its own triangles, and the sine of the angle within which all
    /// are; above 1 where there is none.
    pub(crate) axis: [f32; 3],
    pub(crate) sine: f32,
}

impl Default for Connected {
    /// No facet.
    fn default() -> Self {
        Self {
            places: [Vec::new(), Vec::new(), Vec::new()],
            own_vertices: 0,
            corners: Vec::new(),
            groups: [0; 4],
            edges: Vec::new(),
            two_sided: false,
            bounds: Aabb::EMPTY,
            around: Aabb::EMPTY,
            axis: [0.0; 3],
            sine: 2.0,
        }
    }
}

impl Connected {
    /// How many facets are its own.
    pub(crate) fn own_facets(&self) -> usize {
        let (mut rest, mut count) = (&self.corners[..], 0);
        for kind in 0..2 {
            let (own, more) = rest.split_at(corners_of(kind) * usize::from(self.groups[kind]));
            let is_facet = |rows: &[[u16; LANES]], lane: usize| rows[0][lane] != rows[1][lane];
            let of_group =
                |rows: &[[u16; LANES]]| (0..LANES).filter(|&lane| is_facet(rows, lane)).count();
            count += own.chunks_exact(corners_of(kind)).map(of_group).sum::<usize>();
            rest = more;
        }
        count
    }

    /// Position of a vertex.
    pub(crate) fn place_of(&self, vertex: u16) -> [f32; 3] {
        [0, 1, 2].map(|a: usize| self.places[a][usize::from(vertex)])
    }

    /// Calls back with the number of each facet, whether it is its own, and its corners.
    pub(crate) fn for_facets(&self, mut each: impl FnMut(u16, bool, &[[f32; 3]])) {
        self.for_groups(|kind, number, rows| {
            for lane in (0..LANES).filter(|&lane| rows[0][lane] != rows[1][lane]) {
                let corners =
                    [0, 1, 2, 3].map(|k: usize| self.place_of(rows[k.min(rows.len() - 1)][lane]));
                each((number + lane) as u16, kind < 2, &corners[..corners_of(kind)]);
            }
        });
    }

    /// Puts its vertices, those of its own facets first, where they are among some positions.
    pub(crate) fn place(&mut self, positions: &[[f32; 3]], vertices: &[u32]) {
        let padded = vertices.len().next_multiple_of(LANES);
        for places in &mut self.places {
            places.resize(padded, 0.0);
        }
        let [xs, ys, zs] = &mut self.places;
        let (mut own, mut all) = (Aabb::EMPTY, Aabb::EMPTY);
        let mut last = [0.0; 3];
        for (i, (((x, y), z), &v)) in xs.iter_mut().zip(ys).zip(zs).zip(vertices).enumerate() {
            if i == self.own_vertices {
                own = all;
            }
            last = positions[v as usize];
            [*x, *y, *z] = last;
            for a in 0..3 {
                // They are finite; `min` and `max` would look for NaN.
                all.min[a] = if last[a] < all.min[a] { last[a] } else { all.min[a] };
                all.max[a] = if last[a] > all.max[a] { last[a] } else { all.max[a] };
            }
        }
        for (places, last) in self.places.iter_mut().zip(last) {
            places[vertices.len()..].fill(last);
        }
        (self.bounds, self.around) =
            (if self.own_vertices < vertices.len() { own } else { all }, all);
    }

    /// Gives back memory that it does not use.
    pub(crate) fn shrink(&mut self) {
        self.places.iter_mut().for_each(Vec::shrink_to_fit);
        self.corners.shrink_to_fit();
        self.edges.shrink_to_fit();
    }

    /// Bytes that it takes.
    #[cfg(test)]
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.places.iter().map(|p| p.len() * 4).sum::<usize>()
            + self.corners.len() * 16
            + self.edges.len() * 64
    }

    /// Its groups of facets in the order of their numbers: which of the four kinds, the number of
    /// the first facet, and the rows of corners.
    #[inline(always)]
    pub(super) fn for_groups<'a>(&'a self, mut each: impl FnMut(usize, usize, &'a [[u16; LANES]])) {
        let (mut rest, mut number) = (&self.corners[..], LANES);
        for (kind, &groups) in self.groups.iter().enumerate() {
            for _ in 0..groups {
                let (rows, more) = rest.split_at(corners_of(kind));
                each(kind, number, rows);
                (rest, number) = (more, number + LANES);
            }
        }
    }
}

/// Corners of a facet of a kind: own quads, own triangles, quads around, triangles around.
pub(crate) fn corners_of(kind: usize) -> usize {
    4 - kind % 2
}
