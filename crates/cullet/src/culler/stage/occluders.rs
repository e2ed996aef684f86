//! The search for occluders: by the nodes of the hierarchy, those first that may hold the best.
//!
//! The score of a shape is what may be behind its [pixels](super::density) for what drawing it
//! costs, so no shape below a node has a higher score than the cheapest of the scene would have
//! over all of the node's pixels. Nodes are looked into from the best bound on, those of 4,096
//! slots first, and as soon as the budget is used up what cannot be among the chosen is passed over
//! unseen: of ten million instances a budget is enough for some hundred. The choice is that of
//! looking at everything.

use alloc::collections::BinaryHeap;
use core::cmp::Ordering;

use super::super::sets::{Coarse, GROUP, groups};
use super::density::Density;
use crate::array::{self, Each};
use crate::bits;
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::cull::detail::Detail;
use crate::cull::occlusion::{
    BoxTests, Candidate, Choice, CostModel, LeastCost, Occluder, OcclusionBuffer, ScreenBounds,
    Shape,
};
use crate::prepared::Prepared;
use crate::scene::Scene;
use crate::view::View;

/// Smaller ones hide next to nothing.
const LEAST_PIXELS: f32 = 16.0;

/// The most shapes of an instance of which each is boxed in the space of the scene. The boxes of
/// more shapes are tested in the space of the instance.
const FEW_SHAPES: usize = 6;

/// The most meshes of which the least costs are looked up. With more, the look-up costs more than
/// it saves.
const MOST_MESHES: usize = 1024;

/// Search for occluders: everything that it looks at.
pub(super) struct Search<'a> {
    pub(super) scene: &'a Scene,
    pub(super) buffer: &'a OcclusionBuffer,
    pub(super) tests: BoxTests<'a>,
    pub(super) costs: CostModel,
    /// Whether the fronts of one-sided shapes hide anything.
    pub(super) fronts_are_drawn: bool,
    /// Around where the view begins; see [`is_within`].
    pub(super) near: Aabb,
    /// Slots that are alive, one bit each, and the words of it that are not zero.
    pub(super) alive: &'a [u64],
    pub(super) live: &'a [u32],
    /// Instances that are drawn by levels. They hide nothing: the shapes are of the mesh in full.
    pub(super) coarse: &'a Coarse,
    /// The slots and shapes that the buffer has by now, ascending. What is hidden behind them is
    /// passed over.
    pub(super) drawn: &'a [(u32, u32)],
    /// Value of pixels.
    pub(super) density: &'a Density,
    pub(super) view: &'a View,
    /// Set where instances fade before they are too small: those are drawn by a part of their
    /// pixels, and hide nothing.
    pub(super) fade: Option<Detail>,
}

/// A node, and the highest score that a shape in it may have: the greater the better.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    score: f32,
    /// Level of the node in the hierarchy, 0 to 2: it holds 16, 256 or 4,096 slots.
    level: usize,
    number: u32,
}

impl Ord for Group {
    fn cmp(&self, other: &Self) -> Ordering {
        let ties = || (other.level, other.number).cmp(&(self.level, self.number));
        self.score.total_cmp(&other.score).then_with(ties)
    }
}

impl PartialOrd for Group {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Group {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Group {}

/// Limits that refuse a node without looking into it.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Least cost of a shape of the scene.
    least_cost: LeastCost,
    /// Least value worth looking at. A shape with less has a lower score than any that may be
    /// taken.
    least_value: f32,
}

impl Search<'_> {
    /// Fills `choice`; `open` is memory.
    pub(super) fn run(&self, open: &mut BinaryHeap<Group>, choice: &mut Choice) {
        let mut limits = Limits { least_cost: self.least_cost(), least_value: 0.0 };
        open.clear();
        self.list_highest(limits, open);
        let mut least_score = 0.0;
        while let Some(group) = open.pop() {
            if !choice.may_take(group.score) {
                break;
            }
            if choice.least_score() != least_score {
                least_score = choice.least_score();
                let (costs, densest) = (&self.costs, self.density.densest());
                limits.least_value = costs.least_value(limits.least_cost, least_score, densest);
            }
            if group.level == 2 {
                self.open(group.number as usize, limits, open);
            } else {
                self.look_into(group.number as usize, limits, choice);
            }
        }
    }

    /// Least cost of a shape of the scene.
    fn least_cost(&self) -> LeastCost {
        let prepared = self.scene.prepared();
        if prepared.len() > MOST_MESHES {
            return LeastCost::ANY;
        }
        let of = prepared.iter().filter_map(Prepared::occluder).map(Occluder::least_cost);
        of.fold(LeastCost::default(), LeastCost::or)
    }

