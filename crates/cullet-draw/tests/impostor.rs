//! Impostors keep their error, and are drawn where the cut has chosen them.

use cullet::bounds::Aabb;
use cullet::lod::Lod;
use cullet::mesh::{Alpha, Part};
use cullet::{
    Culler, Instance, InstanceFlags, Mesh, MeshData, Output, Scene, Stage, Transform, View, Visible,
};
use cullet_draw::{
    Frame, ImpostorOptions, ImpostorPlane, PixelId, RenderOptions, Selection, capture_impostor,
    impostor_cards, impostor_sheet, make_impostor, measure_impostor, render, shaded_levels,
    verify_levels,
};
use cullet_io::{LoadOptions, load};
use cullet_mesh::{Impostor, ImpostorError};
use cullet_testkit::answers::cull;
use cullet_testkit::views::look;
use cullet_testkit::{Folder, Rng, meshes, models, soups};

/// Small and quick.
fn options() -> ImpostorOptions {
    ImpostorOptions { grid: 8, texels: 8, samples: 3, directions: 48, ..ImpostorOptions::default() }
}

fn mesh_of((positions, indices): soups::Soup) -> Mesh {
    Mesh::new(MeshData { positions, indices, ..MeshData::default() }).expect("valid")
}

/// Meshes of many shapes, and some that are hardly any.
fn all_shapes() -> Vec<(&'static str, Mesh)> {
    let quad = vec![[-2.0, 0.5, -1.0], [2.0, 0.5, -1.0], [2.0, 0.5, 1.0], [-2.0, 0.5, 1.0]];
    let one = vec![[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 1.0, 0.5]];
    let pole = soups::block([-0.05, 0.0, -0.05], [0.05, 6.0, 0.05]);
    let table = soups::join([
        soups::block([-1.0, 1.0, -1.0], [1.0, 1.1, 1.0]),
        soups::block([-0.9, 0.0, -0.9], [-0.7, 1.0, -0.7]),
        soups::block([0.7, 0.0, 0.7], [0.9, 1.0, 0.9]),
    ]);
    vec![
        ("ball", meshes::ball(24)),
        ("block", meshes::block([1.0; 3], [2.0, 3.0, 5.0])),
        ("tetrahedron", meshes::tetrahedron()),
        ("bumps", mesh_of(soups::bumpy_ball(24, 0.2))),
        ("triangle", mesh_of((one, vec![0, 1, 2]))),
        ("flat", mesh_of((quad, vec![0, 1, 2, 0, 2, 3]))),
        ("pole", mesh_of(pole)),
        ("table", mesh_of(table)),
        ("far", meshes::block([1e6; 3], [1e6 + 2.0, 1e6 + 1.0, 1e6 + 4.0])),
        ("tiny", mesh_of(soups::ball_at([0.0; 3], 1e-15, 8))),
        ("huge", mesh_of(soups::ball_at([0.0; 3], 1e15, 8))),
    ]
}

