//! Levels of groups, from the smallest up.

use cullet::bounds::Aabb;
use cullet::mesh::Part;
use cullet::{MeshData, Scene};

use super::fewest::Measure;
use super::keep::Kept;
use super::made::Made;
use super::tree::{Node, tree};
use super::{Member, MergeInput, MergeOptions, MergedGroup, MeshAttributes};
use crate::gather::{Piece, Surface};
use crate::levels::{LevelsError, Within, chain_of};
use crate::threads;
use crate::work::order_of_share;

/// Errors that are stated are so much larger than the largest distance that was found, for the
/// points that were not measured.
const STATED: f32 = 1.05;

pub(super) fn build(
    scene: &Scene,
    input: &MergeInput<'_>,
    options: &MergeOptions,
    go_on: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Option<Vec<MergedGroup>>, LevelsError> {
    let nodes = tree(scene, options);
    let triangles = |node: &Node| -> u64 {
        node.slots.iter().map(|&s| u64::from(scene.mesh(s).triangle_count())).sum()
    };
    let kept = Kept::new(scene, input, options, &nodes);
    let all: u64 = nodes.iter().map(triangles).sum();
    let done = std::sync::atomic::AtomicU64::new(0);
    let mut made: Vec<Option<Made>> = nodes.iter().map(|_| None).collect();
    let tallest = nodes.iter().map(|n| n.height).max().unwrap_or(0);
    for height in 0..=tallest {
        let mut now: Vec<usize> = (0..nodes.len()).filter(|&n| nodes[n].height == height).collect();
        if let Some(share) = input.share {
            let costs: Vec<f64> = now.iter().map(|&n| triangles(&nodes[n]) as f64).collect();
            let order = order_of_share(&costs, share, height == tallest);
            now = order.into_iter().map(|at| now[at]).collect();
        }
        let job = |_: &mut (), at: usize| {
            let number = now[at];
            let count = triangles(&nodes[number]);
            let kept = kept.as_ref().filter(|kept| kept.is_for(count));
            let result = match kept.and_then(|kept| kept.read(number)) {
                Some(found) => Ok(found),
                None => one(scene, input, options, &nodes, &made, number).inspect(|made| {
                    if let Some(kept) = kept {
                        kept.write(number, made.as_ref());
                    }
                }),
            };
            done.fetch_add(count, std::sync::atomic::Ordering::Relaxed);
            result
        };
        let share = || {
            let done = done.load(std::sync::atomic::Ordering::Relaxed);
            go_on(done as f64 / all.max(1) as f64)
        };
        let Some(found) = threads::run(options.threads, now.len(), || (), job, share) else {
            return Ok(None);
        };
        for (number, found) in now.into_iter().zip(found) {
            made[number] = found?;
        }
    }
    if input.share.is_some() {
        return Ok(Some(Vec::new()));
    }
    // Groups that are none hand their members on.
    let mut number_of = vec![None; nodes.len()];
    let mut members: Vec<Vec<Member>> = Vec::with_capacity(nodes.len());
    let mut groups = Vec::new();
    for (at, node) in nodes.iter().enumerate() {
        let own: Vec<Member> = match &node.below[..] {
            [] => node.slots.iter().map(|&s| Member::Instance(s)).collect(),
            below => below
                .iter()
                .flat_map(|&b| match number_of[b as usize] {
                    Some(group) => vec![Member::Group(group)],
                    None => members[b as usize].clone(),
                })
                .collect(),
        };
        if let Some(made) = made[at].take() {
            number_of[at] = Some(groups.len() as u32);
            groups.push(assembled(made, own.clone())?);
        }
        members.push(own);
    }
    Ok(Some(groups))
}

/// The levels of a group, if it has any that pay.
fn one(
    scene: &Scene,
    input: &MergeInput<'_>,
    options: &MergeOptions,
    nodes: &[Node],
    made: &[Option<Made>],
    number: usize,
) -> Result<Option<Made>, LevelsError> {
    let node = &nodes[number];
    let triangles: u64 =
        node.slots.iter().map(|&s| u64::from(scene.mesh(s).triangle_count())).sum();
    if triangles > options.most_triangles || node.slots.len() < 2 {
        return Ok(None);
    }
    let around = node.slots.iter().map(|&s| scene.bounds(s));
    let around = around.fold(Aabb::EMPTY, |a, b| a.union(&b));
    let scene_origin = scene.origin();
    let origin: [f64; 3] = std::array::from_fn(|a| {
        (f64::from(around.min[a]) + f64::from(around.max[a])) * 0.5 + scene_origin[a]
    });
    let mut kinds: Vec<Part> = Vec::new();
    let whole = node.slots.iter().map(|&s| Piece::whole(scene, s));
    let original = Surface::gather(scene, input.attributes, whole, origin, &mut kinds);
    let length = |p: &[f32; 3]| p.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
    let radius = original.positions.iter().map(length).fold(0.0, f64::max);
    if !(radius > 0.0 && radius < 1e15) || original.indices.is_empty() {
        return Ok(None);
    }
    let measure = Measure::new(&original);
    drop(original);
    let mut levels: Vec<(Surface, f32)> = Vec::new();
    let mut start = None;
    let mut bound = options.first * radius;
    for _ in 0..options.levels {
        let below: u64 = of_members(nodes, node, &mut |n| fewest_at(scene, nodes, made, n, bound));
        let before = levels.last().map_or(u64::MAX, |l| l.0.triangle_count());
        let most = (below.min(before) as f64 * options.keep) as u64 + 1;
        if levels.is_empty() {
            let from = (scene, input.attributes);
            let of = input_at(from, nodes, made, number, bound * 0.5, (origin, &mut kinds));
            start = Some(measure.start(of));
        }
        let Some(from) = &mut start else { break };
        let stated = (bound as f32).next_down() / STATED;
        if let Some((surface, error)) = measure.fewest(from, stated, most) {
            let error = levels.last().map_or(0.0, |l| l.1).max(error * STATED);
            levels.push((surface, error));
        }
        bound *= 2.0;
    }
    Ok((!levels.is_empty()).then_some(Made { origin, radius: radius as f32 * 1.000_01, levels }))
}

/// Who is asked for what is below a group.
enum Asked {
    Instance(u32),
    Node(usize),
}

/// Sums up something over the members of a node.
fn of_members(nodes: &[Node], node: &Node, of: &mut dyn FnMut(Asked) -> u64) -> u64 {
    match &node.below[..] {
        [] => node.slots.iter().map(|&s| of(Asked::Instance(s))).sum(),
        below => {
            debug_assert!(below.iter().all(|&b| (b as usize) < nodes.len()));
            below.iter().map(|&b| of(Asked::Node(b as usize))).sum()
        }
    }
}

/// The fewest triangles that are drawn within a bound.
fn fewest_at(scene: &Scene, nodes: &[Node], made: &[Option<Made>], of: Asked, bound: f64) -> u64 {
    match of {
        Asked::Instance(slot) => Piece::within(scene, slot, bound).triangles,
        Asked::Node(number) => match level_at(&made[number], bound) {
            Some((_, surface)) => surface.triangle_count(),
            None => {
                of_members(nodes, &nodes[number], &mut |n| fewest_at(scene, nodes, made, n, bound))
            }
        },
    }
}

/// The coarsest level of a group within a bound, and where its origin is.
fn level_at(made: &Option<Made>, bound: f64) -> Option<([f64; 3], &Surface)> {
    let made = made.as_ref()?;
    let within = made.levels.iter().rev().find(|l| f64::from(l.1) <= bound);
    within.map(|(surface, _)| (made.origin, surface))
}

/// Returns what is drawn of a node within a bound, as one surface.
fn input_at(
    (scene, attributes): (&Scene, &[MeshAttributes<'_>]),
    nodes: &[Node],
    made: &[Option<Made>],
    number: usize,
    bound: f64,
    (origin, kinds): ([f64; 3], &mut Vec<Part>),
) -> Surface {
    let (mut slots, mut surfaces, mut pending) = (Vec::new(), Vec::new(), vec![number]);
    while let Some(number) = pending.pop() {
        match level_at(&made[number], bound) {
            Some((from, surface)) => {
                surfaces.push((surface, std::array::from_fn(|a| from[a] - origin[a])));
            }
            None if nodes[number].below.is_empty() => slots.extend(&nodes[number].slots),
            None => pending.extend(nodes[number].below.iter().map(|&b| b as usize)),
        }
    }
    let pieces = slots.into_iter().map(|s| Piece::within(scene, s, bound));
    let own = Surface::gather(scene, attributes, pieces, origin, kinds);
    if surfaces.is_empty() {
        return own;
    }
    Surface::join(surfaces.into_iter().chain([(&own, [0.0; 3])]), kinds)
}

fn assembled(made: Made, members: Vec<Member>) -> Result<MergedGroup, LevelsError> {
    let Made { origin, radius, levels } = made;
    let mut data = MeshData::default();
    let mut of = Vec::with_capacity(levels.len());
    let kinds = levels.iter().map(|l| l.0.parts.len()).max().unwrap_or(0);
    let empty: Vec<Part> = levels
        .iter()
        .find(|l| l.0.parts.len() == kinds)
        .map(|l| l.0.parts.iter().map(|p| Part { first_triangle: 0, triangle_count: 0, ..*p }))
        .into_iter()
        .flatten()
        .collect();
    let mut values = Vec::new();
    let has_values = levels.iter().any(|l| !l.0.values.is_empty());
    for (surface, error) in levels {
        if has_values {
            values.extend(&surface.values);
            values.resize(data.positions.len() + surface.positions.len(), Surface::NONE);
        }
        let first = data.positions.len() as u32;
        data.positions.extend(&surface.positions);
        let indices: Vec<u32> = surface.indices.iter().map(|v| v + first).collect();
        let mut parts = surface.parts;
        let end = (indices.len() / 3) as u32;
        parts.extend(empty[parts.len()..].iter().map(|p| Part { first_triangle: end, ..*p }));
        of.push(Within { indices, parts, error });
    }
    data.parts.clone_from(&empty);
    let levels = chain_of(&data, &empty, &of, [0.0; 3], radius)?;
    let uvs: Vec<[f32; 2]> = values.iter().map(|&[u, v, ..]| [u, v]).collect();
    let colors: Vec<[f32; 4]> = values.iter().map(|&[.., r, g, b, a]| [r, g, b, a]).collect();
    let has_uvs = uvs.iter().any(|v| *v != [0.0; 2]);
    let has_colors = colors.iter().any(|v| *v != [1.0; 4]);
    Ok(MergedGroup {
        levels,
        uvs: if has_uvs { uvs } else { Vec::new() },
        colors: if has_colors { colors } else { Vec::new() },
        origin,
        members,
    })
}
