//! Requirements of the viewer's tests beside Rust: a graphics device in software, and a virtual screen.

use crate::runner::{End, Ended, Skip};
use crate::tools::{install, install_words, is_ci, optional};

/// Debian's packages: software Vulkan and OpenGL, a virtual screen, and what a window needs when it starts.
pub(crate) const DEBIAN: &[&str] = &[
    "mesa-vulkan-drivers",
    "libvulkan1",
    "libegl1",
    "xvfb",
    "xauth",
    "libxkbcommon-x11-0",
    "libxcursor1",
    "libxi6",
    "libxrandr2",
];

/// Whether a driver of Vulkan and a virtual screen are there.
pub(crate) fn is_there() -> bool {
    let drivers = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let has_driver =
        |folder: &&str| std::fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some());
    drivers.iter().any(has_driver) && optional("sh", &["-c", "command -v xvfb-run"]).is_some()
}

/// The step that installs what is missing where CI runs and may; elsewhere it names it. What cannot be had is no
/// failure: what needs it is skipped.
pub(crate) fn prepare() -> Ended {
    if is_there() {
        return Ok(End::Passed);
    }
    let skip = |why: String| {
        let what = format!("drawing with the graphics device{why}");
        Ok(End::Skipped(Skip::new(what, install_words(DEBIAN))))
    };
    if !is_ci() {
        return skip(String::new());
    }
    match install(DEBIAN) {
        Ok(()) if is_there() => Ok(End::Passed),
        Ok(()) => skip(", for there is no driver of Vulkan".to_owned()),
        Err(e) => skip(format!(": {e}")),
    }
}
