//! `cullet report` of what is shown: the scene and its camera path, or the camera alone.

use std::fmt::Write as _;
use std::path::Path;
#[cfg(not(target_arch = "wasm32"))]
use std::path::PathBuf;

use cullet::Backface;
use cullet::cull::detail::Measure;

use crate::state::{Sides, Stages};

/// Inputs of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportOrder {
    /// The scene as the command line takes it; a file by its path.
    pub scene: String,
    /// The camera path as JSON.
    pub cameras: String,
    /// How many there are.
    pub views: usize,
    /// Pixels of a view.
    pub size: [u32; 2],
    /// Settings of the report.
    pub stages: Stages,
    /// Sides of the scene's triangles in the report.
    pub sides: Sides,
}

/// The most views of a report: each is drawn and proved, which takes its time.
pub const MOST_VIEWS: usize = 16;

impl ReportOrder {
    /// The arguments of `cullet`, for a path file and a folder to write into.
    #[must_use]
    pub fn arguments(&self, cameras: &Path, out: &Path) -> Vec<String> {
        let s = &self.stages;
        let [w, h] = self.size;
        let mut args: Vec<String> = vec!["report".to_owned(), self.scene.clone()];
        let mut add = |name: &str, value: String| args.extend([name.to_owned(), value]);
        add("--path", format!("file:{}", cameras.display()));
        add("--views", self.views.clamp(1, MOST_VIEWS).to_string());
        add("--size", format!("{w}x{h}"));
        add("--out", out.display().to_string());
        if s.on && s.detail_px > 0.0 {
            add("--detail", s.detail_px.to_string());
            let by = match s.detail_by {
                Measure::WidthAndHeight => "sides",
                Measure::Area => "area",
                Measure::Diameter => "diameter",
            };
            add("--detail-by", by.to_owned());
        }
        if s.on && s.lod_px > 0.0 {
            add("--lod", s.lod_px.to_string());
            if s.lod_triangles > 0 {
                add("--lod-triangles", s.lod_triangles.to_string());
            }
        }
        if s.on && s.occlusion {
            add("--occlusion-width", s.occlusion_width.to_string());
            add("--occlusion-budget", s.occlusion_budget.to_string());
        }
        for (given, name) in [
            (s.on && s.lod_px > 0.0 && s.lod_corners, "--lod-corners"),
            (!(s.on && s.frustum), "--no-frustum"),
            (!(s.on && s.portal), "--no-portal"),
            (!s.on || s.backface == Backface::Off, "--no-backface"),
            (!(s.on && s.degenerate), "--no-degenerate"),
            (!(s.on && s.occlusion), "--no-occlusion"),
            (s.on && s.frustum && s.frustum_exact, "--exact-frustum"),
            (self.sides == Sides::OneSided, "--one-sided"),
            (self.sides == Sides::TwoSided, "--two-sided"),
        ] {
            if given {
                args.push(name.to_owned());
            }
        }
        args
    }

    /// The command as one types it.
    #[must_use]
    pub fn command(&self, cameras: &Path, out: &Path) -> String {
        let mut line = "cullet".to_owned();
        for arg in self.arguments(cameras, out) {
            // An option is one that stands there as such.
            let word = if arg.starts_with("--") { arg } else { cullet_io::shell_word(&arg) };
            let _ = write!(line, " {word}");
        }
        line
    }

    /// The program that makes it, if it is beside this one or in PATH.
    #[cfg(not(target_arch = "wasm32"))]
    #[must_use]
    pub fn program(&self) -> Option<PathBuf> {
        find()
    }

    /// Writes the cameras to a file and runs `cullet report`, from beside this program or from
    /// PATH. What is to be told comes back: where the report is, or what went wrong and what to
    /// type.
    ///
    /// # Errors
    /// In words for the user.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn run(&self) -> Result<String, String> {
        let folder = PathBuf::from("cullet-report");
        let cameras = folder.join("cameras.json");
        std::fs::create_dir_all(&folder)
            .and_then(|()| std::fs::write(&cameras, &self.cameras))
            .map_err(|e| format!("{} cannot be written: {e}.", cameras.display()))?;
        let command = self.command(&cameras, &folder);
        let Some(program) = self.program() else {
            return Err(format!(
                "The program 'cullet' is neither beside this one nor in PATH. The cameras are in {}; type: {command}",
                cameras.display()
            ));
        };
        let ended = std::process::Command::new(&program)
            .args(self.arguments(&cameras, &folder))
            .stdin(std::process::Stdio::null())
            .stdout(std::process::Stdio::null())
            .output()
            .map_err(|e| format!("{} cannot be started: {e}.", program.display()))?;
        let page = folder.join("index.html");
        let page = page.canonicalize().unwrap_or(page);
        match ended.status.code() {
            Some(0) => Ok(format!("The report is in {}.", page.display())),
            Some(1) => {
                Err(format!("The report found something visible dropped: {}.", page.display()))
            }
            _ => {
                let told = String::from_utf8_lossy(&ended.stderr);
                let last =
                    told.lines().rfind(|l| l.starts_with("error")).unwrap_or("it says nothing");
                Err(format!("The report was not made: {last}. By hand: {command}"))
            }
        }
    }
}

/// The program beside this one, or in PATH.
#[cfg(not(target_arch = "wasm32"))]
fn find() -> Option<PathBuf> {
    let name = format!("cullet{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|p| Some(p.parent()?.to_owned()));
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let all = beside.into_iter().chain(std::env::split_paths(&folders));
    all.map(|folder| folder.join(&name)).find(|path| path.is_file())
}
