//! Line of sight: what stands between two points.

use alloc::vec::Vec;

use cullet::exact;
#[cfg(not(feature = "std"))]
use cullet::math::Float as _;
use cullet::mesh::{Alpha, Cluster};
use cullet::{Handle, Mesh, Scene};
use glam::{DMat3, DVec3};

use super::linear::linear;
use super::segment::{Span, walk};
use super::triangle::{SHARE_ERROR, crossing};

/// The side of one-sided triangles that blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum BlockingSides {
    /// The side that is drawn: a triangle of a one-sided part blocks who looks at its front, and is
    /// looked through from behind, as in a picture. Two ends may then see each other one way and
    /// not the other.
    #[default]
    AsDrawn,
    /// Both: what is solid blocks whichever end one looks from.
    Both,
}

/// The blocker that a query is to find.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Find {
    /// The one nearest to the start.
    #[default]
    Nearest,
    /// Any: as soon as one is found the search ends. The same one every time.
    Any,
}

/// Settings of line-of-sight queries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SightOptions {
    /// Instances in none of these layers do not block. Default all.
    pub layers: u32,
    /// The side of one-sided triangles that blocks. Default [`BlockingSides::AsDrawn`].
    pub sides: BlockingSides,
    /// The blocker to find. Default [`Find::Nearest`].
    pub find: Find,
    /// Instances that do not block, such as who looks and who is looked at. A handle that names
    /// none is no error.
    pub ignored: [Option<Handle>; 2],
}

impl Default for SightOptions {
    fn default() -> Self {
        Self {
            layers: u32::MAX,
            sides: BlockingSides::default(),
            find: Find::default(),
            ignored: [None; 2],
        }
    }
}

/// Result of a line-of-sight query between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// Nothing that blocks.
    Clear,
    /// Something opaque.
    Blocked(Blocker),
}

impl Sight {
    /// Whether something blocks.
    #[must_use]
    pub fn is_blocked(&self) -> bool {
        matches!(self, Self::Blocked(_))
    }
}

/// A triangle that blocks a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Its instance.
    pub handle: Handle,
    /// The slot of that.
    pub slot: u32,
    /// Its original number in its mesh.
    pub triangle: u32,
    /// How far along the way it is crossed: above 0 at the start, below 1 at the end, right to
    /// 1e-9.
    pub share: f64,
    /// Where, in world space.
    pub point: [f64; 3],
}

/// Two points in world space: from where one looks, and what is looked at.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Segment {
    /// The start.
    pub from: [f64; 3],
    /// The end.
    pub to: [f64; 3],
}

/// No coordinate may be farther from the scene's origin: bounds are not told apart there.
const FARTHEST: f64 = 1e17;

