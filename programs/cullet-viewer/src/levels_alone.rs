//! Instances that levels of detail alone draw of a scene: who changed from one view to the next,
//! whatever else was culled.

use cullet::{Culler, Output, Reason, Scene, Stage, View, ViewState, Visible, draw::DrawRange};

/// The cut at the threshold that a decision came to; `None` where it was made without levels. With
/// instances that stand for others, or, where these are chosen by what other stages leave, each as
/// itself. Cost: a cull by one stage.
pub(crate) fn levels_alone(
    scene: &Scene,
    (culler, view): (&Culler, &View),
    decided: &Visible,
    stand_ins: bool,
) -> Option<Box<Visible>> {
    culler.lod?;
    let mut alone = culler.only(Stage::Lod).with_output(Output::Clusters);
    if let Some(lod) = &mut alone.lod {
        lod.stand_ins &= stand_ins;
        if let Some(pixels) = decided.lod_pixels {
            // What a budget came to, counted of what the other stages leave.
            (lod.pixels, lod.triangles) = (pixels, None);
        }
    }
    let mut cut = Visible::default();
    alone.cull_one(scene, view, &mut ViewState::default(), &mut cut);
    Some(Box::new(cut))
}

/// The clusters that a result has of a slot: none of one that it has in full.
pub(crate) fn ranges_of(visible: &Visible, slot: u32) -> &[DrawRange] {
    let all = &visible.partial;
    let first = all.partition_point(|r| r.slot < slot);
    let count = all[first..].partition_point(|r| r.slot == slot);
    &all[first..first + count]
}

/// Whether an instance that has a reason is missing from the picture: not where another stands for
/// it, nor one that would stand for others.
pub(crate) fn is_dropped(scene: &Scene, slot: u32, reason: Reason) -> bool {
    reason.stage != Stage::Lod && !scene.is_stand_in(slot)
}
