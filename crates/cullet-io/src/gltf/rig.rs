//! Animations, skins and morph targets, made ready for posing.
//!
//! Nothing here stops a file from loading, but for the limits: what is malformed stays as it is
//! stored, and is noted.

use std::collections::HashMap;

use cullet::{Handle, MeshData, Transform};
use glam::DAffine3;

use super::accessor::{Accessors, Component};
use super::buffers::Buffers;
use super::json::{self, Root, SkinItem};
use super::meshes::{Binding, Meshes};
use super::nodes::{Node, Nodes};
use super::notes::Notes;
use crate::ErrorKind;
use crate::deform::{DeformError, JointBoxes, MorphBounds, MorphedJointBoxes, Morphs, Skin};
use crate::motion::track::Property;
use crate::motion::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig};

/// A skin, its references checked.
#[derive(Debug)]
struct SkinSource {
    nodes: Vec<u32>,
    inverse_binds: Vec<Transform>,
}

/// The nodes that move, and how; known before anything is placed.
#[derive(Debug)]
pub(super) struct Plan {
    /// All animations, for cameras.
    pub(super) clips: Vec<Clip>,
    /// For each animation whether it is played.
    played: Vec<bool>,
    skins: Vec<Option<SkinSource>>,
    /// For each node whether it, or one above it, is animated.
    pub(super) moved: Vec<bool>,
    /// For each node whether joints place it: not where its skin is malformed, its mesh has no
    /// joints, or it has instances.
    pub(super) skinned: Vec<bool>,
    /// For each node whether its mesh changes shape.
    pub(super) deforms: Vec<bool>,
    /// A pointer of `KHR_animation_pointer` that is not played, one that may move what is drawn
    /// before others.
    pub(super) pointer: Option<String>,
}

impl Plan {
    /// Reads animations and skins.
    ///
    /// # Errors
    /// If an animation is malformed, and the file has cameras that it might move.
    pub(super) fn read(
        root: &Root<'_>,
        nodes: &Nodes,
        meshes: &Meshes,
        accessors: &Accessors,
        buffers: &Buffers<'_>,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let targets = |n: usize| {
            let mesh = nodes.all.get(n)?.mesh;
            Some(mesh.map_or(0, |m| meshes.all[m as usize].targets))
        };
        let cameras = nodes.all.iter().any(|n| n.camera.is_some());
        let mut clips = Vec::new();
        let mut pointer = None;
        for i in 0..json::all(&root.animations).len() {
            match Clip::read(root, i, accessors, buffers, targets, &mut pointer, notes) {
                Ok(clip) => clips.push(clip),
                Err(e) if cameras => return Err(e),
                Err(e) => notes.push(format!("animation {i}"), format!("is left out: {e}")),
            }
        }
        let played = played(&clips, notes);
        let mut skins = Vec::new();
        for i in 0..json::all(&root.skins).len() {
            let skin = skin(root, i, nodes.all.len(), accessors, buffers);
            let skin =
                skin.map_err(|e| notes.push(format!("skin {i}"), format!("is left out: {e}")));
            skins.push(skin.ok());
        }
        let skinned = nodes.all.iter().map(|n| {
            let known = n.skin.is_some_and(|s| skins.get(s as usize).is_some_and(Option::is_some));
            let has_joints = n.mesh.is_some_and(|m| meshes.all[m as usize].has_joints);
            known && has_joints && n.instancing.is_none()
        });
        let skinned = skinned.collect();
        let (moved, deforms) = (Vec::new(), Vec::new());
        let mut plan = Self { clips, played, skins, moved, skinned, deforms, pointer };
        let mut moved = vec![false; nodes.all.len()];
        for clip in plan.clips() {
            clip.tracks.iter().for_each(|t| moved[t.node as usize] = true);
        }
        plan.moved = moved;
        for n in nodes.parents_first() {
            let above = nodes.all[n as usize].parent;
            plan.moved[n as usize] |= above.is_some_and(|p| plan.moved[p as usize]);
        }
        let mut morphing = vec![false; nodes.all.len()];
        for clip in plan.clips() {
            clip.weights.iter().for_each(|t| morphing[t.node as usize] = true);
        }
        let deforms = |((n, &morphing), &skinned): ((&Node, &bool), &bool)| {
            let mesh = n.mesh.map(|m| &meshes.all[m as usize]).filter(|mesh| mesh.is_drawn());
            mesh.is_some_and(|mesh| {
                let weights = n.weights.as_ref().unwrap_or(&mesh.weights);
                skinned || morphing || weights.iter().take(mesh.targets).any(|w| *w != 0.0)
            })
        };
        plan.deforms = nodes.all.iter().zip(&morphing).zip(&plan.skinned).map(deforms).collect();
        Ok(plan)
    }

    /// The animations that are played.
    fn clips(&self) -> impl Iterator<Item = &Clip> {
        self.clips.iter().zip(&self.played).filter(|(_, played)| **played).map(|(c, _)| c)
    }

    /// The skin and morph targets of a node for its decoded mesh.
    ///
    /// # Errors
    /// If a vertex is moved by a joint that is not there.
    pub(super) fn deformed(
        &self,
        (index, node): (u32, &Node),
        (number, data): (u32, &MeshData),
        weights: &[f32],
        binding: Binding,
    ) -> Result<Deformed, DeformError> {
        let Binding { joints, weights: shares, targets } = binding;
        let source = node.skin.filter(|_| self.skinned[index as usize]);
        let source = source.and_then(|s| self.skins.get(s as usize)?.as_ref());
        let skin = source.map(|s| SkinRig {
            joints,
            weights: shares,
            nodes: s.nodes.clone(),
            inverse_binds: s.inverse_binds.clone(),
        });
        let pulls: Vec<&[[f32; 3]]> = targets.iter().map(Vec::as_slice).collect();
        let positions = &data.positions;
        let bounds = match &skin {
            None => Bounds::Morphs(MorphBounds::new(&Morphs { positions, targets: &pulls })?),
            Some(s) => {
                let skin = Skin {
                    positions,
                    joints: &s.joints,
                    weights: &s.weights,
                    inverse_binds: &s.inverse_binds,
                };
                match pulls.is_empty() {
                    true => Bounds::Joints(JointBoxes::new(&skin)?),
                    false => Bounds::Both(MorphedJointBoxes::new(&skin, &pulls)?),
                }
            }
        };
        let mut weights = node.weights.as_deref().unwrap_or(weights).to_vec();
        weights.resize(targets.len(), 0.0);
        Ok(Deformed {
            node: index,
            mesh: number,
            instances: Vec::new(),
            data: data.clone(),
            skin,
            targets,
            weights,
            bounds,
        })
    }

    /// The rig; `handles` are those of the followers.
    pub(super) fn rig(
        self,
        nodes: &Nodes,
        followers: &[Placed],
        mut deformed: Vec<Deformed>,
        handles: &[Handle],
    ) -> Rig {
        let mut rigid = Vec::new();
        let mut place: HashMap<u32, u32> = HashMap::new();
        for (i, d) in (0..).zip(&deformed) {
            place.insert(d.node, i);
        }
        for (f, &handle) in followers.iter().zip(handles) {
            let follower = Follower { handle, node: f.node, inner: f.inner };
            let skinned = self.skinned[f.node as usize];
            match place.get(&f.node) {
                Some(&d) => deformed[d as usize].instances.push(follower),
                // A mesh that was to deform and cannot keeps its shape, but follows its node.
                None if skinned || !self.moved[f.node as usize] => {}
                None => rigid.push(follower),
            }
        }
        deformed.retain(|d| !d.instances.is_empty());
        let played = self.clips.into_iter().zip(self.played).filter(|(_, p)| *p).map(|(c, _)| c);
        Rig {
            nodes: nodes.all.iter().map(|n| RigNode { local: n.local, parent: n.parent }).collect(),
            order: nodes.parents_first(),
            base: nodes.base(),
            clips: played.collect(),
            followers: rigid,
            deformed,
        }
    }
}

