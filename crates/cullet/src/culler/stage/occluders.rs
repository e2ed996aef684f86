//! The search for occluders: by the nodes of the hierarchy, those first that may hold the best.
//!
//! The score of a shape is what may be behind its [pixels](super::density) for what drawing it costs, so no
//! shape below a node has a higher score than the cheapest of the scene would have over all of the node's pixels.
//! Nodes are looked into from the best bound on, and as soon as the budget is used up what cannot be among the
//! chosen is passed over unseen: of a million instances a budget is enough for some hundred. The choice is that of
//! looking at everything.

use std::cmp::Ordering;

use super::density::Density;
use crate::bits;
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::cull::occlusion::{
    BoxTests, Candidate, Choice, CostModel, LeastCost, Occluder, OcclusionBuffer, ScreenBounds,
    Shape,
};
use crate::prepared::Prepared;
use crate::scene::Scene;
use crate::view::View;

/// Smaller ones hide next to nothing.
const LEAST_PIXELS: f32 = 16.0;

/// Of an instance with no more shapes each is boxed in the space of the scene.
const FEW_SHAPES: usize = 6;

/// With more meshes than this it costs more to look up the least cost of each than knowing it saves.
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
    /// The slots and shapes that the buffer has by now, ascending. What is hidden behind them is passed over.
    pub(super) drawn: &'a [(u32, u32)],
    /// Value of pixels.
    pub(super) density: &'a Density,
    pub(super) view: &'a View,
}

/// A node of 256 or 16 slots, and the highest score that a shape in it may have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    score: f32,
    number: u32,
}

impl Group {
    /// The better one first.
    fn rank(&self, other: &Self) -> Ordering {
        other.score.total_cmp(&self.score).then_with(|| self.number.cmp(&other.number))
    }
}

