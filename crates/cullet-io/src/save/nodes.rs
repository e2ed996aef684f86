//! The nodes of a GLB: those of the model's tree that lead to something drawn, or one for each
//! instance.

use std::collections::HashMap;

use cullet::Handle;
use glam::DMat4;
use serde_json::{Value, json};

use crate::Model;

/// Relative difference up to which a transform counts as its node's: a few roundings of f32.
const SAME: f64 = 1e-5;
/// The same of translations, which are kept in f64: a few roundings of that.
const SAME_PLACE: f64 = 1e-13;

/// An instance to be written.
struct Drawn {
    handle: Handle,
    mesh: usize,
    world: DMat4,
}

/// The nodes, and which of them are roots.
#[derive(Default)]
pub(super) struct Nodes {
    pub(super) nodes: Vec<Value>,
    pub(super) roots: Vec<usize>,
    /// The node of each instance, by the index of its handle.
    pub(super) node_of: HashMap<u32, usize>,
}

/// The nodes of the instances of some slots, whose transforms are finite; `number` is that of each
/// mesh in the file, `None` where it is not written.
pub(super) fn write(model: &Model, slots: &[u32], number: &[Option<usize>]) -> Nodes {
    let scene = &model.scene;
    let drawn = slots.iter().filter_map(|&slot| {
        let world = DMat4::from_cols_array(&scene.transform(slot).to_matrix());
        let mesh = number[scene.mesh_id(slot) as usize]?;
        Some(Drawn { handle: scene.handle(slot)?, mesh, world })
    });
    // Slots are sorted by place; handles are in the order of the file.
    let mut drawn: Vec<Drawn> = drawn.collect();
    drawn.sort_by_key(|d| d.handle.index);
    let mut out = Nodes::default();
    for one in place(model, drawn, &mut out) {
        let node = node(Some(&model.instance_name(one.handle)), Some(one.mesh), one.world);
        out.roots.push(out.nodes.len());
        out.node_of.insert(one.handle.index, out.nodes.len());
        out.nodes.push(node);
    }
    out
}

fn node(name: Option<&str>, mesh: Option<usize>, local: DMat4) -> Value {
    let mut node = json!({});
    if let Some(name) = name {
        node["name"] = json!(name);
    }
    if let Some(mesh) = mesh {
        node["mesh"] = json!(mesh);
    }
    if local != DMat4::IDENTITY {
        node["matrix"] = json!(local.to_cols_array());
    }
    node
}

/// Hangs the instances on the nodes of the model's tree; gives back those that have none.
fn place(model: &Model, drawn: Vec<Drawn>, out: &mut Nodes) -> Vec<Drawn> {
    let tree = &model.node_tree;
    let count = tree.len();
    let mut left = Vec::new();
    let mut own: Vec<Vec<Drawn>> = (0..count).map(|_| Vec::new()).collect();
    let mut used = vec![false; count];
    let parent = |n: usize| tree.parents.get(n).map(|&p| p as usize).filter(|&p| p < count);
    for one in drawn {
        let at = tree.node_of_instance.get(one.handle.index as usize).map(|&n| n as usize);
        let Some(at) = at.filter(|&n| n < count) else {
            left.push(one);
            continue;
        };
        own[at].push(one);
        let mut up = Some(at);
        while let Some(n) = up.filter(|&n| !used[n]) {
            used[n] = true;
            up = parent(n);
        }
    }
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut stack = Vec::new();
    for n in (0..count).filter(|&n| used[n]) {
        match parent(n) {
            Some(p) => children[p].push(n),
            None => stack.push((n, None, DMat4::IDENTITY)),
        }
    }
    stack.reverse();
    // Parents first, and not by recursion: a chain may be as long as the file.
    while let Some((n, above, parent)) = stack.pop() {
        let given = tree.locals.get(n).map(DMat4::from_cols_array).filter(DMat4::is_finite);
        let mut local = given.unwrap_or(DMat4::IDENTITY);
        let mut own = std::mem::take(&mut own[n]);
        let mut here = own.iter().position(|d| same(&d.world, &(parent * local)));
        // A node that draws one instance and no more is where that instance is, whatever moved it.
        if here.is_none() && own.len() == 1 && children[n].is_empty() {
            let moved = parent.inverse() * own[0].world;
            if moved.is_finite() {
                (local, here) = (moved, Some(0));
            }
        }
        let here = here.map(|i| own.remove(i));
        let name = tree
            .names
            .get(n)
            .filter(|n| !n.is_empty())
            .cloned()
            .or_else(|| here.as_ref().map(|d| model.instance_name(d.handle).into_owned()));
        let index = out.nodes.len();
        out.node_of.extend(here.as_ref().map(|d| (d.handle.index, index)));
        out.nodes.push(node(name.as_deref(), here.map(|d| d.mesh), local));
        match above {
            None => out.roots.push(index),
            Some(above) => adopt(&mut out.nodes, above, index),
        }
        let world = parent * local;
        let inverse = world.inverse();
        for one in own {
            let local = inverse * one.world;
            if !local.is_finite() {
                left.push(one);
                continue;
            }
            let child = out.nodes.len();
            out.node_of.insert(one.handle.index, child);
            out.nodes.push(node(Some(&model.instance_name(one.handle)), Some(one.mesh), local));
            adopt(&mut out.nodes, index, child);
        }
        stack.extend(children[n].iter().rev().map(|&c| (c, Some(index), world)));
    }
    // Instances below nodes that are their own ancestors, as no file's are.
    left.extend(own.into_iter().flatten());
    left
}

fn adopt(nodes: &mut [Value], parent: usize, child: usize) {
    match nodes[parent]["children"].as_array_mut() {
        Some(children) => children.push(json!(child)),
        None => nodes[parent]["children"] = json!([child]),
    }
}

/// Whether an instance, whose transform was rounded to f32, is where its node is.
fn same(instance: &DMat4, node: &DMat4) -> bool {
    let (a, b) = (instance.to_cols_array(), node.to_cols_array());
    let size = |m: &[f64]| m.iter().fold(0.0f64, |s, v| s.max(v.abs()));
    // The last column is a place, which is kept in f64; the rest turns and scales.
    let near = |range: std::ops::Range<usize>, share: f64| {
        let most = share * size(&a[range.clone()]);
        a[range.clone()].iter().zip(&b[range]).all(|(a, b)| (a - b).abs() <= most)
    };
    near(0..12, SAME) && near(12..15, SAME_PLACE)
}
