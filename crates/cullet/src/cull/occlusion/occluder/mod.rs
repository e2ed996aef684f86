//! Occluders: shapes that stand for a mesh in the buffer, each of which draws itself.

mod convex;
mod cost;
mod facing;
mod numbers;
mod patch;
#[cfg(feature = "serde")]
mod plain;

pub use convex::Convex;
pub(crate) use cost::{CostModel, EdgeCount, LeastCost};
pub(crate) use facing::{Facing, cross, dot};
pub use patch::Patch;
pub(crate) use patch::{Chunks, check_finite};

use alloc::vec;
use alloc::vec::Vec;

use super::raster::{Canvas, FACETS, OcclusionBuffer};
use crate::Simd;
use crate::bounds::{Aabb, Boxes};
use crate::costs::OccluderCosts;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::mesh::{Alpha, Mesh, connected_regions};
use crate::transform::Transform;

/// A part of an occluder that is drawn, or left out, as one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Shape {
    /// A convex body or polygon.
    Convex(Convex),
    /// Some triangles of a surface.
    Patch(Patch),
}

impl Shape {
    /// Its box, in the space of the mesh.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Convex(convex) => convex.bounds(),
            Self::Patch(patch) => patch.bounds(),
        }
    }

    /// Whether it hides from behind as well as from the front.
    pub(crate) fn is_two_sided(&self) -> bool {
        match self {
            Self::Convex(convex) => convex.is_two_sided(),
            Self::Patch(patch) => patch.mesh.two_sided,
        }
    }

    /// Draws it into `buffer`, the shape standing at `transform`. Nothing where a number is not
    /// finite, and before [`OcclusionBuffer::begin`].
    pub fn draw(&self, simd: Simd, buffer: &mut OcclusionBuffer, transform: &Transform) {
        match self {
            Self::Convex(convex) => convex.draw(simd, buffer, transform),
            Self::Patch(patch) => patch.draw(simd, buffer, transform),
        }
    }

    /// Draws it onto a canvas.
    pub(crate) fn draw_on(&self, simd: Simd, canvas: &mut Canvas<'_>, transform: &Transform) {
        match self {
            Self::Convex(convex) => convex.draw_on(simd, canvas, transform),
            Self::Patch(patch) => patch.draw_on(simd, canvas, transform),
        }
    }

    /// The pixels of its box on the screen from which on it is likely to hide more than drawing it
    /// costs: sixteen for each facet of a patch, none for a convex body.
    #[must_use]
    pub fn worth_pixels(&self) -> f32 {
        match self {
            Self::Convex(_) => 0.0,
            Self::Patch(patch) => patch.mesh.own_facets() as f32 * PIXELS_A_FACET,
        }
    }

    fn edges(&self) -> EdgeCount {
        match self {
            Self::Convex(convex) => EdgeCount::Convex(convex.edges.len() as u32),
            Self::Patch(patch) => EdgeCount::Patch(patch.mesh.edges.len() as u32 * FACETS as u32),
        }
    }
}

/// A facet of fewer pixels hides next to nothing: half the patches of a large model have such.
const PIXELS_A_FACET: f32 = 16.0;

/// Shapes that stand for a mesh in an occlusion buffer: they lie within what the mesh hides.
#[derive(Clone, Debug, Default)]
pub struct Occluder {
    shapes: Vec<Shape>,
    /// How many of the shapes, the last, are for views that begin within `sealed`.
    near: usize,
    sealed: Vec<Aabb>,
    /// Derived from the shapes: their boxes, their edges, what faces an eye, and the least cost of
    /// any.
    boxes: Boxes,
    edges: Vec<EdgeCount>,
    facing: Vec<Option<Facing>>,
    least_cost: LeastCost,
}

impl PartialEq for Occluder {
    fn eq(&self, other: &Self) -> bool {
        (&self.shapes, self.near, &self.sealed) == (&other.shapes, other.near, &other.sealed)
    }
}

