//! A baked file drawn by a small renderer of its own: in each frame the engine chooses levels and clusters, and one mesh
//! for each material is made anew of the triangles that are left.
//!
//! `cullet bake city -o city.glb`, then `cargo run --release --example baked -- city.glb` opens a window; the arrows walk.
//! With `check` after the file it draws eight views without a window, whole and by the engine, and prints how many
//! triangles that takes and how many pixels differ.

#[path = "../tests/common/picture.rs"]
mod picture;

use std::f32::consts::FRAC_PI_4;
use std::process::ExitCode;

use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy_cullet::engine::draw::{Draw, DrawState};
use bevy_cullet::engine::lod::Lod;
use bevy_cullet::engine::{Culler, Scene, View, ViewState, Visible};
use cullet_io::{LoadOptions, Model, load};

use picture::{Canvas, Studio};

const SIZE: [u32; 2] = [640, 360];

/// A model, and the state of its view.
#[derive(Resource)]
struct Drawing {
    model: Model,
    culler: Culler,
    state: ViewState,
    visible: Visible,
    /// One mesh for each material, and one for parts without.
    meshes: Vec<Handle<Mesh>>,
    triangles: usize,
}

/// Levels may be off by a pixel; nothing else is lossy.
fn by_engine() -> Culler {
    Culler::default().with_lod(Lod::default().with_pixels(1.0))
}

/// Draws everything that is in front of the camera, in full.
fn whole() -> Culler {
    Culler::default().with_occlusion(None)
}

fn open(world: &mut World, model: Model, culler: Culler) {
    let colors = model.materials.iter().map(|material| material.color);
    let colors: Vec<_> = colors.chain([[0.6, 0.6, 0.6, 1.0]]).collect();
    let mut meshes = Vec::new();
    for color in colors {
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let paint = StandardMaterial {
            base_color: LinearRgba::from_f32_array(color).into(),
            perceptual_roughness: 0.95,
            // The engine has dropped what faces away.
            cull_mode: None,
            double_sided: true,
            ..default()
        };
        let paint = world.resource_mut::<Assets<StandardMaterial>>().add(paint);
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(paint), NoFrustumCulling));
        meshes.push(mesh);
    }
    let sun = DirectionalLight { illuminance: 6000.0, ..default() };
    world.spawn((sun, Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.7), Vec3::Y)));
    let (state, visible) = (ViewState::default(), Visible::default());
    world.insert_resource(Drawing { model, culler, state, visible, meshes, triangles: 0 });
}

/// Culls for the camera, and makes the meshes of what is left.
fn draw(
    mut drawing: ResMut<Drawing>,
    camera: Single<&Transform, With<Camera3d>>,
    mut meshes: ResMut<Assets<Mesh>>,
) -> Result {
    let Drawing { model, culler, state, visible, meshes: own, triangles } = &mut *drawing;
    let eye = camera.translation.as_dvec3();
    let target = eye + camera.forward().as_dvec3();
    let fov = f64::from(FRAC_PI_4);
    let view = View::perspective(eye.to_array(), target.to_array(), fov, 0.1, f64::INFINITY, SIZE)?;
    culler.cull_one(&model.scene, &view, state, visible);
    let mut corners = vec![Vec::new(); own.len()];
    for draw in visible.draws(&model.scene)? {
        let material = (draw.material as usize).min(own.len() - 1);
        add(&model.scene, &draw, &mut corners[material]);
    }
    *triangles = corners.iter().map(Vec::len).sum::<usize>() / 3;
    for (mesh, corners) in own.iter().zip(corners) {
        if let Some(mut mesh) = meshes.get_mut(mesh) {
            *mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
                .with_computed_flat_normals();
        }
    }
    Ok(())
}

