//! The node tree: read, checked to be a tree, and walked from the roots of the scene.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::json::{self, NodeItem, Root, SceneItem};
use super::notes::Notes;
use super::uri::shorten;
use crate::motion::track::Local;
use crate::{ErrorKind, NodeTree, Up};

/// How far from 1 the length of a rotation may be: what the reference validator allows for
/// rounding.
const ROTATION_TOLERANCE: f64 = 0.007_69;

/// The attributes of `EXT_mesh_gpu_instancing`, by accessor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Instancing {
    pub(super) translation: Option<usize>,
    pub(super) rotation: Option<usize>,
    pub(super) scale: Option<usize>,
    /// An attribute that has the count of instances when none of the three is there.
    pub(super) other: Option<usize>,
}

/// A node.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) local: Local,
    pub(super) children: Vec<u32>,
    pub(super) parent: Option<u32>,
    pub(super) mesh: Option<u32>,
    pub(super) camera: Option<u32>,
    /// The skin of its mesh; `None` without a mesh.
    pub(super) skin: Option<u32>,
    /// Morph weights in place of its mesh's.
    pub(super) weights: Option<Vec<f32>>,
    pub(super) instancing: Option<Box<Instancing>>,
    pub(super) hidden: bool,
}

/// The tree, or forest.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) all: Vec<Node>,
    roots: Vec<u32>,
    /// See [`base`].
    base: DAffine3,
}

/// Room for the arrays that a node's indices lead to.
pub(super) struct Counts {
    pub(super) meshes: usize,
    pub(super) cameras: usize,
    pub(super) skins: usize,
}

impl Nodes {
    /// Reads all nodes and the scene to show: the file's choice, else its first, else every root.
    ///
    /// # Errors
    /// If an index leads nowhere, a node has two parents or is its own ancestor, or its transform
    /// is ambiguous.
    pub(super) fn read(
        root: &Root<'_>,
        counts: &Counts,
        base: DAffine3,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let raw = json::all(&root.nodes);
        let mut all = Vec::with_capacity(raw.len());
        for (i, raw) in raw.iter().enumerate() {
            all.push(node(json::item(*raw, "node", i)?, i, counts, notes)?);
        }
        adopt(&mut all)?;
        check_reach(&all)?;
        let roots = scene_roots(root, &all)?;
        Ok(Self { all, roots, base })
    }

    /// The name of a node, for messages.
    pub(super) fn name(&self, index: u32) -> String {
        match &self.all[index as usize].name {
            Some(name) if !name.is_empty() => shorten(name),
            _ => format!("node {index}"),
        }
    }

    /// Visits the visible nodes of the scene, parents first and in the order of the file, each with
    /// its transform to the scene.
    ///
    /// # Errors
    /// Whatever `visit` returns.
    pub(super) fn walk(
        &self,
        visit: &mut dyn FnMut(u32, &Node, &DAffine3) -> Result<(), ErrorKind>,
    ) -> Result<(), ErrorKind> {
        // Not by recursion: a chain of a million nodes is a small file.
        let mut stack: Vec<(u32, DAffine3)> =
            self.roots.iter().rev().map(|&r| (r, self.base)).collect();
        while let Some((index, parent)) = stack.pop() {
            let node = &self.all[index as usize];
            if node.hidden {
                continue;
            }
            let global = parent * node.local.affine();
            visit(index, node, &global)?;
            stack.extend(node.children.iter().rev().map(|&c| (c, global)));
        }
        Ok(())
    }

    /// A node and its ancestors, root first.
    pub(super) fn chain(&self, index: u32) -> Vec<u32> {
        let mut chain: Vec<u32> =
            std::iter::successors(Some(index), |&i| self.all[i as usize].parent).collect();
        chain.reverse();
        chain
    }

