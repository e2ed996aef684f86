//! Frustum culling by the groups of a scene's author: a group outside is dropped whole, and can be named;
//! a group inside is taken whole; one that straddles asks what is in it.
//!
//! The answer is that of the flat sweep ([`batch`](super::batch)) over the groups' boxes, bit for bit, in
//! the order of their places.
//!
//! ```
//! use cullet::bounds::Aabb;
//! use cullet::cull::frustum::batch::Planes;
//! use cullet::cull::frustum::groups::{Fate, cull_groups, explain_groups};
//! use cullet::cull::frustum::tree::Cut;
//! use cullet::hierarchy::Groups;
//! use cullet::{Camera, Level, Projection};
//!
//! // Two houses of twenty things each; the second is behind the camera.
//! let thing = |x: f32, z: f32| Aabb::new([x, 0.0, z], [x + 0.5, 1.0, z + 0.5]);
//! let things: Vec<_> =
//!     [-30.0, 30.0].iter().flat_map(|&z| (0..20).map(move |i| thing(i as f32 * 0.1, z))).collect();
//! let members: Vec<_> = (0..40).map(|i| [i / 20, i]).collect();
//! let groups = Groups::build(&[Groups::NONE; 2], &members, &things)?;
//!
//! let projection =
//!     Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 100.0 };
//! let (eye, direction, up) = ([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
//! let frustum = Camera { eye, direction, up, projection }.frustum()?;
//! let planes = Planes::new(&frustum);
//! let mut cut = Cut::new();
//! cull_groups(Level::new(), &planes, &groups, &mut cut);
//! assert_eq!(cut.count(), 20);
//!
//! let mut fates = Vec::new();
//! explain_groups(Level::new(), &planes, &groups, &mut cut, &mut fates);
//! let place = groups.place(25).expect("it is there");
//! assert!(matches!(fates[place as usize], Fate::WithGroup { group: 1, .. }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

use super::batch::{Planes, VISIBLE};
use super::tree::Cut;
use super::tree::walk::{Front, SWEEP, Target, compress, test};
use crate::bits;
use crate::bounds::LANES;
use crate::hierarchy::{GroupNode, Groups};

/// What became of a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// No plane rejects it.
    Visible,
    /// The whole of a group was dropped, and it with the rest.
    WithGroup {
        /// The caller's number of the group, the outermost that was dropped.
        group: u32,
        /// The number of the first plane that rejects the group.
        plane: u8,
    },
    /// It was dropped by itself; so is what has an empty box, wherever it is.
    Alone {
        /// The number of the first plane that rejects it.
        plane: u8,
    },
}

/// Groups of no more things than this do not ask the groups in them, but all things at once: that is one
/// to five tests of sixteen, which wait for nothing. Measured on the nested city below: 24 takes 28.0 µs, 64
/// takes 24.7.
const FEW: usize = 64;

/// Culls by groups, with the answer in places: `cut` is what
/// [`classify_boxes`](super::batch::classify_boxes) finds of [`Groups::boxes`], visible and inside. Any
/// number of planes up to 32. Allocates only where `cut` never held as much.
///
/// Where so much straddles that a sweep of all things is cheaper, it sweeps; [`Cut::swept`] tells.
///
/// Against our own [`Nodes`](crate::hierarchy::Nodes) over the same boxes and the flat sweep of those, µs a
/// view, one thread, AVX-512 (`cargo test --release -p cullet-io --test groups -- --nocapture`):
///
/// | scene | things | groups | went with a group | by groups | by nodes | flat |
/// |---|---|---|---|---|---|---|
/// | city, blocks of houses of floors | 882,384 | 90,940 | 88 % | 25 | 14 | 930 |
/// | the same, the floors alone | 882,384 | 90,940 | 88 % | 480 | 14 | 970 |
/// | the same, twenty kinds of things | 882,384 | 20 | 0 % | 1210 | 14 | 1090 |
/// | intel-castle, its node tree | 2,114 | 2,418 | 86 % | 1.8 | 0.5 | 1.2 |
/// | duplex, one node for all | 215 | 216 | 80 % | 0.4 | 0.4 | 0.3 |
///
/// So groups that are nested by place come within a factor of two of nodes that are made for culling; groups
/// in one long list lose by the length of the list; groups by kind of thing are no better than none. Take
/// them for their names and for subtrees that are switched or moved as one, or where making nodes is not
/// worth its while; else take nodes.
pub fn cull_groups(level: Level, planes: &Planes, groups: &Groups, cut: &mut Cut) {
    walk(level, planes, groups, cut, FEW, |_, _| {});
}

