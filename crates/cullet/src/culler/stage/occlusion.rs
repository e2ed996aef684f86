//! Occlusion: what lies behind something.
//!
//! The occluders with the highest score are sought, by the nodes of the hierarchy, and drawn front
//! to back, a part of the budget at a time; the search goes on where it stopped and passes over
//! shapes that are hidden by then. Then everything is tested, by the nodes first: a hidden node
//! answers for all instances in it, and so does one in front of everything that was drawn. Which
//! occluders are drawn, and in which order, depends on this frame alone: the cost of the drawn ones
//! decides how much of the budget is left, so that an order remembered from the last frame could
//! choose others, and prove something else. Only memory is kept between frames.

use alloc::vec::Vec;

use super::super::evidence::{CoverTest, Evidence};
use super::super::frame::{Alone, Frame};
use super::super::log::Log;
use super::super::run::{Run, is_parted};
use super::super::sets::{Clusters, Coarse, Instances};
use super::density::Density;
use super::occluders::{Frontier, Search, least_cost};
use super::samples::Samples;
use super::stake::Stake;
use super::{bands, hidden};
use crate::bits;
use crate::bounds::Aabb;
use crate::cull::occlusion::{
    BoxTests, Candidate, CostModel, LeastCost, Nearest, Occlusion, OcclusionBuffer, ScreenBounds,
    Visibility,
};
use crate::funnel::{OcclusionTimes, OcclusionWork, Stage};
use crate::scene::{MeshId, Tally};
use crate::sort::Sorter;
use crate::view::View;

/// How often at the most it is looked whether more may be spent than the stake.
const ROUNDS: u32 = 4;

/// Share of the budget that is drawn before what waits is tested against it.
const BATCH: f32 = 0.125;

/// Work of a cull, in microseconds of the cost model, from which on threads are woken for the next
/// one.
const LEAST_WORK: f32 = 20.0;

/// A view's occlusion buffer, and memory.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    buffer: Option<OcclusionBuffer>,
    /// The last cull found that occlusion would not pay: the buffer is of another.
    is_left_out: bool,
    frontier: Frontier,
    /// Shapes that are drawn next, and which of them turned out to be hidden by then.
    chosen: Vec<Candidate>,
    hidden: Vec<bool>,
    /// Work of the last cull, in microseconds of the cost model.
    work: f32,
    samples: Samples,
    density: Density,
    nearest: Nearest,
    /// One bit a slot, of those words that were alive: no part of it can be hidden. See
    /// [`BoxTests::group`].
    whole: Vec<u64>,
    /// Slots and shapes that were drawn.
    pub(in super::super) drawn: Vec<(u32, u32)>,
    sorter: Sorter,
}

impl Cache {
    /// The buffer of the last cull that drew one; `None` where it would not have paid.
    pub(in super::super) fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.buffer.as_ref().filter(|_| !self.is_left_out)
    }

    /// Whether the last cull had enough to do for threads to be woken.
    pub(in super::super) fn was_long(&self) -> bool {
        self.work >= LEAST_WORK
    }

    /// Whether the instance of a slot was drawn into the buffer of the last cull.
    pub(super) fn has_drawn(&self, slot: u32) -> bool {
        !self.is_left_out && self.drawn.iter().any(|&(by, _)| by == slot)
    }

    /// Returns why an instance is hidden or not: which pixel lets it through, or what covers it.
    pub(in super::super) fn evidence(&self, frame: &Frame<'_>, slot: u32) -> Evidence {
        let Some(buffer) = self.buffer() else { return Evidence::Cost };
        let tests = BoxTests::new(buffer, frame.culler.simd);
        let bounds = match tests.bounds(frame.scene.boxes(), slot as usize) {
            Ok(bounds) => bounds,
            Err(Visibility::Outside) => return Evidence::OffScreen,
            Err(_) => return Evidence::NearPlane,
        };
        let ScreenBounds { min, max, nearness } = bounds;
        let open = buffer.first_open(&bounds);
        let pixels = (min[1]..=max[1]).flat_map(|y| (min[0]..=max[0]).map(move |x| [x, y]));
        let covered = pixels.map(|[x, y]| buffer.nearness(x, y)).fold(f32::INFINITY, f32::min);
        Evidence::Cover(CoverTest { buffer: buffer.size(), min, max, nearness, covered, open })
    }

    /// The instances that cover the screen bounds of an instance, alone or in part, front to back.
    pub(in super::super) fn blockers(&self, frame: &Frame<'_>, slot: u32) -> Vec<u32> {
        let Frame { culler, scene, view, .. } = *frame;
        let (Some(buffer), mut found) = (self.buffer(), Vec::new()) else { return Vec::new() };
        let tests = BoxTests::new(buffer, culler.simd);
        let Ok(bounds) = tests.bounds(scene.boxes(), slot as usize) else { return found };
        let Ok(mut alone) = OcclusionBuffer::new(buffer.size()) else { return found };
        for &(by, shape) in &self.drawn {
            alone.begin(view, scene.origin());
            let shape = &scene.prepared_of(by).shapes()[shape as usize];
            shape.draw(culler.simd, &mut alone, scene.transform(by));
            let ScreenBounds { min, max, nearness } = bounds;
            let covers = (min[1]..=max[1])
                .any(|y| (min[0]..=max[0]).any(|x| alone.nearness(x, y) > nearness));
            if covers && !found.contains(&by) {
                found.push(by);
            }
        }
        found
    }
}