impl Occluder {
    /// Creates an occluder of `shapes`, which the caller knows to lie within what the mesh hides.
    #[must_use]
    pub fn new(shapes: Vec<Shape>) -> Self {
        let boxes: Vec<Aabb> = shapes.iter().map(Shape::bounds).collect();
        let edges: Vec<EdgeCount> = shapes.iter().map(Shape::edges).collect();
        let facing = shapes.iter().map(|shape| match shape {
            Shape::Convex(_) => None,
            Shape::Patch(patch) => Some(Facing::of(&patch.mesh)),
        });
        let facing = facing.collect();
        let least_cost = LeastCost::of(&edges);
        let boxes = Boxes::from_slice(&boxes);
        Self { shapes, near: 0, sealed: Vec::new(), boxes, edges, facing, least_cost }
    }

    /// The mesh itself: one body where it is convex, closed and opaque; else a body for each of its
    /// one-sided regions that is, and the rest of its opaque triangles in patches. Blended and
    /// alpha-masked parts do not occlude, nor does a mesh that can deform.
    #[must_use]
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let opaque = mesh.parts().iter().all(|p| p.alpha == Alpha::Opaque);
        if mesh.is_deformable() || mesh.clusters().is_empty() {
            return Self::default();
        }
        let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize * 3;
        if opaque
            && drawn <= Convex::MAX_VERTICES * 32
            && let Some(convex) = Convex::from_mesh(mesh.positions(), &mesh.indices()[..drawn])
        {
            return Self::new(vec![Shape::Convex(convex)]);
        }
        // Within a body of two sides one may stand, and see its walls; a patch has those.
        let (mut shapes, is_in_body) = convex_regions(mesh);
        for two_sided in [false, true] {
            // Edges join what is opaque and has as many sides.
            let mut indices = Vec::new();
            for cluster in mesh.clusters() {
                let part = &mesh.parts()[cluster.part as usize];
                if part.alpha == Alpha::Opaque && part.two_sided == two_sided {
                    for t in cluster.triangles().map(|t| t as usize).filter(|&t| !is_in_body[t]) {
                        indices.extend(&mesh.indices()[t * 3..t * 3 + 3]);
                    }
                }
            }
            // A mesh was checked when it was made, so nothing here is refused.
            if let Ok(cut) = Patch::cut(mesh.positions(), &indices, Patch::FACETS, two_sided) {
                shapes.extend(cut.into_iter().map(Shape::Patch));
            }
        }
        Self::new(shapes)
    }

    /// Says where its bodies do not hide: of a view whose eye or near rectangle comes into one of
    /// these boxes, in the space of the mesh, no closed body is drawn, only polygons and patches. A
    /// box baked within the walls of a room hides the room from outside, but nothing of it from
    /// within.
    #[must_use]
    pub fn with_sealed(mut self, sealed: Vec<Aabb>) -> Self {
        self.sealed = sealed;
        self
    }

    /// Adds shapes for views that begin within [`sealed`](Self::with_sealed), where they take the
    /// place of closed bodies and of patches: such as the surface of a terrain, of which boxes hide
    /// the mountain from afar. No other view has them.
    #[must_use]
    pub fn with_near(mut self, shapes: Vec<Shape>) -> Self {
        let near = self.near + shapes.len();
        self.shapes.extend(shapes);
        Self { near, sealed: self.sealed, ..Self::new(self.shapes) }
    }

    /// Whether a view has one of the shapes: one that begins within [`sealed`](Self::with_sealed),
    /// or another.
    #[must_use]
    pub fn is_for(&self, shape: usize, within: bool) -> bool {
        let for_near = shape + self.near >= self.shapes.len();
        match &self.shapes[shape] {
            _ if for_near || !within => for_near == within,
            Shape::Convex(convex) => convex.face_count() <= 2,
            Shape::Patch(_) => self.near == 0,
        }
    }

    /// Where its bodies do not hide; see [`with_sealed`](Self::with_sealed).
    #[must_use]
    pub fn sealed(&self) -> &[Aabb] {
        &self.sealed
    }

    /// Cost of drawing it over so many pixels from outside, in microseconds of a cost model.
    #[must_use]
    pub fn cost(&self, costs: &OccluderCosts, pixels: f32) -> f32 {
        let (model, far) = (CostModel::new(costs), &self.edges[..self.edges.len() - self.near]);
        far.iter().map(|edges| model.cost(*edges, pixels)).sum()
    }

    /// The edges of each of its shapes, on which its cost depends.
    pub(crate) fn edges(&self) -> &[EdgeCount] {
        &self.edges
    }

    /// Area that each of its patches shows to an eye; `None` for a body.
    pub(crate) fn facing(&self) -> &[Option<Facing>] {
        &self.facing
    }

    /// The boxes of its shapes, in the space of the mesh.
    pub(crate) fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// No shape of it costs less.
    pub(crate) fn least_cost(&self) -> LeastCost {
        self.least_cost
    }

    /// Its shapes; those that [`with_near`](Self::with_near) added come last.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }
}

