//! A light as a kind of view: whose shadows on what a camera sees are wanted.

use alloc::vec::Vec;

use crate::bounds::{Aabb, Side};
use crate::cull::frustum::batch::Planes;
use crate::cull::shadow::Light;
use crate::scene::{Scene, SceneError};
use crate::view::{View, ViewError};
use crate::visible::Visible;

/// A light and the camera whose picture its shadows fall into: what [`Culler::cull_shadow`] takes
/// for a view. Its result is what the light's shadow map must show: an instance matters only if it
/// stands between the light and something that the camera sees.
///
/// ```
/// use cullet::cull::shadow::Light;
/// use cullet::{Culler, Instance, Mesh, MeshData, Scene, ShadowView, Transform, View, ViewState, Visible};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let positions = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
/// # let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
/// # let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() })?;
/// let mut scene = Scene::new();
/// let mesh = scene.add_mesh(mesh);
/// let mut add = |place| scene.add(Instance::new(mesh, Transform::from_translation(place)));
/// let seen = add([0.0, 0.0, -8.0])?;
/// let tower = add([0.0, 9.0, -8.0])?; // above the picture, between the sun and what is seen
/// let behind = add([0.0, 9.0, 8.0])?; // behind the camera
///
/// let (culler, mut visible) = (Culler::default().with_reasons(true), Visible::default());
/// let camera = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.8, 0.1, 100.0, [640, 480])?;
/// culler.cull_one(&scene, &camera, &mut ViewState::default(), &mut visible);
/// assert_eq!(visible.instance_count, 1);
///
/// let sun = Light::Directional { direction: [0.0, -1.0, 0.0] };
/// let shadows = ShadowView::new(camera, sun).receiving(&scene, &visible)?;
/// let mut casters = Visible::default();
/// culler.cull_shadow(&scene, &shadows, &mut ViewState::default(), &mut casters);
/// assert_eq!(casters.instance_count, 2);
/// let reason = casters.reasons[scene.slot(behind)? as usize].and_then(|r| r.caster());
/// assert_eq!(reason.map(|r| r.name()), Some("outside-sweep"));
/// # assert!(casters.reasons[scene.slot(seen)? as usize].is_none());
/// # assert!(casters.reasons[scene.slot(tower)? as usize].is_none());
/// # Ok(())
/// # }
/// ```
///
/// [`Culler::cull_shadow`]: crate::Culler::cull_shadow
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowView {
    /// Whose picture the shadows fall into.
    pub camera: View,
    /// The light, in world space, as the camera is.
    pub light: Light,
    /// A box around all on which the camera can see a shadow, relative to the scene's origin. The
    /// tighter it is, the more is dropped. `None`, as a box that is not finite, is any place in the
    /// camera's frustum; an empty one is none at all, so that every caster is dropped.
    pub receivers: Option<Aabb>,
    /// Shadows may be wrong by so much to every side, in world units: for edges that are blurred,
    /// or maps that are read around a point. One that is not above zero counts as zero; an infinite
    /// one keeps all that the map shows.
    pub margin_world: f64,
    /// The view that the shadow map is drawn with, if it is known yet. What is outside of it is
    /// dropped, also before its near plane: where depth is clamped when drawing, say here a view
    /// that begins at the light. The light then stands where the map's eye is, and only its range
    /// and cone are its own. Layers, culled faces, sizes in pixels and what is hidden are those of
    /// this view: a caster that is hidden from the light shades nothing of its own.
    ///
    /// Without one, layers are the camera's, and the stages that must look from somewhere (detail,
    /// occlusion, back faces) do not run: the answer says what a map is to be fitted around.
    pub map: Option<View>,
}

impl ShadowView {
    /// The shadows of a light in the picture of a camera, on any place that it shows; sharp, and
    /// with no map yet.
    #[must_use]
    pub fn new(camera: View, light: Light) -> Self {
        Self { camera, light, receivers: None, margin_world: 0.0, map: None }
    }

    /// Returns the shadows of cascaded shadow maps: one view for each two distances of `splits`,
    /// which ascend, with the [slice](View::slice) of the camera between them in place of the
    /// camera.
    ///
    /// # Errors
    /// The errors of [`View::slice`].
    pub fn cascades(camera: &View, light: Light, splits: &[f64]) -> Result<Vec<Self>, ViewError> {
        Ok(camera.slices(splits)?.into_iter().map(|slice| Self::new(slice, light)).collect())
    }

    /// Returns these shadows received by nothing but what the camera was found to see: `visible` is
    /// the answer of its cull, or of that of the view that a cascade is a slice of. O(what is
    /// visible). A receiver without bounds stands anywhere in the camera's frustum.
    ///
    /// # Errors
    /// [`SceneError::Stale`] if `visible` is not of the scene as it is.
    pub fn receiving(self, scene: &Scene, visible: &Visible) -> Result<Self, SceneError> {
        visible.check(scene)?;
        let frustum = self.camera.frustum().relative_to(scene.origin());
        let planes = Planes::new(&frustum);
        let is_seen =
            |slot: &u32| planes.classify_stored(scene.boxes(), *slot as usize) != Side::Outside;
        let bounds = visible.slots().filter(is_seen).map(|slot| scene.bounds(slot));
        let all = bounds.fold(Aabb::EMPTY, |all, b| all.union(&b));
        let receivers = match frustum.bounds() {
            Some(within) => all.intersection(&within),
            None => all,
        };
        Ok(Self { receivers: Some(receivers), ..self })
    }

    /// The view that is drawn, or that of the camera while there is none.
    #[cfg(feature = "shadows")]
    pub(super) fn drawn(&self) -> &View {
        self.map.as_ref().unwrap_or(&self.camera)
    }
}