/// Drops instances whose boxes are hidden.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    coarse: &mut Coarse,
    log: &mut Log<'_>,
) {
    let Some(settings) = frame.culler.occlusion else { return };
    let mut dropped = match frame.only {
        Some(only) => test_alone(frame, set, log, only),
        None => test_all(frame, cache, (set, coarse), log, &settings),
    };
    // Of instances that are drawn by levels, only the levels are dropped.
    let (drawn, replaced) = (coarse.drawn(), coarse.replaced());
    coarse.drop_slots(|slot| !set.has(slot));
    dropped += drawn;
    dropped += coarse.replaced();
    dropped -= replaced;
    dropped -= coarse.drawn();
    log.instance_row(Stage::Occlusion, dropped);
}

fn test_all(
    frame: &Frame<'_>,
    cache: &mut Cache,
    (set, coarse): (&mut Instances, &Coarse),
    log: &mut Log<'_>,
    settings: &Occlusion,
) -> Tally {
    let left = log.left.counts;
    // Samples take time themselves: not where all that is left would pay for nothing.
    let costs = &frame.culler.costs;
    let instances = left.instances as f64;
    let all = [instances, left.triangles as f64];
    let mut stake = Stake::new(settings, costs, all, [costs.occluders.begin_ns, 0.0]);
    if !stake.is_nothing() {
        let samples = &mut cache.samples;
        samples.take(frame, (set, coarse), left);
        let overheads = samples.overheads_ns(&costs.occluders, instances);
        stake = Stake::new(settings, costs, [instances, samples.triangles()], overheads);
    }
    cache.is_left_out = stake.is_nothing();
    cache.work = 0.0;
    if cache.is_left_out {
        cache.drawn.clear();
        return Tally::default();
    }
    let size = settings.size(frame.view.viewport());
    if cache.buffer.as_ref().is_none_or(|b| b.size() != size) {
        // Never refused: the size is within the limits.
        cache.buffer = OcclusionBuffer::new(size).ok();
    }
    let Some(mut buffer) = cache.buffer.take() else { return Tally::default() };
    buffer.begin(frame.view, frame.scene.origin());
    let (mut work, hidden) = choose_and_draw(frame, cache, (set, coarse), log, stake, &mut buffer);
    let begin = log.now();
    let mut dropped = Tally::default();
    if stake.pays_for_tests(hidden) {
        (work.tests, dropped) = test(frame, cache, set, log, &buffer);
    } else {
        cache.is_left_out = true;
    }
    if let Some(times) = &mut work.times {
        times.testing = log.now().saturating_sub(begin);
    }
    log.occlusion = work;
    cache.buffer = Some(buffer);
    dropped
}

