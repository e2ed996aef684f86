//! Instances of bounds alone, and meshes in the caller's order.

use cullet::bounds::Aabb;
use cullet::mesh::{Clustering, MAX_CLUSTER_TRIANGLES, Part};
use cullet::{
    Culler, DrawList, Handle, Instance, Mesh, MeshData, Output, Scene, SceneError, Stage,
    Transform, View, ViewState, Visible, scene::BoundsOverride,
};
use cullet_testkit::answers::{cull, listed};
use cullet_testkit::oracles::visible::visible_ref;
use cullet_testkit::views::random_view;
use cullet_testkit::{Rng, meshes};

fn random_box(rng: &mut Rng) -> Aabb {
    let at = rng.vector(30.0).map(|v| v as f32);
    let half = rng.vector(2.0).map(|v| v.abs() as f32);
    let corner = |side: f32| std::array::from_fn(|a| at[a] + half[a] * side);
    Aabb::new(corner(-1.0), corner(1.0))
}

/// The culler says the same of boxes as of instances with a mesh and these boxes as their bounds.
#[test]
fn boxes_are_culled_as_meshes_in_them_are() {
    let mut rng = Rng(5);
    let (mut kept, mut all) = (0, 0);
    for round in 0..60 {
        let output = [Output::Instances, Output::Clusters, Output::Triangles][round % 3];
        let boxes: Vec<Aabb> = (0..400).map(|_| random_box(&mut rng)).collect();
        let (mut alone, mut with_mesh) = (Scene::new(), Scene::new());
        let mesh = with_mesh.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
        for &b in &boxes {
            alone.add(Instance::of_bounds(b)).unwrap();
            let bounds = BoundsOverride::World(b);
            with_mesh.add(Instance { bounds, ..Instance::new(mesh, Transform::IDENTITY) }).unwrap();
        }
        // Some lie under no node.
        if round % 4 != 0 {
            alone.commit(&Culler::default());
            with_mesh.commit(&Culler::default());
        }
        let view = random_view(&mut rng);
        let culler = Culler::default().with_output(output).with_reasons(true);
        let (found, expected) = (cull(&culler, &alone, &view), cull(&culler, &with_mesh, &view));
        let slots: Vec<u32> = found.slots().collect();
        assert_eq!(slots, expected.slots().collect::<Vec<_>>(), "round {round}");
        assert_eq!(found.instance_count, slots.len() as u64);
        assert_eq!(found.triangle_count, 0);
        assert_eq!(found.reasons, expected.reasons);
        assert!(found.draws(&alone).unwrap().is_empty());
        let mut list = DrawList::default();
        list.fill(&alone, &found, &[]).unwrap();
        assert!(list.commands.is_empty());
        (kept, all) = (kept + slots.len(), all + boxes.len());
    }
    assert!(kept * 20 > all && kept * 3 < all, "{kept} of {all}");
}

#[test]
fn a_box_behind_a_wall_is_hidden_and_hides_nothing() {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
    let wall = Transform::from_scale_translation([20.0, 20.0, 0.1], [0.0, 0.0, -10.0]);
    scene.add(Instance::new(cube, wall)).unwrap();
    let at = |z: f32| Instance::of_bounds(Aabb::new([-1.0, -1.0, z - 1.0], [1.0, 1.0, z + 1.0]));
    let [before, behind] = [-5.0, -20.0].map(|z| scene.add(at(z)).unwrap());
    scene.commit(&Culler::default());
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, [640, 480]).unwrap();
    let culler = Culler::exact().with_reasons(true);
    let visible = cull(&culler, &scene, &view);
    let reason =
        |handle: Handle| visible.reasons[scene.slot(handle).unwrap() as usize].map(|r| r.stage);
    assert_eq!((reason(before), reason(behind)), (None, Some(Stage::Occlusion)));
    assert_eq!(visible.instance_count, 2);
}

