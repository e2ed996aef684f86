//! Recordings of what occlusion culling did: made here, played again by `cullet replay`.

use std::path::Path;

use cullet::{Culler, Output, Stage, View, ViewState, Visible};
use cullet_cells::InCells;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::Failure;
use cullet_io::shell_word;
use cullet_maps::recording::Recording;

/// Records what a culler did in its occlusion stage: what it drew, in its order, and each instance
/// that it tested.
pub(crate) fn record<'a>(
    world: impl Into<InCells<'a>>,
    view: &View,
    culler: &Culler,
    recording: &mut Recording,
) {
    let world = world.into();
    let scene = world.scene;
    let culler = culler.clone().with_output(Output::Instances).with_reasons(true).with_clock(None);
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    world.cull(&culler, view, &mut state, &mut result);
    let Some(buffer) = state.occlusion_buffer() else { return };
    recording.begin(view, scene.origin(), buffer.size());
    for &(slot, shape) in state.occluders_drawn() {
        let shapes = scene.prepared_of(slot).shapes();
        recording.draw(&shapes[shape as usize], scene.transform(slot));
    }
    // Instances culled by an earlier stage were not tested.
    let is_tested = |slot: &u32| {
        result.reasons[*slot as usize].is_none_or(|reason| reason.stage == Stage::Occlusion)
    };
    for slot in scene.slots().filter(is_tested) {
        let bounds = scene.bounds(slot);
        recording.test(&bounds, buffer.test_box(&bounds));
    }
}

/// Writes a recording.
pub(crate) fn write(recording: &Recording, path: &Path, console: &Console) -> Result<(), Failure> {
    let bytes = recording.encode();
    std::fs::write(path, &bytes).map_err(|e| Failure::write(path, &e))?;
    console.note(format!(
        "{}: {}, {} bytes; `cullet replay {}` plays it",
        path.display(),
        count(recording.len() as u64, "call", "calls"),
        grouped(bytes.len() as u64),
        shell_word(&path.to_string_lossy())
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use cullet::cull::occlusion::Occlusion;
    use cullet::{Camera, Depth, Projection, Simd};

    use super::*;

    #[test]
    fn a_recording_is_what_the_culler_did() {
        let scene = cullet_scenes::build("city:cells=6").unwrap().scene;
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.1, far: 900.0 };
        let camera = Camera::look_at([-90.0, 2.0, 3.0], [0.0, 2.0, 0.0], projection);
        let view = View::new(&camera, Depth::Reversed, [300, 200]).unwrap();
        let culler = Culler::default().with_occlusion(Occlusion::default());
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        culler.cull_one(&scene, &view, &mut state, &mut result);
        let mut recording = Recording::default();
        record(&scene, &view, &culler, &mut recording);
        let again = Recording::decode(&recording.encode()).unwrap().replay(Simd::best()).unwrap();
        assert_eq!((again.views, again.changed.len()), (1, 0));
        assert_eq!(again.drawn, result.funnel.occlusion.drawn);
        assert!(again.drawn > 0 && again.hidden > 0 && again.hidden < again.tested);
        // Without the stage there is nothing to record.
        let mut nothing = Recording::default();
        record(&scene, &view, &culler.with_occlusion(None), &mut nothing);
        assert!(nothing.is_empty());
    }
}
