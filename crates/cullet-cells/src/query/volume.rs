//! Volume to volume: whether one box is hidden from another, as a whole.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Occluder, Shape};
use cullet::{Handle, Scene};
use glam::DVec3;

use super::body::{Corners, blocks};
use super::segment::{Span, walk};

/// Settings of volume queries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumeOptions {
    /// Instances in none of these layers hide nothing. Default all.
    pub layers: u32,
    /// How often boxes may be halved, to find a proof for each half: where no occluder hides all of
    /// a box, several may together. Where one pair of halves has no proof the search ends, so that
    /// what is visible costs one test more for each; what is hidden costs up to twice as many. 0 to
    /// 16, and what is above counts as 16. Default 0.
    pub splits: u32,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        Self { layers: u32::MAX, splits: 0 }
    }
}

/// The occluder that hides one box from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HiddenBy {
    /// The instance of the occluder.
    pub handle: Handle,
    /// The slot of that.
    pub slot: u32,
    /// Number of the shape in its [occluder](cullet::prepared::Prepared::occluder).
    pub shape: u32,
}

/// Result of [`box_to_box`]: whether one box can be seen from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxSight {
    /// One of the boxes is empty: there is nothing to see, or nowhere to see it from.
    Empty,
    /// It is not proved that nothing is.
    Visible,
    /// No point of the one sees any point of the other: each segment between them passes through
    /// this occluder, or where boxes were halved, those of the first half do.
    Hidden(HiddenBy),
}

/// The most halvings that are done.
const MOST_SPLITS: u32 = 16;

/// Tests whether all of the box `to` is hidden from all of the box `from`, both relative to the
/// scene's origin.
///
/// [`Hidden`](BoxSight::Hidden) is a proof: every segment from a point of `from` to a point of `to`
/// passes through one convex occluder that neither box touches. The shapes are those that occlusion
/// culling has, made when the scene was [committed](Scene::commit): closed convex meshes, convex
/// closed regions of meshes, polygons and bodies that were baked or given. As there, instances do
/// not hide that are flagged `no_occlusion` or transparent, or are not [rigid](Scene::is_rigid),
/// and nobody stands inside of what is solid: a body says nothing of an eye within the boxes that
/// its occluder [seals](cullet::cull::occlusion::Occluder::sealed). A one-sided polygon hides from
/// its front alone, so the two boxes are not always exchangeable. Surfaces that are not convex, as
/// terrain, hide nothing here.
///
/// [`Visible`](BoxSight::Visible) is the absence of a proof, and what a box is whose numbers are
/// not finite; and all that rounding leaves in doubt.
///
/// Cost: what hides both boxes is met by the segment between their middles, so that only what lies
/// along that is looked at; a few hundred products for each candidate.
///
/// ```
/// use cullet::bounds::Aabb;
/// use cullet_cells::query::{BoxSight, VolumeOptions, box_to_box};
/// # use cullet::{Instance, Mesh, MeshData, Scene, Transform};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let positions = vec![[9.0, 9.0, 9.0], [-9.0, -9.0, 9.0], [-9.0, 9.0, -9.0], [9.0, -9.0, -9.0]];
/// # let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
/// # let rock = Mesh::new(MeshData { positions, indices, ..MeshData::default() })?;
/// let mut scene = Scene::new();
/// let rock = scene.add_mesh(rock);
/// let rock = scene.add(Instance::new(rock, Transform::IDENTITY))?;
/// scene.commit(&cullet::Culler::default());
///
/// let room = |x: f32| Aabb::new([x - 1.0, -1.0, -1.0], [x + 1.0, 1.0, 1.0]);
/// let options = VolumeOptions::default();
/// let BoxSight::Hidden(by) = box_to_box(&scene, &room(-20.0), &room(20.0), &options) else {
///     panic!("the rock is between the rooms");
/// };
/// assert_eq!(by.handle, rock);
/// assert_eq!(box_to_box(&scene, &room(20.0), &room(30.0), &options), BoxSight::Visible);
/// # Ok(())
/// # }
/// ```
#[must_use]
pub fn box_to_box(scene: &Scene, from: &Aabb, to: &Aabb, options: &VolumeOptions) -> BoxSight {
    if from.is_empty() || to.is_empty() {
        return BoxSight::Empty;
    }
    if !(from.is_finite() && to.is_finite()) {
        return BoxSight::Visible;
    }
    let boxes = [from, to].map(|b| [b.min, b.max].map(|p| DVec3::from(p.map(f64::from))));
    let query = Query { scene, layers: options.layers };
    query.prove(boxes, options.splits.min(MOST_SPLITS)).map_or(BoxSight::Visible, BoxSight::Hidden)
}

