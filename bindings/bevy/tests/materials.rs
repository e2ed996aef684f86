//! Causes that keep a wall from hiding what is behind it, one by one: set at first, and set later.
mod common;

use bevy::camera::RenderTargetInfo;
use bevy::camera::visibility::{RenderLayers, VisibilityRange};
use bevy::core_pipeline::prepass::DeferredPrepass;
use bevy::material::OpaqueRendererMethod;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::pbr::DefaultOpaqueRendererMethod;
use bevy::prelude::*;
use bevy::render::render_resource::Face;
use bevy_cullet::{
    CulletOcclusion, CulletPrepare, CulletScene, NoCulletOccluder, NoCulletOcclusion,
};
use common::Headless;

/// A wall, and a cube behind it.
struct Stage {
    app: Headless,
    camera: Entity,
    wall: Entity,
    mesh: Handle<Mesh>,
    paint: Handle<StandardMaterial>,
    cube: Entity,
    of_cube: Handle<StandardMaterial>,
}

impl Stage {
    fn new() -> Self {
        let mut app = Headless::with_plugin();
        app.app.init_asset::<StandardMaterial>().insert_resource(CulletPrepare::AtOnce);
        let camera = app.world().spawn((Camera3d::default(), CulletOcclusion::default())).id();
        let mut of_camera = app.world().get_mut::<Camera>(camera).unwrap();
        let physical_size = UVec2::new(640, 640);
        let info = RenderTargetInfo { physical_size, scale_factor: 1.0 };
        of_camera.computed.target_info = Some(info);
        of_camera.computed.clip_from_view = Projection::default().get_clip_from_view();
        let mut add = |size: Vec3, z: f32| {
            let mesh = app.world().resource_mut::<Assets<Mesh>>().add(Cuboid::from_size(size));
            let mut paints = app.world().resource_mut::<Assets<StandardMaterial>>();
            let paint = paints.add(StandardMaterial::default());
            let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(paint.clone()));
            (app.world().spawn((parts, Transform::from_xyz(0.0, 0.0, z))).id(), mesh, paint)
        };
        let (wall, mesh, paint) = add(Vec3::new(4.0, 4.0, 0.2), -5.0);
        let (cube, _, of_cube) = add(Vec3::ONE, -20.0);
        Self { app, camera, wall, mesh, paint, cube, of_cube }
    }

    fn hides(&self) -> bool {
        !self.app.seen(self.camera).contains(&self.cube)
    }

    fn paint(&mut self, change: impl FnOnce(&mut StandardMaterial)) {
        let paint = self.paint.clone();
        let mut paints = self.app.world().resource_mut::<Assets<StandardMaterial>>();
        change(&mut paints.get_mut(&paint).unwrap());
    }

    fn put(&mut self, parts: impl Bundle) {
        let wall = self.wall;
        self.app.world().entity_mut(wall).insert(parts);
    }
}

type Change = fn(&mut Stage);

/// Whether the wall hides with the change made before the first frame, and after some.
fn both(change: Change) -> [bool; 2] {
    let mut early = Stage::new();
    change(&mut early);
    early.app.frames(4);
    let mut late = Stage::new();
    late.app.frames(4);
    assert!(late.hides(), "an opaque wall hides");
    change(&mut late);
    late.app.frames(1);
    [early.hides(), late.hides()]
}

