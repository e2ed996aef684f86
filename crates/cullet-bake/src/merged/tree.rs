//! Choice of the instances that are grouped, and how.

use std::collections::BTreeMap;

use cullet::mesh::Alpha;
use cullet::{InstanceFlags, Scene};

use super::MergeOptions;

/// Instances whose box is longer than this share of that around all are in no group.
const LARGEST: f64 = 0.125;

/// A group to be, and what it is made of: instances, or groups.
#[derive(Debug)]
pub(super) struct Node {
    /// All instances below.
    pub(super) slots: Vec<u32>,
    /// The numbers of the groups below, all lower than its own; none of the smallest.
    pub(super) below: Vec<u32>,
    /// How many levels of groups are below.
    pub(super) height: u32,
}

/// An instance: its slot, and the middle of its box.
type Placed = (u32, [f64; 3]);

/// The groups, those below others before them.
pub(super) fn tree(scene: &Scene, options: &MergeOptions) -> Vec<Node> {
    let extent = scene.extent();
    let diagonal = |b: &cullet::bounds::Aabb| {
        let side = |a: usize| f64::from(b.max[a]) - f64::from(b.min[a]);
        (0..3).map(|a| side(a) * side(a)).sum::<f64>().sqrt()
    };
    let longest = diagonal(&extent) * LARGEST;
    // What is drawn alike can be drawn together.
    let mut kinds: BTreeMap<(u32, bool), Vec<Placed>> = BTreeMap::new();
    for slot in scene.slots() {
        let (mesh, flags) = (scene.mesh(slot), scene.flags(slot));
        let is_plain =
            flags == InstanceFlags { no_occlusion: flags.no_occlusion, ..InstanceFlags::default() };
        let is_solid = mesh.parts().iter().all(|p| p.alpha != Alpha::Blended);
        let b = scene.bounds(slot);
        let fits = scene.is_rigid(slot) && is_plain && is_solid && b.is_finite();
        let size = scene.size_weight(slot) == 1.0;
        if fits && size && !mesh.clusters().is_empty() && diagonal(&b) <= longest {
            let middle = |a: usize| (f64::from(b.min[a]) + f64::from(b.max[a])) * 0.5;
            let key = (scene.layers(slot), flags.no_occlusion);
            kinds.entry(key).or_default().push((slot, std::array::from_fn(middle)));
        }
    }
    let mut nodes = Vec::new();
    for mut items in kinds.into_values().filter(|items| items.len() > 1) {
        grow(&mut items, options, &mut nodes);
    }
    nodes
}

/// Groups instances by halving them at the middle of the longest side; the number of the group of
/// all.
fn grow(items: &mut [Placed], options: &MergeOptions, nodes: &mut Vec<Node>) -> u32 {
    let slots: Vec<u32> = items.iter().map(|i| i.0).collect();
    let (mut below, mut height) = (Vec::new(), 0);
    if items.len() > options.smallest as usize {
        let mut parts = vec![items];
        while parts.len() < options.fan as usize {
            let halved = parts.into_iter().flat_map(|items| halves(items, options));
            let halved: Vec<_> = halved.collect();
            let is_done = halved.iter().all(|part| part.len() <= options.smallest as usize);
            parts = halved;
            if is_done {
                break;
            }
        }
        for part in parts {
            let number = grow(part, options, nodes);
            height = height.max(nodes[number as usize].height + 1);
            below.push(number);
        }
    }
    nodes.push(Node { slots, below, height });
    nodes.len() as u32 - 1
}

/// The halves of what is more than the smallest group.
fn halves<'a>(
    items: &'a mut [Placed],
    options: &MergeOptions,
) -> impl Iterator<Item = &'a mut [Placed]> {
    let mut whole = None;
    let mut two = None;
    if items.len() <= options.smallest as usize {
        whole = Some(items);
    } else {
        let side = |a: usize| {
            let values = || items.iter().map(|i| i.1[a]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let axis = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(0);
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            a.1[axis].total_cmp(&b.1[axis]).then(a.0.cmp(&b.0))
        });
        two = Some(<[_; 2]>::from(items.split_at_mut(middle)));
    }
    whole.into_iter().chain(two.into_iter().flatten())
}