/// Adds the triangles of a draw, in world space.
fn add(scene: &Scene, draw: &Draw, corners: &mut Vec<[f32; 3]>) {
    let mesh = &scene.meshes()[draw.mesh as usize];
    let at = scene.transform(draw.slot).to_matrix().map(|x| x as f32);
    let at = Mat4::from_cols_array(&at);
    let range = draw.indices.start as usize..draw.indices.end as usize;
    for triangle in mesh.indices()[range].as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|index| {
            at.transform_point3(Vec3::from_array(mesh.positions()[index as usize])).to_array()
        });
        let is_mirrored = draw.state.has(DrawState::MIRRORED);
        corners.extend(if is_mirrored { [a, c, b] } else { [a, b, c] });
    }
}

/// Returns a place in the middle of the model at eye height, as far from one side to the other as `part` says, from 0 to 1.
fn eye(model: &Model, part: f32) -> Transform {
    let extent = model.scene.extent();
    let [min, max] = [extent.min, extent.max].map(Vec3::from_array);
    let middle = (min + max) * 0.5;
    let at = Vec3::new(middle.x + 0.7, min.y + 1.7, max.z + (min.z - max.z) * part);
    Transform::from_translation(at).looking_to(Vec3::new(-0.02, 0.01, -1.0), Vec3::Y)
}

fn check(file: &str) -> std::result::Result<(), Box<dyn std::error::Error>> {
    println!("| view | triangles, in the frustum | by the engine | pixels that differ |");
    println!("|---|---|---|---|");
    let mut studios = Vec::new();
    for culler in [whole(), by_engine()] {
        let model = load(file.as_ref(), &LoadOptions::default())?;
        let mut studio = Studio::new(SIZE, |app| {
            app.add_systems(Update, draw);
            let target = app.world().resource::<Canvas>().0.clone();
            let camera = (RenderTarget::Image(target.into()), Msaa::Off, Tonemapping::Reinhard);
            app.world_mut().spawn((Camera3d::default(), camera, eye(&model, 0.1)));
            open(app.world_mut(), model, culler);
        });
        studio.settle();
        studios.push(studio);
    }
    for view in 0..8 {
        let drawn: Vec<_> = studios
            .iter_mut()
            .map(|studio| {
                let at = eye(&studio.world().resource::<Drawing>().model, 0.1 + view as f32 / 32.0);
                let mut cameras = studio.world().query_filtered::<&mut Transform, With<Camera3d>>();
                cameras.iter_mut(studio.world()).for_each(|mut camera| *camera = at);
                studio.frame();
                (studio.shoot(), studio.world().resource::<Drawing>().triangles)
            })
            .collect();
        let differing = drawn[0].0.differing(&drawn[1].0);
        println!("| {view} | {} | {} | {differing} |", drawn[0].1, drawn[1].1);
        if let Some(folder) = std::env::args().nth(3) {
            drawn[1].0.save(&std::path::Path::new(&folder).join(format!("baked-{view}.png")));
        }
    }
    Ok(())
}

fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    drawing: Res<Drawing>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
    mut window: Single<&mut Window>,
) {
    let axis = |more, less| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    camera.rotate_y(axis(KeyCode::ArrowLeft, KeyCode::ArrowRight) * time.delta_secs());
    let ahead = camera.forward() * axis(KeyCode::ArrowUp, KeyCode::ArrowDown);
    camera.translation += ahead * 15.0 * time.delta_secs();
    let all = drawing.model.scene.triangle_count();
    window.title = format!("{} of {all} triangles", drawing.triangles);
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let (file, is_check) = match args[..] {
        [file] => (file, false),
        [file, "check"] | [file, "check", _] => (file, true),
        _ => {
            eprintln!("baked FILE [check [FOLDER]]: a file of cullet bake, such as city.glb");
            return ExitCode::from(2);
        }
    };
    let done = if is_check {
        check(file)
    } else {
        load(file.as_ref(), &LoadOptions::default()).map_err(Into::into).map(|model| {
            let mut app = App::new();
            app.add_plugins(DefaultPlugins).add_systems(Update, (walk, draw).chain());
            app.world_mut().spawn((Camera3d::default(), eye(&model, 0.1)));
            open(app.world_mut(), model, by_engine());
            app.run();
        })
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(3)
        }
    }
}
