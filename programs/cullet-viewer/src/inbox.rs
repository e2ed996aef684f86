//! Files that a browser reads in its own time, and which of several is the model.

use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui;

/// Result of reading files: their names and bytes, the model first; or the name of one that could
/// not be read, and why.
pub type Read = Result<Vec<(String, Vec<u8>)>, (String, String)>;

/// Returns which of several files is the model, and how many more models there are; the others may
/// be files that it names. The first is taken where none has the ending of a model.
#[must_use]
pub fn model_of<'a>(names: impl IntoIterator<Item = &'a str>) -> (usize, usize) {
    let models: Vec<usize> = names
        .into_iter()
        .enumerate()
        .filter(|(_, name)| {
            let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
            ENDINGS.iter().any(|e| ending.eq_ignore_ascii_case(e))
        })
        .map(|(number, _)| number)
        .collect();
    (models.first().copied().unwrap_or(0), models.len().saturating_sub(1))
}

/// Endings of the formats that are read.
pub const ENDINGS: [&str; 8] = ["glb", "gltf", "obj", "ply", "stl", "off", "occscn", "bsp"];

/// Where files arrive when they are read.
#[derive(Debug)]
pub struct Inbox {
    /// For those who read.
    sender: Sender<Read>,
    receiver: Receiver<Read>,
    ctx: egui::Context,
}

impl Inbox {
    /// An empty one.
    #[must_use]
    pub fn new(ctx: egui::Context) -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, ctx }
    }

    /// Returns a sender that puts read files into it and wakes the window.
    pub fn slot(&self) -> impl Fn(Read) + Send + 'static {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        move |read| {
            // The session that would show it may be gone.
            let _ = sender.send(read);
            ctx.request_repaint();
        }
    }

    /// Takes the files that arrived since the last call.
    pub fn take(&self) -> Vec<Read> {
        self.receiver.try_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_is_found_among_what_it_names() {
        assert_eq!(model_of(["Fox.bin", "Texture.png", "Fox.GLTF"]), (2, 0));
        assert_eq!(model_of(["a.mtl", "a.obj", "b.stl", "c.glb"]), (1, 2));
        assert_eq!(model_of(["notes.txt", "gltf"]), (0, 0));
        assert_eq!(model_of([]), (0, 0));
    }
}
