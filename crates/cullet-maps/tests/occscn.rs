//! `OCCSCN01` files written, loaded, and refused.

use cullet_io::{LoadOptions, Model, Up};
use cullet_maps::{load_bytes, occscn};

/// A model from memory that must load.
fn of(name: &str, bytes: &[u8]) -> Model {
    load_bytes(name, bytes, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn sample_scene() -> occscn::Occscn {
    let mut clip_from_world = [0.0; 16];
    (0..16).for_each(|i| clip_from_world[i] = i as f32 * 0.5 - 3.0);
    occscn::Occscn {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1]],
        // In any order, empty ones anywhere.
        meshes: [(1, 2), (0, 1), (9, 0)]
            .map(|(first_triangle, triangle_count)| occscn::MeshRange {
                first_triangle,
                triangle_count,
            })
            .to_vec(),
        cameras: vec![occscn::OccCamera { clip_from_world, eye: [1.0, 2.0, 3.0], near: 0.5 }],
        objects: vec![[[0.1, 0.2, 0.3], [1.3, 1.7, 1e9]], [[-1.0; 3], [-1.0; 3]]],
    }
}

#[test]
fn occscn_survives_writing_and_loading() {
    let scene = sample_scene();
    let mut scene_file = Vec::new();
    scene.write(&mut scene_file).unwrap();
    assert_eq!(scene_file.len(), 32 + 12 * 4 + 12 * 3 + 32 * 3 + 80 + 24 * 2);
    assert_eq!(occscn::Occscn::parse(&scene_file).unwrap(), scene);

    let model = of("a.occscn", &scene_file);
    assert_eq!(model.instance_names, ["mesh 0", "mesh 1", "mesh 2", "object 0", "object 1"]);
    assert_eq!(model.views[0].eye, [1.0, 2.0, 3.0]);
    assert_eq!(model.views[0].clip_from_world[5], -0.5);
    let again = occscn::Occscn::from_model(&model).unwrap();
    assert_eq!(again.objects, scene.objects);
    assert_eq!(again.cameras, scene.cameras);
    let corners = |s: &occscn::Occscn| {
        let mut all: Vec<_> = s
            .triangles
            .iter()
            .map(|t| t.map(|v| s.vertices[v as usize].map(f32::to_bits)))
            .collect();
        all.sort_unstable();
        all
    };
    assert_eq!(corners(&again), corners(&scene));

    // Each object is drawn within its bounds: a closed box wound outward.
    let unit = model.scene.meshes().last().unwrap();
    let volume: f32 = (0..12)
        .map(|t| {
            let [a, b, c] = unit.corners(t);
            (a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]))
                / 6.0
        })
        .sum();
    assert!((volume - 1.0).abs() < 1e-6, "{volume}");
    let objects =
        model.scene.slots().filter(|&s| model.scene.handle(s).is_some_and(|h| h.index >= 3));
    for slot in objects {
        let (t, b) = (model.scene.transform(slot), model.scene.bounds(slot));
        assert!(model.scene.flags(slot).no_occlusion);
        for a in 0..3 {
            let high = t.translation[a] + f64::from(t.linear[a][a]);
            assert_eq!(t.translation[a], f64::from(b.min[a]));
            assert!(
                high <= f64::from(b.max[a]) && high >= f64::from(b.max[a]) * (1.0 - 1e-6) - 1e-6
            );
        }
    }
}

#[test]
fn occscn_turns_views_with_the_world() {
    let mut file = Vec::new();
    sample_scene().write(&mut file).unwrap();
    let load = |up| load_bytes("a", &file, &LoadOptions { up, ..LoadOptions::default() }).unwrap();
    let (y, z) = (load(Some(Up::Y)), load(Some(Up::Z)));
    let clip = |m: &[f64; 16], p: [f64; 3]| -> [f64; 4] {
        std::array::from_fn(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r])
    };
    assert_eq!(
        clip(&y.views[0].clip_from_world, [1.0, 2.0, 3.0]),
        clip(&z.views[0].clip_from_world, [1.0, 3.0, -2.0])
    );
    assert_eq!(z.views[0].eye, [1.0, 3.0, -2.0]);
    // The fourth instance of the file, wherever its slot is.
    let fourth = |scene: &cullet::Scene| {
        let mut slots = scene.slots();
        slots.find(|&s| scene.handle(s).is_some_and(|h| h.index == 3)).map(|s| scene.bounds(s))
    };
    let (a, b) = (fourth(&y.scene).unwrap(), fourth(&z.scene).unwrap());
    assert_eq!(([a.min[0], a.min[2], -a.max[1]], [a.max[0], a.max[2], -a.min[1]]), (b.min, b.max));
}

#[test]
fn occscn_refuses_what_does_not_fit() {
    let mut file = Vec::new();
    sample_scene().write(&mut file).unwrap();
    for end in 0..file.len() {
        load_bytes("a.occscn", &file[..end], &LoadOptions::default()).unwrap_err();
    }
    let vertices = 32;
    let triangles = vertices + 4 * 12;
    let meshes = triangles + 3 * 12;
    let cameras = meshes + 3 * 32;
    let objects = cameras + 80;
    for (at, value, expected) in [
        (8, 5u32, "5 vertices, 3 triangles, 3 meshes, 1 cameras, 2 objects take"),
        (12, u32::MAX, "triangles"),
        (vertices + 16, f32::NAN.to_bits(), "vertex 1: not finite: NaN"),
        (triangles + 12, 4, "triangle 1: refers to vertex 4, but there are only 4 (from 0)"),
        (meshes, 0, "mesh 0: starts at triangle 0, but those before it end at 1"),
        (meshes + 4, 3, "mesh 0: ends at triangle 4, but there are only 3"),
        (meshes + 4, 1, "meshes: they hold 2 of 3 triangles, and must hold all"),
        (cameras, f32::INFINITY.to_bits(), "camera 0: not finite: inf"),
        (objects + 12, 0, "object 0: its box is inside out"),
    ] {
        let mut broken = file.clone();
        broken[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let error = load_bytes("a", &broken, &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(expected), "{at}: {error}");
    }
    let mut bad = sample_scene();
    bad.triangles[0][0] = 9;
    assert!(bad.write(&mut Vec::new()).unwrap_err().to_string().contains("refers to vertex 9"));
}
