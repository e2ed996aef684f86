//! How a scene comes into a session: loaded beside what is shown, and put in its place once it is
//! there.

use std::sync::Arc;

#[cfg(target_arch = "wasm32")]
use eframe::egui;

use super::{Session, Tour};
use crate::audit::Audit;
use crate::cost::Measured;
use crate::cutaway::Cutting;
use crate::inbox::{Read, model_of};
use crate::journey::Journey;
use crate::remaking::Remaking;
use crate::state::{Sides, State};
use crate::task::Progress;
#[cfg(not(target_arch = "wasm32"))]
use crate::task::Task;
use crate::truth::Truth;
use crate::world::{Source, World};

impl Session {
    /// Opens another scene; the cameras will fit it. What is open stays until it is loaded.
    pub fn open(&mut self, source: Source) {
        self.end_tour();
        self.refit = true;
        self.load(source);
    }

    /// Reads files that were dropped on the page; [`dropped`](Self::dropped) has them when they are
    /// read.
    #[cfg(target_arch = "wasm32")]
    pub fn read_dropped(&mut self, files: Vec<egui::DroppedFileHandle>) {
        let put = self.inbox.slot();
        wasm_bindgen_futures::spawn_local(async move {
            let mut read = Vec::with_capacity(files.len());
            for file in files {
                let name = file.path().display().to_string();
                match file.bytes_async().await {
                    Ok(bytes) => read.push((name, bytes)),
                    Err(why) => return put(Err((name, why))),
                }
            }
            put(Ok(read));
        });
    }

    /// Lets the user choose a file to open. On a page it must be called soon after a click or a
    /// key, or the browser opens no dialog.
    pub fn choose_file(&mut self) {
        #[cfg(not(target_arch = "wasm32"))]
        self.chooser.open();
        #[cfg(target_arch = "wasm32")]
        if let Err(error) = crate::web::choose(self.inbox.slot()) {
            self.tell(format!("{error}. Drop the file on the page."), true);
        }
    }

    /// Opens what was chosen since the last call.
    pub(super) fn take_chosen(&mut self) {
        #[cfg(not(target_arch = "wasm32"))]
        match self.chooser.poll(&self.ctx) {
            None => {}
            Some(Ok(path)) => self.open(Source::File(path)),
            Some(Err(text)) => self.tell(text, true),
        }
    }

    /// Opens what was read, with the files that it names, or tells why it could not be.
    pub fn open_read(&mut self, read: Read) {
        match read {
            Ok(mut files) => {
                let model = self.choose_model(files.iter().map(|(name, _)| name.as_str()));
                if model < files.len() {
                    let (name, bytes) = files.swap_remove(model);
                    self.open(Source::Bytes { name, bytes, beside: files });
                }
            }
            Err((name, why)) => {
                self.tell_of_scene(format!("{name} could not be read: {why}."), true);
            }
        }
    }

