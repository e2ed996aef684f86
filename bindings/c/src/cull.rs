//! Culling: states of views, and the call of every frame.

use cullet_cells::CellView;
use cullet_cells::query::LightAnswer;
use engine::cull::shadow::Light;
use engine::jobs::Jobs;
use engine::{Culler, DrawList, ViewState, Visible};

use crate::memory::{Out, value};
use crate::registry::{Kind, Table};
use crate::scene::{SCENES, Scene};
use crate::settings::{Settings, to_culler};
use crate::status::{Error, Result, Status, call};
use crate::view::{View, to_engine};

pub(crate) static STATES: Table<Frame> = Table::new(Kind::State);

/// Handle of the state of a view: what it remembers between frames, and its last result. One for
/// each view that is culled frame after frame. A plain number: copy it freely; 0 is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Not to be read or made.
    pub id: u64,
}

/// State behind the handle.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub(crate) view: ViewState,
    among: CellView,
    pub(crate) visible: Visible,
    pub(crate) draws: DrawList,
    of: Option<Question>,
    /// Whether the result has triangles.
    pub(crate) triangles: bool,
    /// Memory of culls of lights.
    pub(crate) lights: Vec<Light>,
    pub(crate) light_answer: LightAnswer,
}

/// Kinds of questions that a result may answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    View,
    Among,
    Stereo,
    Shadow,
}

/// The question that a result answers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Question {
    asked: Asked,
    scene: u64,
    /// Version of the scene, and of its cells.
    change: u64,
    cells: u64,
    view: View,
    settings: Option<Settings>,
}

impl Frame {
    /// Refuses where there is no result.
    pub(crate) fn check(&self) -> Result {
        if self.of.is_some() {
            return Ok(());
        }
        Err(Error::new(
            Status::NoResult,
            "nothing was culled with this state yet: call cullet_cull",
        ))
    }

    /// Refuses where the result is not of the scene as it is.
    pub(crate) fn check_scene(&self, scene: &engine::Scene) -> Result {
        self.check()?;
        let message = match self.of {
            Some(of) if of.scene != scene.id() => {
                "the last result of this state is of another scene: call cullet_cull with this one"
            }
            Some(of) if of.change != scene.change_version() => {
                "the scene has changed since it was culled: read results first, or cull again"
            }
            _ => return Ok(()),
        };
        Err(Error::new(Status::NoResult, message))
    }

    /// Refuses where the result is not that of a camera, of the scene as it is. Returns its view,
    /// and whether its occlusion buffer is that of this result.
    pub(crate) fn check_camera(&self, scene: &engine::Scene) -> Result<(View, bool)> {
        self.check_scene(scene)?;
        match self.of {
            Some(Question { asked: Asked::View | Asked::Among, view, settings, .. }) => {
                Ok((view, settings.is_none_or(|settings| settings.occlusion == 1)))
            }
            _ => Err(Error::new(
                Status::NoResult,
                "the last result of this state is that of a light or of two eyes: cull the camera by cullet_cull",
            )),
        }
    }

    /// Answers a question whose answer is not kept for the next call.
    pub(crate) fn answer(
        &mut self,
        scene: &engine::Scene,
        (asked, view, settings): (Asked, View, Option<Settings>),
        culler: &Culler,
        run: impl FnOnce(&mut ViewState, &mut Visible) -> Result,
    ) -> Result {
        self.of = None;
        run(&mut self.view, &mut self.visible)?;
        let (scene, change) = (scene.id(), scene.change_version());
        self.of = Some(Question { asked, scene, change, cells: 0, view, settings });
        self.triangles = culler.output == engine::Output::Triangles;
        Ok(())
    }

    /// Number of slots that have something visible.
    pub(crate) fn slot_count(&self) -> usize {
        let whole: usize = self.visible.whole.iter().map(|range| range.count as usize).sum();
        whole + self.visible.partial.chunk_by(|a, b| a.slot == b.slot).count()
    }
}

/// Makes the state of a view. Destroy it with `cullet_state_destroy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_state_create(state: *mut State) -> Status {
    call("cullet_state_create", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("state", state) }?;
        out.set(0, State { id: STATES.insert(Frame::default())? });
        Ok(())
    })
}

/// Destroys the state of a view; its handle is stale from then on.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_state_destroy(state: State) -> Status {
    call("cullet_state_destroy", || STATES.remove(state.id).map(drop))
}

/// The culler of settings; of balanced ones where there are none.
pub(crate) fn settings_of(settings: *const Settings) -> Result<Culler> {
    given(settings)?.map_or_else(|| Ok(Culler::balanced()), |settings| to_culler(&settings))
}

/// The settings behind a pointer; `None` for NULL.
pub(crate) fn given(settings: *const Settings) -> Result<Option<Settings>> {
    if settings.is_null() {
        return Ok(None);
    }
    // SAFETY: not NULL, so that the caller has settings there, as the header asks.
    unsafe { value("settings", settings) }.map(Some)
}

/// Culls a scene for a view; `cullet_visible_slots` and its like read the result. `settings` may be
/// NULL for `CULLET_PRESET_BALANCED`. Conservative: what the view sees is never culled, but for
/// lossy settings. The answer depends on scene, view and settings alone; `state` makes the next
/// frame faster, and keeps the answer where none of the three has changed. Allocates nothing once
/// the state has grown to what the scene needs, and starts no thread. Other threads may cull the
/// same scene meanwhile, each with a state of its own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull(
    scene: Scene,
    view: *const View,
    settings: *const Settings,
    state: State,
) -> Status {
    call("cullet_cull", || {
        // SAFETY: as the header asks of the caller.
        let view = unsafe { value("view", view) }?;
        cull(scene, view, settings, state, None)
    })
}

