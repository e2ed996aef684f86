//! A scene with a moving view: the state of the view is reused, and says why instances were culled.

use cullet::{
    Camera, Culler, Depth, Instance, Mesh, MeshData, Output, Projection, Scene, Transform, View,
    ViewState, Visible,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(MeshData {
        positions: vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        ..MeshData::default()
    })?);
    for i in 0..1000 {
        let at = [f64::from(i % 40) * 4.0 - 80.0, 0.0, f64::from(i / 40) * -4.0];
        scene.add(Instance::new(mesh, Transform::from_translation(at)))?;
    }

    let culler = Culler::default().with_output(Output::Triangles).with_reasons(true);
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    for frame in 0..3 {
        let eye = [0.0, 3.0, 20.0 - 15.0 * f64::from(frame)];
        let projection =
            Projection::Perspective { fov_y_radians: 0.8, aspect: 1.5, near: 0.1, far: 120.0 };
        let camera = Camera { eye, direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], projection };
        let view = View::new(&camera, Depth::Reversed, [1280, 720])?;
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        println!("frame {frame}: {} of 1000 instances", visible.instance_count);
        if let (Some(Some(reason)), Some(handle)) = (visible.reasons.first(), scene.handle(0)) {
            let why = culler.explain(&scene, &view, handle)?;
            println!("  the first went at stage {}: {:?}", reason.stage.name(), why.steps.last());
        }
    }
    Ok(())
}
