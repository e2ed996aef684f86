//! The window: a session, and the renderer that draws it.

use std::sync::Arc;

use eframe::{egui, egui_wgpu, wgpu};

use crate::camera::Rig;
use crate::compose::{Composition, Role};
use crate::device::Watch;
use crate::draw::Renderer;
use crate::link;
use crate::painter::Painter;
use crate::script::{self, Script, Step};
use crate::session::Session;
use crate::snapshot;
use crate::state::State;
use crate::task::clock;
use crate::ui::{self, Shown};
use crate::world::Source;

/// Frames that a step of a script, or what a screenshot shows, gets to settle in.
const FRAMES_TO_SETTLE: u32 = 3;

/// Decisions that a screenshot waits for after the first, whose time is that of a program that
/// finds everything cold. An even number: the camera goes aside, and back.
const WARM_UPS: u32 = 4;

/// How the viewer starts.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// Scene to open; the link's where it is `None`.
    pub source: Option<Source>,
    /// The text of a state.
    pub link: String,
    /// A file to write a picture of the window to, and end.
    pub screenshot: Option<String>,
    /// Whether nothing may fly or fade that need not.
    pub calm: bool,
    /// Whether the tour begins as soon as there is a scene.
    pub tour: bool,
    /// Steps to run without a user, one after the other, before the viewer ends.
    pub script: Script,
}

/// The viewer.
pub struct App {
    session: Session,
    painter: Painter,
    last_frame: u64,
    screenshot: Option<String>,
    script: Option<std::vec::IntoIter<Step>>,
    /// Whether the tour is still to begin.
    tour: bool,
    watch: Watch,
    /// Why the graphics device is gone.
    lost: Option<String>,
    settled: u32,
    /// Decisions that a screenshot still waits for, and where the cameras stood.
    warm_ups: u32,
    before: [Option<Rig>; 2],
    #[cfg_attr(
        not(target_arch = "wasm32"),
        expect(dead_code, reason = "only a page has an address")
    )]
    address: String,
}

impl std::fmt::Debug for App {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("App").field("session", &self.session).finish_non_exhaustive()
    }
}

impl App {
    /// Begins in a window that eframe made.
    ///
    /// # Errors
    /// If the window has no wgpu device.
    pub fn new(cc: &eframe::CreationContext<'_>, start: Start) -> Result<Self, String> {
        let render_state = cc
            .wgpu_render_state
            .clone()
            .ok_or("there is no graphics device: the viewer needs Vulkan, Metal, DirectX 12, WebGPU or WebGL2")?;
        let info = render_state.adapter.get_info();
        log::info!("{:?} {}", info.backend, info.name);
        style(&cc.egui_ctx);
        #[cfg(target_arch = "wasm32")]
        cc.egui_ctx.add_plugin(crate::web::Mirror);
        let mut session = Session::new(cc.egui_ctx.clone(), &start.link, start.source);
        session.calm = start.calm;
        if start.calm {
            cc.egui_ctx.all_styles_mut(|style| style.animation_time = 0.0);
        }
        session.settles = start.screenshot.is_some() || start.script != Script::None;
        session.device.refused = Renderer::refuses_culling(&render_state.adapter);
        Ok(Self {
            session,
            last_frame: clock(),
            screenshot: start.screenshot,
            script: (start.script != Script::None).then(|| start.script.steps().into_iter()),
            tour: start.tour,
            watch: Watch::new(&render_state.device, &cc.egui_ctx),
            lost: None,
            settled: 0,
            warm_ups: WARM_UPS,
            before: [None; 2],
            address: start.link,
            painter: Painter::new(render_state),
        })
    }

    /// The session that is shown.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The same, to change it.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }
}

/// A quieter, denser style than the default: a small window holds all panels.
fn style(ctx: &egui::Context) {
    // Secondary text must be readable as well: its luminance differs from the background's by a
    // factor of six.
    for (theme, grey) in [(egui::Theme::Dark, 155), (egui::Theme::Light, 92)] {
        ctx.style_mut_of(theme, |style| {
            style.visuals.weak_text_color = Some(egui::Color32::from_gray(grey));
        });
    }
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 3.0);
        style.spacing.button_padding = egui::vec2(5.0, 1.0);
        style.spacing.interact_size.y = 17.0;
        style.spacing.icon_width = 13.0;
        style.interaction.tooltip_delay = 0.3;
        for (kind, font) in &mut style.text_styles {
            font.size = match kind {
                egui::TextStyle::Small => 10.5,
                egui::TextStyle::Heading => 15.0,
                _ => 12.0,
            };
        }
    });
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        let now = clock();
        let dt = ((now - self.last_frame) as f64 * 1e-9).min(0.25);
        self.last_frame = now;
        self.listen(&ctx);
        #[cfg(target_arch = "wasm32")]
        crate::web::obey(&mut self.session);
        if self.tour && self.session.loading().is_none() {
            self.tour = false;
            self.session.tour_on();
        }
        let Self { session, painter, lost, .. } = self;
        let lost = lost.is_some();
        ui::show(ui, session, |session, size| {
            session.advance(dt, size);
            if lost {
                // Nothing more can be drawn with it.
                return (Shown::default(), Composition::default());
            }
            painter.paint(session, now, dt);
            (Shown { texture: painter.texture() }, painter.composition().clone())
        });
        if self.session.state.always
            || self.session.journey.playing
            || self.session.journey.recording
        {
            ctx.request_repaint();
        }
        if std::mem::take(&mut self.session.shoot) {
            self.session.saving = Some(snapshot::save(&ctx));
        }
        if self.session.saving.is_some() {
            // WebGL hands pixels over only to who asks, and nobody does while nothing is drawn.
            let _ = self.painter.device().poll(wgpu::PollType::Poll);
            ctx.request_repaint();
        }
        self.unattended(&ctx);
        #[cfg(target_arch = "wasm32")]
        self.tell_page();
    }

    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(&mut *self)
    }
}

