//! Pictures of the window.

use eframe::egui;

use crate::task::Task;

/// Takes a picture of the window with the next frame and saves it where the user finds it; what is
/// to be told of it comes back.
pub(crate) fn save(ctx: &egui::Context) -> Task<Result<String, String>> {
    let (send, task) = Task::waiting();
    let wake = ctx.clone();
    take(ctx, move |image| {
        // Nobody listens any more when the window is closed.
        let _ = send.send(keep(image));
        wake.request_repaint();
    });
    task
}

fn take(ctx: &egui::Context, done: impl FnOnce(&egui::ColorImage) + Send + 'static) {
    let save = egui::ScreenshotCallback::new(move |image| done(&image));
    ctx.send_viewport_cmd(egui::ViewportCommand::Screenshot(save));
    ctx.request_repaint();
}

#[cfg(target_arch = "wasm32")]
fn keep(image: &egui::ColorImage) -> Result<String, String> {
    crate::web::download(image)?;
    Ok("The picture is among the downloads.".to_owned())
}

#[cfg(not(target_arch = "wasm32"))]
use native::keep;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use native::{FAILED, shoot};

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use std::fs::File;
    use std::io;
    use std::path::Path;
    use std::sync::atomic::{AtomicBool, Ordering};

    use eframe::egui;

    /// Whether an unattended run failed at something.
    pub(crate) static FAILED: AtomicBool = AtomicBool::new(false);

    /// The most pictures of one name in a folder.
    const MOST: u32 = 9999;

    /// Saves it in the present folder, beside those that are there.
    pub(super) fn keep(image: &egui::ColorImage) -> Result<String, String> {
        for i in 1..=MOST {
            let name = format!("cullet-{i}.png");
            match File::create_new(&name) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(format!("{name} cannot be written: {error}.")),
                Ok(file) => {
                    write(file, image).map_err(|e| format!("{name} cannot be written: {e}."))?;
                    let path = Path::new(&name).canonicalize().unwrap_or(name.into());
                    return Ok(format!("The picture is in {}.", path.display()));
                }
            }
        }
        Err(format!("There are {MOST} pictures here already: move some away."))
    }

    /// Takes the picture of an unattended run, and closes the window.
    pub(crate) fn shoot(ctx: &egui::Context, path: String) {
        let done = ctx.clone();
        super::take(ctx, move |image| {
            if let Err(error) = File::create(&path).and_then(|file| write(file, image)) {
                // Nobody looks at a window that is about to close.
                log::error!("{path}: {error}");
                use std::io::Write as _;
                let _ = writeln!(io::stderr(), "error: {path} cannot be written: {error}");
                FAILED.store(true, Ordering::Relaxed);
            }
            done.send_viewport_cmd(egui::ViewportCommand::Close);
        });
    }

    fn write(file: File, image: &egui::ColorImage) -> io::Result<()> {
        let [width, height] = image.size.map(|v| v as u32);
        let mut encoder = png::Encoder::new(io::BufWriter::new(file), width, height);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        writer.write_image_data(image.as_raw()).map_err(io::Error::other)?;
        writer.finish().map_err(io::Error::other)
    }
}
