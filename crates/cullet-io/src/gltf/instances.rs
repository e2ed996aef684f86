//! Placing meshes: one instance for each node that draws, or many by `EXT_mesh_gpu_instancing`.

use cullet::{Instance, InstanceFlags, Transform};
use glam::{DAffine3, DQuat, DVec3};

use super::accessor::Accessors;
use super::buffers::Buffers;
use super::meshes::Meshes;
use super::nodes::{Instancing, Nodes};
use super::notes::Notes;
use super::rig::{self, Plan};
use crate::motion::transform;
use crate::{ErrorKind, LoadOptions};

/// An instance to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    mesh: u32,
    transform: Transform,
}

impl Placement {
    /// Returns the instance as the scene takes it.
    pub(super) fn instance(&self) -> Instance {
        let mut instance = Instance::new(self.mesh, self.transform);
        instance.flags = InstanceFlags {
            always_visible: !self.transform.is_finite(),
            ..InstanceFlags::default()
        };
        instance
    }
}

impl Instancing {
    /// The accessors it names.
    pub(super) fn accessors(&self) -> impl Iterator<Item = usize> {
        [self.translation, self.rotation, self.scale, self.other].into_iter().flatten()
    }
}

/// Meshes and instances that the nodes of the scene place.
#[derive(Debug, Default)]
pub(super) struct PlacedScene {
    /// The file's meshes that are drawn, in the order of the file; after them one more of its mesh
    /// for each node that deforms and shares it.
    pub(super) meshes: Vec<u32>,
    /// Nodes that deform, each with its own of `meshes`.
    pub(super) deformed: Vec<(u32, u32)>,
    /// Instances that move or deform.
    pub(super) followers: Vec<rig::Placed>,
    /// The instances; their meshes are indices into `meshes`.
    pub(super) placements: Vec<Placement>,
    /// The name of each.
    pub(super) names: Vec<String>,
    /// The node of each.
    pub(super) nodes: Vec<u32>,
    /// Nodes with cameras, and where they stand.
    pub(super) cameras: Vec<(u32, DAffine3)>,
}

/// Walks the scene.
///
/// # Errors
/// If there are more instances than the options allow, or instance attributes are malformed.
pub(super) fn place(
    nodes: &Nodes,
    meshes: &Meshes,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    plan: &Plan,
    options: &LoadOptions,
    notes: &mut Notes,
) -> Result<PlacedScene, ErrorKind> {
    let mut placed = PlacedScene::default();
    let mut number_of = vec![u32::MAX; meshes.all.len()];
    let mut users = vec![0u32; meshes.all.len()];
    // Counted first: names and transforms cost more than what stands for them in the file.
    let mut total = 0u64;
    nodes.walk(&mut |index, node, _| {
        if let Some(mesh) = node.mesh.filter(|&m| meshes.all[m as usize].is_drawn()) {
            total = total.saturating_add(match &node.instancing {
                Some(i) => count(i, accessors, &user(index))? as u64,
                None => 1,
            });
            number_of[mesh as usize] = 0;
            users[mesh as usize] = users[mesh as usize].saturating_add(1);
        }
        Ok(())
    })?;
    if total > options.max_instances {
        return Err(ErrorKind::OverLimit {
            item: "instances".into(),
            count: total,
            limit: options.max_instances,
        });
    }
    // In the order of the file, so that a mesh keeps its number where all are drawn.
    for (m, number) in number_of.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
        *number = placed.meshes.len() as u32;
        placed.meshes.push(m as u32);
    }
    let undrawn = meshes.all.len() - placed.meshes.len();
    if undrawn > 0 {
        notes.push(
            "meshes",
            format!(
                "{undrawn} of {} are not loaded: no node of the scene draws triangles of theirs",
                meshes.all.len()
            ),
        );
    }
    placed.placements.reserve_exact(total as usize);
    placed.names.reserve_exact(total as usize);
    placed.nodes.reserve_exact(total as usize);
    nodes.walk(&mut |index, node, global| {
        if node.camera.is_some() {
            placed.cameras.push((index, *global));
        }
        let Some(mesh) = node.mesh.filter(|&m| meshes.all[m as usize].is_drawn()) else {
            return Ok(());
        };
        let name = nodes.name(index);
        let deforms = plan.deforms[index as usize];
        let skinned = plan.skinned[index as usize];
        if node.skin.is_some() && !skinned {
            let why = match (node.instancing.is_some(), meshes.all[mesh as usize].has_joints) {
                (true, _) => "it has instances too",
                (_, false) => "its mesh has no joints",
                (_, true) => "the skin is malformed",
            };
            notes.push(&name, format!("is skinned, but drawn where the node is, for {why}"));
        } else if !skinned && meshes.all[mesh as usize].has_joints {
            notes.push(&name, "has a mesh with joints but no skin");
        }
        let mut number = number_of[mesh as usize];
        if deforms {
            // Of its own, unless it has it for itself.
            if users[mesh as usize] > 1 {
                number = placed.meshes.len() as u32;
                placed.meshes.push(mesh);
            }
            placed.deformed.push((index, number));
        }
        let moved = plan.moved[index as usize] && !skinned;
        let mut add = |global: &DAffine3, name: String, inner: Option<DAffine3>| {
            let transform = transform(global);
            if !transform.is_finite() {
                notes.push(&name, "has a transform that is not finite: it is always kept");
            }
            if moved || deforms {
                let placement = placed.placements.len() as u32;
                placed.followers.push(rig::Placed { placement, node: index, inner });
            }
            placed.placements.push(Placement { mesh: number, transform });
            placed.names.push(name);
            placed.nodes.push(index);
        };
        match &node.instancing {
            None => add(global, name, None),
            Some(instancing) => {
                let locals = Locals::read(instancing, accessors, buffers, &user(index))?;
                for i in 0..locals.count {
                    let inner = locals.at(i);
                    add(&(*global * inner), format!("{name}[{i}]"), Some(inner));
                }
            }
        }
        Ok(())
    })?;
    Ok(placed)
}