    /// Value of screen bounds of `pixels` at most, of which each has no more than `densest`; all of
    /// the screen where it crosses the near plane. `None` is for less than `least`.
    fn value(
        &self,
        bounds: Option<ScreenBounds>,
        pixels: f32,
        densest: f32,
        least: f32,
    ) -> Option<f32> {
        // A product, before the more expensive sums; raised by more than its rounding.
        let most = pixels * densest * (1.0 + 1e-5);
        if most < least {
            return None;
        }
        let value = self.density.of_bounds(bounds).min(most);
        (value >= least).then_some(value)
    }

    /// Returns the [`value`](Self::value) of an instance or a shape itself, by its `bounds`. `None`
    /// is for less than `least`.
    fn value_of(&self, bounds: Option<ScreenBounds>, least: f32) -> Option<f32> {
        let pixels = bounds.map_or(f32::INFINITY, |f| f.pixels());
        self.value(bounds, pixels, self.density.densest(), least)
    }

    /// Returns an upper bound of the [`value`](Self::value) of every shape below `node` of `level`,
    /// 0 to 2. A shape's pixels are limited by the largest box below the node, since a large node
    /// may hold only small boxes. `None` is for less than `least`, and for fewer pixels than
    /// [`LEAST_PIXELS`].
    fn value_below(
        &self,
        bounds: Option<ScreenBounds>,
        level: usize,
        node: usize,
        least: f32,
    ) -> Option<f32> {
        let Some(f) = bounds else { return self.value_of(None, least) };
        let sizes = self.scene.hierarchy().nodes().largest_below(level, node);
        let pixels = self.tests.most_pixels(&f, sizes);
        if pixels < LEAST_PIXELS {
            return None;
        }
        self.value(bounds, pixels, self.density.densest_of(f.min, f.max), least)
    }

    /// Lists the nodes of 4,096 slots.
    fn list_highest(&self, limits: Limits, open: &mut BinaryHeap<Group>) {
        let mut live = groups(self.live).map(|live| live[0] as usize / GROUP).peekable();
        while let Some(first) = live.next() {
            let (block, mut wanted) = (first / LANES, 1 << (first % LANES));
            while let Some(next) = live.next_if(|group| group / LANES == block) {
                wanted |= 1 << (next % LANES);
            }
            self.bounds_of_nodes((2, block), wanted, |number, bounds| {
                open.extend(self.group(2, number, bounds, limits));
            });
        }
    }

    /// Lists the nodes of 256 below one of 4,096.
    fn open(&self, group: usize, limits: Limits, open: &mut BinaryHeap<Group>) {
        let words = self.alive[group * GROUP..].chunks(GROUP / LANES).take(LANES);
        let wanted = words.enumerate().fold(0_u64, |wanted, (n, words)| {
            wanted | u64::from(words.iter().any(|&word| word != 0)) << n
        });
        self.bounds_of_nodes((1, group), wanted, |number, bounds| {
            open.extend(self.group(1, number, bounds, limits));
        });
    }

    /// Calls back with the number and the screen bounds of the nodes of a block of a level that are
    /// wanted, but for those with too few pixels and those outside; `None` is for one that has no
    /// bounds, since it crosses the near plane or was not made for all instances that are there
    /// now.
    fn bounds_of_nodes(
        &self,
        (level, block): (usize, usize),
        wanted: u64,
        mut each: impl FnMut(usize, Option<ScreenBounds>),
    ) {
        let nodes = self.scene.hierarchy().nodes();
        let of_level = nodes.levels().get(level).and_then(|l| l.blocks().get(block));
        let whole = (nodes.len() / LANES.pow(level as u32 + 1)).saturating_sub(block * LANES);
        let known = wanted & of_level.map_or(0, |_| (1 << whole.min(LANES)) - 1);
        bits::ones(wanted & !known).for_each(|n| each(block * LANES + n, None));
        if let Some(of_level) = of_level.filter(|_| known != 0) {
            self.tests.bounds_of_nodes(of_level, known, LEAST_PIXELS, |n, bounds| {
                each(block * LANES + n, bounds);
            });
        }
    }

    /// A node that may hold what may be taken.
    fn group(
        &self,
        level: usize,
        number: usize,
        bounds: Option<ScreenBounds>,
        limits: Limits,
    ) -> Option<Group> {
        let value = self.value_below(bounds, level, number, limits.least_value)?;
        let score = self.costs.score(limits.least_cost, value, self.density.densest());
        (!self.is_hidden(bounds)).then_some(Group { score, level, number: number as u32 })
    }

    /// Whether what was drawn hides all of some screen bounds. Where a node's are hidden, so are
    /// those of all that is below it, so that what is considered does not depend on the nodes.
    fn is_hidden(&self, bounds: Option<ScreenBounds>) -> bool {
        let covers = |b| self.buffer.covers(self.tests.simd(), &b);
        !self.drawn.is_empty() && bounds.is_some_and(covers)
    }

