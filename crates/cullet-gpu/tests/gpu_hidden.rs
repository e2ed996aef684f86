//! How much of what is hidden is found, of boxes that are hidden pixel by pixel: by our test, and by the form that others have.

use crate::common;

use cullet::{Instance, Scene, Transform, View};
use cullet_gpu::Tier;
use cullet_testkit::Rng;
use cullet_testkit::meshes::block;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;
use glam::{DMat4, DVec3, DVec4};

use common::stage::{Stage, Way, is_set};
use common::{gpu, texels};

/// Depth of a view, which is standard, reversed.
fn reversed(p: DVec4) -> f64 {
    (p.w - p.z) / p.w
}

/// Whether no pixel of a box lies before what was drawn: exactly, by a ray through each.
fn is_hidden_ref(view: &View, [low, high]: [DVec3; 2], depth: &[f32]) -> bool {
    let clip = DMat4::from_cols_array(&view.clip_from_world());
    let Some([from, to]) = rectangle(view, &corners(low, high)) else { return false };
    let eye = DVec3::from_slice(&view.eye()[..3]);
    let world = DMat4::from_cols_array(&view.world_from_clip());
    let size = view.viewport().map(f64::from);
    let seen_at = |x: u32, y: u32| {
        let ndc = [
            (f64::from(x) + 0.5) / size[0] * 2.0 - 1.0,
            1.0 - (f64::from(y) + 0.5) / size[1] * 2.0,
        ];
        let along = (world.project_point3(DVec3::new(ndc[0], ndc[1], 0.5)) - eye).normalize();
        let (a, b) = ((low - eye) / along, (high - eye) / along);
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        let at = || clip * (eye + along * enter).extend(1.0);
        enter <= leave && reversed(at()) >= f64::from(depth[(y * view.viewport()[0] + x) as usize])
    };
    !(from[1]..to[1]).any(|y| (from[0]..to[0]).any(|x| seen_at(x, y)))
}

fn corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        DVec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high)
    })
}

/// Pixels whose middles lie within the bounds of points on the screen, the last ones not; `None` where one is not before the near plane.
fn rectangle(view: &View, points: &[DVec3]) -> Option<[[u32; 2]; 2]> {
    let clip = DMat4::from_cols_array(&view.clip_from_world());
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for point in points {
        let p = clip * point.extend(1.0);
        if p.w <= 0.0 || reversed(p) >= 1.0 {
            return None;
        }
        for (a, at) in [p.x / p.w, -p.y / p.w].into_iter().enumerate() {
            (low[a], high[a]) = (low[a].min(at), high[a].max(at));
        }
    }
    Some(pixels(view, low, high))
}

fn pixels(view: &View, low: [f64; 2], high: [f64; 2]) -> [[u32; 2]; 2] {
    let at = |a: usize, v: f64| {
        let size = f64::from(view.viewport()[a]);
        ((v * 0.5 + 0.5) * size - 0.5).clamp(-1.0, size)
    };
    let from = [0, 1].map(|a| at(a, low[a]).ceil().max(0.0) as u32);
    let to = [0, 1].map(|a| (at(a, high[a]).floor() + 1.0) as u32);
    [from, [0, 1].map(|a| to[a].min(view.viewport()[a]).max(from[a]))]
}

/// The form of others, as of *niagara* (A. Kapoulkine): the sphere around a box, and two by two texels. After *2D Polyhedral
/// Bounds of a Clipped, Perspective-Projected 3D Sphere* (M. Mara and others, 2013).
fn is_hidden_as_sphere(view: &View, [low, high]: [DVec3; 2], levels: &[Level]) -> bool {
    let clip = DMat4::from_cols_array(&view.clip_from_world());
    let (centre, radius) = ((low + high) / 2.0, (high - low).length() / 2.0);
    let p = clip * centre.extend(1.0);
    let rows = clip.transpose();
    let away = rows.w_axis.truncate();
    if p.w <= radius * away.length() {
        return false;
    }
    let nearest = clip * (centre - away / away.length() * radius).extend(1.0);
    if nearest.w <= 0.0 || reversed(nearest) >= 1.0 {
        return false;
    }
    // Planes through the eye that touch the sphere: (a − t w)² = r² |n − t m|².
    let ends = |value: f64, row: DVec4| {
        let (own, r2) = (row.truncate(), radius * radius);
        let a = p.w * p.w - r2 * away.length_squared();
        let b = value * p.w - r2 * own.dot(away);
        let c = value * value - r2 * own.length_squared();
        let root = (b * b - a * c).max(0.0).sqrt();
        [(b - root) / a, (b + root) / a]
    };
    let (x, y) = (ends(p.x, rows.x_axis), ends(-p.y, -rows.y_axis));
    let [from, to] = pixels(view, [x[0], y[0]], [x[1], y[1]]);
    if from[0] == to[0] || from[1] == to[1] {
        return true;
    }
    let last = to.map(|v| v - 1);
    let fits = |l: &usize| (0..2).all(|a| (last[a] >> l) - (from[a] >> l) < 2);
    let level = (0..levels.len()).find(fits).unwrap();
    let Level { width, depths } = &levels[level];
    let mut texels = [from[1], last[1]]
        .into_iter()
        .flat_map(|y| [from[0], last[0]].map(|x| (y >> level) * width + (x >> level)));
    texels.all(|i| reversed(nearest) < f64::from(depths[i as usize]))
}

