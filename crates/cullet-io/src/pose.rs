//! Models that move: posed at a time, with bounds that hold the pose.

use std::collections::HashMap;

use cullet::mesh::MeshError;
use cullet::{Mesh, MeshData, SceneError, Transform, scene::BoundsOverride};
use glam::DAffine3;
use thiserror::Error;

use crate::deform::{Morphs, Skin};
use crate::model::MotionKind;
use crate::motion::{Deformed, Rig, transform};
use crate::{Model, Warning};

/// Why a model cannot be posed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The time is no number of seconds.
    #[error("{0} is not a time: give finite seconds")]
    Time(f64),
    /// A vertex is nowhere.
    #[error(
        "{instance} at {seconds} s: {error}; a joint, a morph weight or a scale that moves it is not \
         finite or overflows"
    )]
    NotFinite {
        /// The name of the instance.
        instance: String,
        /// The time.
        seconds: f64,
        /// The vertex that is not finite.
        error: MeshError,
    },
    /// The built-in scene has no such time.
    #[error("{0}")]
    Made(String),
    /// The scene was changed since the model was loaded: an instance that moves was removed.
    #[error("the scene is no longer that of the model: {0}")]
    Changed(#[from] SceneError),
}

impl Model {
    /// Poses the model at a time: every instance that moves is put where it is then, and every mesh
    /// that deforms gets the positions that it has then, under bounds from its joints and morph
    /// targets (prepared at loading, so that they know nothing of those positions). Handles and
    /// slots stay; the nodes of the hierarchy are fitted again. A model without
    /// [`motion`](Self::motion) is left as it is.
    ///
    /// Of a glTF, every animation is played and starts again at its end, but not one that moves
    /// what an earlier one of the file moves. Skins blend in f64. What is both morphed and skinned
    /// is morphed first. The built-in `moving` is taken at that many seconds after the `t` of its
    /// text, to the millisecond.
    ///
    /// Costs O(nodes) for what is rigid; O(vertices × (joints + targets)), and a new
    /// [`Mesh`](cullet::Mesh), for what deforms. A built-in scene is made anew.
    ///
    /// # Errors
    /// If `seconds` is not finite, a deformed vertex is nowhere, a built-in scene has no such time,
    /// or an instance that moves was removed. The model may then be posed in part; posing it again
    /// at another time makes it whole.
    pub fn pose(&mut self, seconds: f64) -> Result<(), PoseError> {
        if !seconds.is_finite() {
            return Err(PoseError::Time(seconds));
        }
        // Put back whatever comes, so that an error leaves a model that can be posed again.
        let Some(motion) = self.motion.take() else { return Ok(()) };
        let posed = match &motion.kind {
            MotionKind::Rig(rig) => pose_rig(rig, self, seconds),
            MotionKind::Made(make) => {
                make(seconds).map_err(PoseError::Made).and_then(|now| take_pose(self, &now))
            }
        };
        self.motion = Some(motion);
        self.scene.refit();
        self.update_cells();
        posed
    }
}

/// Puts what moves with a node where it is then, and gives deformed meshes their positions and
/// bounds.
fn pose_rig(rig: &Rig, model: &mut Model, seconds: f64) -> Result<(), PoseError> {
    let globals = rig.globals(Some(seconds));
    for f in &rig.followers {
        model.scene.set_transform(f.handle, f.place(&globals))?;
    }
    let mut weights = HashMap::new();
    for clip in &rig.clips {
        let time = clip.time(seconds);
        weights.extend(clip.weights.iter().map(|t| (t.node, t.at(time))));
    }
    for d in &rig.deformed {
        let weights = weights.get(&d.node).unwrap_or(&d.weights);
        let posed = Posed::of(d, &globals, weights).map_err(|error| PoseError::NotFinite {
            instance: name(d, model),
            seconds,
            error,
        })?;
        model.scene.edit_mesh(d.mesh, |old| *old = posed.mesh);
        let (bounds, origin) = (d.bounds.at(&posed.joints, weights), model.scene.origin());
        for f in &d.instances {
            let place = posed.place.unwrap_or_else(|| f.place(&globals));
            model.scene.set_transform(f.handle, place)?;
            let world = place.transform_box(&bounds, origin);
            model.scene.set_bounds(f.handle, BoundsOverride::World(world))?;
        }
    }
    Ok(())
}

