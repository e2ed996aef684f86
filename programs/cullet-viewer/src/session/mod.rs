//! State of the viewer while it is open: the scene, the settings, decisions, and everything but the
//! picture. It needs no window and no graphics, so tests run it as it is.

mod cameras;
mod cells;
mod fading;
#[cfg(not(target_arch = "wasm32"))]
mod following;
mod inspecting;
mod jobs;
mod on_device;
mod opening;
mod sharing;
mod tour_facts;
mod tour_steps;
mod touring;

pub use inspecting::Inspected;
pub use on_device::DeviceStatus;
pub use sharing::funnel_json;
pub use tour_steps::{STOPS, Stop};
pub use touring::{Given, Tour};

use std::collections::VecDeque;
use std::sync::Arc;

use cullet::view::EyeBall;
use cullet::{Backface, View, Visible, view::CullFace};
use eframe::egui;

use crate::audit::Audit;
use crate::camera::{Chase, Rig};
use crate::cells::Cells;
#[cfg(not(target_arch = "wasm32"))]
use crate::chooser::Chooser;
use crate::cost::Measured;
use crate::cutaway::Cutting;
use crate::decide::{Decider, Decision, Request};
use crate::fades::Fades;
use crate::inbox::Inbox;
use crate::journey::Journey;
use crate::link;
use crate::pops::Pops;
use crate::remaking::Remaking;
use crate::state::{Alteration, Colour, Manner, Stages, State, Study};
use crate::study::Figures;
use crate::task::{Progress, Task, clock};
use crate::truth::Truth;
use crate::world::{Source, World};

/// Decisions that the history graph remembers.
pub const HISTORY: usize = 240;

/// A message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Its text.
    pub text: String,
    /// Whether something went wrong.
    pub bad: bool,
    /// Whether it is about the scene that was open then, or that was not to be opened: the next
    /// scene ends it.
    pub of_scene: bool,
}

/// Figures of a decision, for the history graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Triangles left, of all.
    pub share: f32,
    /// Milliseconds of culling.
    pub milliseconds: f32,
}

/// Figures of drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drawn {
    /// Milliseconds on the processor.
    pub milliseconds: f32,
    /// Milliseconds on the device, where it has a clock.
    pub device_ms: Option<f32>,
    /// Triangles of all panes.
    pub triangles: u64,
    /// Draw calls.
    pub draws: u32,
    /// Pictures a second, while pictures follow each other.
    pub per_second: f32,
    /// Pictures so far.
    pub pictures: u64,
}

/// Everything but the graphics.
#[derive(Debug)]
pub struct Session {
    /// The settings, as in a link.
    pub state: State,
    /// The scene.
    pub world: Option<Arc<World>>,
    /// The newest decision.
    pub decision: Option<Decision>,
    /// Figures of the latest decisions.
    pub history: VecDeque<Point>,
    /// Messages to the user.
    pub notices: Vec<Notice>,
    /// The clicked instance.
    pub inspected: Option<Inspected>,
    /// The proof for a view.
    pub truth: Truth,
    /// The search for bounds violations.
    pub audit: Audit,
    /// The cut-away.
    pub cutting: Cutting,
    /// The scene with other sides, while it is made.
    remaking: Remaking,
    /// Counts of the back faces of the inspected instance that bounds prove.
    pub figures: Option<Figures>,
    /// Cells and portals that are shown.
    pub cells: Cells,
    /// The camera path.
    pub journey: Journey,
    /// Culling costs of the cameras of the path.
    pub measured: Measured,
    /// How the camera outside follows.
    pub chase: Chase,
    /// Figures of drawing.
    pub drawn: Drawn,
    /// The graphics device as one that decides.
    pub device: DeviceStatus,
    /// The scene or path that the user types.
    pub to_open: String,
    /// Whether the help sheet is open.
    pub help: bool,
    /// The tour, while it goes on.
    pub tour: Option<Tour>,
    /// Whether nothing may fly or fade that need not: the system, or the browser, asks for reduced
    /// motion.
    pub calm: bool,
    /// Whether the picture must be drawn again though nothing changed.
    pub refresh: bool,
    /// Whether a picture of the window is to be saved.
    pub shoot: bool,
    /// The picture's size in pixels; zero before the first.
    pub size: [u32; 2],
    loading: Option<(String, Task<Result<World, String>>)>,
    #[cfg(not(target_arch = "wasm32"))]
    chooser: Chooser,
    report: Option<Task<Result<String, String>>>,
    /// The picture of the window that is being saved.
    pub(crate) saving: Option<Task<Result<String, String>>>,
    decider: Decider,
    inbox: Inbox,
    asked: Option<(View, Stages, bool)>,
    /// The scene that is to be shown in place of this one, as soon as it is decided what of it is
    /// drawn.
    next: Option<Arc<World>>,
    /// The subject of `figures`: decision, slot, settings.
    studied: Option<(u64, u32, Study)>,
    /// How many requests there were.
    requests: u64,
    /// The eyes that levels of detail were last chosen for.
    ball: Option<EyeBall>,
    /// Pops of the last decision, where they are shown.
    pub pops: Pops,
    /// Fades from one level of detail to the next.
    pub fades: Fades,
    /// Result of levels alone in the view of the decision, where they fade.
    alone: Option<Box<Visible>>,
    /// The camera as it was last fitted, and to a pane of which size.
    fitted: Option<(Rig, [u32; 2])>,
    /// How the last scene was shown at first.
    manner: Option<Manner>,
    /// Whether the next scene that is loaded gets cameras that fit it, whatever the state says.
    refit: bool,
    /// Whether the renderer does not have all of the scene yet.
    pub uploading: bool,
    /// Whether nothing is settled before all tiles that matter are there: for pictures and tests.
    pub settles: bool,
    /// State of the scene's tiles that follow the eye.
    #[cfg(not(target_arch = "wasm32"))]
    following: following::Following,
    pub(crate) ctx: egui::Context,
}

