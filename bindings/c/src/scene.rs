//! Scenes: made, committed and measured.

use std::ops::{Deref, DerefMut};

use cullet_cells::Cells;
#[cfg(feature = "files")]
use cullet_io::Model;

use crate::memory::Out;
use crate::registry::{Kind, Table};
use crate::status::{Status, call};

pub(crate) static SCENES: Table<InCells> = Table::new(Kind::Scene);

/// A scene, and the cells that its file or baked sets brought.
#[derive(Debug)]
pub(crate) struct InCells {
    pub(crate) scene: engine::Scene,
    /// Cells of its file, or found in it.
    cells: Option<Cells>,
    /// View cells of baked sets, by which it is culled in place of those.
    view_cells: Option<Cells>,
    /// Rises when cells or their sets change, so that no answer of before stands.
    pub(crate) cells_version: u64,
    /// Contents of its file beyond the scene, as far as something needs them.
    #[cfg(feature = "files")]
    pub(crate) rest: Model,
}

impl InCells {
    /// A scene without cells.
    pub(crate) fn new(scene: engine::Scene) -> Self {
        Self {
            scene,
            cells: None,
            view_cells: None,
            cells_version: 0,
            #[cfg(feature = "files")]
            rest: Model::default(),
        }
    }

    /// The scene of a file.
    #[cfg(feature = "files")]
    pub(crate) fn of_model(mut model: Model) -> Self {
        let scene = std::mem::take(&mut model.scene);
        let mut cells = model.placed.take();
        if let (Some(cells), Some(sets)) = (&mut cells, model.cell_sets.take()) {
            // Sets that do not fit hide nothing.
            let _ = cells.set_visible_sets(sets);
        }
        if !cfg!(feature = "bake") {
            // Occluders are all that is asked for later.
            model = Model { baked: model.baked, ..Model::default() };
        }
        Self { cells, rest: model, ..Self::new(scene) }
    }

    /// The scene and its cells, to cull by.
    pub(crate) fn all(&self) -> cullet_cells::InCells<'_> {
        let cells = self.view_cells.as_ref().or(self.cells.as_ref());
        cullet_cells::InCells::new(&self.scene, cells)
    }

    /// Finds again what is in which cells.
    fn update(&mut self) {
        for cells in [&mut self.cells, &mut self.view_cells].into_iter().flatten() {
            cells.update(&self.scene);
        }
    }
}

#[cfg(feature = "files")]
impl InCells {
    /// The cells of its file, or those that were found in it.
    pub(crate) fn cells(&self) -> Option<&Cells> {
        self.cells.as_ref()
    }

    /// The same, to change their sets.
    pub(crate) fn cells_mut(&mut self) -> Option<&mut Cells> {
        self.cells_version += 1;
        self.cells.as_mut()
    }

    /// Takes cells in place of its own and of view cells.
    #[cfg(feature = "bake")]
    pub(crate) fn set_cells(&mut self, cells: Cells) {
        self.cells_version += 1;
        (self.cells, self.view_cells) = (Some(cells), None);
    }

    /// Takes view cells with their sets, or none.
    pub(crate) fn set_view_cells(&mut self, cells: Option<Cells>) {
        self.cells_version += 1;
        self.view_cells = cells;
    }
}

impl Deref for InCells {
    type Target = engine::Scene;

    fn deref(&self) -> &engine::Scene {
        &self.scene
    }
}

impl DerefMut for InCells {
    fn deref_mut(&mut self) -> &mut engine::Scene {
        &mut self.scene
    }
}

/// Handle of a scene. A plain number: copy it freely; 0 is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Not to be read or made.
    pub id: u64,
}

/// Contents of a scene.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SceneInfo {
    /// Instances.
    pub instance_count: u32,
    /// Slots, empty ones included: how long an array by slot must be.
    pub slot_count: u32,
    /// Meshes.
    pub mesh_count: u32,
    /// 0.
    pub reserved: u32,
    /// Triangles of all instances.
    pub triangle_count: u64,
    /// Rises whenever a commit put instances into other slots.
    pub order_version: u64,
    /// The point that boxes in world space are relative to: zero, but for files far from it.
    pub origin: [f64; 3],
    /// The lowest corner of the box around all instances, relative to `origin`; above `max` for
    /// none.
    pub min: [f32; 3],
    /// The highest corner.
    pub max: [f32; 3],
}

/// Makes an empty scene. Destroy it with `cullet_scene_destroy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_create(scene: *mut Scene) -> Status {
    call("cullet_scene_create", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("scene", scene) }?;
        out.set(0, Scene { id: SCENES.insert(InCells::new(engine::Scene::new()))? });
        Ok(())
    })
}

/// Destroys a scene; its handle is stale from then on, and so are those of its instances.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_destroy(scene: Scene) -> Status {
    call("cullet_scene_destroy", || SCENES.remove(scene.id).map(drop))
}

/// Sorts the slots by place, closes gaps, and prepares meshes that are new. Call it once after
/// loading, and again after much was added, removed or moved far. Results of before are refused
/// (`CULLET_STATUS_NO_RESULT`) until the next cull. Cost: linear in instances, and in the triangles
/// of new meshes.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_commit(scene: Scene) -> Status {
    call("cullet_scene_commit", || {
        let mut scene = SCENES.get_mut(scene.id)?;
        scene.commit(&engine::Culler::default());
        scene.update();
        Ok(())
    })
}

/// Fits the nodes of the hierarchy to what moved: makes the next cull faster, never different.
/// Cost: that of what moved.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_refit(scene: Scene) -> Status {
    call("cullet_scene_refit", || {
        let mut scene = SCENES.get_mut(scene.id)?;
        scene.refit();
        scene.update();
        Ok(())
    })
}

/// Writes the contents of a scene. Cost: linear in its instances.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_get_info(scene: Scene, info: *mut SceneInfo) -> Status {
    call("cullet_scene_get_info", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("info", info) }?;
        let scene = SCENES.get(scene.id)?;
        let extent = scene.extent();
        out.set(
            0,
            SceneInfo {
                instance_count: scene.instance_count(),
                slot_count: scene.slot_count(),
                mesh_count: scene.meshes().len() as u32,
                reserved: 0,
                triangle_count: scene.triangle_count(),
                order_version: scene.order_version(),
                origin: scene.origin(),
                min: extent.min,
                max: extent.max,
            },
        );
        Ok(())
    })
}
