//! Rays against the triangles of a scene: a tree over each mesh, and one over the instances.

use cullet::bounds::Aabb;
use cullet::mesh::{Alpha, Mesh};
use cullet::{Handle, Scene};
use glam::{DMat3, DVec3};

use super::SampledError;
use super::box_tree::BoxTree;
use super::crossing::{Crossing, crossing, inverse, reaches};
use super::targets::{Ball, Granularity, Targets};
use cullet_draw::Random;

/// Options that choose the instances that take part, and the items of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayTreeOptions {
    /// Items of rows. Default: instances.
    pub granularity: Granularity,
    /// Instances in none of these layers hide nothing, and are kept in every row: sets are for
    /// views of just these layers. Default: all.
    pub layers: u32,
}

impl Default for RayTreeOptions {
    fn default() -> Self {
        Self { granularity: Granularity::default(), layers: u32::MAX }
    }
}

/// The triangles of a scene, as rays meet them.
///
/// An opaque triangle stops who looks at a side of it that is drawn; a one-sided one is looked
/// through from behind, as in a picture. Blended and alpha-masked parts, and instances that are
/// flagged transparent, stop nothing and are seen. Instances whose triangles are not known now
/// (their mesh can deform, or the caller gave their bounds), and those with a transform that is not
/// finite or flattens them, hide nothing and are [kept](Self::kept) in all rows.
#[derive(Debug)]
pub struct RayTree<'a> {
    pub(super) scene: &'a Scene,
    pub(super) origin: DVec3,
    targets: Targets,
    bodies: Vec<Body>,
    /// One tree per mesh; none where no instance needs it.
    meshes: Vec<Option<MeshTree>>,
    /// Over the bodies, relative to the origin of the scene.
    top: BoxTree,
    kept: Vec<u32>,
    /// Place of the body of each handle, by the handle's index; `u32::MAX` for none.
    by_index: Vec<u32>,
    /// Around each target; `None` for one that takes no part.
    balls: Vec<Option<Ball>>,
}

/// An instance that takes part.
#[derive(Debug)]
pub(crate) struct Body {
    pub(crate) slot: u32,
    pub(crate) handle: Handle,
    pub(crate) mesh: u32,
    first: u32,
    linear: DMat3,
    inverse: DMat3,
    /// Relative to the origin of the scene.
    place: DVec3,
    /// The box around it, relative to the origin as well and a little larger.
    bounds: [DVec3; 2],
    transparent: bool,
    two_sided: bool,
}

/// Meshes of so many triangles and fewer have no tree: walking one takes as long.
const FEW: usize = 16;

/// The triangles of a mesh, in the order of its tree.
#[derive(Debug)]
struct MeshTree {
    /// `None` for few triangles, which are tried one by one.
    tree: Option<BoxTree>,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [[f32; 3]; 3],
    cluster: u32,
    /// In the mesh's order.
    number: u32,
    two_sided: bool,
    opaque: bool,
}

/// A triangle that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeHit {
    /// How far along the ray, in lengths of its direction.
    pub distance: f64,
    /// The instance or cluster.
    pub target: u32,
    /// The triangle, by its original number in its mesh.
    pub triangle: u32,
}

/// Something that does not stop a ray, and is seen along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passed {
    pub(super) distance: f64,
    pub(super) target: u32,
    /// Whether who looks along the ray, and against it, sees it.
    pub(super) seen: [bool; 2],
}

/// Result of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cast {
    /// Hit that stops the ray.
    pub(super) hit: Option<TreeHit>,
    /// The nearest triangle before that which is seen against the ray only: who looks back from
    /// beyond it sees that.
    pub(super) back: Option<TreeHit>,
    /// Whether the first opaque triangle that it crosses, seen or not, turns its front to it, or
    /// there is none: not so from within something solid.
    pub(super) open: bool,
}

impl Cast {
    /// How far it goes.
    pub(super) fn end(&self) -> f64 {
        self.hit.map_or(f64::INFINITY, |hit| hit.distance)
    }
}

impl MeshTree {
    fn new(mesh: &Mesh) -> Option<Self> {
        let mut triangles = Vec::new();
        for (cluster, c) in (0..).zip(mesh.clusters()) {
            let part = &mesh.parts()[c.part as usize];
            triangles.extend(c.triangles().map(|number| Triangle {
                corners: mesh.corners(number),
                cluster,
                number,
                two_sided: part.two_sided,
                opaque: part.alpha == Alpha::Opaque,
            }));
        }
        if triangles.is_empty() {
            return None;
        }
        if triangles.len() <= FEW {
            return Some(Self { tree: None, triangles });
        }
        let boxes: Vec<[DVec3; 2]> = triangles
            .iter()
            .map(|t| {
                let [p, q, r] = t.corners.map(|v| DVec3::from(v.map(f64::from)));
                [p.min(q).min(r), p.max(q).max(r)]
            })
            .collect();
        let (tree, order) = BoxTree::new(&boxes);
        let triangles = order.iter().map(|&i| triangles[i as usize]).collect();
        Some(Self { tree: Some(tree), triangles })
    }

