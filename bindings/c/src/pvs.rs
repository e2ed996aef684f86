//! Visible sets: opened, asked, and given to the scene that they are of.

use std::ffi::c_char;
use std::path::Path;

use cullet_cells::cell::{CellGraph, CellLocator, CellPiece, CellShapes};
use cullet_cells::pvs::{Targets, VisibleSets};
use cullet_io::baked::{CellSets, Container, Region, SceneSets};

use crate::memory::{Out, read, text};
use crate::registry::{Kind, Table};
use crate::results::write;
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Result, Status, call};
use crate::view::EyeBox;

static SETS: Table<Sets> = Table::new(Kind::Pvs);

/// Handle of potentially visible sets: what may be seen from each of some cells. A plain number: copy
/// it freely; 0 is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Pvs {
    /// Not to be read or made.
    pub id: u64,
}

/// Kinds of items that visible sets hold.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum PvsTargets {
    /// Cells of the scene. Conservative, and true of whatever moves.
    Cells = 0,
    /// Instances, by the `index` of their handles, seen from view cells: boxes that the sets bring
    /// along. Found by sampled lines, so that something may be missing.
    Instances = 1,
}

/// Contents of visible sets.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PvsInfo {
    /// Cells that there is a set of.
    pub cell_count: u32,
    /// Items that the sets may hold: cells, or instances.
    pub target_count: u32,
    /// A `cullet_pvs_targets`.
    pub targets: u32,
    /// 0.
    pub reserved: u32,
    /// Rays that were traced for them; 0 for sets of cells.
    pub rays: u64,
    /// Share of looks that are estimated to end on something that its set lacks, 0 to 1: the mean
    /// over the cells. 0 for sets of cells, which lack nothing.
    pub mean_missing: f64,
    /// The same of the cell where it is largest.
    pub most_missing: f64,
}

/// Sets behind a handle.
#[derive(Debug)]
enum Sets {
    Scene { sets: SceneSets, places: CellShapes },
    Cells { bytes: Vec<u8>, sets: VisibleSets<'static> },
}

fn fail(error: impl std::fmt::Display) -> Error {
    Error::new(Status::File, error.to_string())
}

/// Makes a handle of sets.
#[cfg(feature = "bake")]
pub(crate) fn insert_bytes(bytes: Vec<u8>) -> Result<Pvs> {
    Ok(Pvs { id: SETS.insert(Sets::of_bytes(bytes)?)? })
}

impl Sets {
    /// Reads the bytes of a file; all sums are checked.
    fn of_bytes(bytes: Vec<u8>) -> Result<Self> {
        let file = Container::open(&bytes).map_err(fail)?;
        if SceneSets::is_of(&file) {
            let sets = SceneSets::from_bytes(&bytes).map_err(fail)?;
            let graph = CellGraph::new(sets.cells.len() as u32, Vec::new()).map_err(fail)?;
            let piece = |(cell, [min, max]): (u32, &Region)| CellPiece::from_box(cell, *min, *max);
            let pieces = (0..).zip(&sets.cells).map(piece).collect();
            let places = CellShapes::new(&graph, pieces).map_err(fail)?;
            return Ok(Self::Scene { sets, places });
        }
        if !CellSets::is_of(&file) {
            return Err(fail("a baked file, but without visible sets"));
        }
        CellSets::open(file).and_then(|stored| stored.check()).map_err(fail)?;
        let of_file = file.chunk(CellSets::SETS).map_err(fail)?;
        let sets = VisibleSets::from_bytes(of_file).map_err(fail)?.into_owned();
        Ok(Self::Cells { bytes, sets })
    }

    fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::Scene { sets, .. } => sets.to_bytes(),
            Self::Cells { bytes, .. } => bytes.clone(),
        }
    }

    fn sets(&self) -> &VisibleSets<'static> {
        match self {
            Self::Scene { sets, .. } => &sets.sets,
            Self::Cells { sets, .. } => sets,
        }
    }

    /// View cells and what they miss; refused for sets of a scene's own cells.
    fn view_cells(&self) -> Result<(&SceneSets, &CellShapes)> {
        match self {
            Self::Scene { sets, places } => Ok((sets, places)),
            Self::Cells { .. } => Err(Error::new(
                Status::NotFound,
                "these are sets of a scene's own cells, which have no view cells: ask cullet_scene_cell_of",
            )),
        }
    }

    fn info(&self) -> PvsInfo {
        let sets = self.sets();
        let of_scene = self.view_cells().ok().map(|(sets, _)| sets);
        let [mean_missing, most_missing] = of_scene.map_or([0.0; 2], SceneSets::stated_error);
        PvsInfo {
            cell_count: sets.cell_count(),
            target_count: sets.target_count(),
            targets: match sets.targets() {
                Targets::Cells => PvsTargets::Cells as u32,
                Targets::Instances => PvsTargets::Instances as u32,
            },
            reserved: 0,
            rays: of_scene.map_or(0, |sets| sets.rays),
            mean_missing,
            most_missing,
        }
    }

    /// Gives a scene the sets.
    fn place_in(&self, scene: &mut InCells) -> Result {
        match self {
            Self::Scene { sets, .. } => {
                let cells = sets.clone().place_in(&mut scene.scene).map_err(fail)?;
                scene.set_view_cells(Some(cells));
            }
            Self::Cells { bytes, .. } => {
                let cells = scene.cells().ok_or_else(|| {
                    fail("these are sets of a scene's own cells, and this scene has none")
                })?;
                let stored = Container::open(bytes).map_err(fail)?;
                let stored = CellSets::open(stored).map_err(fail)?;
                let sets = stored.of_graph(cells.graph()).map_err(fail)?.into_owned();
                if let Some(cells) = scene.cells_mut() {
                    cells.set_visible_sets(sets).map_err(fail)?;
                }
                scene.set_view_cells(None);
            }
        }
        Ok(())
    }
}

/// Opens a file of visible sets, as `cullet pvs` and `cullet_pvs_write` make them. The path is
/// UTF-8. Refused with `CULLET_STATUS_FILE` where it cannot be read, is cut short or was changed; the
/// message names the file. Destroy them with `cullet_pvs_destroy`. Cost: linear in the file.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_open(path: *const c_char, pvs: *mut Pvs) -> Status {
    call("cullet_pvs_open", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("pvs", pvs) }?;
        // SAFETY: as the header asks of the caller.
        let path = unsafe { text("path", path) }?;
        let named = |e: &dyn std::fmt::Display| fail(format_args!("{path}: {e}"));
        // A device might never end.
        if std::fs::metadata(path).is_ok_and(|at| !at.is_file()) {
            return Err(named(&"it is no file"));
        }
        let bytes = std::fs::read(Path::new(path)).map_err(|e| named(&e))?;
        let sets = Sets::of_bytes(bytes).map_err(|e| named(&e.message))?;
        out.set(0, Pvs { id: SETS.insert(sets)? });
        Ok(())
    })
}

/// Makes visible sets of the bytes of such a file, for programs with files of their own; they are
/// copied. Otherwise as `cullet_pvs_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_read(bytes: *const u8, size: usize, pvs: *mut Pvs) -> Status {
    call("cullet_pvs_read", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("pvs", pvs) }?;
        // SAFETY: as the header asks of the caller.
        let bytes = unsafe { read("bytes", bytes, size) }?;
        out.set(0, Pvs { id: SETS.insert(Sets::of_bytes(bytes.to_vec())?)? });
        Ok(())
    })
}

/// Writes visible sets as the bytes of a file, which `cullet_pvs_open`, `cullet_pvs_read` and the
/// program `cullet` read. `capacity` and `count`, in bytes, as for `cullet_visible_slots`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_write(
    pvs: Pvs,
    bytes: *mut u8,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_pvs_write", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("bytes", bytes, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let own = SETS.get(pvs.id)?.to_bytes();
        write(&mut out, &mut count, own.iter().copied(), own.len())
    })
}

/// Destroys visible sets; their handle is stale from then on. Scenes that were given them keep them.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_pvs_destroy(pvs: Pvs) -> Status {
    call("cullet_pvs_destroy", || SETS.remove(pvs.id).map(drop))
}

/// Writes the contents of visible sets.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_get_info(pvs: Pvs, info: *mut PvsInfo) -> Status {
    call("cullet_pvs_get_info", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("info", info) }?;
        out.set(0, SETS.get(pvs.id)?.info());
        Ok(())
    })
}

