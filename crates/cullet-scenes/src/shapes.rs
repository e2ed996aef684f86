//! Shapes that meshes of the built-in scenes are made of: closed, and wound outward.

use std::collections::BTreeMap;

use cullet::MeshData;
use cullet::mesh::{Alpha, Part};
use glam::{DVec2, DVec3};

use super::rng::sin_cos;

/// A triangle list under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) indices: Vec<u32>,
}

impl Shape {
    fn push(&mut self, p: DVec3) -> u32 {
        // −0 would be a position of its own to whoever compares bits.
        self.positions.push(p.as_vec3().to_array().map(|v| v + 0.0));
        (self.positions.len() - 1) as u32
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.indices.extend([a, b, c, a, c, d]);
    }

    /// An axis-aligned box, with shared corners.
    pub(crate) fn cuboid(min: [f64; 3], max: [f64; 3]) -> Self {
        let square = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]];
        Self::prism(&square, min[2], max[2])
    }

    /// The box −½..½ × 0..1 × −½..½ whose faces share no vertex, each cut in `sub` × `sub` quads.
    pub(crate) fn building(sub: u32) -> Self {
        let mut s = Self::default();
        // Axes of each face: along × across points out.
        let faces = [
            ([0, 1, 2], 1.0),
            ([2, 1, 0], -1.0),
            ([1, 2, 0], 1.0),
            ([1, 0, 2], -1.0),
            ([2, 0, 1], 1.0),
            ([0, 2, 1], -1.0),
        ];
        for ([along, across, out], side) in faces {
            let first = s.positions.len() as u32;
            for j in 0..=sub {
                for i in 0..=sub {
                    let mut p = [0.0; 3];
                    p[along] = f64::from(i) / f64::from(sub) - 0.5;
                    p[across] = f64::from(j) / f64::from(sub) - 0.5;
                    p[out] = 0.5 * side;
                    p[1] += 0.5;
                    s.push(p.into());
                }
            }
            for j in 0..sub {
                for i in 0..sub {
                    let a = first + j * (sub + 1) + i;
                    s.quad([a, a + 1, a + sub + 2, a + sub + 1]);
                }
            }
        }
        s
    }

    /// A polygon in x and y, counter-clockwise and simple, stretched from z = `z0` to `z1`.
    pub(crate) fn prism(polygon: &[[f64; 2]], z0: f64, z1: f64) -> Self {
        let mut s = Self::default();
        let n = polygon.len() as u32;
        for z in [z0, z1] {
            polygon.iter().for_each(|p| {
                s.push(DVec3::new(p[0], p[1], z));
            });
        }
        for i in 0..n {
            let j = (i + 1) % n;
            s.quad([i, j, n + j, n + i]);
        }
        for [a, b, c] in ears(polygon) {
            s.indices.extend([c, b, a, n + a, n + b, n + c]);
        }
        s
    }

    /// A profile of (radius, height) turned about the y axis in `sides` steps. It runs upward on
    /// the outside; each end is on the axis (radius 0) or is closed by a flat polygon.
    pub(crate) fn lathe(profile: &[[f64; 2]], sides: u32) -> Self {
        let mut s = Self::default();
        let rings: Vec<Vec<u32>> = profile.iter().map(|p| s.ring(*p, sides)).collect();
        for pair in rings.windows(2) {
            s.band(&pair[0], &pair[1]);
        }
        if let (Some(bottom), Some(top)) = (rings.first(), rings.last()) {
            for i in 1..bottom.len().saturating_sub(1) {
                s.indices.extend([bottom[0], bottom[i + 1], bottom[i]]);
            }
            for i in 1..top.len().saturating_sub(1) {
                s.indices.extend([top[0], top[i], top[i + 1]]);
            }
        }
        s
    }

    /// A closed profile of (radius, height), counter-clockwise and away from the axis, turned about
    /// the y axis in `sides` steps: a ring.
    pub(crate) fn ring_lathe(profile: &[[f64; 2]], sides: u32) -> Self {
        let mut s = Self::default();
        let rings: Vec<Vec<u32>> = profile.iter().map(|p| s.ring(*p, sides)).collect();
        for i in 0..rings.len() {
            s.band(&rings[i], &rings[(i + 1) % rings.len()]);
        }
        s
    }

    /// The vertices of one height of a lathe: one on the axis, else `sides`.
    fn ring(&mut self, [radius, height]: [f64; 2], sides: u32) -> Vec<u32> {
        let count = if radius == 0.0 { 1 } else { sides };
        (0..count)
            .map(|i| {
                let (sin, cos) = sin_cos(f64::from(i) / f64::from(sides));
                self.push(DVec3::new(radius * sin, height, radius * cos))
            })
            .collect()
    }

    /// The surface between two rings of a lathe, either of which may be a point.
    fn band(&mut self, low: &[u32], high: &[u32]) {
        let n = low.len().max(high.len());
        for i in 0..n {
            let j = (i + 1) % n;
            match (low.len(), high.len()) {
                (1, 1) => {}
                (1, _) => self.indices.extend([low[0], high[j], high[i]]),
                (_, 1) => self.indices.extend([low[i], low[j], high[0]]),
                _ => self.quad([low[i], low[j], high[j], high[i]]),
            }
        }
    }

    /// A round rod of `sides` sides along a curve; `closed` joins its end to its start, else flat
    /// ends close it. `frame` gives, for a place in 0..1, the centre and two unit vectors across it
    /// whose cross product runs along the curve.
    pub(crate) fn rod(
        steps: u32,
        closed: bool,
        radius: f64,
        sides: u32,
        frame: impl Fn(f64) -> (DVec3, DVec3, DVec3),
    ) -> Self {
        let mut s = Self::default();
        let rings = if closed { steps } else { steps + 1 };
        for i in 0..rings {
            let (centre, n, b) = frame(f64::from(i) / f64::from(steps));
            for j in 0..sides {
                let (sin, cos) = sin_cos(f64::from(j) / f64::from(sides));
                s.push(centre + n * (cos * radius) + b * (sin * radius));
            }
        }
        for i in 0..steps {
            let (at, next) = (i * sides, (i + 1) % rings * sides);
            for j in 0..sides {
                let k = (j + 1) % sides;
                s.quad([at + j, at + k, next + k, next + j]);
            }
        }
        if !closed {
            let last = steps * sides;
            for j in 1..sides - 1 {
                s.indices.extend([0, j + 1, j, last, last + j, last + j + 1]);
            }
        }
        s
    }

    /// The regular tetrahedron within the unit sphere.
    pub(crate) fn tetrahedron() -> Self {
        let r = 1.0 / 3.0f64.sqrt();
        let corners = [[r, r, r], [r, -r, -r], [-r, r, -r], [-r, -r, r]];
        let mut s = Self::default();
        corners.iter().for_each(|c| {
            s.push((*c).into());
        });
        s.indices = vec![0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2];
        s
    }

    /// The regular octahedron within the unit sphere.
    pub(crate) fn octahedron() -> Self {
        Self::lathe(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]], 4)
    }

    /// The regular icosahedron within the unit sphere.
    pub(crate) fn icosahedron() -> Self {
        let golden = (1.0 + 5.0f64.sqrt()) / 2.0;
        let mut s = Self::default();
        for axis in 0..3 {
            for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
                let mut p = [0.0; 3];
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                s.push(DVec3::from(p).normalize());
            }
        }
        // Faces are the triples at the least distance from each other, wound away from the centre.
        let at = |i: u32| DVec3::from(s.positions[i as usize].map(f64::from));
        let near = |i: u32, j: u32| at(i).distance(at(j)) < 1.1;
        let mut faces = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if near(a, b) && near(b, c) && near(c, a) {
                        let out = (at(b) - at(a)).cross(at(c) - at(a)).dot(at(a)) > 0.0;
                        faces.extend(if out { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        s.indices = faces;
        s
    }

    /// The regular dodecahedron within the unit sphere: the dual of the icosahedron.
    pub(crate) fn dodecahedron() -> Self {
        let ico = Self::icosahedron();
        let mut s = Self::default();
        let faces: Vec<&[u32]> = ico.indices.chunks_exact(3).collect();
        for f in &faces {
            let sum: DVec3 =
                f.iter().map(|&v| DVec3::from(ico.positions[v as usize].map(f64::from))).sum();
            s.push(sum.normalize());
        }
        for v in 0..ico.positions.len() as u32 {
            // Around a vertex v, the face (v, a, b) is followed by the one whose edge leaves from
            // b.
            let edge = |f: &[u32]| {
                let k = f.iter().position(|&w| w == v)?;
                Some((f[(k + 1) % 3], f[(k + 2) % 3]))
            };
            let around: BTreeMap<u32, (u32, u32)> = faces
                .iter()
                .enumerate()
                .filter_map(|(i, f)| edge(f).map(|(a, b)| (a, (b, i as u32))))
                .collect();
            let Some(&start) = around.keys().next() else { continue };
            let mut ring = Vec::new();
            let mut at = start;
            while let Some(&(next, face)) = around.get(&at).filter(|_| ring.len() < around.len()) {
                ring.push(face);
                at = next;
            }
            for i in 1..ring.len() - 1 {
                s.indices.extend([ring[0], ring[i], ring[i + 1]]);
            }
        }
        s
    }

    /// The icosahedron with each face cut in four `times` over, on the unit sphere.
    pub(crate) fn icosphere(times: u32) -> Self {
        let mut s = Self::icosahedron();
        for _ in 0..times {
            let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
            let faces = std::mem::take(&mut s.indices);
            for f in faces.chunks_exact(3) {
                let mut middle = |a: u32, b: u32| {
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        let at = |i: u32| DVec3::from(s.positions[i as usize].map(f64::from));
                        let p = (at(a) + at(b)).normalize();
                        s.positions.push(p.as_vec3().to_array());
                        (s.positions.len() - 1) as u32
                    })
                };
                let (ab, bc, ca) = (middle(f[0], f[1]), middle(f[1], f[2]), middle(f[2], f[0]));
                s.indices.extend([f[0], ab, ca, f[1], bc, ab, f[2], ca, bc, ab, bc, ca]);
            }
        }
        s
    }

    /// The same surface turned inside out: the wall of a cavity.
    pub(crate) fn flipped(mut self) -> Self {
        self.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        self
    }

    /// Both shapes, as one.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.indices.extend(other.indices.iter().map(|i| i + first));
        self
    }

    /// Every position sent through `f`, which must not mirror.
    pub(crate) fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        for p in &mut self.positions {
            *p = f(DVec3::from(p.map(f64::from))).as_vec3().to_array().map(|v| v + 0.0);
        }
        self
    }

    /// Scaled, then moved.
    pub(crate) fn scaled(self, scale: [f64; 3], by: [f64; 3]) -> Self {
        self.map(|p| p * DVec3::from(scale) + DVec3::from(by))
    }

    /// Union of boxes, each (min, max). Give them so that no two share an edge: overlap a little
    /// where they meet, or welding makes edges of four triangles.
    pub(crate) fn boxes(boxes: &[([f64; 3], [f64; 3])]) -> Self {
        boxes.iter().fold(Self::default(), |s, (min, max)| s.and(&Self::cuboid(*min, *max)))
    }
}