/// Shows a rig as its file stores it: no animation is played, skins follow the nodes as they stand,
/// and targets have their default weights. What has a vertex nowhere keeps its stored shape, has no
/// bounds, and is warned of.
pub(crate) fn stand(rig: &Rig, model: &mut Model) -> Result<Vec<Warning>, SceneError> {
    let mut warnings = Vec::new();
    if rig.deformed.is_empty() {
        return Ok(warnings);
    }
    let globals = rig.globals(None);
    for d in &rig.deformed {
        match Posed::of(d, &globals, &d.weights) {
            Ok(posed) => {
                model.scene.edit_mesh(d.mesh, |old| *old = posed.mesh);
                let Some(place) = posed.place else { continue };
                for f in &d.instances {
                    model.scene.set_transform(f.handle, place)?;
                }
            }
            Err(error) => {
                for f in &d.instances {
                    model.scene.set_bounds(f.handle, BoundsOverride::None)?;
                }
                let message = format!(
                    "keeps its stored shape, without bounds, so that it is always kept: as its \
                     joints and weights stand, {error}"
                );
                warnings.push(Warning { item: name(d, model), message });
            }
        }
    }
    Ok(warnings)
}

/// The name of the first instance of a mesh that deforms.
fn name(deformed: &Deformed, model: &Model) -> String {
    let first = deformed.instances.first();
    first.map(|f| model.instance_name(f.handle).into_owned()).unwrap_or_default()
}

/// A mesh with the positions that joints and weights give it.
struct Posed {
    mesh: Mesh,
    /// The joints of its skin, about `place`.
    joints: Vec<Transform>,
    /// Where it is, if it has a skin: joints alone place it, whatever the node says.
    place: Option<Transform>,
}

impl Posed {
    fn of(deformed: &Deformed, globals: &[DAffine3], weights: &[f32]) -> Result<Self, MeshError> {
        let mut positions = Vec::new();
        if weights.iter().any(|w| *w != 0.0) && !deformed.targets.is_empty() {
            let targets: Vec<&[[f32; 3]]> = deformed.targets.iter().map(Vec::as_slice).collect();
            let morphs = Morphs { positions: &deformed.data.positions, targets: &targets };
            positions = morphs.pose(weights).unwrap_or_default();
        }
        if positions.is_empty() {
            positions.clone_from(&deformed.data.positions);
        }
        let mut joints = Vec::new();
        let mut place = None;
        if let Some(skin) = &deformed.skin {
            // About the first joint, so that positions stay small.
            let centre = skin.nodes.first().map(|&n| globals[n as usize].translation);
            let centre = centre.filter(|c| c.is_finite()).unwrap_or_default();
            let local = |&n: &u32| {
                let g = globals[n as usize];
                transform(&DAffine3 { translation: g.translation - centre, ..g })
            };
            joints = skin.nodes.iter().map(local).collect();
            place = Some(Transform::from_translation(centre));
            let bound = Skin {
                positions: &positions,
                joints: &skin.joints,
                weights: &skin.weights,
                inverse_binds: &skin.inverse_binds,
            };
            debug_assert!(bound.pose(&joints).is_ok(), "joints were checked when loading");
            positions = bound.pose(&joints).unwrap_or(positions);
        }
        let mesh = Mesh::new(MeshData { positions, ..deformed.rest() })?;
        Ok(Self { mesh, joints, place })
    }
}

/// Takes the places, shapes and bounds of a model with the same meshes and instances.
fn take_pose(model: &mut Model, now: &Model) -> Result<(), PoseError> {
    let scene = &mut model.scene;
    scene.edit_meshes(|id, old| {
        let new = now.scene.meshes().get(id as usize);
        if let Some(new) = new.filter(|new| new.is_deformable()) {
            // Sides are the caller's to set, and stay.
            let two_sided = old.is_two_sided();
            *old = new.clone();
            old.set_two_sided(two_sided);
        }
    });
    for slot in now.scene.slots() {
        let Some(handle) = now.scene.handle(slot) else { continue };
        let at = scene.slot(handle)?;
        let transform = *now.scene.transform(slot);
        if *scene.transform(at) != transform {
            scene.set_transform(handle, transform)?;
        }
        if now.scene.mesh(slot).is_deformable() {
            scene.set_bounds(handle, BoundsOverride::World(now.scene.bounds(slot)))?;
        }
    }
    Ok(())
}
