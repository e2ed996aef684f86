//! What goes on while the viewer is open: the scene, the state, decisions, and all that is not a picture.
//! It needs no window and no graphics, so tests run it as it is.

use std::collections::VecDeque;
use std::sync::Arc;

use cullet::{Explanation, Handle, View};
use eframe::egui;
use glam::DVec3;

use crate::audit::Audit;
use crate::camera::{Chase, Mode, Rig};
use crate::cost::Measured;
use crate::cutaway::Cutting;
use crate::decide::{Decider, Decision, Request, pick};
use crate::inbox::{Inbox, Read};
use crate::journey::{Journey, json};
use crate::link;
use crate::outcodes::Coded;
use crate::report::{MOST_VIEWS, Order};
use crate::state::{GhostForm, Layout, Stages, State};
use crate::study::{self, Cube, Figures, Seen, Study};
use crate::task::{Progress, Task, clock};
use crate::truth::Truth;
use crate::world::{Source, World};

/// Decisions that the history graph remembers.
pub const HISTORY: usize = 240;

/// A message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// What it says.
    pub text: String,
    /// Whether something went wrong.
    pub bad: bool,
}

/// What a decision came to, for the history graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Triangles left, of all.
    pub share: f32,
    /// Milliseconds of culling.
    pub milliseconds: f32,
}

/// What drawing took.
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

/// What the user clicked, and why it is drawn or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// The thing.
    pub handle: Handle,
    /// Its slot.
    pub slot: u32,
    /// The triangle that was hit.
    pub triangle: u32,
    /// The stages that it came to.
    pub explanation: Explanation,
    /// The decision that this is about.
    pub decided: u64,
}

/// Everything but the graphics.
#[derive(Debug)]
pub struct Session {
    /// What is shown and how.
    pub state: State,
    /// The scene.
    pub world: Option<Arc<World>>,
    /// The newest decision.
    pub decision: Option<Decision>,
    /// What decisions came to.
    pub history: VecDeque<Point>,
    /// What the user is told.
    pub notices: Vec<Notice>,
    /// What was clicked.
    pub inspected: Option<Inspected>,
    /// The proof for a view.
    pub truth: Truth,
    /// What leaves its bounds.
    pub audit: Audit,
    /// The cut-away.
    pub cutting: Cutting,
    /// What bounds prove of the back faces of what is inspected.
    pub figures: Option<Figures>,
    /// The camera path.
    pub journey: Journey,
    /// What the cameras of the path cost.
    pub measured: Measured,
    /// How the camera outside follows.
    pub chase: Chase,
    /// What drawing took.
    pub drawn: Drawn,
    /// What the user types to open.
    pub to_open: String,
    /// Whether the help sheet is open.
    pub help: bool,
    /// Whether the picture must be drawn again though nothing changed.
    pub refresh: bool,
    /// The picture's size in pixels; zero before the first.
    pub size: [u32; 2],
    loading: Option<(String, Task<Result<World, String>>)>,
    report: Option<Task<Result<String, String>>>,
    decider: Decider,
    inbox: Inbox,
    asked: Option<(View, Stages, bool)>,
    /// The scene that is to be shown in place of this one, as soon as it is decided what of it is drawn.
    next: Option<Arc<World>>,
    /// What `figures` are about: decision, slot, settings.
    studied: Option<(u64, u32, Study)>,
    /// How many requests there were.
    requests: u64,
    /// Whether the next scene that is loaded gets cameras that fit it, whatever the state says.
    refit: bool,
    ctx: egui::Context,
}

