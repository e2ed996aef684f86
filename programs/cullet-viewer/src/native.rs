//! The command line and the window.

use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use cullet_viewer::app::{App, Start, has_failed, setup};
use cullet_viewer::bench::BenchError;
use cullet_viewer::device::Watch;
use cullet_viewer::link;
use cullet_viewer::script::Script;
use cullet_viewer::state::{Sides, State};
use cullet_viewer::world::{Source, World};
use eframe::egui;

const HELP: &str = "\
Shows what of a 3D scene need not be drawn, and why

Usage: cullet-viewer [SCENE|FILE] [options]

  --state LINK         the text that Copy link gives: scene, camera and every switch
  --one-sided          take every triangle for one-sided, whatever the file says
  --two-sided          take every triangle for two-sided, whatever the file says
  --tour               begin with the tour of what culling does
  --calm               reduced motion: nothing flies or fades that need not
  --size WxH           the window in points (default 1280x800)
  --screenshot FILE    write a picture of the window as PNG, and end
  --script NAME        without a user: throw every switch (toggles), give every order that a button gives
                       (orders), or lose the graphics device (lose-device); then end
  --bench              measure what each stage saves the graphics card, without a window, and end
  --bench-culling      measure what deciding takes for a camera that stands, turns and flies, and end
  --help, --version

Examples
  cullet-viewer                          the built-in city
  cullet-viewer --tour                   every kind of culling, with a question each
  cullet-viewer model.glb                a file: GLB, glTF, OBJ, PLY, STL, OFF
  cullet-viewer scan.ply --one-sided     a scan with small holes: its back faces are culled all the same
  cullet-viewer forest:n=100000          a built-in scene with a setting (cullet scenes lists them)
  cullet-viewer city:n=1e8               a world that is larger than memory, tile by tile
  cullet-viewer city/tileset.json        the same of a folder that cullet tiles wrote
  cullet-viewer city --state 'layout=split&ghosts.form=solid'
  cullet-viewer office --size 960x600 --screenshot office.png

Exit codes
  0 fine     2 wrong command line     3 input unreadable or invalid (of an unattended run)
  1 culling changed a picture (of --bench)   69 no window or no graphics device";

/// A device that is lost so soon after the window was opened again stays lost.
const TOO_SOON: Duration = Duration::from_secs(60);

/// Argument that the viewer passes to itself when it opens a window again.
const AGAIN: &str = "--after-lost-device";

/// The parsed command line.
struct CommandLine {
    start: Start,
    size: [f32; 2],
    bench: Option<Measurement>,
    /// Said in the link too; a measurement follows none.
    sides: Sides,
    /// Whether it is opened again after its device was lost.
    again: bool,
}

/// A measurement that is run in place of a window.
#[derive(Clone, Copy)]
enum Measurement {
    Drawing,
    Culling,
}

