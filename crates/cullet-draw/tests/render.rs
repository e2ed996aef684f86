//! The renderer against its slow twin, and against what must be so.

use cullet::{
    Camera, Depth, Instance, InstanceFlags, Projection, Scene, Transform, View, Visible,
    draw::TriangleRange,
};
use cullet_draw::{Frame, PixelId, RenderOptions, Selection, render, render_ref};
use cullet_testkit::scenes::{city, elsewhere, mixed_scene};
use cullet_testkit::views::{look, mixed_view};
use cullet_testkit::{Rng, meshes, soups};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(300), ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_its_slow_twin(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let mut scene = mixed_scene(&mut rng);
        let size = [1 + rng.below(90) as u32, 1 + rng.below(70) as u32];
        let mut view = mixed_view(&mut rng, size);
        if rng.chance(0.3) {
            view = elsewhere(&mut scene, &view, &mut rng);
        }
        let jitter = if rng.chance(0.5) { [0.5; 2] } else { [rng.unit(), rng.unit()] };
        let options = RenderOptions {
            jitter,
            count_layers: rng.chance(0.3),
            threads: rng.index(3),
            ..RenderOptions::default()
        };
        let slow = render_ref(&scene, &view, Selection::All, &options);
        prop_assert!(render(&scene, &view, Selection::All, &options) == slow);
        let some = some_of(&scene, &mut rng);
        let slow = render_ref(&scene, &view, Selection::Visible(&some), &options);
        prop_assert!(render(&scene, &view, Selection::Visible(&some), &options) == slow);
    }
}

/// Some triangles of some instances, as a culler would list them.
fn some_of(scene: &Scene, rng: &mut Rng) -> Visible {
    let mut visible = Visible::default();
    for slot in scene.slots() {
        let first = visible.triangles.len() as u32;
        let all = 0..scene.mesh(slot).triangle_count();
        visible.triangles.extend(all.filter(|_| rng.chance(0.6)));
        let count = visible.triangles.len() as u32 - first;
        if count > 0 {
            visible.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
        }
    }
    visible
}

fn one(mesh: cullet::Mesh) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    scene
}

/// Looks down −Z at the square from −1 to 1.
fn flat_view(viewport: [u32; 2], depth: Depth) -> View {
    let projection = Projection::Orthographic {
        left: -1.0,
        right: 1.0,
        bottom: -1.0,
        top: 1.0,
        near: 0.0,
        far: 2.0,
    };
    let camera = Camera {
        eye: [0.0, 0.0, 1.0],
        direction: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        projection,
    };
    View::new(&camera, depth, viewport).unwrap()
}

fn counted(scene: &Scene, view: &View) -> Frame {
    let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
    render(scene, view, Selection::All, &options)
}

#[test]
fn a_grid_whose_edges_meet_samples_covers_each_pixel_once() {
    // Vertices on pixel centres and diagonals through them: every kind of tie.
    for n in [4u32, 8, 16] {
        let at = |v: u32| v as f32 / n as f32 * 2.0 - 1.0;
        let positions =
            (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y), 0.0])).collect::<Vec<_>>();
        let mut indices = Vec::new();
        for y in 0..n {
            for x in 0..n {
                let [a, b, c, d] =
                    [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| y * (n + 1) + x);
                let quad = if (x + y) % 2 == 0 { [a, b, c, a, c, d] } else { [a, b, d, b, d, c] };
                indices.extend(quad);
            }
        }
        let scene = one(meshes::of_parts((positions, indices), Vec::new()));
        for (size, jitter) in [(16, 0.5), (32, 0.0), (48, 0.5), (32, 1.0)] {
            let options = RenderOptions {
                count_layers: true,
                jitter: [jitter; 2],
                ..RenderOptions::default()
            };
            let view = flat_view([size; 2], Depth::Reversed);
            let frame = render(&scene, &view, Selection::All, &options);
            for y in 0..size {
                for x in 0..size {
                    // The grid's own right and bottom edges are no left or top ones, so they own none
                    // of the samples on them.
                    let beyond = jitter == 1.0 && (x + 1 == size || y + 1 == size);
                    let n = frame.layers[(y * size + x) as usize];
                    assert_eq!(n, u32::from(!beyond), "at {x}, {y} of {size} at {jitter}");
                }
            }
        }
    }
}

