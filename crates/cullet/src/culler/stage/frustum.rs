//! Frustum: what is outside of the view's half-spaces. Each of its steps makes a set of what is
//! left of the one before.

use alloc::vec::Vec;

use super::super::evidence::{Evidence, PlaneTest};
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::{Run, is_parted, triangles_of};
use super::super::sets::{self, Coarse, GROUP, Instances, Sets, slots};
use super::backface::Backs;
use super::{candidates, detail, occlusion};
use crate::array::Each;
use crate::bits;
use crate::bounds::Side;
use crate::cull::frustum::batch::Planes;
use crate::cull::frustum::exact::ExactFrustum;
use crate::cull::frustum::tree::Cut;
use crate::cull::frustum::triangles::ObjectRegion;
use crate::cull::shadow::CasterRegion;
use crate::funnel::{FrustumWork, Reason, Stage, Unit};
use crate::visible::TriangleRange;

/// State that the stage keeps of a view.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    /// The instances of the last frame, which are still right if neither view nor scene changed.
    instances: Cut,
    clusters: Cut,
    of_levels: Vec<Run>,
}

/// Takes the instances that are in a layer of the view and not outside; all of them with the stage
/// off.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    log: &mut Log<'_>,
) {
    let scene = frame.scene;
    let words = scene.hierarchy().present().len();
    set.clear(words);
    let all = frame.only_slot().map_or_else(|| scene.tally(), |slot| scene.tally_of(slot));
    let all_in = all.counts.instances == log.left.counts.instances;
    match frame.only_slot() {
        Some(slot) if all_in => take_alone(frame, set, log, slot),
        Some(_) => {}
        None if frame.culler.frustum => take_visible(frame, cache, set, log, all_in),
        None => (0..words).for_each(|word| set.take(frame, word, u64::MAX, u64::MAX, all_in)),
    }
    if frame.culler.frustum {
        let entered = core::mem::replace(&mut log.left, set.tally(scene));
        log.row(Stage::Frustum, Unit::Instances, entered.counts);
    }
}

/// Takes what the frustum does not reject, by the scene's hierarchy.
fn take_visible(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    log: &mut Log<'_>,
    all_in: bool,
) {
    let (scene, planes) = (frame.scene, &frame.planes);
    let hierarchy = scene.hierarchy();
    let cut = &mut cache.instances;
    let exempt = scene.exempt_words();
    let mut touched: &[u64] = &[];
    if !frame.sees_nothing() {
        let state = [scene.id(), hierarchy.change_version()];
        cut.update(frame.culler.simd, planes, hierarchy.nodes(), hierarchy.boxes(), state);
        log.frustum = FrustumWork {
            nodes: cut.nodes_tested(),
            blocks: cut.leaves_tested(),
            plane_tests: cut.plane_tests(),
            swept: cut.swept(),
        };
        touched = cut.touched_words();
    }
    // Where all is in view, a group of words at once.
    let are_plain = all_in && scene.stand_ins().is_none();
    for group in 0..exempt.len().max(touched.len()) {
        let [touched, exempt] = [touched, exempt].each(|w| w.get(group).copied().unwrap_or(0));
        if touched == u64::MAX && exempt == 0 && are_plain {
            let words = group * GROUP..(group + 1) * GROUP;
            set.take_group(scene, group, &cut.visible()[words.clone()], &cut.inside()[words]);
            continue;
        }
        for bit in bits::ones(touched | exempt) {
            let word = group * 64 + bit;
            match touched >> bit & 1 {
                0 => set.take(frame, word, 0, 0, all_in),
                _ => set.take(frame, word, cut.visible()[word], cut.inside()[word], all_in),
            }
        }
    }
    if let Some(casters) = frame.casters().filter(|c| c.has_range()) {
        drop_beyond_range(frame, casters, set);
    }
    if frame.culler.frustum_exact {
        drop_beyond_planes(frame, set);
    }
    if log.wants_reasons() {
        for word in 0..hierarchy.present().len() {
            let stands_in = scene.stand_ins().map_or(0, |s| s.word(word));
            let dropped = hierarchy.present()[word] & !set.alive[word] & !stands_in;
            for slot in slots(word, dropped) {
                // Instances in no layer were dropped before.
                if all_in || scene.layers(slot) & frame.view.layers != 0 {
                    let detail = frame.rejection(slot);
                    log.drop_slot(slot, Reason { stage: Stage::Frustum, detail });
                }
            }
        }
    }
}

