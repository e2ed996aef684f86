//! Tests that entities behind others, and only those, are not listed.
mod common;

use bevy::camera::RenderTargetInfo;
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_cullet::{
    CulletCandidates, CulletExplain, CulletOccluder, CulletOcclusion, CulletPrepare, CulletReason,
    CulletScene, CulletView,
};
use common::{Headless, cube};

fn app() -> (Headless, Entity) {
    let mut app = Headless::with_plugin();
    app.app.insert_resource(CulletPrepare::AtOnce);
    let camera = app.world().spawn((Camera3d::default(), CulletOcclusion::default())).id();
    size(&mut app, camera, true);
    (app, camera)
}

/// Tells a camera the size of its target, as Bevy's renderer would, which is not here.
fn size(app: &mut Headless, camera: Entity, is_known: bool) {
    let mut camera = app.world().get_mut::<Camera>(camera).unwrap();
    let physical_size = UVec2::new(640, 640);
    camera.computed.target_info =
        is_known.then_some(RenderTargetInfo { physical_size, scale_factor: 1.0 });
    camera.computed.clip_from_view = Projection::default().get_clip_from_view();
}

fn wall(app: &mut Headless, at: Vec3, size: Vec3) -> (Entity, Handle<Mesh>) {
    let mesh = app.world().resource_mut::<Assets<Mesh>>().add(Cuboid::from_size(size));
    let wall = (Mesh3d(mesh.clone()), CulletOccluder::default(), Transform::from_translation(at));
    (app.world().spawn(wall).id(), mesh)
}

fn why(app: &mut Headless, camera: Entity, entity: Entity) -> CulletReason {
    let ask = move |explain: CulletExplain| explain.why(camera, entity);
    app.world().run_system_once(ask).unwrap()
}

#[test]
fn a_wall_hides_what_is_behind_it_and_says_so() {
    let (mut app, camera) = app();
    let (wall, mesh) = wall(&mut app, Vec3::new(0.0, 0.0, -5.0), Vec3::new(2.0, 2.0, 0.2));
    let behind = cube(&mut app, [0.0, 0.0, -20.0]);
    let beside = cube(&mut app, [6.0, 6.0, -20.0]);
    let outside = cube(&mut app, [0.0, 0.0, 0.8]);
    app.frames(4);
    let mut expected = vec![wall, beside];
    expected.sort_unstable();
    assert_eq!(app.seen(camera), expected);
    let funnel = app.world().get::<CulletView>(camera).unwrap().funnel;
    assert_eq!((funnel.entities, funnel.in_frustum, funnel.in_range, funnel.visible), (4, 3, 3, 2));
    let why = |app: &mut Headless, entity| why(app, camera, entity);
    assert_eq!(why(&mut app, behind), CulletReason::Occluded(vec![wall]));
    assert_eq!(why(&mut app, beside), CulletReason::Visible);
    assert_eq!(why(&mut app, outside), CulletReason::Frustum("near"));

    // The mesh is changed behind the plugin's back: what it hid is seen.
    *app.world().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
        Cuboid::from_size(Vec3::new(0.1, 0.1, 0.1)).into();
    app.frames(1);
    assert!(app.seen(camera).contains(&behind));

    // And back again.
    *app.world().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
        Cuboid::from_size(Vec3::new(2.0, 2.0, 0.2)).into();
    app.frames(3);
    assert!(!app.seen(camera).contains(&behind));
    app.world().entity_mut(wall).remove::<CulletOccluder>();
    app.frames(1);
    assert!(app.seen(camera).contains(&behind));
}

#[test]
fn occluders_move_with_their_entities() {
    let (mut app, camera) = app();
    let (wall, _) = wall(&mut app, Vec3::new(0.0, 0.0, -5.0), Vec3::new(4.0, 4.0, 0.2));
    let behind = cube(&mut app, [0.0, 0.0, -20.0]);
    app.frames(4);
    assert!(!app.seen(camera).contains(&behind));
    app.world().get_mut::<Transform>(wall).unwrap().translation.x = 10.0;
    app.frames(1);
    assert!(app.seen(camera).contains(&behind));
}

#[test]
fn a_camera_without_a_size_hides_nothing() {
    let (mut app, camera) = app();
    size(&mut app, camera, false);
    wall(&mut app, Vec3::new(0.0, 0.0, -5.0), Vec3::new(4.0, 4.0, 0.2));
    let behind = cube(&mut app, [0.0, 0.0, -20.0]);
    app.frames(4);
    assert!(app.seen(camera).contains(&behind));
}

