//! Finds the rooms of a building that has no cells, and shows what its portals hide.
//!
//!     cargo run --release -p cullet-bake --example rooms

use cullet::{Culler, Stage, View, ViewState, Visible};
use cullet_bake::rooms::{FindOptions, find_cells};
use cullet_cells::Cells;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An office of which we keep the triangles alone.
    let mut model = cullet_scenes::build("office:floors=1,corridors=1,roof=1")?;
    let doors = model.cells.portals.iter().filter_map(|portal| portal.door).collect();
    model.placed = None;

    let options = FindOptions::default().with_voxel(0.1).with_ignored(doors);
    let found = find_cells(&model.scene, &options, 2, |_| true, || true)?;
    let figures = &found.figures;
    println!("{} cells, {} portals", found.cells.len(), found.portals.len());
    let [sides, closed] = figures.sides;
    println!("{} free voxels; {closed} of {sides} sides at walls are closed", figures.free);

    let (graph, shapes) = found.build()?;
    model.placed = Some(Cells::new(&mut model.scene, graph, shapes));
    // From the middle of the largest box of each cell but the outside.
    let volume = |b: &[[f64; 3]; 2]| (0..3).map(|a| b[1][a] - b[0][a]).product::<f64>();
    let rooms = found.cells[1..].iter();
    let largest =
        rooms.filter_map(|c| c.pieces.iter().max_by(|a, b| volume(a).total_cmp(&volume(b))));
    let mut visible = Visible::default();
    let mut left = [0_u64; 2];
    for [low, high] in largest {
        let eye: [f64; 3] = std::array::from_fn(|a| (low[a] + high[a]) * 0.5);
        let target = [eye[0] + 1.0, eye[1], eye[2] + 0.5];
        let view = View::perspective(eye, target, 1.2, 0.05, 200.0, [640, 480])?;
        for (stage, left) in [Stage::Frustum, Stage::Portal].into_iter().zip(&mut left) {
            let culler = Culler::default().only(stage);
            model.in_cells().cull(&culler, &view, &mut ViewState::default(), &mut visible);
            *left += visible.instance_count;
        }
    }
    println!("instances left, over all rooms: {} by the frustum, {} by portals", left[0], left[1]);
    Ok(())
}
