//! Distances from points to a surface of triangles.

use std::cmp::Ordering;

use glam::{DVec3, Vec4};

use super::exact::closest_point;

/// Triangles to which distances are measured: a tree of four boxes a node and four triangles a
/// leaf.
///
/// Points and triangles are brought into the cube from −1 to 1 around the surface before anything
/// is computed in f32, so that a distance is right to some 1e-6 of the surface's half size (of the
/// point's distance, for points far away), wherever it lies and however large it is. Points that
/// are equal to corners of triangles have the distance 0.
///
/// Triangles with a corner that is not finite or does not exist are as though they were not there;
/// those without area are the segment or the point that they look like. Some 75 bytes a triangle;
/// built in O(n log n), the same on every machine.
///
/// ```
/// use cullet_draw::surface::SurfaceTree;
///
/// let surface = SurfaceTree::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2]);
/// assert_eq!(surface.nearest([0.25, 0.25, 3.0], f32::INFINITY), Some((3.0, 0)));
/// assert_eq!(surface.within([0.25, 0.25, 3.0], 2.0), None);
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceTree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    root: u32,
    cube: Cube,
}

/// The cube from −1 to 1 around a surface.
#[derive(Clone, Copy, Debug)]
struct Cube {
    center: DVec3,
    /// A power of two, so that it rounds nothing.
    scale: f64,
}

/// Boxes of up to four children.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: [Vec4; 3],
    high: [Vec4; 3],
    child: [u32; 4],
}

/// Up to four triangles: the first corner, the edges from it, the unit normal and twice the area.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    corner: [Vec4; 3],
    edges: [[Vec4; 3]; 2],
    /// NaN where the triangle has no area: then no point is above its inside, and its edges are all
    /// there is.
    normal: [Vec4; 3],
    double_area: Vec4,
    triangle: [u32; 4],
}

/// Marks leaves among the numbers of children.
const LEAF: u32 = 1 << 31;

/// No child or triangle.
const NONE: u32 = u32::MAX;

/// Children that wait: each node leaves at most three, and trees are balanced, so that 2³²
/// triangles have 16 levels.
const STACK: usize = 64;

/// Triangles flatter than this share of their longest edge are their edges: what is left out is as
/// small as rounding.
const FLATTEST: f64 = 1e-7;

/// Beyond so many sizes of the surface, squares of f32 could overflow.
const FARTHEST: f64 = 1e15;