#[test]
fn what_writes_no_opaque_depth_hides_nothing() {
    let changes: &[(&str, Change)] = &[
        ("blend", |s| s.paint(|m| m.alpha_mode = AlphaMode::Blend)),
        ("premultiplied", |s| s.paint(|m| m.alpha_mode = AlphaMode::Premultiplied)),
        ("add", |s| s.paint(|m| m.alpha_mode = AlphaMode::Add)),
        ("multiply", |s| s.paint(|m| m.alpha_mode = AlphaMode::Multiply)),
        ("mask", |s| s.paint(|m| m.alpha_mode = AlphaMode::Mask(0.5))),
        ("alpha to coverage", |s| s.paint(|m| m.alpha_mode = AlphaMode::AlphaToCoverage)),
        ("specular transmission", |s| s.paint(|m| m.specular_transmission = 0.1)),
        ("diffuse transmission", |s| s.paint(|m| m.diffuse_transmission = 0.1)),
        ("depth bias", |s| s.paint(|m| m.depth_bias = -1.0)),
        ("front faces culled", |s| s.paint(|m| m.cull_mode = Some(Face::Front))),
        ("deferred without its prepass", |s| {
            s.paint(|m| m.opaque_render_method = OpaqueRendererMethod::Deferred);
        }),
        ("deferred by default", |s| {
            s.app.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
        }),
        ("deferred by default, once", |s| {
            s.app.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
            s.app.frames(1);
            s.app.world().insert_resource(DefaultOpaqueRendererMethod::forward());
        }),
        ("a second camera without the prepass", |s| {
            s.paint(|m| m.opaque_render_method = OpaqueRendererMethod::Deferred);
            let camera = s.camera;
            s.app.world().entity_mut(camera).insert(DeferredPrepass);
            s.app.world().spawn((Camera3d::default(), CulletOcclusion::default()));
        }),
        ("a texture that is not there", |s| {
            let image = s.app.world().resource::<Assets<Image>>().reserve_handle();
            s.paint(|m| m.normal_map_texture = Some(image));
        }),
        ("a depth map that is not there", |s| {
            let image = s.app.world().resource::<Assets<Image>>().reserve_handle();
            s.paint(|m| m.depth_map = Some(image));
        }),
        ("a texture that goes", |s| {
            let image = s.app.world().resource_mut::<Assets<Image>>().add(Image::default());
            let id = image.id();
            s.paint(|m| m.base_color_texture = Some(image));
            s.app.frames(2);
            s.app.world().resource_mut::<Assets<Image>>().remove(id);
        }),
        ("a material that goes", |s| {
            let id = s.paint.id();
            s.app.world().resource_mut::<Assets<StandardMaterial>>().remove(id);
        }),
        ("another kind of material", |s| {
            let wall = s.wall;
            s.app.world().entity_mut(wall).remove::<MeshMaterial3d<StandardMaterial>>();
        }),
        ("another material", |s| {
            let glass = StandardMaterial { alpha_mode: AlphaMode::Blend, ..default() };
            let glass = s.app.world().resource_mut::<Assets<StandardMaterial>>().add(glass);
            s.put(MeshMaterial3d(glass));
        }),
        ("a layer that the camera does not see", |s| s.put(RenderLayers::layer(1))),
        ("a layer beyond the engine's", |s| s.put(RenderLayers::from_layers(&[0, 40]))),
        ("a camera that sees other layers", |s| {
            let (camera, cube) = (s.camera, s.cube);
            s.app.world().entity_mut(camera).insert(RenderLayers::layer(2));
            s.app.world().entity_mut(cube).insert(RenderLayers::layer(2));
        }),
        ("hidden", |s| s.put(Visibility::Hidden)),
        ("a skin", |s| s.put(SkinnedMesh::default())),
        ("a range", |s| s.put(VisibilityRange::abrupt(0.0, 100.0))),
        ("mirrored", |s| {
            s.put(Transform::from_xyz(0.0, 0.0, -5.0).with_scale(Vec3::new(-1.0, 1.0, 1.0)));
        }),
        ("asked not to", |s| s.put(NoCulletOccluder)),
        ("joints without a skin", |s| {
            let mesh = s.mesh.clone();
            let mut meshes = s.app.world().resource_mut::<Assets<Mesh>>();
            let mut mesh = meshes.get_mut(&mesh).unwrap();
            let joints = VertexAttributeValues::Uint16x4(vec![[0; 4]; mesh.count_vertices()]);
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
        }),
        ("an attribute too short", |s| {
            let mesh = s.mesh.clone();
            let mut meshes = s.app.world().resource_mut::<Assets<Mesh>>();
            let mut mesh = meshes.get_mut(&mesh).unwrap();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, vec![[0.0_f32; 2]; 3]);
        }),
        ("a camera that turns faces over", |s| {
            let camera = s.camera;
            s.app.world().get_mut::<Camera>(camera).unwrap().invert_culling = true;
        }),
        ("gone", |s| {
            let wall = s.wall;
            s.app.world().despawn(wall);
        }),
        ("a cube that is never hidden", |s| {
            let cube = s.cube;
            s.app.world().entity_mut(cube).insert(NoCulletOcclusion);
        }),
        ("a cube drawn nearer than it is", |s| {
            let paint = s.of_cube.clone();
            let mut paints = s.app.world().resource_mut::<Assets<StandardMaterial>>();
            paints.get_mut(&paint).unwrap().depth_bias = 1e7;
        }),
    ];
    for (name, change) in changes {
        assert_eq!(both(*change), [false; 2], "{name}");
    }
}