    /// Looks into the sixteen blocks of a node of 256 slots.
    fn look_into(&self, group: usize, limits: Limits, choice: &mut Choice) {
        let alive = |n: usize| {
            let word = self.alive.get(group * 4 + n / 4).copied().unwrap_or(0);
            word >> (n % 4 * LANES) & 0xffff != 0
        };
        let wanted = (0..LANES).fold(0_u64, |wanted, n| wanted | u64::from(alive(n)) << n);
        let none = Group { score: 0.0, level: 0, number: 0 };
        let (mut blocks, mut count) = ([none; LANES], 0);
        // The best first: what they hold rules out the others.
        self.bounds_of_nodes((0, group), wanted, |number, bounds| {
            if let Some(block) = self.group(0, number, bounds, limits) {
                let mut at = count;
                while at > 0 && blocks[at - 1] < block {
                    blocks[at] = blocks[at - 1];
                    at -= 1;
                }
                blocks[at] = block;
                count += 1;
            }
        });
        for block in &blocks[..count] {
            if choice.may_take(block.score) {
                self.look_at(block.number as usize, limits.least_value, choice);
            }
        }
    }

    /// Looks at sixteen instances.
    fn look_at(&self, block: usize, least_value: f32, choice: &mut Choice) {
        let alive = self.alive[block / 4] >> (block % 4 * LANES) & 0xffff;
        let boxes = &self.scene.boxes().blocks()[block];
        self.tests.bounds_of(boxes, alive, LEAST_PIXELS, |lane, bounds| {
            let slot = (block * LANES + lane) as u32;
            if let Some(value) = self.value_of(bounds, least_value)
                && let Some(occluder) = occluder_of(self.scene, self.coarse, slot)
                && !self.fades(slot)
            {
                let least_cost = occluder.least_cost();
                if choice.may_take(self.costs.score(least_cost, value, self.density.densest()))
                    && !self.is_hidden(bounds)
                {
                    self.consider(slot, occluder, bounds, value, least_value, choice);
                }
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

    /// Considers the shapes of an instance that are for a view which begins within what it seals
    /// off, or does not.
    fn consider(
        &self,
        slot: u32,
        occluder: &Occluder,
        bounds: Option<ScreenBounds>,
        most: f32,
        least_value: f32,
        choice: &mut Choice,
    ) {
        let Self { scene, tests, .. } = self;
        let within = is_within(scene, slot, occluder, &self.near);
        let mut consider = |number: usize, bounds: Option<ScreenBounds>| {
            let pixels = bounds.map_or(f32::INFINITY, |f| f.pixels());
            let Some(value) = self.value_of(bounds, least_value) else { return };
            let cost = |pixels: f32| self.costs.cost(occluder.edges()[number], pixels);
            // No more than the instance, by whose pixels it was sought. The shape itself is looked
            // at last: of some instances there are thousands.
            if bounds.is_some() && !choice.may_take(value.min(most) / cost(pixels)) {
                return;
            }
            let shape = &occluder.shapes()[number];
            if !(self.fronts_are_drawn || shape.is_two_sided()) || !occluder.is_for(number, within)
            {
                return;
            }
            // Bounds that cross the near plane have no screen bounds; those of the part beyond
            // estimate them.
            let (pixels, value) = match bounds {
                Some(_) => (pixels, value),
                None => match self.seen_part(slot, shape) {
                    Some([min, max]) => (
                        ScreenBounds { min, max, nearness: 0.0 }.pixels(),
                        self.density.of(min, max),
                    ),
                    None => return,
                },
            };
            let cost = cost(pixels);
            let candidate = Candidate {
                score: value.min(most) / cost,
                nearness: bounds.map_or(f32::INFINITY, |f| f.nearness),
                slot,
                shape: number as u32,
                cost,
                bounds,
            };
            // The most expensive test comes last.
            if choice.may_take(candidate.score)
                && self.drawn.binary_search(&(slot, number as u32)).is_err()
                && !self.is_hidden(bounds)
            {
                choice.consider(candidate);
            }
        };
        if let [_] = occluder.shapes() {
            consider(0, bounds);
            return;
        }
        if occluder.shapes().len() <= FEW_SHAPES {
            // A projection of its own costs more than what it tells.
            let mut block = BoxBlock([[0.0; LANES]; 6]);
            let transform = scene.transform(slot);
            for (lane, shape) in occluder.shapes().iter().enumerate() {
                block.set(lane, &transform.transform_box(&shape.bounds(), scene.origin()));
            }
            let wanted = (1 << occluder.shapes().len()) - 1;
            tests.bounds_of(&block, wanted, LEAST_PIXELS, consider);
            return;
        }
        let tests = tests.for_object(scene.transform(slot));
        for (at, block) in occluder.boxes().blocks().iter().enumerate() {
            let count = occluder.shapes().len().saturating_sub(at * LANES).min(LANES);
            let wanted = (1 << count) - 1;
            tests.bounds_of(block, wanted, LEAST_PIXELS, |lane, b| consider(at * LANES + lane, b));
        }
    }
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
