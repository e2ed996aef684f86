//! Listens to the graphics device while the viewer runs: it may report an error, or be lost.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::{egui, wgpu};

/// Reports of a device.
#[derive(Debug, Default)]
struct Said {
    lost: Option<String>,
    error: Option<String>,
}

/// Listens to a device.
#[derive(Clone, Debug)]
pub struct Watch {
    said: Arc<Mutex<Said>>,
}

impl Watch {
    /// Begins to listen. Without it an error of the device would end the program. `ctx` is woken
    /// when something is said.
    pub(crate) fn new(device: &wgpu::Device, ctx: &egui::Context) -> Self {
        let watch = Self { said: Arc::default() };
        let (told, wake) = (watch.clone(), ctx.clone());
        device.set_device_lost_callback(move |reason, message| {
            let text = lost_text(reason, &message);
            log::error!("{text}");
            // Told at once, since the next drawing may end the page's program.
            #[cfg(target_arch = "wasm32")]
            crate::web::tell_lost(&text);
            told.with(|said| said.lost = Some(text));
            wake.request_repaint();
        });
        let (told, wake) = (watch.clone(), ctx.clone());
        device.on_uncaptured_error(Arc::new(move |error| {
            log::error!("{error}");
            told.with(|said| said.error = Some(error_text(&error)));
            wake.request_repaint();
        }));
        watch
    }

    /// Why the device is gone, if it is.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        self.with(|said| said.lost.clone())
    }

    /// The newest error since the last call, in words for the user.
    pub(crate) fn error(&self) -> Option<String> {
        self.with(|said| said.error.take())
    }

    fn with<T>(&self, look: impl FnOnce(&mut Said) -> T) -> T {
        look(&mut self.said.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn lost_text(reason: wgpu::DeviceLostReason, message: &str) -> String {
    let why = match (reason, message.trim()) {
        (wgpu::DeviceLostReason::Destroyed, "") => "it was closed",
        (_, "") => "the driver does not say why",
        (_, message) => message.trim_end_matches('.'),
    };
    format!("the graphics device was lost: {why}")
}

fn error_text(error: &wgpu::Error) -> String {
    match error {
        wgpu::Error::OutOfMemory { .. } => "The graphics device is out of memory, so the picture may be wrong or old. Close \
             other programs that draw, make the window smaller, switch high quality off, or open a smaller scene."
            .to_owned(),
        error => {
            // The first line says what, those below where in our code.
            let text = error.to_string();
            let what = text.lines().map(str::trim).rfind(|l| !l.is_empty()).unwrap_or("it does not say why");
            format!(
                "The graphics device refused to draw, so the picture may be wrong or old: {what}. R draws again; \
                 if it stays, another graphics driver may help."
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_names_the_cause_and_what_to_try() {
        let unknown = wgpu::DeviceLostReason::Unknown;
        assert!(lost_text(unknown, "").ends_with("the driver does not say why"));
        assert!(lost_text(unknown, "GPU hang.").ends_with("was lost: GPU hang"));
        assert!(lost_text(wgpu::DeviceLostReason::Destroyed, " ").ends_with("it was closed"));
        let full = wgpu::Error::OutOfMemory { source: "none left".into() };
        assert!(error_text(&full).contains("smaller scene"));
        let wrong = wgpu::Error::Validation {
            source: "bad".into(),
            description: "Validation Error\n\nCaused by:\n  buffer is too small\n".to_owned(),
        };
        let text = error_text(&wrong);
        assert!(
            text.contains(": buffer is too small.") && text.contains("R draws again"),
            "{text}"
        );
    }
}