impl Session {
    /// Begins with a link's text, empty for the default; nonsense is told and not followed. `source`, if
    /// there is one, is opened in place of the link's scene.
    #[must_use]
    pub fn new(ctx: egui::Context, link: &str, source: Option<Source>) -> Self {
        let mut notices = Vec::new();
        let state = link::from_text(link).unwrap_or_else(|error| {
            let text = format!("{error}. The default is shown in its place.");
            notices.push(Notice { text, bad: true });
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
            figures: None,
            journey: Journey::default(),
            measured: Measured::None,
            report: None,
            chase: Chase::default(),
            drawn: Drawn::default(),
            to_open: String::new(),
            help: false,
            refresh: false,
            size: [0; 2],
            loading: None,
            decider: Decider::new(move || wake.request_repaint()),
            inbox: Inbox::new(ctx.clone()),
            asked: None,
            next: None,
            studied: None,
            requests: 0,
            refit: false,
            ctx,
            state,
        };
        let source = source.unwrap_or_else(|| Source::of_text(&session.state.scene));
        session.load(source);
        session
    }

    /// Opens another scene; the cameras will fit it. What is open stays until it is loaded.
    pub fn open(&mut self, source: Source) {
        self.refit = true;
        self.load(source);
    }

    /// Reads a file that was dropped on the page; [`dropped`](Self::dropped) has it when it is read.
    #[cfg(target_arch = "wasm32")]
    pub fn read_dropped(&mut self, file: egui::DroppedFileHandle) {
        let put = self.inbox.slot();
        wasm_bindgen_futures::spawn_local(async move {
            let name = file.path().display().to_string();
            put((name, file.bytes_async().await));
        });
    }

    /// Files that were read since the last call.
    pub fn dropped(&mut self) -> Vec<Read> {
        self.inbox.take()
    }

    /// Tells the user.
    pub fn tell(&mut self, text: impl Into<String>, bad: bool) {
        let notice = Notice { text: text.into(), bad };
        if self.notices.last() != Some(&notice) {
            self.notices.push(notice);
        }
        // An old message is no news.
        if self.notices.len() > 4 {
            self.notices.remove(0);
        }
    }

    /// The name of what is being loaded.
    #[must_use]
    pub fn loading(&self) -> Option<&str> {
        self.loading.as_ref().map(|(name, _)| name.as_str())
    }

    /// The text of the present state.
    #[must_use]
    pub fn link(&self) -> String {
        link::to_text(&self.state)
    }

    /// Whether all that was asked for is there: nothing is loading, and the decision is about the present
    /// view.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let decided = self.decision.as_ref().map(|d| d.request.number);
        let wanted = self.asked.as_ref().map(|_| self.requests);
        let idle = self.loading.is_none() && !self.journey.is_making();
        let cut = self.world.is_none() || self.cutting.is_settled(&self.state.cut);
        idle && cut
            && self.next.is_none()
            && self.audit.is_settled()
            && !matches!(self.truth, Truth::Working(_))
            && !matches!(self.measured, Measured::Working(_))
            && self.report.is_none()
            && (self.world.is_none() || decided.is_some() && decided == wanted)
    }

    /// Lets `dt` seconds pass, for a picture of `size` pixels: takes in what was loaded and decided, and asks
    /// for a decision where the view or a switch changed.
    pub fn advance(&mut self, dt: f64, size: [u32; 2]) {
        self.size = size.map(|v| v.max(1));
        self.take_loaded();
        if !self.truth.poll() {
            self.tell("The proof ended without a result.", true);
        }
        if !self.measured.poll() {
            self.tell("The path could not be measured.", true);
        }
        match self.report.as_ref().map(Task::poll) {
            None | Some(Progress::Working) => {}
            Some(done) => {
                self.report = None;
                match done {
                    Progress::Done(Ok(text)) => self.tell(text, false),
                    Progress::Done(Err(text)) => self.tell(text, true),
                    _ => self.tell("The report ended without a result.", true),
                }
            }
        }
        if self.journey.is_making() || self.journey.recording {
            // What was measured is about another path.
            self.measured = Measured::None;
        }
        if let Some(rig) = &mut self.state.camera {
            let trouble = self.journey.advance(dt, rig);
            trouble.into_iter().for_each(|t| self.tell(t, true));
        }
        self.beside();
        self.ask();
        if let Some(decision) = self.decider.latest() {
            // One that was asked for before another scene was opened is about that other one.
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
        self.study();
    }

    /// Goes on with what is made beside the pictures: the cut and the audit.
    fn beside(&mut self) {
        let Some(world) = self.next.clone().or_else(|| self.world.clone()) else { return };
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
            // What it found is no part of a decision.
            self.refresh |= waited && self.audit.is_settled();
        }
    }

    /// Studies the back faces of what is inspected, where anything of that changed.
    fn study(&mut self) {
        let settings = &self.state.study;
        let wanted = (settings.by != study::By::None).then_some((
            &self.world,
            &self.decision,
            &self.inspected,
        ));
        let Some((Some(world), Some(decision), Some(inspected))) = wanted else {
            (self.figures, self.studied) = (None, None);
            return;
        };
        let key = (decision.number, inspected.slot, settings.clone());
        if self.studied.as_ref() != Some(&key) {
            let scene = &world.model.scene;
            let view = &decision.request.view;
            let (mesh, transform) = (scene.mesh(inspected.slot), scene.transform(inspected.slot));
            self.figures = Some(Seen { mesh, transform, view }.study(settings));
            self.studied = Some(key);
        }
    }