#[test]
fn what_the_app_leaves_out_is_not_listed_and_hides_nothing() {
    let (mut app, camera) = app();
    let (wall, _) = wall(&mut app, Vec3::new(0.0, 0.0, -5.0), Vec3::new(2.0, 2.0, 0.2));
    let behind = cube(&mut app, [0.0, 0.0, -20.0]);
    let beside = cube(&mut app, [6.0, 6.0, -20.0]);
    app.world().entity_mut(camera).insert(CulletCandidates::default());
    app.frames(4);
    let sorted = |mut entities: Vec<Entity>| {
        entities.sort_unstable();
        entities
    };
    assert_eq!(app.seen(camera), sorted(vec![wall, beside]));
    assert_eq!(why(&mut app, camera, behind), CulletReason::Occluded(vec![wall]));
    let change = |app: &mut Headless, change: &dyn Fn(&mut CulletCandidates)| {
        change(&mut app.world().get_mut::<CulletCandidates>(camera).unwrap());
        app.frames(1);
    };

    change(&mut app, &|candidates| candidates.extend([wall, beside]));
    assert_eq!(app.seen(camera), [behind], "in the next frame, and the wall hides nothing");
    assert_eq!(why(&mut app, camera, wall), CulletReason::LeftOut);
    assert_eq!(why(&mut app, camera, behind), CulletReason::Visible);
    let funnel = app.world().get::<CulletView>(camera).unwrap().funnel;
    assert_eq!((funnel.entities, funnel.in_frustum, funnel.in_range, funnel.visible), (3, 3, 1, 1));
    assert!(!app.world().get::<ViewVisibility>(wall).unwrap().get());
    app.frames(3);
    assert_eq!(app.seen(camera), [behind], "as long as it is not changed");

    // One that stays listed whatever is before it would hide as well, so nothing does.
    app.world().entity_mut(wall).insert(bevy_cullet::NoCulletOcclusion);
    app.frames(2);
    assert_eq!(app.seen(camera), [behind]);
    app.world().entity_mut(wall).remove::<bevy_cullet::NoCulletOcclusion>();

    change(&mut app, &|candidates| candidates.put_back(wall));
    assert_eq!(app.seen(camera), [wall]);

    // Another camera has candidates of its own.
    let second = app.camera();
    app.frames(2);
    assert_eq!(app.seen(second), sorted(vec![wall, behind, beside]));

    change(&mut app, &|candidates| candidates.clear());
    assert_eq!(app.seen(camera), sorted(vec![wall, beside]));
    change(&mut app, &|candidates| candidates.leave_out(beside));
    app.world().entity_mut(camera).remove::<CulletCandidates>();
    app.frames(1);
    assert_eq!(app.seen(camera), sorted(vec![wall, beside]));
}

#[test]
fn a_mesh_that_changes_in_each_frame_leaves_nothing_behind() {
    let (mut app, camera) = app();
    let (_, mesh) = wall(&mut app, Vec3::new(0.0, 0.0, -5.0), Vec3::new(2.0, 2.0, 0.2));
    let behind = cube(&mut app, [0.0, 0.0, -20.0]);
    // Both sides of the same mesh, where it hides nothing.
    let sides = (Mesh3d(mesh.clone()), CulletOccluder { double_sided: true });
    app.world().spawn((sides, Transform::from_xyz(0.0, 0.0, 9.0)));
    app.frames(4);
    let held = |app: &mut Headless| {
        let scene = app.world().resource::<CulletScene>().scene();
        let triangles: u32 = scene.meshes().iter().map(|mesh| mesh.triangle_count()).sum();
        [scene.meshes().len() as u32, triangles, scene.instance_count()]
    };
    let before = held(&mut app);
    let mut most = 0;
    for round in 0..1000 {
        let size = if round % 2 == 0 { Vec3::splat(0.1) } else { Vec3::new(2.0, 2.0, 0.2) };
        *app.world().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
            Cuboid::from_size(size).into();
        app.frames(1);
        most = most.max(app.world().resource::<CulletScene>().scene().slot_count());
        // The box of an entity follows its mesh a frame later.
        if round % 97 == 0 {
            app.frames(2);
            assert_eq!(app.seen(camera).contains(&behind), round % 2 == 0, "{round}");
        }
    }
    app.frames(2);
    assert_eq!(held(&mut app), before);
    assert!(most < 200, "{most}");
    // What is left without it is the triangle that all others share.
    app.world().resource_mut::<Assets<Mesh>>().remove(&mesh);
    app.frames(2);
    assert_eq!(held(&mut app)[1], 1);
}

#[test]
fn both_sides_of_a_mesh_follow_it() {
    let (mut app, camera) = app();
    let size = Vec3::new(1.5, 1.5, 0.2);
    let (_, mesh) = wall(&mut app, Vec3::new(-1.0, 0.0, -5.0), size);
    let sides = (Mesh3d(mesh.clone()), CulletOccluder { double_sided: true });
    app.world().spawn((sides, Transform::from_xyz(1.0, 0.0, -5.0)));
    let behind = [-4.0, 4.0].map(|x| cube(&mut app, [x, 0.0, -20.0]));
    let hidden = |app: &mut Headless| behind.map(|cube| !app.seen(camera).contains(&cube));
    app.frames(4);
    assert_eq!(hidden(&mut app), [true; 2]);
    *app.world().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
        Cuboid::from_size(Vec3::splat(0.1)).into();
    app.frames(3);
    assert_eq!(hidden(&mut app), [false; 2]);
}
