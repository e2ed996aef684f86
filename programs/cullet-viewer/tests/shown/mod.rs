//! Panels without a window, for tests: keys are pressed and buttons clicked as a user would, and
//! what is shown is read.

#![allow(dead_code, reason = "no test uses all of it")]

use std::time::{Duration, Instant};

use cullet_viewer::compose::{Composition, compose};
use cullet_viewer::session::Session;
use cullet_viewer::ui::{self, Shown};
use cullet_viewer::world::Source;
use eframe::egui::accesskit::TreeUpdate;
use eframe::egui::{self, Event, Key, OutputCommand, PointerButton, Pos2, Shape};

/// High enough that nothing is scrolled out of sight.
pub(crate) const SIZE: egui::Vec2 = egui::vec2(1400.0, 2400.0);

/// A session with its panels.
pub(crate) struct Panels {
    pub(crate) ctx: egui::Context,
    pub(crate) session: Session,
    size: egui::Vec2,
    time: f64,
    /// The text that was copied last.
    pub(crate) copied: Option<String>,
    /// Texts of the last frame and where their middles are.
    pub(crate) texts: Vec<(String, Pos2)>,
    /// The same with all of where they are, of those that are shown in full.
    pub(crate) places: Vec<(String, egui::Rect)>,
    /// Tree that screen readers are told, once `ctx` was asked to make it.
    pub(crate) tree: Option<TreeUpdate>,
}

impl Panels {
    pub(crate) fn open(scene: &str, link: &str) -> Self {
        Self::open_in(SIZE, scene, link)
    }

    pub(crate) fn open_in(size: egui::Vec2, scene: &str, link: &str) -> Self {
        let ctx = egui::Context::default();
        let session = Session::new(ctx.clone(), link, Some(Source::of_text(scene)));
        let mut panels = Self {
            ctx,
            session,
            size,
            time: 0.0,
            copied: None,
            texts: Vec::new(),
            places: Vec::new(),
            tree: None,
        };
        panels.settle();
        panels
    }

    pub(crate) fn frame(&mut self, events: Vec<Event>) {
        self.time += 0.1;
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(self.time),
            max_texture_side: Some(8192),
            events,
            ..Default::default()
        };
        let session = &mut self.session;
        let mut out = self.ctx.run_ui(input, |ui| {
            ui::show(ui, session, |session, size| {
                session.advance(0.1, size);
                let made = session.world.as_ref().map(|_| compose(session));
                (Shown::default(), made.unwrap_or_else(Composition::default))
            });
        });
        out.textures_delta.clear();
        for command in out.platform_output.commands {
            if let OutputCommand::CopyText(text) = command {
                self.copied = Some(text);
            }
        }
        self.tree = out.platform_output.accesskit_update;
        self.places.clear();
        self.texts.clear();
        for shape in &out.shapes {
            read(&shape.shape, shape.clip_rect, &mut self.texts, &mut self.places);
        }
    }

    pub(crate) fn settle(&mut self) {
        let began = Instant::now();
        while !self.session.is_settled() || self.session.world.is_none() {
            self.frame(Vec::new());
            assert!(began.elapsed() < Duration::from_secs(240), "it does not settle");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Takes a camera path of the scene's own, and stays where it begins: a camera that moves on is
    /// never decided for.
    pub(crate) fn travel(&mut self) {
        self.session.travel(cullet_scenes::paths::PathSpec::Orbit);
        while self.session.journey.is_making() {
            self.frame(Vec::new());
            std::thread::sleep(Duration::from_millis(2));
        }
        self.session.journey.playing = false;
        self.settle();
    }

    pub(crate) fn press(&mut self, key: Key) {
        for pressed in [true, false] {
            let modifiers = egui::Modifiers::NONE;
            let event = Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
            self.frame(vec![event]);
        }
    }

    pub(crate) fn click(&mut self, label: &str) {
        // Panels that opened just now reach their places after some frames.
        (0..4).for_each(|_| self.frame(Vec::new()));
        let at = self.texts.iter().find(|(text, _)| text == label);
        let at = at.unwrap_or_else(|| panic!("'{label}' is not shown: {:?}", self.texts)).1;
        self.frame(vec![Event::PointerMoved(at)]);
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Primary, egui::Modifiers::NONE);
            self.frame(vec![Event::PointerButton { pos: at, button, pressed, modifiers }]);
        }
    }

    /// All that a key or a button can change.
    pub(crate) fn look(&self) -> String {
        let s = &self.session;
        let j = &s.journey;
        let flags = [s.help, s.refresh, s.shoot, j.playing, j.recording, s.inspected.is_some()];
        let flags = (flags, s.tour.is_some());
        format!("{:?} {flags:?} {:?} {} {:?}", s.state, s.truth, j.at, self.copied)
    }
}

fn read(
    shape: &Shape,
    clip: egui::Rect,
    texts: &mut Vec<(String, Pos2)>,
    places: &mut Vec<(String, egui::Rect)>,
) {
    match shape {
        Shape::Vec(all) => all.iter().for_each(|s| read(s, clip, texts, places)),
        Shape::Text(text) => {
            let rect = text.visual_bounding_rect();
            texts.push((text.galley.text().to_owned(), rect.center()));
            // A point of what letters reach beyond their place is no loss.
            if !text.galley.elided && clip.expand(1.0).contains_rect(rect) {
                places.push((text.galley.text().to_owned(), rect));
            }
        }
        _ => {}
    }
}
