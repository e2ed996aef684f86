//! Occlusion culling by hand: draw what hides, test what is hidden.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Visibility};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 16.0 / 9.0, near: 0.1, far: 500.0 };
    let camera = Camera::look_at([0.0, 1.7, 0.0], [0.0, 1.7, -100.0], projection);
    let view = View::new(&camera, Depth::Reversed, [1280, 720])?;

    // A house, and a wall that hides from both sides. What hides must lie within what is opaque.
    let house = Convex::from_box(&Aabb::new([-5.0, 0.0, -30.0], [5.0, 8.0, -20.0]))?;
    let wall = Convex::from_polygon(&[
        [6.0, 0.0, -15.0],
        [14.0, 0.0, -15.0],
        [14.0, 3.0, -15.0],
        [6.0, 3.0, -15.0],
    ])?;

    // A quarter of the pixels of the view: what is called hidden is hidden all the same.
    let mut buffer = OcclusionBuffer::new([640, 360])?;
    buffer.begin(&view, [0.0; 3]);
    for occluder in [&house, &wall] {
        occluder.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }

    for (name, x) in [("behind the house", 0.0), ("beside it", -14.0), ("behind the wall", 20.0)] {
        let tree = Aabb::new([x - 1.0, 0.0, -41.0], [x + 1.0, 4.0, -39.0]);
        let visibility = buffer.test_box(&tree);
        println!(
            "a tree {name}: {}",
            if visibility == Visibility::Hidden { "hidden" } else { "drawn" }
        );
    }
    Ok(())
}
