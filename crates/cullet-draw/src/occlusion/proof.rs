//! The proof that a box is hidden, between the samples too.
//!
//! The image of the box is cut into cells, and those into four, until each is proved: one triangle
//! covers it, or triangles of one mesh do whose every edge in the cell is shared, and all of them
//! are nearer there than the box. All numbers are intervals rounded outward, so rounding never
//! makes a proof.
//!
//! Why shared edges prove: take triangles of one mesh that are wound alike on the screen, and count
//! at each point of the cell how many of them cover it. The count changes only across an edge, and
//! there one triangle ends and, if the edge is shared, one of the same winding begins on the other
//! side. So without an edge that is not shared it is the same all over the cell: if it is above 0
//! in one point, the cell is covered. No line of this depends on which triangles they are, nor on
//! how far they are beyond the cell.

use std::collections::HashMap;

use cullet::bounds::Aabb;
use cullet::mesh::Alpha;
use cullet::{
    Scene, Transform, View,
    view::{CullFace, FrontFace},
};

use super::OccluderTriangles;
use super::interval::Interval;
use super::planar::{Cell, Point, Projected, Projector, Range, range_of};
use super::reference::{box_triangles, corners};
use crate::prepare::part_of;
use crate::sort;

/// Result of the proof that a box is hidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Proof {
    /// No ray of the view meets the box before something that hides it, or the box is outside of
    /// the view volume. True of every real-valued point of the image.
    Proved,
    /// At this point of the image, in pixels from the top left corner, the box is seen.
    Refuted {
        /// Column and row, with their fractions.
        pixel: [f64; 2],
    },
    /// Neither is certain.
    Undecided {
        /// How much of the image, in square pixels, is neither proved nor seen. All of it where the
        /// box reaches nearer than the near plane, or is not finite.
        area: f64,
    },
}

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProofOptions {
    /// Cells are cut until they are at most this wide and high, in pixels. Default 1/64. Smaller
    /// leaves less undecided along edges that touch but are not shared, and costs in proportion to
    /// their length.
    pub smallest_px: f64,
    /// At most so many cells are looked at for one box; what is left then is undecided. Default
    /// 200,000: some tenths of a second.
    pub max_cells: u32,
}

impl Default for ProofOptions {
    fn default() -> Self {
        Self { smallest_px: 1.0 / 64.0, max_cells: 200_000 }
    }
}

/// Pixels along a side of the cells that occluders are sorted into.
const BUCKET_PX: u32 = 32;

/// A triangle that may hide.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// `None` where it is seen edge-on, within rounding: it hides nothing for certain.
    shape: Option<Projected>,
    range: Range,
    vertices: [u32; 3],
    /// Mesh and winding on the screen.
    group: u32,
}

/// Occluders as one view sees them, ready for boxes to be proved hidden behind them.
#[derive(Clone, Debug)]
pub struct Prover {
    projector: Projector,
    viewport: [f64; 2],
    /// Triangles sorted by group.
    triangles: Vec<Triangle>,
    /// Where each vertex is in the image.
    places: Vec<Range>,
    buckets: Vec<Vec<u32>>,
    /// How many buckets there are in a row and in a column.
    size: [u32; 2],
}

/// Proves boxes hidden one by one; see [`Prover`], which is the way for more than one box.
#[must_use]
pub fn prove_hidden(
    view: &View,
    occluders: &[OccluderTriangles],
    bounds: &Aabb,
    transform: &Transform,
    options: &ProofOptions,
) -> Proof {
    Prover::new(view, occluders).prove(bounds, transform, options)
}

impl Prover {
    /// Makes occluders ready. Triangles that refer to a vertex that is not there hide nothing, and
    /// nor do those that are not finite. Vertices of one occluder in one place are one vertex.
    ///
    /// Cost: some microseconds and 400 bytes a triangle.
    #[must_use]
    pub fn new(view: &View, occluders: &[OccluderTriangles]) -> Self {
        let mut build = Build::new(view);
        for o in occluders {
            let triangles = o.indices.as_chunks::<3>().0.iter();
            build.add(o.positions, &o.transform, triangles.map(|t| (*t, o.two_sided)));
        }
        build.finish(view)
    }

    /// Makes ready what hides in a scene: opaque parts of instances in the view's layers, but for
    /// those with [`no_occlusion`](cullet::InstanceFlags::no_occlusion).
    #[must_use]
    pub fn of_scene(view: &View, scene: &Scene) -> Self {
        let mut build = Build::new(view);
        for slot in scene.slots() {
            let flags = scene.flags(slot);
            if scene.layers(slot) & view.layers == 0 || flags.transparent || flags.no_occlusion {
                continue;
            }
            let mesh = scene.mesh(slot);
            let triangle = |t: u32| {
                let part = part_of(mesh, mesh.original_triangle()[t as usize]);
                let two_sided = part.two_sided || flags.double_sided;
                (part.alpha == Alpha::Opaque).then_some((mesh.triangle(t), two_sided))
            };
            let triangles = (0..mesh.triangle_count()).filter_map(triangle);
            build.add(mesh.positions(), scene.transform(slot), triangles);
        }
        build.finish(view)
    }

