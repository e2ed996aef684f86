//! Bakes of cells and visible sets.

use cullet_bake::job::{SceneSettings, Settings};
use cullet_bake::pvs::Bake as CellsBake;
use cullet_bake::rooms::{FindOptions, FindStep, RoomsError, find_cells};
use cullet_bake::sampled::{RayTree, RayTreeOptions, SampledBake, SampledError, ViewCells};
use cullet_cells::Cells;
use engine::Handle as EngineHandle;

use crate::bake::{Bake, BakeOptions, on_deep_stack, stopped};
use crate::instance::Handle;
use crate::memory::{Out, Plain, read, reserved, value};
use crate::pvs::{Pvs, insert_bytes};
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Result, Status, call};
use crate::view::EyeBox;

/// Settings of visible sets. Set them to zero before their fields: 0 takes the default of each.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PvsSettings {
    /// Boxes to make view cells in, in world space; NULL for the bounds of the scene.
    pub boxes: *const EyeBox,
    /// How many boxes.
    pub box_count: usize,
    /// 1 where the boxes are the view cells themselves; then `cells` and `grid` are 0.
    pub boxes_are_cells: u32,
    /// How many view cells to make, small ones where geometry is near; default 500.
    pub cells: u32,
    /// In place of that: equal cells, so many along each axis of the one box.
    pub grid: [u32; 3],
    /// 0.
    pub reserved: u32,
    /// The bake ends after about so many rays; default 100,000,000.
    pub rays: u64,
    /// Seed of the rays; default 1.
    pub seed: u64,
    /// The bake ends earlier where the mean share of looks that are estimated to miss something is
    /// at most this, up to 1; default 0.00002. Below 0 to use all rays.
    pub missing: f64,
    /// Things that could appear wider than this are kept, met by a ray or not: in radians, up to pi,
    /// the default, which keeps what a cell may touch.
    pub keep_angle: f64,
    /// View cells get the sets of others within this distance, in world units; default none.
    pub join: f64,
}

impl Plain for PvsSettings {}

/// Settings as they were given, checked.
#[derive(Default)]
struct Asked {
    settings: Settings,
    boxes_are_cells: bool,
}

impl Asked {
    /// # Safety
    /// As the header asks of the caller.
    unsafe fn of(settings: *const PvsSettings) -> Result<Self> {
        if settings.is_null() {
            return Ok(Self::default());
        }
        // SAFETY: the caller's promise.
        let of = unsafe { value("settings", settings) }?;
        reserved("settings->reserved", of.reserved)?;
        // SAFETY: the caller's promise.
        let boxes = unsafe { read("settings->boxes", of.boxes, of.box_count) }?;
        let (has_grid, are_cells) = (of.grid != [0; 3], of.boxes_are_cells);
        if are_cells > 1 {
            let message = format!("settings->boxes_are_cells is {are_cells}: it must be 0 or 1");
            return Err(Error::value(message));
        }
        if are_cells == 1 && (boxes.is_empty() || of.cells != 0 || has_grid) {
            let message =
                "settings->boxes_are_cells is 1: give boxes, and neither cells nor a grid";
            return Err(Error::value(message));
        }
        if has_grid && (of.cells != 0 || boxes.len() > 1) {
            let message = "settings->grid cuts one box: give at most one, and no settings->cells";
            return Err(Error::value(message));
        }
        let number = |name: &str, value: f64| {
            let is_right = value.is_finite() && value >= 0.0;
            let message =
                || format!("settings->{name} is {value}: it must be finite and at least 0");
            if is_right { Ok((value > 0.0).then_some(value)) } else { Err(Error::value(message())) }
        };
        if of.keep_angle > std::f64::consts::PI {
            let message =
                format!("settings->keep_angle is {}: it must be at most pi", of.keep_angle);
            return Err(Error::value(message));
        }
        if of.missing.is_nan() {
            let message = "settings->missing is NaN: it must be a share of 0 to 1, or below 0";
            return Err(Error::value(message));
        }
        let scene = SceneSettings {
            view_cells: (of.cells != 0).then_some(of.cells),
            regions: boxes.iter().map(|b| [b.min, b.max]).collect(),
            grid: has_grid.then_some(of.grid),
            rays: (of.rays != 0).then_some(of.rays),
            missing: (of.missing != 0.0).then_some(of.missing.max(0.0)),
            keep_angle: number("keep_angle", of.keep_angle)?.map(f64::to_degrees),
            join: number("join", of.join)?,
            ..SceneSettings::default()
        };
        let seed = if of.seed == 0 { Settings::default().seed } else { of.seed };
        let settings = Settings { seed, scene, ..Settings::default() };
        Ok(Self { settings, boxes_are_cells: are_cells == 1 })
    }

    fn view_cells(&self, tree: &RayTree<'_>) -> std::result::Result<ViewCells, SampledError> {
        match self.boxes_are_cells {
            true => ViewCells::of_boxes(&self.settings.scene.regions),
            false => self.settings.view_cells(tree),
        }
    }
}

