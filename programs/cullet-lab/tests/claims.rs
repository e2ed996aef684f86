//! Every pixel that the occlusion buffer claims, and its depth, against jittered samples: of
//! adversaries, of built-in scenes and of models; and that the check finds claims that are wrong.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, DynamicSurface, OcclusionBuffer};
use cullet::{
    Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Simd, Transform, View,
    view::CullFace,
};
use cullet_draw::OccluderTriangles;
use cullet_io::{LoadOptions, load};
use cullet_lab::claims::{ClaimCheck, ClaimOptions, Claims, SceneOccluders, check_claims};
use cullet_scenes::adversaries::{ADVERSARIES, adversary};
use cullet_scenes::paths::{self, Overrides, PathSpec};
use cullet_testkit::{at_every_level, cases, data};

/// Draws all occluders of a scene, and checks; what is wrong ends the test.
fn check(name: &str, scene: &Scene, view: &View, simd: Simd) -> ClaimCheck {
    let occluders = SceneOccluders::new(scene);
    check_drawn(name, &occluders, view, simd)
}

fn check_drawn(name: &str, occluders: &SceneOccluders<'_>, view: &View, simd: Simd) -> ClaimCheck {
    let mut buffer = OcclusionBuffer::new(view.viewport()).unwrap();
    occluders.draw(view, simd, &mut buffer);
    let claims = Claims::of(&buffer);
    let check = check_claims(view, &claims, &occluders.triangles(view), &ClaimOptions::default());
    assert_eq!(check.wrong, 0, "{name}: {:?}", check.first);
    check
}

#[test]
fn adversaries_find_no_wrong_claim() {
    let views = cases(2);
    let (mut claimed, mut pixels) = (0, 0);
    for number in 0..ADVERSARIES {
        let a = adversary(number, 1, views, [240, 135]);
        let occluders = SceneOccluders::new(&a.scene);
        for (k, view) in a.views.iter().enumerate() {
            let name = format!("{number} {}, view {k}", a.name);
            let check = check_drawn(&name, &occluders, view, Simd::best());
            claimed += check.claimed;
            pixels += check.pixels;
        }
    }
    println!("{claimed} of {pixels} pixels claimed");
    assert!(
        claimed * 20 > pixels,
        "{claimed} of {pixels}: nothing is tested where nothing is claimed"
    );
}

#[test]
fn triangles_in_the_near_plane_are_there_far_from_the_origin() {
    // Rounding puts their corners before and behind it.
    let a = adversary(69, 9, 1, [320, 180]);
    assert!(check(&a.name, &a.scene, &a.views[0], Simd::best()).claimed > 50_000);
}

#[test]
fn buffers_of_odd_sizes_claim_nothing_wrong_at_any_level() {
    at_every_level!(|name, level| {
        for (number, size) in [(0, [37, 91]), (8, [5, 3]), (23, [130, 67]), (47, [1, 1])] {
            let a = adversary(number, 2, 3, size);
            for view in &a.views {
                check(&format!("{} at {name}", a.name), &a.scene, view, level);
            }
        }
    });
}

fn cameras(model: &cullet_io::Model, path: &PathSpec, count: usize, size: [u32; 2]) -> Vec<View> {
    let cameras = paths::cameras(model, path, count, size, &Overrides::default()).unwrap();
    cameras.iter().map(|c| View::new(c, Depth::Reversed, size).unwrap()).collect()
}

#[test]
fn built_in_scenes_find_no_wrong_claim() {
    for spec in ["city:cells=8", "office:floors=1", "solids:n=60", "forest:n=400", "knobs"] {
        let model = cullet_scenes::build(spec).unwrap();
        let path = paths::of_builtin(spec);
        let occluders = SceneOccluders::new(&model.scene);
        let mut claimed = 0;
        for view in cameras(&model, &path, 2, [320, 180]) {
            claimed += check_drawn(spec, &occluders, &view, Simd::best()).claimed;
        }
        assert!(claimed > 1000, "{spec}: {claimed}");
    }
}

#[test]
fn models_find_no_wrong_claim() {
    for (name, two_sided) in [
        ("intel-castle/intel-castle.glb", Some(false)),
        ("crytek-sponza/crytek-sponza.ply", None),
        ("duplex-bim/duplex.glb", None),
        ("room-godot/room.glb", None),
    ] {
        let Some(file) = data(name) else { continue };
        let options = LoadOptions { two_sided, ..LoadOptions::default() };
        let model = load(&file, &options).unwrap();
        let occluders = SceneOccluders::new(&model.scene);
        for view in cameras(&model, &PathSpec::Walk, 2, [480, 270]) {
            check_drawn(name, &occluders, &view, Simd::best());
        }
    }
}