    /// The triangle that was clicked against the planes of the culling view.
    #[must_use]
    pub fn coded(&self) -> Option<Coded> {
        let (world, inspected) = (self.world.as_ref()?, self.inspected.as_ref()?);
        let (scene, view) = (&world.model.scene, &self.decision.as_ref()?.request.view);
        let slot = inspected.slot;
        Coded::new(view, scene.mesh(slot), scene.transform(slot), inspected.triangle)
    }

    /// The cube of directions: of what is inspected in its own space, or else of the whole culling view.
    #[must_use]
    pub fn cube(&self) -> Option<Cube> {
        let (world, decision) = (self.world.as_ref()?, self.decision.as_ref()?);
        let view = &decision.request.view;
        let cone = match &self.inspected {
            Some(i) => {
                let scene = &world.model.scene;
                Seen { mesh: scene.mesh(i.slot), transform: scene.transform(i.slot), view }.cone()
            }
            None => study::sight(view),
        };
        Cube::new(self.state.study.cells, cone)
    }

    /// The scene as it was before it was cut.
    #[must_use]
    pub fn whole(&self) -> Option<&Arc<World>> {
        self.cutting.whole.as_ref().or(self.world.as_ref())
    }

    /// Looks straight at the cut, from far away through a narrow lens, so that it is drawn almost to scale.
    pub fn face_cut(&mut self) {
        let Some(world) = self.whole() else { return };
        let Some(plane) = self.state.cut.planes(world).first().copied() else { return };
        let (reach, centre) = (world.reach, DVec3::from(world.centre));
        let inside = self.state.cut.part == crate::cutaway::Part::Inside;
        let n = DVec3::from(plane.normal) * if inside { 1.0 } else { -1.0 };
        let foot = centre - DVec3::from(plane.normal) * plane.distance(centre);
        // Looking against the normal; straight down or up there is no heading to keep.
        let d = -n;
        let fov: f64 = 4.0;
        let distance = reach * 1.05 / (fov.to_radians() * 0.5).tan();
        self.state.camera = Some(Rig {
            mode: Mode::Orbit,
            target: foot.into(),
            distance,
            yaw: if d.x.hypot(d.z) > 1e-6 { (-d.x).atan2(-d.z).to_degrees() } else { 0.0 },
            pitch: d.y.clamp(-1.0, 1.0).asin().to_degrees().clamp(-89.0, 89.0),
            fov,
            near: distance * 0.5,
        });
        self.state.frozen = None;
    }

    /// The rig that decides what is drawn.
    #[must_use]
    pub fn culling_rig(&self) -> Option<&Rig> {
        self.state.frozen.as_ref().or(self.state.camera.as_ref())
    }

    /// The size of the pane that shows what the culling camera sees.
    #[must_use]
    pub fn culling_size(&self) -> [u32; 2] {
        match self.state.layout {
            Layout::Split | Layout::Buffer => [(self.size[0] / 2).max(1), self.size[1]],
            _ => self.size,
        }
    }

    /// The view that decides what is drawn.
    #[must_use]
    pub fn culling_view(&self) -> Option<View> {
        let mut view = self.culling_rig()?.view(self.culling_size()).ok()?;
        view.cull_face = self.state.look.cull_face();
        view.front_face = self.state.look.front_face();
        Some(view)
    }

    /// Freezes what is drawn, or lets it follow the flown camera again.
    pub fn toggle_freeze(&mut self) {
        self.state.frozen = match self.state.frozen.take() {
            Some(_) => None,
            None => self.state.camera,
        };
    }

    /// Freezes what is drawn and goes out to look at it; the way back is the frozen camera's place.
    pub fn toggle_outside(&mut self) {
        match self.state.frozen.take() {
            Some(back) => self.state.camera = Some(back),
            None => {
                self.state.frozen = self.state.camera;
                self.state.camera = self.outside();
            }
        }
    }

    /// The camera behind and above the culling one.
    #[must_use]
    pub fn outside(&self) -> Option<Rig> {
        let reach = self.world.as_ref()?.reach;
        Some(self.culling_rig()?.outside(reach, &self.chase))
    }

    /// Fits the flown camera to the scene.
    pub fn fit(&mut self) {
        if let Some(world) = &self.world {
            let mode = self.state.camera.map_or(Mode::Orbit, |c| c.mode);
            let rig = world.overview(self.size);
            self.state.camera = Some(match mode {
                Mode::Top => world.top(&Rig { target: world.centre, distance: 0.0, ..rig }),
                mode => Rig { mode, ..rig },
            });
        }
    }

