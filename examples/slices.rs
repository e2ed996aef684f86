//! Frustum culling over one's own arrays: no scene, no engine to adopt.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::{Camera, Depth, Projection, Simd, View};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A field of a million unit boxes, as an engine might hold them.
    let objects: Vec<Aabb> = (0..1_000_000)
        .map(|i| {
            let (x, z) = ((i % 1000) as f32 * 3.0 - 1500.0, (i / 1000) as f32 * 3.0 - 1500.0);
            Aabb::new([x, 0.0, z], [x + 1.0, 1.0, z + 1.0])
        })
        .collect();
    let boxes = Boxes::from_slice(&objects);

    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 16.0 / 9.0, near: 0.1, far: 500.0 };
    let camera = Camera::look_at([0.0, 2.0, 0.0], [100.0, 0.0, 30.0], projection);
    let view = View::new(&camera, Depth::Standard, [1280, 720])?;

    // Once a frame: the planes; then one call fills a list that is reused from frame to frame.
    let planes = Planes::new(&view.frustum());
    let mut visible = Indices::new();
    cull_boxes(Simd::best(), &planes, &boxes, &mut visible);
    println!("{} of {} boxes may be visible", visible.len(), boxes.len());
    Ok(())
}