/// An instance that goes with a node, by its place among all.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) placement: u32,
    pub(super) node: u32,
    pub(super) inner: Option<DAffine3>,
}

/// Returns for each animation whether it is played: all are that move nothing that an earlier one
/// moves. A file may hold the ways of one figure (walks, runs), of which one is enough, or one
/// animation for each of many instances.
fn played(clips: &[Clip], notes: &mut Notes) -> Vec<bool> {
    let mut taken: HashMap<(u32, Option<Property>), usize> = HashMap::new();
    let mut played = Vec::with_capacity(clips.len());
    for (i, clip) in clips.iter().enumerate() {
        let tracks = clip.tracks.iter().map(|t| (t.node, Some(t.property)));
        let weights = clip.weights.iter().map(|t| (t.node, None));
        let moves: Vec<(u32, Option<Property>)> = tracks.chain(weights).collect();
        let other = moves.iter().find_map(|m| taken.get(m));
        if let Some(&other) = other {
            let other = &clips[other].name;
            let message = format!("is not played: it moves what `{other}` moves");
            notes.push(format!("animation `{}`", clip.name), message);
        }
        played.push(other.is_none());
        if other.is_none() {
            taken.extend(moves.into_iter().map(|m| (m, i)));
        }
    }
    played
}

fn skin(
    root: &Root<'_>,
    index: usize,
    nodes: usize,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
) -> Result<SkinSource, ErrorKind> {
    let user = format!("skin {index}");
    let wrong = |message: String| ErrorKind::invalid(&user, message);
    let item: SkinItem = json::item(json::all(&root.skins)[index], "skin", index)?;
    let count = item.joints.len();
    if let Some(j) = item.joints.iter().find(|j| j.index() >= nodes) {
        return Err(wrong(format!("names node {} of {nodes}", j.0)));
    }
    let inverse_binds = match item.inverse_bind_matrices {
        None => vec![Transform::IDENTITY; count],
        Some(i) => {
            if accessors.get(i.index(), &user)?.component != Component::F32 {
                return Err(wrong(format!("its matrices, accessor {}, are not floats", i.0)));
            }
            let m: Vec<[f32; 16]> = accessors.floats(i.index(), buffers, &user)?;
            if m.len() < count {
                return Err(wrong(format!("has {count} joints but {} matrices", m.len())));
            }
            m.iter().take(count).map(|m| Transform::from_matrix(m.map(f64::from))).collect()
        }
    };
    let nodes = item.joints.iter().map(|j| j.index() as u32).collect();
    Ok(SkinSource { nodes, inverse_binds })
}
