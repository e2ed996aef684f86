//! The funnel by a slow way: each stage run alone, and what it takes of what the rows before it left.

use cullet::{
    Culler, Output, Scene, Stage, View, Visible,
    funnel::{Counts, Unit},
};
use cullet_cells::InCells;

use crate::answers::cull;

/// Fate of every triangle of every instance, in the order of its mesh: the row that dropped it.
pub type Fates = Vec<Vec<Option<(Stage, Unit)>>>;

/// Settings that record all that a cull can tell.
pub fn telling(culler: &Culler) -> Culler {
    culler
        .clone()
        .with_output(Output::Triangles)
        .with_reasons(true)
        .with_dropped(true)
        .with_clock(None)
}

/// Fates by the record of one cull: ranges where an instance was dropped by parts, else its reason.
///
/// # Panics
///
/// If ranges overlap, or do not fit what is listed.
pub fn fates(scene: &Scene, result: &Visible) -> Fates {
    let mut fates: Fates = (0..scene.slot_count()).map(|_| Vec::new()).collect();
    for slot in scene.slots() {
        fates[slot as usize] = vec![None; scene.mesh(slot).triangle_count() as usize];
    }
    for d in &result.dropped {
        for t in d.first_triangle..d.first_triangle + d.triangle_count {
            let fate = &mut fates[d.slot as usize][t as usize];
            assert_eq!(*fate, None, "triangle {t} of slot {} is listed twice", d.slot);
            *fate = Some((d.stage, d.unit));
        }
    }
    for slot in scene.slots() {
        let Some(reason) = result.reasons[slot as usize] else { continue };
        let fates = &mut fates[slot as usize];
        if fates.iter().all(Option::is_none) {
            fates.fill(Some((reason.stage, Unit::Instances)));
        }
        assert!(fates.iter().all(Option::is_some), "slot {slot} was dropped, but not all of it");
    }
    for range in &result.triangle_ranges {
        let list = &result.triangles[range.first as usize..][..range.count as usize];
        for &t in list {
            assert_eq!(fates[range.slot as usize][t as usize], None, "listed and dropped");
        }
    }
    fates
}

/// Fates by the stages, each run alone. Occlusion chooses its occluders among what the stages of instances before it
/// leave, so it runs after those; and detail leaves occluders their clusters, so it runs beside occlusion.
pub fn fates_alone<'a>(culler: &Culler, world: impl Into<InCells<'a>>, view: &View) -> Fates {
    let world = world.into();
    let scene = world.scene;
    let culler = telling(culler);
    let alone = |stage: Stage| {
        let mut one = culler.only(stage);
        let is_beside = stage == Stage::Detail && culler.runs(Stage::Occlusion);
        if stage == Stage::Occlusion || is_beside {
            one = culler.without(Stage::Backface);
        }
        fates(scene, &cull(&one, world, view))
    };
    // In the order in which the rows of a funnel come.
    let order = [
        (Stage::Layer, Unit::Instances),
        (Stage::Frustum, Unit::Instances),
        (Stage::Pvs, Unit::Instances),
        (Stage::Portal, Unit::Instances),
        (Stage::Detail, Unit::Instances),
        (Stage::Degenerate, Unit::Instances),
        (Stage::Occlusion, Unit::Instances),
        (Stage::Frustum, Unit::Clusters),
        (Stage::Portal, Unit::Clusters),
        (Stage::Detail, Unit::Clusters),
        (Stage::Occlusion, Unit::Clusters),
        (Stage::Backface, Unit::Clusters),
        (Stage::Frustum, Unit::Triangles),
        (Stage::Backface, Unit::Triangles),
        (Stage::Degenerate, Unit::Triangles),
        (Stage::Detail, Unit::Triangles),
    ];
    let mut left: Fates = fates(scene, &cull(&culler.only(Stage::Layer), world, view));
    for (stage, unit) in order.into_iter().skip(1).filter(|(stage, _)| culler.runs(*stage)) {
        let alone = alone(stage);
        for slot in scene.slots() {
            let mesh = scene.mesh(slot);
            let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
            let (left, alone) = (&mut left[slot as usize], &alone[slot as usize]);
            for (left, alone) in left[..drawn].iter_mut().zip(alone) {
                if left.is_none() && *alone == Some((stage, unit)) {
                    *left = *alone;
                }
            }
            // Degenerate triangles are in no cluster: they go with the whole instance, with the last cluster of it,
            // or as what they are.
            let whole = alone.first() == Some(&Some((stage, unit))) && unit == Unit::Instances;
            let last = unit == Unit::Clusters
                && drawn > 0
                && left[..drawn].iter().all(Option::is_some)
                && left[..drawn].contains(&Some((stage, unit)));
            let own = (stage, unit) == (Stage::Degenerate, Unit::Triangles);
            if whole || last || own {
                let rest = left[drawn..].iter_mut().filter(|fate| fate.is_none());
                rest.for_each(|fate| *fate = Some((stage, unit)));
            }
        }
    }
    left
}

/// How many triangles a row took.
pub fn taken(fates: &Fates, stage: Stage, unit: Unit) -> u64 {
    fates.iter().flatten().filter(|fate| **fate == Some((stage, unit))).count() as u64
}

/// Checks the rows of a cull: they chain in all three units, begin with the scene, end with the answer, and count what
/// the record says.
///
/// # Panics
///
/// Where they do not.
pub fn check_rows(scene: &Scene, result: &Visible, fates: &Fates) {
    let rows = &result.funnel.rows;
    let sum = |f: &dyn Fn(u32) -> u64| scene.slots().map(f).sum::<u64>();
    let all = Counts {
        instances: u64::from(scene.instance_count()),
        clusters: sum(&|slot| scene.mesh(slot).clusters().len() as u64),
        triangles: sum(&|slot| u64::from(scene.mesh(slot).triangle_count())),
    };
    assert_eq!(result.funnel.entered(), all);
    assert!(rows.windows(2).all(|w| w[0].left == w[1].entered), "{rows:#?}");
    let whole = result.whole.iter().flat_map(|r| r.first..r.first + r.count);
    let whole: u64 = whole.map(|slot| scene.mesh(slot).clusters().len() as u64).sum();
    let partial: u64 = result.partial.iter().map(|d| u64::from(d.cluster_count)).sum();
    let left = Counts {
        instances: result.slots().count() as u64,
        clusters: whole + partial,
        triangles: result.triangle_count,
    };
    assert_eq!(result.funnel.left(), left);
    assert_eq!(result.instance_count, left.instances);
    for row in rows {
        let taken = taken(fates, row.stage, row.unit);
        assert_eq!(row.dropped().triangles, taken, "{:?} of {:?}", row.stage, row.unit);
    }
}