    /// Visits the triangles that a ray may meet up to a distance; see [`BoxTree::walk`].
    #[inline]
    fn walk(
        &self,
        start: DVec3,
        along: DVec3,
        limit: f64,
        mut visit: impl FnMut(&Triangle) -> f64,
    ) {
        match &self.tree {
            Some(tree) => tree.walk(start, along, limit, |at| visit(&self.triangles[at])),
            None => self.triangles.iter().for_each(|triangle| {
                visit(triangle);
            }),
        }
    }
}

impl<'a> RayTree<'a> {
    /// Builds the trees: O(n log n) of the triangles of meshes, and of the instances.
    ///
    /// # Errors
    /// If nothing in the scene could be seen, or there is more than numbers go.
    pub fn new(scene: &'a Scene, options: &RayTreeOptions) -> Result<Self, SampledError> {
        let targets = Targets::new(scene, options.granularity)?;
        let origin = DVec3::from(scene.origin());
        let mut meshes: Vec<Option<MeshTree>> = Vec::new();
        meshes.resize_with(scene.meshes().len(), || None);
        let (mut bodies, mut kept, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for slot in scene.slots() {
            let Some(handle) = scene.handle(slot) else { continue };
            let transform = scene.transform(slot);
            let b = scene.bounds(slot);
            let takes_part = scene.layers(slot) & options.layers != 0
                && scene.is_rigid(slot)
                && transform.is_finite()
                && transform.rank() == 3
                && b.is_finite()
                && !b.is_empty();
            let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
            let inverse = linear.inverse();
            let mesh = scene.mesh_id(slot);
            if !takes_part || !inverse.is_finite() {
                kept.extend(targets.range(handle.index).unwrap_or_default());
                continue;
            }
            let tree = &mut meshes[mesh as usize];
            if tree.is_none() {
                *tree = MeshTree::new(scene.mesh(slot));
            }
            if tree.is_none() {
                continue;
            }
            let flags = scene.flags(slot);
            bodies.push(Body {
                slot,
                handle,
                mesh,
                first: targets.first(handle.index).unwrap_or(0),
                linear,
                inverse,
                place: DVec3::from(transform.translation) - origin,
                bounds: widened(b),
                transparent: flags.transparent,
                two_sided: flags.double_sided,
            });
            boxes.push([b.min, b.max].map(|v| DVec3::from(v.map(f64::from))));
        }
        if bodies.is_empty() {
            return Err(SampledError::Empty { instances: scene.instance_count() });
        }
        let (top, places) = BoxTree::new(&boxes);
        // In the order of the tree, so that what is near each other lies near each other.
        let mut order: Vec<Option<Body>> = bodies.into_iter().map(Some).collect();
        let bodies: Vec<Body> = places.iter().filter_map(|&i| order[i as usize].take()).collect();
        let most = bodies.iter().map(|b| b.handle.index + 1).max().unwrap_or(0);
        let mut by_index = vec![u32::MAX; most as usize];
        (0..).zip(&bodies).for_each(|(at, b)| by_index[b.handle.index as usize] = at);
        kept.sort_unstable();
        let balls = Vec::new();
        let mut tree = Self { scene, origin, targets, bodies, meshes, top, kept, by_index, balls };
        let ball = |target| tree.target_bounds(target).map(Ball::around);
        // Needed with every line that is drawn.
        tree.balls = (0..tree.targets.count()).map(ball).collect();
        Ok(tree)
    }

    /// Numbers of what may be seen.
    #[must_use]
    pub fn targets(&self) -> &Targets {
        &self.targets
    }

    /// Targets that no ray can tell of, and that every row keeps; ascending.
    #[must_use]
    pub fn kept(&self) -> &[u32] {
        &self.kept
    }

    /// The box around all instances that take part, in the world; a little larger, for what is
    /// rounded.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.top.bounds().map(|v| (v + self.origin).into())
    }

