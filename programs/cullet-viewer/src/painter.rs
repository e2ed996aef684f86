//! The picture of a session: what of it changed is given to the renderer, and shown to the window
//! as a texture.

use std::sync::Arc;

use cullet::{View, view::CullFace};
use eframe::{egui, egui_wgpu, wgpu};

use crate::compose::{Composition, compose, instance_colours};
use crate::decide::Decision;
use crate::draw::{DeviceView, Paint, Pane, Renderer};
use crate::present::Present;
use crate::session::{Drawn, Inspected, Session};
use crate::state::{Colour, Layout, State};
use crate::task::{SLICE, clock, until};
use crate::world::World;

/// Inputs of a picture: if none of them changed, neither did the picture.
#[derive(Clone, Debug, PartialEq)]
struct PictureKey {
    state: State,
    size: [u32; 2],
    world: Option<*const World>,
    decided: u64,
    inspected: Option<Inspected>,
    proved: bool,
    /// Measurement that the path's colours are of.
    measured: Option<usize>,
    chase: crate::camera::Chase,
}

/// Draws a session's picture, and knows what it drew last.
pub(crate) struct Painter {
    renderer: Renderer,
    present: Present,
    texture: Option<egui::TextureId>,
    render_state: egui_wgpu::RenderState,
    /// The scene that the renderer has.
    uploaded: Option<Arc<World>>,
    /// The scene that it is given piece by piece, and whether that has begun.
    coming: Option<(Arc<World>, bool)>,
    /// Inputs of the instances' colours.
    coloured: Option<(Option<*const World>, u64, bool, Colour)>,
    /// How many instances faded from one level to the next in the last picture.
    faded: usize,
    last: Option<PictureKey>,
    /// The frame of the device whose figures are awaited, and how many pictures more may be drawn
    /// for them.
    awaited: (u64, u32),
    composition: Composition,
}

/// So many pictures a device gets to tell of one.
const MOST_AWAITED: u32 = 60;

impl Painter {
    pub(crate) fn new(render_state: egui_wgpu::RenderState) -> Self {
        Self {
            renderer: Renderer::new(&render_state.adapter, &render_state.device),
            present: Present::new(&render_state.device),
            texture: None,
            uploaded: None,
            coming: None,
            coloured: None,
            faded: 0,
            last: None,
            awaited: (0, 0),
            composition: Composition::default(),
            render_state,
        }
    }