#[test]
fn fans_cover_each_pixel_once_from_any_eye() {
    let mut rng = Rng(3);
    for _ in 0..60 {
        // A closed fan in a plane: every sample that it covers is covered just once.
        let sides = 3 + rng.below(40) as u32;
        let centre = [rng.range(-0.5, 0.5) as f32, 0.0, rng.range(-0.5, 0.5) as f32];
        let mut positions = vec![centre];
        for k in 0..sides {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
            positions.push([(4.0 * c) as f32, 0.0, (4.0 * s) as f32]);
        }
        let indices = (0..sides).flat_map(|k| [0, 1 + k, 1 + (k + 1) % sides]).collect();
        let scene = one(meshes::of_parts((positions, indices), Vec::new()));
        // Near enough that much of it is beside and behind the eye.
        let eye = [rng.range(-1.0, 1.0), rng.range(0.1, 1.5), rng.range(-1.0, 1.0)];
        let view = look(eye, [rng.range(-2.0, 2.0), 0.0, 1.0], [80, 60]);
        let frame = counted(&scene, &view);
        assert!(frame.stats.max_layers <= 1, "{:?}", frame.stats);
        assert!(frame.stats.covered_pixels > 500);
    }
}

#[test]
fn a_closed_surface_around_the_eye_covers_each_pixel_once() {
    let mut scene = one(meshes::one_sided(soups::ball(17, 23)));
    scene.edit_meshes(|_, m| m.set_two_sided(true));
    let projection =
        Projection::Perspective { fov_y_radians: 2.6, aspect: 1.0, near: 1e-3, far: f64::INFINITY };
    let mut rng = Rng(11);
    for depth in [Depth::Standard, Depth::Reversed] {
        for _ in 0..8 {
            let mut at = || rng.range(-0.4, 0.4);
            let camera = Camera::look_at([at(), at(), at()], [at(), at(), at()], projection);
            let frame = counted(&scene, &View::new(&camera, depth, [128, 96]).unwrap());
            assert!(frame.layers.iter().all(|&n| n == 1));
        }
    }
}

#[test]
fn a_solid_shows_its_front_alone_under_any_mirror() {
    let view = look([3.0, 2.0, 4.0], [0.0; 3], [64, 64]);
    for (scale, front_is_near) in
        [([1.0, 1.0, 1.0], true), ([-1.0, 1.0, 1.0], true), ([1.0, -1.0, -1.0], true)]
    {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
        let t = Transform::from_scale_translation(scale, [0.0; 3]);
        let handle = scene.add(Instance::new(mesh, t)).unwrap();
        let one_sided = counted(&scene, &view);
        scene
            .set_flags(handle, InstanceFlags { double_sided: true, ..InstanceFlags::default() })
            .unwrap();
        let both = counted(&scene, &view);
        assert_eq!(one_sided.ids == both.ids, front_is_near);
        assert_eq!(one_sided.stats.max_layers, 1);
        assert_eq!(both.stats.max_layers, 2);
        assert_eq!(both.stats.fragments, 2 * one_sided.stats.fragments);
    }
}

#[test]
fn ties_go_to_the_lowest_slot_and_triangle() {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    // The same triangle thrice, started elsewhere and wound the other way.
    let mut scene = one(meshes::of_parts((positions, vec![1, 2, 0, 0, 1, 2, 2, 1, 0]), Vec::new()));
    scene.add(Instance::new(0, Transform::IDENTITY)).unwrap();
    for depth in [Depth::Standard, Depth::Reversed] {
        let frame =
            render(&scene, &flat_view([9, 9], depth), Selection::All, &RenderOptions::default());
        assert_eq!(frame.visible(), [PixelId { slot: 0, triangle: 0 }]);
    }
}

#[test]
fn blended_instances_hide_nothing_and_are_seen_in_front() {
    let square = |z: f32| {
        let p = vec![[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]];
        meshes::of_parts((p, vec![0, 1, 2]), Vec::new())
    };
    let mut scene = Scene::new();
    for z in [0.5, 0.0, -0.5] {
        let mesh = scene.add_mesh(square(z));
        scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    }
    let glass = InstanceFlags { transparent: true, ..InstanceFlags::default() };
    for slot in [0, 2] {
        let handle = scene.handle(slot).unwrap();
        scene.set_flags(handle, glass).unwrap();
    }
    let frame = counted(&scene, &flat_view([8, 8], Depth::Standard));
    // The near pane passes, the wall owns the pixels, the pane behind the wall is not seen.
    assert_eq!(frame.blended, [PixelId { slot: 0, triangle: 0 }]);
    assert!(frame.ids.iter().all(|id| id.slot == 1));
    assert_eq!(frame.stats.max_layers, 3);
}

#[test]
fn nothing_at_all_makes_an_empty_frame() {
    let view = flat_view([5, 3], Depth::Reversed);
    for scene in [Scene::new(), one(meshes::of_parts(Default::default(), Vec::new()))] {
        let frame = counted(&scene, &view);
        assert_eq!(frame.ids, vec![PixelId::NONE; 15]);
        assert_eq!(frame.depth, vec![0.0; 15]);
        assert!(frame.visible().is_empty());
    }
}