    /// Returns which of the files is the model; where several could be, says that one is opened.
    pub fn choose_model<'a>(&mut self, names: impl IntoIterator<Item = &'a str> + Clone) -> usize {
        let (model, more) = model_of(names.clone());
        if let (true, Some(name)) = (more > 0, names.into_iter().nth(model)) {
            self.tell(format!("Of {} models {name} is opened, the first.", more + 1), false);
        }
        model
    }

    /// Takes the files read since the last call.
    pub fn dropped(&mut self) -> Vec<Read> {
        self.inbox.take()
    }

    /// The name of what is being loaded.
    #[must_use]
    pub fn loading(&self) -> Option<&str> {
        self.loading.as_ref().map(|(name, _)| name.as_str())
    }

    /// The scene as it was before it was cut.
    #[must_use]
    pub fn whole(&self) -> Option<&Arc<World>> {
        self.cutting.whole.as_ref().or(self.world.as_ref())
    }

    pub(super) fn load(&mut self, source: Source) {
        let ctx = self.ctx.clone();
        let name = source.name();
        let wake = move || ctx.request_repaint();
        #[cfg(not(target_arch = "wasm32"))]
        let task = {
            let ctx = self.ctx.clone();
            Task::start(move || World::open(&source, move || ctx.request_repaint()), wake)
        };
        #[cfg(target_arch = "wasm32")]
        let task = crate::web::load(source, wake);
        self.loading = Some((name, task));
    }

    pub(super) fn take_loaded(&mut self) {
        let Some((name, task)) = &self.loading else { return };
        match task.poll() {
            Progress::Working => return,
            Progress::Done(Ok(world)) => self.show(world),
            Progress::Done(Err(error)) => {
                let stays = if self.world.is_some() { " What was open stays open." } else { "" };
                self.refit = false;
                self.tell_of_scene(format!("{error}.{stays}"), true);
            }
            Progress::Lost => {
                let text = format!("{name}: loading ended without a result: a fault of cullet.");
                self.tell_of_scene(text, true);
            }
        }
        self.loading = None;
        // A stop whose scene cannot be had is none.
        if self.tour.as_ref().is_some_and(Tour::is_coming) {
            self.end_tour();
        }
    }

    fn show(&mut self, world: World) {
        self.notices.retain(|n| !n.of_scene);
        for warning in world.model.warnings.iter().take(2) {
            let text = format!("{}: {warning}", world.name);
            self.tell_of_scene(text, false);
        }
        if world.counts.triangles == 0 {
            self.tell_of_scene(format!("{} has no triangle to show.", world.name), true);
        }
        self.enter(Arc::new(world));
    }

    fn enter(&mut self, world: Arc<World>) {
        self.state.scene.clone_from(&world.name);
        self.world = Some(world);
        if std::mem::take(&mut self.refit) {
            self.state.camera = None;
            self.state.frozen = None;
            // The chosen sides of another scene do not apply to this one.
            self.state.sides = Sides::Automatic;
            self.state.doors.clear();
        }
        self.forget();
        if self.tour.as_ref().is_some_and(Tour::is_coming) {
            self.arrive(true);
        } else if self.state.camera.is_none() {
            self.begin();
        }
    }

    /// Stops to load what is being loaded.
    pub(super) fn stop_loading(&mut self) {
        (self.loading, self.refit) = (None, false);
    }

    /// Shows a scene again that was shown before, as the state has it; none where it was none.
    pub(super) fn enter_again(&mut self, world: Option<Arc<World>>) {
        match world {
            Some(world) => self.enter(world),
            None => {
                self.world = None;
                self.forget();
            }
        }
    }

    /// Clears the scene, and what is being loaded: none is shown until another is opened. Switches
    /// stay.
    pub fn clear(&mut self) {
        self.end_tour();
        self.notices.retain(|n| !n.of_scene);
        (self.loading, self.refit) = (None, false);
        self.world = None;
        self.forget();
        self.audit = Audit::default();
        self.device.awaited = false;
        let State { scene, camera, frozen, sides, doors, .. } = &mut self.state;
        (*camera, *frozen, *sides) = (None, None, Sides::Automatic);
        scene.clear();
        doors.clear();
    }

    /// Forgets what is known of the scene that was shown.
    fn forget(&mut self) {
        #[cfg(not(target_arch = "wasm32"))]
        {
            self.following = Default::default();
        }
        self.fitted = None;
        self.remaking = Remaking::default();
        self.asked = None;
        self.next = None;
        self.cutting = Cutting::default();
        self.decision = None;
        self.end_fades();
        self.history.clear();
        self.inspected = None;
        self.truth = Truth::None;
        self.journey = Journey::default();
        self.measured = Measured::None;
    }

    /// Goes back to the scene that was open before, since the new one cannot be drawn.
    pub fn refuse(&mut self, before: Option<Arc<World>>, why: String) {
        if self.tour.is_some() {
            self.end_tour();
            return self.tell_of_scene(why, true);
        }
        if let Some(whole) = self.cutting.whole.clone().filter(|_| self.state.cut.on) {
            self.state.cut.on = false;
            self.tell_of_scene(format!("{why} It is shown whole."), true);
            return self.enter(whole);
        }
        match before {
            Some(world) => {
                self.tell_of_scene(format!("{why} What was open stays open."), true);
                self.state.camera = None;
                self.state.frozen = None;
                self.state.sides = world.sides;
                self.state.doors.clone_from(&world.doors);
                self.enter(world);
                // Of a world in tiles what comes next would be as large.
                #[cfg(not(target_arch = "wasm32"))]
                self.following.end();
            }
            None => self.tell_of_scene(why, true),
        }
    }
}