fn user(node: u32) -> String {
    format!("node {node}, EXT_mesh_gpu_instancing")
}

/// How many instances the attributes make: they must agree.
fn count(i: &Instancing, accessors: &Accessors, user: &str) -> Result<usize, ErrorKind> {
    let mut count = None;
    for index in i.accessors() {
        let n = accessors.get(index, user)?.count;
        if count.is_some_and(|c| c != n) {
            let message =
                format!("accessor {index} has {n} elements, another {}", count.unwrap_or(0));
            return Err(ErrorKind::invalid(user, message));
        }
        count = Some(n);
    }
    count.ok_or_else(|| ErrorKind::invalid(user, "has no attributes"))
}

/// The transforms of instances relative to their node.
struct Locals {
    count: usize,
    translations: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    scales: Vec<[f32; 3]>,
}

impl Locals {
    fn read(
        i: &Instancing,
        accessors: &Accessors,
        buffers: &Buffers<'_>,
        user: &str,
    ) -> Result<Self, ErrorKind> {
        let vectors = |index: Option<usize>| match index {
            Some(index) => accessors.floats(index, buffers, user),
            None => Ok(Vec::new()),
        };
        Ok(Self {
            count: count(i, accessors, user)?,
            translations: vectors(i.translation)?,
            rotations: match i.rotation {
                Some(index) => accessors.floats(index, buffers, user)?,
                None => Vec::new(),
            },
            scales: vectors(i.scale)?,
        })
    }

    fn at(&self, i: usize) -> DAffine3 {
        let vector =
            |v: &[[f32; 3]], default| v.get(i).map_or(default, |v| DVec3::from(v.map(f64::from)));
        let rotation = self.rotations.get(i).map_or(DQuat::IDENTITY, |r| {
            let q = DQuat::from_array(r.map(f64::from));
            let length = q.length();
            // A zero turns nothing; NaN goes on, to be kept and noted.
            if length == 0.0 { DQuat::IDENTITY } else { q / length }
        });
        DAffine3::from_scale_rotation_translation(
            vector(&self.scales, DVec3::ONE),
            rotation,
            vector(&self.translations, DVec3::ZERO),
        )
    }
}
