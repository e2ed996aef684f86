//! The search for occluders: by the nodes of the hierarchy, those first that may hold the best.
//!
//! The score of a shape is what may be behind its [pixels](super::density) for what drawing it
//! costs, so no shape below a node has a higher score than the cheapest of the scene would have
//! over all of the node's pixels. What was found waits on a heap, nodes by such a bound and shapes by
//! their score. The best is taken: a node is opened, an instance gives its shapes, and a shape is
//! the best of all, since everything else has a lower bound. So of ten million instances only those
//! are looked at that lie around the some hundred that are drawn.
//!
//! The shapes that were taken are drawn in batches. A batch hides some of the entries that wait, each
//! of which is tested when it comes to the top.

use alloc::collections::BinaryHeap;
use alloc::vec::Vec;

use super::super::sets::{Coarse, GROUP, groups};
use super::density::Density;
use crate::array::{self, Each};
use crate::bits;
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::cull::detail::Detail;
use crate::cull::occlusion::{
    BoxTests, Candidate, CostModel, LeastCost, Occluder, OcclusionBuffer, ScreenBounds, Shape,
    cross, dot,
};
use crate::jobs::{self, Jobs, MOST};
use crate::prepared::Prepared;
use crate::scene::Scene;
use crate::sort::of_f32;
use crate::transform::Transform;
use crate::view::View;

/// Smaller ones hide next to nothing.
const LEAST_PIXELS: f32 = 16.0;

/// A patch that covers fewer pixels hides nothing.
const LEAST_COVERED: f32 = 2.0;

/// The most shapes of an instance of which each is boxed in the space of the scene. The boxes of
/// more shapes are tested in the space of the instance.
const FEW_SHAPES: usize = 6;

/// The fewest entries that are worth a job.
const LEAST_SWEPT: f32 = 96.0;

/// The most entries of which all are tested: of more, most never come to the top.
const MOST_SWEPT: usize = 1024;

/// The place of an entry that is dropped: none has it, for so many would not fit into memory.
const GONE: u32 = 0;

/// The most meshes of which the least costs are looked up. With more, the look-up costs more than
/// it saves.
const MOST_MESHES: usize = 1024;

/// Search for occluders: everything that it looks at.
pub(super) struct Search<'a> {
    pub(super) scene: &'a Scene,
    pub(super) buffer: &'a OcclusionBuffer,
    pub(super) tests: BoxTests<'a>,
    pub(super) costs: CostModel,
    /// Least cost of a shape of the scene.
    pub(super) least_cost: LeastCost,
    /// Whether the fronts of one-sided shapes hide anything.
    pub(super) fronts_are_drawn: bool,
    /// Around where the view begins; see [`is_within`].
    pub(super) near: Aabb,
    /// Slots that are alive, one bit each, and the words of it that are not zero.
    pub(super) alive: &'a [u64],
    pub(super) live: &'a [u32],
    /// Instances that are drawn by levels. They hide nothing: the shapes are of the mesh in full.
    pub(super) coarse: &'a Coarse,
    /// Value of pixels.
    pub(super) density: &'a Density,
    pub(super) view: &'a View,
    /// Set where instances fade before they are too small: those are drawn by a part of their
    /// pixels, and hide nothing.
    pub(super) fade: Option<Detail>,
}

/// Nodes, instances and shapes that were found and not taken yet. Memory that is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Frontier {
    open: BinaryHeap<Entry>,
    found: Vec<Found>,
    /// Batches that were drawn since the search began, and how many had been when all that waited
    /// was tested.
    drawn: u32,
    swept: u32,
    /// The last of those tests dropped too little.
    is_kept: bool,
    considered: u64,
}

/// An entry by its score, the highest first; of one score, nodes first, then the lower slot, then
/// what was found first. With it the complement of its place among what was found.
type Entry = (u64, u32);

/// Entry of the frontier.
#[derive(Clone, Copy, Debug)]
struct Found {
    what: What,
    bounds: Option<ScreenBounds>,
    /// Batches that had been drawn when it was found not to be hidden.
    drawn: u32,
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// A node of `level` 0 to 2, which holds 16, 256 or 4,096 slots.
    Node {
        level: u32,
        number: u32,
    },
    Instance {
        slot: u32,
    },
    Shape {
        slot: u32,
        shape: u32,
        cost: f32,
    },
}

impl Frontier {
    /// Forgets everything but the memory.
    fn clear(&mut self) {
        self.open.clear();
        self.found.clear();
        (self.drawn, self.swept, self.considered) = (0, 0, 0);
        self.is_kept = false;
    }

    /// Notes that what was taken is drawn, so that what waits may be hidden.
    pub(super) fn note_drawn(&mut self) {
        self.drawn += 1;
    }

