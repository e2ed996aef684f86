//! Pictures in place of triangles.

use cullet::lod::{Lod, PixelScale};
use cullet::{Culler, Mesh, MeshData, Stage, View};
use cullet_draw::{ImpostorOptions, impostor_cards, make_impostor};
use cullet_scenes::knobbly_ball;

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, grouped, other, scene_of};

/// From near the mesh is drawn, from afar the box of the impostor, and the error that was measured is below a pixel there.
pub(super) fn impostor(_: &Lab) -> Result<Finding, LabError> {
    let (positions, indices) = knobbly_ball(16);
    let ball = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).map_err(other)?;
    let options = ImpostorOptions { grid: 6, directions: 24, ..ImpostorOptions::default() };
    let (made, found) = make_impostor(&ball, &options).map_err(other)?;
    let cards = impostor_cards(&made, "ball", &[[200; 3]]);
    let triangles = u64::from(ball.triangle_count());
    let radius = f64::from(made.radius());
    let error = f64::from(made.error());
    let mut scene = scene_of(ball)?;
    scene.add_impostor(0, made).map_err(other)?;
    let culler = Culler { lod: Some(Lod::default()), ..Culler::exact() }.only(Stage::Lod);
    let mut drawn = Vec::new();
    for distance in [3.0 * radius, 100.0 * radius] {
        let eye = [0.0, 0.0, distance];
        let view = View::perspective(eye, [0.0; 3], 1.0, 0.1, f64::INFINITY, SIZE)?;
        let visible = cull(&culler, &scene, &view);
        let pixels = PixelScale::of(&view, false).pixels * error / (distance - radius);
        drawn.push((visible.triangle_count, pixels));
    }
    let [(near, too_many), (far, few)] = drawn[..] else {
        return Err(other("two distances"));
    };
    Ok(Finding::if_so(
        near == triangles
            && far == 12
            && too_many > 1.0
            && few <= 1.0
            && found.p999 <= error
            && !cards.gltf.is_empty(),
        format!(
            "of a ball of {} triangles {} are drawn from 3 radii, where its impostor would be off by {too_many:.1} pixels, and the {far} \
             of a box with the pictures on it from 100, where it is off by {few:.2}; as measured on {} samples",
            grouped(triangles),
            grouped(near),
            grouped(found.samples)
        ),
    ))
}