/// A bumpy sheet of quads before the eye, in f32, as a scene of one mesh.
fn bumpy_sheet(two_sided: bool) -> Scene {
    let n = 12;
    let at = |i: u32| i as f32 / n as f32 * 4.5 - 2.25;
    let positions: Vec<[f32; 3]> = (0..(n + 1) * (n + 1))
        .map(|v| {
            let (x, y) = (v % (n + 1), v / (n + 1));
            [at(x), at(y), ((v * 37 % 11) as f32 - 5.0) * 0.06 - 6.0]
        })
        .collect();
    let indices = (0..n * n).flat_map(|i| {
        let v = i / n * (n + 1) + i % n;
        [v, v + 1, v + n + 2, v, v + n + 2, v + n + 1]
    });
    let mut mesh =
        Mesh::new(MeshData { positions, indices: indices.collect(), ..MeshData::default() })
            .unwrap();
    mesh.set_two_sided(two_sided);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    scene.commit(&cullet::Culler::default());
    scene
}

const SIZE: [u32; 2] = [160, 120];

fn kinds_of_views() -> Vec<View> {
    let perspective = View::perspective([0.1, 0.2, 0.0], [0.3, 0.1, -6.0], 0.9, 0.1, 90.0, SIZE);
    let parallel = View::orthographic([0.1, 0.2, 0.0], [0.3, 0.1, -6.0], 5.0, -1.0, 40.0, SIZE);
    let projection = Projection::OffCentre {
        left: 0.12,
        right: -0.1,
        bottom: -0.06,
        top: 0.1,
        near: 0.2,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at([0.0, 0.1, 0.5], [0.0, 0.0, -6.0], projection);
    let mirrored = View::new(&camera, Depth::Reversed, SIZE);
    vec![perspective.unwrap(), parallel.unwrap(), mirrored.unwrap()]
}

/// Claims that were drawn, all of them right, with the triangles that they are of.
fn drawn<'a>(occluders: &SceneOccluders<'a>, view: &View) -> (Claims, Vec<OccluderTriangles<'a>>) {
    let mut buffer = OcclusionBuffer::new(SIZE).unwrap();
    occluders.draw(view, Simd::best(), &mut buffer);
    let (claims, triangles) = (Claims::of(&buffer), occluders.triangles(view));
    let check = check_claims(view, &claims, &triangles, &ClaimOptions::default());
    assert!(check.claimed > 5000 && check.wrong == 0, "{check:?}");
    (claims, triangles)
}

fn wrong(view: &View, claims: &Claims, triangles: &[OccluderTriangles<'_>]) -> Vec<[u32; 2]> {
    let options = ClaimOptions { listed: usize::MAX, ..ClaimOptions::default() };
    let check = check_claims(view, claims, triangles, &options);
    assert_eq!(check.first.len() as u64, check.wrong);
    check.first.iter().map(|w| w.pixel).collect()
}

/// The next to last digits of f32 that the samples of an uneven pixel surely tell apart.
const STEP: f32 = 1.0 + 1.0 / 256.0;

#[test]
fn a_depth_that_is_too_near_is_found() {
    let scene = bumpy_sheet(false);
    let occluders = SceneOccluders::new(&scene);
    for view in kinds_of_views() {
        let (claims, triangles) = drawn(&occluders, &view);
        for pixel in [[80, 60], [70, 50], [91, 66]] {
            // The nearest that may be claimed is that of the farthest point in the pixel: more is
            // found, less is right.
            let [x, y] = pixel;
            let right = claims.nearness(x, y);
            assert!(right > 0.0);
            let mut nearer = claims.clone();
            nearer.claim(x, y, right * (1.0 + 0.1));
            assert_eq!(wrong(&view, &nearer, &triangles), [pixel], "{}", view.is_orthographic());
            nearer.claim(x, y, right / STEP);
            assert!(wrong(&view, &nearer, &triangles).is_empty());
            nearer.claim(x, y, f32::NAN);
            assert_eq!(wrong(&view, &nearer, &triangles), [pixel]);
            nearer.claim(x, y, f32::INFINITY);
            assert_eq!(wrong(&view, &nearer, &triangles), [pixel]);
        }
    }
}

#[test]
fn a_single_step_of_f32_is_found_where_a_wall_is_parallel_to_the_screen() {
    // 0.25 and no rounding: a wall at a distance of 4, exactly.
    let positions =
        vec![[-9.0, -9.0, -4.0], [9.0, -9.0, -4.0], [9.0, 9.0, -4.0], [-9.0, 9.0, -4.0]];
    let wall = [OccluderTriangles {
        positions: &positions,
        indices: &[0, 1, 2, 0, 2, 3],
        transform: Transform::IDENTITY,
        two_sided: false,
    }];
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 90.0, SIZE).unwrap();
    let mut claims = Claims::none(SIZE);
    (0..SIZE[1]).for_each(|y| (0..SIZE[0]).for_each(|x| claims.claim(x, y, 0.25)));
    assert!(wrong(&view, &claims, &wall).is_empty());
    claims.claim(31, 7, 0.25_f32.next_up());
    assert_eq!(wrong(&view, &claims, &wall), [[31, 7]]);
}

