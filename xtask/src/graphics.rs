//! What the viewer's tests need beside Rust: a graphics device in software, and a screen that nobody looks at.

use crate::tools::{Done, install, install_words, is_ci, output};

/// Debian's packages: software Vulkan, a virtual screen, and what a window asks for when it starts.
pub(crate) const DEBIAN: &[&str] = &[
    "mesa-vulkan-drivers",
    "libvulkan1",
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
    drivers.iter().any(has_driver) && output("sh", &["-c", "command -v xvfb-run"]).is_some()
}

/// Installs what is missing where CI runs and may; elsewhere names it. What cannot be had is no failure: the tests
/// that need it say that they skip.
pub(crate) fn prepare() -> Done {
    if is_there() {
        return Ok(());
    }
    if !is_ci() {
        println!("skipped: the viewer is not drawn here; {}", install_words(DEBIAN));
        return Ok(());
    }
    match install(DEBIAN) {
        Ok(()) if is_there() => {}
        Ok(()) => {
            println!("skipped: the viewer is not drawn here, for there is no driver of Vulkan");
        }
        Err(e) => println!("skipped: the viewer is not drawn here; {e}"),
    }
    Ok(())
}
