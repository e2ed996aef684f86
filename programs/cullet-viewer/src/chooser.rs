//! The system's dialog that chooses a file to open.

use std::path::PathBuf;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use std::time::{Duration, Instant};

use eframe::egui;

use crate::inbox::ENDINGS;

/// Nobody closes a dialog so soon: it was never there.
const TOO_SOON: Duration = Duration::from_millis(300);

/// A dialog, until something is chosen or not.
type Dialog = Pin<Box<dyn Future<Output = Option<rfd::FileHandle>>>>;

/// A dialog that may be open.
#[derive(Default)]
pub(crate) struct Chooser {
    open: Option<(Instant, Dialog)>,
}

impl std::fmt::Debug for Chooser {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Chooser").field("open", &self.open.is_some()).finish()
    }
}

impl Chooser {
    /// Opens the dialog, unless it is open.
    pub(crate) fn open(&mut self) {
        if self.open.is_none() {
            let dialog = rfd::AsyncFileDialog::new()
                .set_title("Open a 3D scene")
                .add_filter("3D scenes", &ENDINGS)
                .add_filter("All files", &["*"]);
            self.open = Some((Instant::now(), Box::pin(dialog.pick_file())));
        }
    }

    /// Returns the file chosen since the last call, or why no dialog could be opened. `ctx` is
    /// woken when there is something new.
    pub(crate) fn poll(&mut self, ctx: &egui::Context) -> Option<Result<PathBuf, String>> {
        let (since, dialog) = self.open.as_mut()?;
        let waker = Waker::from(Arc::new(Repaint(ctx.clone())));
        let Poll::Ready(chosen) = dialog.as_mut().poll(&mut Context::from_waker(&waker)) else {
            return None;
        };
        let none = since.elapsed() < TOO_SOON;
        self.open = None;
        match chosen {
            Some(file) => Some(Ok(file.path().to_owned())),
            // The dialog's own error only goes to the log.
            None if none => Some(Err("No file dialog can be opened: on Linux it takes xdg-desktop-portal or \
                                      zenity. Type the path beside Open, or drop the file on the window."
                .to_owned())),
            None => None,
        }
    }
}

struct Repaint(egui::Context);

impl Wake for Repaint {
    fn wake(self: Arc<Self>) {
        self.0.request_repaint();
    }
}