#[test]
fn a_pixel_too_many_is_found_with_what_its_sample_met() {
    let scene = bumpy_sheet(false);
    let occluders = SceneOccluders::new(&scene);
    for view in kinds_of_views() {
        let (mut claims, triangles) = drawn(&occluders, &view);
        // Beside the last pixel of a row that is claimed, some nearness farther than all.
        let row = (0..SIZE[1]).find(|&y| {
            claims.nearness(80, y) > 0.0 && (0..SIZE[0]).any(|x| claims.nearness(x, y) == 0.0)
        });
        let (row, least) = (row.unwrap(), 1e-4);
        let open = (0..SIZE[0]).find(|&x| claims.nearness(x, row) == 0.0).unwrap();
        claims.claim(open, row, least);
        let options = ClaimOptions { samples: 24, ..ClaimOptions::default() };
        let check = check_claims(&view, &claims, &triangles, &options);
        assert_eq!(check.wrong, 1, "{:?}", check.first);
        let w = check.first[0];
        assert_eq!((w.pixel, w.claimed, w.found), ([open, row], least, None));
        assert!(w.samples > 0 && w.sample[0].floor() == f64::from(open));
    }
}

#[test]
fn gaps_are_found_of_a_triangle_and_of_a_third_of_a_pixel() {
    let scene = bumpy_sheet(true);
    let occluders = SceneOccluders::new(&scene);
    let view = &kinds_of_views()[0];
    let (claims, triangles) = drawn(&occluders, view);
    // The same without two of its triangles: the claims are those of the whole.
    let without: Vec<u32> = triangles[0].indices[6..].to_vec();
    let fewer = [OccluderTriangles { indices: &without, ..triangles[0] }];
    let found = wrong(view, &claims, &fewer);
    assert!(found.len() > 10, "{found:?}");
    // Cut in two along x = 0, the right half moved by a hair: a third of a pixel.
    let corners = triangles[0].indices.chunks_exact(3).flat_map(|t| {
        let corners = [0, 1, 2].map(|k| triangles[0].positions[t[k] as usize]);
        let is_right = corners.iter().all(|p| p[0] > -0.01);
        corners.map(|[x, y, z]| [if is_right { x + 0.015 } else { x }, y, z])
    });
    let moved: Vec<[f32; 3]> = corners.collect();
    let indices: Vec<u32> = (0..moved.len() as u32).collect();
    let gap = [OccluderTriangles { positions: &moved, indices: &indices, ..triangles[0] }];
    assert!(wrong(view, &claims, &gap).len() > 50);
}

#[test]
fn the_side_that_is_not_drawn_covers_nothing() {
    let scene = bumpy_sheet(false);
    let occluders = SceneOccluders::new(&scene);
    for mut view in kinds_of_views() {
        let (claims, triangles) = drawn(&occluders, &view);
        let claimed = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        let claimed = claimed.filter(|&[x, y]| claims.nearness(x, y) > 0.0).count();
        let turned: Vec<u32> =
            triangles[0].indices.chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
        let mut backs = [OccluderTriangles { indices: &turned, ..triangles[0] }];
        assert_eq!(wrong(&view, &claims, &backs).len(), claimed);
        backs[0].two_sided = true;
        assert!(wrong(&view, &claims, &backs).is_empty());
        // What a view culls is no matter: an occluder has its front.
        view.cull_face = CullFace::Front;
        assert!(wrong(&view, &claims, &triangles).is_empty());
    }
}