/// Drops casters that no plane of the region rejects, but that the light does not reach.
fn drop_beyond_range(frame: &Frame<'_>, casters: &CasterRegion, set: &mut Instances) {
    let scene = frame.scene;
    for &word in &set.live {
        let word = word as usize;
        for slot in slots(word, set.alive[word] & !scene.exempt()[word]) {
            if casters.is_beyond_range(&scene.boxes().get(slot as usize)) {
                set.alive[word] &= !(1 << (slot % 64));
            }
        }
    }
}

/// Drops boxes that straddle planes but lie beyond the frustum's corners.
fn drop_beyond_planes(frame: &Frame<'_>, set: &mut Instances) {
    let exact = ExactFrustum::new(&frame.frustum);
    for &word in &set.live {
        let word = word as usize;
        for slot in slots(word, set.alive[word] & !set.inside[word]) {
            if exact.is_outside_beyond_planes(&frame.scene.bounds(slot)) {
                set.alive[word] &= !(1 << (slot % 64));
            }
        }
    }
}

/// Takes one slot, by the arithmetic of the batch test, so with the same answer.
fn take_alone(frame: &Frame<'_>, set: &mut Instances, log: &mut Log<'_>, slot: u32) {
    let scene = frame.scene;
    let exempt = bits::get(scene.exempt(), slot as usize);
    let bounds = scene.bounds(slot);
    let mut side = match frame.culler.frustum {
        true if frame.sees_nothing() => Side::Outside,
        true => frame.planes.classify_box(&bounds),
        false => Side::Inside,
    };
    let casters = frame.casters().filter(|_| frame.culler.frustum);
    if casters.is_some_and(|c| c.is_beyond_range(&scene.boxes().get(slot as usize))) {
        side = Side::Outside;
    }
    if frame.culler.frustum_exact
        && side == Side::Straddling
        && ExactFrustum::new(&frame.frustum).is_outside_beyond_planes(&bounds)
    {
        side = Side::Outside;
    }
    if side == Side::Outside && !exempt {
        log.drop_slot(slot, Reason { stage: Stage::Frustum, detail: frame.rejection(slot) });
    } else {
        set.take_slot(slot, exempt || side == Side::Inside);
    }
}

