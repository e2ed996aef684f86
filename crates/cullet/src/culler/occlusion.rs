//! The stage that drops what lies behind something.
//!
//! First the footprints of all instances that are left, sixteen at a time; then the largest of them offer their shapes,
//! and what the budget allows is drawn front to back; then everything is asked, by the nodes of the hierarchy
//! first. Which occluders are drawn, and in which order, depends on this frame alone: one that is hidden when its turn
//! comes is left out, so that an order remembered from the last frame could leave out others, and prove
//! something else. What is remembered is memory.

use super::backfaces::split;
use super::run::{Pass, Scratch};
use super::{Culler, Output};
use crate::bits;
use crate::bounds::{Aabb, LANES};
use crate::cull::occlusion::{
    Asker, Candidate, Footprint, Occlusion, OcclusionBuffer, Shape, Verdict, choose,
};
use crate::scene::Scene;
use crate::view::{CullFace, FrontFace, View};
use crate::visible::{OcclusionWork, Reason, Stage, Unit, Visible};

/// What a view keeps of its occlusion buffer.
#[derive(Clone, Debug, Default)]
pub(super) struct OcclusionState {
    pub(super) buffer: Option<OcclusionBuffer>,
    offers: Vec<Offer>,
    candidates: Vec<Candidate>,
    /// Slots and shapes that were drawn.
    pub(super) drawn: Vec<(u32, u32)>,
    /// Of one instance: clusters that are not hidden, or, negated, that are.
    clusters: Vec<u64>,
}

/// An instance that may hide something.
#[derive(Clone, Copy, Debug)]
struct Offer {
    /// Those of the rectangle around it, infinite where it crosses the near plane.
    pixels: f32,
    slot: u32,
    footprint: Option<Footprint>,
}

impl OcclusionState {
    /// Why an instance is hidden or not, in words: which pixel lets it through, or what covers it.
    pub(super) fn finding(&self, culler: &Culler, scene: &Scene, slot: u32) -> String {
        let Some(buffer) = &self.buffer else { return String::new() };
        let [width, height] = buffer.size();
        let asker = Asker::new(buffer, culler.level);
        let footprint = match asker.footprint(scene.boxes(), slot as usize) {
            Ok(footprint) => footprint,
            Err(Verdict::Outside) => return "beyond an edge of the screen".to_owned(),
            Err(_) => {
                return "crosses the near plane, or has no bounds: never hidden".to_owned();
            }
        };
        let Footprint { min: [x0, y0], max: [x1, y1], nearness } = footprint;
        let place = format!(
            "pixels {x0}..={x1} x {y0}..={y1} of {width} x {height}, nearness {nearness:e}"
        );
        match buffer.first_open(&footprint) {
            Some([x, y]) => format!(
                "{place}: pixel ({x}, {y}) lets it through, covered only at {:e}",
                buffer.nearness(x, y)
            ),
            None => format!("{place}: all covered by what is nearer"),
        }
    }

    /// The instances of which something covers a footprint alone or in part, front to back.
    pub(super) fn blockers(
        &self,
        culler: &Culler,
        scene: &Scene,
        view: &View,
        slot: u32,
    ) -> Vec<u32> {
        let (Some(buffer), mut found) = (&self.buffer, Vec::new()) else { return Vec::new() };
        let asker = Asker::new(buffer, culler.level);
        let footprint = asker.footprint(scene.boxes(), slot as usize);
        let Ok(footprint) = footprint else { return found };
        let Ok(mut alone) = OcclusionBuffer::new(buffer.size()) else { return found };
        for &(by, shape) in &self.drawn {
            alone.begin(view, scene.origin());
            draw(
                &mut alone,
                culler,
                scene,
                by,
                &scene.mesh(by).occluder().shapes()[shape as usize],
            );
            let Footprint { min, max, nearness } = footprint;
            let covers = (min[1]..=max[1])
                .any(|y| (min[0]..=max[0]).any(|x| alone.nearness(x, y) > nearness));
            if covers && !found.contains(&by) {
                found.push(by);
            }
        }
        found
    }
}