#[test]
fn nothing_before_the_near_plane_covers() {
    let [view] = [[0.0; 3]]
        .map(|eye| View::perspective(eye, [0.0, 0.0, -1.0], 1.0, 2.0, 90.0, SIZE).unwrap());
    // A floor through the near plane: of what is claimed of it, all that lies before the plane is
    // wrong.
    let positions = [[-9.0, -0.5, 5.0], [9.0, -0.5, 5.0], [9.0, -0.5, -50.0], [-9.0, -0.5, -50.0]];
    let floor = [OccluderTriangles {
        positions: &positions,
        indices: &[0, 1, 2, 0, 2, 3],
        transform: Transform::IDENTITY,
        two_sided: false,
    }];
    let mut claims = Claims::none(SIZE);
    // Rows below that in which the floor is at a distance of 2: y = 60 + 0.25 * 60 / tan(0.5).
    let edge = (60.0 + 0.25 * 60.0 / 0.5_f64.tan()) as u32;
    for y in 70..SIZE[1] {
        (0..SIZE[0]).for_each(|x| claims.claim(x, y, 0.02));
    }
    let found = wrong(&view, &claims, &floor);
    assert!(found.iter().all(|p| p[1] >= edge), "{edge}: {:?}", found.first());
    assert_eq!(found.len() as u32, (SIZE[1] - edge) * SIZE[0]);
}

/// Mutants of drawing: what is drawn is a little more, nearer or elsewhere than what it is held
/// against.
#[test]
fn mutants_of_drawing_are_found() {
    let scene = bumpy_sheet(false);
    let occluders = SceneOccluders::new(&scene);
    for view in kinds_of_views() {
        let mut buffer = OcclusionBuffer::new(SIZE).unwrap();
        let triangles = occluders.triangles(&view);
        let mutants = [
            ("moved by half a pixel", Transform::from_translation([0.02, 0.0, 0.0])),
            ("nearer by a hundredth", Transform::from_translation([0.0, 0.0, 0.08])),
            ("wider", Transform::from_scale_translation([1.01, 1.01, 1.0], [0.0; 3])),
        ];
        for (name, transform) in mutants {
            let mut other = Scene::new();
            let mesh = other.add_mesh(Mesh::new(scene.meshes()[0].to_data()).unwrap());
            other.add(Instance::new(mesh, transform)).unwrap();
            other.commit(&cullet::Culler::default());
            SceneOccluders::new(&other).draw(&view, Simd::best(), &mut buffer);
            let found = wrong(&view, &Claims::of(&buffer), &triangles);
            assert!(!found.is_empty(), "{name} {}", view.is_orthographic());
        }
        // Triangles one by one, each as an outline a hundredth wider: gaps at folds are closed, and
        // the border is too far out.
        buffer.begin(&view, [0.0; 3]);
        for t in triangles.iter().flat_map(|o| o.indices.chunks_exact(3)) {
            let corners = [0, 1, 2].map(|k| scene.meshes()[0].positions()[t[k] as usize]);
            let middle: [f32; 3] =
                std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0);
            let wider = corners.map(|c| {
                std::array::from_fn::<f32, 3, _>(|a| middle[a] + (c[a] - middle[a]) * 1.1)
            });
            let wider = Convex::from_one_sided_polygon(&wider).unwrap();
            wider.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        }
        assert!(wrong(&view, &Claims::of(&buffer), &triangles).len() > 50);
    }
}

#[test]
fn a_body_is_held_against_its_walls() {
    let cube = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let convex = Convex::from_box(&cube).unwrap();
    let corners = cube.corners();
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices: Vec<u32> = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let at = |scale: f32, x: f64| Transform {
        linear: [[-scale, 0.1, 0.0], [0.2, 1.3, 0.1], [0.0, -0.3, 0.8]],
        translation: [x, 0.1, -6.0],
    };
    let body = |transform| {
        [OccluderTriangles { positions: &corners, indices: &indices, transform, two_sided: false }]
    };
    for view in kinds_of_views() {
        let mut buffer = OcclusionBuffer::new(SIZE).unwrap();
        buffer.begin(&view, [0.0; 3]);
        convex.draw(Simd::best(), &mut buffer, &at(1.2, 0.3));
        let claims = Claims::of(&buffer);
        assert!(wrong(&view, &claims, &body(at(1.2, 0.3))).is_empty());
        assert!(!wrong(&view, &claims, &body(at(1.2, 0.33))).is_empty());
        assert!(!wrong(&view, &claims, &body(at(1.19, 0.3))).is_empty());
    }
}