/// [`cull_groups`], and what became of the thing at each place. Slower: every group that straddles asks
/// the groups in it, however few things they have, and what is outside is asked again for its plane.
///
/// `fates` is made as long as there are things; it allocates only where it never was as long. A group's
/// plane is one that rejects the thing too, but perhaps not the first that does.
pub fn explain_groups(
    level: Level,
    planes: &Planes,
    groups: &Groups,
    cut: &mut Cut,
    fates: &mut Vec<Fate>,
) {
    fates.clear();
    fates.resize(groups.items().len(), Fate::Visible);
    let nodes = groups.nodes();
    let boxes = groups.node_boxes();
    walk(level, planes, groups, cut, 0, |block, rejected| {
        for lane in bits::ones(u64::from(rejected)) {
            let at = block * LANES + lane;
            let plane = planes.first_rejecting(boxes, at);
            let GroupNode { group, .. } = nodes[at];
            fates[nodes[at].places()].fill(Fate::WithGroup { group, plane });
        }
    });
    for (place, fate) in fates.iter_mut().enumerate() {
        let gone = !bits::get(cut.visible(), place);
        if gone && (*fate == Fate::Visible || bits::get(groups.holes(), place)) {
            *fate = Fate::Alone { plane: planes.first_rejecting(groups.boxes(), place) };
        }
    }
}

/// The oracle of [`explain_groups`]: thing by thing, its groups from the outermost in, then itself.
#[must_use]
pub fn cull_groups_ref(planes: &Planes, groups: &Groups) -> Vec<Fate> {
    let nodes = groups.nodes();
    let fate = |place: usize| {
        let item = groups.items()[place];
        let innermost = groups.group_of(item);
        let mut chain: Vec<_> = std::iter::successors(innermost, |&g| groups.parent(g)).collect();
        chain.reverse();
        if bits::get(groups.holes(), place) {
            chain.clear();
        }
        for group in chain {
            let Some(node) = nodes.iter().position(|n| n.group == group) else { continue };
            let plane = planes.first_rejecting(groups.node_boxes(), node);
            if plane != VISIBLE {
                return Fate::WithGroup { group, plane };
            }
        }
        match planes.first_rejecting(groups.boxes(), place) {
            VISIBLE => Fate::Visible,
            plane => Fate::Alone { plane },
        }
    };
    (0..groups.items().len()).map(fate).collect()
}

/// Walks the groups, and calls `rejected` for each block of sixteen nodes with those that are outside.
fn walk(
    level: Level,
    planes: &Planes,
    groups: &Groups,
    cut: &mut Cut,
    few: usize,
    mut rejected: impl FnMut(usize, u32),
) {
    let things = groups.items().len();
    cut.clear(things);
    if things == 0 {
        return;
    }
    let [mut front, other] = std::mem::take(&mut cut.fronts);
    front.set_root(planes.len(), things);
    // Every node is met once at most, and compress writes a vector more.
    front.reserve(groups.nodes().len());
    let mut target = cut.target(things);
    let walk = Walk { planes, groups, few };
    let asked = dispatch!(level, simd => walk.nodes(simd, &mut front, &mut target, &mut rejected));
    let sweeps = asked * SWEEP.1 > things / LANES * SWEEP.0 && asked > 1;
    if !sweeps {
        dispatch!(level, simd => walk.things(simd, &front, &mut target));
    }
    cut.counts = target.counts;
    cut.fronts = [front, other];
    if sweeps {
        cut.sweep(level, planes, groups.boxes(), 0);
    } else {
        cut.finish(planes, Some(groups.holes()));
    }
}