impl Search<'_> {
    /// Fills `choice`; `groups` is memory.
    pub(super) fn run(&self, groups: &mut Vec<Group>, choice: &mut Choice) {
        let least_cost = self.least_cost();
        self.list_groups(least_cost, groups);
        groups.sort_unstable_by(Group::rank);
        // Of the least value that may be taken, by what nodes and instances are refused.
        let (mut least_score, mut least_value) = (0.0, 0.0);
        for group in groups.iter() {
            if !choice.may_take(group.score) {
                break;
            }
            if choice.least_score() != least_score {
                least_score = choice.least_score();
                least_value =
                    self.costs.least_value(least_cost, least_score, self.density.densest());
            }
            self.look_into(group.number as usize, least_cost, least_value, choice);
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

    /// Value of screen bounds of `pixels` at most, of which each has no more than `densest`; all of the screen
    /// where it crosses the near plane. `None` is for less than `least`.
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

    /// As [`value`](Self::value), of an instance or a shape itself.
    fn value_of(&self, bounds: Option<ScreenBounds>, least: f32) -> Option<f32> {
        let pixels = bounds.map_or(f32::INFINITY, |f| f.pixels());
        self.value(bounds, pixels, self.density.densest(), least)
    }

    /// As [`value`](Self::value), of what is below a node of a level, 0 or 1: however large the node is, all that it
    /// holds may be small.
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

    fn list_groups(&self, least_cost: LeastCost, groups: &mut Vec<Group>) {
        groups.clear();
        let nodes = self.scene.hierarchy().nodes();
        for words in self.live.chunk_by(|a, b| a / 64 == b / 64) {
            let at = words[0] as usize / 64;
            let wanted = words.iter().fold(0_u64, |wanted, w| wanted | 1 << (w % 64 / 4));
            let block = nodes.levels().get(1).and_then(|l| l.blocks().get(at));
            // Instances added since the nodes were made are under none.
            let under = bits::ones(wanted).filter(|n| (at * LANES + n + 1) * 256 <= nodes.len());
            let known = under.fold(0_u64, |known, n| known | 1 << n);
            let mut list = |n: usize, bounds| {
                let number = at * LANES + n;
                if let Some(value) = self.value_below(bounds, 1, number, 0.0)
                    && !self.is_hidden(bounds)
                {
                    let score = self.costs.score(least_cost, value, self.density.densest());
                    groups.push(Group { score, number: number as u32 });
                }
            };
            match block {
                Some(block) => {
                    bits::ones(wanted & !known).for_each(|n| list(n, None));
                    self.tests.bounds_of_nodes(block, known, LEAST_PIXELS, list);
                }
                None => bits::ones(wanted).for_each(|n| list(n, None)),
            }
        }
    }

    /// Whether what was drawn hides all of some screen bounds. Where a node's are hidden, so are those of all that is
    /// below it, so that what is considered does not depend on the nodes.
    fn is_hidden(&self, bounds: Option<ScreenBounds>) -> bool {
        let covers = |b| self.buffer.covers(self.tests.level(), &b);
        !self.drawn.is_empty() && bounds.is_some_and(covers)
    }

    /// Looks into the sixteen blocks of a group.
    fn look_into(
        &self,
        group: usize,
        least_cost: LeastCost,
        least_value: f32,
        choice: &mut Choice,
    ) {
        let nodes = self.scene.hierarchy().nodes();
        let (mut wanted, mut known) = (0_u64, 0_u64);
        for n in 0..LANES {
            let word = group * 4 + n / 4;
            let alive = self.alive.get(word).copied().unwrap_or(0);
            if alive >> (n % 4 * LANES) & 0xffff != 0 {
                wanted |= 1 << n;
                known |= u64::from(((group * LANES) + n + 1) * LANES <= nodes.len()) << n;
            }
        }
        let (mut blocks, mut count) = ([Group { score: 0.0, number: 0 }; LANES], 0);
        let mut look = |n: usize, bounds| {
            let node = group * LANES + n;
            if let Some(value) = self.value_below(bounds, 0, node, least_value)
                && !self.is_hidden(bounds)
            {
                let score = self.costs.score(least_cost, value, self.density.densest());
                blocks[count] = Group { score, number: node as u32 };
                count += 1;
            }
        };
        match nodes.levels().first().and_then(|l| l.blocks().get(group)) {
            Some(block) => {
                bits::ones(wanted & !known).for_each(|n| look(n, None));
                self.tests.bounds_of_nodes(block, known, LEAST_PIXELS, look);
            }
            None => bits::ones(wanted).for_each(|n| look(n, None)),
        }
        // The best first: what they hold rules out the others.
        let blocks = &mut blocks[..count];
        blocks.sort_unstable_by(Group::rank);
        for block in blocks {
            if choice.may_take(block.score) {
                self.look_at(block.number as usize, least_value, choice);
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
                && let Some(occluder) = occluder_of(self.scene, slot)
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

    /// The pixels of that part of a shape's box that lies beyond the near plane; `None` where there are none.
    fn seen_part(&self, slot: u32, shape: &Shape) -> Option<[[u32; 2]; 2]> {
        let scene = self.scene;
        let b = scene.transform(slot).transform_box(&shape.bounds(), scene.origin());
        let [min, max] = self.view.part_of_box(&b, scene.origin())?;
        let size = self.buffer.size();
        let pixel = |v: f64, a: usize| {
            let v = v * f64::from(size[a]);
            v.clamp(0.0, f64::from(size[a] - 1)) as u32
        };
        Some([min, max].map(|p| std::array::from_fn(|a| pixel(p[a], a))))
    }

    /// Considers the shapes of an instance that are for a view which begins within what it seals off, or does not.
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
            // No more than the instance, by whose pixels it was sought. The shape itself is looked at last: of some
            // instances there are thousands.
            if bounds.is_some() && !choice.may_take(value.min(most) / cost(pixels)) {
                return;
            }
            let shape = &occluder.shapes()[number];
            if !(self.fronts_are_drawn || shape.is_two_sided()) || !occluder.is_for(number, within)
            {
                return;
            }
            // Bounds that cross the near plane have no screen bounds; those of the part beyond estimate them.
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
            let candidate = Candidate {
                value: value.min(most),
                nearness: bounds.map_or(f32::INFINITY, |f| f.nearness),
                slot,
                shape: number as u32,
                cost: cost(pixels),
                bounds,
            };
            // The most expensive test comes last.
            if choice.may_take(candidate.score())
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
fn occluder_of(scene: &Scene, slot: u32) -> Option<&Occluder> {
    let flags = scene.flags(slot);
    if flags.no_occlusion || flags.transparent || !scene.is_rigid(slot) {
        return None;
    }
    scene.prepared_of(slot).occluder().filter(|occluder| !occluder.shapes().is_empty())
}

/// Whether the view may begin within what the occluder of an instance seals off.
fn is_within(scene: &Scene, slot: u32, occluder: &Occluder, near: &Aabb) -> bool {
    let sealed = occluder.sealed().iter();
    sealed.map(|b| scene.transform(slot).transform_box(b, scene.origin())).any(|b| {
        // A NaN is no proof that they are apart.
        !(0..3).any(|a| near.min[a] > b.max[a] || near.max[a] < b.min[a])
    })
}
