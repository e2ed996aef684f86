//! Two rooms and a door: what portals hide, which door hides it, and what changes when that is opened.

use cullet::{Culler, Instance, Mesh, MeshData, Scene, Transform, View, ViewState, Visible};
use cullet_cells::cell::{CellGraph, CellPiece, CellShapes, Portal};
use cullet_cells::{CellView, Cells};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let chair = scene.add_mesh(Mesh::new(MeshData {
        positions: vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        ..MeshData::default()
    })?);
    let at = |x| Transform::from_scale_translation([0.3; 3], [x, 1.0, 2.0]);
    scene.add(Instance::new(chair, at(2.0)))?;
    let beyond = scene.add(Instance::new(chair, at(7.0)))?;
    let culler = Culler::default();
    scene.commit(&culler);

    // Counter-clockwise as seen from the first cell.
    let polygon = vec![[4.0, 0.0, 1.5], [4.0, 0.0, 2.5], [4.0, 2.0, 2.5], [4.0, 2.0, 1.5]];
    let graph = CellGraph::new(2, vec![Portal { cells: [0, 1], polygon }])?;
    let rooms = vec![
        CellPiece::from_box(0, [0.0, 0.0, 0.0], [4.0, 3.0, 4.0]),
        CellPiece::from_box(1, [4.0, 0.0, 0.0], [8.0, 3.0, 4.0]),
    ];
    let shapes = CellShapes::new(&graph, rooms)?;
    let mut cells = Cells::new(&mut scene, graph, shapes);

    let mut visible = Visible::default();
    let (mut state, mut among) = (ViewState::default(), CellView::default());
    let view = View::perspective([0.5, 1.2, 2.0], [4.0, 1.2, 2.0], 1.0, 0.1, 100.0, [640, 480])?;
    for open in [true, false] {
        cells.set_portal_open(0, open);
        culler.cull_among(&scene, &view, &among.on(&cells), &mut state, &mut visible)?;
        let told = culler.explain_among(&scene, &view, &among.on(&cells), &[beyond])?;
        let portal = told[0].steps.iter().find(|step| step.stage == cullet::Stage::Portal);
        let why = portal.map_or_else(String::new, ToString::to_string);
        println!("{} visible; {why}", visible.instance_count);
    }
    Ok(())
}
