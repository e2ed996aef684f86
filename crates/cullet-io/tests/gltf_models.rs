//! The glTF models of the test data have the counts that its README gives.

use cullet_io::{LoadOptions, Model, Up, load};
use cullet_testkit::data;

/// Vertices and triangles of all instances, triangles of all meshes, instances, meshes.
type Counts = (usize, u64, u64, u32, usize);

fn counts(model: &Model) -> Counts {
    let scene = &model.scene;
    (
        scene.slots().map(|s| scene.mesh(s).positions().len()).sum(),
        scene.triangle_count(),
        scene.meshes().iter().map(|m| u64::from(m.triangle_count())).sum(),
        scene.instance_count(),
        scene.meshes().len(),
    )
}

const MODELS: [(&str, Counts); 8] = [
    ("intel-castle/intel-castle.glb", (1_490_689, 1_070_891, 139_619, 2_114, 437)),
    ("duplex-bim/duplex.glb", (15_038, 26_348, 15_396, 215, 153)),
    ("duplex-bim/duplex-spaces.glb", (326, 568, 568, 21, 21)),
    ("city-delft/delft.glb", (17_857, 21_801, 21_801, 570, 570)),
    ("city-rotterdam/delfshaven.glb", (26_679, 38_530, 38_530, 853, 853)),
    ("room-godot/room.glb", (34_716, 63_720, 63_720, 17, 17)),
    ("cad-2cylinder/2CylinderEngine.glb", (84_657, 121_496, 75_730, 67, 29)),
    ("cad-satellite/FM1_satellite.glb", (104_495, 103_566, 97_002, 62, 36)),
];

#[test]
fn counts_are_those_of_the_table() {
    for (file, expected) in MODELS {
        let Some(path) = data(file) else { continue };
        let model = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(counts(&model), expected, "{file}");
        assert_eq!(model.warnings, [], "{file}");
        assert_eq!(model.mesh_names.len(), model.scene.meshes().len(), "{file}");
        assert_eq!(model.instance_names.len(), model.scene.instance_count() as usize, "{file}");
        for mesh in model.scene.meshes() {
            let materials = model.materials.len();
            assert!(mesh.parts().iter().all(|p| (p.material as usize) < materials), "{file}");
        }
    }
}

/// All 853 meshes name one accessor of 22,246 vertices: copied whole they would be 19 million.
#[test]
fn a_vertex_accessor_of_many_meshes_is_not_multiplied() {
    let Some(file) = data("city-rotterdam/original-gltf/3-20-DELFSHAVEN.gltf") else { return };
    let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let model = load(&file, &options).unwrap();
    assert_eq!(counts(&model), (26_679, 38_530, 38_530, 853, 853));
    for mesh in model.scene.meshes() {
        let mut used: Vec<u32> = mesh.indices().to_vec();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), mesh.positions().len());
    }
    // With Z up, heights are the scene's y: a city is wider than it is high.
    let extent = model.scene.extent();
    let size: Vec<f32> = (0..3).map(|a| extent.max[a] - extent.min[a]).collect();
    assert!(size[1] * 3.0 < size[0].min(size[2]), "{size:?}");
}

#[test]
fn an_engines_camera_is_read() {
    let Some(file) = data("cad-2cylinder/2CylinderEngine.glb") else { return };
    let model = load(&file, &LoadOptions::default()).unwrap();
    let [camera] = &model.cameras[..] else { panic!("{:?}", model.cameras) };
    assert_eq!(camera.keys.len(), 1);
    let cullet::Projection::Perspective { fov_y_radians, near, far, .. } = camera.projection else {
        panic!("{:?}", camera.projection)
    };
    assert!(fov_y_radians > 0.1 && fov_y_radians < 2.0 && near > 0.0 && far > near);
}