#[test]
fn a_broken_selection_is_skipped() {
    let scene = one(meshes::block([-1.0; 3], [1.0; 3]));
    let visible = Visible {
        triangle_ranges: vec![
            TriangleRange { slot: 9, level: 0, first: 0, count: 2 },
            TriangleRange { slot: 0, level: 0, first: 0, count: 50 },
            TriangleRange { slot: 0, level: 0, first: 77, count: 5 },
        ],
        triangles: vec![3, 99, u32::MAX, 0, 3],
        ..Visible::default()
    };
    let view = look([3.0, 2.0, 4.0], [0.0; 3], [32, 32]);
    let o = RenderOptions::default();
    let frame = render(&scene, &view, Selection::Visible(&visible), &o);
    let slow = render_ref(&scene, &view, Selection::Visible(&visible), &o);
    // Not assert_eq: a frame is too long to read.
    assert!(frame == slow, "{:?} owned, {:?} by the twin", frame.visible(), slow.visible());
}

#[test]
fn threads_and_batches_leave_a_city_the_same() {
    let scene = city(24, 3, 3000);
    let view = look([3.0, 30.0, 200.0], [0.0, 5.0, 0.0], [333, 187]);
    let frame = |threads, count_layers| {
        let options = RenderOptions { threads, count_layers, ..RenderOptions::default() };
        render(&scene, &view, Selection::All, &options)
    };
    let first = frame(1, false);
    assert!(first.visible().len() > 1000);
    assert!(frame(3, false) == first);
    // Counting layers turns off all rejects behind what is drawn.
    let counted = frame(2, true);
    assert!(counted.ids == first.ids && counted.depth == first.depth);
    assert!(counted.stats.max_layers > 5);
}

/// The nearest triangle on the line of sight of a pixel (Möller & Trumbore, *Fast, Minimum Storage
/// Ray/Triangle Intersection*, 1997), drawn from the front alone where it is one-sided.
fn hit(scene: &Scene, eye: [f64; 3], direction: [f64; 3], near: f64) -> Option<u32> {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let mut best = (f64::INFINITY, None);
    for slot in scene.slots() {
        let (mesh, t) = (scene.mesh(slot), scene.transform(slot));
        for triangle in 0..mesh.triangle_count() {
            let [a, b, c] = mesh.corners(triangle).map(|p| {
                std::array::from_fn::<f64, 3, _>(|r| {
                    (0..3).map(|k| f64::from(t.linear[k][r]) * f64::from(p[k])).sum::<f64>()
                        + t.translation[r]
                })
            });
            let (u, v) = (sub(b, a), sub(c, a));
            let p = cross(direction, v);
            let determinant = dot(u, p);
            if determinant == 0.0 || (determinant < 0.0 && !mesh.parts()[0].two_sided) {
                continue;
            }
            let s = sub(eye, a);
            let q = cross(s, u);
            let (x, y) = (dot(s, p) / determinant, dot(direction, q) / determinant);
            let distance = dot(v, q) / determinant;
            if x >= 0.0 && y >= 0.0 && x + y <= 1.0 && distance > near && distance < best.0 {
                best = (distance, Some(slot));
            }
        }
    }
    best.1
}

#[test]
fn owners_are_what_rays_meet() {
    // Shares no arithmetic with the renderer: a turned matrix or a wrong winding would show.
    let scene = city(5, 1, 40);
    let (eye, target) = ([-13.0, 9.0, 71.0], [4.0, 2.0, 0.0]);
    let size = [64u32, 36];
    let frame = render(&scene, &look(eye, target, size), Selection::All, &RenderOptions::default());
    let unit = |v: [f64; 3]| v.map(|c| c / v.iter().map(|c| c * c).sum::<f64>().sqrt());
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let forward = unit(std::array::from_fn(|a| target[a] - eye[a]));
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let up = cross(right, forward);
    let tangent = 30f64.to_radians().tan();
    let mut apart = 0;
    for y in 0..size[1] {
        for x in 0..size[0] {
            let (w, h) = (f64::from(size[0]), f64::from(size[1]));
            let u = ((f64::from(x) + 0.5) / w * 2.0 - 1.0) * tangent * w / h;
            let v = (1.0 - (f64::from(y) + 0.5) / h * 2.0) * tangent;
            let direction = std::array::from_fn(|a| forward[a] + right[a] * u + up[a] * v);
            let slot = hit(&scene, eye, direction, 0.5).unwrap_or(u32::MAX);
            apart += u32::from(slot != frame.id(x, y).slot);
        }
    }
    assert!(frame.stats.covered_pixels > 1300);
    assert!(apart <= 2, "{apart} pixels differ");
}