    /// Whether a batch was drawn since all that waits was tested, and testing it is likely to pay.
    fn is_unswept(&self) -> bool {
        self.drawn > self.swept && !self.is_kept
    }

    /// Number of shapes that were looked at.
    pub(super) fn considered(&self) -> u64 {
        self.considered
    }

    fn push(&mut self, score: f32, what: What, bounds: Option<ScreenBounds>) {
        let ties = match what {
            What::Node { .. } => u32::MAX,
            What::Instance { slot } | What::Shape { slot, .. } => !slot,
        };
        let key = u64::from(of_f32(score)) << 32 | u64::from(ties);
        self.open.push((key, !(self.found.len() as u32)));
        self.found.push(Found { what, bounds, drawn: self.drawn });
    }
}

impl Search<'_> {
    /// Begins the search: lists the nodes of 4,096 slots.
    pub(super) fn begin(&self, frontier: &mut Frontier) {
        frontier.clear();
        let mut live = groups(self.live).map(|live| live[0] as usize / GROUP).peekable();
        while let Some(first) = live.next() {
            let (block, mut wanted) = (first / LANES, 1 << (first % LANES));
            while let Some(next) = live.next_if(|group| group / LANES == block) {
                wanted |= 1 << (next % LANES);
            }
            self.list_nodes((2, block), wanted, frontier);
        }
    }

    /// Takes the best shapes that are not hidden, until they cost `enough` or the next one would
    /// cost more than `most` with them. Returns whether something is left to take.
    pub(super) fn take(
        &self,
        frontier: &mut Frontier,
        [enough, most]: [f32; 2],
        chosen: &mut Vec<Candidate>,
    ) -> bool {
        let mut sum = 0.0;
        chosen.clear();
        while let Some(&(_, place)) = frontier.open.peek() {
            let Found { what, bounds, drawn } = frontier.found[!place as usize];
            let is_known = drawn.max(frontier.swept) == frontier.drawn;
            let is_hidden = !is_known && self.is_hidden(bounds, frontier);
            if let (What::Shape { cost, .. }, false) = (what, is_hidden)
                && sum + cost > most
            {
                return true;
            }
            frontier.open.pop();
            match what {
                _ if is_hidden => {}
                What::Node { level, number } => self.open(level, number as usize, frontier),
                What::Instance { slot } => self.list_shapes(slot, bounds, frontier),
                What::Shape { slot, shape, cost } => {
                    let nearness = bounds.map_or(f32::INFINITY, |f| f.nearness);
                    chosen.push(Candidate { nearness, slot, shape, cost, bounds });
                    sum += cost;
                    if sum >= enough {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Drops all that waits and is hidden after a batch was drawn, in jobs, where there is enough. An
    /// entry that is not tested here is tested when it comes to the top, which many never do. So it
    /// pays while most of them are hidden, and is given up in a cull where they are not.
    pub(super) fn sweep(&self, jobs: &dyn Jobs, frontier: &mut Frontier) {
        let waiting = frontier.open.len();
        let count = jobs::split(jobs, waiting as f32, LEAST_SWEPT, 1);
        if count == 1 || waiting > MOST_SWEPT || !frontier.is_unswept() {
            return;
        }
        let Frontier { open, found, .. } = frontier;
        let mut entries = core::mem::take(open).into_vec();
        let size = entries.len().div_ceil(count);
        let mut chunks = entries.chunks_mut(size);
        let mut chunks: [_; MOST] = array::from_fn(|_| chunks.next().unwrap_or_default());
        jobs::each(jobs, &mut chunks[..count], |chunk| {
            for entry in &mut **chunk {
                let bounds = found[!entry.1 as usize].bounds;
                if bounds.is_some_and(|b| self.buffer.covers(self.tests.simd(), &b)) {
                    entry.1 = GONE;
                }
            }
        });
        entries.retain(|entry| entry.1 != GONE);
        frontier.is_kept = entries.len() * 2 > waiting;
        *open = BinaryHeap::from(entries);
        frontier.swept = frontier.drawn;
    }

    /// Lists what is below a node of `level`.
    fn open(&self, level: u32, node: usize, frontier: &mut Frontier) {
        let alive = |slots: usize, n: usize| {
            let first = (node * LANES + n) * slots;
            let words = first / 64..(first + slots).div_ceil(64).min(self.alive.len());
            let word = self.alive.get(words).unwrap_or(&[]).iter().fold(0, |any, word| any | word);
            word >> (first % 64) & u64::MAX >> (64 - slots.min(64)) != 0
        };
        let wanted = |slots: usize| {
            (0..LANES).fold(0_u64, |wanted, n| wanted | u64::from(alive(slots, n)) << n)
        };
        match level {
            0 => self.list_instances(node, frontier),
            1 => self.list_nodes((0, node), wanted(LANES), frontier),
            _ => self.list_nodes((1, node), wanted(LANES * LANES), frontier),
        }
    }

    /// Lists the `wanted` nodes of a block of a level, but for those with too few pixels and those
    /// that are hidden or outside. A node without bounds crosses the near plane or was not made for
    /// all instances that are there now.
    fn list_nodes(&self, (level, block): (usize, usize), wanted: u64, frontier: &mut Frontier) {
        let nodes = self.scene.hierarchy().nodes();
        let of_level = nodes.levels().get(level).and_then(|l| l.blocks().get(block));
        let whole = (nodes.len() / LANES.pow(level as u32 + 1)).saturating_sub(block * LANES);
        let known = wanted & of_level.map_or(0, |_| (1 << whole.min(LANES)) - 1);
        let mut list = |n: usize, bounds: Option<ScreenBounds>| {
            let number = block * LANES + n;
            // A node may be large and hold only small boxes.
            let largest = || nodes.largest_below(level, number);
            let pixels = bounds.map_or(f32::INFINITY, |f| self.tests.most_pixels(&f, largest()));
            if pixels < LEAST_PIXELS || self.is_hidden(bounds, frontier) {
                return;
            }
            let value = self.density.most_of(bounds, pixels);
            let score = self.costs.score(self.least_cost, value, self.density.densest());
            let what = What::Node { level: level as u32, number: number as u32 };
            frontier.push(score, what, bounds);
        };
        bits::ones(wanted & !known).for_each(|n| list(n, None));
        if let Some(of_level) = of_level.filter(|_| known != 0) {
            self.tests.bounds_of_nodes(of_level, known, LEAST_PIXELS, list);
        }
    }

    /// Whether what was drawn hides all of some screen bounds. Where a node's are hidden, so are
    /// those of all that is below it, so that what is considered does not depend on the nodes.
    fn is_hidden(&self, bounds: Option<ScreenBounds>, frontier: &Frontier) -> bool {
        let covers = |b| self.buffer.covers(self.tests.simd(), &b);
        frontier.drawn > 0 && bounds.is_some_and(covers)
    }

    /// Lists sixteen instances, of those that may hide something.
    fn list_instances(&self, block: usize, frontier: &mut Frontier) {
        let alive = self.alive[block / 4] >> (block % 4 * LANES) & 0xffff;
        let boxes = &self.scene.boxes().blocks()[block];
        self.tests.bounds_of(boxes, alive, LEAST_PIXELS, |lane, bounds| {
            let slot = (block * LANES + lane) as u32;
            if let Some(occluder) = occluder_of(self.scene, self.coarse, slot)
                && !self.fades(slot)
                && !self.is_hidden(bounds, frontier)
            {
                let (least, densest) = (occluder.least_cost(), self.density.densest());
                let score = self.costs.score(least, self.density.of_bounds(bounds), densest);
                frontier.push(score, What::Instance { slot }, bounds);
            }
        });
    }

    /// Whether an instance is drawn by a part of its pixels.
    fn fades(&self, slot: u32) -> bool {
        let Self { scene, view, .. } = self;
        self.fade.is_some_and(|detail| {
            let rect = view.project_box(&scene.bounds(slot), scene.origin());
            let size = rect.map(|rect| [rect.width(), rect.height()]);
            detail.weight(size, f64::from(scene.size_weight(slot))) < 1.0
        })
    }

    /// The pixels of that part of a shape's box that lies beyond the near plane; `None` where there
    /// are none.
    fn seen_part(&self, slot: u32, shape: &Shape) -> Option<[[u32; 2]; 2]> {
        let scene = self.scene;
        let b = scene.transform(slot).transform_box(&shape.bounds(), scene.origin());
        let [min, max] = self.view.part_of_box(&b, scene.origin())?;
        let size = self.buffer.size();
        let pixel = |v: f64, a: usize| {
            let v = v * f64::from(size[a]);
            v.clamp(0.0, f64::from(size[a] - 1)) as u32
        };
        Some([min, max].each(|p| array::from_fn(|a| pixel(p[a], a))))
    }

    /// Lists the shapes of an instance that are for a view which begins within what it seals off,
    /// or does not.
    fn list_shapes(&self, slot: u32, of: Option<ScreenBounds>, frontier: &mut Frontier) {
        let Self { scene, tests, .. } = self;
        let Some(occluder) = scene.prepared_of(slot).occluder() else { return };
        let within = is_within(scene, slot, occluder, &self.near);
        type Area<'a> = &'a dyn Fn() -> Option<[f32; 3]>;
        let mut list = |number: usize, bounds: Option<ScreenBounds>, area: Area<'_>| {
            let shape = &occluder.shapes()[number];
            if !(self.fronts_are_drawn || shape.is_two_sided())
                || !occluder.is_for(number, within)
                || self.is_hidden(bounds, frontier)
            {
                return;
            }
            // Bounds that cross the near plane have no screen bounds; those of the part beyond
            // estimate them.
            let (min, max) = match bounds {
                Some(f) => (f.min, f.max),
                None => match self.seen_part(slot, shape) {
                    Some([min, max]) => (min, max),
                    None => return,
                },
            };
            let pixels = ScreenBounds { min, max, nearness: 0.0 }.pixels();
            // Of a patch, those that it covers; a body covers most of its box.
            let facing = occluder.facing()[number].as_ref().filter(|_| bounds.is_some());
            let covered = facing.and_then(|facing| Some(facing.pixels(area()?).min(pixels)));
            let covered = covered.unwrap_or(pixels);
            if covered < LEAST_COVERED {
                return;
            }
            let cost = self.costs.cost(occluder.edges()[number], pixels);
            let score = self.density.of(min, max) * (covered / pixels) / cost;
            frontier.considered += 1;
            frontier.push(score, What::Shape { slot, shape: number as u32, cost }, bounds);
        };
        let transform = scene.transform(slot);
        let of_box = |b: &Aabb| {
            let v = tests.pixels_of_area([0, 1, 2].map(|a| (b.min[a] + b.max[a]) * 0.5))?;
            Some(in_object(transform, v))
        };
        if let [_] = occluder.shapes() {
            list(0, of, &|| of_box(&scene.bounds(slot)));
            return;
        }
        if occluder.shapes().len() <= FEW_SHAPES {
            // A projection of its own costs more than what it tells.
            let mut block = BoxBlock([[0.0; LANES]; 6]);
            let mut boxes = [Aabb::EMPTY; FEW_SHAPES];
            for (lane, shape) in occluder.shapes().iter().enumerate() {
                boxes[lane] = transform.transform_box(&shape.bounds(), scene.origin());
                block.set(lane, &boxes[lane]);
            }
            let wanted = (1 << occluder.shapes().len()) - 1;
            tests.bounds_of(&block, wanted, LEAST_PIXELS, |lane, b| {
                list(lane, b, &|| of_box(&boxes[lane]));
            });
            return;
        }
        let tests = tests.for_object(transform);
        for (at, block) in occluder.boxes().blocks().iter().enumerate() {
            let count = occluder.shapes().len().saturating_sub(at * LANES).min(LANES);
            let wanted = (1 << count) - 1;
            tests.bounds_of(block, wanted, LEAST_PIXELS, |lane, b| {
                let middle = |a: usize| (block.0[a + 3][lane] - block.0[a][lane]) * 0.5;
                list(at * LANES + lane, b, &|| tests.pixels_of_area([0, 1, 2].map(middle)));
            });
        }
    }
}

/// Vector of area in the space of an object for one in the space of the scene: the products with
/// area vectors are the same, and as they would be without a mirror.
fn in_object(transform: &Transform, v: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = transform.linear;
    let columns = [cross(y, z), cross(z, x), cross(x, y)];
    let side = if dot(columns[0], x) < 0.0 { -1.0 } else { 1.0 };
    columns.map(|column| dot(column, v) * side)
}

/// Returns the least cost of a shape of a scene.
pub(super) fn least_cost(scene: &Scene) -> LeastCost {
    let prepared = scene.prepared();
    if prepared.len() > MOST_MESHES {
        return LeastCost::ANY;
    }
    let of = prepared.iter().filter_map(Prepared::occluder).map(Occluder::least_cost);
    of.fold(LeastCost::default(), LeastCost::or)
}

/// The occluder of an instance that may hide something.
fn occluder_of<'a>(scene: &'a Scene, coarse: &Coarse, slot: u32) -> Option<&'a Occluder> {
    let flags = scene.flags(slot);
    if flags.no_occlusion || flags.transparent || !scene.is_rigid(slot) {
        return None;
    }
    let occluder = scene.prepared_of(slot).occluder();
    occluder.filter(|occluder| !occluder.shapes().is_empty() && coarse.cut_of(slot).is_none())
}

/// Whether the view may begin within what the occluder of an instance seals off.
fn is_within(scene: &Scene, slot: u32, occluder: &Occluder, near: &Aabb) -> bool {
    let sealed = occluder.sealed().iter();
    sealed.map(|b| scene.transform(slot).transform_box(b, scene.origin())).any(|b| {
        // A NaN is no proof that they are apart.
        !(0..3).any(|a| near.min[a] > b.max[a] || near.max[a] < b.min[a])
    })
}