impl SurfaceTree {
    /// A tree over triangles, three indices each.
    #[must_use]
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let point = |i: u32| {
            let p = positions.get(i as usize)?;
            p.iter().all(|v| v.is_finite()).then(|| DVec3::from_array(p.map(f64::from)))
        };
        let corners = |t: u32| {
            let at = t as usize * 3;
            Some([point(indices[at])?, point(indices[at + 1])?, point(indices[at + 2])?])
        };
        let count = (indices.len() / 3) as u32;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for c in (0..count).filter_map(corners).flatten() {
            (low, high) = (low.min(c), high.max(c));
        }
        let cube = Cube::around(low, high);
        let mut tree = Self { nodes: Vec::new(), leaves: Vec::new(), root: NONE, cube };
        let mut items: Vec<Item> = (0..count)
            .filter_map(|number| {
                let corners = corners(number)?.map(|p| cube.bring(p));
                let [a, b, c] = corners;
                // Twice the middle of its box.
                let middle = a.min(b).min(c) + a.max(b).max(c);
                Some(Item { middle: middle.as_vec3().to_array(), number })
            })
            .collect();
        if !items.is_empty() {
            let blocks = items.len().div_ceil(4);
            tree.leaves.reserve_exact(blocks);
            tree.nodes.reserve(blocks / 2);
            let load = |t: u32| corners(t).map(|c| c.map(|p| cube.bring(p)));
            let mut build = Build { nodes: &mut tree.nodes, leaves: &mut tree.leaves, load };
            tree.root = build.child(&mut items).0;
        }
        tree
    }

    /// Whether there is no triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.root == NONE
    }

    /// A triangle at most `distance` away, if there is one: the first that is found, not the
    /// nearest, but always the same. `None` for a point that is not finite and a distance that is
    /// negative or NaN.
    #[must_use]
    #[inline]
    pub fn within(&self, point: [f32; 3], distance: f32) -> Option<u32> {
        self.search(point, distance, distance, &mut { NONE }).map(|found| found.1)
    }

    /// Returns whether a triangle is at most `distance` away. `last` is where one was found the
    /// last time, or any number: it is looked at first, which is quick for points next to each other.
    #[must_use]
    #[inline]
    pub fn is_within(&self, point: [f32; 3], distance: f32, last: &mut u32) -> bool {
        self.search(point, distance, distance, last).is_some()
    }

    /// Returns how far the nearest triangle is, if it is farther than `distance`; infinity where
    /// there is none. `last` is as for [`is_within`](Self::is_within).
    #[must_use]
    #[inline]
    pub fn farther(&self, point: [f32; 3], distance: f32, last: &mut u32) -> Option<f32> {
        let found = self.search(point, f32::INFINITY, distance, last);
        found.map_or(Some(f32::INFINITY), |(far, _, is_enough)| (!is_enough).then_some(far))
    }

    /// The nearest triangle that is at most `limit` away, and its distance; of several one, always
    /// the same. `None` as for [`within`](Self::within).
    #[must_use]
    #[inline]
    pub fn nearest(&self, point: [f32; 3], limit: f32) -> Option<(f32, u32)> {
        self.search(point, limit, -1.0, &mut { NONE }).map(|found| (found.0, found.1))
    }

    /// Ends at the first triangle that is no farther than `enough`, and tells that it is; a negative
    /// one is never reached. `last` is the leaf to begin with, then the one that was found.
    fn search(
        &self,
        point: [f32; 3],
        limit: f32,
        enough: f32,
        last: &mut u32,
    ) -> Option<(f32, u32, bool)> {
        let at = self.cube.bring(DVec3::from_array(point.map(f64::from)));
        // Also false where something is NaN.
        if !(limit >= 0.0 && at.is_finite()) || self.root == NONE {
            return None;
        }
        if at.abs().max_element() > FARTHEST {
            let (distance, triangle) = self.search_far(at, limit)?;
            return Some((distance, triangle, distance <= enough));
        }
        let at = at.as_vec3().to_array().map(Vec4::splat);
        let squared = |distance: f32| {
            let scaled = (f64::from(distance) * self.cube.scale) as f32;
            // Empty places are infinitely far and must stay beyond it.
            (scaled * scaled).min(f32::MAX)
        };
        let mut limit = squared(limit);
        let enough = if enough >= 0.0 { squared(enough) } else { -1.0 };
        let mut found = NONE;
        if let Some(leaf) = self.leaves.get(*last as usize) {
            let distances = leaf.distances(&at).to_array();
            if let Some(k) = (0..4).find(|&k| distances[k] <= enough) {
                return Some((0.0, leaf.triangle[k], true));
            }
        }
        let mut stack = [(0.0_f32, NONE); STACK];
        let mut waiting = 0;
        let mut child = self.root;
        loop {
            if child & LEAF == 0 {
                let node = &self.nodes[child as usize];
                let distances = node.distances(&at).to_array();
                // The nearest is entered, the others wait, the farthest longest.
                let mut near = (f32::INFINITY, NONE);
                let base = waiting;
                for k in 0..4 {
                    let mut entry = (distances[k], node.child[k]);
                    if entry.0 <= limit {
                        if entry.0 < near.0 {
                            std::mem::swap(&mut near, &mut entry);
                        }
                        if entry.1 != NONE {
                            let mut place = waiting;
                            while place > base && stack[place - 1].0 < entry.0 {
                                stack[place] = stack[place - 1];
                                place -= 1;
                            }
                            stack[place] = entry;
                            waiting += 1;
                        }
                    }
                }
                if near.1 != NONE {
                    child = near.1;
                    continue;
                }
            } else {
                let leaf = &self.leaves[(child & !LEAF) as usize];
                let distances = leaf.distances(&at).to_array();
                for k in 0..4 {
                    // The first of equals stays.
                    if distances[k] < limit || (distances[k] == limit && found == NONE) {
                        (limit, found) = (distances[k], leaf.triangle[k]);
                    }
                }
                if found != NONE && limit <= enough {
                    *last = child & !LEAF;
                    break;
                }
            }
            // The next that is still near enough; equals of what was found change nothing.
            loop {
                if waiting == 0 {
                    child = NONE;
                    break;
                }
                waiting -= 1;
                let (distance, number) = stack[waiting];
                if distance < limit || (distance == limit && found == NONE) {
                    child = number;
                    break;
                }
            }
            if child == NONE {
                break;
            }
        }
        let distance = (f64::from(limit.sqrt()) / self.cube.scale) as f32;
        (found != NONE).then_some((distance, found, limit <= enough))
    }

    /// Searches like [`search`](Self::search), in f64 and through all triangles, for points so far
    /// away that f32 overflows.
    #[cold]
    fn search_far(&self, at: DVec3, limit: f32) -> Option<(f32, u32)> {
        let mut best = (f64::from(limit) * self.cube.scale, NONE);
        for leaf in &self.leaves {
            for k in (0..4).filter(|&k| leaf.triangle[k] != NONE) {
                let vector =
                    |v: &[Vec4; 3]| DVec3::from_array(std::array::from_fn(|a| f64::from(v[a][k])));
                let corner = vector(&leaf.corner);
                let corners =
                    [corner, corner + vector(&leaf.edges[0]), corner + vector(&leaf.edges[1])];
                let distance = (closest_point(at, corners) - at).length();
                if distance < best.0 || (distance == best.0 && best.1 == NONE) {
                    best = (distance, leaf.triangle[k]);
                }
            }
        }
        (best.1 != NONE).then(|| ((best.0 / self.cube.scale) as f32, best.1))
    }
}