/// Turns instances into runs of clusters: all of those inside and of those with [few](is_parted),
/// and of the others what is not outside the frustum. Where clusters are wanted and no later stage
/// can drop one of an instance, its bit is [settled](super::super::sets::Clusters::settled) and it
/// gets no run: in large scenes that is most of what is visible.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    cache: &mut Cache,
    hidden: &occlusion::Cache,
    sets: &mut Sets,
    log: &mut Log<'_>,
) {
    let scene = frame.scene;
    let by_cluster = frame.culler.frustum;
    let settles = frame.culler.output.unit() == Unit::Clusters;
    let backs = frame.culls_backs_by_cluster().then(|| Backs::new(frame));
    let Sets { instances, coarse, clusters, .. } = sets;
    clusters.settled.resize(instances.alive.len(), 0);
    let kinds = scene.mesh_kinds();
    // What holds of every mesh: of such scenes most words are settled without a look at their
    // instances.
    let is_few = scene.meshes().len() < instances.live.len();
    let none_has_backs = settles
        && is_few
        && kinds.iter().all(|&kind| backs.as_ref().is_none_or(|b| b.none_of(kind)));
    let all_are_whole = none_has_backs && !kinds.iter().any(|kind| kind.is_parted());
    let entered = log.left.counts;
    for &word in &instances.live {
        let word = word as usize;
        // Those of which only their mesh can say that they are not drawn whole.
        let inside = if by_cluster { instances.inside[word] } else { u64::MAX };
        let may_settle = if settles && !detail::drops_clusters(frame) {
            inside & occlusion::unhidden(frame, hidden, word)
        } else {
            0
        };
        let may_settle = may_settle & !candidates::straddling(frame, word);
        let replaced = coarse.word(word as u32);
        let alive = instances.alive[word];
        let at_once = match (all_are_whole, none_has_backs) {
            (true, _) => alive & !replaced,
            (_, true) => alive & !replaced & may_settle,
            _ if settles => bits::ones(alive & !replaced).fold(0, |settled, bit| {
                let kind = kinds[scene.mesh_id((word * 64 + bit) as u32) as usize];
                let is_whole = may_settle >> bit & 1 == 1 || !kind.is_parted();
                let settles = is_whole && backs.as_ref().is_none_or(|b| b.none_of(kind));
                settled | u64::from(settles) << bit
            }),
            _ => 0,
        };
        clusters.settled[word] = at_once;
        for slot in slots(word, alive & !at_once) {
            if replaced >> (slot % 64) & 1 == 1 {
                let Some(cut) = coarse.cut_of(slot) else { continue };
                let inside = inside >> (slot % 64) & 1 == 1;
                let memory = (&mut cache.clusters, &mut cache.of_levels);
                let runs = &mut clusters.runs;
                list_levels(frame, memory, (coarse, cut), inside, runs, log);
                continue;
            }
            let mesh = scene.mesh(slot);
            let cluster_count = mesh.cluster_count();
            let inside =
                inside >> (slot % 64) & 1 == 1 || !scene.is_rigid(slot) || cluster_count == 0;
            let mesh_id = scene.mesh_id(slot);
            let run =
                Run { slot, mesh: mesh_id, level: 0, first_cluster: 0, cluster_count, inside };
            if !inside && is_parted(mesh) {
                list_clusters(frame, &mut cache.clusters, run, &mut clusters.runs, log);
                continue;
            }
            if !settles
                || occlusion::may_hide_clusters(frame, hidden, slot)
                || candidates::may_cut(frame, slot)
                || detail::may_drop_clusters(frame, slot)
                || backs.as_ref().is_some_and(|b| b.may_cull_clusters(slot))
            {
                clusters.runs.push(run);
                continue;
            }
            clusters.settle(slot);
        }
    }
    if by_cluster {
        log.row(Stage::Frustum, Unit::Clusters, entered);
    }
}

