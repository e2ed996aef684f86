//! `cullet film`: a short clip that shows one thing.

mod args;
mod dolly;
mod freeze;
mod path;
mod portal;
mod script;
mod volume;

use std::path::{Path, PathBuf};

use crate::animation::Animation;
use cullet_command::console::{Console, count, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::replace;
use cullet_command::inputs;
use cullet_draw::Picture;
use cullet_io::Model;

use args::Subject;
pub(crate) use args::{FilmArgs, HELP};
use cullet_cli::levels;
use script::Script;

/// Runs the command.
pub(crate) fn run(args: &FilmArgs, console: &Console) -> Outcome {
    let model = load(args, console)?;
    let frames = match args.of {
        Subject::Freeze => film(&mut freeze::Freeze::new(&model, args)?, args, console)?,
        Subject::Volume => film(&mut volume::Volume::new(&model, args)?, args, console)?,
        Subject::Portal => film(&mut portal::Portal::new(&model, args)?, args, console)?,
        Subject::Dolly => film(&mut dolly::Dolly::new(&model, args)?, args, console)?,
    };
    let out = args.out.clone().unwrap_or_else(|| format!("{}.webp", args.of.name()).into());
    let made = Animation::new(&frames, args.fps, args.colors).map_err(Failure::usage)?;
    let bytes = write(&made, &out)?;
    console.line(format!(
        "{} written: {} of {}x{} at {} a second, {}",
        out.display(),
        count(made.frame_count() as u64, "frame", "frames"),
        made.size()[0],
        made.size()[1],
        args.fps,
        size_words(bytes)
    ));
    Ok(Exit::Fine)
}

/// Loads the scene with all that its culling needs.
fn load(args: &FilmArgs, console: &Console) -> Result<Model, Failure> {
    let mut model = levels::load(&args.scene, &args.cull, console)?;
    inputs::give_occluders(&mut model, &args.cull, console)?;
    if model.scene.instance_count() == 0 {
        let name = &model.name;
        return Err(Failure::input(format!("{name}: there is no instance, so nothing to film")));
    }
    model.scene.prepare(&inputs::culler(&args.cull));
    Ok(model)
}

fn film(
    script: &mut dyn Script,
    args: &FilmArgs,
    console: &Console,
) -> Result<Vec<Picture>, Failure> {
    let count = args.count();
    let mut bar = console.progress("frames", count.into());
    let mut frames = Vec::with_capacity(count as usize);
    for number in 0..count {
        if interrupted() {
            let message = format!("stopped after {number} of {count} frames; no film is written");
            return Err(Failure { exit: Exit::Interrupted, message });
        }
        frames.push(script.frame(f64::from(number) / f64::from(count))?);
        bar.step();
    }
    bar.finish();
    Ok(frames)
}

/// Writes a film; how many bytes the animated file has.
fn write(film: &Animation, out: &Path) -> Result<usize, Failure> {
    let ending = out.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let bytes = match ending.as_deref() {
        Some("png" | "apng") => film.to_apng(),
        Some("webp") => film.to_webp(),
        Some(other @ ("gif" | "mp4" | "webm" | "avif")) => {
            return Err(Failure::usage(format!(
                "{}: no .{other} is written; try .webp or .png, or a folder for single frames",
                out.display()
            )));
        }
        _ => return write_frames(film, out),
    };
    replace(out, &bytes)?;
    Ok(bytes.len())
}

/// Writes each frame, and the film.
fn write_frames(film: &Animation, folder: &Path) -> Result<usize, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::write(folder, &e))?;
    for number in 0..film.frame_count() {
        let path: PathBuf = folder.join(format!("{number:04}.png"));
        replace(&path, &film.frame(number).to_png())?;
    }
    let bytes = film.to_webp();
    replace(&folder.join("film.webp"), &bytes)?;
    Ok(bytes.len())
}

/// A size in words: bytes of a small file, else KiB or MiB.
fn size_words(bytes: usize) -> String {
    const KIB: f64 = 1024.0;
    let size = bytes as f64;
    match bytes {
        0..10_240 => count(bytes as u64, "byte", "bytes"),
        _ if size < KIB * KIB => format!("{:.0} KiB", size / KIB),
        _ => format!("{:.2} MiB", size / KIB / KIB),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_short() {
        assert_eq!(size_words(1), "1 byte");
        assert_eq!(size_words(20_480), "20 KiB");
        assert_eq!(size_words(1_572_864), "1.50 MiB");
    }
}