/// Draws a shape of an instance.
fn draw(buffer: &mut OcclusionBuffer, culler: &Culler, scene: &Scene, slot: u32, shape: &Shape) {
    let transform = scene.transform(slot);
    match shape {
        Shape::Convex(convex) => buffer.draw_convex(culler.level, convex, transform),
        Shape::Patch(patch) => buffer.draw_patch(culler.level, patch, transform),
    }
}

impl Pass<'_> {
    /// Drops instances whose boxes are hidden.
    pub(super) fn occlusion(&mut self, settings: &Occlusion) {
        let entered = self.alive_count();
        if let Some(slot) = self.only {
            self.occlusion_of(slot);
        } else {
            self.occlusion_of_all(settings);
        }
        let left = self.alive_count();
        self.row(Stage::Occlusion, Unit::Instances, entered, left);
    }

    fn occlusion_of_all(&mut self, settings: &Occlusion) {
        let mut state = std::mem::take(&mut self.scratch.occlusion);
        let size = settings.size(self.view.viewport());
        if state.buffer.as_ref().is_none_or(|b| b.size() != size) {
            // Never refused: the size is within the limits.
            state.buffer = OcclusionBuffer::new(size).ok();
        }
        if let Some(mut buffer) = state.buffer.take() {
            buffer.begin(self.view, self.scene.origin());
            self.gather(&buffer, settings, &mut state);
            let offered = state.candidates.len() as u64;
            choose(&mut state.candidates, settings.budget);
            let chosen = state.candidates.len() as u64;
            self.draw(&mut buffer, &mut state);
            let drawn = state.drawn.len() as u64;
            let tests = self.ask(&buffer);
            self.result.funnel.occlusion = OcclusionWork { offered, chosen, drawn, tests };
            state.buffer = Some(buffer);
        }
        self.scratch.occlusion = state;
    }

    /// The shapes that may hide something: those of the largest instances, as many as could be paid for.
    fn gather(
        &mut self,
        buffer: &OcclusionBuffer,
        settings: &Occlusion,
        state: &mut OcclusionState,
    ) {
        let scene = self.scene;
        let asker = Asker::new(buffer, self.culler.level);
        let offers = &mut state.offers;
        offers.clear();
        for &word in &self.scratch.live {
            let alive = self.scratch.alive[word as usize];
            for part in (0..4).filter(|part| alive >> (part * LANES) & 0xffff != 0) {
                let first = word * 64 + (part * LANES) as u32;
                let block = &scene.boxes().blocks()[first as usize / LANES];
                asker.footprints(
                    block,
                    alive >> (part * LANES) & 0xffff,
                    LEAST_PIXELS,
                    |lane, f| {
                        let slot = first + lane as u32;
                        if occludes(scene, slot) {
                            let pixels = f.map_or(f32::INFINITY, |f| f.pixels());
                            offers.push(Offer { pixels, slot, footprint: f });
                        }
                    },
                );
            }
        }
        let most = settings.most_shapes();
        if offers.len() > most {
            offers.select_nth_unstable_by(most, |a, b| {
                b.pixels.total_cmp(&a.pixels).then(a.slot.cmp(&b.slot))
            });
            offers.truncate(most);
        }
        state.candidates.clear();
        let fronts_are_drawn = fronts_are_drawn(self.view);
        let near = near_box(self.view, scene.origin());
        for o in offers {
            let within = is_within(scene, o.slot, &near);
            offer(scene, buffer, o, fronts_are_drawn, within, &mut state.candidates);
        }
    }

    /// Drops what is hidden of all that is left; how many tests it took.
    fn ask(&mut self, buffer: &OcclusionBuffer) -> u64 {
        let scene = self.scene;
        let asker = Asker::new(buffer, self.culler.level);
        let (hierarchy, live) = (scene.hierarchy(), std::mem::take(&mut self.scratch.live));
        let mut tests = 0;
        for words in live.chunk_by(|a, b| a / 64 == b / 64) {
            let group = words[0] as usize / 64;
            let mut asked = [0; 64];
            for &word in words {
                asked[word as usize % 64] =
                    self.scratch.alive[word as usize] & !scene.exempt()[word as usize];
            }
            let before = asked;
            tests += asker.group(hierarchy.nodes(), hierarchy.boxes(), group, &mut asked);
            for &word in words {
                let at = word as usize % 64;
                let dropped = before[at] & !asked[at];
                self.scratch.alive[word as usize] &= !dropped;
                if self.culler.reasons {
                    for bit in bits::ones(dropped) {
                        let slot = word * 64 + bit as u32;
                        self.drop_slot(slot, Reason { stage: Stage::Occlusion, detail: 0 });
                    }
                }
            }
        }
        self.scratch.live = live;
        tests
    }

    /// Drops the clusters of rigid instances that are hidden, behind others or behind their own instance.
    pub(super) fn occlusion_of_clusters(&mut self) {
        let scene = self.scene;
        let mut state = std::mem::take(&mut self.scratch.occlusion);
        let runs = std::mem::take(&mut self.scratch.runs);
        let mut kept = std::mem::take(&mut self.scratch.kept_runs);
        kept.clear();
        let (mut entered, mut left) = (0, 0);
        for runs in runs.chunk_by(|a, b| a.slot == b.slot) {
            let slot = runs[0].slot;
            let before: u32 = runs.iter().map(|run| run.cluster_count).sum();
            entered += u64::from(before);
            let exempt = bits::get(scene.exempt(), slot as usize);
            // One cluster has the box of its instance, which was asked about.
            let asked = scene.mesh(slot).clusters().len() > 1 && !exempt && scene.is_rigid(slot);
            let after = match &state.buffer {
                Some(buffer) if asked => {
                    let (mesh, clusters) = (scene.mesh(slot), &mut state.clusters);
                    clusters.clear();
                    clusters.resize(mesh.clusters().len().div_ceil(64), 0);
                    for run in runs {
                        let first = run.first_cluster as usize;
                        for (word, bits) in
                            bits::words_of(first..first + run.cluster_count as usize)
                        {
                            clusters[word] |= bits;
                        }
                    }
                    let asker = Asker::of_object(buffer, self.culler.level, scene.transform(slot));
                    let tests = asker.hide(mesh.cluster_nodes(), mesh.cluster_boxes(), clusters);
                    self.result.funnel.occlusion.tests += tests;
                    clusters.iter_mut().for_each(|word| *word = !*word);
                    split(runs, clusters, &mut kept)
                }
                _ => {
                    kept.extend_from_slice(runs);
                    before
                }
            };
            left += u64::from(after);
            if after == 0 && before > 0 {
                self.drop_slot(slot, Reason { stage: Stage::Occlusion, detail: 0 });
            }
        }
        self.scratch.runs = kept;
        self.scratch.kept_runs = runs;
        self.scratch.occlusion = state;
        self.row(Stage::Occlusion, Unit::Clusters, entered, left);
    }

    /// Draws the chosen, front to back; one that is hidden by then adds nothing.
    fn draw(&self, buffer: &mut OcclusionBuffer, state: &mut OcclusionState) {
        state.drawn.clear();
        for c in &state.candidates {
            if c.footprint.is_some_and(|f| buffer.is_covering(self.culler.level, &f)) {
                continue;
            }
            let shape = &self.scene.mesh(c.slot).occluder().shapes()[c.shape as usize];
            draw(buffer, self.culler, self.scene, c.slot, shape);
            state.drawn.push((c.slot, c.shape));
        }
    }

    /// One slot alone: what hides it is everything else, so all of the scene is culled to know.
    fn occlusion_of(&mut self, slot: u32) {
        let all =
            Culler { output: Output::Instances, reasons: true, clock: None, ..self.culler.clone() };
        let (mut scratch, mut result) = (Scratch::default(), Visible::default());
        Pass::new(&all, self.scene, self.view, &mut scratch, &mut result).run();
        let hidden = Reason { stage: Stage::Occlusion, detail: 0 };
        if result.reasons[slot as usize] == Some(hidden) {
            self.scratch.alive[slot as usize / 64] &= !(1 << (slot % 64));
            self.drop_slot(slot, hidden);
        }
        self.scratch.occlusion = scratch.occlusion;
        self.result.funnel.occlusion = result.funnel.occlusion;
    }
}