fn radius(mesh: &Mesh) -> f64 {
    mesh.bounds().half_extent().iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[test]
fn the_error_holds_from_other_directions_than_those_it_was_measured_from() {
    for (name, mesh) in all_shapes() {
        let (impostor, found) = make_impostor(&mesh, &options()).expect(name);
        let error = f64::from(impostor.error());
        assert!(error >= found.error && error > 0.0, "{name}: {found:?}");
        // What is flat vanishes edge-on, and says so; else it is much less than half of what there is.
        let is_flat = mesh.triangle_count() < 3;
        assert!(
            is_flat || error < 0.35 * radius(&mesh),
            "{name}: {} of the radius",
            error / radius(&mesh)
        );
        let other = measure_impostor(&mesh, &impostor, 64, 77).expect(name);
        assert!(other.samples > 1000, "{name}: {other:?}");
        assert!(
            other.p999 <= error && (is_flat || other.max <= 1.4 * error),
            "{name}: {other:?} of {error}"
        );
    }
}

#[test]
fn the_same_bytes_come_out_of_any_number_of_threads() {
    let mesh = mesh_of(soups::bumpy_ball(16, 0.2));
    let make = || make_impostor(&mesh, &options()).expect("sound");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let (a, b) = (make(), one.install(make));
    assert_eq!(a, b);
    assert_eq!(a.0.shape().len(), 8 * 8 * 8 * 8);
    // Two bytes a texel: what the usual size comes to.
    assert_eq!(Impostor::texel_count([12, 12]).expect("usual") * 2, 41_472);
}

#[test]
fn what_cannot_be_stood_for_is_refused() {
    let refused = |mesh: &Mesh| match capture_impostor(mesh, &options()) {
        Err(ImpostorError::Mesh { why }) => why,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("made"),
    };
    let empty = Mesh::new(MeshData::default()).expect("valid");
    assert_eq!(refused(&empty), "has no triangle with an area");
    let line = mesh_of((vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![0, 1, 2]));
    assert_eq!(refused(&line), "has no triangle with an area");
    let data = meshes::tetrahedron().to_data();
    let moves = Mesh::new(MeshData { deformable: true, ..data.clone() }).expect("valid");
    assert_eq!(refused(&moves), "may move");
    let part = |alpha, first_triangle, triangle_count| Part {
        alpha,
        first_triangle,
        triangle_count,
        ..Part::default()
    };
    for alpha in [Alpha::Masked, Alpha::Blended] {
        let parts = vec![part(Alpha::Opaque, 0, 3), part(alpha, 3, 1)];
        let mesh = Mesh::new(MeshData { parts, ..data.clone() }).expect("valid");
        assert_eq!(refused(&mesh), "is not opaque");
        let mut scene = Scene::new();
        let own = scene.add_mesh(mesh);
        let good = capture_impostor(&meshes::tetrahedron(), &options()).expect("sound");
        assert!(matches!(good.add_to(&mut scene, own), Err(ImpostorError::Mesh { .. })));
    }
    let (positions, indices) = soups::ball(6, 6);
    let parts = (0..indices.len() as u32 / 3).map(|t| part(Alpha::Opaque, t, 1)).collect();
    let many = Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() });
    assert_eq!(refused(&many.expect("valid")), "has more than 16 parts");
    for size in [1e-44_f32, 3e38] {
        let odd = mesh_of((vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]], vec![0, 1, 2]));
        if odd.degenerate_count() == 0 {
            assert_eq!(refused(&odd), "is too large or too small");
        }
    }
    let sizes = ImpostorOptions { grid: 1, ..options() };
    let refused = capture_impostor(&meshes::tetrahedron(), &sizes);
    assert!(matches!(refused, Err(ImpostorError::Size { .. })));
    let mut scene = Scene::new();
    let own = scene.add_mesh(meshes::block([0.0; 3], [1.0; 3]));
    let other = capture_impostor(&meshes::tetrahedron(), &options()).expect("sound");
    assert!(matches!(other.clone().add_to(&mut scene, own), Err(ImpostorError::Mesh { .. })));
    assert!(matches!(other.add_to(&mut scene, 9), Err(ImpostorError::Levels(_))));
}

/// A scene of instances of one mesh with an impostor.
fn scene_of(mesh: &Mesh, places: &[Transform]) -> (Scene, f64) {
    let mut scene = Scene::new();
    let (impostor, _) = make_impostor(mesh, &options()).expect("sound");
    let error = f64::from(impostor.error());
    let own = scene.add_mesh(mesh.clone());
    let held = impostor.add_to(&mut scene, own).expect("of this mesh");
    assert_eq!((held, scene.levels(own).len()), (1, 1));
    for place in places {
        scene.add(Instance::new(own, *place)).expect("sound");
    }
    scene.commit(&Culler::default());
    scene.prepare(&Culler::exact());
    (scene, error)
}

fn drawn(scene: &Scene, view: &View, pixels: f64) -> (Visible, Frame) {
    let lod = Some(Lod::default().with_pixels(pixels));
    let culler = Culler::exact().with_lod(lod).with_output(Output::Triangles);
    let visible = cull(&culler, scene, view);
    let frame = render(scene, view, Selection::Visible(&visible), &RenderOptions::default());
    (visible, frame)
}

/// How far, in pixels, the farthest covered pixel of either frame is from one of the other.
fn apart(a: &Frame, b: &Frame) -> f64 {
    let covered = |f: &Frame| -> Vec<[i64; 2]> {
        let at = (0..f.ids.len()).filter(|&i| f.ids[i] != PixelId::NONE);
        at.map(|i| [i as i64 % i64::from(f.width), i as i64 / i64::from(f.width)]).collect()
    };
    let (a, b) = (covered(a), covered(b));
    assert!(!a.is_empty() && !b.is_empty());
    let one = |from: &[[i64; 2]], to: &[[i64; 2]]| {
        let near = |p: &[i64; 2]| {
            let off = |q: &[i64; 2]| (p[0] - q[0]).pow(2) + (p[1] - q[1]).pow(2);
            to.iter().map(off).min().unwrap_or(i64::MAX)
        };
        from.iter().map(near).max().unwrap_or(0)
    };
    (one(&a, &b).max(one(&b, &a)) as f64).sqrt()
}

