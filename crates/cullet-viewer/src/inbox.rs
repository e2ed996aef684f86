//! Files that a browser reads in its own time.

use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui;

/// What came of reading a file: its name, and its bytes or why not.
pub type Read = (String, Result<Vec<u8>, String>);

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

    /// What puts a file into it, from wherever it was read, and wakes the window.
    pub fn slot(&self) -> impl Fn(Read) + Send + 'static {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        move |read| {
            // The session that would show it may be gone.
            let _ = sender.send(read);
            ctx.request_repaint();
        }
    }

    /// What arrived since the last call.
    pub fn take(&self) -> Vec<Read> {
        self.receiver.try_iter().collect()
    }
}