/// Reads the command line; what is to be printed in place of a window is the error, with the exit
/// code.
fn parse(mut args: impl Iterator<Item = String>) -> Result<CommandLine, (u8, String)> {
    let wrong = |text: String| (2, format!("error: {text}\nTry cullet-viewer --help."));
    let mut line = CommandLine {
        start: Start::default(),
        size: [1280.0, 800.0],
        bench: None,
        sides: Sides::Automatic,
        again: false,
    };
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or_else(|| wrong(format!("{arg} needs a value")));
        match arg.as_str() {
            "--help" | "-h" => return Err((0, HELP.to_owned())),
            "--version" | "-V" => {
                return Err((0, format!("cullet-viewer {}", env!("CARGO_PKG_VERSION"))));
            }
            "--state" => {
                let text = value()?;
                // A whole address serves too.
                line.start.link = text.rsplit_once('#').map_or(text.clone(), |(_, l)| l.to_owned());
            }
            AGAIN => line.again = true,
            "--one-sided" | "--two-sided" => {
                let sides = if arg == "--one-sided" { Sides::OneSided } else { Sides::TwoSided };
                if ![Sides::Automatic, sides].contains(&line.sides) {
                    return Err(wrong("--one-sided and --two-sided exclude each other".to_owned()));
                }
                line.sides = sides;
            }
            "--calm" => line.start.calm = true,
            "--tour" => line.start.tour = true,
            "--bench" => line.bench = Some(Measurement::Drawing),
            "--bench-culling" => line.bench = Some(Measurement::Culling),
            "--screenshot" => line.start.screenshot = Some(value()?),
            "--script" => {
                let name = value()?;
                let there_is = "there is toggles, orders and lose-device";
                line.start.script = Script::of_name(&name)
                    .ok_or_else(|| wrong(format!("there is no script '{name}'; {there_is}")))?;
            }
            "--size" => {
                let text = value()?;
                let parsed = text.split_once('x').and_then(|(w, h)| {
                    let side = |t: &str| t.parse().ok().filter(|v| (64..=8192).contains(v));
                    Some([side(w)?, side(h)?].map(|v: u16| f32::from(v)))
                });
                let must = "must be WxH with sides of 64 to 8192, as in 960x600";
                line.size = parsed.ok_or_else(|| wrong(format!("--size {text}: {must}")))?;
            }
            _ if arg.starts_with('-') => return Err(wrong(format!("there is no option {arg}"))),
            _ if line.start.source.is_some() => {
                return Err(wrong(format!("one scene at a time: '{arg}' is a second")));
            }
            _ => line.start.source = Some(Source::of_text(&arg)),
        }
    }
    if line.sides != Sides::Automatic {
        // The last value of a key in a link holds.
        let said = State { sides: line.sides, ..State::default() };
        line.start.link.push_str(&format!("&{}", link::to_text(&said)));
    }
    Ok(line)
}

/// State that outlives a closed window.
#[derive(Default)]
struct Left {
    /// Whether an unattended run told of trouble.
    trouble: AtomicBool,
    /// The listener on the graphics device, and the state that was shown last.
    shown: Mutex<Option<(Watch, State)>>,
}

impl Left {
    /// Why the graphics device was lost, if it was, and the state that was shown.
    fn lost(&self) -> Option<(String, State)> {
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let (watch, state) = shown.as_ref()?;
        Some((watch.lost()?, state.clone()))
    }
}

/// Keeps what an unattended run is judged by, and what is to be shown again.
struct Judged {
    app: App,
    unattended: bool,
    left: Arc<Left>,
}

impl eframe::App for Judged {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.app.ui(ui, frame);
        let shown = (self.app.watch().clone(), self.app.session().state.clone());
        *self.left.shown.lock().unwrap_or_else(PoisonError::into_inner) = Some(shown);
        if self.app.watch().lost().is_some() {
            // Later reports of a lost device tell nothing new.
            return;
        }
        if self.unattended
            && self.app.has_trouble()
            && !self.left.trouble.swap(true, Ordering::Relaxed)
        {
            for notice in self.app.session().notices.iter().filter(|n| n.bad) {
                let _ = writeln!(std::io::stderr(), "error: {}", notice.text);
            }
        }
    }
}

/// Measures, without a window.
fn bench(start: &Start, what: Measurement, sides: Sides) -> ExitCode {
    let told = |code: u8, text: String| {
        let _ = writeln!(std::io::stderr(), "error: {text}");
        ExitCode::from(code)
    };
    let source = start.source.clone().unwrap_or_else(|| Source::of_text("city"));
    let loaded = World::load(&source).and_then(|mut world| {
        world.set_sides(sides)?;
        Ok(world)
    });
    let world = match loaded {
        Ok(world) => world,
        Err(error) => return told(3, error),
    };
    if let Measurement::Culling = what {
        return match cullet_viewer::pace::run(world, &mut std::io::stdout().lock()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => told(3, format!("the table cannot be written: {error}")),
        };
    }
    match cullet_viewer::bench::run(&world, &mut std::io::stdout().lock()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(pixels) => told(1, format!("culling changed {pixels} pixels")),
        Err(error @ BenchError::Device(_)) => told(69, error.to_string()),
        Err(error) => told(3, error.to_string()),
    }
}

