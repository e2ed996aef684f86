//! Benchmark scenes as `Occscn::make` makes them.

use cullet::mesh::{Alpha, MeshData, Part};
use cullet::{Instance, InstanceFlags, Mesh, Scene, Transform};
use cullet_io::{MatrixView, Model, NodeTree};
use cullet_maps::occscn::{MakeOptions, MeshRange, Objects, Occscn};

fn written(scene: &Occscn) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write(&mut bytes).unwrap();
    bytes
}

fn city(text: &str) -> Occscn {
    let model = cullet_scenes::build(text).unwrap();
    let occluders = vec!["building".to_owned()];
    let view =
        MatrixView { name: String::new(), clip_from_world: [1.0; 16], eye: [0.0; 3], near: 0.5 };
    let options = MakeOptions { occluders, ..MakeOptions::default() };
    Occscn::make(&model, &vec![view; 32], &options).unwrap()
}

#[test]
fn the_city_has_the_published_size() {
    let scene = city("city:ground=0");
    assert_eq!(scene.triangles.len(), 120_000);
    assert_eq!((scene.meshes.len(), scene.objects.len()), (10_000, 100_000));
    let bytes = written(&scene);
    assert_eq!(bytes.len(), 7_042_592);
    assert_eq!(Occscn::parse(&bytes).unwrap(), scene);
    // Buildings of 10 to 18 m a side and 6 to 120 m height, each in the middle of a 24 m cell.
    for m in 0..scene.meshes.len() {
        let b = scene.mesh_bounds(m);
        for a in [0, 2] {
            let (side, middle) = (b.max[a] - b.min[a], (b.max[a] + b.min[a]) * 0.5);
            assert!((9.999..18.001).contains(&side), "mesh {m}: {side}");
            assert!(((middle - 12.0) / 24.0).fract().abs() < 1e-3, "mesh {m}: {middle}");
        }
        assert!(b.min[1] == 0.0 && (6.0..=120.0).contains(&b.max[1]), "mesh {m}: {b:?}");
    }
    // Small objects of 0.4 to 2 m a side and 0.3 to 2.5 m height.
    for [min, max] in &scene.objects {
        for a in [0, 2] {
            assert!((0.39..2.01).contains(&(max[a] - min[a])), "{min:?} to {max:?}");
        }
        assert!((0.299..2.51).contains(&(max[1] - min[1])), "{min:?} to {max:?}");
    }
}

#[test]
fn a_dense_city_has_ninefold_faces() {
    let scene = city("city:ground=0,sub=3,cells=10,objects=10");
    assert_eq!(scene.triangles.len(), 100 * 6 * 9 * 2);
}

/// Four instances: a wall, a pane of glass, a hedge with holes, and a wall half of which is glass.
fn model() -> Model {
    let mut scene = Scene::new();
    let quads: Vec<[f32; 3]> =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| [x, y, 0.0]).to_vec();
    let part = |first_triangle, triangle_count, alpha| Part {
        first_triangle,
        triangle_count,
        two_sided: true,
        alpha,
        ..Part::default()
    };
    let kinds = [
        vec![part(0, 2, Alpha::Opaque)],
        vec![part(0, 2, Alpha::Blended)],
        vec![part(0, 2, Alpha::Masked)],
        vec![part(0, 1, Alpha::Blended), part(1, 1, Alpha::Opaque)],
    ];
    for (i, parts) in kinds.into_iter().enumerate() {
        let data = MeshData {
            positions: quads.clone(),
            indices: vec![0, 1, 2, 0, 2, 3],
            parts,
            ..MeshData::default()
        };
        let mesh = scene.add_mesh(Mesh::new(data).unwrap());
        let at = Transform::from_translation([0.0, 0.0, i as f64]);
        scene.add(Instance::new(mesh, at)).unwrap();
    }
    scene.commit(&cullet::Culler::default());
    Model {
        scene,
        mesh_names: ["wall", "glass", "hedge", "window"].map(String::from).to_vec(),
        node_tree: NodeTree {
            // The root comes last.
            parents: vec![2, 2, u32::MAX],
            names: ["left", "right", "house"].map(String::from).to_vec(),
            node_of_instance: vec![0, 0, 1, 1],
            locals: Vec::new(),
        },
        ..Model::default()
    }
}

fn make(occluders: &[&str], objects: Objects) -> Result<Occscn, String> {
    let occluders = occluders.iter().map(|&n| n.to_owned()).collect();
    let options = MakeOptions { occluders, objects, ..MakeOptions::default() };
    Occscn::make(&model(), &[], &options).map_err(|e| e.to_string())
}

#[test]
fn only_what_is_opaque_occludes() {
    let scene = make(&[], Objects::Rest).unwrap();
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!(scene.triangles.len(), 3);
    // The opaque half of the window is its second triangle.
    let last = scene.triangles[2].map(|v| scene.vertices[v as usize]);
    assert_eq!(last, [[0.0, 0.0, 3.0], [1.0, 1.0, 3.0], [0.0, 1.0, 3.0]]);
    // Glass and hedge are tested, in boxes rounded outward.
    let places: Vec<f32> = scene.objects.iter().map(|o| o[0][2].round()).collect();
    assert_eq!(places, [1.0, 2.0]);
    assert_eq!(
        make(&["glass"], Objects::Rest).unwrap_err(),
        "occluders: none is left: what is blended or masked never occludes"
    );
}