struct Query<'a> {
    scene: &'a Scene,
    layers: u32,
}

impl Query<'_> {
    /// Returns what hides one box from the other, or `None` without a proof. Where no single
    /// occluder is found and the boxes do not touch, it halves the box with the longest edge, up to
    /// `splits` times, and seeks a proof for each half. Then it returns what hides the first half.
    fn prove(&self, boxes: [[DVec3; 2]; 2], splits: u32) -> Option<HiddenBy> {
        if let Some(by) = self.prove_whole(boxes) {
            return Some(by);
        }
        // Boxes that touch see each other there, however they are halved.
        let [a, b] = boxes;
        let apart = a[0].cmpgt(b[1]).any() || b[0].cmpgt(a[1]).any();
        if splits == 0 || !apart {
            return None;
        }
        // The longest edge of both is halved.
        let longest = |[min, max]: [DVec3; 2]| (max - min).max_element();
        let which = usize::from(longest(b) > longest(a));
        let [min, max] = boxes[which];
        let size = max - min;
        let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        let middle = (min[axis] + max[axis]) * 0.5;
        let [mut low, mut high] = [boxes; 2];
        low[which][1][axis] = middle;
        high[which][0][axis] = middle;
        let by = self.prove(low, splits - 1)?;
        self.prove(high, splits - 1)?;
        Some(by)
    }

    /// Returns the occluder that hides all of one box from all of the other, or `None` without a
    /// proof.
    fn prove_whole(&self, boxes: [[DVec3; 2]; 2]) -> Option<HiddenBy> {
        let corners = boxes.map(|[min, max]| Corners::of(min, max));
        // An occluder that all segments pass is passed by that between the middles.
        let [from, to] = boxes.map(|[min, max]| (min + max) * 0.5);
        let slack = (from.abs() + to.abs()) * (16.0 * f64::EPSILON);
        let span = Span::new(from.into(), (to - from).into(), slack.into());
        let (hierarchy, mut found) = (self.scene.hierarchy(), None);
        walk((hierarchy.nodes(), hierarchy.boxes()), &span, &mut 1.0, &mut |slot, _| {
            found = self.hides(slot as u32, boxes[0], [&corners[0], &corners[1]]);
            found.is_some()
        });
        found
    }

    /// The shape of an instance that hides one box from the other.
    fn hides(&self, slot: u32, eyes: [DVec3; 2], boxes: [&Corners; 2]) -> Option<HiddenBy> {
        let (scene, flags) = (self.scene, self.scene.flags(slot));
        let hides = scene.layers(slot) & self.layers != 0
            && !flags.no_occlusion
            && !flags.transparent
            && scene.is_rigid(slot);
        let occluder = if hides { scene.prepared_of(slot).occluder() } else { None }?;
        let within = self.is_within(slot, occluder, eyes);
        for (shape, convex) in occluder.shapes().iter().enumerate() {
            let Shape::Convex(convex) = convex else { continue };
            // Those that are only for eyes within would have to be proved for all of them.
            if occluder.is_for(shape, false)
                && (!within || occluder.is_for(shape, true))
                && blocks(convex, scene.transform(slot), scene.origin(), boxes)
            {
                let handle = scene.handle(slot)?;
                return Some(HiddenBy { handle, slot, shape: shape as u32 });
            }
        }
        None
    }

    /// Whether an eye may be within what the occluder of an instance seals off.
    fn is_within(&self, slot: u32, occluder: &Occluder, [min, max]: [DVec3; 2]) -> bool {
        let transform = self.scene.transform(slot);
        let mut sealed =
            occluder.sealed().iter().map(|b| transform.transform_box(b, self.scene.origin()));
        sealed.any(|b| {
            let apart = |a: usize| min[a] > f64::from(b.max[a]) || max[a] < f64::from(b.min[a]);
            // A NaN is no proof that they are apart.
            !(0..3).any(apart)
        })
    }
}