/// Chooses occluders and draws them, batch by batch, until the budget is used up or nothing is left
/// to choose. Shapes that are hidden by then are not drawn and cost nothing of the budget. Returns
/// the work, and the share of the frame that is likely to be hidden; 1 where that does not matter.
fn choose_and_draw(
    frame: &Frame<'_>,
    cache: &mut Cache,
    left: (&Instances, &Coarse),
    log: &Log<'_>,
    stake: Stake,
    buffer: &mut OcclusionBuffer,
) -> (OcclusionWork, f32) {
    let (mut work, mut times) = (OcclusionWork::default(), OcclusionTimes::default());
    cache.drawn.clear();
    let mut hidden = if stake.is_limited() { 0.0 } else { 1.0 };
    let mut budget = stake.budget(0.0);
    if budget <= 0.0 {
        return (work, hidden);
    }
    let mut begin = log.now();
    let simd = frame.culler.simd;
    cache.density.sample(
        frame.scene,
        &BoxTests::new(buffer, simd),
        buffer.size(),
        cache.samples.slots(),
    );
    let least_cost = least_cost(frame.scene);
    search(frame, &cache.density, left, buffer, least_cost).begin(&mut cache.frontier);
    let (mut spent, mut since, mut rounds) = (0.0, 0.0, ROUNDS);
    loop {
        let Cache { density, frontier, chosen, .. } = cache;
        let [batch, most] = [budget * BATCH, budget - spent];
        let search = search(frame, density, left, buffer, least_cost);
        search.sweep(frame.jobs, frontier);
        let is_more = search.take(frontier, [batch, most], chosen);
        work.chosen += chosen.len() as u64;
        let chose = log.now();
        spent += draw_chosen(frame, cache, buffer);
        let drew = log.now();
        times.choosing += chose.saturating_sub(begin);
        times.drawing += drew.saturating_sub(chose);
        begin = drew;
        if is_more && !cache.chosen.is_empty() {
            cache.frontier.note_drawn();
            continue;
        }
        if !stake.is_limited() {
            break;
        }
        let before = core::mem::replace(&mut hidden, cache.samples.hidden_share(frame, buffer));
        rounds -= 1;
        let raised = stake.budget(hidden);
        // As long as what it finds is worth it.
        let pays = stake.saved(hidden - before) > spent - since;
        if !(is_more && pays && raised > budget) || rounds == 0 {
            break;
        }
        (budget, since) = (raised, spent);
    }
    work.considered = cache.frontier.considered();
    work.drawn = cache.drawn.len() as u64;
    cache.work =
        spent + work.considered as f32 * (frame.culler.costs.occluders.look_ns * 1e-3) as f32;
    work.times = log.has_clock().then_some(times);
    (work, hidden)
}

/// Search of a frame for occluders that `buffer` does not hide.
fn search<'a>(
    frame: &'a Frame<'_>,
    density: &'a Density,
    (set, coarse): (&'a Instances, &'a Coarse),
    buffer: &'a OcclusionBuffer,
    least_cost: LeastCost,
) -> Search<'a> {
    Search {
        scene: frame.scene,
        buffer,
        tests: BoxTests::new(buffer, frame.culler.simd),
        costs: CostModel::new(&frame.culler.costs.occluders),
        least_cost,
        fronts_are_drawn: frame.view.draws_fronts(),
        near: near_box(frame.view, frame.scene.origin()),
        alive: &set.alive,
        live: &set.live,
        coarse,
        density,
        view: frame.view,
        fade: frame.culler.detail_settings().filter(|detail| detail.fade > 0.0),
    }
}

/// Draws the chosen, front to back; one that is hidden by then adds nothing. Its answer is what
/// those drawn cost.
fn draw_chosen(frame: &Frame<'_>, cache: &mut Cache, buffer: &mut OcclusionBuffer) -> f32 {
    cache.sorter.sort(&mut cache.chosen, Candidate::by_nearness);
    bands::draw(frame, &cache.chosen, buffer, &mut cache.hidden);
    let mut cost = 0.0;
    for (c, _) in cache.chosen.iter().zip(&cache.hidden).filter(|(_, hidden)| !**hidden) {
        cache.drawn.push((c.slot, c.shape));
        cost += c.cost;
    }
    cost
}

