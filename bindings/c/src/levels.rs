//! Levels of detail: those that a mesh has, and meshes of the caller's as levels of others.

use engine::lod::LevelsError;

use crate::cull::{STATES, State};
use crate::memory::Out;
use crate::mesh::mesh_of;
use crate::results::write;
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Status, call};

/// Levels of detail of a mesh: one chain of whole meshes, or one hierarchy of clusters.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Levels {
    /// The mesh of the scene that holds the triangles of all its levels: draws name it, and
    /// `cullet_scene_mesh_read` reads what to upload.
    pub mesh: u32,
    /// Steps of simplification: of a chain its levels.
    pub group_count: u32,
    /// Triangles of all levels together.
    pub triangle_count: u64,
    /// The least distance from the original surface of a step, in units of the mesh.
    pub least_error: f32,
    /// The largest.
    pub most_error: f32,
}

impl Levels {
    fn of(scene: &engine::Scene, levels: &engine::scene::MeshLevels) -> Self {
        let groups = levels.levels.group_count();
        let errors = || (0..groups).map(|group| levels.levels.group(group).error);
        Self {
            mesh: levels.mesh,
            group_count: groups as u32,
            triangle_count: scene.meshes()[levels.mesh as usize].triangle_count().into(),
            least_error: errors().reduce(f32::min).unwrap_or(0.0),
            most_error: errors().fold(0.0, f32::max),
        }
    }
}

/// Writes the levels that a mesh of a scene has: from its file, by `cullet_scene_add_lod`, or baked.
/// The first is number 1 in `cullet_draw_key.level`; 0 is the mesh itself. `capacity` and `count` as
/// for `cullet_visible_slots`; most meshes have at most two. `cullet_settings.lod_pixels` and
/// `.lod_triangles` choose among them in each cull. Reads the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_levels(
    scene: Scene,
    mesh: u32,
    levels: *mut Levels,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_scene_levels", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("levels", levels, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let scene = SCENES.get(scene.id)?;
        mesh_of(&scene, mesh)?;
        let all = scene.levels(mesh);
        write(&mut out, &mut count, all.iter().map(|one| Levels::of(&scene, one)), all.len())
    })
}

/// Gives a mesh a coarser one to be drawn in its place where the eye is far enough: another mesh of
/// the scene, in the same space, with the same parts and materials. No point of it may be farther
/// than `error` from the surface of `mesh`, in units of the mesh, nor the other way round; at least
/// 0 and finite. Call it once for each level, in any order. Refused with `CULLET_STATUS_MESH` where
/// `coarse` has triangles without area. Commit the scene before culling.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_add_lod(scene: Scene, mesh: u32, coarse: u32, error: f32) -> Status {
    call("cullet_scene_add_lod", || {
        let mut scene = SCENES.get_mut(scene.id)?;
        for mesh in [mesh, coarse] {
            mesh_of(&scene, mesh)?;
        }
        if !(error >= 0.0 && error.is_finite()) {
            let message = format!("error is {error}: it must be finite and at least 0");
            return Err(Error::value(message));
        }
        if mesh == coarse {
            let message = format!("coarse is mesh {mesh} itself: it must be another mesh");
            return Err(Error::value(message));
        }
        scene.add_lod(mesh, coarse, error).map_err(|e| Error::new(status_of(&e), e.to_string()))
    })
}

fn status_of(error: &LevelsError) -> Status {
    match error {
        LevelsError::NoMesh { .. } => Status::NotFound,
        _ => Status::Mesh,
    }
}

/// Takes all levels of a mesh away. Meshes that held them stay in the scene.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_clear_levels(scene: Scene, mesh: u32) -> Status {
    call("cullet_scene_clear_levels", || {
        let mut scene = SCENES.get_mut(scene.id)?;
        mesh_of(&scene, mesh)?;
        scene.clear_levels(mesh);
        Ok(())
    })
}

/// Writes by how many pixels the surfaces of the last result may be off: `cullet_settings.lod_pixels`,
/// or what the budget of triangles raised it to; 0 where no levels were chosen.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_lod(state: State, pixels: *mut f64) -> Status {
    call("cullet_visible_lod", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("pixels", pixels) }?;
        let frame = STATES.get(state.id)?;
        frame.check()?;
        out.set(0, frame.visible.lod_pixels.unwrap_or(0.0));
        Ok(())
    })
}
