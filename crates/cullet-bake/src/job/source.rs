//! Source of a bake: a portal graph, a map from which one is made, or a scene.

use std::path::Path;

use crate::pvs::Pvs;
use cullet::prepared::Preparation;
use cullet_cells::cell::CellGraph;
use cullet_io::baked::hash;
use cullet_io::{ErrorKind, LoadError, LoadOptions, Model};
use cullet_maps::bsp::{Bsp, ClusterRows, clusters_of_leafs, with_visibility};
use cullet_maps::has_scene_ending;
use cullet_maps::load_prt_bytes;

use super::error::WorkError;

/// Bytes before the rows of [`Pvs::rows_bytes`].
const ROWS_BEGIN: usize = 16;

/// A graph of cells, and where it is from.
#[derive(Debug)]
pub struct CellSource {
    /// The graph.
    pub graph: CellGraph,
    /// Portals of the file that were wound the other way around.
    pub turned: u32,
    /// The bytes of the map, where it is one.
    map: Option<Vec<u8>>,
}

impl CellSource {
    /// Reads a `.prt`, or a map, whose cells and portals are made from its tree.
    ///
    /// # Errors
    /// If the file cannot be read, or is neither.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        let bytes = bytes_of(path)?;
        let fail = |kind| LoadError { path: path.to_owned(), kind };
        if is_map(path, &bytes) {
            let cells = Bsp::parse(&bytes).and_then(|map| map.cells());
            return Ok(Self { graph: cells.map_err(fail)?, turned: 0, map: Some(bytes) });
        }
        let prt = load_prt_bytes(&path.display().to_string(), &bytes);
        let prt = prt.map_err(|error| fail(error.kind))?;
        Ok(Self { graph: prt.graph, turned: prt.turned, map: None })
    }

    /// The cells of a scene.
    #[must_use]
    pub fn of_cells(graph: CellGraph) -> Self {
        Self { graph, turned: 0, map: None }
    }

    /// Whether it has a map to write sets into.
    #[must_use]
    pub fn has_map(&self) -> bool {
        self.map.is_some()
    }

    /// The map with these sets as its visibility.
    ///
    /// # Errors
    /// If there is no map, or the sets do not fit it.
    pub fn map_with(&self, path: &Path, pvs: &Pvs) -> Result<Vec<u8>, LoadError> {
        let bytes = self.map.as_deref().unwrap_or_default();
        let baked = Bsp::parse(bytes).and_then(|map| {
            let rows = pvs.rows_bytes();
            let of_leaf = clusters_of_leafs(&map);
            let rows = rows.get(ROWS_BEGIN..).unwrap_or_default();
            with_visibility(
                bytes,
                &ClusterRows { clusters: pvs.cell_count(), of_leaf: &of_leaf, rows },
            )
        });
        baked.map_err(|kind| LoadError { path: path.to_owned(), kind })
    }
}

/// A scene as it is baked.
pub(crate) fn scene(text: &str) -> Result<Model, WorkError> {
    if is_builtin(text) {
        return Ok(cullet_scenes::build(text)?);
    }
    let options =
        LoadOptions { impostors: true, prepare: Preparation::NONE, ..LoadOptions::default() };
    Ok(cullet_maps::load(Path::new(text), &options)?)
}

/// Whether a text names a built-in scene, and no file.
pub(crate) fn is_builtin(text: &str) -> bool {
    !Path::new(text).exists() && cullet_scenes::is_builtin(text)
}

/// Hash of what a file contains; of a built-in scene none. Files that it names are no part of it.
///
/// # Errors
/// If it cannot be read.
pub fn content_of(text: &str) -> Result<Option<u64>, LoadError> {
    if is_builtin(text) {
        return Ok(None);
    }
    bytes_of(Path::new(text)).map(|bytes| Some(hash(&bytes)))
}

/// Returns the same as [`content_of`], including the files that it names as far as they exist:
/// buffers of a glTF, materials of an OBJ. For a tileset only its JSON counts.
///
/// # Errors
/// If it cannot be read.
pub fn contents_of(text: &str) -> Result<Option<u64>, LoadError> {
    let Some(own) = content_of(text)? else { return Ok(None) };
    let path = Path::new(text);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut sums = vec![own];
    // A file that names none, or is invalid, is loaded or refused as it is.
    for name in cullet_io::files_named(path).unwrap_or_default() {
        sums.push(bytes_of(&folder.join(name)).map_or(0, |bytes| hash(&bytes)));
    }
    let bytes: Vec<u8> = sums.into_iter().flat_map(u64::to_le_bytes).collect();
    Ok(Some(hash(&bytes)))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, LoadError> {
    // A device might never end.
    let bytes = match std::fs::metadata(path).map(|m| m.is_file()) {
        Ok(false) => Err(std::io::Error::other("it is no file")),
        Ok(true) => std::fs::read(path),
        Err(error) => Err(error),
    };
    bytes.map_err(|error| LoadError { path: path.to_owned(), kind: ErrorKind::from(error) })
}

/// Tests whether a file is a map, by its first bytes, else by its name.
fn is_map(path: &Path, bytes: &[u8]) -> bool {
    let quake = 29_i32.to_le_bytes();
    let begins = [&quake[..], b"BSP2", b"IBSP"].iter().any(|head| bytes.starts_with(head));
    begins || is_named_map(path)
}

/// Whether a path ends as those of maps do.
#[must_use]
pub fn is_named_map(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bsp"))
}

/// Whether a name is that of a scene rather than of a map or a portal graph.
#[must_use]
pub fn is_named_scene(path: &Path) -> bool {
    has_scene_ending(path) || is_builtin(&path.to_string_lossy())
}
