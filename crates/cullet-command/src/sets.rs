//! Visible sets that were baked before, given to the scene that they are of.

use std::path::Path;

use cullet_cells::cell::CellGraph;
use cullet_cells::pvs::VisibleSets;
use cullet_io::Model;
use cullet_io::baked::{CellSets, Container, PvsFileError, SceneSets};
use cullet_maps::bsp::Bsp;

use crate::exit::Failure;

/// Gives a model the sets of a file: those of its cells, or view cells with their own.
///
/// # Errors
/// If the file cannot be read, is damaged, or is of another scene.
pub(crate) fn place(model: &mut Model, scene: &str, path: &Path) -> Result<(), Failure> {
    let bytes = std::fs::read(path).map_err(|error| failure(path, &error))?;
    let file = Container::open(&bytes).map_err(|error| failure(path, &error))?;
    if SceneSets::is_of(&file) {
        let sets = SceneSets::from_bytes(&bytes).map_err(|error| failure(path, &error))?;
        let cells = sets.place_in(&mut model.scene).map_err(|error| failure(path, &error))?;
        model.placed = Some(cells);
        return Ok(());
    }
    if !CellSets::is_of(&file) {
        return Err(failure(path, &"a baked file, but without visible sets"));
    }
    let stored = CellSets::open(file).map_err(|error| failure(path, &error))?;
    // Damage is noticed here: sets alone are looked up as they are.
    stored.check().map_err(|error| failure(path, &error))?;
    let placed = model.placed.as_mut().ok_or_else(|| {
        failure(path, &format!("sets of cells, but {scene} has none that a scene can be given"))
    })?;
    let sets = of_graph(&stored, placed.graph()).or_else(|error| {
        match (error, map_graph(Path::new(scene))) {
            // Maps are baked in their own axes.
            (PvsFileError::OtherGraph { .. }, Some(graph)) => of_graph(&stored, &graph),
            (error, _) => Err(error),
        }
    });
    let sets = sets.map_err(|error| failure(path, &error))?;
    placed.set_visible_sets(sets).map_err(|error| failure(path, &error))
}

/// Returns the error that the sets of a file state: mean over the cells of the share of looks that
/// go to what is missing, and the highest share of a cell. `None` for sets that lack nothing.
///
/// # Errors
/// If the file cannot be read or is damaged.
pub fn stated_error(path: &Path) -> Result<Option<[f64; 2]>, Failure> {
    Ok(of_scene(path)?.map(|sets| sets.stated_error()))
}

/// The sets of a file, where they are those of a scene's view cells.
///
/// # Errors
/// If the file cannot be read or is damaged.
pub fn of_scene(path: &Path) -> Result<Option<SceneSets>, Failure> {
    let bytes = std::fs::read(path).map_err(|error| failure(path, &error))?;
    let file = Container::open(&bytes).map_err(|error| failure(path, &error))?;
    if !SceneSets::is_of(&file) {
        return Ok(None);
    }
    SceneSets::from_bytes(&bytes).map(Some).map_err(|error| failure(path, &error))
}

/// Gives a map the sets that it brings along, where its cells are those of the scene.
pub(crate) fn place_stored(model: &mut Model) {
    // Without cells they are of no use, and why there are none is said already.
    if let (Some(sets), Some(placed)) = (&model.cell_sets, &mut model.placed) {
        let placed = placed.set_visible_sets(sets.clone());
        debug_assert_eq!(placed, Ok(()));
    }
}

fn of_graph(
    stored: &CellSets<'_>,
    graph: &CellGraph,
) -> Result<VisibleSets<'static>, PvsFileError> {
    stored.of_graph(graph).map(VisibleSets::into_owned)
}

/// The cells of a map, as `cullet pvs` makes them.
fn map_graph(scene: &Path) -> Option<CellGraph> {
    scene.extension().filter(|e| e.eq_ignore_ascii_case("bsp"))?;
    Bsp::parse(&std::fs::read(scene).ok()?).ok()?.cells().ok()
}

fn failure(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::input(format!("{}: {error}", path.display()))
}
