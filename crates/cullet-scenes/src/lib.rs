//! Built-in scenes: made by rule from a seed, the same on every machine.
//!
//! A scene is named by a text, `name:key=value,...`: `city`, `city:seed=3,sub=2`, `forest:n=1e7`.
//! [`list`] says which names and keys there are. Lengths are metres; y is up and the ground is near
//! 0.
//!
//! [`paths`] are camera paths through any model, [`adversaries`] small scenes that are hard for
//! occlusion culling.
//!
//! ```
//! let city = cullet_scenes::build("city:cells=4,objects=50")?;
//! assert!(city.scene.instance_count() > 50);
//! # Ok::<(), cullet_scenes::SceneSpecError>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod adversaries;

mod builder;
mod city;
mod city_name;
mod city_plots;
mod forest;
mod knobs;
mod moving;
mod office;
pub mod paths;
mod plant;
mod rng;
mod shapes;
mod solids;
mod spec;

pub use city_name::{CityName, NoCityName};
pub use city_plots::{CityPlots, Placed, Plot};
pub use knobs::knobbly_ball;
pub use spec::{KeyInfo, SceneInfo, SceneSpecError};

pub use rng::Rng;
pub(crate) use rng::sin_cos;

use cullet_io::Model;
use spec::Spec;

static SCENES: &[SceneInfo] =
    &[city::INFO, solids::INFO, office::INFO, plant::INFO, forest::INFO, moving::INFO, knobs::INFO];

/// The built-in scenes, with their keys.
#[must_use]
pub fn list() -> &'static [SceneInfo] {
    SCENES
}

/// Whether `text` begins with the name of a built-in scene, so that it is not meant as a file: the
/// part before the first colon is compared.
#[must_use]
pub fn is_builtin(text: &str) -> bool {
    let name = text.split(':').next().unwrap_or_default().trim();
    SCENES.iter().any(|s| s.name == name)
}

/// Message for a text that names neither a file nor a built-in scene: with the built-in scene whose
/// name is most like it, or with all of them. Addresses are told apart.
#[must_use]
pub fn no_such_file(text: &str) -> String {
    if text.contains("://") {
        return format!("{text}: addresses are not fetched; download it, then name the file");
    }
    let name = text.split(':').next().unwrap_or_default().trim();
    match spec::similar(name, SCENES.iter().map(|s| s.name)) {
        Some(like) => format!("there is no file {text}; did you mean the built-in scene {like}?"),
        None => {
            let known: Vec<&str> = SCENES.iter().map(|s| s.name).collect();
            format!("there is no file {text}; the built-in scenes are {}", known.join(", "))
        }
    }
}

/// Makes a built-in scene from its text, `name:key=value,...`; keys left out have their defaults.
///
/// The same text gives the same scene, to the last bit of every position, on every machine. The
/// name of the model is the shortest text that gives it again. Costs less than a microsecond and
/// some 120 bytes an instance, and 150 while it is made.
///
/// # Errors
/// If the text names no scene, or a key or value that the scene does not have; the message lists
/// those that it has.
pub fn build(text: &str) -> Result<Model, SceneSpecError> {
    let spec = Spec::parse(text, SCENES)?;
    match spec.info.name {
        "city" if spec.get("n") > 0 => city_plots::build(&spec),
        "city" => city::build(&spec),
        "solids" => solids::build(&spec),
        "office" => office::build(&spec),
        "plant" => plant::build(&spec),
        "moving" => moving::build(&spec),
        "knobs" => knobs::build(&spec),
        _ => forest::build(&spec),
    }
}

/// Makes the built-in `moving` as it is `seconds` after the time of its text, to the millisecond.
///
/// # Errors
/// As [`build`]; also if the scene has no such time.
pub(crate) fn build_at(text: &str, seconds: f64) -> Result<Model, SceneSpecError> {
    let mut spec = Spec::parse(text, SCENES)?;
    let t = spec.get("t") as f64 + seconds * 1e3;
    spec.set("t", t)?;
    moving::build(&spec)
}
