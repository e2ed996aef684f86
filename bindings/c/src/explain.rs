//! Why an instance is drawn or culled, in words.

use std::ffi::c_char;

use crate::cull::settings_of;
use crate::instance::{Handle, scene_error};
use crate::memory::{Out, value};
use crate::results::Reason;
use crate::scene::{SCENES, Scene};
use crate::settings::Settings;
use crate::status::{Error, Status, call};
use crate::view::{View, to_engine};

/// Replays the stages for one instance, and writes why it is drawn or culled: its reason (stage 0
/// for an instance that is drawn) unless `reason` is NULL; and a line for each stage into `text`,
/// UTF-8 with a 0 at its end, cut off where `capacity` bytes are too few. `length` takes the bytes
/// that all of it needs, the 0 included, unless it is NULL. `settings` may be NULL as in
/// `cullet_cull`. For tools: it may cull the whole scene, and allocates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_explain(
    scene: Scene,
    view: *const View,
    settings: *const Settings,
    handle: Handle,
    reason: *mut Reason,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> Status {
    call("cullet_explain", || {
        // SAFETY: as the header asks of the caller.
        let view = to_engine(&unsafe { value("view", view) }?)?;
        let culler = settings_of(settings)?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("text", text.cast::<u8>(), capacity) }?;
        let some = |is_null: bool| usize::from(!is_null);
        // SAFETY: as the header asks of the caller.
        let mut needed = unsafe { Out::array("length", length, some(length.is_null())) }?;
        // SAFETY: as the header asks of the caller.
        let mut why = unsafe { Out::array("reason", reason, some(reason.is_null())) }?;
        let scene = SCENES.get(scene.id)?;
        let found = scene.all().explain(&culler, &view, handle.into()).map_err(|e| match e {
            engine::CullError::Scene(e) => scene_error(e),
            e => Error::value(e.to_string()),
        })?;
        let mut words = String::new();
        for step in &found.steps {
            let (stage, unit) = (step.stage.name(), step.unit.name());
            let (entered, left) = (step.entered, step.left);
            words += &format!("{stage}: {left} of {entered} {unit} left: {step}\n");
        }
        for &slot in &found.hidden_by {
            if let Some(by) = scene.handle(slot) {
                words += &format!("hidden by instance {}\n", by.index);
            }
        }
        if why.room() > 0 {
            why.set(0, Reason::of(found.reason));
        }
        if needed.room() > 0 {
            needed.set(0, words.len() + 1);
        }
        if capacity > 0 {
            let mut end = words.len().min(capacity - 1);
            while !words.is_char_boundary(end) {
                end -= 1;
            }
            out.copy(&words.as_bytes()[..end]);
            out.set(end, 0);
        }
        Ok(())
    })
}