#[test]
fn the_result_depends_on_no_thread_and_more_samples_find_no_less() {
    let a = adversary(6, 1, 1, [160, 90]);
    let view = &a.views[0];
    let occluders = SceneOccluders::new(&a.scene);
    let mut buffer = OcclusionBuffer::new([160, 90]).unwrap();
    occluders.draw(view, Simd::best(), &mut buffer);
    let mut claims = Claims::of(&buffer);
    // Nearer by a thousandth, all of it.
    for (x, y) in (0..90).flat_map(|y| (0..160).map(move |x| (x, y))) {
        claims.claim(x, y, claims.nearness(x, y) * 1.001);
    }
    let triangles = occluders.triangles(view);
    let of = |samples, threads| {
        let options = ClaimOptions { samples, threads, ..ClaimOptions::default() };
        check_claims(view, &claims, &triangles, &options)
    };
    let eight = of(8, 1);
    assert!(eight.wrong > 0);
    assert_eq!(of(8, 2), eight);
    assert!(of(16, 0).wrong >= of(2, 0).wrong);
}

#[test]
fn a_dynamic_surface_claims_nothing_wrong_and_nearly_as_much() {
    let scene = bumpy_sheet(false);
    let occluders = SceneOccluders::new(&scene);
    let mut surface = DynamicSurface::default();
    let mesh = &scene.meshes()[0];
    for view in kinds_of_views() {
        let (prepared, triangles) = drawn(&occluders, &view);
        surface.set(mesh.positions(), mesh.indices(), false).unwrap();
        let mut buffer = OcclusionBuffer::new(SIZE).unwrap();
        buffer.begin(&view, [0.0; 3]);
        surface.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        let claims = Claims::of(&buffer);
        assert!(wrong(&view, &claims, &triangles).is_empty());
        let options = ClaimOptions::default();
        let [new, old] = [&claims, &prepared]
            .map(|claims| check_claims(&view, claims, &triangles, &options).claimed);
        assert!(new as f64 > old as f64 * 0.99, "{new} of {old}");
        // What is refused leaves nothing behind.
        assert!(surface.set(mesh.positions(), &[0, 1, 9999], false).is_err());
        buffer.begin(&view, [0.0; 3]);
        surface.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        assert!((0..SIZE[0]).all(|x| buffer.nearness(x, SIZE[1] / 2) <= 0.0));
    }
}

/// Draws triangles as dynamic surfaces, and checks; what is wrong ends the test.
fn check_dynamic(
    name: &str,
    surfaces: &mut [DynamicSurface],
    triangles: &[OccluderTriangles<'_>],
    view: &View,
) -> u64 {
    let mut buffer = OcclusionBuffer::new(view.viewport()).unwrap();
    buffer.begin(view, [0.0; 3]);
    for (surface, of) in surfaces.iter_mut().zip(triangles) {
        surface.set(of.positions, of.indices, of.two_sided).unwrap();
        surface.draw(Simd::best(), &mut buffer, &of.transform);
    }
    let check = check_claims(view, &Claims::of(&buffer), triangles, &ClaimOptions::default());
    assert_eq!(check.wrong, 0, "{name}: {:?}", check.first);
    check.claimed
}

#[test]
fn dynamic_adversaries_find_no_wrong_claim_however_they_deform() {
    let mut claimed = 0;
    for number in 0..cases(ADVERSARIES).min(ADVERSARIES) {
        let a = adversary(number, 3, 2, [120, 67]);
        let occluders = SceneOccluders::new(&a.scene);
        let view = &a.views[1];
        let triangles = occluders.triangles(view);
        let mut surfaces = vec![DynamicSurface::default(); triangles.len()];
        claimed += check_dynamic(&a.name, &mut surfaces, &triangles, view);
        // The indices stay: what was paired to quads bends, what faced the eye turns away, what was
        // apart is crossed.
        for strength in [0.01_f32, 0.3] {
            let moved: Vec<Vec<[f32; 3]>> = triangles
                .iter()
                .map(|of| {
                    let bend = |v: f32, by: f32| v + strength * (by * 1.7 + v * 0.3).sin();
                    let bent = |&[x, y, z]: &[f32; 3]| [bend(x, z), bend(y, x), bend(z, y)];
                    of.positions.iter().map(bent).collect()
                })
                .collect();
            let bent: Vec<OccluderTriangles<'_>> = triangles
                .iter()
                .zip(&moved)
                .map(|(of, positions)| OccluderTriangles { positions, ..*of })
                .collect();
            claimed += check_dynamic(&a.name, &mut surfaces, &bent, view);
        }
    }
    println!("{claimed} pixels claimed");
    assert!(claimed > u64::from(cases(20_000).min(20_000)), "{claimed}");
}