struct Walk<'a> {
    planes: &'a Planes,
    groups: &'a Groups,
    few: usize,
}

impl Walk<'_> {
    /// The places that a node asks one by one, and whether it asks the groups in it.
    #[inline(always)]
    fn asks(&self, node: &GroupNode) -> (Range<usize>, bool) {
        let below = (node.end - node.own_end) as usize;
        // No more things than groups, each in one of its own as in many files: their boxes say no less.
        let listed = below <= node.children as usize && self.few > 0;
        if listed || node.places().len() <= self.few {
            (node.places(), false)
        } else {
            (node.own(), true)
        }
    }

    /// Asks groups, outermost first. What is inside is taken; what straddles stays in `front`, a queue that
    /// is read from its start while it grows. Returns how many blocks of things are left to ask.
    #[inline(always)]
    fn nodes<S: Simd>(
        &self,
        simd: S,
        front: &mut Front,
        target: &mut Target<'_>,
        rejected: &mut impl FnMut(usize, u32),
    ) -> usize {
        let planes = self.planes.box_planes();
        let nodes = self.groups.nodes();
        let boxes = self.groups.node_boxes().blocks();
        let mut asked = 0;
        let mut next = 0;
        while next < front.len {
            let node = &nodes[front.blocks[next] as usize];
            let open = front.open[next];
            next += 1;
            let (own, asks_groups) = self.asks(node);
            asked += blocks_of(&own).len();
            if !asks_groups {
                continue;
            }
            let children = node.child_range();
            for block in blocks_of(&children) {
                let mut closed = [0; LANES];
                let (seen, straddling) = test::<S>(simd, planes, open, &boxes[block], &mut closed);
                target.counts.nodes += 1;
                target.counts.planes += u64::from(open.count_ones());
                let here = lanes_of(&children, block);
                rejected(block, here & !seen);
                let seen = here & seen;
                for run in bits::runs(u64::from(seen & !straddling)) {
                    // Sisters lie one after the other, so what is in them does, too.
                    let first = nodes[block * LANES + run.start].first as usize;
                    let end = nodes[block * LANES + run.end - 1].end as usize;
                    if first < end {
                        target.take_range(first..end);
                    }
                }
                // One thing in a box of just its size: what holds for the box holds for the thing.
                let part = seen & straddling;
                let alone = part & self.groups.alone(block);
                for lane in bits::ones(u64::from(alone)) {
                    let place = nodes[block * LANES + lane].first as usize;
                    target.take_block(place / LANES, 1 << (place % LANES), 0);
                }
                let part = part & !alone;
                compress::<S>(simd, (block * LANES) as u32, part, &closed, front, front.len);
                front.len += part.count_ones() as usize;
            }
        }
        asked
    }

    /// Asks the things of the groups that straddle.
    #[inline(always)]
    fn things<S: Simd>(&self, simd: S, front: &Front, target: &mut Target<'_>) {
        let planes = self.planes.box_planes();
        let boxes = self.groups.boxes().blocks();
        for at in 0..front.len {
            let (places, _) = self.asks(&self.groups.nodes()[front.blocks[at] as usize]);
            let open = front.open[at];
            for block in blocks_of(&places) {
                let mut ignored = [0; LANES];
                let (seen, straddling) = test::<S>(simd, planes, open, &boxes[block], &mut ignored);
                let seen = seen & lanes_of(&places, block);
                target.counts.leaves += 1;
                target.counts.planes += u64::from(open.count_ones());
                target.take_block(block, seen, seen & !straddling);
            }
        }
    }
}

/// The blocks of sixteen that a range meets.
#[inline(always)]
fn blocks_of(range: &Range<usize>) -> Range<usize> {
    if range.is_empty() { 0..0 } else { range.start / LANES..range.end.div_ceil(LANES) }
}

/// The bits of a block's lanes that are in a range.
#[inline(always)]
fn lanes_of(range: &Range<usize>, block: usize) -> u32 {
    let base = block * LANES;
    let from = range.start.saturating_sub(base).min(LANES);
    let to = range.end.saturating_sub(base).min(LANES);
    (0xffff << from) & !(0xffff << to) & 0xffff
}