/// Whether the view draws the fronts of one-sided meshes: where it draws their backs alone, as some shadow passes
/// do, their fronts hide nothing.
fn fronts_are_drawn(view: &View) -> bool {
    matches!(
        (view.cull_face, view.front_face),
        (CullFace::None, _)
            | (CullFace::Back, FrontFace::CounterClockwise)
            | (CullFace::Front, FrontFace::Clockwise)
    )
}

/// Smaller ones hide next to nothing.
const LEAST_PIXELS: f32 = 16.0;

/// Whether an instance has shapes that may hide something.
fn occludes(scene: &Scene, slot: u32) -> bool {
    let flags = scene.flags(slot);
    !(flags.no_occlusion || flags.transparent)
        && scene.is_rigid(slot)
        && !scene.mesh(slot).occluder().shapes().is_empty()
}

/// A box around the view's eye and its near rectangle, relative to an origin: what the near plane cuts away
/// hides nothing. Everything, where a corner is not known.
fn near_box(view: &View, origin: [f64; 3]) -> Aabb {
    let Some(corners) = view.frustum().corners() else { return Aabb::EVERYTHING };
    let eye = view.eye();
    let points = corners[..4].iter().chain((eye[3] != 0.0).then_some(&eye));
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for a in 0..3 {
            let v = p[a] / p[3] - origin[a];
            if !v.is_finite() {
                return Aabb::EVERYTHING;
            }
            // Corners are off by their rounding.
            let slack = (p[a].abs() + origin[a].abs()) * 1e-9;
            min[a] = min[a].min(v - slack);
            max[a] = max[a].max(v + slack);
        }
    }
    Aabb::rounded_out(min, max)
}

