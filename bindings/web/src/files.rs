//! Model files: read into scenes.

use alloc::string::String;
use alloc::vec::Vec;

use cullet::prepared::Preparation;
use cullet_io::{ErrorKind, LoadError, LoadOptions, Model, files_named_in};
use cullet_maps::load_bytes_with;

use crate::cells::Cells;
use crate::fault::{Code, Fault, has_room};
use crate::scene::SceneSet;

/// Reads a file, committed and prepared. `name` stands for it in messages, and its ending tells
/// formats without a signature apart.
///
/// # Errors
/// If it is of no known kind, is invalid, over a limit or needs other files.
pub fn open(name: &str, bytes: &[u8]) -> Result<SceneSet, Fault> {
    let model = load(name, bytes, &[], &LoadOptions::default())?;
    let mut set = SceneSet::new(model.scene);
    set.cells = Cells(model.placed);
    Ok(set)
}

/// Reads a file with the files that it names, without preparing it for culling.
pub(crate) fn read(name: &str, bytes: &[u8], beside: &[(String, Vec<u8>)]) -> Result<Model, Fault> {
    // As the program `cullet` reads it for `info`.
    let options =
        LoadOptions { impostors: true, prepare: Preparation::NONE, ..LoadOptions::default() };
    load(name, bytes, beside, &options)
}

/// Names the files that a model needs beside it, one a line: buffers of glTF, materials of OBJ.
///
/// # Errors
/// If the file is of no known kind, or invalid.
pub fn beside(name: &str, bytes: &[u8]) -> Result<String, Fault> {
    let files = files_named_in(name, bytes).map_err(|error| fault(&error))?;
    let lines: Vec<String> = files.iter().map(|f| f.to_string_lossy().into_owned()).collect();
    Ok(lines.join("\n"))
}

fn load(
    name: &str,
    bytes: &[u8],
    beside: &[(String, Vec<u8>)],
    options: &LoadOptions,
) -> Result<Model, Fault> {
    // What is read takes a multiple of a file whose tables are used as they lie.
    let all = beside.iter().fold(bytes.len(), |all, (_, file)| all.saturating_add(file.len()));
    if !has_room(all.saturating_mul(3)) {
        return Err(Fault::new(Code::Memory, format!("no memory to read {name}")));
    }
    load_bytes_with(name, bytes, beside, options).map_err(|error| fault(&error))
}

fn fault(error: &LoadError) -> Fault {
    let over = matches!(error.kind, ErrorKind::OverLimit { .. });
    Fault::new(if over { Code::Limit } else { Code::File }, error)
}
