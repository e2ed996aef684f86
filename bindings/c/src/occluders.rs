//! Occluders that were baked of meshes, given to those that they are of.

use cullet_io::baked::{Occluders, pays};
use engine::prepared::Preparation;

use crate::memory::Out;
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Result, Status, call};

/// Gives meshes of a scene the occluders that were baked of them; returns how many took theirs.
pub(crate) fn give(scene: &mut InCells, always: u32) -> Result<u32> {
    if always > 1 {
        return Err(Error::value(format!("always is {always}: it must be 0 or 1")));
    }
    let InCells { scene, rest, .. } = scene;
    scene.prepare(Preparation { occluder: true, ..Preparation::NONE });
    let mut given = 0;
    let baked = rest.baked.iter().flat_map(|baked| &baked.meshes);
    for (mesh, made) in baked.filter_map(|one| Some((one.mesh, one.occluders.as_ref()?))) {
        given += u32::from(give_one(scene, mesh, made, always == 1)?);
    }
    Ok(given)
}

fn give_one(scene: &mut engine::Scene, mesh: u32, made: &Occluders, always: bool) -> Result<bool> {
    let occluder = made.to_engine().map_err(|e| Error::new(Status::File, e.to_string()))?;
    let own = scene.prepared().get(mesh as usize).and_then(|prepared| prepared.occluder());
    let takes = !occluder.shapes().is_empty()
        && (always || made.hide_enough() && own.is_some_and(|own| pays(&occluder, own)));
    if takes {
        scene.set_occluder(mesh, occluder);
    }
    Ok(takes)
}

/// Gives meshes the occluders that were baked of them and that the scene's file brought; each mesh
/// is its own occluder otherwise. With `always` 0 a mesh takes them only where they hide nearly all
/// that it hides itself and cost less than half as much to draw; with 1 wherever there are some,
/// which `cullet_box_to_box` and `cullet_region_cull` may need: boxes and polygons hide there, and
/// walls that are sheets do not. `given` takes how many meshes took some, unless it is NULL. Call it
/// after a commit. Cost: linear in the triangles of meshes that are new.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_take_occluders(
    scene: Scene,
    always: u32,
    given: *mut u32,
) -> Status {
    call("cullet_scene_take_occluders", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("given", given, usize::from(!given.is_null())) }?;
        let count = give(&mut *SCENES.get_mut(scene.id)?, always)?;
        if out.room() > 0 {
            out.set(0, count);
        }
        Ok(())
    })
}