/// Writes the view cells, in the order of their numbers, in world space; `CULLET_STATUS_NOT_FOUND`
/// for sets of a scene's own cells. `capacity` and `count` as for `cullet_visible_slots`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_cells(
    pvs: Pvs,
    boxes: *mut EyeBox,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_pvs_cells", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("boxes", boxes, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let own = SETS.get(pvs.id)?;
        let cells = &own.view_cells()?.0.cells;
        let boxes = cells.iter().map(|&[min, max]| EyeBox { min, max });
        write(&mut out, &mut count, boxes, cells.len())
    })
}

/// Writes for each view cell the share of looks from it that are estimated to end on something that
/// its set lacks, 0 to 1. Otherwise as `cullet_pvs_cells`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_missing(
    pvs: Pvs,
    shares: *mut f32,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_pvs_missing", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("shares", shares, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let own = SETS.get(pvs.id)?;
        let missing = &own.view_cells()?.0.missing;
        write(&mut out, &mut count, missing.iter().copied(), missing.len())
    })
}

/// Writes the view cell of each point, three doubles in world space; `UINT32_MAX` where it is in
/// none, or not finite. Of several that touch there, it is the lowest. `CULLET_STATUS_NOT_FOUND` for
/// sets of a scene's own cells: ask `cullet_scene_cell_of`. Cost: that of a tree of the cells for
/// each point; allocates nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_cell_of(
    pvs: Pvs,
    points: *const f64,
    count: usize,
    cells: *mut u32,
) -> Status {
    call("cullet_pvs_cell_of", || {
        // SAFETY: as the header asks of the caller.
        let points = unsafe { read("points", points.cast::<[f64; 3]>(), count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("cells", cells, count) }?;
        let own = SETS.get(pvs.id)?;
        let (_, places) = own.view_cells()?;
        for (at, &point) in points.iter().enumerate() {
            out.set(at, places.cell_of(point).unwrap_or(u32::MAX));
        }
        Ok(())
    })
}

/// Writes all that may be seen from any of some cells, ascending: the `index` of each handle, or
/// numbers of cells, as `cullet_pvs_info.targets` says. For streaming and for your own culling;
/// instances that were added since the bake are in no set. `CULLET_STATUS_NOT_FOUND` where there is
/// no such cell. `capacity` and `count` as for `cullet_visible_slots`. Cost: linear in the targets,
/// for each cell; allocates a bit a target.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_pvs_visible(
    pvs: Pvs,
    cells: *const u32,
    cell_count: usize,
    targets: *mut u32,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_pvs_visible", || {
        // SAFETY: as the header asks of the caller.
        let cells = unsafe { read("cells", cells, cell_count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("targets", targets, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let own = SETS.get(pvs.id)?;
        let sets = own.sets();
        let all = sets.cell_count();
        if let Some(at) = cells.iter().position(|&cell| cell >= all) {
            let message = format!("cells[{at}] is {}: the sets have {all} cells", cells[at]);
            return Err(Error::new(Status::NotFound, message));
        }
        let row = sets.union(cells);
        let needed = row.iter().map(|word| word.count_ones() as usize).sum();
        let seen = (0..sets.target_count()).filter(|&t| row[t as usize / 64] >> (t % 64) & 1 == 1);
        write(&mut out, &mut count, seen, needed)
    })
}

/// Gives a scene visible sets, to be culled by from now on where `cullet_settings.pvs` is 1 and the
/// eye is in one of their cells; 0 for no more. They are copied. Sets of view cells take the place
/// of the scene's own cells and portals until then; those of cells need the cells that they were
/// baked of. Instances that are added or moved later are seen from everywhere; what hides must stay
/// where it was. Refused with `CULLET_STATUS_FILE` where they are of another scene, or of this one
/// before it was changed. Cost: linear in the triangles of the meshes and in the instances.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_scene_set_pvs(scene: Scene, pvs: Pvs) -> Status {
    call("cullet_scene_set_pvs", || {
        let mut scene = SCENES.get_mut(scene.id)?;
        if pvs.id == 0 {
            if let Some(cells) = scene.cells_mut() {
                cells.clear_visible_sets();
            }
            scene.set_view_cells(None);
            return Ok(());
        }
        SETS.get(pvs.id)?.place_in(&mut scene)
    })
}
