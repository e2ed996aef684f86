//! Measures of a scene, found out once when it is loaded.

use cullet::bounds::Aabb;
use cullet_io::{Model, Warning};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::sides::KeptBacks;
use crate::state::Sides;

/// How much there is of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Meshes, each counted once.
    pub meshes: u64,
    /// Instances.
    pub instances: u64,
    /// Vertices of all instances.
    pub vertices: u64,
    /// Triangles of all instances.
    pub triangles: u64,
    /// Clusters of all instances.
    pub clusters: u64,
}

/// Measures of a scene, found once, in time that grows with its instances and with its largest
/// two-sided mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// How much there is of it.
    pub counts: Counts,
    /// The radius of the scene, but for a ground or sky that reaches far beyond all else.
    pub reach: f64,
    /// The middle of that.
    pub centre: [f64; 3],
    /// Half its extent along each axis.
    pub half: [f64; 3],
    /// The triangles that back-face culling cannot test, and why.
    pub kept_backs: KeptBacks,
}

impl Measures {
    /// Measures a model whose sides are as they were stored. O(instances), and [`KeptBacks::of`].
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let scene = &model.scene;
        let mut counts = Counts {
            meshes: scene.meshes().len() as u64,
            instances: u64::from(scene.instance_count()),
            triangles: scene.triangle_count(),
            ..Counts::default()
        };
        for slot in scene.slots() {
            let mesh = scene.mesh(slot);
            counts.vertices += mesh.positions().len() as u64;
            counts.clusters += mesh.clusters().len() as u64;
        }
        let usual = usual_extent(model);
        let half = DVec3::from(usual.half_extent()).length();
        let centre = DVec3::from(usual.center()) + DVec3::from(scene.origin());
        let sound = half > 0.0 && half.is_finite() && centre.is_finite();
        let (reach, centre) = if sound { (half, centre.into()) } else { (1.0, [0.0; 3]) };
        let half = if sound { usual.half_extent() } else { [1.0; 3] };
        let kept_backs = KeptBacks::of(model, Sides::Automatic);
        Self { counts, reach, centre, half, kept_backs }
    }
}

/// The box around all instances but those that are more than half as large as the whole: a ground,
/// a sky.
fn usual_extent(model: &Model) -> Aabb {
    let scene = &model.scene;
    let size = |b: &Aabb| DVec3::from(b.half_extent()).length();
    let extent = scene.extent();
    if extent.is_empty() {
        return Aabb::new([-1.0; 3], [1.0; 3]);
    }
    let limit = size(&extent) * 0.5;
    let boxes = scene.slots().map(|s| scene.bounds(s));
    let usual =
        boxes.filter(|b| b.is_finite() && size(b) < limit).fold(Aabb::EMPTY, |a, b| a.union(&b));
    if usual.is_empty() { extent } else { usual }
}

/// A warning for a model that moves, since the viewer does not show it moving.
#[must_use]
pub fn at_rest(model: &Model) -> Option<Warning> {
    let seconds = model.motion.as_ref()?.seconds();
    let what = match seconds {
        // Skins and morph targets that nothing moves.
        Some(0.0) => return None,
        Some(seconds) => format!("{seconds:.1} s of animation are not played"),
        None => "it moves, but not here".to_owned(),
    };
    let message = format!(
        "{what}: the scene is shown at rest, as it is stored; cullet report --time SECONDS takes another moment"
    );
    Some(Warning { item: "animation".to_owned(), message })
}
