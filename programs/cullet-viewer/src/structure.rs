//! The structures behind the answer, as lines: the hierarchy's boxes by what they answered, and the
//! cones of normals of clusters.

use cullet::bounds::{Boxes, Side};
use cullet::cull::frustum::batch::Planes;
use cullet::{Scene, Stage, View};
use cullet_draw::{Trace, palette};
use glam::DVec3;

use crate::lines::{Lines, tint, to_world};

/// Kept whole, as in the pictures of `cullet picture hierarchy`.
pub const WHOLE: [u8; 3] = palette::PROVED;
/// More boxes than these are a haze; the user is told.
pub const MOST_BOXES: usize = 8_000;

/// Counts of the test results of the boxes of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelTally {
    /// How many boxes the level has.
    pub boxes: usize,
    /// How many were tested and found outside, inside, straddling.
    pub answers: [usize; 3],
}

/// How many levels of nodes stand above the instances.
#[must_use]
pub fn level_count(scene: &Scene) -> u32 {
    scene.hierarchy().nodes().levels().len() as u32
}

/// Adds the boxes of one level (1 is just above the instances) that the walk for `view` tested,
/// coloured by the result. Nothing for a level that is not there. O(boxes of the scene).
pub fn hierarchy(scene: &Scene, view: &View, level: u32, lines: &mut Lines) -> LevelTally {
    let tree = scene.hierarchy();
    let boxes: Option<&Boxes> =
        (level > 0).then(|| tree.nodes().levels().get(level as usize - 1)).flatten();
    let Some(boxes) = boxes else { return LevelTally::default() };
    let planes = Planes::new(&view.frustum().relative_to(scene.origin()));
    let trace = Trace::new(&planes, tree.nodes(), tree.boxes());
    let tested = &trace.levels[level as usize];
    let mut tally = LevelTally { boxes: boxes.len(), ..LevelTally::default() };
    for (i, side) in tested.iter().enumerate() {
        let (answer, colour) = match side {
            None => continue,
            Some(Side::Outside) => (0, palette::reason_color(Some(Stage::Frustum))),
            Some(Side::Inside) => (1, WHOLE),
            Some(Side::Straddling) => (2, palette::UNSEEN),
        };
        tally.answers[answer] += 1;
        let b = boxes.get(i);
        let endless = b.min.iter().chain(&b.max).any(|v| v.abs() >= Boxes::LIMIT);
        if !endless && tally.answers.iter().sum::<usize>() <= MOST_BOXES {
            lines.edges(&b, scene.origin(), tint(colour, 220));
        }
    }
    tally
}

/// Adds, for each cluster of a slot's mesh, the cone that its normals lie in: from the middle of
/// its box. Red-violet ones face away from `view` and are dropped whole; a cluster whose normals
/// lie all around has none. Returns how many cones there are and how many clusters. O(triangles of
/// the mesh).
pub fn cones(scene: &Scene, view: &View, slot: u32, lines: &mut Lines) -> [usize; 2] {
    let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
    let flip = if transform.is_mirrored() { -1.0 } else { 1.0 };
    let [x, y, z, w] = view.eye();
    let eye = DVec3::new(x, y, z);
    let mut shown = 0;
    for cluster in mesh.clusters().iter().take(MOST_BOXES / 4) {
        let triangles: Vec<[DVec3; 3]> =
            cluster.triangles().map(|t| mesh.corners(t).map(|p| to_world(transform, p))).collect();
        let normals: Vec<DVec3> = triangles
            .iter()
            .filter_map(|[a, b, c]| ((*b - *a).cross(*c - *a) * flip).try_normalize())
            .collect();
        let corners = triangles.iter().flatten();
        let Some(axis) = normals.iter().sum::<DVec3>().try_normalize() else { continue };
        let widest = normals.iter().map(|n| n.dot(axis)).fold(1.0, f64::min);
        // Normals that span half a sphere or more have no cone.
        if widest <= 0.0 {
            continue;
        }
        let (low, high) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let middle = (low + high) * 0.5;
        // As the triangle's rule, for the cluster: all planes must have the eye behind them.
        let away = triangles.iter().all(|[a, b, c]| {
            let n = (*b - *a).cross(*c - *a) * flip;
            n.dot(*a * w - eye) >= 0.0
        });
        let colour =
            if away { palette::reason_color(Some(Stage::Backface)) } else { palette::SEEN };
        let length = (high - low).length() * 0.35;
        lines.cone(middle, axis, length, widest.clamp(-1.0, 1.0).acos(), tint(colour, 255));
        shown += 1;
    }
    [shown, mesh.clusters().len()]
}
