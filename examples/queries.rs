//! Queries of a scene: who sees whom, which room is hidden from which, which lamps matter.

use cullet::bounds::Aabb;
use cullet::cull::shadow::Light;
use cullet::{Instance, Mesh, MeshData, Scene, Transform, View};
use cullet_cells::query::{
    self, BoxSight, LightAnswer, LightOptions, Sight, SightOptions, VolumeOptions,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| bit as f32 * 10.0 - 5.0);
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut scene = Scene::new();
    let house = scene.add_mesh(Mesh::new(MeshData {
        positions: (0..8).map(corner).collect(),
        indices: quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect(),
        ..MeshData::default()
    })?);
    scene.add(Instance::new(house, Transform::from_translation([0.0, 4.0, -20.0])))?;
    scene.commit(&cullet::Culler::default());

    let (guard, thief) = ([0.0, 1.7, 0.0], [1.0, 1.7, -40.0]);
    match query::line_of_sight(&scene, guard, thief, &SightOptions::default()) {
        Sight::Clear => println!("the guard sees the thief"),
        Sight::Blocked(by) => println!("triangle {} is between, at {:?}", by.triangle, by.point),
    }

    let [street, yard] = [0.0, -40.0].map(|z| Aabb::new([-2.0, 0.0, z - 2.0], [2.0, 2.0, z + 2.0]));
    let sight = query::box_to_box(&scene, &street, &yard, &VolumeOptions::default());
    println!("the yard is hidden from the street: {}", matches!(sight, BoxSight::Hidden(_)));

    let view = View::perspective(guard, thief, 1.0, 0.1, 500.0, [1280, 720])?;
    let lamps = [-30.0, 30.0].map(|z| Light::Point { position: [3.0, 4.0, z], range: 12.0 });
    let mut lit = LightAnswer::default();
    query::cull_lights(&scene, &view, &lamps, &LightOptions::default(), &mut lit);
    println!("lamps that matter: {:?}; of the others: {:?}", lit.kept, lit.reasons[1]);
    Ok(())
}
