//! A frame: culls for all cameras, and tells Godot's server what changed.

use std::time::Instant;

use cullet::cull::occlusion::Occlusion;
use cullet::{Backface, Culler, Output, Scene, ShadowView, View, ViewState, Visible};
use godot::classes::RenderingServer;
use godot::obj::Singleton;
use godot::prelude::*;

use crate::lights::{Lights, Receivers};
use crate::mirror::{Mirror, item_and_part};
use crate::probes;
use crate::pvs::live::Counts;
use crate::registry::Registry;
use crate::shown::{self, Shown};
use crate::told;
use crate::views::{self, Eye};

mod decide;
pub(crate) use decide::Fate;

/// Settings of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Pixels across the occlusion buffer and its budget; none for the frustum alone.
    pub(crate) occlusion: Option<(u32, f32)>,
    /// Whether casters are hidden whose shadow no camera sees.
    pub(crate) casters: bool,
    pub(crate) receivers: Receivers,
    /// Whether baked visibility is used.
    pub(crate) pvs: bool,
    /// Whether lamps are hidden that light nothing seen.
    pub(crate) lamps: bool,
}

/// Counts and times of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stats {
    pub(crate) instances: usize,
    pub(crate) cameras: usize,
    pub(crate) visible: usize,
    /// Drawn into shadow maps alone.
    pub(crate) shadow_only: usize,
    pub(crate) gone: usize,
    pub(crate) changed: usize,
    pub(crate) occluders: usize,
    /// Lamps that light nothing seen.
    pub(crate) dark: usize,
    /// Counts of baked visibility.
    pub(crate) pvs: Counts,
    /// Times that occluders were found to be others than they were, and culled again.
    pub(crate) again: usize,
    /// Microseconds: following, culling, casters, telling the server.
    pub(crate) us: [f64; 4],
}

/// State between frames.
#[derive(Default)]
pub(crate) struct Frame {
    eyes: Vec<Eye>,
    states: Vec<(ViewState, Visible)>,
    reach: Vec<View>,
    reach_states: Vec<(ViewState, Visible)>,
    lights: Lights,
    shadows: Vec<ShadowView>,
    shadow_states: Vec<(ViewState, Visible)>,
    // One bit an item.
    seen: Vec<u64>,
    casts: Vec<u64>,
    occluders: Vec<u32>,
    // Slots behind which baked sets hide something.
    walls: Vec<u32>,
    pub(crate) stats: Stats,
}

/// Frames in which occluders keep changing under our hands are culled so often, then without them.
const MOST_TRIES: usize = 4;

impl Frame {
    /// Culls, and hides and shows what follows from it.
    pub(crate) fn run(&mut self, registry: &mut Registry, settings: Settings, us_follow: f64) {
        let mut clock = Clock(Instant::now());
        let world = registry.world().unwrap_or(Rid::Invalid);
        let words = registry.mirror.told.here.len();
        for bits in [&mut self.seen, &mut self.casts] {
            bits.clear();
            bits.resize(words, 0);
        }
        let (mut again, mut us) = (0, [us_follow, 0.0, 0.0, 0.0]);
        loop {
            let is_tried = again < MOST_TRIES;
            let occlusion = settings.occlusion.filter(|_| is_tried);
            let pvs = settings.pvs && is_tried;
            if self.look(registry, Settings { occlusion, pvs, ..settings }, world) {
                break;
            }
            // What hides was brought up to date: once more.
            registry.mirror.settle();
            again += 1;
        }
        us[1] = clock.lap();
        let all_cast = !self.find_casters(registry, settings, world);
        let is_all_seen = self.eyes.iter().all(|eye| !eye.has_lit_fog && !eye.has_sdfgi);
        registry.darken(settings.lamps && is_all_seen && !self.eyes.is_empty(), &self.seen);
        us[2] = clock.lap();
        let changed = self.tell(&mut registry.mirror, all_cast);
        us[3] = clock.lap();
        let told = &registry.mirror.told;
        let (unseen, gone) = (told::count(&told.unseen), told::count(&told.gone));
        let instances = told::count(&told.here);
        self.stats = Stats {
            instances,
            cameras: self.eyes.len(),
            visible: instances - unseen,
            shadow_only: unseen - gone,
            gone,
            changed,
            occluders: self.occluders.len(),
            dark: registry.dark.len(),
            pvs: registry.pvs.counts(),
            again,
            us,
        };
    }

    /// Returns the answers of the cameras, in the order of the viewports.
    pub(crate) fn answers(&self) -> impl Iterator<Item = (&Eye, &Visible)> {
        self.eyes.iter().zip(self.states.iter().map(|(_, visible)| visible))
    }