impl Cube {
    fn around(low: DVec3, high: DVec3) -> Self {
        let half = ((high - low) * 0.5).max_element();
        // Nothing at all, and a single point, which has no size of its own.
        let scale = if half > 0.0 { (-half.log2().ceil()).exp2() } else { 1.0 };
        let center = if half >= 0.0 { (low + high) * 0.5 } else { DVec3::ZERO };
        Self { center, scale }
    }

    fn bring(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.scale
    }
}

impl Node {
    const EMPTY: Self =
        Self { low: [Vec4::INFINITY; 3], high: [Vec4::NEG_INFINITY; 3], child: [NONE; 4] };

    /// Squared distances to the boxes.
    #[inline]
    fn distances(&self, at: &[Vec4; 3]) -> Vec4 {
        let axis = |a: usize| {
            let d = (self.low[a] - at[a]).max(at[a] - self.high[a]).max(Vec4::ZERO);
            d * d
        };
        axis(0) + axis(1) + axis(2)
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

/// Squared distances from `d` to segments from the origin.
#[inline]
fn to_segment(d: &[Vec4; 3], edge: &[Vec4; 3]) -> Vec4 {
    // Edges without length have any place on them.
    let t = dot(d, edge) / dot(edge, edge).max(Vec4::splat(f32::MIN_POSITIVE));
    let t = t.max(Vec4::ZERO).min(Vec4::ONE);
    let rest = [d[0] - edge[0] * t, d[1] - edge[1] * t, d[2] - edge[2] * t];
    dot(&rest, &rest)
}

impl Leaf {
    const EMPTY: Self = Self {
        corner: [Vec4::INFINITY; 3],
        edges: [[Vec4::ZERO; 3]; 2],
        normal: [Vec4::NAN; 3],
        double_area: Vec4::NAN,
        triangle: [NONE; 4],
    };

    fn set(&mut self, k: usize, [a, b, c]: [DVec3; 3], number: u32) {
        let round = |p: DVec3| p.as_vec3().to_array();
        let [corner, second, third] = [a, b, c].map(round);
        // From what is kept, so that the corners are where the boxes say.
        let edges =
            [second, third].map(|p| -> [f32; 3] { std::array::from_fn(|i| p[i] - corner[i]) });
        let [e, f] = edges.map(|e| DVec3::from_array(e.map(f64::from)));
        let cross = e.cross(f);
        let longest = e.length_squared().max(f.length_squared()).max((f - e).length_squared());
        let area = cross.length();
        let has_area = area > FLATTEST * longest;
        let normal = if has_area { cross / area } else { DVec3::NAN };
        for (i, n) in round(normal).into_iter().enumerate() {
            self.corner[i][k] = corner[i];
            self.edges[0][i][k] = edges[0][i];
            self.edges[1][i][k] = edges[1][i];
            self.normal[i][k] = n;
        }
        self.double_area[k] = if has_area { area as f32 } else { f32::NAN };
        self.triangle[k] = number;
    }

    /// Squared distances to the triangles: to the plane for points above the inside, else to the
    /// nearest edge. With the normal known to full precision, slivers are as right as others.
    #[inline]
    fn distances(&self, at: &[Vec4; 3]) -> Vec4 {
        let [e, f] = &self.edges;
        let third = sub(f, e);
        let d = sub(at, &self.corner);
        let to_edges =
            to_segment(&d, e).min(to_segment(&d, f)).min(to_segment(&sub(&d, e), &third));
        // d × n; which side of an edge g a point is on is the sign of g · (d × n).
        let n = &self.normal;
        let m = [d[1] * n[2] - d[2] * n[1], d[2] * n[0] - d[0] * n[2], d[0] * n[1] - d[1] * n[0]];
        let above = dot(e, &m).cmpge(Vec4::ZERO)
            & dot(f, &m).cmple(Vec4::ZERO)
            & (dot(&third, &m) + self.double_area).cmpge(Vec4::ZERO);
        let height = dot(&d, n);
        Vec4::select(above, height * height, to_edges)
    }
}

/// A triangle that waits for its place.
#[derive(Clone, Copy, Debug)]
struct Item {
    middle: [f32; 3],
    number: u32,
}

/// Working state of building the tree.
struct Build<'a, F> {
    nodes: &'a mut Vec<Node>,
    leaves: &'a mut Vec<Leaf>,
    load: F,
}

impl<F: Fn(u32) -> Option<[DVec3; 3]>> Build<'_, F> {
    /// Builds a child of these triangles; its number and box.
    fn child(&mut self, items: &mut [Item]) -> (u32, [[f32; 3]; 2]) {
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        if items.len() <= 4 {
            // Four at the most: no sort is compiled for them.
            for end in 1..items.len() {
                let mut at = end;
                while at > 0 && items[at - 1].number > items[at].number {
                    items.swap(at - 1, at);
                    at -= 1;
                }
            }
            let mut leaf = Leaf::EMPTY;
            for (k, item) in items.iter().enumerate() {
                let Some(corners) = (self.load)(item.number) else { continue };
                leaf.set(k, corners, item.number);
                for p in corners {
                    let p = p.as_vec3().to_array();
                    for a in 0..3 {
                        bounds[0][a] = bounds[0][a].min(p[a]);
                        bounds[1][a] = bounds[1][a].max(p[a]);
                    }
                }
            }
            let number = self.leaves.len() as u32;
            self.leaves.push(leaf);
            return (number | LEAF, bounds);
        }
        let number = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let (left, right) = halves(items);
        let mut quarters = [None, None, None, None];
        for (k, half) in [left, right].into_iter().enumerate() {
            if half.len() > 4 {
                let (left, right) = halves(half);
                quarters[k * 2] = Some(left);
                quarters[k * 2 + 1] = Some(right);
            } else {
                quarters[k * 2] = Some(half);
            }
        }
        for (k, quarter) in quarters.into_iter().enumerate() {
            let Some(quarter) = quarter else { continue };
            let (child, [low, high]) = self.child(quarter);
            let node = &mut self.nodes[number];
            node.child[k] = child;
            for a in 0..3 {
                node.low[a][k] = low[a];
                node.high[a][k] = high[a];
                bounds[0][a] = bounds[0][a].min(low[a]);
                bounds[1][a] = bounds[1][a].max(high[a]);
            }
        }
        (number as u32, bounds)
    }
}

/// Two halves across the longest side, the first of whole leaves.
fn halves(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items.iter() {
        for a in 0..3 {
            low[a] = low[a].min(item.middle[a]);
            high[a] = high[a].max(item.middle[a]);
        }
    }
    let side: [f32; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let mut axis = 0;
    for a in 1..3 {
        if side[a] > side[axis] {
            axis = a;
        }
    }
    let blocks = items.len().div_ceil(4);
    let mid = blocks.div_ceil(2) * 4;
    // By number where places are equal, so that the same triangles meet everywhere.
    let order = |x: &Item, y: &Item| -> Ordering {
        x.middle[axis].total_cmp(&y.middle[axis]).then(x.number.cmp(&y.number))
    };
    items.select_nth_unstable_by(mid, order);
    items.split_at_mut(mid)
}
