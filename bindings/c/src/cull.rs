//! Culling: states of views, and the call of every frame.

use cullet_cells::CellView;
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
    view: ViewState,
    among: CellView,
    pub(crate) visible: Visible,
    pub(crate) draws: DrawList,
    /// Scene of the result, and the version of its instances.
    of: Option<(u64, u64)>,
    /// Whether the result has triangles.
    pub(crate) triangles: bool,
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
            Some((id, _)) if id != scene.id() => {
                "the last result of this state is of another scene: call cullet_cull with this one"
            }
            Some((_, change)) if change != scene.change_version() => {
                "the scene has changed since it was culled: read results first, or cull again"
            }
            _ => return Ok(()),
        };
        Err(Error::new(Status::NoResult, message))
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
    if settings.is_null() {
        return Ok(Culler::balanced());
    }
    // SAFETY: not NULL, so that the caller has settings there, as the header asks.
    to_culler(&unsafe { value("settings", settings) }?)
}

/// Culls a scene for a view; `cullet_visible_slots` and its like read the result. `settings` may be
/// NULL for `CULLET_PRESET_BALANCED`. Conservative: what the view sees is never culled, but for
/// lossy settings. The answer depends on scene, view and settings alone; `state` makes the next
/// frame faster. Allocates nothing once the state has grown to what the scene needs, and starts no
/// thread. Other threads may cull the same scene meanwhile, each with a state of its own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull(
    scene: Scene,
    view: *const View,
    settings: *const Settings,
    state: State,
) -> Status {
    call("cullet_cull", || {
        // SAFETY: as the header asks of the caller.
        let view = to_engine(&unsafe { value("view", view) }?)?;
        let culler = settings_of(settings)?;
        let scene = SCENES.get(scene.id)?;
        let mut state = STATES.get_mut(state.id)?;
        let Frame { view: own, among, visible, of, triangles, .. } = &mut *state;
        among.cull(scene.all(), &culler, &view, own, visible);
        *of = Some((scene.id(), scene.change_version()));
        *triangles = culler.output == engine::Output::Triangles;
        Ok(())
    })
}
