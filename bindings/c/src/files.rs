//! Scenes from files.

use std::ffi::c_char;
use std::path::Path;

use cullet_io::LoadOptions;
use cullet_maps::load;

use crate::memory::{Out, text};
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Status, call};

/// Opens a file as a scene: glTF and GLB, with what `cullet bake` wrote into them, OBJ, PLY, STL,
/// OFF, maps of Quake with the visible sets that are in them; and 3D Tiles, in libraries that are
/// built with `tiles`. The path is UTF-8. The scene is committed; instances have the handles 0, 1, 2,
/// ... of generation 0 in the order of the file. Reading takes at most three times the memory of the
/// geometry. The message of a failure names the file, the item and what would be right.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_open(path: *const c_char, scene: *mut Scene) -> Status {
    call("cullet_open", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("scene", scene) }?;
        // SAFETY: as the header asks of the caller.
        let path = unsafe { text("path", path) }?;
        let model = load(Path::new(path), &LoadOptions::default())
            .map_err(|e| Error::new(Status::File, e.to_string()))?;
        out.set(0, Scene { id: SCENES.insert(InCells::of_model(model))? });
        Ok(())
    })
}
