//! The text that names a built-in scene: `name:key=value,...`.

use thiserror::Error;

/// Description of a built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneInfo {
    /// Its name.
    pub name: &'static str,
    /// The scene, in a sentence.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [KeyInfo],
}

/// A key of a built-in scene. Every value is a whole number; `1e6` and `1_000_000` are as good as
/// `1000000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyInfo {
    /// Its name.
    pub name: &'static str,
    /// The quantity that it sets, with the unit.
    pub about: &'static str,
    /// The value where none is given.
    pub default: u64,
    /// The least value.
    pub min: u64,
    /// The greatest value.
    pub max: u64,
}

/// Why a scene's text cannot be followed; each says what would be right.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneSpecError {
    /// No scene has that name.
    #[error("there is no built-in scene '{name}'{}; the built-in scenes are {known}", meant(*like))]
    UnknownScene {
        /// The name given.
        name: String,
        /// The name that is most like it, if any is alike.
        like: Option<&'static str>,
        /// All names.
        known: String,
    },
    /// The scene has no such key.
    #[error("scene '{scene}' has no key '{key}'{}; its keys are {known}", meant(*like))]
    UnknownKey {
        /// The scene.
        scene: &'static str,
        /// The key given.
        key: String,
        /// The key that is most like it, if any is alike.
        like: Option<&'static str>,
        /// All keys, with their ranges.
        known: String,
    },
    /// An item that is not `key=value`.
    #[error("scene '{scene}': '{item}' is not key=value; the keys are {known}")]
    Syntax {
        /// The scene.
        scene: &'static str,
        /// The item.
        item: String,
        /// All keys, with their ranges.
        known: String,
    },
    /// A key given twice.
    #[error("scene '{scene}': key '{key}' is given twice")]
    Repeated {
        /// The scene.
        scene: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A value that is no whole number, or out of range.
    #[error("scene '{scene}': {key}={value} is not a whole number from {min} to {max}")]
    Value {
        /// The scene.
        scene: &'static str,
        /// The key.
        key: &'static str,
        /// The value given.
        value: String,
        /// The least value.
        min: u64,
        /// The greatest value.
        max: u64,
    },
    /// The scene does not fit the limits of a scene.
    #[error("the scene cannot be made: {0}")]
    Scene(#[from] cullet::SceneError),
    /// A mesh does not fit the limits of a mesh.
    #[error("the scene cannot be made: {0}")]
    Mesh(#[from] cullet::mesh::MeshError),
    /// A deforming mesh has no bounds.
    #[error("the scene cannot be made: {0}")]
    Deform(#[from] cullet_io::deform::DeformError),
    /// Its cells do not fit each other.
    #[error("the scene cannot be made: {0}")]
    Cells(#[from] cullet_cells::cell::CellError),
}

/// A scene's text, taken apart: one value for each of its keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Spec {
    pub(super) info: &'static SceneInfo,
    values: Vec<u64>,
}

impl Spec {
    /// Takes `name:key=value,...` apart. Space around names, keys and values is ignored, and so is
    /// an empty item (a comma at the end).
    pub(super) fn parse(text: &str, scenes: &'static [SceneInfo]) -> Result<Self, SceneSpecError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let name = name.trim();
        let info = scenes.iter().find(|s| s.name == name).ok_or_else(|| {
            let names = scenes.iter().map(|s| s.name);
            SceneSpecError::UnknownScene {
                name: name.to_owned(),
                like: similar(name, names.clone()),
                known: names.collect::<Vec<_>>().join(", "),
            }
        })?;
        let scene = info.name;
        let mut given: Vec<Option<u64>> = vec![None; info.keys.len()];
        for item in rest.split(',').map(str::trim).filter(|i| !i.is_empty()) {
            let (key, value) = item.split_once('=').ok_or_else(|| SceneSpecError::Syntax {
                scene,
                item: item.to_owned(),
                known: known_keys(info),
            })?;
            let (key, value) = (key.trim(), value.trim());
            let at = info.keys.iter().position(|k| k.name == key).ok_or_else(|| {
                let like = similar(key, info.keys.iter().map(|k| k.name));
                SceneSpecError::UnknownKey {
                    scene,
                    key: key.to_owned(),
                    like,
                    known: known_keys(info),
                }
            })?;
            let KeyInfo { name: key, min, max, .. } = info.keys[at];
            let number = whole(value).filter(|v| (min..=max).contains(v)).ok_or_else(|| {
                SceneSpecError::Value { scene, key, value: value.to_owned(), min, max }
            })?;
            if given[at].replace(number).is_some() {
                return Err(SceneSpecError::Repeated { scene, key });
            }
        }
        let values = given.iter().zip(info.keys).map(|(v, k)| v.unwrap_or(k.default)).collect();
        Ok(Self { info, values })
    }

    /// The value of a key that the scene declares; 0 for one that it does not, which its tests
    /// notice.
    pub(super) fn get(&self, key: &str) -> u64 {
        let at = self.info.keys.iter().position(|k| k.name == key);
        debug_assert!(at.is_some(), "key {key} of {}", self.info.name);
        at.map_or(0, |at| self.values[at])
    }

    /// Sets a key to the whole number nearest to `value`.
    pub(super) fn set(&mut self, key: &str, value: f64) -> Result<(), SceneSpecError> {
        let Some(at) = self.info.keys.iter().position(|k| k.name == key) else { return Ok(()) };
        let KeyInfo { name: key, min, max, .. } = self.info.keys[at];
        let number = value.round();
        // Saturates, so that what is beyond u64 is out of range too.
        if !(number >= min as f64 && number as u64 <= max) {
            let (scene, value) = (self.info.name, value.to_string());
            return Err(SceneSpecError::Value { scene, key, value, min, max });
        }
        self.values[at] = number as u64;
        Ok(())
    }

    /// The text with only what differs from the defaults: the shortest that names this scene.
    pub(super) fn canonical(&self) -> String {
        let items: Vec<String> = self
            .info
            .keys
            .iter()
            .zip(&self.values)
            .filter(|(key, value)| **value != key.default)
            .map(|(key, value)| format!("{}={value}", key.name))
            .collect();
        let colon = if items.is_empty() { "" } else { ":" };
        format!("{}{colon}{}", self.info.name, items.join(","))
    }
}

/// The name that `text` is most likely a slip of: at most one letter in three is another, missing,
/// or has changed places with its neighbour.
pub(super) fn similar(
    text: &str,
    names: impl Iterator<Item = &'static str>,
) -> Option<&'static str> {
    let text = text.to_lowercase();
    let slips = names.map(|name| (strsim::osa_distance(&text, name), name));
    let near = slips.filter(|(n, name)| n * 3 <= name.len().max(text.chars().count()));
    near.min_by_key(|(n, _)| *n).map(|(_, name)| name)
}

fn meant(like: Option<&str>) -> String {
    like.map_or_else(String::new, |name| format!(" (did you mean '{name}'?)"))
}

fn known_keys(info: &SceneInfo) -> String {
    let range = |k: &KeyInfo| match k.max {
        u64::MAX => k.name.to_owned(),
        max => format!("{} ({} to {max})", k.name, k.min),
    };
    info.keys.iter().map(range).collect::<Vec<_>>().join(", ")
}

/// A whole number, also as `1e6` or with underscores.
fn whole(text: &str) -> Option<u64> {
    let text = text.replace('_', "");
    if let Ok(v) = text.parse::<u64>() {
        return Some(v);
    }
    // Beyond 2^53 an f64 no longer tells neighbouring whole numbers apart.
    let v = text.parse::<f64>().ok()?;
    (v >= 0.0 && v <= (1u64 << 53) as f64 && v.fract() == 0.0).then_some(v as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    static SCENES: &[SceneInfo] = &[
        SceneInfo { name: "empty", about: "", keys: &[] },
        SceneInfo {
            name: "full",
            about: "",
            keys: &[
                KeyInfo { name: "seed", about: "", default: 1, min: 0, max: u64::MAX },
                KeyInfo { name: "n", about: "", default: 5, min: 1, max: 10_000_000 },
            ],
        },
    ];

    #[test]
    fn values_and_defaults() {
        let spec = Spec::parse(" full : n = 1e6 , ", SCENES).unwrap();
        assert_eq!((spec.get("n"), spec.get("seed")), (1_000_000, 1));
        assert_eq!(spec.canonical(), "full:n=1000000");
        let spec = Spec::parse("full:seed=18446744073709551615,n=1_0", SCENES).unwrap();
        assert_eq!((spec.get("n"), spec.get("seed")), (10, u64::MAX));
        assert_eq!(Spec::parse("full:n=5", SCENES).unwrap().canonical(), "full");
        assert_eq!(Spec::parse(&spec.canonical(), SCENES), Ok(spec));
    }

    #[test]
    fn a_slip_is_told_from_another_word() {
        let names = ["city", "solids", "office", "forest", "n"];
        let of = |text: &str| similar(text, names.into_iter());
        for (slip, meant) in [
            ("ctiy", "city"),
            ("City", "city"),
            ("cty", "city"),
            ("solid", "solids"),
            ("forrest", "forest"),
        ] {
            assert_eq!(of(slip), Some(meant), "{slip}");
        }
        for other in ["", "m", "castle", "city.glb", "models/city", "cathedral", "ci"] {
            assert_eq!(of(other), None, "{other}");
        }
    }

    #[test]
    fn errors_say_what_would_be_right() {
        let error = |text: &str| Spec::parse(text, SCENES).unwrap_err().to_string();
        assert_eq!(
            error("cty:n=1"),
            "there is no built-in scene 'cty'; the built-in scenes are empty, full"
        );
        assert_eq!(
            error("ful:n=1"),
            "there is no built-in scene 'ful' (did you mean 'full'?); the built-in scenes are empty, full"
        );
        assert_eq!(
            error("full:sede=1"),
            "scene 'full' has no key 'sede' (did you mean 'seed'?); its keys are seed, n (1 to 10000000)"
        );
        assert_eq!(
            error("full:m=1"),
            "scene 'full' has no key 'm'; its keys are seed, n (1 to 10000000)"
        );
        assert_eq!(
            error("full:n"),
            "scene 'full': 'n' is not key=value; the keys are seed, n (1 to 10000000)"
        );
        for value in ["0", "-1", "1e8", "1.5", "", "x", "NaN", "inf", "99999999999999999999999"] {
            let message = error(&format!("full:n={value}"));
            let expected =
                format!("scene 'full': n={value} is not a whole number from 1 to 10000000");
            assert_eq!(message, expected);
        }
        assert_eq!(error("full:n=1,n=2"), "scene 'full': key 'n' is given twice");
        assert!(error("").contains("no built-in scene ''"));
    }
}
