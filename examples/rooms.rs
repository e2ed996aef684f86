//! Finds the rooms of a building that has no cells, and shows what its portals hide.
//!
//!     cargo run --release -p cullet-bake --example rooms

use cullet::{Culler, Stage, View, ViewState, Visible};
use cullet_bake::rooms::{FindOptions, find_cells};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An office of which we keep the triangles alone.
    let mut model = cullet_io::scenes::build("office:floors=1,rooms=3,rows=2")?;
    let doors = model.cells.portals.iter().filter_map(|portal| portal.door).collect();
    model.scene.clear_cells();

    let options = FindOptions::default().with_voxel(0.1).with_ignored(doors);
    let found = find_cells(&model.scene, &options, 2, |_| true, || true)?;
    let figures = &found.figures;
    println!("{} cells, {} portals", found.cells.len(), found.portals.len());
    let [sides, closed] = figures.sides;
    println!("{} free voxels; {closed} of {sides} sides at walls are closed", figures.free);

    let (graph, shapes) = found.build()?;
    model.scene.set_cells(graph, shapes);
    let bounds = model.scene.bounds(0);
    let eye = [f64::from(bounds.min[0]) + 2.0, 1.6, 3.0];
    let view = View::perspective(eye, [eye[0] + 5.0, 1.6, 8.0], 1.2, 0.05, 200.0, [640, 480])?;
    let mut visible = Visible::default();
    for culler in [Culler::default().only(Stage::Frustum), Culler::default().only(Stage::Portal)] {
        culler.cull_one(&model.scene, &view, &mut ViewState::default(), &mut visible);
        println!("{} of {} instances left", visible.instance_count, model.scene.instance_count());
    }
    Ok(())
}