    /// How many triangles all instances that take part have.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        let of = |body: &Body| self.mesh_of(body).triangles.len() as u64;
        self.bodies.iter().map(of).sum()
    }

    /// Returns the first hit that stops a ray from a point along a direction, both in the world: an
    /// opaque triangle, drawn on the side that is looked at. Among several at one distance the
    /// lowest target and triangle wins. Of several at one distance that of the lowest target and
    /// triangle. `None` where nothing stops it, or where an argument is not finite or the direction
    /// has no length.
    #[must_use]
    pub fn first_hit(&self, from: [f64; 3], direction: [f64; 3]) -> Option<TreeHit> {
        self.cast(from.into(), direction.into(), &mut Vec::new()).hit
    }

    pub(crate) fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    fn mesh_of(&self, body: &Body) -> &MeshTree {
        // Made when the body was.
        self.meshes[body.mesh as usize].as_ref().expect("a body's mesh has a tree")
    }

    /// Returns what a ray meets, and leaves the transparent hits that it passes in `passed`, in
    /// order.
    pub(super) fn cast(&self, from: DVec3, direction: DVec3, passed: &mut Vec<Passed>) -> Cast {
        passed.clear();
        let mut search = Search {
            tree: self,
            inverse: inverse(direction),
            hit: None,
            back: None,
            first: (f64::INFINITY, true),
            passed,
        };
        let from = from - self.origin;
        let length = direction.length();
        if !(from.is_finite() && length > 0.0 && length.is_finite()) {
            return Cast { hit: None, back: None, open: true };
        }
        search.look(from, direction);
        let (hit, mut back, open) = (search.hit, search.back, search.first.1);
        let end = hit.map_or(f64::INFINITY, |hit| hit.distance);
        passed.retain(|p| p.distance < end);
        passed.sort_by(|a, b| (a.distance.total_cmp(&b.distance)).then(a.target.cmp(&b.target)));
        if back.is_some_and(|back| back.distance >= end) {
            back = None;
        }
        Cast { hit, back, open }
    }

    /// [`first_hit`](Self::first_hit) by a plain loop over all triangles: the oracle of its tests.
    /// O(triangles).
    #[must_use]
    pub fn first_hit_ref(&self, from: [f64; 3], direction: [f64; 3]) -> Option<TreeHit> {
        let (from, direction) = (DVec3::from(from) - self.origin, DVec3::from(direction));
        let mut nearest: Option<TreeHit> = None;
        for body in &self.bodies {
            let mesh = self.scene.mesh(body.slot);
            let (start, along) = body.ray(from, direction);
            for (number, cluster) in mesh.clusters().iter().enumerate() {
                let part = &mesh.parts()[cluster.part as usize];
                if part.alpha != Alpha::Opaque || body.transparent {
                    continue;
                }
                for t in cluster.triangles() {
                    let Some(found) = crossing(start, along, mesh.corners(t)) else { continue };
                    if !(found.from_front || part.two_sided || body.two_sided) {
                        continue;
                    }
                    let target = self.target(body, number as u32);
                    let triangle = mesh.original_triangle()[t as usize];
                    let hit = TreeHit { distance: found.distance, target, triangle };
                    if nearest.is_none_or(|n| hit.is_before(&n)) {
                        nearest = Some(hit);
                    }
                }
            }
        }
        nearest
    }

    #[inline]
    fn target(&self, body: &Body, cluster: u32) -> u32 {
        match self.targets.granularity() {
            Granularity::Instance => body.first,
            Granularity::Cluster => body.first + cluster,
        }
    }

    /// How often a ray leaves a body by a face's back, less how often it enters by a front: how
    /// many times its surface is wound around the point that it starts from.
    pub(crate) fn winding(&self, body: &Body, from: DVec3, direction: DVec3) -> i32 {
        let (start, along) = body.ray(from - self.origin, direction);
        let mesh = self.mesh_of(body);
        let mut sum = 0;
        mesh.walk(start, along, f64::INFINITY, |triangle| {
            if let Some(found) = crossing(start, along, triangle.corners) {
                sum += if found.from_front { -1 } else { 1 };
            }
            f64::INFINITY
        });
        sum
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The box around a body, in the world, and a little larger.
    pub(crate) fn body_bounds(&self, body: &Body) -> [DVec3; 2] {
        body.bounds.map(|v| v + self.origin)
    }

    /// A point of a body's mesh, in the world.
    pub(crate) fn world_of(&self, body: &Body, point: [f32; 3]) -> DVec3 {
        body.place_of(point) + self.origin
    }

    /// The box around a target, in the world; `None` for one that takes no part.
    pub(super) fn target_bounds(&self, target: u32) -> Option<[DVec3; 2]> {
        let body = self.body_of(target)?;
        let b = match self.targets.granularity() {
            Granularity::Instance => self.scene.bounds(body.slot),
            Granularity::Cluster => {
                let mesh = self.scene.mesh(body.slot);
                let b = mesh.cluster_boxes().get((target - body.first) as usize);
                self.scene.transform(body.slot).transform_box(&b, self.scene.origin())
            }
        };
        Some([b.min, b.max].map(|v| DVec3::from(v.map(f64::from)) + self.origin))
    }

    /// A ball around a target.
    pub(super) fn ball(&self, target: u32) -> Option<Ball> {
        self.balls.get(target as usize).copied().flatten()
    }

    /// The body of a target; `None` for one that takes no part.
    pub(super) fn body_of(&self, target: u32) -> Option<&Body> {
        let index = self.targets.index_of(target);
        let at = self.by_index.get(index as usize).copied().filter(|&at| at != u32::MAX)?;
        self.bodies.get(at as usize)
    }

    /// A random point of a target; `None` for one that takes no part.
    pub(super) fn point_of(&self, target: u32, random: &mut Random) -> Option<DVec3> {
        let body = self.body_of(target)?;
        let mesh = self.scene.mesh(body.slot);
        let range = match self.targets.granularity() {
            Granularity::Instance => {
                let drawn = mesh.triangle_count() - mesh.degenerate_count();
                0..drawn
            }
            Granularity::Cluster => mesh.clusters()[(target - body.first) as usize].triangles(),
        };
        let t = range.start + random.below((range.end - range.start).max(1));
        let [p, q, r] = mesh.corners(t).map(|v| DVec3::from(v.map(f64::from)));
        let (mut a, mut b) = (random.unit(), random.unit());
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        let at = p + (q - p) * a + (r - p) * b;
        Some(body.linear * at + body.place + self.origin)
    }
}