#[test]
fn what_changes_colours_alone_hides_as_before() {
    let changes: &[(&str, Change)] = &[
        ("nothing", |_| {}),
        ("colour", |s| s.paint(|m| m.base_color = Color::srgba(1.0, 0.0, 0.0, 0.1))),
        ("unlit", |s| s.paint(|m| m.unlit = true)),
        ("both sides", |s| s.paint(|m| m.cull_mode = None)),
        ("clear coat", |s| s.paint(|m| m.clearcoat = 1.0)),
        ("a texture", |s| {
            let image = s.app.world().resource_mut::<Assets<Image>>().add(Image::default());
            s.paint(|m| m.base_color_texture = Some(image));
        }),
        ("forward where deferred is the default", |s| {
            s.app.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
            s.paint(|m| m.opaque_render_method = OpaqueRendererMethod::Forward);
        }),
        ("deferred with its prepass", |s| {
            s.paint(|m| m.opaque_render_method = OpaqueRendererMethod::Deferred);
            let camera = s.camera;
            s.app.world().entity_mut(camera).insert(DeferredPrepass);
        }),
    ];
    for (name, change) in changes {
        let mut stage = Stage::new();
        change(&mut stage);
        stage.app.frames(4);
        assert!(stage.hides(), "{name}");
    }
}

#[test]
fn a_wall_hides_once_its_texture_has_come() {
    let mut s = Stage::new();
    let image = s.app.world().resource::<Assets<Image>>().reserve_handle();
    let id = image.id();
    s.paint(|m| m.base_color_texture = Some(image));
    s.app.frames(4);
    assert!(!s.hides());
    s.app.world().resource_mut::<Assets<Image>>().insert(id, Image::default()).unwrap();
    s.app.frames(3);
    assert!(s.hides());
}

#[test]
fn meshes_that_change_or_go_leave_nothing_behind() {
    let mut s = Stage::new();
    // The same mesh once more, drawn from both sides, which is another one to the engine.
    let both = StandardMaterial { cull_mode: None, ..default() };
    let both = s.app.world().resource_mut::<Assets<StandardMaterial>>().add(both);
    let at = Transform::from_xyz(0.0, 0.0, -8.0);
    let second = (Mesh3d(s.mesh.clone()), MeshMaterial3d(both), at);
    let second = s.app.world().spawn(second).id();
    s.app.frames(4);
    assert!(s.hides());
    let count = |s: &Stage| s.app.app.world().resource::<CulletScene>().scene().meshes().len();
    let before = count(&s);
    let mesh = s.mesh.clone();
    let change = |s: &mut Stage, size: Vec3| {
        let mut meshes = s.app.world().resource_mut::<Assets<Mesh>>();
        *meshes.get_mut(&mesh).unwrap() = Cuboid::from_size(size).into();
    };
    for round in 0..100 {
        let is_small = round % 3 == 0;
        change(&mut s, if is_small { Vec3::splat(0.01) } else { Vec3::new(5.0, 5.0, 0.2) });
        s.app.frames(1);
        assert!(!s.hides() || !is_small, "{round}: what it hid may be seen at once");
        s.app.frames(2);
        assert_eq!(s.hides(), !is_small, "{round}");
        assert!(count(&s) <= before, "{round}: {} meshes, {before} before", count(&s));
    }
    let (wall, id) = (s.wall, mesh.id());
    s.app.world().despawn(wall);
    s.app.world().despawn(second);
    s.app.world().resource_mut::<Assets<Mesh>>().remove(id);
    s.app.frames(3);
    let scene = s.app.app.world().resource::<CulletScene>().scene();
    let drawn = scene.meshes().iter().filter(|mesh| mesh.triangle_count() > 0).count();
    // The triangle that boxes share, and the cube.
    assert!(drawn <= 2, "{drawn}");
}
