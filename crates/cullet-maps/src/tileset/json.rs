//! The JSON of a tileset.

use glam::{DMat4, DVec3};
use serde::{Deserialize, Serialize};

use cullet_io::ErrorKind;

#[derive(Debug, Deserialize)]
pub(super) struct TilesetJson {
    asset: Asset,
    pub(super) root: TileJson,
    #[serde(default, rename = "extensionsRequired")]
    required: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub(super) enum Refine {
    #[serde(rename = "REPLACE", alias = "replace")]
    Replace,
    #[serde(rename = "ADD", alias = "add")]
    Add,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TileJson {
    pub(super) bounding_volume: Volume,
    #[serde(default)]
    pub(super) refine: Option<Refine>,
    #[serde(default)]
    pub(super) transform: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) content: Option<Content>,
    #[serde(default)]
    pub(super) contents: Vec<Content>,
    #[serde(default)]
    pub(super) children: Vec<Self>,
    #[serde(default)]
    pub(super) geometric_error: f64,
    #[serde(default)]
    pub(super) extras: Option<Extras>,
    #[serde(default)]
    pub(super) implicit_tiling: Option<ImplicitJson>,
}

/// What others wrote here is of no concern.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Extras {
    Ours { cullet: OursJson },
    Other(serde::de::IgnoredAny),
}

/// What this crate writes of a tile.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct OursJson {
    #[serde(flatten)]
    pub(super) size: TileSize,
    /// Its number in the rows of visible sets.
    #[serde(default)]
    pub(super) number: Option<u32>,
    /// Of a root: the file of visible sets.
    #[serde(default)]
    pub(super) cells: Option<String>,
}

/// What a tile takes once it is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct TileSize {
    /// Its instances.
    pub instances: u32,
    /// Vertices of its meshes.
    pub vertices: u64,
    /// Their triangles, each mesh counted once.
    pub triangles: u64,
}

/// A tree of tiles by bits.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ImplicitJson {
    pub(super) subdivision_scheme: Scheme,
    pub(super) subtree_levels: u32,
    pub(super) available_levels: u32,
    pub(super) subtrees: Template,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Scheme {
    Quadtree,
    Octree,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Template {
    pub(super) uri: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Content {
    #[serde(default)]
    pub(super) uri: Option<String>,
    /// As before 1.0.
    #[serde(default)]
    pub(super) url: Option<String>,
}

impl Content {
    /// What it names.
    pub(super) fn text(&self) -> &str {
        self.uri.as_deref().or(self.url.as_deref()).unwrap_or_default()
    }
}

/// One of the three is there; numbers as in the file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Volume {
    #[serde(rename = "box")]
    pub(super) block: Option<Vec<f64>>,
    pub(super) sphere: Option<Vec<f64>>,
    pub(super) region: Option<Vec<f64>>,
}

/// Extensions that change nothing of what is drawn where.
const HARMLESS: [&str; 3] =
    ["3DTILES_content_gltf", "3DTILES_metadata", "3DTILES_multiple_contents"];

/// Reads a tileset. Its depth is limited by that of JSON, 128.
pub(super) fn read(bytes: &[u8]) -> Result<TilesetJson, ErrorKind> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let tileset: TilesetJson =
        serde_json::from_slice(bytes).map_err(|e| ErrorKind::invalid("tileset", e.to_string()))?;
    let version = &tileset.asset.version;
    if !matches!(version.as_str(), "0.0" | "1.0" | "1.1") {
        let message = format!("\"{version}\"; 1.0 and 1.1 are known");
        return Err(ErrorKind::invalid("asset.version", message));
    }
    if let Some(name) = tileset.required.iter().find(|name| !HARMLESS.contains(&name.as_str())) {
        return Err(ErrorKind::Unsupported(format!(
            "it requires the extension {name}, which is not known"
        )));
    }
    Ok(tileset)
}

/// By how much a b3dm is moved: `RTC_CENTER` of its features, where it is there and finite.
pub(super) fn relative_to(features: &[u8]) -> DMat4 {
    #[derive(Deserialize)]
    struct Features {
        #[serde(rename = "RTC_CENTER")]
        centre: Option<[f64; 3]>,
    }
    let features = serde_json::from_slice::<Features>(features).ok();
    let centre = features.and_then(|f| f.centre).map_or(DVec3::ZERO, DVec3::from);
    DMat4::from_translation(if centre.is_finite() { centre } else { DVec3::ZERO })
}
