//! The JSON of a tileset.

use std::borrow::Cow;

use cullet_io::reader::{FromJson, Integer, Json, Object};
use cullet_io::{ErrorKind, from_json};

from_json! {
    pub(super) struct TilesetJson<'a> {
        asset: Asset<'a> = need("asset"),
        root: TileJson<'a> = need("root"),
        required: Vec<Cow<'a, str>> = or_default("extensionsRequired"),
        used: Vec<Cow<'a, str>> = or_default("extensionsUsed"),
    }

    pub(super) struct Asset<'a> {
        version: Cow<'a, str> = need("version"),
        /// The axis of its glTF contents that points up, as tilesets before 1.0 have it.
        gltf_up: Option<GltfUp> = get("gltfUpAxis"),
    }

    pub(super) struct TileJson<'a> {
        bounding_volume: Volume = need("boundingVolume"),
        refine: Option<Refine> = get("refine"),
        transform: Option<Vec<f64>> = get("transform"),
        content: Option<Content> = get("content"),
        contents: Vec<Content> = or_default("contents"),
        /// The contents of 1.0.
        multiple: Option<MultipleJson> = extension("3DTILES_multiple_contents"),
        /// Each is read when the walk comes to it.
        children: Vec<Json<'a>> = or_default("children"),
        geometric_error: f64 = or_default("geometricError"),
        extras: Extras = or_default("extras"),
        implicit_tiling: Option<ImplicitJson> = get("implicitTiling"),
        /// The implicit tiling of 1.0.
        implicit_extension: Option<ImplicitJson> = extension("3DTILES_implicit_tiling"),
        /// The places from which alone it is shown.
        request_volume: Option<Json<'a>> = get("viewerRequestVolume"),
    }

    pub(super) struct MultipleJson {
        content: Vec<Content> = or_default("content"),
        /// Its name in early drafts.
        contents: Vec<Content> = or_default("contents"),
    }

    /// A tree of tiles by bits.
    #[derive(Clone)]
    pub(super) struct ImplicitJson {
        subdivision_scheme: Scheme = need("subdivisionScheme"),
        subtree_levels: u32 = need("subtreeLevels"),
        available_levels: Option<u32> = get("availableLevels"),
        /// One less than those, as 1.0 has it.
        maximum_level: Option<u32> = get("maximumLevel"),
        subtrees: Template = need("subtrees"),
    }

    #[derive(Clone)]
    pub(super) struct Template {
        uri: String = need("uri"),
    }

    pub(super) struct Content {
        uri: Option<String> = get("uri"),
        /// Address under the name used before 1.0.
        url: Option<String> = get("url"),
    }

    /// One of the three is there; numbers as in the file.
    #[derive(Default)]
    pub(super) struct Volume {
        block: Option<Vec<f64>> = get("box"),
        sphere: Option<Vec<f64>> = get("sphere"),
        region: Option<Vec<f64>> = get("region"),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refine {
    Replace,
    Add,
}

impl FromJson<'_> for Refine {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        match &*Cow::from_json(json)? {
            "REPLACE" | "replace" => Ok(Self::Replace),
            "ADD" | "add" => Ok(Self::Add),
            other => Err(format!("unknown variant `{other}`, expected `REPLACE` or `ADD`")),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    Quadtree,
    Octree,
}

impl FromJson<'_> for Scheme {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        match &*Cow::from_json(json)? {
            "QUADTREE" => Ok(Self::Quadtree),
            "OCTREE" => Ok(Self::Octree),
            other => Err(format!("unknown variant `{other}`, expected `QUADTREE` or `OCTREE`")),
        }
    }
}

/// Fields that this crate has written to a tile. Fields that others wrote are ignored.
#[derive(Debug, Default)]
pub(super) struct Extras(pub(super) Option<OursJson>);

#[derive(Clone, Debug)]
pub(super) struct OursJson {
    pub(super) size: TileSize,
    /// Its number in the rows of visible sets.
    pub(super) number: Option<u32>,
    /// File of visible sets, in a root.
    pub(super) cells: Option<String>,
    /// Whether the transform of a root places a scene on the globe, and does not belong to the scene.
    pub(super) placed: bool,
}

