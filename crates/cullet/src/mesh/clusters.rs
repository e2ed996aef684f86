//! Clusters of a mesh's triangles, and the simple generator: triangles in spatial order.

use super::{Cluster, MeshData, MeshError, is_degenerate};

/// The most vertices that a cluster may use: the mesh-shader limit that vendors recommend.
pub const MAX_CLUSTER_VERTICES: usize = 64;
/// The most triangles in a cluster: 126 is the mesh-shader limit, 124 keeps their local indices in a
/// multiple of four bytes.
pub const MAX_CLUSTER_TRIANGLES: usize = 124;

/// A way to cut a mesh into clusters: an order of its triangles, and ranges of that order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clustering {
    /// Original triangle numbers, cluster by cluster. Triangles left out are degenerate.
    pub order: Vec<u32>,
    /// Ranges of `order`, without gap.
    pub clusters: Vec<Cluster>,
}

impl Clustering {
    /// Triangles of each part in the Morton order of their centres, cut whenever a cluster is full.
    #[must_use]
    pub fn spatial(data: &MeshData) -> Self {
        let mut result = Self::default();
        let mut keyed: Vec<(u32, u32)> = Vec::new();
        // The cluster that last used a vertex, plus one.
        let mut used_by = vec![0u32; data.positions.len()];
        let triangle = |t: u32| {
            let i = t as usize * 3;
            [data.indices[i], data.indices[i + 1], data.indices[i + 2]]
        };
        for (part_index, part) in data.parts.iter().enumerate() {
            let range = part.first_triangle..part.first_triangle + part.triangle_count;
            let centre = |t: u32| {
                let [a, b, c] = triangle(t).map(|v| data.positions[v as usize]);
                // Thirds are taken first: the sum of three large coordinates might overflow.
                std::array::from_fn::<f32, 3, _>(|i| a[i] / 3.0 + b[i] / 3.0 + c[i] / 3.0)
            };
            let drawn = range
                .clone()
                .filter(|&t| data.deformable || !is_degenerate(triangle(t), &data.positions));
            let mut bounds = crate::bounds::Aabb::EMPTY;
            keyed.clear();
            for t in drawn {
                let c = centre(t);
                bounds = bounds.union(&crate::bounds::Aabb::new(c, c));
                keyed.push((0, t));
            }
            for (key, t) in &mut keyed {
                *key = morton(centre(*t), &bounds);
            }
            keyed.sort_unstable();
            let mut open = Cluster {
                first_triangle: result.order.len() as u32,
                triangle_count: 0,
                part: part_index as u32,
            };
            let mut vertices = 0;
            for &(_, t) in &keyed {
                let stamp = result.clusters.len() as u32 + 1;
                let fresh = fresh_vertices(triangle(t), &used_by, stamp);
                let full = open.triangle_count as usize == MAX_CLUSTER_TRIANGLES
                    || vertices + fresh > MAX_CLUSTER_VERTICES;
                if full {
                    result.clusters.push(open);
                    open.first_triangle += open.triangle_count;
                    open.triangle_count = 0;
                    vertices = 0;
                }
                let stamp = result.clusters.len() as u32 + 1;
                for v in triangle(t) {
                    if used_by[v as usize] != stamp {
                        used_by[v as usize] = stamp;
                        vertices += 1;
                    }
                }
                open.triangle_count += 1;
                result.order.push(t);
            }
            if open.triangle_count > 0 {
                result.clusters.push(open);
            }
        }
        result
    }

    /// Checks a clustering that came from elsewhere against the data it is for.
    pub(super) fn validate(&self, data: &MeshData) -> Result<(), MeshError> {
        let fail = |message: String| Err(MeshError::Clustering(message));
        let triangles = data.indices.len() / 3;
        let mut seen = vec![false; triangles];
        for &t in &self.order {
            match seen.get_mut(t as usize) {
                None => return fail(format!("triangle {t} of {triangles}")),
                Some(true) => return fail(format!("triangle {t} is there twice")),
                Some(seen) => *seen = true,
            }
        }
        let triangle = |t: u32| {
            let i = t as usize * 3;
            [data.indices[i], data.indices[i + 1], data.indices[i + 2]]
        };
        for t in (0..triangles as u32).filter(|&t| !seen[t as usize]) {
            if data.deformable || !is_degenerate(triangle(t), &data.positions) {
                return fail(format!("triangle {t} is left out but not degenerate"));
            }
        }
        let mut expected = 0;
        let mut vertices = Vec::new();
        for (i, c) in self.clusters.iter().enumerate() {
            let end = c.first_triangle as usize + c.triangle_count as usize;
            if c.first_triangle as usize != expected || end > self.order.len() {
                return fail(format!("cluster {i} starts at {}, not {expected}", c.first_triangle));
            }
            let Some(part) = data.parts.get(c.part as usize) else {
                return fail(format!("cluster {i} is of part {} of {}", c.part, data.parts.len()));
            };
            if c.triangle_count == 0 || c.triangle_count as usize > MAX_CLUSTER_TRIANGLES {
                return fail(format!(
                    "cluster {i} has {} triangles; 1 to {MAX_CLUSTER_TRIANGLES} are allowed",
                    c.triangle_count
                ));
            }
            vertices.clear();
            for &t in &self.order[expected..end] {
                if t < part.first_triangle || t >= part.first_triangle + part.triangle_count {
                    return fail(format!("cluster {i} has triangle {t}, not of part {}", c.part));
                }
                vertices.extend(triangle(t));
            }
            vertices.sort_unstable();
            vertices.dedup();
            if vertices.len() > MAX_CLUSTER_VERTICES {
                return fail(format!(
                    "cluster {i} has {} vertices; {MAX_CLUSTER_VERTICES} are allowed",
                    vertices.len()
                ));
            }
            expected = end;
        }
        if expected != self.order.len() {
            return fail(format!("clusters end at {expected} of {}", self.order.len()));
        }
        Ok(())
    }
}

fn fresh_vertices(triangle: [u32; 3], used_by: &[u32], stamp: u32) -> usize {
    let [a, b, c] = triangle;
    let fresh = |v: u32| usize::from(used_by[v as usize] != stamp);
    // Indices may repeat where a mesh can deform.
    fresh(a) + fresh(b) * usize::from(b != a) + fresh(c) * usize::from(c != a && c != b)
}

/// 30-bit Morton code of a point in a box: ten bits an axis, on the box's own scale.
fn morton(p: [f32; 3], bounds: &crate::bounds::Aabb) -> u32 {
    let cell = |axis: usize| {
        let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
        let t = (f64::from(p[axis]) - low) / (high - low);
        // A flat box gives NaN, which casts to 0.
        ((t * 1024.0) as u32).min(1023)
    };
    let spread = |mut v: u32| {
        v = (v | v << 16) & 0x0300_00FF;
        v = (v | v << 8) & 0x0300_F00F;
        v = (v | v << 4) & 0x030C_30C3;
        (v | v << 2) & 0x0924_9249
    };
    spread(cell(0)) | spread(cell(1)) << 1 | spread(cell(2)) << 2
}
