//! Model files: read into scenes.

use cullet_io::LoadOptions;
use cullet_maps::load_bytes;

use crate::cells::Cells;
use crate::fault::{Code, Fault, has_room};
use crate::scene::SceneSet;

/// Reads a file, committed and prepared. `name` stands for it in messages, and its ending tells
/// formats without a signature apart.
///
/// # Errors
/// If it is of no known kind, is invalid or needs other files.
pub fn open(name: &str, bytes: &[u8]) -> Result<SceneSet, Fault> {
    // What is read takes a multiple of a file whose tables are used as they lie.
    if !has_room(bytes.len().saturating_mul(3)) {
        return Err(Fault::new(Code::Memory, format!("no memory to read {name}")));
    }
    let model = load_bytes(name, bytes, &LoadOptions::default())
        .map_err(|error| Fault::new(Code::File, error))?;
    let mut set = SceneSet::new(model.scene);
    set.cells = Cells(model.placed);
    Ok(set)
}