/// Size of a tile once it is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileSize {
    /// Its instances.
    pub instances: u32,
    /// Vertices of its meshes.
    pub vertices: u64,
    /// Their triangles, each mesh counted once.
    pub triangles: u64,
}

impl FromJson<'_> for Extras {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        let ours = || -> Result<OursJson, String> {
            let all: Object<'_> = Object::from_json(json)?.need("cullet")?;
            let size = TileSize {
                instances: all.need("instances")?,
                vertices: all.need::<Integer>("vertices")?.0,
                triangles: all.need::<Integer>("triangles")?.0,
            };
            let placed = all.get("placed")?.unwrap_or_default();
            Ok(OursJson { size, number: all.get("number")?, cells: all.get("cells")?, placed })
        };
        Ok(Self(ours().ok()))
    }
}

/// The axis of a glTF content that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum GltfUp {
    X,
    #[default]
    Y,
    Z,
}

impl FromJson<'_> for GltfUp {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        match &*Cow::from_json(json)? {
            "X" | "x" => Ok(Self::X),
            "Y" | "y" => Ok(Self::Y),
            "Z" | "z" => Ok(Self::Z),
            other => Err(format!("unknown variant `{other}`, expected `X`, `Y` or `Z`")),
        }
    }
}

impl TileJson<'_> {
    /// All of its contents, however they are listed.
    pub(super) fn all_contents(&self) -> impl Iterator<Item = &Content> {
        let multiple = self.multiple.iter().flat_map(|of| of.content.iter().chain(&of.contents));
        self.content.iter().chain(&self.contents).chain(multiple)
    }

    /// Its implicit tiling, if it has any.
    pub(super) fn implicit(&self) -> Option<&ImplicitJson> {
        self.implicit_tiling.as_ref().or(self.implicit_extension.as_ref())
    }
}

impl Content {
    /// Returns the address that it names.
    pub(super) fn text(&self) -> &str {
        self.uri.as_deref().or(self.url.as_deref()).unwrap_or_default()
    }
}

/// Extensions that are read, or change nothing of what is drawn where.
const KNOWN: [&str; 6] = [
    "3DTILES_batch_table_hierarchy",
    "3DTILES_content_gltf",
    "3DTILES_horizon_occlusion_point",
    "3DTILES_implicit_tiling",
    "3DTILES_metadata",
    "3DTILES_multiple_contents",
];

impl TilesetJson<'_> {
    /// Extensions that it uses and that are not read.
    pub(super) fn unread(&self) -> impl Iterator<Item = &str> {
        self.used.iter().map(|name| &**name).filter(|name| !KNOWN.contains(name))
    }
}

/// Reads a tileset: its root, and the tiles below as they lie.
pub(super) fn read(bytes: &[u8]) -> Result<TilesetJson<'_>, ErrorKind> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let tileset: TilesetJson<'_> = of_bytes(bytes, "tileset")?;
    let version = &tileset.asset.version;
    if !matches!(&**version, "0.0" | "1.0" | "1.1") {
        let message = format!("\"{version}\"; 1.0 and 1.1 are known");
        return Err(ErrorKind::invalid("asset.version", message));
    }
    if let Some(name) = tileset.required.iter().find(|name| !KNOWN.contains(&&***name)) {
        return Err(ErrorKind::Unsupported(format!(
            "it requires the extension {name}, which is not known"
        )));
    }
    Ok(tileset)
}

/// Reads a file that is one value; `item` is what errors call it.
pub(super) fn of_bytes<'a, T: FromJson<'a>>(bytes: &'a [u8], item: &str) -> Result<T, ErrorKind> {
    // Some exporters pad JSON with zeros.
    let end = bytes.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let text = std::str::from_utf8(&bytes[..end]).map_err(|e| e.to_string());
    let read = text.and_then(Json::parse).and_then(T::from_json);
    read.map_err(|message| ErrorKind::invalid(item, message))
}