#[test]
fn bounds_that_say_nothing_are_kept() {
    let mut scene = Scene::new();
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    let odd = [
        Aabb::EMPTY,
        Aabb::EVERYTHING,
        Aabb::new([nan, 0.0, 0.0], [1.0; 3]),
        Aabb::new([0.0; 3], [inf, 1.0, 1.0]),
        Aabb::new([1.0; 3], [0.0; 3]),
    ];
    for b in odd {
        scene.add(Instance::of_bounds(b)).unwrap();
    }
    let behind = Aabb::new([-1.0, -1.0, 5.0], [1.0, 1.0, 6.0]);
    let mover = scene.add(Instance::of_bounds(behind)).unwrap();
    scene.commit(&Culler::default());
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, [640, 480]).unwrap();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let culler = Culler::default();
    culler.cull_one(&scene, &view, &mut state, &mut visible);
    assert_eq!(visible.instance_count, odd.len() as u64);
    let ahead = Aabb::new([-1.0, -1.0, -6.0], [1.0, 1.0, -5.0]);
    scene.set_bounds(mover, BoundsOverride::World(ahead)).unwrap();
    culler.cull_one(&scene, &view, &mut state, &mut visible);
    assert_eq!(visible.instance_count, odd.len() as u64 + 1);
    assert_eq!(scene.meshes().len(), 1, "all share one mesh");
    let beyond = scene.add(Instance::new(7, Transform::IDENTITY));
    assert_eq!(beyond, Err(SceneError::NoMesh { mesh: 7, meshes: 1 }));
}

/// A mesh that keeps its order has the indices that it was given, and every triangle in a cluster within the limits.
#[test]
fn a_mesh_in_order_keeps_its_indices() {
    let mut rng = Rng(8);
    for round in 0..40 {
        let vertices = [3, 40, 300][round % 3];
        let positions: Vec<[f32; 3]> =
            (0..vertices).map(|_| rng.vector(5.0).map(|v| v as f32)).collect();
        let triangles = rng.below(900) as u32;
        // Some repeat a vertex, and so are degenerate.
        let index = |rng: &mut Rng| rng.below(vertices as u64) as u32;
        let indices: Vec<u32> = (0..triangles * 3).map(|_| index(&mut rng)).collect();
        let cut = if triangles == 0 { 0 } else { rng.below(u64::from(triangles)) as u32 };
        let part = |first_triangle, triangle_count| Part {
            first_triangle,
            triangle_count,
            ..Part::default()
        };
        let parts = match round % 2 {
            0 => Vec::new(),
            _ => vec![part(0, cut), part(cut, triangles - cut)],
        };
        let data = MeshData { positions, indices, parts, ..MeshData::default() };
        let clustering = Clustering::in_order(&data).unwrap();
        let given = data.indices.clone();
        let mesh = Mesh::with_clusters(data, &clustering).unwrap();
        assert_eq!(mesh.indices(), given);
        assert_eq!(mesh.degenerate_count(), 0);
        let count: u32 = mesh.clusters().iter().map(|c| c.triangle_count).sum();
        assert_eq!(count, triangles);
        // Of three vertices alone, and so of any few, clusters are as long as they may be.
        if vertices == 3 && round % 2 == 0 {
            let fewest = (triangles as usize).div_ceil(MAX_CLUSTER_TRIANGLES);
            assert_eq!(mesh.clusters().len(), fewest);
        }
    }
    let wrong = MeshData { positions: Vec::new(), indices: vec![0, 1, 2], ..MeshData::default() };
    assert!(Clustering::in_order(&wrong).is_err());
}

/// Nothing visible is lost of meshes in order, degenerate triangles among them.
#[test]
fn meshes_in_order_lose_nothing_visible() {
    let mut rng = Rng(9);
    let (mut needed, mut kept, mut all) = (0, 0, 0);
    for round in 0..60 {
        let mut scene = Scene::new();
        let (positions, mut indices) = cullet_testkit::soups::ball(8, 12);
        let at = rng.below(indices.len() as u64 / 3) as usize * 3;
        indices.splice(at..at, [0, 0, 1, 3, 3, 3]);
        let parts = vec![Part { triangle_count: indices.len() as u32 / 3, ..Part::default() }];
        let data = MeshData { positions, indices, parts, ..MeshData::default() };
        let clustering = Clustering::in_order(&data).unwrap();
        let mesh = scene.add_mesh(Mesh::with_clusters(data, &clustering).unwrap());
        for _ in 0..12 {
            let place = Transform::from_scale_translation([2.0, 1.0, 1.5], rng.vector(15.0));
            scene.add(Instance::new(mesh, place)).unwrap();
        }
        scene.commit(&Culler::default());
        let view = random_view(&mut rng);
        let culler = Culler::exact().with_output(Output::Triangles);
        let listed = listed(&cull(&culler, &scene, &view));
        for seen in visible_ref(&scene, &view) {
            assert!(listed.contains(&seen), "round {round}: {seen:?}");
            needed += 1;
        }
        (kept, all) = (kept + listed.len() as u64, all + scene.triangle_count());
    }
    assert!(needed > 500 && kept * 2 < all, "{needed} seen, {kept} kept of {all}");
}