#[test]
fn occluders_are_named_by_mesh_or_by_a_node_above() {
    let count = |names: &[&str]| {
        let scene = make(names, Objects::Rest).unwrap();
        (scene.meshes.len(), scene.objects.len())
    };
    assert_eq!(count(&["wall"]), (1, 3));
    assert_eq!(count(&["right"]), (1, 3));
    assert_eq!(count(&["house"]), (2, 2));
    assert_eq!(count(&["left", "window"]), (2, 2));
    assert!(make(&["left", "roof"], Objects::Rest).unwrap_err().contains("occluders 'roof'"));
}

#[test]
fn a_tree_with_a_loop_ends() {
    let mut model = model();
    model.node_tree.parents = vec![1, 0, u32::MAX];
    let options = MakeOptions { occluders: vec!["left".into()], ..MakeOptions::default() };
    assert_eq!(Occscn::make(&model, &[], &options).unwrap().meshes.len(), 2);
}

#[test]
fn random_boxes_are_in_the_scene_and_the_same_for_a_seed() {
    let scene = make(&[], Objects::Random(500)).unwrap();
    assert_eq!(scene.objects.len(), 500);
    let diagonal = 11f32.sqrt();
    for [min, max] in &scene.objects {
        for a in 0..3 {
            let (middle, side) = ((min[a] + max[a]) * 0.5, max[a] - min[a]);
            assert!((-1e-4..[1.0, 1.0, 3.0][a] + 1e-4).contains(&middle), "{min:?} to {max:?}");
            assert!((0.0019 * diagonal..0.0201 * diagonal).contains(&side), "{min:?} to {max:?}");
        }
    }
    assert_eq!(make(&[], Objects::Random(500)).unwrap(), scene);
    assert_ne!(scene.objects[0], scene.objects[1]);
}

#[test]
fn flags_say_what_does_not_occlude() {
    let mut model = model();
    let handle = model.scene.slots().find_map(|s| model.scene.handle(s)).unwrap();
    let flags = InstanceFlags { no_occlusion: true, ..InstanceFlags::default() };
    model.scene.set_flags(handle, flags).unwrap();
    let scene = Occscn::make(&model, &[], &MakeOptions::default()).unwrap();
    assert_eq!((scene.meshes.len(), scene.objects.len()), (1, 3));
}

#[test]
fn clusters_hold_every_triangle_once_and_few_of_them() {
    let mut scene = city("city:ground=0,cells=5,objects=1");
    let sorted = |s: &Occscn| {
        let mut triangles = s.triangles.clone();
        triangles.sort_unstable();
        triangles
    };
    let before = sorted(&scene);
    for most in [128, 7, 1, 0, u32::MAX] {
        scene.cluster(most);
        let counts = scene.meshes.iter().map(|m| m.triangle_count);
        assert!(counts.clone().all(|n| n > 0 && n <= most.max(1)), "{most}");
        // Halves: none has less than half of what is allowed, rounded down.
        assert!(counts.clone().all(|n| n >= most.min(300) / 2), "{most}");
        let mut next = 0;
        for &MeshRange { first_triangle, triangle_count } in &scene.meshes {
            assert_eq!(first_triangle, next);
            next += triangle_count;
        }
        assert_eq!(sorted(&scene), before, "{most}");
    }
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(Occscn::parse(&written(&scene)).unwrap(), scene);
    let mut empty = Occscn::default();
    empty.cluster(128);
    assert_eq!(empty, Occscn::parse(&written(&Occscn::default())).unwrap());
}

#[test]
fn a_scene_far_from_zero_is_counted_from_a_place_nearby() {
    let near = model();
    let far = [-299_510_456.0, 98_424_296.0, -975_000.0];
    let mut moved = model();
    let handles: Vec<_> = moved.scene.slots().filter_map(|s| moved.scene.handle(s)).collect();
    for handle in handles {
        let slot = moved.scene.slot(handle).unwrap();
        let at = *moved.scene.transform(slot);
        let translation = std::array::from_fn(|a| at.translation[a] + far[a]);
        moved.scene.set_transform(handle, Transform { translation, ..at }).unwrap();
    }
    moved.scene.rebase(far);
    let origin = Occscn::local_origin(&moved);
    assert!((0..3).all(|a| (origin[a] - far[a]).abs() < 10.0), "{origin:?}");
    assert_eq!(Occscn::local_origin(&near), [0.0; 3]);
    // A view that looks from (1, 2, 3) beyond the origin: clip space is the world, moved there.
    let eye: [f64; 3] = std::array::from_fn(|a| origin[a] + [1.0, 2.0, 3.0][a]);
    let mut clip_from_world = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    (0..3).for_each(|a| clip_from_world[12 + a] = -eye[a]);
    let view = MatrixView { name: String::new(), clip_from_world, eye, near: 0.5 };
    let made = |model: &Model, origin: [f64; 3]| {
        let options = MakeOptions { origin, ..MakeOptions::default() };
        Occscn::make(model, std::slice::from_ref(&view), &options).unwrap()
    };
    // The same place, counted near zero: only where it stands differs, by whole numbers.
    let from = std::array::from_fn(|a| origin[a] - far[a]);
    let (far, near) = (made(&moved, origin), made(&near, from));
    assert_eq!((&far.vertices, &far.triangles), (&near.vertices, &near.triangles));
    assert_eq!(far.objects.len(), near.objects.len());
    assert_eq!(far.cameras[0].eye, [1.0, 2.0, 3.0]);
    assert_eq!(far.cameras[0].clip_from_world[12..], [-1.0, -2.0, -3.0, 1.0]);
    assert_eq!(Occscn::parse(&written(&far)).unwrap(), far);
}