/// Finds what blocks the line of sight from one point to another, both in world space.
///
/// Triangles block that are opaque: of a part that is neither blended nor alpha-masked, of an
/// instance that is not flagged transparent, and on the side that the options say. Layers count as
/// for a view. An instance that is flagged `no_occlusion` is drawn as any other, and blocks.
///
/// Exact: a triangle blocks if the two ends lie on different sides of its plane and the segment
/// passes through its inside or its border. So nothing slips through between two triangles that
/// share an edge or a corner by its position, within one instance; an end that lies on a surface is
/// not blocked by that surface; and a triangle seen edge-on blocks nothing. What is exact are the
/// signs, of vertices and ends that were rounded to f64 once, relative to `from`.
///
/// *Blocked* is a proof and *clear* is its absence: what is not known does not block. That is an
/// instance that is not [rigid](Scene::is_rigid) (it can deform, or the caller gave its bounds:
/// where its triangles are now, only a shader knows), one whose transform is not finite or flattens
/// it, and everything where a coordinate of an end is not finite or is more than 1e17 away from the
/// scene's origin. Nothing blocks between a point and itself.
///
/// Cost: the nodes, cluster boxes and triangles that the segment comes near; it allocates nothing,
/// but for where rounding hides a sign. It is right at any time; [commit](Scene::commit) the scene
/// for it to be quick.
///
/// ```
/// use cullet_cells::query::{Sight, SightOptions, line_of_sight};
/// # use cullet::{Instance, Mesh, MeshData, Scene, Transform};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
/// # let wall = Mesh::new(MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() })?;
/// let mut scene = Scene::new();
/// let wall = scene.add_mesh(wall);
/// let wall = scene.add(Instance::new(wall, Transform::from_translation([0.0, 0.0, -5.0])))?;
///
/// let options = SightOptions::default();
/// let Sight::Blocked(by) = line_of_sight(&scene, [0.0; 3], [0.0, 0.0, -20.0], &options) else {
///     panic!("the wall is in between");
/// };
/// assert_eq!((by.handle, by.triangle, by.share), (wall, 0, 0.25));
/// assert_eq!(line_of_sight(&scene, [0.0; 3], [9.0, 0.0, -20.0], &options), Sight::Clear);
/// # Ok(())
/// # }
/// ```
#[must_use]
pub fn line_of_sight(scene: &Scene, from: [f64; 3], to: [f64; 3], options: &SightOptions) -> Sight {
    let origin = scene.origin();
    let far = |p: [f64; 3]| (0..3).any(|a| (p[a] - origin[a]).abs() > FARTHEST);
    // A NaN is not far, so it is looked for as well.
    if ![from, to].iter().all(|&p| p.iter().all(|v| v.is_finite()) && !far(p)) {
        return Sight::Clear;
    }
    let (start, along) = (DVec3::from(from), DVec3::from(to) - DVec3::from(from));
    // Boxes hold what is in them by the rounding of their own terms; what is new here are the ends.
    let size = start.abs() + DVec3::from(to).abs() + DVec3::from(origin).abs();
    let relative = start - DVec3::from(origin);
    let span = Span::new(relative.into(), along.into(), (size * BOX_ROUNDING).into());
    let ignored = options.ignored.map(|h| h.and_then(|h| scene.slot(h).ok()));
    let mut search = Search { scene, options, start, along, nearest: None };
    let mut limit = 1.0;
    let hierarchy = scene.hierarchy();
    walk((hierarchy.nodes(), hierarchy.boxes()), &span, &mut limit, &mut |slot, limit| {
        let slot = slot as u32;
        !ignored.contains(&Some(slot)) && search.look_into(slot, limit)
    });
    search.nearest.map_or(Sight::Clear, Sight::Blocked)
}

/// [`line_of_sight`] for each of many segments, in their order. `results` is cleared first. To use
/// several threads, give each its own part of the segments.
pub fn lines_of_sight(
    scene: &Scene,
    segments: &[Segment],
    options: &SightOptions,
    results: &mut Vec<Sight>,
) {
    results.clear();
    results.extend(segments.iter().map(|s| line_of_sight(scene, s.from, s.to, options)));
}

/// Ends are off by so much of their size where they are held against boxes; a little more than the
/// roundings are.
const BOX_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// From so many clusters on their boxes are tested: in the space of the mesh, into which the
/// segment must be brought.
const LEAST_CLUSTERS: usize = 2;

/// Transforms that stretch some direction so much more than another are not inverted: all clusters
/// are looked into.
const WORST_CONDITION: f64 = 1e6;

/// The search along one segment.
struct Search<'a> {
    scene: &'a Scene,
    options: &'a SightOptions,
    start: DVec3,
    along: DVec3,
    nearest: Option<Blocker>,
}

/// An instance that may block.
struct Body<'a> {
    slot: u32,
    mesh: &'a Mesh,
    linear: DMat3,
    /// From the segment's start to the instance's own origin.
    shift: DVec3,
    is_mirrored: bool,
    double_sided: bool,
}

impl<'a> Search<'a> {
    /// Looks for blockers of one instance; whether the search is over.
    fn look_into(&mut self, slot: u32, limit: &mut f64) -> bool {
        let Some(body) = self.body(slot) else { return false };
        let clusters = body.mesh.clusters();
        let span = (clusters.len() >= LEAST_CLUSTERS).then(|| body.span(self)).flatten();
        let Some(span) = span else {
            return clusters.iter().any(|c| self.look_into_cluster(&body, c, limit));
        };
        let tree = (body.mesh.cluster_nodes(), body.mesh.cluster_boxes());
        walk(tree, &span, limit, &mut |c, limit| self.look_into_cluster(&body, &clusters[c], limit))
    }

