//! The nodes, animations, skins and morph targets of a file.

use std::collections::HashMap;

use cullet::bounds::Aabb;
use cullet::{BoundsOverride, Handle, Mesh, MeshData, MeshId, Transform};
use glam::DAffine3;

use super::PoseError;
use super::track::{Local, Track, WeightTrack};
use crate::Model;
use crate::deform::{JointBoxes, MorphBounds, MorphedJointBoxes, Morphs, Skin};

/// A node of the tree.
#[derive(Debug)]
pub(crate) struct RigNode {
    pub(crate) local: Local,
    pub(crate) parent: Option<u32>,
}

/// An animation.
#[derive(Debug)]
pub(crate) struct Clip {
    pub(crate) name: String,
    pub(crate) tracks: Vec<Track>,
    pub(crate) weights: Vec<WeightTrack>,
}

impl Clip {
    /// When its last key is.
    pub(crate) fn seconds(&self) -> f64 {
        let last = |times: &[f64]| times.last().copied().unwrap_or(0.0);
        let tracks = self.tracks.iter().map(|t| last(&t.times));
        tracks.chain(self.weights.iter().map(|t| last(&t.times))).fold(0.0, f64::max)
    }

    /// The time of its own at a time of the model: it starts again at its end.
    fn time(&self, seconds: f64) -> f64 {
        match self.seconds() {
            length if length > 0.0 => seconds.rem_euclid(length),
            _ => seconds,
        }
    }
}

/// A rigid instance that goes with a node.
#[derive(Debug)]
pub(crate) struct Follower {
    pub(crate) handle: Handle,
    pub(crate) node: u32,
    /// Where it is relative to the node; `None` where it is the node's own.
    pub(crate) inner: Option<DAffine3>,
}

/// A skin bound to a mesh.
#[derive(Debug)]
pub(crate) struct SkinRig {
    /// Four for each vertex; each exists.
    pub(crate) joints: Vec<[u16; 4]>,
    pub(crate) weights: Vec<[f32; 4]>,
    /// The node of each joint.
    pub(crate) nodes: Vec<u32>,
    pub(crate) inverse_binds: Vec<Transform>,
}

/// Bounds of a deformed mesh, prepared once.
#[derive(Debug)]
pub(crate) enum Bounds {
    Joints(JointBoxes),
    Morphs(MorphBounds),
    Both(MorphedJointBoxes),
}

impl Bounds {
    /// In the space that the joints are given in, or the mesh's.
    fn at(&self, joints: &[Transform], weights: &[f32]) -> Aabb {
        match self {
            Self::Joints(b) => b.bounds(joints, [0.0; 3]),
            Self::Morphs(b) => b.bounds(weights),
            Self::Both(b) => b.bounds(joints, weights, [0.0; 3]),
        }
    }
}

/// A node whose mesh deforms. The mesh is its own, so that it can be given other positions.
#[derive(Debug)]
pub(crate) struct Deformed {
    pub(crate) node: u32,
    pub(crate) mesh: MeshId,
    /// What draws it: one, or the many of `EXT_mesh_gpu_instancing`.
    pub(crate) instances: Vec<Follower>,
    /// The mesh as the file has it.
    pub(crate) data: MeshData,
    pub(crate) skin: Option<SkinRig>,
    /// For each morph target, the displacement of every vertex.
    pub(crate) targets: Vec<Vec<[f32; 3]>>,
    /// Of the targets, while no animation moves them.
    pub(crate) weights: Vec<f32>,
    pub(crate) bounds: Bounds,
}

/// What moves in a file, and how.
#[derive(Debug)]
pub(crate) struct Rig {
    pub(crate) nodes: Vec<RigNode>,
    /// The nodes, parents first.
    pub(crate) order: Vec<u32>,
    /// What stands above the roots.
    pub(crate) base: DAffine3,
    /// The animations that are played: no two move the same.
    pub(crate) clips: Vec<Clip>,
    pub(crate) followers: Vec<Follower>,
    pub(crate) deformed: Vec<Deformed>,
}