/// The most triangles of a region that is tried: as many as a body of triangles has at the most
/// vertices.
const MOST_OF_REGION: u32 = Convex::MAX_VERTICES as u32 * 2 - 4;

/// The least size of a body, as a share of the mesh; smaller ones are left to the patches: the
/// bolts of a machine are not to be looked at one by one.
const LEAST_OF_MESH: f32 = 1.0 / 4.0;

fn diagonal(b: &Aabb) -> f32 {
    (0..3).map(|a| (b.max[a] - b.min[a]).powi(2)).sum::<f32>().sqrt()
}

/// The regions of a mesh, of what is opaque and one-sided, that are closed and convex, in the order
/// of their first triangles; and whether a triangle is of one. A body is drawn at a tenth of what
/// its triangles cost, and covers more: nothing is lost where they meet.
fn convex_regions(mesh: &Mesh) -> (Vec<Shape>, Vec<bool>) {
    let mut is_wanted = vec![false; mesh.triangle_count() as usize];
    for cluster in mesh.clusters() {
        let part = &mesh.parts()[cluster.part as usize];
        if part.alpha == Alpha::Opaque && !part.two_sided {
            cluster.triangles().for_each(|t| is_wanted[t as usize] = true);
        }
    }
    // An edge of more triangles than two joins them all, so that what stays is left whole by what
    // goes.
    let regions = connected_regions(mesh.positions(), mesh.indices(), |t| is_wanted[t]);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); regions.count()];
    for (t, &region) in regions.of.iter().enumerate() {
        let count = regions.triangles.get(region as usize).copied().unwrap_or(0);
        if (4..=MOST_OF_REGION).contains(&count) {
            lists[region as usize].extend(&mesh.indices()[t * 3..t * 3 + 3]);
        }
    }
    let least = diagonal(&mesh.bounds()) * LEAST_OF_MESH;
    let body = |list: &Vec<u32>| {
        let corners: Vec<_> = list.iter().map(|&v| mesh.positions()[v as usize]).collect();
        let is_large = diagonal(&Aabb::from_points(&corners)) >= least;
        is_large.then(|| Convex::from_mesh(mesh.positions(), list)).flatten()
    };
    let bodies: Vec<Option<Convex>> = lists.iter().map(body).collect();
    let is_in_body = |&region: &u32| bodies.get(region as usize).is_some_and(Option::is_some);
    let is_in_body = regions.of.iter().map(is_in_body).collect();
    (bodies.into_iter().flatten().map(Shape::Convex).collect(), is_in_body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_shapes_take_the_place_of_bodies_and_patches_but_not_of_polygons() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cube = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let body = Shape::Convex(Convex::from_box(&cube).unwrap());
        let polygon = Shape::Convex(Convex::from_one_sided_polygon(&corners).unwrap());
        let patch =
            Shape::Patch(Patch::cut(&corners, &[0, 1, 2], Patch::FACETS, false).unwrap().remove(0));
        let far = Occluder::new(vec![body, polygon, patch.clone()]).with_sealed(vec![cube]);
        let of = |o: &Occluder, within| {
            (0..o.shapes().len()).map(|i| o.is_for(i, within)).collect::<Vec<_>>()
        };
        assert_eq!(of(&far, false), [true, true, true]);
        assert_eq!(of(&far, true), [false, true, true]);
        let both = far.clone().with_near(vec![patch]);
        assert_eq!(of(&both, false), [true, true, true, false]);
        assert_eq!(of(&both, true), [false, true, false, true]);
        // A view from outside does not pay for them.
        let costs = OccluderCosts::default();
        assert_eq!(both.cost(&costs, 100.0), far.cost(&costs, 100.0));
    }
}