    /// How much nearer the flown camera is than the one that shows the whole scene: 1 is that, 2 twice as near.
    #[must_use]
    pub fn scale(&self) -> f64 {
        match (&self.world, &self.state.camera) {
            (Some(world), Some(rig)) => world.reach * 2.0 / rig.distance,
            _ => 1.0,
        }
    }

    /// Inspects what is seen at a pixel of a view: what is drawn, and ghosts that are shown as they are.
    /// Nothing there ends the inspection.
    pub fn inspect(&mut self, view: &View, pixel: [f64; 2]) {
        let (Some(world), Some(ray)) = (&self.world, view.ray(pixel)) else { return };
        let scene = &world.model.scene;
        let visible = self.decision.as_ref().map(|d| &d.visible);
        let reason =
            |slot: u32| visible.and_then(|v| v.reasons.get(slot as usize).copied().flatten());
        let shown = |slot: u32| match reason(slot) {
            Some(reason) => {
                self.state.ghosts.form == GhostForm::Solid && !self.hides(reason.stage.name())
                    || !self.state.stages.on
            }
            None => true,
        };
        let boxed = self.state.ghosts.form == GhostForm::Boxes;
        let hit = pick(scene, &ray, shown).or_else(|| {
            // Outlines are clicked where nothing that is drawn lies on the way.
            let ghost = |s: u32| boxed && reason(s).is_some_and(|r| !self.hides(r.stage.name()));
            pick(scene, &ray, ghost)
        });
        let found = hit.and_then(|hit| Some((scene.handle(hit.slot)?, hit.triangle)));
        self.inspected = None;
        if let Some((handle, triangle)) = found {
            self.inspect_handle(handle, triangle);
        }
    }

    /// Inspects an instance by its slot.
    pub fn inspect_slot(&mut self, slot: u32) {
        let handle = self.world.as_ref().and_then(|w| w.model.scene.handle(slot));
        if let Some(handle) = handle {
            self.inspect_handle(handle, 0);
        }
    }

    /// Inspects an instance by its handle.
    pub fn inspect_handle(&mut self, handle: Handle, triangle: u32) {
        let (Some(world), Some(decision)) = (&self.world, &self.decision) else { return };
        let Request { view, culler, .. } = &decision.request;
        let scene = &world.model.scene;
        let (slot, explanation) = match (scene.slot(handle), culler.explain(scene, view, handle)) {
            (Ok(slot), Ok(explanation)) => (slot, explanation),
            (Err(error), _) => return self.tell(error.to_string(), true),
            (_, Err(error)) => return self.tell(error.to_string(), true),
        };
        let decided = decision.number;
        self.inspected = Some(Inspected { handle, slot, triangle, explanation, decided });
    }

    /// Whether ghosts of a stage are switched off.
    #[must_use]
    pub fn hides(&self, stage: &str) -> bool {
        self.state.ghosts.hidden.iter().any(|h| h == stage)
    }

    /// Begins the proof for the present view and settings.
    pub fn prove(&mut self) {
        if let (Some(world), Some(view)) = (&self.world, self.culling_view()) {
            let ctx = self.ctx.clone();
            let culler = self.state.stages.culler(clock);
            let wake = move || ctx.request_repaint();
            self.truth = Truth::start(Arc::clone(world), view, culler, wake);
        }
    }

    /// Begins to measure what every camera of the path costs with the present settings.
    pub fn measure(&mut self) {
        if let Some(world) = &self.world {
            let ctx = self.ctx.clone();
            let (stages, look) = (self.state.stages.clone(), self.state.look.clone());
            let wake = move || ctx.request_repaint();
            let (world, rigs) = (Arc::clone(world), self.journey.rigs.clone());
            let size = self.culling_size();
            self.measured = Measured::start(world, rigs, size, stages, look, wake);
        }
    }

    /// What a report of the present scene, path and settings is made of: of a path cameras that are spread over it,
    /// without one the camera that culls.
    #[must_use]
    pub fn order(&self) -> Option<Order> {
        let size = self.culling_size().map(|v| v.max(1));
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let rigs = match self.journey.rigs.as_slice() {
            [] => vec![*self.culling_rig()?],
            rigs => {
                let views = rigs.len().min(MOST_VIEWS);
                let last = (rigs.len() - 1) as f64 / (views.max(2) - 1) as f64;
                (0..views).map(|i| rigs[(i as f64 * last).round() as usize]).collect()
            }
        };
        let views = rigs.len();
        let (scene, stages) = (self.state.scene.clone(), self.state.stages.clone());
        Some(Order { scene, cameras: json(&rigs, aspect).ok()?, views, size, stages })
    }