/// Whether the view may begin within what the occluder of an instance seals off.
fn is_within(scene: &Scene, slot: u32, near: &Aabb) -> bool {
    let sealed = scene.mesh(slot).occluder().sealed().iter();
    sealed.map(|b| scene.transform(slot).transform_box(b, scene.origin())).any(|b| {
        // A NaN is no proof that they are apart.
        !(0..3).any(|a| near.min[a] > b.max[a] || near.max[a] < b.min[a])
    })
}

/// Offers the shapes of an instance that are for a view which begins within what it seals off, or does not.
fn offer(
    scene: &Scene,
    buffer: &OcclusionBuffer,
    &Offer { slot, footprint, .. }: &Offer,
    fronts_are_drawn: bool,
    within: bool,
    candidates: &mut Vec<Candidate>,
) {
    let occluder = scene.mesh(slot).occluder();
    let shapes = occluder.shapes();
    for (number, shape) in shapes.iter().enumerate() {
        if !occluder.is_for(number, within) || !(fronts_are_drawn || shape.is_two_sided()) {
            continue;
        }
        let own = match shapes {
            [_] => footprint,
            _ => buffer.footprint_of(&world_box(scene, slot, shape)),
        };
        let (pixels, nearness) = match own {
            Some(f) => (f.pixels(), f.nearness),
            None if buffer.ask_box(&world_box(scene, slot, shape)) == Verdict::Outside => continue,
            None => (buffer.size().iter().map(|&s| s as f32).product(), f32::INFINITY),
        };
        if pixels >= LEAST_PIXELS {
            let cost = Candidate::cost(shape, pixels);
            let shape = number as u32;
            candidates.push(Candidate { pixels, nearness, slot, shape, cost, footprint: own });
        }
    }
}

/// The box of a shape relative to the scene's origin.
pub(super) fn world_box(scene: &Scene, slot: u32, shape: &Shape) -> Aabb {
    scene.transform(slot).transform_box(&shape.bounds(), scene.origin())
}