impl Session {
    /// Begins with a link's text, empty for the default; an invalid one is reported and not
    /// followed. `source`, if there is one, is opened in place of the link's scene; where neither
    /// names any, none is.
    #[must_use]
    pub fn new(ctx: egui::Context, link: &str, source: Option<Source>) -> Self {
        let mut notices = Vec::new();
        let state = link::from_text(link).unwrap_or_else(|error| {
            let text = format!("{error}. The default is shown in its place.");
            notices.push(Notice { text, bad: true, of_scene: false });
            State::default()
        });
        let wake = ctx.clone();
        let mut session = Self {
            world: None,
            decision: None,
            history: VecDeque::new(),
            notices,
            inspected: None,
            truth: Truth::None,
            audit: Audit::default(),
            cutting: Cutting::default(),
            remaking: Remaking::default(),
            figures: None,
            cells: Cells::default(),
            journey: Journey::default(),
            measured: Measured::None,
            chase: Chase::default(),
            drawn: Drawn::default(),
            device: DeviceStatus::default(),
            to_open: String::new(),
            help: false,
            tour: None,
            calm: false,
            refresh: false,
            shoot: false,
            size: [0; 2],
            loading: None,
            #[cfg(not(target_arch = "wasm32"))]
            chooser: Chooser::default(),
            report: None,
            saving: None,
            uploading: false,
            settles: false,
            #[cfg(not(target_arch = "wasm32"))]
            following: Default::default(),
            decider: Decider::new(move || wake.request_repaint()),
            inbox: Inbox::new(ctx.clone()),
            asked: None,
            next: None,
            studied: None,
            requests: 0,
            ball: None,
            pops: Pops::default(),
            fades: Fades::default(),
            alone: None,
            fitted: None,
            manner: None,
            refit: false,
            ctx,
            state,
        };
        // A session that was left without a scene begins without one.
        let linked =
            || Some(Source::of_text(&session.state.scene)).filter(|s| !s.name().is_empty());
        if let Some(source) = source.or_else(linked) {
            session.load(source);
        }
        session
    }

    /// Tells the user.
    pub fn tell(&mut self, text: impl Into<String>, bad: bool) {
        self.notify(Notice { text: text.into(), bad, of_scene: false });
    }

    /// Tells the user something about a scene, which is no news once another is there.
    fn tell_of_scene(&mut self, text: impl Into<String>, bad: bool) {
        self.notify(Notice { text: text.into(), bad, of_scene: true });
    }

    fn notify(&mut self, notice: Notice) {
        if self.notices.last() != Some(&notice) {
            self.notices.push(notice);
        }
        // An old message is no news.
        if self.notices.len() > 4 {
            self.notices.remove(0);
        }
    }

    /// The text of the present state.
    #[must_use]
    pub fn link(&self) -> String {
        link::to_text(&self.state)
    }