/// Lists the clusters of an instance that the frustum does not reject.
fn list_clusters(
    frame: &Frame<'_>,
    cut: &mut Cut,
    all: Run,
    runs: &mut Vec<Run>,
    log: &mut Log<'_>,
) {
    let (scene, slot) = (frame.scene, all.slot);
    let mesh = scene.mesh(slot);
    let (first, straddled) = (runs.len(), frame.straddled(slot));
    let planes = Planes::in_object_space(&frame.world_frustum, scene.transform(slot), straddled);
    cut.cull(frame.culler.simd, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
    for word in cut.touched() {
        for bit in bits::ones(cut.visible()[word]) {
            let cluster = (word * 64 + bit) as u32;
            let inside = cut.inside()[word] >> bit & 1 == 1;
            match runs[first..].last_mut() {
                Some(run)
                    if run.inside == inside && run.first_cluster + run.cluster_count == cluster =>
                {
                    run.cluster_count += 1;
                }
                _ => {
                    runs.push(Run { first_cluster: cluster, cluster_count: 1, inside, ..all });
                }
            }
        }
    }
    if (cut.count() as u32) < all.cluster_count {
        log.drop_clusters(Stage::Frustum, mesh, slot, &[all], &runs[first..]);
    }
    if runs.len() == first {
        log.drop_slot(slot, Reason { stage: Stage::Frustum, detail: Reason::MIXED });
    }
}

/// Lists the clusters of an instance's levels that the frustum does not reject.
fn list_levels(
    frame: &Frame<'_>,
    (cut, all): (&mut Cut, &mut Vec<Run>),
    (coarse, levels): (&Coarse, &sets::Cut),
    inside: bool,
    runs: &mut Vec<Run>,
    log: &mut Log<'_>,
) {
    let (scene, slot, first) = (frame.scene, levels.slot, runs.len());
    let mesh = &scene.meshes()[levels.mesh as usize];
    if inside || !is_parted(mesh) {
        runs.extend(coarse.runs_of(levels).map(|run| Run { inside, ..run }));
        return;
    }
    // A coarser level may lie beyond the bounds of its instance, so that no plane is left out.
    let planes = Planes::in_object_space(&frame.world_frustum, scene.transform(slot), u32::MAX);
    cut.cull(frame.culler.simd, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
    all.clear();
    all.extend(coarse.runs_of(levels));
    for range in coarse.within(levels, cut.visible()) {
        let mut at = range.start;
        while at < range.end {
            let inside = bits::get(cut.inside(), at as usize);
            let end = bits::next(cut.inside(), at, range.end, !inside);
            runs.push(Run { first_cluster: at, cluster_count: end - at, inside, ..all[0] });
            at = end;
        }
    }
    log.drop_clusters(Stage::Frustum, mesh, slot, all, &runs[first..]);
    if runs.len() == first {
        log.drop_slot(slot, Reason { stage: Stage::Frustum, detail: Reason::MIXED });
    }
}

/// Lists the triangles of all runs, those of straddling clusters by their outcodes.
pub(in super::super) fn triangles(frame: &Frame<'_>, sets: &mut Sets, log: &mut Log<'_>) {
    let scene = frame.scene;
    let entered = log.left.counts;
    let Sets { clusters, triangles: set, .. } = sets;
    // The slot, its region, and the planes that it straddles.
    let mut region: Option<(u32, ObjectRegion, u32)> = None;
    for (i, &run) in clusters.runs.iter().enumerate() {
        let mesh = &scene.meshes()[run.mesh as usize];
        // An instance of bounds alone has no triangles to lose.
        if mesh.triangle_count() == 0 {
            continue;
        }
        let triangles = triangles_of(mesh, run);
        let before = set.list.len();
        if run.inside {
            set.list.extend(triangles.clone());
        } else {
            // Runs of a slot follow each other: its region is made once.
            if region.as_ref().is_none_or(|(slot, ..)| *slot != run.slot) {
                let transform = scene.transform(run.slot);
                let own = ObjectRegion::new(&frame.world_frustum, transform);
                region = Some((run.slot, own, frame.straddled(run.slot)));
            }
            let Some((_, region, straddled)) = &region else { continue };
            let (positions, indices) = (mesh.positions(), mesh.indices());
            let is_own = run.mesh == scene.mesh_id(run.slot);
            let active = region.present() & if is_own { *straddled } else { u32::MAX };
            region.keep_into(positions, indices, triangles.clone(), active, &mut set.list);
        }
        let is_part = set.list.len() - before < triangles.len();
        if is_part && log.lists_dropped() {
            let of = (run.slot, run.level);
            log.drop_triangles(Stage::Frustum, of, triangles, &set.list[before..]);
        }
        // Degenerate triangles are in no cluster; they go with the last run of their instance.
        if clusters.runs.get(i + 1).is_none_or(|next| next.slot != run.slot) {
            set.list.extend(mesh.degenerate_triangles());
        }
        let count = (set.list.len() - before) as u32;
        match set.ranges.last_mut() {
            Some(range) if range.slot == run.slot => range.count += count,
            _ => {
                let Run { slot, level, .. } = run;
                set.ranges.push(TriangleRange { slot, level, first: before as u32, count });
            }
        }
    }
    if frame.culler.frustum {
        set.end(&clusters.runs, Stage::Frustum, entered, log);
    }
    debug_assert_eq!(log.left.counts.triangles, set.list.len() as u64);
}

/// Returns how far the box of an instance is outside of each plane. `reason` is why this stage
/// dropped the instance.
pub(in super::super) fn evidence(frame: &Frame<'_>, slot: u32, reason: Option<Reason>) -> Evidence {
    let bounds = frame.scene.bounds(slot);
    let tests = frame.frustum.planes().map(|(number, plane)| {
        let [nearest, farthest] = bounds.span(plane);
        PlaneTest { plane: number as u8, nearest, farthest }
    });
    let planes = tests.collect();
    match frame.casters() {
        Some(_) => Evidence::Caster { reason: reason.and_then(Reason::caster), planes },
        None => Evidence::Planes(planes),
    }
}
