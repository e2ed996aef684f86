//! Detail: instances that are too small on the screen.

use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Instances, slots};
use crate::funnel::Stage;

/// Drops instances whose projected box is below the threshold.
pub(in super::super) fn instances(frame: &Frame<'_>, set: &mut Instances, log: &mut Log<'_>) {
    let Some(detail) = frame.culler.detail else { return };
    let (scene, view) = (frame.scene, frame.view);
    let dropped = set.filter(scene, Stage::Detail, log, |word, tested| {
        let small = slots(word, tested).filter(|&slot| {
            let rectangle = view.project_box(&scene.bounds(slot), scene.origin());
            detail.is_small(rectangle.as_ref())
        });
        small.fold(0, |small, slot| small | 1 << (slot % 64))
    });
    log.instance_row(Stage::Detail, dropped);
}

/// The size of an instance on the screen.
pub(in super::super) fn finding(frame: &Frame<'_>, slot: u32) -> String {
    match frame.view.project_box(&frame.scene.bounds(slot), frame.scene.origin()) {
        Some(r) => format!("{:.2} x {:.2} pixels on the screen", r.width(), r.height()),
        None => "crosses the near plane, so it is never small".to_owned(),
    }
}