/// The picture, or a level above it.
struct Level {
    width: u32,
    depths: Vec<f32>,
}

/// A city with boxes among its buildings, of a size.
fn with_boxes(size: f64) -> Scene {
    let mut scene = city(40, 1, 0);
    let mut rng = Rng(21);
    let mesh = scene.add_mesh(block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]));
    for _ in 0..12_000 {
        let scale = [(); 3].map(|()| (size * rng.range(0.2, 1.0)) as f32);
        let at = [rng.range(-480.0, 480.0), rng.range(0.0, 3.0), rng.range(-480.0, 480.0)];
        scene.add(Instance::new(mesh, Transform::from_scale_translation(scale, at))).unwrap();
    }
    scene.commit(&cullet::Culler::default());
    scene
}

/// Percent of what is hidden that is found: by the device, and by spheres.
fn found(scene: &Scene, size: [u32; 2]) -> Option<[f64; 2]> {
    let gpu = gpu(Tier::Pyramid)?;
    let mut stage = Stage::new(gpu, scene, size);
    let mut rng = Rng(22);
    let (mut hidden, mut by_us, mut by_spheres) = (0, 0, 0);
    for _ in 0..12 {
        // From streets.
        let street = (f64::from(rng.below(30) as u32) - 15.0) * 24.0;
        let eye = [street, rng.range(2.0, 6.0), rng.range(-350.0, 350.0)];
        let ahead =
            [0, 1, 2].map(|a| eye[a] + [rng.signed() * 100.0, 0.0, rng.signed() * 100.0][a]);
        let view = look(eye, ahead, size);
        // The second time all that is visible is early, and the depth complete.
        stage.draw(scene, &view, Way::TwoPhases);
        let frame = stage.draw(scene, &view, Way::TwoPhases);
        let in_view = stage.bits(stage.all.culling.in_view());
        let visible = stage.bits(stage.all.culling.visible());
        let pyramid = &stage.all.pyramid;
        let above = (0..).zip(pyramid.sizes()).map(|(level, of)| Level {
            width: of[0],
            depths: texels(gpu, pyramid.texture(), level, *of),
        });
        let picture = Level { width: size[0], depths: frame.depth };
        let levels: Vec<Level> = [picture].into_iter().chain(above).collect();
        for slot in scene.slots().filter(|slot| is_set(&in_view, *slot)) {
            let bounds = scene.bounds(slot);
            let origin = DVec3::from(scene.origin());
            let own = [bounds.min, bounds.max].map(|v| DVec3::from(v.map(f64::from)) + origin);
            let is_hidden = is_hidden_ref(&view, own, &levels[0].depths);
            let sphere = is_hidden_as_sphere(&view, own, &levels);
            assert!(is_hidden || !sphere, "{own:?}: the sphere holds the box");
            assert!(is_hidden || is_set(&visible, slot), "{own:?} is visible");
            hidden += u32::from(is_hidden);
            by_us += u32::from(is_hidden && !is_set(&visible, slot));
            by_spheres += u32::from(sphere);
        }
    }
    assert!(hidden > 10_000, "{hidden}");
    let percent = |of: u32| 100.0 * f64::from(of) / f64::from(hidden);
    println!("{hidden} hidden: {:.2} %, by spheres {:.2} %", percent(by_us), percent(by_spheres));
    Some([percent(by_us), percent(by_spheres)])
}

#[test]
fn nearly_all_small_boxes_that_are_hidden_are_found() {
    let Some([ours, spheres]) = found(&with_boxes(1.0), [1280, 720]) else { return };
    assert!(ours >= 99.5 && spheres < ours, "{ours} % against {spheres} %");
}

#[test]
fn nearly_all_large_boxes_that_are_hidden_are_found() {
    let Some([ours, spheres]) = found(&with_boxes(6.0), [1333, 751]) else { return };
    assert!(ours >= 98.5 && spheres < ours, "{ours} % against {spheres} %");
}