    /// The tree as a model keeps it. `node_of_instance` is the node of each instance; `details` is
    /// whether the nodes' places are kept.
    pub(super) fn tree(&self, node_of_instance: Vec<u32>, details: bool) -> NodeTree {
        let local = |n: &Node| {
            let local = n.local.affine();
            let placed = if n.parent.is_none() { self.base * local } else { local };
            DMat4::from(placed).to_cols_array()
        };
        NodeTree {
            parents: self.all.iter().map(|n| n.parent.unwrap_or(NodeTree::NONE)).collect(),
            names: (self.all.iter())
                .map(|n| n.name.as_deref().map_or_else(String::new, shorten))
                .collect(),
            locals: if details { self.all.iter().map(local).collect() } else { Vec::new() },
            node_of_instance,
        }
    }

    /// Every node, drawn or not, each after its parent.
    pub(super) fn parents_first(&self) -> Vec<u32> {
        let is_root = |&i: &u32| self.all[i as usize].parent.is_none();
        let mut order: Vec<u32> = (0..self.all.len() as u32).filter(is_root).collect();
        let mut at = 0;
        while let Some(&i) = order.get(at) {
            order.extend(&self.all[i as usize].children);
            at += 1;
        }
        order
    }

    /// The transform above the roots.
    pub(super) fn base(&self) -> DAffine3 {
        self.base
    }
}

/// The transform above the roots: by the file's centre, then from its up axis to the scene's, where
/// (x, y, z) of a file with Z up becomes (x, z, −y).
pub(super) fn base(up: Up, centre: [f64; 3]) -> DAffine3 {
    let turn = match up {
        Up::Y => DMat3::IDENTITY,
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    };
    DAffine3 { matrix3: turn, translation: turn * DVec3::from(centre) }
}

fn node(
    item: NodeItem<'_>,
    index: usize,
    counts: &Counts,
    notes: &mut Notes,
) -> Result<Node, ErrorKind> {
    let wrong = |message: String| ErrorKind::invalid(format!("node {index}"), message);
    let link = |to: Option<json::Index>, what: &str, count: usize| match to {
        Some(i) if i.index() >= count => Err(wrong(format!("names {what} {} of {count}", i.0))),
        to => Ok(to.map(|i| i.index() as u32)),
    };
    let mesh = link(item.mesh, "mesh", counts.meshes)?;
    let camera = link(item.camera, "camera", counts.cameras)?;
    let skin = link(item.skin, "skin", counts.skins)?;
    let parts = item.translation.is_some() || item.rotation.is_some() || item.scale.is_some();
    if item.matrix.is_some() && parts {
        return Err(wrong(
            "has both a matrix and translation, rotation or scale: which of them holds?".into(),
        ));
    }
    let local = match item.matrix {
        Some(m) => matrix(&m).map_err(wrong)?,
        None => {
            let rotation = item.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
            Local::Parts {
                translation: item.translation.map_or(DVec3::ZERO, DVec3::from),
                rotation: unit(rotation).map_err(wrong)?,
                scale: item.scale.map_or(DVec3::ONE, DVec3::from),
            }
        }
    };
    if !local.affine().is_finite() {
        notes.push(format!("node {index}"), "its transform is not finite");
    }
    let instancing = match &item.instancing {
        Some(e) => {
            let of = |name: &str| e.attributes.get(name).map(json::Integer::index);
            Some(Box::new(Instancing {
                translation: of("TRANSLATION"),
                rotation: of("ROTATION"),
                scale: of("SCALE"),
                other: e.attributes.0.first().map(|(_, i)| i.index()),
            }))
        }
        None => None,
    };
    let hidden = item.visibility.is_some_and(|v| v.visible == Some(false));
    if hidden {
        notes.push(format!("node {index}"), "is hidden by KHR_node_visibility, with all below it");
    }
    let children = item.children.iter().map(|c| u32::try_from(c.0).unwrap_or(u32::MAX)).collect();
    Ok(Node {
        name: item.name.map(std::borrow::Cow::into_owned),
        local,
        children,
        parent: None,
        mesh,
        camera,
        skin: skin.filter(|_| mesh.is_some()),
        weights: item.weights.map(|w| w.iter().map(|&w| w as f32).collect()),
        instancing,
        hidden,
    })
}

