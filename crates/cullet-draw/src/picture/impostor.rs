//! A mesh beside its impostor.

use cullet::lod::Lod;
use cullet::{
    Camera, Culler, Depth, Instance, Mesh, Output, Projection, Scene, Stage, Transform, View,
    ViewState, Visible,
};
use cullet_mesh::{Impostor, ImpostorError};
use glam::DVec3;

use super::Picture;
use super::font::{text_height, text_size};
use super::levels::difference;
use super::palette::{INK, PAPER};
use super::shaded::{shaded, shaded_levels};
use crate::frame::{RenderOptions, Selection};
use crate::render::render;

/// Radii in pixels, one a row, and how many pixels of the picture show one of the view.
const ROWS: [(f64, u32); 4] = [(72.0, 1), (36.0, 2), (12.0, 5), (6.0, 10)];
/// Pixels along a side of a tile.
const TILE: u32 = 160;
/// Between tiles.
const GAP: u32 = 6;
/// From where: between frames of the usual grid, from the front above and from behind below.
const SIDES: [DVec3; 2] = [DVec3::new(0.48, 0.31, 0.82), DVec3::new(-0.71, -0.22, -0.67)];
/// Radii from the eye to the centre.
const DISTANCE: f64 = 8.0;

/// A mesh, its impostor, and the difference, from two sides and at four sizes, small ones enlarged.
/// The colours are linear ones, by the number of the material.
///
/// # Errors
/// If the impostor is not of the mesh.
pub fn impostor_beside(
    mesh: &Mesh,
    impostor: &Impostor,
    material_colors: &[[f32; 4]],
) -> Result<Picture, ImpostorError> {
    let bounds = mesh.bounds();
    let scale = (1.0 / DVec3::from(bounds.half_extent()).length()) as f32;
    let place = bounds.center().map(|v| -v * f64::from(scale));
    let mut scene = Scene::new();
    let own = scene.add_mesh(mesh.clone());
    impostor.clone().add_to(&mut scene, own)?;
    let instance = Instance::new(own, Transform::from_scale_translation([scale; 3], place));
    let not = |_| ImpostorError::Mesh { why: "is too large or too small" };
    scene.add(instance).map_err(not)?;
    scene.commit(&Culler::default());
    let error = f64::from(impostor.error()) * f64::from(scale);
    let across = SIDES.len() as u32 * 3;
    let width = across * (TILE + GAP) - GAP;
    let size = text_size(width);
    let strip = text_height(size) as u32 + GAP * 2;
    let mut picture = Picture::new(width, ROWS.len() as u32 * (TILE + strip), PAPER);
    for (row, &(radius, zoom)) in (0..).zip(&ROWS) {
        let top = row * (TILE + strip);
        for (side, from) in (0..).zip(SIDES) {
            let Some(view) = view(from, radius, TILE / zoom) else { continue };
            let drawn =
                [false, true].map(|as_impostor| draw(&scene, &view, as_impostor, material_colors));
            let off = difference(&drawn[0], &drawn[1]);
            let tiles = drawn.iter().chain([&off]);
            for (column, tile) in (0..).zip(tiles) {
                paste(&mut picture, tile, [(side * 3 + column) * (TILE + GAP), top], zoom);
            }
        }
        let words = format!(
            "radius {radius} px: stated {:.2} px; mesh, impostor, difference",
            error * radius
        );
        picture.text([0, i64::from(top + TILE + GAP)], &words, size, INK);
    }
    Ok(picture)
}

/// A view of something of radius 1 around the origin that is so large in it.
fn view(from: DVec3, radius: f64, side: u32) -> Option<View> {
    let tangent = f64::from(side) / (2.0 * DISTANCE * radius);
    let projection = Projection::Perspective {
        fov_y_radians: 2.0 * tangent.atan(),
        aspect: 1.0,
        near: DISTANCE - 2.0,
        far: f64::INFINITY,
    };
    let eye = from.normalize() * DISTANCE;
    View::new(&Camera::look_at(eye, [0.0; 3], projection), Depth::Reversed, [side; 2]).ok()
}

fn draw(scene: &Scene, view: &View, as_impostor: bool, colors: &[[f32; 4]]) -> Picture {
    let options = RenderOptions::default();
    if !as_impostor {
        return shaded(scene, &render(scene, view, Selection::All, &options), view, colors);
    }
    // A threshold that nothing exceeds.
    let lod = Some(Lod::default().with_pixels(1e6));
    let culler = Culler::default().with_lod(lod).with_output(Output::Triangles).only(Stage::Lod);
    let mut visible = Visible::default();
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    let frame = render(scene, view, Selection::Visible(&visible), &options);
    shaded_levels(scene, &frame, view, &visible, colors)
}

fn paste(picture: &mut Picture, tile: &Picture, [left, top]: [u32; 2], zoom: u32) {
    for y in 0..tile.height * zoom {
        for x in 0..tile.width * zoom {
            let at = ((top + y) as usize * picture.width as usize + (left + x) as usize) * 3;
            picture.rgb[at..at + 3].copy_from_slice(&tile.pixel(x / zoom, y / zoom));
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet_testkit::meshes;

    use super::*;
    use crate::impostor::{ImpostorOptions, capture_impostor, make_impostor};

    #[test]
    fn the_impostor_is_much_like_the_mesh_and_another_is_refused() {
        let options = ImpostorOptions { directions: 32, ..ImpostorOptions::default() };
        let mesh = meshes::ball(20);
        let (impostor, _) = make_impostor(&mesh, &options).expect("sound");
        let picture = impostor_beside(&mesh, &impostor, &[]).expect("of this mesh");
        assert_eq!(picture.width, 6 * 166 - 6);
        // The middle of a ball is the same colour, nearly; its difference is grey.
        let (a, b, off) = (picture.pixel(80, 80), picture.pixel(246, 80), picture.pixel(412, 80));
        assert!((0..3).all(|k| a[k].abs_diff(b[k]) < 30), "{a:?} {b:?}");
        assert_ne!(off, PAPER);
        let other = capture_impostor(&meshes::block([-2.0; 3], [1.0; 3]), &options).expect("sound");
        assert!(impostor_beside(&mesh, &other, &[]).is_err());
    }
}
