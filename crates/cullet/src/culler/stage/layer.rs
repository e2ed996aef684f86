//! Layers: instances that share none with the view.

use super::super::evidence::Evidence;
use super::super::frame::Frame;
use super::super::log::Log;
use crate::funnel::{Reason, Stage, Unit};
use crate::scene::Tally;

/// Counts what is in the layers of the view. Instances themselves are held against them when they
/// are taken, by the stage that follows: most are never looked at.
pub(in super::super) fn instances(frame: &Frame<'_>, log: &mut Log<'_>) {
    let (scene, layers) = (frame.scene, frame.view.layers);
    let all = match frame.only_slot() {
        Some(slot) => {
            let is_in = scene.layers(slot) & layers != 0;
            log.left = if is_in { scene.tally_of(slot) } else { Tally::default() };
            scene.tally_of(slot)
        }
        None => {
            log.left = scene.tally_of_layers(layers);
            scene.tally()
        }
    };
    log.row(Stage::Layer, Unit::Instances, all.counts);
    let some_are_out = all.counts != log.left.counts || scene.stand_ins().is_some();
    if log.wants_reasons() && some_are_out {
        let slots = frame.only_slot().map_or(0..scene.slot_count(), |slot| slot..slot + 1);
        for slot in slots.filter(|&s| !scene.is_removed(s)) {
            if scene.layers(slot) & layers == 0 {
                log.drop_slot(slot, Reason { stage: Stage::Layer, detail: 0 });
            }
        }
    }
}

/// Returns the layers of an instance and of the view.
pub(in super::super) fn evidence(frame: &Frame<'_>, slot: u32) -> Evidence {
    Evidence::Layers { instance: frame.scene.layers(slot), view: frame.view.layers }
}
