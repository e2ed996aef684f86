//! Scenes written to files.

use std::ffi::c_char;
use std::path::Path;

use cullet_io::{save, save_original};

use crate::memory::text;
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Status, call};

/// Writes a scene to a file, by the ending of its name: `.glb` with the levels, occluders and cells
/// that were baked, which `cullet_open` reads; `.ply`, `.obj` and `.stl` without them. With
/// `original`, which may be NULL, a `.glb` is that glTF file as it is, textures and all, with what
/// was baked added: the one that the scene was opened from. Paths are UTF-8. An existing file is
/// replaced when all has been written. Refused with `CULLET_STATUS_FILE`; the message names the
/// file. Needs the scene alone. Cost: linear in the file.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_save(
    scene: Scene,
    path: *const c_char,
    original: *const c_char,
) -> Status {
    call("cullet_scene_save", || {
        // SAFETY: as the header asks of the caller.
        let path = Path::new(unsafe { text("path", path) }?);
        let mut of = None;
        if !original.is_null() {
            // SAFETY: as the header asks of the caller.
            of = Some(Path::new(unsafe { text("original", original) }?));
        }
        let mut own = SCENES.get_mut(scene.id)?;
        let InCells { scene, rest, .. } = &mut *own;
        // A model has its scene. Where writing panics, nobody sees the scene again.
        std::mem::swap(scene, &mut rest.scene);
        let saved = match of {
            Some(original) => save_original(rest, original, path, false).map(drop),
            None => save(rest, path).map(drop),
        };
        std::mem::swap(scene, &mut rest.scene);
        saved.map_err(|e| Error::new(Status::File, e.to_string()))
    })
}