/// Bakes visible sets of a scene, as `cullet pvs` does, with the same bytes; `cullet_pvs_write`
/// writes them, and `cullet_scene_set_pvs` culls by them. A scene with cells of its own and
/// settings that ask for no view cells gets sets of those: conservative. Otherwise it gets sets of
/// instances, seen from view cells and found by rays: something may be missing, and
/// `cullet_pvs_info.mean_missing` says how much is likely to be. `settings` and `options` may be
/// NULL. The same on every run and machine, for any threads, shares and stops. Reads the scene,
/// which must stay as it is. Cost: seconds to hours, in proportion to `rays`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_bake_pvs(
    scene: Scene,
    settings: *const PvsSettings,
    options: *const BakeOptions,
    pvs: *mut Pvs,
) -> Status {
    call("cullet_bake_pvs", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("pvs", pvs) }?;
        // SAFETY: as the header asks of the caller.
        let asked = unsafe { Asked::of(settings) }?;
        // SAFETY: as the header asks of the caller.
        let bake = unsafe { Bake::of(options) }?;
        let own = SCENES.get(scene.id)?;
        let own = &*own;
        let bytes = on_deep_stack(|| match own.cells() {
            Some(cells) if !asked.settings.scene.wants_view_cells() => {
                of_cells(cells, &asked, &bake)
            }
            _ => of_scene(own, &asked, &bake),
        })?;
        out.set(0, insert_bytes(bytes)?);
        Ok(())
    })
}

fn of_cells(cells: &Cells, asked: &Asked, bake: &Bake<'_>) -> Result<Vec<u8>> {
    let mut work = CellsBake::new(cells.graph(), &asked.settings.of_cells(), bake.threads);
    bake.run(&mut work)?;
    Ok(work.finish().to_bytes())
}

fn of_scene(scene: &engine::Scene, asked: &Asked, bake: &Bake<'_>) -> Result<Vec<u8>> {
    let fail = |e: SampledError| Error::value(e.to_string());
    let tree = RayTree::new(scene, &RayTreeOptions::default()).map_err(fail)?;
    let cells = asked.view_cells(&tree).map_err(fail)?;
    let mut work = SampledBake::new(&tree, &cells, &asked.settings.sampled()).map_err(fail)?;
    bake.run(&mut work)?;
    Ok(work.finish().to_bytes())
}

/// Settings of cells that are found. Set them to zero before their fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CellsSettings {
    /// Side of a voxel, in world units: no more than half as thick as the walls. 0 finds one.
    pub voxel: f64,
    /// Instances that hide nothing because they move, such as doors; NULL for none.
    pub ignored: *const Handle,
    /// How many of them.
    pub ignored_count: usize,
}

impl Plain for CellsSettings {}

/// Finds the rooms of a scene and the openings between them, in its triangles, and gives the scene
/// these cells in place of its own: `cullet_cull` culls by them at once, and `cullet_bake_pvs` bakes
/// sets of them. Conservative: walls are closed, opaque meshes, which must stay where they are.
/// `count` takes how many cells there are, unless it is NULL; the first is the outside. `settings`
/// and `options` may be NULL; the work has five steps and no units, so that `options->folder` must
/// be NULL. Refused with `CULLET_STATUS_INVALID_VALUE` where nothing is closed, all is one cell, or
/// there are too many voxels; the message says what to try. `cullet_scene_save` keeps them in a GLB.
/// Needs the scene alone. Cost: linear in the voxels, and in the triangles by the voxels that they
/// touch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_bake_cells(
    scene: Scene,
    settings: *const CellsSettings,
    options: *const BakeOptions,
    count: *mut u32,
) -> Status {
    call("cullet_bake_cells", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("count", count, usize::from(!count.is_null())) }?;
        let mut find = FindOptions::default();
        if !settings.is_null() {
            // SAFETY: as the header asks of the caller.
            let of = unsafe { value("settings", settings) }?;
            // SAFETY: as the header asks of the caller.
            let ignored = unsafe { read("settings->ignored", of.ignored, of.ignored_count) }?;
            find.ignored = ignored.iter().map(|&handle| EngineHandle::from(handle)).collect();
            find.voxel = (of.voxel != 0.0).then_some(of.voxel);
        }
        // SAFETY: as the header asks of the caller.
        let bake = unsafe { Bake::of(options) }?;
        bake.no_units()?;
        let mut own = SCENES.get_mut(scene.id)?;
        let own = &mut *own;
        let found = on_deep_stack(|| find_in(own, &find, &bake))?;
        if out.room() > 0 {
            out.set(0, found);
        }
        Ok(())
    })
}

fn find_in(own: &mut InCells, options: &FindOptions, bake: &Bake<'_>) -> Result<u32> {
    let step = |step: FindStep| bake.at(f64::from(step.done) / f64::from(step.of));
    let found = find_cells(&own.scene, options, bake.threads, step, || bake.goes_on());
    let found = found.map_err(|e| match e {
        RoomsError::Stopped => stopped(),
        e => Error::value(e.to_string()),
    })?;
    let graph = found.into_graph();
    let (cells, shapes) = graph.build().map_err(|e| Error::new(Status::Mesh, e.to_string()))?;
    let placed = Cells::new(&mut own.scene, cells, shapes);
    let count = placed.graph().cell_count();
    own.set_cells(placed);
    own.rest.cells = graph;
    Ok(count)
}

#[cfg(test)]
mod tests;