    /// The graphics device.
    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.render_state.device
    }

    /// The picture, if one was drawn.
    pub(crate) fn texture(&self) -> Option<egui::TextureId> {
        self.texture
    }

    /// The panes of the last picture.
    pub(crate) fn composition(&self) -> &Composition {
        &self.composition
    }

    /// Draws the session's picture if it changed, in a frame that began at `began` on the clock,
    /// `dt` seconds after the one before.
    pub(crate) fn paint(&mut self, session: &mut Session, began: u64, dt: f64) {
        if session.world.is_none() && self.uploaded.is_some() {
            self.clear();
        }
        session.uploading = !self.upload(session, began);
        if session.uploading {
            return;
        }
        self.prepare_culling(session);
        let world = self.uploaded.as_ref().map(Arc::as_ptr);
        let decided = session.decision.as_ref().map_or(0, |d| d.number);
        let proved = session.truth.finding().is_some();
        let now = PictureKey {
            state: session.state.clone(),
            size: session.size,
            world,
            decided,
            inspected: session.inspected.clone(),
            proved,
            measured: session.measured.costs().map(|c| Arc::as_ptr(c) as usize),
            chase: session.chase,
        };
        let changed = self.last.as_ref() != Some(&now);
        let again = std::mem::take(&mut session.refresh) || session.state.always;
        let again = self.wait_for_figures(session, changed) || again;
        // Before anything is decided there is nothing to draw: all of a large scene would take
        // long.
        if !(changed || again) || world.is_none() || session.decision.is_none() {
            return;
        }
        self.last = Some(now);
        self.composition = compose(session);
        let drawing = clock();
        let kept = session.decision.as_ref().map(|d: &Decision| &d.visible);
        let panes = self.composition.panes(kept);
        let egui_wgpu::RenderState { device, queue, .. } = &self.render_state;
        let key = (world, decided, proved, session.state.look.colour);
        let uses = |p: &Pane<'_>| p.style.paint == Paint::Instances || p.style.fade;
        // Shares change from picture to picture.
        let fades = session.fades.len();
        let same = self.coloured == Some(key) && fades == 0 && self.faded == 0;
        if panes.iter().any(uses) && !same {
            self.faded = fades;
            self.renderer.set_instance_colours(queue, &instance_colours(session));
            self.coloured = Some(key);
        }
        let ground = if session.state.dark { [0.082, 0.098, 0.122] } else { [0.90, 0.91, 0.92] };
        let by = self.composition.by_device.as_ref().map(|view| device_view(session, view));
        let size = session.size;
        let fresh = self.renderer.draw_by(device, queue, size, ground, &panes, by.as_ref());
        let fresh = self.present.encode(device, queue, self.renderer.colour(), session.size, fresh);
        if let (true, Some(view)) = (fresh, self.present.shown()) {
            let mut egui = self.render_state.renderer.write();
            let filter = wgpu::FilterMode::Linear;
            match self.texture {
                None => self.texture = Some(egui.register_native_texture(device, view, filter)),
                Some(id) => egui.update_egui_texture_from_wgpu_texture(device, view, filter, id),
            }
        }
        let stats = self.renderer.stats();
        let before = session.drawn;
        let smooth = if before.per_second > 0.0 { 0.9 } else { 0.0 };
        let rate = if dt > 0.0 { (1.0 / dt) as f32 } else { 0.0 };
        session.drawn = Drawn {
            milliseconds: (clock() - drawing) as f32 * 1e-6,
            device_ms: stats.device_ms,
            triangles: stats.triangles,
            draws: stats.draws,
            per_second: before.per_second * smooth + rate * (1.0 - smooth),
            pictures: before.pictures + 1,
        };
    }

    /// Gives back all that the scene took, its picture too.
    fn clear(&mut self) {
        if let Some(texture) = self.texture {
            self.render_state.renderer.write().free_texture(&texture);
        }
        *self = Self::new(self.render_state.clone());
    }

    /// Makes the device ready to decide, where it is to. Where it cannot, the CPU goes on.
    fn prepare_culling(&mut self, session: &mut Session) {
        let wanted = session.state.device.on && session.state.stages.on;
        session.device.ready = wanted && session.device.refused.is_none();
        let Some(world) = self.uploaded.as_ref().filter(|_| session.device.ready) else { return };
        let egui_wgpu::RenderState { device, queue, .. } = &self.render_state;
        if let Err(error) = self.renderer.prepare_culling(device, queue, &world.model.scene) {
            session.device.ready = false;
            session.state.device.on = false;
            session.tell(format!("{}: {error}.", world.name), true);
        }
    }

    /// Takes in what the device tells of its pictures; true while the next has to be drawn to hear
    /// more. One that `begins` is told of when the one after it is drawn, too: what it hides is
    /// tested against what it showed.
    fn wait_for_figures(&mut self, session: &mut Session, begins: bool) -> bool {
        if !session.by_device() {
            session.device.awaited = false;
            return false;
        }
        // Callbacks are called when the device is asked.
        let _ = self.device().poll(wgpu::PollType::Poll);
        if begins {
            self.awaited = (self.renderer.device_frames() + 2, MOST_AWAITED);
        }
        let (frame, left) = &mut self.awaited;
        session.device.figures = self.renderer.device_figures();
        session.device.awaited = session.device.figures.frame < *frame && *left > 0;
        if session.device.awaited {
            *left -= 1;
            session.ctx.request_repaint();
        }
        session.device.awaited
    }

    /// Gives the renderer the scene, if it has another; on a page, which has one thread, a piece at
    /// a time. True when it has it.
    fn upload(&mut self, session: &mut Session, began: u64) -> bool {
        let Some(world) = session.world.clone() else { return true };
        if self.uploaded.as_ref().is_some_and(|w| Arc::ptr_eq(w, &world)) {
            return true;
        }
        let egui_wgpu::RenderState { device, queue, .. } = &self.render_state;
        let begun = match &self.coming {
            Some((coming, begun)) if Arc::ptr_eq(coming, &world) => *begun,
            _ => {
                self.coming = Some((Arc::clone(&world), false));
                // The frame that decided what of it is drawn has done enough.
                if clock() >= until(began) {
                    session.ctx.request_repaint();
                    return false;
                }
                false
            }
        };
        if !begun {
            if let Err(error) = self.renderer.begin_scene(device, queue, &world.model) {
                self.coming = None;
                let text = format!("{}: {error}.", world.name);
                session.refuse(self.uploaded.clone(), text);
                // Held on to even where it does not fit, or it would be tried at every frame.
                self.uploaded.get_or_insert(world);
                return true;
            }
            self.coming = Some((Arc::clone(&world), true));
        }
        // The next scenes of a world in tiles come while one flies on.
        let end = if world.is_tiled() { clock() + SLICE } else { until(clock()) };
        if !self.renderer.go_on(queue, &world.model, || clock() < end) {
            session.ctx.request_repaint();
            return false;
        }
        self.coming = None;
        self.coloured = None;
        self.last = None;
        self.uploaded = Some(world);
        true
    }
}

/// Returns what the device is to decide of a view.
fn device_view<'a>(session: &Session, view: &'a View) -> DeviceView<'a> {
    let State { stages, look, device, layout, .. } = &session.state;
    let [width, height] = session.size;
    let half = view.viewport()[0];
    let place = [half, 0, width.saturating_sub(half), height];
    DeviceView {
        view,
        frustum: stages.frustum,
        occlusion: stages.occlusion,
        faces: if look.hardware { look.cull } else { CullFace::None },
        pyramid: (*layout == Layout::Buffer).then(|| (place, device.shown(view.viewport()).0)),
    }
}
