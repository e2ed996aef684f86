//! Visibility from anywhere in a box of eyes, and what will be needed along a way.

use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_cells::query::{EyeBox, Motion, MotionQuery, RegionCuller, RegionState, RegionVisible};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A cube, −1..1 along each axis; its faces by the numbers of its corners.
    let corner = |i: u32| [0, 1, 2].map(|a| if i >> a & 1 == 1 { 1.0 } else { -1.0 });
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let positions = (0..8).map(corner).collect();
    let indices = faces.iter().flat_map(|f: &[u32; 4]| [0, 1, 2, 0, 2, 3].map(|k| f[k])).collect();
    let mut scene = Scene::new();
    let cube = scene.add_mesh(Mesh::new(MeshData { positions, indices, ..MeshData::default() })?);
    // Two rows of houses along a street, and a tree in the yard behind each of the left row.
    for i in 0..12 {
        let z = f64::from(i) * -12.0;
        for x in [-10.0, 10.0] {
            let house = Transform::from_scale_translation([4.0, 5.0, 5.9], [x, 5.0, z]);
            scene.add(Instance { user_data: 1, ..Instance::new(cube, house) })?;
        }
        scene.add(Instance::new(cube, Transform::from_translation([-20.0, 1.0, z])))?;
    }
    scene.commit(&cullet::Culler::default());

    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    let street = EyeBox::new([-3.0, 1.5, -70.0], [3.0, 1.9, -60.0]);
    RegionCuller::default().cull(&scene, &street, &mut state, &mut visible)?;
    let trees = visible.slots().filter(|&s| scene.user_data(s) == 0).count();
    println!(
        "{} of 36 may be seen from the street, {trees} of them trees",
        visible.slots().count()
    );

    // Down the street, and round its end.
    let way = [[0.0, 1.7, -60.0], [0.0, 1.7, -150.0], [-30.0, 1.7, -150.0]];
    let mut needed = Vec::new();
    MotionQuery::default().needed(&scene, &Motion::along(&way), &mut state, &mut needed)?;
    for n in needed.iter().filter(|n| n.distance > 0.0) {
        println!("slot {} is needed from {:.0} m on", scene.slot(n.handle)?, n.distance);
    }
    Ok(())
}
