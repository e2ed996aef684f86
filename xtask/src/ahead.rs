//! Builds for hosts and other machines, begun before their steps. Most steps leave one of two cores idle, and what these
//! build is shared with no other step, so that a step finds it done, or waits for the rest of it.

use std::fs::{self, File};
use std::process::{Child, Command, Stdio};

use crate::bindings::{bevy, c, godot, web};
use crate::changed;
use crate::platforms;
use crate::tools::{Done, target};

/// The builds for a step.
struct Build {
    step: &'static str,
    run: fn() -> Done,
}

/// In the order in which the steps run.
const BUILDS: [Build; 5] = [
    Build { step: "host-c", run: c::build_ahead },
    Build { step: "host-web", run: || web::build().map(drop) },
    Build { step: "host-bevy", run: bevy::build },
    Build { step: "host-godot", run: || godot::build().map(drop) },
    Build { step: "platforms", run: platforms::build_ahead },
];

/// Starts this program once more to build, behind everything else that runs; `None` where that cannot
/// be done, for each step builds what it lacks.
pub(crate) fn begin() -> Option<Child> {
    fs::create_dir_all(target()).ok()?;
    let said = File::create(target().join("ahead.log")).ok()?;
    let mut ahead = Command::new("nice");
    ahead.args(["-n", "15"]).arg(std::env::current_exe().ok()?).arg("ahead");
    ahead.stdin(Stdio::null()).stderr(said.try_clone().ok()?).stdout(said);
    ahead.spawn().ok()
}

/// Builds for the steps that will run. What fails here fails again in its step, which says so.
pub(crate) fn build() -> Done {
    for build in BUILDS.iter().filter(|build| !changed::is_kept(build.step)) {
        if let Err(why) = (build.run)() {
            println!("{}: {why}", build.step);
        }
    }
    Ok(())
}