impl Rig {
    /// Whether anything moves or deforms.
    pub(crate) fn moves(&self) -> bool {
        !(self.followers.is_empty() && self.deformed.is_empty())
    }

    pub(super) fn pose(&self, model: &mut Model, seconds: f64) -> Result<(), PoseError> {
        let globals = self.globals(seconds);
        for f in &self.followers {
            model.scene.set_transform(f.handle, f.place(&globals))?;
        }
        let mut weights = HashMap::new();
        for clip in &self.clips {
            let time = clip.time(seconds);
            weights.extend(clip.weights.iter().map(|t| (t.node, t.at(time))));
        }
        for d in &self.deformed {
            let weights = weights.get(&d.node).unwrap_or(&d.weights);
            d.pose(model, &globals, weights, seconds)?;
        }
        Ok(())
    }

    /// Where every node is.
    fn globals(&self, seconds: f64) -> Vec<DAffine3> {
        let mut locals: Vec<Local> = self.nodes.iter().map(|n| n.local).collect();
        for clip in &self.clips {
            let time = clip.time(seconds);
            for track in &clip.tracks {
                let local = &mut locals[track.node as usize];
                *local = local.moved(track, time);
            }
        }
        let mut globals = vec![self.base; self.nodes.len()];
        for &n in &self.order {
            let parent = self.nodes[n as usize].parent;
            let above = parent.map_or(self.base, |p| globals[p as usize]);
            globals[n as usize] = above * locals[n as usize].affine();
        }
        globals
    }
}

impl Follower {
    fn place(&self, globals: &[DAffine3]) -> Transform {
        let global = globals[self.node as usize];
        transform(&self.inner.map_or(global, |inner| global * inner))
    }
}

impl Deformed {
    fn pose(
        &self,
        model: &mut Model,
        globals: &[DAffine3],
        weights: &[f32],
        seconds: f64,
    ) -> Result<(), PoseError> {
        let mut positions = Vec::new();
        if weights.iter().any(|w| *w != 0.0) && !self.targets.is_empty() {
            let targets: Vec<&[[f32; 3]]> = self.targets.iter().map(Vec::as_slice).collect();
            let morphs = Morphs { positions: &self.data.positions, targets: &targets };
            positions = morphs.pose(weights).unwrap_or_default();
        }
        if positions.is_empty() {
            positions.clone_from(&self.data.positions);
        }
        let mut joints = Vec::new();
        let mut place = None;
        if let Some(skin) = &self.skin {
            // A skin is placed by its joints alone. About the first of them, so that positions stay small.
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
        let bounds = self.bounds.at(&joints, weights);
        let mesh = Mesh::new(MeshData { positions, ..self.rest() }).map_err(|error| {
            let name = self.instances.first().map(|f| model.instance_name(f.handle).into_owned());
            PoseError::NotFinite { instance: name.unwrap_or_default(), seconds, error }
        })?;
        model.scene.edit_mesh(self.mesh, |old| *old = mesh);
        let origin = model.scene.origin();
        for f in &self.instances {
            let place = place.unwrap_or_else(|| f.place(globals));
            model.scene.set_transform(f.handle, place)?;
            let world = place.transform_box(&bounds, origin);
            model.scene.set_bounds(f.handle, BoundsOverride::World(world))?;
        }
        Ok(())
    }

    /// All of the mesh but its positions.
    fn rest(&self) -> MeshData {
        let d = &self.data;
        MeshData {
            positions: Vec::new(),
            indices: d.indices.clone(),
            parts: d.parts.clone(),
            polygons: d.polygons,
            deformable: true,
        }
    }
}

/// Rounds to what an instance holds.
pub(crate) fn transform(m: &DAffine3) -> Transform {
    let column = |c: glam::DVec3| [c.x as f32, c.y as f32, c.z as f32];
    let l = m.matrix3;
    Transform {
        linear: [column(l.x_axis), column(l.y_axis), column(l.z_axis)],
        translation: m.translation.into(),
    }
}