    /// Fills `seen`. Returns false where something that hid others was not what it had been.
    fn look(&mut self, registry: &mut Registry, settings: Settings, world: Rid) -> bool {
        let is_known = views::collect(&registry.viewports, world, &mut self.eyes)
            & probes::collect(&registry.probes, world, &mut self.reach);
        self.states.resize_with(self.eyes.len(), Default::default);
        self.occluders.clear();
        self.walls.clear();
        registry.pvs.update(&mut registry.mirror);
        // Without a camera nothing is drawn, and nothing need be told; without knowing what one
        // sees, everything is.
        if !is_known || self.eyes.is_empty() {
            self.seen.fill(u64::MAX);
            return true;
        }
        let culler = culler(settings.occlusion);
        let (mirror, pvs) = (&registry.mirror, &mut registry.pvs);
        let scene = &mirror.scene;
        let eyes = self.eyes.iter().zip(&mut self.states).enumerate();
        for (number, (eye, (state, visible))) in eyes {
            let mask = if settings.pvs { pvs.mask(number, &eye.view, mirror) } else { None };
            let among = mask.map(|mask| culler.cull_among(scene, &eye.view, mask, state, visible));
            if among.is_none_or(|among| among.is_err()) {
                culler.cull_one(scene, &eye.view, state, visible);
            }
            pvs.add_walls(number, scene, visible, &mut self.walls);
            let drawn = state.occluders_drawn().iter().map(|&(slot, _)| slot);
            self.occluders.extend(drawn.filter(|_| culler.occlusion.is_some()));
        }
        if !self.occluders_hold(&mut registry.mirror) {
            return false;
        }
        let scene = &registry.mirror.scene;
        self.states.iter().for_each(|(_, visible)| mark(scene, visible, &mut self.seen));
        let plain = plain();
        self.reach_states.resize_with(self.reach.len(), Default::default);
        for (view, (state, visible)) in self.reach.iter().zip(&mut self.reach_states) {
            plain.cull_one(scene, view, state, visible);
            mark(scene, visible, &mut self.seen);
        }
        true
    }

    /// Asks the nodes that hid others whether they are what they were. Those that are not are brought up to date, and false is returned.
    fn occluders_hold(&mut self, mirror: &mut Mirror) -> bool {
        self.occluders.sort_unstable();
        self.occluders.dedup();
        let mut stale = Vec::new();
        self.walls.sort_unstable();
        let is_asked = |slot: &&u32| self.occluders.binary_search(slot).is_err();
        for &slot in self.occluders.iter().chain(self.walls.iter().filter(is_asked)) {
            if !mirror.still_hides(slot) {
                stale.push(item_and_part(mirror.scene.user_data(slot)).0);
            }
        }
        stale.dedup();
        stale.iter().for_each(|&index| mirror.renew(index));
        stale.is_empty()
    }

    /// Fills `casts`. Returns false where all cast.
    fn find_casters(&mut self, registry: &Registry, settings: Settings, world: Rid) -> bool {
        self.lights.collect(&registry.lights, world);
        if !settings.casters || self.lights.keeps_all || !registry.may_drop_casters() {
            return false;
        }
        let scene = &registry.mirror.scene;
        let foreign = registry.has_foreign();
        let receivers = if foreign { Receivers::Anywhere } else { settings.receivers };
        let (lights, shadows) = (&self.lights, &mut self.shadows);
        shadows.clear();
        let eyes = self.eyes.iter().zip(&self.states);
        let mut each =
            eyes.map(|(eye, (_, visible))| lights.shadows(scene, eye, visible, receivers, shadows));
        if !each.all(|is_known| is_known) {
            return false;
        }
        let plain = plain();
        self.shadow_states.resize_with(shadows.len() + lights.lamps.len(), Default::default);
        let (of_suns, of_lamps) = self.shadow_states.split_at_mut(shadows.len());
        for (shadow, (state, visible)) in shadows.iter().zip(of_suns) {
            plain.cull_shadow(scene, shadow, state, visible);
            mark(scene, visible, &mut self.casts);
        }
        for (view, (state, visible)) in lights.lamps.iter().zip(of_lamps) {
            plain.cull_one(scene, view, state, visible);
            mark(scene, visible, &mut self.casts);
        }
        true
    }

    /// Tells the server what changed. Returns of how many nodes.
    fn tell(&mut self, mirror: &mut Mirror, all_cast: bool) -> usize {
        let mut server = RenderingServer::singleton();
        let mut changed = 0;
        let (items, told) = (&mut mirror.items, &mut mirror.told);
        for (word, (&seen, &casts)) in self.seen.iter().zip(&self.casts).enumerate() {
            let casts = if all_cast { u64::MAX } else { casts };
            told::each(word, told.change(word, !seen, !seen & !casts), |index| {
                let Some(item) = items.get_mut(index).and_then(Option::as_mut) else { return };
                let Some(drawn) = &item.drawn else { return };
                let bit = 1_u64 << (index % 64);
                let to = match seen & bit != 0 {
                    true => Shown::Whole,
                    false => shown::unseen(item.look.casts, casts & bit != 0),
                };
                changed += usize::from(to != item.shown);
                shown::tell(&mut server, item.rid, &drawn.node, item.shown, to);
                item.shown = to;
            });
        }
        changed
    }
}

/// Returns the engine's settings without occlusion.
fn plain() -> Culler {
    culler(None)
}

/// Returns the engine's settings: whole nodes, and all that can be proved within the budget.
pub(crate) fn culler(occlusion: Option<(u32, f32)>) -> Culler {
    let occlusion = occlusion.map(|(width, budget)| {
        Occlusion::default().with_width(width).with_budget(budget).with_risk(None)
    });
    Culler::default()
        .with_portal(false)
        .with_backface(Backface::Off)
        .with_degenerate(false)
        .with_output(Output::Instances)
        .with_occlusion(occlusion)
}

/// Sets the bits of the items of which anything is in `visible`.
fn mark(scene: &Scene, visible: &Visible, bits: &mut [u64]) {
    for slot in visible.slots() {
        let (index, part) = item_and_part(scene.user_data(slot));
        // Parts hide; whether they are drawn, their node says.
        if part == 0 {
            told::set(bits, index, true);
        }
    }
}

/// A clock of laps, in microseconds.
struct Clock(Instant);

impl Clock {
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let us = (now - std::mem::replace(&mut self.0, now)).as_secs_f64() * 1e6;
        self.0 = now;
        us
    }
}
