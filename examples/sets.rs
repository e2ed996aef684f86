//! Visible sets at run time: baked once, looked up in every frame, asked what must be there next.

use cullet::{
    Culler, Instance, Mesh, MeshData, Output, Scene, Transform, View, ViewState, Visible,
};
use cullet_bake::pvs::{PvsSettings, bake};
use cullet_cells::cell::{CellGraph, CellPiece, CellShapes, Portal};
use cullet_cells::{CellView, Cells};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Six rooms along x with doors that are not in line, and a body in each.
    let place = |room: u32| 4.0 * f64::from(room);
    let doors = [0.0, 2.6, 2.9, 0.4, 1.2].iter().zip(0..).map(|(&y, room)| {
        let x = place(room + 1);
        let polygon = vec![[x, y, 0.0], [x, y, 2.0], [x, y + 1.0, 2.0], [x, y + 1.0, 0.0]];
        Portal { cells: [room, room + 1], polygon }
    });
    let graph = CellGraph::new(6, doors.collect())?;
    let piece =
        |room| CellPiece::from_box(room, [place(room), 0.0, 0.0], [place(room + 1), 4.0, 3.0]);
    let shapes = CellShapes::new(&graph, (0..6).map(piece).collect())?;
    let mut scene = Scene::new();
    let body = scene.add_mesh(Mesh::new(MeshData {
        positions: vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        ..MeshData::default()
    })?);
    for room in 0..6 {
        let at = Transform::from_scale_translation([0.5; 3], [place(room) + 2.0, 2.0, 0.5]);
        scene.add(Instance::new(body, at))?;
    }
    scene.commit(&Culler::default());
    // Baked here; a game loads the file that `cullet pvs` wrote.
    let sets = bake(&graph, &PvsSettings::default(), 1).sets();
    let mut cells = Cells::new(&mut scene, graph, shapes);
    cells.set_visible_sets(sets)?;

    let view = View::perspective([1.0, 2.0, 1.5], [9.0, 2.0, 1.5], 1.5, 0.05, 100.0, [640, 360])?;
    let (mut state, mut among) = (ViewState::default(), CellView::default());
    let mut visible = Visible::default();
    for pvs in [false, true] {
        let culler =
            Culler::default().with_pvs(pvs).with_portal(false).with_output(Output::Instances);
        culler.cull_among(&scene, &view, &among.on(&cells), &mut state, &mut visible)?;
        println!("with the sets: {pvs}; {} of 6 bodies are drawn", visible.instance_count);
    }
    let sets = cells.visible_sets().ok_or("they were just given")?;
    println!("seen from room 0: {:?}", sets.seen_from(0).collect::<Vec<_>>());
    println!("who sees room 5: {:?}", sets.seeing(5).collect::<Vec<_>>());
    println!("to fetch on the way from 0 to 1: {:?}", sets.arriving(0, 1).collect::<Vec<_>>());
    let ways = cells.graph().ways_from(0, [1.0, 2.0, 1.5], 12.0);
    println!("heard from there, by the length of the way: {ways:.1?}");
    Ok(())
}
