//! The nodes, animations, skins and morph targets of a file.

use cullet::bounds::Aabb;
use cullet::{Handle, MeshData, MeshId, Transform};
use glam::DAffine3;

use super::track::{Local, Track, WeightTrack};
use crate::deform::{JointBoxes, MorphBounds, MorphedJointBoxes};

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
    pub(crate) fn time(&self, seconds: f64) -> f64 {
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
    /// Four for each vertex, then perhaps four more for each; those that matter exist.
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
    pub(crate) fn at(&self, joints: &[Transform], weights: &[f32]) -> Aabb {
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
    /// The instances that draw it: one, or the many of `EXT_mesh_gpu_instancing`.
    pub(crate) instances: Vec<Follower>,
    /// The mesh as the file has it.
    pub(crate) data: MeshData,
    pub(crate) skin: Option<SkinRig>,
    /// For each morph target, the displacement of every vertex.
    pub(crate) targets: Vec<Vec<[f32; 3]>>,
    /// Weights of the targets, while no animation moves them.
    pub(crate) weights: Vec<f32>,
    pub(crate) bounds: Bounds,
}

/// Nodes, animations and deformed meshes of a file: all that moves.
#[derive(Debug)]
pub(crate) struct Rig {
    pub(crate) nodes: Vec<RigNode>,
    /// The nodes, parents first.
    pub(crate) order: Vec<u32>,
    /// The transform above the roots.
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

    /// Where every node is at a time; as the file stores them where there is none.
    pub(crate) fn globals(&self, seconds: Option<f64>) -> Vec<DAffine3> {
        let mut locals: Vec<Local> = self.nodes.iter().map(|n| n.local).collect();
        for (clip, seconds) in self.clips.iter().zip(seconds.into_iter().cycle()) {
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
    pub(crate) fn place(&self, globals: &[DAffine3]) -> Transform {
        let global = globals[self.node as usize];
        transform(&self.inner.map_or(global, |inner| global * inner))
    }
}

impl Deformed {
    /// All of the mesh but its positions.
    pub(crate) fn rest(&self) -> MeshData {
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