/// Data of a mesh of several materials: one opaque part, or one of `alpha`, for each shape.
pub(crate) fn mesh_data(parts: &[(Shape, u32)], two_sided: bool, alpha: Alpha) -> MeshData {
    let mut all = Shape::default();
    let mut ranges = Vec::new();
    for (shape, material) in parts {
        ranges.push(Part {
            first_triangle: (all.indices.len() / 3) as u32,
            triangle_count: (shape.indices.len() / 3) as u32,
            material: *material,
            two_sided,
            alpha,
        });
        all = all.and(shape);
    }
    MeshData {
        positions: all.positions,
        indices: all.indices,
        parts: ranges,
        ..MeshData::default()
    }
}

/// A star with `points` points, counter-clockwise; points at radius 1.
pub(crate) fn star(points: u32, inner: f64) -> Vec<[f64; 2]> {
    (0..points * 2)
        .map(|i| {
            let r = if i % 2 == 0 { 1.0 } else { inner };
            let (sin, cos) = sin_cos(f64::from(i) / f64::from(points * 2));
            [r * cos, r * sin]
        })
        .collect()
}

/// Triangles of a simple, counter-clockwise polygon (ear clipping; Meisters, *Polygons Have Ears*,
/// 1975). O(n³), which for a few dozen corners is nothing.
fn ears(polygon: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let at = |i: u32| DVec2::from(polygon[i as usize]);
    let side = |a: u32, b: u32, c: u32| (at(b) - at(a)).perp_dot(at(c) - at(a));
    let mut left: Vec<u32> = (0..polygon.len() as u32).collect();
    let mut triangles = Vec::new();
    while left.len() > 2 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let ear = (0..n).find(|&i| {
            let [a, b, c] = corner(i);
            let inside = |&p: &u32| {
                ![a, b, c].contains(&p)
                    && side(a, b, p) >= 0.0
                    && side(b, c, p) >= 0.0
                    && side(c, a, p) >= 0.0
            };
            side(a, b, c) > 0.0 && !left.iter().any(inside)
        });
        // A polygon that is not simple has no ear left: what was cut so far is all there is.
        let Some(ear) = ear else { break };
        triangles.push(corner(ear));
        left.remove(ear);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ears_cover_a_concave_polygon() {
        let polygon = star(5, 0.4);
        let triangles = ears(&polygon);
        assert_eq!(triangles.len(), 8);
        let area = |p: &[[f64; 2]]| {
            (0..p.len())
                .map(|i| DVec2::from(p[i]).perp_dot(DVec2::from(p[(i + 1) % p.len()])))
                .sum::<f64>()
                / 2.0
        };
        let sum: f64 = triangles.iter().map(|t| area(&t.map(|i| polygon[i as usize]))).sum();
        assert!((sum - area(&polygon)).abs() < 1e-12);
    }

    #[test]
    fn counts_of_the_regular_solids() {
        let counts = |s: Shape| (s.positions.len(), s.indices.len() / 3);
        assert_eq!(counts(Shape::tetrahedron()), (4, 4));
        assert_eq!(counts(Shape::octahedron()), (6, 8));
        assert_eq!(counts(Shape::icosahedron()), (12, 20));
        assert_eq!(counts(Shape::dodecahedron()), (20, 36));
        assert_eq!(counts(Shape::icosphere(2)), (162, 320));
        assert_eq!(counts(Shape::building(1)), (24, 12));
        assert_eq!(counts(Shape::building(3)), (96, 108));
    }
}