    /// The instance of a slot, if it may block.
    fn body(&self, slot: u32) -> Option<Body<'a>> {
        let (scene, flags) = (self.scene, self.scene.flags(slot));
        let transform = scene.transform(slot);
        let may_block = scene.layers(slot) & self.options.layers != 0
            && !flags.transparent
            && scene.is_rigid(slot)
            && transform.is_finite();
        // What is flattened is not drawn.
        let turn = if may_block { exact::determinant_sign(&transform.linear) } else { 0 };
        (turn != 0).then(|| Body {
            slot,
            mesh: scene.mesh(slot),
            linear: linear(transform),
            shift: DVec3::from(transform.translation) - self.start,
            is_mirrored: turn < 0,
            double_sided: flags.double_sided,
        })
    }

    fn look_into_cluster(&mut self, body: &Body<'_>, cluster: &Cluster, limit: &mut f64) -> bool {
        let part = &body.mesh.parts()[cluster.part as usize];
        if part.alpha != Alpha::Opaque {
            return false;
        }
        let both = part.two_sided || body.double_sided || self.options.sides == BlockingSides::Both;
        for triangle in cluster.triangles() {
            // The same numbers for a vertex, whichever triangle it is of.
            let place =
                |p: [f32; 3]| (body.linear * DVec3::from(p.map(f64::from)) + body.shift).into();
            let corners: [[f64; 3]; 3] = body.mesh.corners(triangle).map(place);
            let Some(found) = crossing(self.along.into(), corners) else { continue };
            if !(both || found.from_front != body.is_mirrored) {
                continue;
            }
            self.note(body, triangle, found.share);
            if self.options.find == Find::Any {
                return true;
            }
            // No box beyond holds a nearer one, whatever rounding did to both shares.
            let nearest = self.nearest.map_or(1.0, |n| n.share);
            *limit = limit.min(nearest + 2.0 * SHARE_ERROR);
        }
        false
    }

    /// Keeps a blocker if none is nearer; of those at one place that of the lowest slot and
    /// triangle.
    fn note(&mut self, body: &Body<'_>, triangle: u32, share: f64) {
        let triangle = body.mesh.original_triangle()[triangle as usize];
        let order = |b: &Blocker| (b.share, b.slot, b.triangle);
        if self.nearest.is_some_and(|n| order(&n) <= (share, body.slot, triangle)) {
            return;
        }
        let Some(handle) = self.scene.handle(body.slot) else { return };
        let point = (self.start + self.along * share).into();
        self.nearest = Some(Blocker { handle, slot: body.slot, triangle, share, point });
    }
}

impl Body<'_> {
    /// The segment in the space of the mesh; `None` where that is not known well enough.
    fn span(&self, search: &Search<'_>) -> Option<Span> {
        let inverse = self.linear.inverse();
        let norm = |m: &DMat3| m.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt();
        let condition = norm(&self.linear) * norm(&inverse);
        let is_known = condition < WORST_CONDITION;
        if !is_known {
            return None;
        }
        let reach = |m: &DMat3, v: DVec3| {
            m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z
        };
        let bounds = self.mesh.bounds();
        let size = DVec3::from(bounds.min.map(f64::from))
            .abs()
            .max(DVec3::from(bounds.max.map(f64::from)).abs());
        // Every rounding on the way there, and that of the vertices on their way here, is relative
        // to these terms; that of the inverse, by the condition too.
        let here =
            search.start.abs() + search.along.abs() + self.shift.abs() + reach(&self.linear, size);
        let slack = reach(&inverse, here) * (BOX_ROUNDING * condition);
        let (start, along) = (inverse * -self.shift, inverse * search.along);
        slack.is_finite().then(|| Span::new(start.into(), along.into(), slack.into()))
    }
}
