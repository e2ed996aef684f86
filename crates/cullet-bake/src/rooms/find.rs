//! Cells of a scene, from its triangles alone.

use cullet::Scene;
use cullet::math;
use glam::DVec3;

use super::basins::Basins;
use super::found::{FoundCell, FoundCells};
use super::options::{FindOptions, FindStep, FoundFigures, RoomsError};
use super::sides::Sides;
use super::voxels::{FREE, Grid, SOLID, TOUCHED, Voxels, thickness, walls};
use super::{regions, shapes};
use crate::sampled::{Body, RayTree, RayTreeOptions};

/// Share of the surface of all walls that may belong to walls thinner than two voxels.
const THIN: f64 = 0.05;
/// Steps of the work.
const STEPS: u32 = 5;

/// Finds the rooms of a scene, and the openings between them.
///
/// Conservative: a line of sight from an eye in a cell to any place in the scene, that meets no
/// surface, goes through the portals of all cells on its way. Walls are the instances that are
/// closed meshes, opaque, rigid, and not [ignored](FindOptions::ignored); the cells are true for as
/// long as these stand where they are, and are drawn. Cracks narrower than a thousandth of a voxel
/// count as closed. The same for any number of threads.
///
/// `progress` is called between steps, and `false` from it ends the work, as does `go_on` within
/// them.
///
/// Cost: linear in the voxels, and in the triangles of walls by the voxels that they touch; some 20
/// bytes a voxel.
///
/// # Errors
/// If an option is out of its range, nothing is a wall, voxels are too many, or all that is free is
/// one cell.
pub fn find_cells(
    scene: &Scene,
    options: &FindOptions,
    threads: usize,
    mut progress: impl FnMut(FindStep) -> bool,
    go_on: impl Fn() -> bool + Sync,
) -> Result<FoundCells, RoomsError> {
    check(options)?;
    let instances = scene.instance_count();
    let none = |_| RoomsError::NoWalls { instances };
    let tree_options = RayTreeOptions { layers: options.layers, ..RayTreeOptions::default() };
    let tree = RayTree::new(scene, &tree_options).map_err(none)?;
    let walls = walls(&tree, options);
    if walls.is_empty() {
        return Err(RoomsError::NoWalls { instances });
    }
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for body in &walls {
        let bounds = tree.body_bounds(body);
        (low, high) = (low.min(bounds[0]), high.max(bounds[1]));
    }
    let size = options.voxel.unwrap_or_else(|| default_voxel(&tree, &walls, low, high, options));
    let grid = Grid::new([low, high], size)?;
    let mut done = 0;
    let mut step = || {
        done += 1;
        if progress(FindStep { done, of: STEPS }) { Ok(()) } else { Err(RoomsError::Stopped) }
    };
    let mut voxels = Voxels::new(&tree, walls, grid, threads, &go_on)?;
    step()?;
    let sides = Sides::new(&tree, &voxels, threads, &go_on)?;
    sides.mark(&mut voxels);
    step()?;
    let states = std::mem::take(&mut voxels.states);
    let walls = voxels.walls.len() as u32;
    drop(voxels);
    let mut basins = Basins::new(&grid, &states, options, &go_on)?;
    step()?;
    let of_state = |state: u8| states.iter().filter(|s| **s & 15 == state).count() as u64;
    let figures = FoundFigures {
        voxel: grid.size,
        counts: grid.counts.map(|n| n as u32),
        free: of_state(FREE),
        touched: of_state(TOUCHED),
        solid: of_state(SOLID),
        sides: sides.counts,
        walls,
        instances,
    };
    if basins.count < 2 {
        return Err(RoomsError::OneCell { free: figures.free, voxel: grid.size });
    }
    let labels = &mut basins.labels;
    regions::straighten(&grid, &states, labels);
    regions::spread(&grid, &states, labels);
    // Once more, with the touched voxels along the frames of doors.
    regions::straighten(&grid, &states, labels);
    step()?;
    let mut cells = vec![FoundCell::default(); basins.count as usize];
    shapes::boxes(&grid, &states, &basins.labels, &mut cells);
    let portals = shapes::portals(&grid, &states, &basins.labels);
    step()?;
    Ok(FoundCells { cells, portals, figures })
}

fn check(options: &FindOptions) -> Result<(), RoomsError> {
    let setting = |name, value: f64, fits: bool, range| {
        if fits { Ok(()) } else { Err(RoomsError::Setting { name, value, range }) }
    };
    let voxel = options.voxel.unwrap_or(1.0);
    setting("voxel", voxel, voxel > 0.0 && voxel.is_finite(), "a length above 0")?;
    setting("merge", options.merge, (0.0..=1.0).contains(&options.merge), "a share from 0 to 1")?;
    let smallest = options.smallest;
    setting("smallest", smallest, smallest >= 0.0 && smallest.is_finite(), "a length from 0")
}

/// Half as thick as the thinner walls, small enough for the smallest room, and not too many.
fn default_voxel(
    tree: &RayTree<'_>,
    walls: &[&Body],
    low: DVec3,
    high: DVec3,
    options: &FindOptions,
) -> f64 {
    let mut all: Vec<[f64; 2]> = walls.iter().map(|body| thickness(tree, body)).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let whole: f64 = all.iter().map(|[_, area]| area).sum();
    let mut sum = 0.0;
    let thin = all.iter().find(|[_, area]| {
        sum += area;
        sum >= whole * THIN
    });
    let extent = (high - low).max_element();
    let wanted = thin.map_or(extent, |[thick, _]| thick * 0.5);
    let room = if options.smallest > 0.0 { options.smallest / 3.0 } else { extent };
    let mut fits = ((high - low) + extent * 1e-3).element_product();
    fits = math::cbrt(fits / FindOptions::AUTO_VOXELS as f64) * 1.05;
    wanted.min(room).max(fits)
}
