//! A scene as a tree of boxes, in which large instances stand high up and small ones far down.

use std::collections::BTreeMap;

use cullet::Scene;
use glam::DVec3;

use super::options::WriteTiles;
use cullet_io::{world, world_box};

/// Cuts end here: a box is a millionth of the whole.
const DEEPEST: u32 = 20;
/// An instance stays with the box that it is a larger part of than this, by their longest sides: it
/// is seen from as far as the whole is.
const LARGE: f64 = 0.25;

/// An instance that draws something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) slot: u32,
    low: DVec3,
    high: DVec3,
    triangles: u64,
}

impl Item {
    /// An instance of a scene; `None` where it has no triangles or no place.
    pub(super) fn of(scene: &Scene, slot: u32) -> Option<Self> {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let triangles = mesh.triangle_count().into();
        if triangles == 0 || !transform.is_finite() {
            return None;
        }
        let [mut low, mut high] = match world_box(scene, slot) {
            Some(corners) => corners.map(DVec3::from),
            // None of its triangles has an area.
            None => {
                let points = mesh.positions().iter().map(|&p| DVec3::from(world(transform, p)));
                points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
                    [low.min(p), high.max(p)]
                })
            }
        };
        // Its levels of detail may reach beyond the mesh.
        let bounds = scene.bounds(slot);
        if !scene.levels(scene.mesh_id(slot)).is_empty() && bounds.is_finite() {
            let at = |v: [f32; 3]| DVec3::from(v.map(f64::from)) + DVec3::from(scene.origin());
            (low, high) = (low.min(at(bounds.min)), high.max(at(bounds.max)));
        }
        Some(Self { slot, low, high, triangles })
    }

    /// Low and high corner of everything that it draws.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        [self.low, self.high]
    }

    fn middle(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    fn diagonal(&self) -> f64 {
        (self.high - self.low).length()
    }
}

/// A box of the tree.
#[derive(Debug)]
pub(super) struct Node {
    /// Around all that is in it and below it.
    pub(super) low: DVec3,
    pub(super) high: DVec3,
    /// Items that the tile shows itself; none for an inner tile that others replace.
    pub(super) own: Vec<Item>,
    pub(super) children: Vec<Self>,
    /// The largest diagonal of what is not shown while nothing below it is.
    pub(super) error: f64,
}

impl Node {
    /// Without tiles below.
    fn leaf(own: Vec<Item>) -> Self {
        let low = own.iter().map(|i| i.low).reduce(DVec3::min).unwrap_or_default();
        let high = own.iter().map(|i| i.high).reduce(DVec3::max).unwrap_or_default();
        Self { low, high, own, children: Vec::new(), error: 0.0 }
    }

    pub(super) fn diagonal(&self) -> f64 {
        let diagonal = (self.high - self.low).length();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }

    /// Adds the slots of all instances in it and below it. As deep as [`DEEPEST`].
    pub(super) fn add_slots(&self, slots: &mut Vec<u32>) {
        slots.extend(self.own.iter().map(|item| item.slot));
        self.children.iter().for_each(|child| child.add_slots(slots));
    }
}

/// The tree of some instances. Where tiles `replace` those above them, an inner one has no
/// instances: those that are large beside it are a tile of their own, the first below it.
pub(super) fn cut(items: Vec<Item>, options: &WriteTiles, replace: bool) -> Node {
    node(items, options, replace, 0)
}

/// A node of some items. As deep as [`DEEPEST`].
fn node(items: Vec<Item>, options: &WriteTiles, replace: bool, depth: u32) -> Node {
    let triangles: u64 = items.iter().map(|i| i.triangles).sum();
    let is_small = triangles <= options.triangles && items.len() <= options.instances as usize;
    if is_small || depth == DEEPEST || items.len() == 1 {
        return Node::leaf(items);
    }
    let Node { low, high, own: items, .. } = Node::leaf(items);
    let size = high - low;
    let longest = size.max_element();
    let middle = (low + high) * 0.5;
    let (own, small): (Vec<Item>, Vec<Item>) =
        items.into_iter().partition(|i| (i.high - i.low).max_element() > longest * LARGE);
    // What is large alone is not cut further.
    if small.is_empty() {
        return Node::leaf(own);
    }
    // Flat boxes are cut along their long sides alone.
    let mut parts: BTreeMap<u8, Vec<Item>> = BTreeMap::new();
    for item in small {
        let at = item.middle();
        let side = |a: usize| u8::from(size[a] > longest * 0.5 && at[a] >= middle[a]) << a;
        parts.entry(side(0) | side(1) | side(2)).or_default().push(item);
    }
    let mut error = largest(parts.values().flatten());
    let mut children: Vec<Node> =
        parts.into_values().map(|part| node(part, options, replace, depth + 1)).collect();
    if !replace {
        return Node { low, high, own, children, error };
    }
    if !own.is_empty() {
        error = error.max(largest(own.iter()));
        children.insert(0, Node::leaf(own));
    }
    Node { low, high, own: Vec::new(), children, error }
}

/// The largest diagonal of some instances.
fn largest<'a>(items: impl Iterator<Item = &'a Item>) -> f64 {
    items.map(Item::diagonal).fold(0.0, f64::max)
}