/// A rotation of unit length, give or take rounding.
fn unit(rotation: DQuat) -> Result<DQuat, String> {
    let length = rotation.length();
    if !length.is_finite() {
        return Ok(rotation);
    }
    if (length - 1.0).abs() > ROTATION_TOLERANCE {
        return Err(format!("the length of its rotation is {length}; it must be 1"));
    }
    Ok(rotation / length)
}

fn matrix(m: &[f64; 16]) -> Result<Local, String> {
    let last = [m[3], m[7], m[11], m[15]];
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the last row of its matrix is {last:?}; it must be 0, 0, 0, 1"));
    }
    let column = |c: usize| DVec3::new(m[c * 4], m[c * 4 + 1], m[c * 4 + 2]);
    let linear = DMat3::from_cols(column(0), column(1), column(2));
    Ok(Local::Matrix(DAffine3 { matrix3: linear, translation: column(3) }))
}

/// Tells each node its parent.
fn adopt(all: &mut [Node]) -> Result<(), ErrorKind> {
    for i in 0..all.len() {
        for at in 0..all[i].children.len() {
            let child = all[i].children[at] as usize;
            let wrong = |message| Err(ErrorKind::invalid(format!("node {i}"), message));
            let count = all.len();
            let Some(node) = all.get_mut(child) else {
                return wrong(format!("has child {child} of {count} nodes"));
            };
            if let Some(other) = node.parent {
                return wrong(format!(
                    "has child {child}, which is a child of node {other} already"
                ));
            }
            node.parent = Some(i as u32);
        }
    }
    Ok(())
}

/// Checks that every node is reached from a root. As each has one parent, a node that is not
/// reached lies on a circle.
fn check_reach(all: &[Node]) -> Result<(), ErrorKind> {
    let mut reached = vec![false; all.len()];
    let mut stack: Vec<u32> =
        (0..all.len() as u32).filter(|&i| all[i as usize].parent.is_none()).collect();
    while let Some(i) = stack.pop() {
        reached[i as usize] = true;
        stack.extend(&all[i as usize].children);
    }
    match reached.iter().position(|r| !r) {
        None => Ok(()),
        Some(i) => Err(ErrorKind::invalid(
            format!("node {i}"),
            "is, or is below, a node that is its own ancestor: the nodes form a loop",
        )),
    }
}

fn scene_roots(root: &Root<'_>, all: &[Node]) -> Result<Vec<u32>, ErrorKind> {
    let mut scenes: Vec<SceneItem> = Vec::new();
    for (s, json) in json::all(&root.scenes).iter().enumerate() {
        let scene: SceneItem = json::item(*json, "scene", s)?;
        let wrong = |message| Err(ErrorKind::invalid(format!("scene {s}"), message));
        let mut sorted: Vec<u64> = scene.nodes.iter().map(|n| n.0).collect();
        sorted.sort_unstable();
        for &n in &sorted {
            match usize::try_from(n).ok().and_then(|n| all.get(n)) {
                None => return wrong(format!("names node {n} of {}", all.len())),
                Some(Node { parent: Some(p), .. }) => {
                    return wrong(format!(
                        "names node {n}, which is not a root but a child of node {p}"
                    ));
                }
                Some(_) => {}
            }
        }
        if let Some(w) = sorted.windows(2).find(|w| w[0] == w[1]) {
            return wrong(format!("names node {} twice", w[0]));
        }
        scenes.push(scene);
    }
    let chosen = root.scene.map_or(0, json::Integer::index);
    match scenes.get(chosen) {
        Some(scene) => Ok(scene.nodes.iter().map(|n| n.index() as u32).collect()),
        None if root.scene.is_none() => {
            Ok((0..all.len() as u32).filter(|&i| all[i as usize].parent.is_none()).collect())
        }
        None => {
            Err(ErrorKind::invalid("scene", format!("names scene {chosen} of {}", scenes.len())))
        }
    }
}