/// Drops what is hidden of all that is left; how many tests it took, and what those dropped hold.
fn test(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    log: &mut Log<'_>,
    buffer: &OcclusionBuffer,
) -> (u64, Tally) {
    let mut against = BoxTests::new(buffer, frame.culler.simd);
    // Boxes that are empty are outside, though not by their nodes; the frustum drops them, where it
    // is on.
    if frame.culler.frustum {
        cache.nearest.read(frame.culler.simd, buffer);
        against = against.with_nearest(&cache.nearest);
    }
    hidden::test(frame, &against, set, &mut cache.whole, log, buffer)
}

/// Drops one instance alone, if it was dropped from among all: then the cache, which is that of the
/// whole scene, says what hides it.
fn test_alone(
    frame: &Frame<'_>,
    set: &mut Instances,
    log: &mut Log<'_>,
    Alone { slot, all }: Alone<'_>,
) -> Tally {
    log.occlusion = all.funnel.occlusion;
    if !set.has(slot) || all.reasons[slot as usize] != Some(hidden::HIDDEN) {
        return Tally::default();
    }
    bits::set(&mut set.alive, slot as usize, false);
    log.drop_slot(slot, hidden::HIDDEN);
    frame.scene.tally_of(slot)
}

/// Drops the clusters of rigid instances that are hidden, behind others or behind their own
/// instance.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    cache: &Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    let scene = frame.scene;
    let mut tests = 0;
    set.filter(scene, Stage::Occlusion, log, |runs, culled| {
        let slot = runs[0].slot;
        let buffer =
            cache.buffer().filter(|_| may_hide_clusters_of(frame, cache, slot, runs[0].mesh));
        let Some(buffer) = buffer else { return false };
        let mesh = &scene.meshes()[runs[0].mesh as usize];
        set_clusters(runs, mesh.clusters().len(), culled);
        let against = BoxTests::of_object(buffer, frame.culler.simd, scene.transform(slot));
        tests += against.hide(mesh.cluster_nodes(), mesh.cluster_boxes(), culled);
        // Clusters that are not hidden are left.
        culled.iter_mut().for_each(|word| *word = !*word);
        true
    });
    log.occlusion.tests += tests;
}

/// Returns one bit for each slot of `word`: its instance is known to have no cluster that is hidden
/// by itself. All bits are set where the stage is off or was left out.
pub(super) fn unhidden(frame: &Frame<'_>, cache: &Cache, word: usize) -> u64 {
    match frame.culler.occlusion.filter(|_| !cache.is_left_out) {
        Some(_) => cache.whole.get(word).copied().unwrap_or(0),
        None => u64::MAX,
    }
}

/// Sets the bits of the clusters of runs, among `count`.
fn set_clusters(runs: &[Run], count: usize, clusters: &mut Vec<u64>) {
    clusters.clear();
    clusters.resize(count.div_ceil(64), 0);
    for run in runs {
        let first = run.first_cluster as usize;
        for (word, bits) in bits::words_of(first..first + run.cluster_count as usize) {
            clusters[word] |= bits;
        }
    }
}

/// Whether some cluster of an instance may be hidden by itself.
pub(super) fn may_hide_clusters(frame: &Frame<'_>, cache: &Cache, slot: u32) -> bool {
    may_hide_clusters_of(frame, cache, slot, frame.scene.mesh_id(slot))
}

/// The same of an instance that is drawn by a mesh, its own or that of its levels.
fn may_hide_clusters_of(frame: &Frame<'_>, cache: &Cache, slot: u32, mesh: MeshId) -> bool {
    if frame.culler.occlusion.is_none() || cache.is_left_out {
        return false;
    }
    let scene = frame.scene;
    let is_set =
        |words: &[u64]| words.get(slot as usize / 64).is_some_and(|w| w >> (slot % 64) & 1 == 1);
    // One cluster has the box of its instance, which was tested.
    let mesh = &scene.meshes()[mesh as usize];
    mesh.clusters().len() > 1
        && is_parted(mesh)
        && !is_set(&cache.whole)
        && !is_set(scene.exempt())
        && scene.is_rigid(slot)
}

/// A box around the view's eye and its near rectangle, relative to an origin: what the near plane
/// cuts away hides nothing. Everything, where a corner is not known.
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