/// Culls for a camera, on threads of the caller's where there are some.
pub(crate) fn cull(
    scene: Scene,
    view: View,
    settings: *const Settings,
    state: State,
    jobs: Option<&dyn Jobs>,
) -> Result {
    let (seen, culler) = (to_engine(&view)?, settings_of(settings)?);
    let scene = SCENES.get(scene.id)?;
    let mut state = STATES.get_mut(state.id)?;
    let Frame { view: own, among, visible, of, triangles, .. } = &mut *state;
    let (id, change) = (scene.id(), scene.change_version());
    let settings = given(settings)?;
    let cells = scene.cells_version;
    let question = Question { asked: Asked::View, scene: id, change, cells, view, settings };
    if *of == Some(question) {
        return Ok(());
    }
    *of = None;
    let all = scene.all();
    match jobs {
        Some(jobs) if all.cells.is_none() => {
            culler.cull_one_on(jobs, &scene, &seen, own, visible);
        }
        _ => among.cull(all, &culler, &seen, own, visible),
    }
    *of = Some(question);
    *triangles = culler.output == engine::Output::Triangles;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::{Handle, Instance, cullet_scene_add, cullet_scene_set_layers};
    use crate::mesh::{MeshArrays, cullet_scene_add_mesh};
    use crate::scene::{cullet_scene_commit, cullet_scene_create};
    use crate::settings::cullet_settings_preset;
    use crate::transform::Transform;
    use crate::view::cullet_view_look_at;
    use std::ptr::null;

    /// A triangle in front of the eye; returns its scene, its handle, a view and settings.
    fn made() -> (Scene, Handle, View, Settings) {
        let (positions, indices) =
            ([-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0], [0, 1, 2]);
        let arrays = MeshArrays {
            positions: positions.as_ptr(),
            position_count: 3,
            indices: indices.as_ptr(),
            index_count: 3,
            parts: null(),
            part_count: 0,
            flags: 0,
            material: 0,
        };
        let linear = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let transform = Transform { linear, translation: [0.0, 0.0, -5.0] };
        let at = Instance { transform, mesh: 0, layers: 1, flags: 0, reserved: 0, user: 0 };
        let (mut scene, mut handle) = (Scene { id: 0 }, Handle { index: 0, generation: 0 });
        let (eye, target) = ([0.0; 3], [0.0, 0.0, -1.0]);
        let mut view = std::mem::MaybeUninit::uninit();
        let mut settings = std::mem::MaybeUninit::uninit();
        // SAFETY: every pointer is of a value that lives on, and both structs are filled.
        unsafe {
            assert_eq!(cullet_scene_create(&mut scene), Status::Ok);
            assert_eq!(cullet_scene_add_mesh(scene, &arrays, &mut 0), Status::Ok);
            assert_eq!(cullet_scene_add(scene, &at, 1, &mut handle), Status::Ok);
            let (eye, target) = (eye.as_ptr(), target.as_ptr());
            let done = cullet_view_look_at(eye, target, 0.9, 0.1, 64, 64, view.as_mut_ptr());
            assert_eq!(done, Status::Ok);
            assert_eq!(cullet_settings_preset(1, settings.as_mut_ptr()), Status::Ok);
            (scene, handle, view.assume_init(), settings.assume_init())
        }
    }

    #[test]
    fn a_standing_answer_is_kept_until_scene_view_or_settings_change() {
        let (scene, handle, view, settings) = made();
        let mut state = State { id: 0 };
        // SAFETY: the pointer is of a value that lives on.
        assert_eq!(unsafe { cullet_state_create(&mut state) }, Status::Ok);
        let cull = |view: &View, settings: *const Settings| {
            // SAFETY: pointers are of values that live on, or NULL.
            assert_eq!(unsafe { cullet_cull(scene, view, settings, state) }, Status::Ok);
            // Marks the answer: a mark that is there after the next call says that it was kept.
            let mut frame = STATES.get_mut(state.id).unwrap();
            std::mem::replace(&mut frame.visible.instance_count, 77)
        };
        assert_eq!(cull(&view, &settings), 1);
        assert_eq!(cull(&view, &settings), 77);
        let changes: [fn(&mut View, &mut Settings); 5] = [
            |view, _| view.width = 65,
            |view, _| view.clip_from_world[12] += 1e-9,
            |view, _| view.layers = 3,
            |_, settings| settings.occlusion_budget += 1.0,
            |_, settings| settings.reasons = 1,
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let (mut view, mut settings) = (view, settings);
            change(&mut view, &mut settings);
            assert_eq!(cull(&view, &settings), 1, "change {number}");
            assert_eq!(cull(&view, &settings), 77, "change {number}");
        }
        assert_eq!(cull(&view, null()), 1);
        // SAFETY: pointers are of values that live on.
        assert_eq!(unsafe { cullet_scene_set_layers(scene, &handle, &0, 1) }, Status::Ok);
        assert_eq!(cull(&view, null()), 0);
        assert_eq!(cullet_scene_commit(scene), Status::Ok);
        assert_ne!(cull(&view, null()), 1);
        // What is refused leaves the answer as it was.
        let wrong = View { cull_face: 7, ..view };
        // SAFETY: pointers are of values that live on.
        assert_ne!(unsafe { cullet_cull(scene, &wrong, null(), state) }, Status::Ok);
        assert_eq!(cull(&view, null()), 77);
    }
}
