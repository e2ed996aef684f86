//! `cullet bench pvs --scene --edit`: what going on after an edit takes, beside baking anew.

use std::time::Instant;

use cullet::{Culler, Handle, Instance, Scene, Transform};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledBake, SampledError, SampledSettings, ScenePvs, ViewCells,
    bake_sampled, check_pictures_from,
};
use cullet_bake::work::RunOptions;
use cullet_command::console::{Console, digits, grouped, interrupted};
use cullet_command::process;
use serde::Serialize;

use super::world::Random;

/// An edit, and the two ways to the sets of what it made.
#[derive(Debug, Serialize)]
pub(super) struct Edited {
    /// Whether what changed stands together.
    together: bool,
    /// Instances that went, came or moved.
    changed: usize,
    /// Cells that see any of it, and cells whose sets are the same bytes as before.
    cells: u32,
    same_cells: u32,
    rays: u64,
    fresh_rays: u64,
    cpu_seconds: f64,
    fresh_cpu_seconds: f64,
    pairs: u64,
    fresh_pairs: u64,
    /// Share of what pictures from cells that see the edit show and the sets lack.
    missing_share: f64,
    fresh_missing_share: f64,
}

/// Measurements that both ways share.
pub(super) struct Setting {
    pub(super) settings: SampledSettings,
    pub(super) threads: usize,
    pub(super) poses: u32,
    pub(super) side: u32,
}

/// Changes a share of a scene, and goes on from sets that were baked before.
pub(super) fn measure(
    scene: &mut Scene,
    before: &ScenePvs,
    (share, together): (f64, bool),
    with: &Setting,
) -> Result<Edited, SampledError> {
    let changed = edit(scene, share, together);
    let begin = (Instant::now(), process::cpu_time());
    let sets = before.to_sets();
    let tree = RayTree::new(scene, &RayTreeOptions::default())?;
    let cells = ViewCells::of_boxes(&sets.cells)?;
    let mut bake = SampledBake::after(&tree, &cells, &with.settings, &sets)?;
    let options = RunOptions { threads: with.threads, ..RunOptions::default() };
    // Without a folder nothing can fail.
    let _ = bake.run(&options, &|_| !interrupted());
    let (rays, touched) = (bake.rays(), bake.touched());
    let again = bake.finish();
    let cpu_seconds = (process::cpu_time() - begin.1).as_secs_f64();
    let begin = process::cpu_time();
    let fresh = bake_sampled(&tree, &cells, &with.settings, with.threads)?;
    let fresh_cpu_seconds = (process::cpu_time() - begin).as_secs_f64();
    let missing = |pvs: &ScenePvs| {
        let rows = &pvs.visible;
        check_pictures_from(&tree, &cells, &touched, rows, [with.poses, with.side], 1, with.threads)
            .missing_share()
    };
    let same = |cell: &u32| {
        let rows = [&again, before].map(|pvs| pvs.visible.row(*cell));
        let words = rows[0].len().max(rows[1].len());
        (0..words).all(|k| rows[0].get(k).unwrap_or(&0) == rows[1].get(k).unwrap_or(&0))
    };
    Ok(Edited {
        together,
        changed,
        cells: touched.len() as u32,
        same_cells: (0..cells.len()).filter(same).count() as u32,
        rays,
        fresh_rays: fresh.rays,
        cpu_seconds,
        fresh_cpu_seconds,
        pairs: again.visible_pairs(),
        fresh_pairs: fresh.visible_pairs(),
        missing_share: missing(&again),
        fresh_missing_share: missing(&fresh),
    })
}

/// Prints what was measured.
pub(super) fn tell(e: &Edited, console: &Console) {
    let share = |part: f64, whole: f64| format!("{} %", digits(part / whole.max(1e-9) * 100.0));
    console.line(format!(
        "  edit of {} instances {}: {} cells see it, {} keep their bytes; {} rays, {} of those of baking anew; {} s of processors, {}",
        e.changed,
        if e.together { "that stand together" } else { "anywhere" },
        e.cells,
        e.same_cells,
        grouped(e.rays),
        share(e.rays as f64, e.fresh_rays as f64),
        digits(e.cpu_seconds),
        share(e.cpu_seconds, e.fresh_cpu_seconds),
    ));
    console.line(format!(
        "    missing from cells that see it {:.4} %, baked anew {:.4} %; {} pairs, baked anew {}",
        e.missing_share * 100.0,
        e.fresh_missing_share * 100.0,
        grouped(e.pairs),
        grouped(e.fresh_pairs),
    ));
}

/// Edits a share of the instances: a third goes, a third moves by its own size, and beside each of the
/// others a copy comes. Returns how many changed.
fn edit(scene: &mut Scene, share: f64, together: bool) -> usize {
    let mut random = Random::new();
    let mut some = |count: usize| (random.next() * count as f32) as usize % count.max(1);
    let mut slots: Vec<u32> =
        scene.slots().filter(|&slot| scene.bounds(slot).is_finite()).collect();
    let count = ((slots.len() as f64 * share).ceil() as usize).min(slots.len());
    let middle = |slot: u32| scene.bounds(slot).center();
    if together {
        let of = middle(slots[some(slots.len())]);
        let far = |slot: u32| {
            let at = middle(slot);
            (0..3).map(|a| (at[a] - of[a]) * (at[a] - of[a])).sum::<f64>()
        };
        slots.sort_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)));
    } else {
        for k in 0..count {
            let other = k + some(slots.len() - k);
            slots.swap(k, other);
        }
    }
    let handles: Vec<Handle> =
        slots[..count].iter().filter_map(|&slot| scene.handle(slot)).collect();
    for (k, &handle) in handles.iter().enumerate() {
        let Ok(slot) = scene.slot(handle) else { continue };
        let b = scene.bounds(slot);
        let mut there: Transform = *scene.transform(slot);
        let axis = if k % 2 == 0 { 0 } else { 2 };
        there.translation[axis] += f64::from(b.max[axis] - b.min[axis]);
        let mesh = scene.mesh_id(slot);
        let _ = match k % 3 {
            0 => scene.remove(handle),
            1 => scene.set_transform(handle, there),
            _ => scene.add(Instance::new(mesh, there)).map(|_| ()),
        };
    }
    scene.commit(&Culler::default());
    count
}