    /// Tries to prove that the box `bounds`, placed in the world by `transform`, is hidden.
    ///
    /// A box that only touches what is before it is not proved. One that reaches nearer than the
    /// near plane is undecided. Empty, NaN and infinite ones are too.
    #[must_use]
    pub fn prove(&self, bounds: &Aabb, transform: &Transform, options: &ProofOptions) -> Proof {
        let all = Proof::Undecided { area: self.viewport[0] * self.viewport[1] };
        if !bounds.is_finite() || bounds.is_empty() || !transform.is_finite() {
            return all;
        }
        let points = corners(bounds).map(|p| self.projector.point(transform, p));
        if self.is_outside(&points) {
            return Proof::Proved;
        }
        let Some(hull) = Hull::new(&points, self.projector.depth[0]) else { return all };
        let mut search = Search {
            prover: self,
            hull,
            smallest: self.viewport.map(|v| options.smallest_px.max(1e-6) * 2.0 / v),
            cells_left: options.max_cells,
            undecided: 0.0,
            seen: None,
        };
        'all: for row in 0..self.size[1] {
            for column in 0..self.size[0] {
                let candidates = &self.buckets[(row * self.size[0] + column) as usize];
                search.cell(&self.bucket(column, row), candidates);
                if search.seen.is_some() {
                    break 'all;
                }
            }
        }
        match search.seen {
            Some([x, y]) => {
                let pixel =
                    [(x + 1.0) * 0.5 * self.viewport[0], (1.0 - y) * 0.5 * self.viewport[1]];
                Proof::Refuted { pixel }
            }
            None if search.undecided > 0.0 => Proof::Undecided { area: search.undecided },
            None => Proof::Proved,
        }
    }

    /// Whether all of these are certainly beyond one side of the view volume.
    fn is_outside(&self, points: &[Point; 8]) -> bool {
        let [low, high] = self.projector.depth.map(Interval::exactly);
        let all = |beyond: fn([Interval; 4], [Interval; 2]) -> bool| {
            points.iter().all(|p| beyond(p.clip, [low, high]))
        };
        all(|[x, _, _, w], _| (x - w).is_positive())
            || all(|[x, _, _, w], _| (-x - w).is_positive())
            || all(|[_, y, _, w], _| (y - w).is_positive())
            || all(|[_, y, _, w], _| (-y - w).is_positive())
            || all(|[_, _, z, w], [low, _]| (low * w - z).is_positive())
            || all(|[_, _, z, w], [_, high]| (z - high * w).is_positive())
    }

    fn bucket(&self, column: u32, row: u32) -> Cell {
        let [nx, ny] = self.size.map(f64::from);
        // Neighbours share the very number between them, and the last ends at 1.
        let at = |i: u32, n: f64| -1.0 + 2.0 * f64::from(i) / n;
        Cell { x: [at(column, nx), at(column + 1, nx)], y: [at(row, ny), at(row + 1, ny)] }
    }
}

/// A [`Prover`] in the making.
struct Build {
    projector: Projector,
    triangles: Vec<Triangle>,
    places: Vec<Range>,
    meshes: u32,
    cull_face: CullFace,
    flipped: bool,
}

impl Build {
    fn new(view: &View) -> Self {
        Self {
            projector: Projector::new(view),
            triangles: Vec::new(),
            places: Vec::new(),
            meshes: 0,
            cull_face: view.cull_face,
            flipped: view.is_mirrored() != (view.front_face == FrontFace::Clockwise),
        }
    }

    fn add(
        &mut self,
        positions: &[[f32; 3]],
        transform: &Transform,
        triangles: impl Iterator<Item = ([u32; 3], bool)>,
    ) {
        if !transform.is_finite() {
            return;
        }
        let mirrored = transform.determinant() < 0.0;
        let mesh = self.meshes;
        self.meshes += 1;
        let mut points: Vec<Point> = Vec::new();
        let first = self.places.len() as u32;
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        for (triangle, two_sided) in triangles {
            let place = triangle.map(|v| positions.get(v as usize).copied());
            let [Some(a), Some(b), Some(c)] = place else { continue };
            let vertices = [a, b, c].map(|p| {
                // −0 is in the place of 0.
                *known.entry(p.map(|v| (v + 0.0).to_bits())).or_insert_with(|| {
                    let point = self.projector.point(transform, p);
                    points.push(point);
                    self.places.push(point.range());
                    points.len() as u32 - 1
                })
            });
            let corners = vertices.map(|v| points[v as usize]);
            let (shape, ccw) = match Projected::new(&corners) {
                Some((shape, ccw)) => (Some(shape), ccw),
                None => (None, false),
            };
            let front = ccw != (self.flipped != mirrored);
            let drawn = two_sided
                || shape.is_none()
                || match self.cull_face {
                    CullFace::None => true,
                    CullFace::Back => front,
                    CullFace::Front => !front,
                };
            if drawn {
                self.triangles.push(Triangle {
                    shape,
                    range: range_of(&corners),
                    vertices: vertices.map(|v| v + first),
                    group: mesh * 2 + u32::from(ccw),
                });
            }
        }
    }

