//! Levels of detail: a mesh in full near by, its coarser level far away, and nothing that flips while the eye stays in a ball.

use cullet::lod::{Group, Levels, Lod, NO_GROUP};
use cullet::view::EyeBall;
use cullet::{Culler, Instance, Mesh, MeshData, Scene, Transform, View, ViewState, Visible};

/// A disc of so many triangles.
fn disc(count: u32) -> MeshData {
    let turn = |i: u32| std::f32::consts::TAU * i as f32 / count as f32;
    let rim = (0..count).map(|i| [turn(i).cos(), turn(i).sin(), 0.0]);
    let indices = (0..count).flat_map(|i| [count, i, (i + 1) % count]).collect();
    MeshData { positions: rim.chain([[0.0; 3]]).collect(), indices, ..MeshData::default() }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let (fine, coarse) =
        (scene.add_mesh(Mesh::new(disc(96))?), scene.add_mesh(Mesh::new(disc(12))?));
    // How far the middle of a side of the coarse one is from the circle: a bake measures this.
    let error = 1.0 - (std::f32::consts::TAU / 24.0).cos();
    let groups = [Group { centre: [0.0; 3], radius: 1.0, error }];
    // The coarse one was made from the group; no other is made from it. The mesh itself needs no entry.
    let clusters = scene.meshes()[coarse as usize].clusters().len();
    let levels = Levels::new(
        &scene.meshes()[coarse as usize],
        &groups,
        vec![0; clusters],
        vec![NO_GROUP; clusters],
    )?;
    scene.add_levels(fine, coarse, levels)?;
    scene.add(Instance::new(fine, Transform::from_translation([0.0, 0.0, -40.0])))?;
    let culler = Culler::default().with_lod(Lod::default().with_pixels(0.5));
    scene.commit(&culler);

    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let mut ball = EyeBall { centre: [0.0; 3], radius: 0.0 };
    for z in [0.0, -2.0, -30.0, -37.0] {
        let mut view =
            View::perspective([0.0, 0.0, z], [0.0, 0.0, -40.0], 1.0, 0.1, 100.0, [640, 480])?;
        ball = ball.follow([0.0, 0.0, z], 3.0);
        view.eyes = Some(ball);
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        let level = visible.partial.first().map_or(0, |range| range.level);
        println!("from {} away: level {level}, {} triangles", 40.0 + z, visible.triangle_count);
    }
    Ok(())
}