    /// Whether a report is being made.
    #[must_use]
    pub fn is_reporting(&self) -> bool {
        self.report.is_some()
    }

    /// Begins to make a report with `cullet report`.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn make_report(&mut self) {
        if let Some(order) = self.order() {
            let ctx = self.ctx.clone();
            self.report = Some(Task::start(move || order.run(), move || ctx.request_repaint()));
        }
    }

    /// Begins to make and play one of the scene's own camera paths.
    pub fn travel(&mut self, path: cullet_io::paths::PathSpec) {
        if let Some(world) = &self.world {
            let ctx = self.ctx.clone();
            self.journey.make(Arc::clone(world), path, move || ctx.request_repaint());
        }
    }

    fn load(&mut self, source: Source) {
        let ctx = self.ctx.clone();
        let name = source.name();
        let wake = move || ctx.request_repaint();
        #[cfg(not(target_arch = "wasm32"))]
        let task = Task::start(move || World::load(&source), wake);
        #[cfg(target_arch = "wasm32")]
        let task = crate::web::load(source, wake);
        self.loading = Some((name, task));
    }

    fn take_loaded(&mut self) {
        let Some((name, task)) = &self.loading else { return };
        match task.poll() {
            Progress::Working => return,
            Progress::Done(Ok(world)) => self.show(world),
            Progress::Done(Err(error)) => {
                let stays = if self.world.is_some() { " What was open stays open." } else { "" };
                self.refit = false;
                self.tell(format!("{error}.{stays}"), true);
            }
            Progress::Lost => {
                let text = format!("{name}: loading ended without a result: a fault of cullet.");
                self.tell(text, true);
            }
        }
        self.loading = None;
    }

    fn show(&mut self, world: World) {
        for warning in world.model.warnings.iter().take(2) {
            let text = format!("{}: {warning}", world.name);
            self.tell(text, false);
        }
        if world.counts.triangles == 0 {
            self.tell(format!("{} has no triangle to show.", world.name), true);
        }
        self.enter(Arc::new(world));
    }

    fn enter(&mut self, world: Arc<World>) {
        self.state.scene.clone_from(&world.name);
        self.world = Some(world);
        if std::mem::take(&mut self.refit) {
            self.state.camera = None;
            self.state.frozen = None;
        }
        if self.state.camera.is_none() {
            self.state.camera = self.world.as_ref().map(|w| w.first_sight(self.size));
        }
        self.asked = None;
        self.next = None;
        self.cutting = Cutting::default();
        self.decision = None;
        self.history.clear();
        self.inspected = None;
        self.truth = Truth::None;
        self.journey = Journey::default();
        self.measured = Measured::None;
    }

    /// Goes back to the scene that was open before, since the new one cannot be drawn.
    pub fn refuse(&mut self, before: Option<Arc<World>>, why: String) {
        if let Some(whole) = self.cutting.whole.clone().filter(|_| self.state.cut.on) {
            self.state.cut.on = false;
            self.tell(format!("{why} It is shown whole."), true);
            return self.enter(whole);
        }
        match before {
            Some(world) => {
                self.tell(format!("{why} What was open stays open."), true);
                self.state.camera = None;
                self.state.frozen = None;
                self.enter(world);
            }
            None => self.tell(why, true),
        }
    }

    fn ask(&mut self) {
        let world = self.next.as_ref().or(self.world.as_ref());
        let (Some(world), Some(view)) = (world, self.culling_view()) else { return };
        let (stages, buffer) = (&self.state.stages, self.state.wants_buffer());
        let fits = |(v, s, b): &(View, Stages, bool)| *v == view && s == stages && (*b || !buffer);
        if self.asked.as_ref().is_some_and(fits) {
            return;
        }
        let culler = stages.culler(clock);
        let world = Arc::clone(world);
        self.asked = Some((view.clone(), stages.clone(), buffer));
        self.requests += 1;
        self.decider.ask(Request { world, view, culler, buffer, number: self.requests });
    }

    fn take(&mut self, decision: Decision) {
        let all = self.world.as_ref().map_or(1, |w| w.counts.triangles).max(1);
        let share = decision.visible.triangle_count as f32 / all as f32;
        self.history.push_back(Point { share, milliseconds: decision.milliseconds });
        if self.history.len() > HISTORY {
            self.history.pop_front();
        }
        // What is inspected is explained for the new view.
        let handle = self.inspected.as_ref().map(|i| (i.handle, i.triangle));
        self.decision = Some(decision);
        if let Some((handle, triangle)) = handle {
            self.inspect_handle(handle, triangle);
        }
    }
}
