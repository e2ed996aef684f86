//! Stakes: how much occlusion may cost, and how much it saves.
//!
//! Nobody knows before drawing what is hidden. So little is spent first, a share of what the frame would cost to draw
//! without; then some of what is left is tested, and as long as that shows that much is hidden, a fifth of what it saves is
//! spent on more. A frame in which nothing is hidden is slower by the first share alone, and one that costs next to
//! nothing to draw is left alone.

use super::super::frame::Frame;
use super::super::run::is_parted;
use super::super::sets::Instances;
use crate::bits;
use crate::costs::{Costs, OccluderCosts};
use crate::cull::occlusion::{BoxTests, Occlusion, OcclusionBuffer, Visibility};
use crate::funnel::Counts;

/// Share of what is saved that is spent to save more.
const RETURN: f32 = 0.2;

/// Instances that are tested for what is hidden, and clusters.
const SAMPLES: usize = 64;

/// How much may be spent, in microseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stake {
    /// At the most, whatever is saved.
    limit: f32,
    /// Before anything is known to be hidden.
    first: f32,
    /// Cost of drawing all that is left.
    draw: f32,
}

impl Stake {
    /// Of a frame in which so much is left.
    pub(super) fn new(settings: &Occlusion, costs: &Costs, left: Counts) -> Self {
        let us = |ns: f64, count: u64| (ns * 1e-3) as f32 * count as f32;
        let draw = us(costs.draw_ns, left.instances) + us(costs.opaque_triangle_ns, left.triangles);
        let OccluderCosts { test_ns, begin_ns, .. } = costs.occluders;
        let overhead = us(begin_ns, 1) + us(test_ns, left.instances);
        let first = settings.risk.map_or(f32::INFINITY, |risk| draw * risk - overhead);
        Self { limit: settings.budget, first, draw }
    }

    /// Whether there is nothing to be gained.
    pub(super) fn is_nothing(&self) -> bool {
        self.first <= 0.0
    }

    /// Whether less may be spent than the budget.
    pub(super) fn is_limited(&self) -> bool {
        self.first < self.limit
    }

    /// What may be spent on drawing occluders where such a share is known to be hidden. No more than the limit.
    pub(super) fn budget(&self, hidden: f32) -> f32 {
        // A limit of NaN is none to be spent.
        if self.limit > 0.0 {
            (self.first + self.draw * hidden * RETURN).min(self.limit)
        } else {
            0.0
        }
    }
}

/// The share of what is left, by triangles, that a buffer hides; of some instances, and some of their clusters.
pub(super) fn hidden_share(frame: &Frame<'_>, set: &Instances, buffer: &OcclusionBuffer) -> f32 {
    let scene = frame.scene;
    let tests = BoxTests::new(buffer, frame.culler.level);
    // By handles, so that the order of slots has no say.
    let handles = scene.hierarchy().index_count();
    let slots = (0..handles).step_by(handles.div_ceil(SAMPLES).max(1));
    let slots = slots.filter_map(|index| scene.hierarchy().slot_of_index(index));
    let alive = |slot: &usize| set.alive.get(slot / 64).is_some() && bits::get(&set.alive, *slot);
    let few = slots.clone().filter(alive).count().max(1);
    let (mut hidden, mut all) = (0.0, 0.0);
    for slot in slots.filter(alive) {
        let mesh = scene.mesh(slot as u32);
        let weight = mesh.triangle_count() as f32;
        all += weight;
        let bounds = match tests.bounds(scene.boxes(), slot) {
            Err(Visibility::Outside) => {
                all -= weight;
                continue;
            }
            bounds => bounds.ok(),
        };
        if bounds.is_some_and(|b| buffer.covers(frame.culler.level, &b)) {
            hidden += weight;
        } else if is_parted(mesh) && scene.is_rigid(slot as u32) {
            let against = tests.for_object(scene.transform(slot as u32));
            let (count, clusters) = (mesh.clusters().len(), mesh.cluster_boxes());
            let some = (SAMPLES / few).clamp(1, count);
            let share = weight / some as f32;
            for i in 0..some {
                match against.bounds(clusters, (2 * i + 1) * count / (2 * some)) {
                    Err(Visibility::Outside) => all -= share,
                    Ok(b) if buffer.covers(frame.culler.level, &b) => hidden += share,
                    _ => {}
                }
            }
        }
    }
    if all > 0.0 { hidden / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_spent_on_what_costs_nothing_and_more_where_more_is_saved() {
        let costs = Costs::default();
        let left =
            |instances| Counts { instances, clusters: instances, triangles: instances * 100 };
        let settings = Occlusion { risk: Some(0.025), budget: 500.0, ..Occlusion::default() };
        assert!(Stake::new(&settings, &costs, left(10)).is_nothing());
        let stake = Stake::new(&settings, &costs, left(2000));
        assert!(!stake.is_nothing() && stake.is_limited());
        // 4 ms to draw: 2.5 % of them, without what tests cost.
        assert!((60.0..100.0).contains(&stake.budget(0.0)), "{stake:?}");
        assert_eq!(stake.budget(0.25), stake.budget(0.0) + 200.0);
        assert_eq!(stake.budget(1.0), settings.budget);
        let always = Stake::new(&Occlusion::default(), &costs, left(1));
        assert!(!always.is_nothing() && !always.is_limited());
        assert_eq!(always.budget(0.0), Occlusion::default().budget);
    }
}