/// Runs the program.
pub(crate) fn run() -> ExitCode {
    let line = match parse(std::env::args().skip(1)) {
        Ok(line) => line,
        Err((code, text)) => {
            let _ = if code == 0 {
                writeln!(std::io::stdout(), "{text}")
            } else {
                writeln!(std::io::stderr(), "{text}")
            };
            return ExitCode::from(code);
        }
    };
    if let Some(what) = line.bench {
        return bench(&line.start, what, line.sides);
    }
    let began = Instant::now();
    let (size, calm, screenshot) = (line.size, line.start.calm, line.start.screenshot.clone());
    let left = Arc::new(Left::default());
    let again = line.again;
    if let Err(error) = window(line, &left) {
        let _ = writeln!(
            std::io::stderr(),
            "error: no window can be opened: {error}\n\
             The viewer needs a display, and Vulkan, Metal, DirectX 12 or OpenGL. On a machine without a \
             graphics card, install software Vulkan (Debian: mesa-vulkan-drivers libvulkan1); without a \
             display, run it under xvfb-run. cullet report needs neither."
        );
        return ExitCode::from(69);
    }
    if let Some((reason, state)) = left.lost() {
        let link = link::to_text(&state);
        if again && began.elapsed() < TOO_SOON {
            return lost_for_good(&reason, &link);
        }
        return reopen(&reason, &link, size, calm, screenshot);
    }
    if left.trouble.load(Ordering::Relaxed) || has_failed() {
        return ExitCode::from(3);
    }
    ExitCode::SUCCESS
}

fn lost_for_good(reason: &str, link: &str) -> ExitCode {
    let _ = writeln!(
        std::io::stderr(),
        "error: {reason}, and the window cannot go on. Another graphics driver may help, or a smaller scene. \
         This goes on where you were: cullet-viewer --state '{}'",
        link.replace('\'', r"'\''")
    );
    ExitCode::from(69)
}

/// Opens the window again with what it showed, in a program of its own: little of what drew can be
/// trusted after its device was lost.
fn reopen(
    reason: &str,
    link: &str,
    [w, h]: [f32; 2],
    calm: bool,
    screenshot: Option<String>,
) -> ExitCode {
    let _ =
        writeln!(std::io::stderr(), "note: {reason}. The window opens again with what it showed.");
    let Ok(program) = std::env::current_exe() else { return lost_for_good(reason, link) };
    let mut command = std::process::Command::new(program);
    command.args([AGAIN, "--state", link, "--size", &format!("{w}x{h}")]);
    if calm {
        command.arg("--calm");
    }
    if let Some(path) = screenshot {
        command.args(["--screenshot", &path]);
    }
    match command.status() {
        Ok(status) => {
            let code = status.code().and_then(|code| u8::try_from(code).ok());
            ExitCode::from(code.unwrap_or(69))
        }
        Err(_) => lost_for_good(reason, link),
    }
}

/// Opens the window, until it is closed, or until its device is lost.
fn window(line: CommandLine, left: &Arc<Left>) -> eframe::Result {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("cullet")
            .with_inner_size(line.size)
            .with_min_inner_size([320.0, 200.0]),
        wgpu_options: setup(None),
        ..Default::default()
    };
    let start = line.start;
    let unattended = start.screenshot.is_some() || start.script != Script::None;
    let own = Arc::clone(left);
    let make = Box::new(move |cc: &eframe::CreationContext<'_>| {
        let app = App::new(cc, start)?;
        Ok(Box::new(Judged { app, unattended, left: own }) as Box<dyn eframe::App>)
    });
    // The panels' renderer panics when a buffer is refused, as it is after the loss of the device.
    // That is no fault to be shown; any other is.
    let (before, quiet) = (panic::take_hook(), Arc::clone(left));
    panic::set_hook(Box::new(move |info| {
        if quiet.lost().is_none() {
            before(info);
        }
    }));
    let ran = panic::catch_unwind(AssertUnwindSafe(|| eframe::run_native("cullet", options, make)));
    match ran {
        Ok(result) => result,
        Err(_) if left.lost().is_some() => Ok(()),
        Err(fault) => panic::resume_unwind(fault),
    }
}