    fn finish(self, view: &View) -> Prover {
        let triangles = sort::sorted_by(&self.triangles, |t| t.group.into());
        let viewport = view.viewport();
        let size = viewport.map(|v| v.div_ceil(BUCKET_PX));
        let mut prover = Prover {
            projector: self.projector,
            viewport: viewport.map(f64::from),
            triangles,
            places: self.places,
            buckets: vec![Vec::new(); (size[0] * size[1]) as usize],
            size,
        };
        let mut buckets = std::mem::take(&mut prover.buckets);
        for (i, t) in (0..).zip(&prover.triangles) {
            // One bucket more on each side, for rounding.
            let span = |r: [f64; 2], n: u32| {
                let at = |v: f64| (v + 1.0) * 0.5 * f64::from(n);
                // The casts saturate.
                ((at(r[0]) - 1.0) as u32, ((at(r[1]) + 1.0) as u32).min(n - 1))
            };
            if t.range.x[0] > 1.0
                || t.range.x[1] < -1.0
                || t.range.y[0] > 1.0
                || t.range.y[1] < -1.0
            {
                continue;
            }
            let ((x0, x1), (y0, y1)) = (span(t.range.x, size[0]), span(t.range.y, size[1]));
            for row in y0..=y1 {
                for column in x0..=x1 {
                    if t.may_meet(&prover.bucket(column, row)) {
                        buckets[(row * size[0] + column) as usize].push(i);
                    }
                }
            }
        }
        prover.buckets = buckets;
        prover
    }
}

impl Triangle {
    fn may_meet(&self, cell: &Cell) -> bool {
        match &self.shape {
            Some(shape) => !shape.misses(cell),
            None => cell.meets(&self.range),
        }
    }
}

/// The image of the box.
struct Hull {
    /// Its twelve triangles.
    faces: Vec<(Option<Projected>, Range)>,
    /// Planes that all of it is certainly behind.
    before: Vec<Projected>,
    /// Depths of its corners.
    depths: [f64; 2],
}

impl Hull {
    /// `None` where it may reach nearer than `near`.
    fn new(points: &[Point; 8], near: f64) -> Option<Self> {
        let ndc = points.each_ref().map(Point::ndc);
        let low = ndc.iter().fold(f64::INFINITY, |m, p| m.min(p[2].low));
        let high = ndc.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[2].high));
        if !(low >= near && high < f64::INFINITY) {
            return None;
        }
        let mut hull = Self { faces: Vec::new(), before: Vec::new(), depths: [low, high] };
        for t in box_triangles() {
            let triangle = t.map(|i| points[i]);
            let shape = Projected::new(&triangle).map(|(shape, _)| shape);
            if let Some(shape) = shape {
                // The box is behind the plane of this side if the opposite side is.
                let axis = !((t[0] ^ t[1]) | (t[0] ^ t[2])) & 7;
                let mut others = (0..8usize).filter(|i| (i ^ t[0]) & axis != 0);
                let behind = |i: usize| {
                    let [x, y, depth] = ndc[i];
                    shape.plane.at(x, y).high <= depth.low
                };
                if others.all(behind) {
                    hull.before.push(shape);
                }
            }
            hull.faces.push((shape, range_of(&triangle)));
        }
        Some(hull)
    }

    fn misses(&self, cell: &Cell) -> bool {
        self.faces.iter().all(|(shape, range)| match shape {
            Some(shape) => shape.misses(cell),
            None => !cell.meets(range),
        })
    }

    /// A depth that none of it is nearer than over a cell: rays enter a convex body through the
    /// last of the planes before it.
    fn nearest(&self, cell: &Cell) -> f64 {
        self.before.iter().fold(self.depths[0], |m, s| m.max(s.plane.over(cell).low))
    }

    /// A depth that some point of it at this place of the image is not farther than; `None` where
    /// there may be none.
    fn reached(&self, at: [f64; 2]) -> Option<f64> {
        let shapes = self.faces.iter().filter_map(|(shape, _)| shape.as_ref());
        shapes
            .filter(|s| s.holds(at))
            .map(|s| s.plane.at_point(at).high.min(s.depths[1]))
            .reduce(f64::min)
    }
}

