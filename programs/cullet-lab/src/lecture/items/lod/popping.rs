//! Popping of what is dropped for its size, and its cure.

use std::collections::BTreeMap;

use cullet::cull::detail::Detail;
use cullet::view::View;
use cullet::{Culler, Stage};

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, draw};

/// Steps of the dolly, each a hundredth farther away.
const STEPS: i32 = 60;
const STEP: f64 = 1.01;
const THRESHOLD: f64 = 8.0;

/// An eye that draws back: what goes at once, and how much less of it is drawn from step to step where it fades.
pub(super) fn popping(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=6,objects=200")?;
    let scene = &model.scene;
    let detail = Detail { threshold_px: THRESHOLD, fade: 0.5, ..Detail::default() };
    let culler = Culler { detail: Some(detail), reasons: true, ..Culler::exact() };
    let culler = culler.only(Stage::Detail);
    let mut before: BTreeMap<u32, f64> = BTreeMap::new();
    let mut last: Option<View> = None;
    let (mut pops, mut seen, mut largest, mut most) = (0, 0, 0, 0.0_f64);
    for step in 0..STEPS {
        let far = 200.0 * STEP.powi(step);
        let eye = [0.0, 0.4 * far, far];
        let view = View::perspective(eye, [0.0; 3], 1.0, 0.5, f64::INFINITY, SIZE)?;
        let visible = cull(&culler, scene, &view);
        let mut now = BTreeMap::new();
        for slot in visible.slots() {
            let rect = view.project_box(&scene.bounds(slot), scene.origin());
            let size = rect.map(|rect| [rect.width(), rect.height()]);
            now.insert(slot, detail.weight(size, 1.0));
        }
        let gone: Vec<u32> =
            before.keys().filter(|slot| !now.contains_key(slot)).copied().collect();
        for (slot, was) in &before {
            let is = now.get(slot).copied().unwrap_or(0.0);
            most = most.max((was - is).abs());
        }
        pops += gone.len();
        // Of what went the pixels that it had in the picture before.
        if let Some(last) = last.filter(|_| !gone.is_empty()) {
            let frame = draw(scene, &last);
            for slot in gone {
                let pixels = frame.ids.iter().filter(|id| id.slot == slot).count();
                seen += usize::from(pixels > 0);
                largest = largest.max(pixels);
            }
        }
        (before, last) = (now, Some(view));
    }
    // A pop takes all of an instance; a step takes some hundredths of its size, of which the fade is a half.
    Ok(Finding::if_so(
        seen > 0 && largest as f64 <= THRESHOLD * THRESHOLD && most < 0.1,
        format!(
            "while an eye draws back by 1 % at each of {STEPS} steps, {pops} instances go at 8 pixels, {seen} of them seen the step \
             before, in up to {largest} pixels; faded from 12 pixels down, no step takes more than {:.1} % of one",
            most * 100.0
        ),
    ))
}