/// A box, larger by far more than rays round and far less than counts.
fn widened(b: Aabb) -> [DVec3; 2] {
    let [low, high] = [b.min, b.max].map(|v| DVec3::from(v.map(f64::from)));
    let room = DVec3::splat(low.abs().max(high.abs()).max_element() * 1e-9);
    [low - room, high + room]
}

impl TreeHit {
    fn is_before(&self, other: &Self) -> bool {
        let key = |h: &Self| (h.target, h.triangle);
        self.distance < other.distance || self.distance == other.distance && key(self) < key(other)
    }
}

impl Body {
    /// A ray in the space of the mesh; distances along it stay what they are.
    #[inline]
    fn ray(&self, from: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (self.inverse * (from - self.place), self.inverse * direction)
    }

    /// A point of its mesh, relative to the origin of the scene.
    pub(crate) fn place_of(&self, point: [f32; 3]) -> DVec3 {
        self.linear * DVec3::from(point.map(f64::from)) + self.place
    }

    /// Whether it hides nothing.
    pub(crate) fn is_transparent(&self) -> bool {
        self.transparent
    }
}

struct Search<'a> {
    tree: &'a RayTree<'a>,
    /// One by the direction's coordinates.
    inverse: DVec3,
    hit: Option<TreeHit>,
    back: Option<TreeHit>,
    /// How far the first opaque triangle is, and whether it turns its front to the ray.
    first: (f64, bool),
    passed: &'a mut Vec<Passed>,
}

impl Search<'_> {
    fn end(&self) -> f64 {
        self.hit.map_or(f64::INFINITY, |hit| hit.distance)
    }

    fn look(&mut self, from: DVec3, direction: DVec3) {
        let tree = self.tree;
        tree.top.walk(from, direction, f64::INFINITY, |at| {
            self.look_into(&tree.bodies[at], from, direction);
            self.end()
        });
    }

    fn look_into(&mut self, body: &Body, from: DVec3, direction: DVec3) {
        // Most boxes of the tree are met only because it keeps them roughly.
        if !reaches(&body.bounds, from, self.inverse, self.end()) {
            return;
        }
        let mesh = self.tree.mesh_of(body);
        let (start, along) = body.ray(from, direction);
        mesh.walk(start, along, self.end(), |triangle| {
            if let Some(found) = crossing(start, along, triangle.corners) {
                self.meet(body, triangle, found);
            }
            self.end()
        });
    }

    #[inline]
    fn meet(&mut self, body: &Body, triangle: &Triangle, found: Crossing) {
        let Crossing { distance, from_front } = found;
        if distance > self.end() {
            return;
        }
        let both = triangle.two_sided || body.two_sided;
        let target = self.tree.target(body, triangle.cluster);
        if !triangle.opaque || body.transparent {
            let seen = [from_front || both, !from_front || both];
            self.passed.push(Passed { distance, target, seen });
            return;
        }
        // Of two at one place the front counts, whichever comes first.
        if distance < self.first.0 || distance == self.first.0 && from_front {
            self.first = (distance, from_front);
        }
        let original = || {
            let mesh = self.tree.scene.mesh(body.slot);
            mesh.original_triangle()[triangle.number as usize]
        };
        let hit = TreeHit { distance, target, triangle: original() };
        let nearest = if from_front || both { &mut self.hit } else { &mut self.back };
        if nearest.is_none_or(|n| hit.is_before(&n)) {
            *nearest = Some(hit);
        }
    }
}
