//! Distances from points to a handful of triangles.

use glam::{Vec3, Vec4};

/// Triangles in fours.
#[derive(Clone, Debug, Default)]
pub(super) struct Fan {
    fours: Vec<Four>,
    count: usize,
}

/// Four triangles: first corners, edges from there, unit normals and twice the areas.
#[derive(Clone, Copy, Debug)]
struct Four {
    corner: [Vec4; 3],
    edges: [[Vec4; 3]; 2],
    normal: [Vec4; 3],
    double_area: Vec4,
    /// One over the squared lengths of the three edges.
    inverse: [Vec4; 3],
}

const EMPTY: Four = Four {
    // Far, but finite: a product with an edge of no length must not be NaN.
    corner: [Vec4::splat(1e18); 3],
    edges: [[Vec4::ZERO; 3]; 2],
    normal: [Vec4::NAN; 3],
    double_area: Vec4::NAN,
    inverse: [Vec4::ZERO; 3],
};

/// Triangles flatter than this share of their longest edge squared are their edges.
const FLATTEST: f32 = 1e-6;

impl Fan {
    pub(super) fn clear(&mut self) {
        self.fours.clear();
        self.count = 0;
    }

    pub(super) fn push(&mut self, [a, b, c]: [Vec3; 3]) {
        let lane = self.count % 4;
        if lane == 0 {
            self.fours.push(EMPTY);
        }
        self.count += 1;
        let Some(four) = self.fours.last_mut() else { return };
        let (e, f) = (b - a, c - a);
        let g = f - e;
        let cross = e.cross(f);
        let squared = [e, f, g].map(Vec3::length_squared);
        let area = cross.length();
        let has_area = area > FLATTEST * squared[0].max(squared[1]).max(squared[2]);
        let normal = if has_area { cross / area } else { Vec3::NAN };
        for k in 0..3 {
            four.corner[k][lane] = a[k];
            four.edges[0][k][lane] = e[k];
            four.edges[1][k][lane] = f[k];
            four.normal[k][lane] = normal[k];
            four.inverse[k][lane] = if squared[k] > 0.0 { 1.0 / squared[k] } else { 0.0 };
        }
        four.double_area[lane] = if has_area { area } else { f32::NAN };
    }

    /// The squared distance to the nearest triangle, and its number.
    #[inline]
    pub(super) fn nearest(&self, at: Vec3) -> (f32, u32) {
        let at = [Vec4::splat(at.x), Vec4::splat(at.y), Vec4::splat(at.z)];
        let mut best = (f32::INFINITY, 0);
        for (number, four) in self.fours.iter().enumerate() {
            let distances = four.distances(&at);
            let least = distances.min_element();
            if least < best.0 {
                let lane = distances.cmple(Vec4::splat(least)).bitmask().trailing_zeros();
                best = (least, number as u32 * 4 + lane);
            }
        }
        best
    }
}

#[inline]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn sub(a: &[Vec4; 3], b: &[Vec4; 3]) -> [Vec4; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn to_segment(d: &[Vec4; 3], edge: &[Vec4; 3], inverse: Vec4) -> Vec4 {
    let t = (dot(d, edge) * inverse).max(Vec4::ZERO).min(Vec4::ONE);
    let rest = [d[0] - edge[0] * t, d[1] - edge[1] * t, d[2] - edge[2] * t];
    dot(&rest, &rest)
}

impl Four {
    /// Squared distances: to the plane for points above the inside, else to the nearest edge.
    #[inline]
    fn distances(&self, at: &[Vec4; 3]) -> Vec4 {
        let [e, f] = &self.edges;
        let third = sub(f, e);
        let d = sub(at, &self.corner);
        let n = &self.normal;
        let m = [d[1] * n[2] - d[2] * n[1], d[2] * n[0] - d[0] * n[2], d[0] * n[1] - d[1] * n[0]];
        let above = dot(e, &m).cmpge(Vec4::ZERO)
            & dot(f, &m).cmple(Vec4::ZERO)
            & (dot(&third, &m) + self.double_area).cmpge(Vec4::ZERO);
        let height = dot(&d, n);
        let to_edges = to_segment(&d, e, self.inverse[0])
            .min(to_segment(&d, f, self.inverse[1]))
            .min(to_segment(&sub(&d, e), &third, self.inverse[2]));
        Vec4::select(above, height * height, to_edges)
    }
}