#[test]
fn instances_of_all_transforms_are_drawn_where_they_are() {
    let table = all_shapes().swap_remove(7).1;
    let turn = [0.0, (0.4_f64).sin(), 0.0, (0.4_f64).cos()];
    let places = [
        Transform::IDENTITY,
        Transform::from_scale_translation([-1.0, 1.0, 1.0], [0.3, 0.0, 0.0]),
        Transform::from_scale_translation([1.0, 2.0, 0.5], [0.0, -1.0, 0.0]),
        Transform::from_scale_rotation_translation([0.7; 3], turn, [1e5, 0.0, -1e5]),
    ];
    for place in places {
        let (scene, error) = scene_of(&table, &[place]);
        let [x, y, z] = place.translation;
        for (from, size) in
            [([3.0, 2.0, 5.0], 100.0), ([-4.0, 6.0, 1.0], 60.0), ([1.0, -3.0, -4.0], 150.0)]
        {
            let far = 6.0;
            let eye = [x + from[0] * far, y + from[1] * far, z + from[2] * far];
            let view = look(eye, [x, y + 0.5, z], [size as u32; 2]);
            // Beyond any threshold, so that the impostor is chosen, and none at all.
            let (visible, frame) = drawn(&scene, &view, 1e3);
            assert_eq!(visible.triangle_ranges.iter().map(|r| r.level).collect::<Vec<_>>(), [1]);
            let full = render(&scene, &view, Selection::All, &RenderOptions::default());
            let distance = (from.iter().map(|v| v * v).sum::<f64>()).sqrt() * far;
            let pixel = cullet::lod::PixelScale::of(&view, false).pixels / distance;
            let stated = error * 2.0 * 1.4 * pixel;
            let off = apart(&full, &frame);
            assert!(off <= stated + 1.5, "{place:?} from {from:?}: {off} px, {stated} stated");
            let shaded = shaded_levels(&scene, &frame, &view, &visible, &[]);
            assert_eq!(shaded.width, size as u32);
        }
    }
}

#[test]
fn an_impostor_is_chosen_as_any_level_is_and_never_near_by() {
    let (scene, error) = scene_of(&mesh_of(soups::bumpy_ball(24, 0.2)), &[Transform::IDENTITY]);
    let scale = |view: &View| cullet::lod::PixelScale::of(view, false).pixels;
    let radius = f64::from(scene.levels(0)[0].levels.group(0).radius);
    let view = |distance: f64| look([0.0, 0.0, distance], [0.0; 3], [64, 64]);
    let at_one = error * scale(&view(9.0)) + radius;
    for (distance, level) in [(1.3, 0), (radius, 0), (at_one * 0.98, 0), (at_one * 1.02, 1)] {
        let (visible, _) = drawn(&scene, &view(distance), 1.0);
        let levels: Vec<u32> = visible.triangle_ranges.iter().map(|r| r.level).collect();
        assert_eq!(levels, [level], "{distance} of {at_one}");
    }
    // But where none are wanted, however few triangles there may be.
    for (impostors, triangles, level) in
        [(true, None, 1), (true, Some(12), 1), (false, None, 0), (false, Some(12), 0)]
    {
        let lod = Some(Lod::default().with_impostors(impostors).with_triangles(triangles));
        let culler = Culler::exact().with_lod(lod).with_output(Output::Triangles);
        let visible = cull(&culler, &scene, &view(at_one * 1.02));
        assert_eq!(visible.triangle_ranges[0].level, level, "{impostors} {triangles:?}");
    }
    // Of another mesh in its place it is no picture.
    let mut scene = scene;
    scene.edit_mesh(0, |mesh| mesh.set_two_sided(true));
    assert_eq!(scene.levels(0).len(), 1);
    scene.edit_mesh(0, |mesh| *mesh = meshes::tetrahedron());
    assert!(scene.levels(0).is_empty());
}

#[test]
fn verification_excuses_impostors_by_no_more_than_levels() {
    let mut rng = Rng(5);
    let places: Vec<Transform> = (0..40)
        .map(|_| Transform::from_translation(rng.vector(9.0)))
        .chain([Transform::from_scale_translation([3.0; 3], [0.0, 0.0, 6.0])])
        .collect();
    let (mut scene, _) = scene_of(&meshes::ball(12), &places);
    let glass = InstanceFlags { transparent: true, ..InstanceFlags::default() };
    let mut instance = Instance::new(0, Transform::from_translation([4.0, 0.0, 9.0]));
    instance.flags = glass;
    scene.add(instance).expect("sound");
    scene.commit(&Culler::default());
    scene.prepare(&Culler::exact());
    let mut impostors = 0;
    for (eye, pixels) in [([0.0, 2.0, 30.0], 2.0), ([3.0, 1.0, 12.0], 4.0), ([25.0, 9.0, 3.0], 9.0)]
    {
        let view = look(eye, [0.0; 3], [160, 120]);
        let lod = Some(Lod::default().with_pixels(pixels));
        let culler = Culler::exact().with_lod(lod);
        let v = verify_levels(
            &scene,
            &view,
            &culler,
            [&mut Default::default(), &mut Default::default()],
            &Default::default(),
        );
        assert!(v.full.false_culls.is_empty(), "{:?}", v.full.false_culls);
        assert!(v.levels.false_culls.is_empty(), "{:?}", v.levels.false_culls);
        impostors += v.cut.triangle_ranges.iter().filter(|r| r.level == 1).count();
        assert!(v.pixels.differ * 5 < v.pixels.all, "{:?}", v.pixels);
    }
    assert!(impostors > 20, "{impostors}");
    let only = Culler::exact().with_lod(Lod::default()).only(Stage::Lod);
    assert!(only.lod.is_some());
}

