//! A decision for one camera that is told to nobody: nothing is hidden.

use std::collections::HashMap;

use cullet::Stage;
use godot::obj::InstanceId;
use godot::prelude::*;

use super::{Frame, MOST_TRIES, Settings, Stats, culler, mark, plain};
use crate::item::Item;
use crate::look::{Bounds, Kind};
use crate::probes;
use crate::registry::Registry;
use crate::shown::{self, Shown};
use crate::told;
use crate::views::Eye;

/// Whether a node is drawn, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// It may be seen.
    Drawn,
    /// It is drawn whatever happens: a `GridMap`, particles, or a node whose bounds are unknown.
    Always,
    /// It is drawn for a reflection probe that may see it.
    Probe,
    /// This stage left it out.
    Dropped(Stage),
}

impl Fate {
    /// Returns the word that scripts know it by: a stage's own name, or one of three more.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Drawn => "drawn",
            Self::Always => "always",
            Self::Probe => "probe",
            Self::Dropped(stage) => stage.name(),
        }
    }
}

/// A decision: the fate of each node, and how it is drawn for shadows.
#[derive(Debug, Default)]
pub(crate) struct Decision {
    pub(crate) fates: HashMap<InstanceId, (Fate, Shown)>,
    /// Counts, as a frame has them.
    pub(crate) stats: Stats,
}

impl Frame {
    /// Decides for `eye` alone what a frame would hide, by the same steps. Costs what a frame does
    /// after a jump of the camera, and a look-up a node.
    pub(crate) fn decide(
        &mut self,
        registry: &mut Registry,
        settings: Settings,
        eye: Eye,
    ) -> Decision {
        let world = registry.world().unwrap_or(Rid::Invalid);
        let is_all_known = !eye.has_lit_fog && !eye.has_sdfgi;
        self.eyes = vec![eye];
        self.states.resize_with(1, Default::default);
        let again = self.cull_with_reasons(registry, settings);
        let words = registry.mirror.told.here.len();
        for bits in [&mut self.seen, &mut self.casts] {
            bits.clear();
            bits.resize(words, 0);
        }
        let scene = &registry.mirror.scene;
        mark(scene, &self.states[0].1, &mut self.seen);
        let of_camera = self.seen.clone();
        if !probes::collect(&registry.probes, world, &mut self.reach) {
            self.seen.fill(u64::MAX);
        }
        self.reach_states.resize_with(self.reach.len(), Default::default);
        for (view, (state, visible)) in self.reach.iter().zip(&mut self.reach_states) {
            plain().cull_one(scene, view, state, visible);
            mark(scene, visible, &mut self.seen);
        }
        let all_cast = !self.find_casters(registry, settings, world);
        let mut decision = Decision::default();
        let stats = &mut decision.stats;
        (stats.cameras, stats.again, stats.occluders) = (1, again, self.occluders.len());
        stats.dark = match settings.lamps && is_all_known {
            true => registry.count_dark(true, &self.seen),
            false => 0,
        };
        for (index, item) in registry.mirror.items.iter().enumerate() {
            let Some(item) = item else { continue };
            let has = |bits: &[u64]| told::has(bits, index);
            let fate = match (has(&of_camera), has(&self.seen)) {
                _ if item.kind == Kind::Grid => Fate::Always,
                (true, _) if item.look.bounds == Bounds::Unknown => Fate::Always,
                (true, _) => Fate::Drawn,
                (_, true) => Fate::Probe,
                _ => Fate::Dropped(self.stage_of(registry, item)),
            };
            let (is_seen, casts) =
                (!matches!(fate, Fate::Dropped(_)), all_cast || has(&self.casts));
            let to = if is_seen { Shown::Whole } else { shown::unseen(item.look.casts, casts) };
            if item.kind != Kind::Grid {
                stats.instances += 1;
                stats.visible += usize::from(is_seen);
                stats.gone += usize::from(!is_seen && !casts);
                stats.shadow_only += usize::from(!is_seen && casts);
            }
            decision.fates.insert(item.node.instance_id(), (fate, to));
        }
        decision
    }

    /// Culls for the one eye, and once more where an occluder was not what it had been. Returns how
    /// often it was.
    fn cull_with_reasons(&mut self, registry: &mut Registry, settings: Settings) -> usize {
        let mut again = 0;
        loop {
            let is_tried = again < MOST_TRIES;
            let culler = culler(settings.occlusion.filter(|_| is_tried)).with_reasons(true);
            let hides = culler.occlusion.is_some();
            let (state, visible) = &mut self.states[0];
            registry.pvs.update(&mut registry.mirror);
            let (mirror, view) = (&registry.mirror, &self.eyes[0].view);
            let mask = if is_tried { registry.pvs.mask(0, view, mirror) } else { None };
            let among = mask.map(|m| culler.cull_among(&mirror.scene, view, m, state, visible));
            if among.is_none_or(|among| among.is_err()) {
                culler.cull_one(&mirror.scene, view, state, visible);
            }
            self.walls.clear();
            registry.pvs.add_walls(0, &mirror.scene, visible, &mut self.walls);
            self.occluders.clear();
            let drawn = state.occluders_drawn().iter().map(|&(slot, _)| slot);
            self.occluders.extend(drawn.filter(|_| hides));
            if self.occluders_hold(&mut registry.mirror) {
                return again;
            }
            registry.mirror.settle();
            again += 1;
        }
    }

    /// Returns the stage that left an item out.
    fn stage_of(&self, registry: &Registry, item: &Item) -> Stage {
        let slot = item.handle.and_then(|handle| registry.mirror.scene.slot(handle).ok());
        let reasons = &self.states[0].1.reasons;
        let reason = slot.and_then(|slot| *reasons.get(slot as usize)?);
        reason.map_or(Stage::Layer, |reason| reason.stage)
    }
}
