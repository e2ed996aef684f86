//! Requirements of the viewer's tests beside Rust: a graphics device in software, and a virtual
//! screen.

use crate::runner::{End, Ended, Skip};
use crate::tools::{install, install_words, is_ci, output};

/// Debian's packages: software Vulkan and OpenGL, a virtual screen, and what a window needs when it
/// starts.
pub(crate) const DEBIAN: &[&str] = &[
    "mesa-vulkan-drivers",
    "libvulkan1",
    "libegl1",
    "libgl1-mesa-dri",
    "xvfb",
    "xauth",
    "libxkbcommon-x11-0",
    "libxcursor1",
    "libxi6",
    "libxrandr2",
];

/// Graphics of a machine. One that has all is any of them by its [environment](Self::environment).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Machine {
    Nothing,
    OpenGl,
    Vulkan,
    Both,
}

impl Machine {
    /// The backends that wgpu may look for, and the highest tier that must be found: tests that
    /// need more are skipped, and no others.
    pub(crate) fn environment(self) -> [(&'static str, &'static str); 2] {
        let [backends, required] = match self {
            Self::Nothing => ["none", ""],
            Self::OpenGl => ["gl", "compute"],
            Self::Vulkan => ["vulkan", "1"],
            Self::Both => ["vulkan,gl", "1"],
        };
        [("WGPU_BACKEND", backends), ("CULLET_REQUIRE_GPU", required)]
    }

    /// Returns the graphics that it has, for people.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Nothing => "no graphics device",
            Self::OpenGl => "OpenGL alone",
            Self::Vulkan => "Vulkan alone",
            Self::Both => "Vulkan and OpenGL",
        }
    }
}

/// Whether there is what every test of a device needs: Vulkan, and a virtual screen.
pub(crate) fn is_there() -> bool {
    has_vulkan() && output("sh", &["-c", "command -v xvfb-run"]).is_some()
}

/// Whether there is the library that OpenGL is reached by without a screen.
pub(crate) fn has_opengl() -> bool {
    output("sh", &["-c", "PATH=$PATH:/sbin ldconfig -p"]).is_some_and(|l| l.contains("libEGL.so.1"))
}

/// Whether wgpu may look for Vulkan, and there is a driver: where the environment says, or else
/// where drivers lie.
fn has_vulkan() -> bool {
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let is_wanted = variable("WGPU_BACKEND").is_none_or(|own| {
        own.split(',').any(|name| ["vulkan", "vk"].contains(&name.trim().to_lowercase().as_str()))
    });
    let is_driver = |path: &str| {
        let is_named = std::path::Path::new(path).is_file();
        is_named || std::fs::read_dir(path).is_ok_and(|mut files| files.next().is_some())
    };
    let named = variable("VK_DRIVER_FILES").or_else(|| variable("VK_ICD_FILENAMES"));
    let drivers = named.unwrap_or_else(|| "/usr/share/vulkan/icd.d:/etc/vulkan/icd.d".to_owned());
    is_wanted && drivers.split(':').any(is_driver)
}

/// The step that installs what is missing where CI runs and may; elsewhere it names it. What cannot
/// be had is no failure: what needs it is skipped.
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
