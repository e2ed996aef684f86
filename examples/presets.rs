//! The presets of the culler, and one setting changed: how much each leaves of a street of houses.

use cullet::{
    Culler, Instance, Mesh, MeshData, Scene, Transform, View, ViewState, Visible,
    cull::occlusion::Occlusion,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 * 2.0 - 1.0);
    let house = scene.add_mesh(Mesh::new(MeshData {
        positions: (0..8).map(corner).collect(),
        indices: vec![
            0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6,
            2, 1, 3, 7, 1, 7, 5,
        ],
        ..MeshData::default()
    })?);
    for i in 0..1000 {
        let at = [f64::from(i % 40) * 3.0 - 60.0, 0.0, f64::from(i / 40) * -6.0 - 6.0];
        scene.add(Instance::new(house, Transform::from_translation(at)))?;
    }
    scene.commit(&Culler::exact());

    let narrow = Occlusion::default().with_width(64);
    let narrow = Culler::balanced().with_occlusion(narrow);
    let (exact, balanced, fast) = (Culler::exact(), Culler::balanced(), Culler::fast());
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.8, 0.1, 500.0, [1280, 720])?;
    for (name, culler) in
        [("exact", exact), ("balanced", balanced), ("fast", fast), ("narrow", narrow)]
    {
        let mut visible = Visible::default();
        culler.cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
        println!("{name}: {} of 1000 houses are drawn", visible.instance_count);
    }
    Ok(())
}