/// The hunt for a gap.
struct Search<'a> {
    prover: &'a Prover,
    hull: Hull,
    smallest: [f64; 2],
    cells_left: u32,
    undecided: f64,
    seen: Option<[f64; 2]>,
}

impl Search<'_> {
    fn cell(&mut self, cell: &Cell, candidates: &[u32]) {
        if self.seen.is_some() || self.hull.misses(cell) {
            return;
        }
        let [width, height] = [cell.x[1] - cell.x[0], cell.y[1] - cell.y[0]];
        let [w, h] = self.prover.viewport;
        let area = width * height * 0.25 * w * h;
        if self.cells_left == 0 {
            self.undecided += area;
            return;
        }
        self.cells_left -= 1;
        let triangles = &self.prover.triangles;
        let nearest = self.hull.nearest(cell);
        let near = self.prover.projector.depth[0];
        // Those whose every point in the cell is before the box.
        let mut before: Vec<u32> = Vec::new();
        let mut left: Vec<u32> = Vec::with_capacity(candidates.len());
        for &i in candidates {
            let t = &triangles[i as usize];
            if !t.may_meet(cell) {
                continue;
            }
            if let Some(shape) = &t.shape {
                let depth = shape.depth_over(cell);
                if depth.low > self.hull.depths[1] || depth.high < near {
                    continue;
                }
                if depth.high < nearest && depth.low >= near {
                    if shape.covers(cell) {
                        return;
                    }
                    before.push(i);
                }
            }
            left.push(i);
        }
        let same = |a: &u32, b: &u32| triangles[*a as usize].group == triangles[*b as usize].group;
        if before.chunk_by(same).any(|group| self.is_covered(cell, group)) {
            return;
        }
        let centre = cell.centre();
        if self.is_seen(centre, &left) {
            self.seen = Some(centre);
            return;
        }
        if width <= self.smallest[0] && height <= self.smallest[1] {
            self.undecided += area;
            return;
        }
        for quarter in cell.quarters() {
            self.cell(&quarter, &left);
        }
    }

    /// Whether triangles of one mesh and winding, all of them before the box, cover a cell
    /// together: see the head of this file.
    fn is_covered(&self, cell: &Cell, group: &[u32]) -> bool {
        if group.len() < 2 {
            return false;
        }
        // Both ends, and whether it runs from the lower one.
        let mut edges: Vec<(u64, u32)> = Vec::new();
        for &i in group {
            let t = &self.prover.triangles[i as usize];
            let Some(shape) = &t.shape else { continue };
            for (k, edge) in shape.edges.iter().enumerate() {
                let (a, b) = (t.vertices[(k + 1) % 3], t.vertices[(k + 2) % 3]);
                let place = |v: u32| &self.prover.places[v as usize];
                if edge.over(cell).has_zero() && cell.meets(&place(a).union(place(b))) {
                    edges.push((sort::pair(a.min(b), a.max(b)), u32::from(a < b)));
                }
            }
        }
        sort::sort_numbered(&mut edges);
        let shared = edges.chunk_by(|a, b| a.0 == b.0).all(|uses| {
            let forward = uses.iter().filter(|u| u.1 == 1).count();
            forward * 2 == uses.len()
        });
        let ([x0, x1], [y0, y1]) = (cell.x, cell.y);
        let at = |u: f64, v: f64| [x0 + (x1 - x0) * u, y0 + (y1 - y0) * v];
        // Any one point will do; one of these is hardly on an edge.
        let points = [at(0.5, 0.5), at(0.31, 0.17), at(0.83, 0.37), at(0.13, 0.71), at(0.59, 0.93)];
        shared
            && group.iter().any(|&i| {
                let shape = self.prover.triangles[i as usize].shape.as_ref();
                shape.is_some_and(|s| points.iter().any(|p| s.holds(*p)))
            })
    }

    /// Whether the box is certainly seen at a point, with all that may hide it there.
    fn is_seen(&self, at: [f64; 2], candidates: &[u32]) -> bool {
        let Some(depth) = self.hull.reached(at) else { return false };
        let [near, far] = self.prover.projector.depth;
        depth <= far
            && candidates.iter().all(|&i| {
                let t = &self.prover.triangles[i as usize];
                match &t.shape {
                    Some(s) => {
                        let d = s.plane.at_point(at);
                        s.leaves(at) || d.low > depth || d.high < near
                    }
                    None => {
                        let point = Cell { x: [at[0]; 2], y: [at[1]; 2] };
                        !point.meets(&t.range)
                    }
                }
            })
    }
}
