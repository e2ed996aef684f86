//! The triangles around a place, and the places next to it.

use super::NONE;

/// A corner of a triangle at the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) triangle: u32,
    pub(super) corner: u8,
    pub(super) wedge: u32,
    /// Places of the other two corners.
    pub(super) next: u32,
    pub(super) prev: u32,
}

/// A place next to the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub(super) place: u32,
    /// How many triangles have the edge to it, and from it.
    count: [u8; 2],
    /// The last such triangles.
    pub(super) triangle_out: u32,
    pub(super) triangle_in: u32,
    /// Their vertices here and there.
    wedges: [[u32; 2]; 2],
    /// Whether others of these have other vertices.
    mixed: bool,
}

impl Near {
    /// Whether the edge has as many triangles on either side, and is no seam. More than one on each
    /// are surfaces that touch there: whatever is done to them closes again.
    pub(super) fn is_plain(&self) -> bool {
        self.count[0] == self.count[1] && !self.mixed && self.wedges[0] == self.wedges[1]
    }

    pub(super) fn is_border(&self) -> bool {
        self.count[0] + self.count[1] == 1
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    pub(super) place: u32,
    pub(super) corners: Vec<Corner>,
    pub(super) around: Vec<Near>,
}

impl Ring {
    pub(super) fn gather(
        &mut self,
        v: u32,
        head: &[u32],
        links: &[u32],
        triangles: &[[u32; 3]],
        place: &[u32],
    ) {
        self.place = v;
        self.corners.clear();
        self.around.clear();
        let mut c = head[v as usize];
        while c != NONE {
            let (triangle, corner) = (c / 3, c % 3);
            let t = triangles[triangle as usize];
            if t[0] != NONE {
                let own = t[corner as usize];
                let (b, d) = (t[(corner as usize + 1) % 3], t[(corner as usize + 2) % 3]);
                let (next, prev) = (place[b as usize], place[d as usize]);
                let corner = corner as u8;
                self.corners.push(Corner { triangle, corner, wedge: own, next, prev });
                self.side(next, 0, triangle, [own, b]);
                self.side(prev, 1, triangle, [own, d]);
            }
            c = links[c as usize];
        }
    }

    fn side(&mut self, place: u32, way: usize, triangle: u32, wedges: [u32; 2]) {
        let near = match self.around.iter_mut().find(|n| n.place == place) {
            Some(near) => near,
            None => {
                self.around.push(Near {
                    place,
                    count: [0; 2],
                    triangle_out: NONE,
                    triangle_in: NONE,
                    wedges: [[NONE; 2]; 2],
                    mixed: false,
                });
                let last = self.around.len() - 1;
                &mut self.around[last]
            }
        };
        near.mixed |= near.count[way] > 0 && near.wedges[way] != wedges;
        near.count[way] = near.count[way].saturating_add(1);
        near.wedges[way] = wedges;
        if way == 0 {
            near.triangle_out = triangle;
        } else {
            near.triangle_in = triangle;
        }
    }

    /// The places that this one may be collapsed onto.
    pub(super) fn targets(&self, mut add: impl FnMut(u32)) {
        let special = self.around.iter().filter(|n| !n.is_plain());
        let count = special.clone().count();
        if count == 0 {
            self.around.iter().for_each(|n| add(n.place));
        } else if count == 2 {
            let kind = |n: &Near| n.count[0] + n.count[1];
            let mut kinds = special.clone().map(kind);
            if kinds.next() == kinds.next() {
                special.for_each(|n| add(n.place));
            }
        }
    }

    fn to(&self, to: u32) -> Option<&Near> {
        self.around.iter().find(|n| n.place == to)
    }

    pub(super) fn is_plain(&self, to: u32) -> bool {
        self.to(to).is_none_or(Near::is_plain)
    }

    /// Whether no vertex of this place would become two at another.
    pub(super) fn is_clear(&self, to: u32) -> bool {
        self.to(to).is_some_and(|near| {
            let [a, b] = near.wedges;
            !near.mixed && (a[0] != b[0] || a[1] == b[1])
        })
    }

    /// Whether a vertex of this place becomes one at another.
    pub(super) fn maps(&self, to: u32, wedge: u32) -> bool {
        self.to(to).is_some_and(|n| n.wedges.iter().any(|w| w[0] == wedge))
    }

    /// The vertex that one of this place becomes at another.
    pub(super) fn mapped(&self, to: u32, wedge: u32) -> u32 {
        let near = self.to(to).and_then(|n| n.wedges.iter().find(|w| w[0] == wedge));
        near.map_or(NONE, |w| w[1])
    }
}
