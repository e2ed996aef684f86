//! What `cullet pvs` bakes: a portal graph, or a map from which one is made.

use std::path::Path;

use cullet::cell::CellGraph;
use cullet_bake::pvs::Pvs;
use cullet_command::exit::{Exit, Failure};
use cullet_io::bsp::{Bsp, ClusterRows, clusters_of_leafs, with_visibility};
use cullet_io::{ErrorKind, LoadError, load_prt_bytes};

/// Bytes before the rows of [`Pvs::rows_bytes`].
const ROWS_BEGIN: usize = 16;

/// A graph of cells, and where it is from.
pub(crate) struct Source {
    pub(crate) graph: CellGraph,
    /// Portals of the file that were wound the other way around.
    pub(crate) turned: u32,
    /// The bytes of the map, where it is one.
    map: Option<Vec<u8>>,
}

impl Source {
    /// Reads a `.prt`, or a map, whose cells and portals are made from its tree.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        // A device might never end.
        let is_file = std::fs::metadata(path).map(|m| m.is_file());
        let bytes = match is_file {
            Ok(false) => Err(std::io::Error::other("it is no file")),
            Ok(true) => std::fs::read(path),
            Err(error) => Err(error),
        };
        let bytes = bytes.map_err(|error| failure(path, error.into()))?;
        if is_map(path, &bytes) {
            let cells = Bsp::parse(&bytes).and_then(|map| map.cells());
            let graph = cells.map_err(|kind| failure(path, kind))?;
            return Ok(Self { graph, turned: 0, map: Some(bytes) });
        }
        let prt = load_prt_bytes(&path.display().to_string(), &bytes);
        let prt = prt.map_err(|error| failure(path, error.kind))?;
        Ok(Self { graph: prt.graph, turned: prt.turned, map: None })
    }

    /// The cells of a scene.
    pub(crate) fn of_cells(graph: CellGraph) -> Self {
        Self { graph, turned: 0, map: None }
    }

    /// Whether it has a map to write sets into.
    pub(crate) fn has_map(&self) -> bool {
        self.map.is_some()
    }

    /// The map with these sets as its visibility.
    pub(crate) fn map_with(&self, path: &Path, pvs: &Pvs) -> Result<Vec<u8>, Failure> {
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
        baked.map_err(|kind| failure(path, kind))
    }
}

/// By its first bytes, else by its name.
fn is_map(path: &Path, bytes: &[u8]) -> bool {
    let quake = 29_i32.to_le_bytes();
    let begins = [&quake[..], b"BSP2", b"IBSP"].iter().any(|head| bytes.starts_with(head));
    begins || is_named_map(path)
}

/// Whether a path ends as those of maps do.
pub(crate) fn is_named_map(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bsp"))
}

fn failure(path: &Path, kind: ErrorKind) -> Failure {
    let exit = if matches!(kind, ErrorKind::OverLimit { .. }) { Exit::Limit } else { Exit::Input };
    Failure { exit, message: LoadError { path: path.to_owned(), kind }.to_string() }
}