#[test]
fn sheets_show_each_plane() {
    let impostor = capture_impostor(&meshes::ball(12), &options()).expect("sound");
    assert_eq!(impostor.bounds(), meshes::ball(12).bounds());
    assert_ne!(impostor.bounds(), Aabb::EMPTY);
    for plane in ImpostorPlane::ALL {
        let sheet = impostor_sheet(&impostor, plane, &[[255, 0, 0]]);
        assert_eq!([sheet.width, sheet.height], [64, 64]);
        // The middle of a frame, and the corner of one, where there is no ball.
        let (middle, corner) = (sheet.pixel(12, 12), sheet.pixel(8, 8));
        match plane {
            ImpostorPlane::Coverage => assert_eq!((middle, corner), ([255; 3], [0; 3])),
            ImpostorPlane::Color => assert_eq!((middle, corner), ([255, 0, 0], [0; 3])),
            ImpostorPlane::Depth => assert!(middle[0] > 180),
            ImpostorPlane::Normal => assert_ne!(middle, [0; 3]),
        }
    }
}

#[test]
fn cards_are_a_gltf_that_loads() {
    let impostor = capture_impostor(&meshes::block([-1.0; 3], [1.0, 2.0, 3.0]), &options());
    let cards = impostor_cards(&impostor.expect("sound"), "block", &[[200, 10, 10]]);
    let folder = Folder::new("impostor-cards");
    let path = |name: &str| folder.path(name);
    for (name, bytes) in [
        ("block.gltf", cards.gltf.as_bytes()),
        ("block.bin", &cards.bin),
        ("block.png", &cards.png),
    ] {
        std::fs::write(path(name), bytes).expect("a folder of ours");
    }
    let model = load(path("block.gltf").as_ref(), &LoadOptions::default()).expect("a glTF");
    assert_eq!((model.scene.triangle_count(), model.warnings.len()), (12, 0));
    // As large as the block, or as a frame that looks at it from a little aside.
    let extent = model.scene.extent().half_extent();
    assert!((0..3).all(|a| extent[a] < 3.3 && extent[a] > [0.9, 1.4, 1.9][a]), "{extent:?}");
    assert!(cards.png.starts_with(b"\x89PNG"));
}

/// Prints the figures of large models, by grid and texels: `cargo test impostor_figures --
/// --ignored --nocapture`.
#[test]
#[ignore = "for figures"]
fn impostor_figures() {
    let mut shapes = all_shapes();
    for name in ["armadillo/armadillo.obj", "happy-buddha/happy-buddha.off"] {
        shapes.extend(models::model(name).map(|soup| (name, mesh_of(soup))));
    }
    for (name, mesh) in shapes {
        for [grid, texels] in [[12, 12], [8, 12], [12, 16]] {
            let options = ImpostorOptions { grid, texels, ..ImpostorOptions::default() };
            let start = std::time::Instant::now();
            let captured = capture_impostor(&mesh, &options).expect("sound");
            let capture = start.elapsed().as_secs_f64();
            let found = measure_impostor(&mesh, &captured, 32, 1).expect("sound");
            let r = radius(&mesh);
            println!(
                "{name} {grid} × {texels}: {} bytes a plane, {capture:.2} s; p99.9 {:.4} R, 1 px at {:.1} px, max {:.4} R; {:.2} s",
                captured.shape().len() * 2,
                found.p999 / r,
                r / found.p999,
                found.max / r,
                start.elapsed().as_secs_f64()
            );
        }
    }
    let (scene, _) = scene_of(&meshes::ball(24), &[Transform::IDENTITY]);
    for distance in [4.0, 40.0] {
        let view = look([0.3 * distance, 0.2 * distance, distance], [0.0; 3], [256; 2]);
        let (visible, frame) = drawn(&scene, &view, 1e6);
        assert_eq!(visible.triangle_ranges[0].level, 1);
        let start = std::time::Instant::now();
        for _ in 0..10 {
            std::hint::black_box(render(
                &scene,
                &view,
                Selection::Visible(&visible),
                &RenderOptions { threads: 1, ..RenderOptions::default() },
            ));
        }
        let each = start.elapsed().as_secs_f64() / 10.0;
        let covered = frame.stats.covered_pixels;
        println!("{covered} pixels covered in {:.3} ms, one thread", each * 1e3);
    }
}