impl App {
    /// Takes in what the graphics device said. One that is lost ends the window: what was shown is
    /// in [`link`](Self::link), to begin again with.
    fn listen(&mut self, ctx: &egui::Context) {
        if let Some(error) = self.watch.error() {
            self.session.tell(error, true);
        }
        if self.lost.is_none() {
            self.lost = self.watch.lost();
            if self.lost.is_some() {
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// The listener on the graphics device; it outlives the window.
    #[must_use]
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// Steps of a script, and the screenshot at its end.
    fn unattended(&mut self, ctx: &egui::Context) {
        if self.screenshot.is_none() && self.script.is_none() {
            return;
        }
        ctx.request_repaint();
        // A camera that moves on is never decided for.
        self.session.journey.playing = false;
        let pictures = self.session.drawn.pictures > 0 || self.session.loading().is_none();
        self.settled = if self.session.is_settled() && pictures { self.settled + 1 } else { 0 };
        if self.settled < FRAMES_TO_SETTLE {
            return;
        }
        self.settled = 0;
        if let Some(steps) = &mut self.script {
            if let Some(step) = steps.next() {
                log::info!("{step:?}");
                match step {
                    Step::Throw(toggle) => match script::thrown(&self.session.state, toggle) {
                        Some(state) => self.session.state = state,
                        None => {
                            self.session.tell(format!("'{toggle}' is not a part of a link"), true);
                        }
                    },
                    Step::Order(_, order) => order(&mut self.session),
                    Step::Lose => {
                        let device = self.painter.device();
                        device.destroy();
                        // A device that is lost says so at once; one that is destroyed, when it is
                        // asked.
                        let _ = device.poll(wgpu::PollType::Poll);
                    }
                }
                return;
            }
            self.script = None;
            if self.screenshot.is_none() {
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
        if self.screenshot.is_some() && self.warm_ups > 0 {
            self.warm_ups -= 1;
            self.nudge(self.warm_ups % 2 == 1);
            return;
        }
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(path) = self.screenshot.take() {
            snapshot::shoot(ctx, path);
        }
    }

    /// Turns the cameras by a little, or puts them back, so that what is drawn is decided once
    /// more.
    fn nudge(&mut self, aside: bool) {
        let State { camera, frozen, .. } = &mut self.session.state;
        if !aside {
            [*camera, *frozen] = self.before;
            return;
        }
        self.before = [*camera, *frozen];
        for rig in [camera, frozen].into_iter().flatten() {
            rig.turn(0.1, 0.0);
        }
    }

    /// Whether a message says that something went wrong.
    #[must_use]
    pub fn has_trouble(&self) -> bool {
        self.session.notices.iter().any(|n| n.bad)
    }

    /// Keeps the page's address and its attributes in step, for links and for tests: the counters,
    /// the notices and whether all is settled.
    #[cfg(target_arch = "wasm32")]
    fn tell_page(&mut self) {
        let link = link::to_text(&self.session.state);
        // An address that changes at every frame of a turn would drown the browser's history.
        let still = !self.session.journey.playing;
        if link != self.address && still && self.session.is_settled() {
            crate::web::set_address(&link);
            self.address = link;
        }
        crate::web::tell(&self.session);
    }

    /// The panes of the last picture, with what they are for.
    #[must_use]
    pub fn panes(&self) -> Vec<(Role, [u32; 4])> {
        self.painter.composition().panels.iter().map(|p| (p.role, p.place)).collect()
    }

    /// The text of the present state.
    #[must_use]
    pub fn link(&self) -> String {
        link::to_text(&self.session.state)
    }
}

/// Whether an unattended run could not write its picture.
#[cfg(not(target_arch = "wasm32"))]
#[must_use]
pub fn has_failed() -> bool {
    snapshot::FAILED.load(std::sync::atomic::Ordering::Relaxed)
}

/// How eframe asks for the device: the adapter's own limits, so that large scenes fit where the
/// card can hold them, and a clock where it has one. `backends` restricts where to look.
#[must_use]
pub fn setup(backends: Option<wgpu::Backends>) -> egui_wgpu::WgpuConfiguration {
    let mut new = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    if let Some(backends) = backends {
        new.instance_descriptor.backends = backends;
    }
    new.device_descriptor = Arc::new(|adapter: &wgpu::Adapter| wgpu::DeviceDescriptor {
        label: Some("cullet"),
        required_limits: adapter.limits(),
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..Default::default()
    });
    egui_wgpu::WgpuConfiguration { wgpu_setup: new.into(), ..Default::default() }
}