    /// Whether every request is answered: nothing is loading, and the decision is about the present
    /// view.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.is_decided() && self.tour.as_ref().is_none_or(Tour::is_settled)
    }

    /// The same, but for what the tour still has to do.
    fn is_decided(&self) -> bool {
        let decided = self.decision.as_ref().map(|d| d.request.number);
        let wanted = self.asked.as_ref().map(|_| self.requests);
        let idle = self.loading.is_none() && !self.journey.is_making();
        #[cfg(not(target_arch = "wasm32"))]
        let idle = idle && (!self.settles || self.has_its_tiles());
        let cut = self.world.is_none() || self.cutting.is_settled(&self.state.cut);
        let sides = self.whole().is_none_or(|w| self.remaking.is_settled(w, &self.alteration()));
        idle && cut
            && sides
            && self.next.is_none()
            && self.audit.is_settled()
            && !matches!(self.truth, Truth::Working(_))
            && !matches!(self.measured, Measured::Working(_))
            && self.report.is_none()
            && !self.cells.is_baking()
            && self.saving.is_none()
            && self.fades.is_empty()
            && !self.uploading
            && !self.device.awaited
            && (self.world.is_none() || decided.is_some() && decided == wanted)
            // A view that moved after the request went out is requested with the next picture.
            && self.culling_view().is_none_or(|view| self.is_asked(&view))
    }

    /// Whether the last request was about a view, with the present settings.
    fn is_asked(&self, view: &View) -> bool {
        let (stages, buffer) = (&self.state.stages, self.state.wants_buffer());
        let fits = |(v, s, b): &(View, Stages, bool)| v == view && s == stages && (*b || !buffer);
        self.asked.as_ref().is_some_and(fits)
    }

    /// Lets `dt` seconds pass, for a picture of `size` pixels: takes in what was loaded and
    /// decided, and asks for a decision where the view or a switch changed.
    pub fn advance(&mut self, dt: f64, size: [u32; 2]) {
        self.size = size.map(|v| v.max(1));
        self.take_chosen();
        self.take_loaded();
        if !self.truth.poll() {
            self.tell("The proof ended without a result.", true);
        }
        if !self.measured.poll() {
            self.tell("The path could not be measured.", true);
        }
        let told = finished(&mut self.report, "The report ended without a result.");
        let saved = finished(&mut self.saving, "The picture was not made.");
        for (text, bad) in told.into_iter().chain(saved) {
            self.tell(text, bad);
        }
        if self.journey.is_making() || self.journey.recording {
            // The costs belong to another path.
            self.measured = Measured::None;
        }
        if let Some(rig) = &mut self.state.camera {
            let trouble = self.journey.advance(dt, rig);
            trouble.into_iter().for_each(|t| self.tell(t, true));
        }
        self.fade(dt);
        self.fit_again();
        #[cfg(not(target_arch = "wasm32"))]
        self.follow_tiles(dt);
        self.beside();
        self.request();
        if let Some(decision) = self.decider.latest() {
            // One that was requested before another scene was opened is about that other one.
            let about = |w: &Option<Arc<World>>| {
                w.as_ref().is_some_and(|w| Arc::ptr_eq(w, &decision.request.world))
            };
            if about(&self.next) {
                // Slots and triangles have other numbers in the scene that follows.
                self.inspected = None;
                self.truth = Truth::None;
                self.world = self.next.take();
                self.take(decision);
            } else if about(&self.world) {
                self.take(decision);
            }
        }
        self.follow_tour(dt);
        self.study();
        self.follow_cells();
    }

    /// Returns how the wanted scene differs from its file.
    fn alteration(&self) -> Alteration {
        let graph = self.whole().and_then(|w| w.model.in_cells().graph());
        let portals = graph.map_or(0, |graph| graph.portals().len());
        let doors = self.state.doors.iter().copied().filter(|&door| (door as usize) < portals);
        let mut doors: Vec<u32> = doors.collect();
        doors.sort_unstable();
        doors.dedup();
        Alteration { sides: self.state.sides, doors }
    }

    /// Goes on with what is made beside the pictures: the scene with other sides, the cut and the
    /// audit.
    fn beside(&mut self) {
        let Some(world) = self.next.clone().or_else(|| self.world.clone()) else { return };
        let whole = self.cutting.whole.as_ref().unwrap_or(&world);
        let wanted = self.alteration();
        let ctx = self.ctx.clone();
        match self.remaking.advance(whole, &wanted, move || ctx.request_repaint()) {
            Some(Ok(next)) => {
                self.next = Some(next);
                // Both were of the scene with its other sides.
                self.cutting = Cutting::default();
                self.measured = Measured::None;
                self.asked = None;
                return;
            }
            Some(Err(text)) => self.tell(format!("{text}. What was shown stays."), true),
            None => {}
        }
        let ctx = self.ctx.clone();
        match self.cutting.advance(&world, &self.state.cut, move || ctx.request_repaint()) {
            Some(Ok(next)) => {
                self.next = Some(next);
                self.asked = None;
            }
            Some(Err(text)) => self.tell(format!("{text}. What was shown stays."), false),
            None => {}
        }
        let ctx = self.ctx.clone();
        if let Some(shown) = self.world.clone() {
            let wanted = self.state.structure.audit;
            let waited = !self.audit.is_settled();
            let told = self.audit.advance(&shown, wanted, move || ctx.request_repaint());
            told.into_iter().for_each(|t| self.tell(t, true));
            // Bounds violations are no part of a decision, so the picture must be drawn again.
            self.refresh |= waited && self.audit.is_settled();
        }
    }

    /// Why back faces of the scene are kept though they are to be culled, if they are: a sentence
    /// for the user.
    #[must_use]
    pub fn kept_backs(&self) -> Option<String> {
        let State { stages, look, .. } = &self.state;
        let wanted = stages.on && stages.backface != Backface::Off && look.cull != CullFace::None;
        let whole = self.whole().filter(|_| wanted)?;
        whole.kept_backs.sentence(whole.counts.triangles)
    }

    fn request(&mut self) {
        let world = self.next.as_ref().or(self.world.as_ref());
        let (Some(world), Some(view)) = (world, self.culling_view()) else { return };
        if self.is_asked(&view) {
            return;
        }
        let (stages, buffer) = (&self.state.stages, self.state.wants_buffer());
        let culler = stages.culler(clock);
        let steady = stages.lod_steady && culler.lod.is_some();
        let world = Arc::clone(world);
        self.asked = Some((view.clone(), stages.clone(), buffer));
        let view = if steady { self.with_ball(view) } else { view };
        self.requests += 1;
        self.decider.request(Request { world, view, culler, buffer, number: self.requests });
    }

    /// A view whose levels of detail are chosen for a ball of eyes, the last one as long as the eye
    /// is in it.
    fn with_ball(&mut self, mut view: View) -> View {
        let [x, y, z, w] = view.eye();
        let rig = self.state.frozen.as_ref().or(self.state.camera.as_ref());
        if let Some(rig) = rig.filter(|_| w != 0.0) {
            let radius = rig.distance * self.state.stages.lod_ball.max(0.0);
            // A ball of another size belongs to another distance.
            let old = self.ball.filter(|b| b.radius >= radius * 0.5 && b.radius <= radius * 2.0);
            let fresh = EyeBall { centre: [x, y, z], radius };
            self.ball = Some(old.unwrap_or(fresh).follow([x, y, z], radius));
            view.eyes = self.ball;
        }
        view
    }

    /// Finds out what popped from the present decision to the next, where that is shown.
    fn follow_pops(&mut self, next: &Decision) {
        let Request { world, view, culler, .. } = &next.request;
        let before = self.decision.as_ref().filter(|d| Arc::ptr_eq(&d.request.world, world));
        match before.filter(|_| self.state.look.colour == Colour::Pops) {
            Some(before) => {
                let both = [&before.visible, &next.visible];
                self.pops.follow(&world.model.scene, both, culler, view);
            }
            None => self.pops = Pops::default(),
        }
    }

    fn take(&mut self, decision: Decision) {
        let all = self.world.as_ref().map_or(1, |w| w.counts.triangles).max(1);
        let share = decision.visible.triangle_count as f32 / all as f32;
        self.history.push_back(Point { share, milliseconds: decision.milliseconds });
        if self.history.len() > HISTORY {
            self.history.pop_front();
        }
        // The inspected instance is explained for the new view.
        let handle = self.inspected.as_ref().map(|i| (i.handle, i.triangle));
        self.follow_pops(&decision);
        self.follow_fades(&decision);
        if let Some(before) = self.decision.replace(decision) {
            self.decider.give_back(before.visible);
        }
        if let Some((handle, triangle)) = handle {
            self.inspect_handle(handle, triangle);
        }
    }
}

/// Takes the message of a finished task, and whether it failed.
fn finished(task: &mut Option<Task<Result<String, String>>>, lost: &str) -> Option<(String, bool)> {
    let told = match task.as_ref()?.poll() {
        Progress::Working => return None,
        Progress::Done(Ok(text)) => (text, false),
        Progress::Done(Err(text)) => (text, true),
        Progress::Lost => (lost.to_owned(), true),
    };
    *task = None;
    Some(told)
}
