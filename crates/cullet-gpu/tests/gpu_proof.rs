//! Scenes, sizes, modes and views of every kind, each with each: pictures are those without occlusion culling, and what owns a pixel is
//! in the list.

use crate::common;

use cullet::bounds::Aabb;
use cullet::{Camera, Depth, Projection, Scene, View};
use cullet_gpu::{DrawMode, Phase, Tier};
use cullet_io::Model;
use cullet_scenes::paths::{Overrides, PathSpec, views};
use cullet_testkit::views::look;

use common::gpu;
use common::stage::{Stage, Way, assert_same};

/// Small ones of the built-in scenes, the paths that suit them, and where they are moved to.
const SCENES: [(&str, PathSpec, f64); 8] = [
    ("city:cells=10,objects=300,sub=2", PathSpec::Walk, 0.0),
    ("city:cells=10,objects=300,ground=0", PathSpec::Orbit, 1e7),
    ("solids:n=40", PathSpec::Orbit, 0.0),
    ("office:rooms=3,corridors=1", PathSpec::Walk, 0.0),
    ("plant:bays=2,floors=2,pipes=2,kinds=3", PathSpec::Walk, -1e7),
    ("forest:n=3000", PathSpec::Fly, 0.0),
    ("moving:n=40,t=700", PathSpec::Walk, 0.0),
    ("knobs:n=10", PathSpec::Orbit, 0.0),
];

/// From one to the next everything is another: what was seen before says nothing.
const SIZES: [[u32; 2]; 12] = [
    [333, 187],
    [1, 1],
    [1333, 751],
    [1, 7],
    [447, 319],
    [3, 2],
    [1024, 16],
    [17, 31],
    [256, 128],
    [64, 64],
    [641, 361],
    [31, 500],
];

/// Boxes of a scene's instances in the world, of those that have one.
fn boxes(scene: &Scene) -> Vec<[[f64; 3]; 2]> {
    let origin = scene.origin();
    let of = |slot| scene.bounds(slot);
    let moved = |end: [f32; 3]| std::array::from_fn(|a| f64::from(end[a]) + origin[a]);
    let has_box = |b: &Aabb| b.is_finite() && !b.is_empty();
    scene.slots().map(of).filter(has_box).map(|b| [moved(b.min), moved(b.max)]).collect()
}

/// A view moved as a whole, whatever its kind.
fn moved(view: &View, by: f64) -> View {
    let mut m = view.clip_from_world();
    for row in 0..4 {
        m[12 + row] -= (0..3).map(|column| m[column * 4 + row] * by).sum::<f64>();
    }
    View::from_matrix(m, view.depth(), view.viewport()).unwrap()
}

fn mirrored(view: &View) -> View {
    let mut m = view.clip_from_world();
    (0..4).for_each(|column| m[column * 4] = -m[column * 4]);
    View::from_matrix(m, view.depth(), view.viewport()).unwrap()
}

/// Views of a scene of every kind, one far from the next: along its path, mirrored, along parallel lines, with the near plane through a
/// box, from within a box, and away from everything.
fn views_of(model: &Model, path: &PathSpec, size: [u32; 2]) -> Vec<View> {
    let along = views(model, path, 4, size, &Overrides::default()).unwrap();
    let all = boxes(&model.scene);
    let middle = |[low, high]: &[[f64; 3]; 2]| std::array::from_fn(|a| (low[a] + high[a]) / 2.0);
    let length = |[low, high]: &[[f64; 3]; 2]| {
        (0..3).map(|a| (high[a] - low[a]).powi(2)).sum::<f64>().sqrt()
    };
    let join = |a: [[f64; 3]; 2], b: &[[f64; 3]; 2]| {
        [0, 1].map(|end| {
            std::array::from_fn(
                |i| if end == 0 { a[0][i].min(b[0][i]) } else { a[1][i].max(b[1][i]) },
            )
        })
    };
    let whole = all.iter().fold(all[0], join);
    let largest = all.iter().max_by(|a, b| length(a).total_cmp(&length(b))).unwrap();
    let (centre, reach) = (middle(&whole), length(&whole) / 2.0);
    let parallel = |depth, near| {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let projection = Projection::Orthographic {
            left: -reach * aspect * 0.4,
            right: reach * aspect * 0.4,
            bottom: -reach * 0.4,
            top: reach * 0.4,
            near,
            far: reach * 4.0,
        };
        let eye = [centre[0] + reach, centre[1] + reach * 0.7, centre[2] + reach * 0.3];
        View::new(&Camera::look_at(eye, centre, projection), depth, size).unwrap()
    };
    let corner = all[all.len() / 2][1];
    let away = std::array::from_fn(|a| centre[a] + reach * 10.0);
    let further = std::array::from_fn(|a| away[a] + reach);
    vec![
        along[0].clone(),
        parallel(Depth::Reversed, 0.0),
        along[2].clone(),
        look(corner, centre, size),
        mirrored(&along[1]),
        look(middle(largest), corner, size),
        along[3].clone(),
        look(away, further, size),
        mirrored(&parallel(Depth::Standard, reach)),
        along[1].clone(),
    ]
}

#[test]
fn every_scene_at_every_size_in_every_mode_is_drawn_as_without_culling() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let (mut drawn, mut in_view, mut late, mut ties, mut pixels) = (0, 0, 0, 0, 0);
    for (name, path, by) in SCENES {
        let (still, mut model) =
            (cullet_scenes::build(name).unwrap(), cullet_scenes::build(name).unwrap());
        for slot in 0..model.scene.slot_count() {
            let (Some(handle), true) = (model.scene.handle(slot), by != 0.0) else { continue };
            let mut t = *model.scene.transform(slot);
            t.translation = t.translation.map(|v| v + by);
            model.scene.set_transform(handle, t).unwrap();
        }
        model.scene.commit(&cullet::Culler::default());
        let scene = &model.scene;
        let modes = [DrawMode::Each, DrawMode::Multi, DrawMode::Clusters, DrawMode::Counted];
        let modes = modes.into_iter().filter(|mode| mode.is_offered(&gpu.device));
        // Each goes on from size to size.
        let stage = |mode| Stage::with_mode(gpu, scene, SIZES[0], mode);
        let mut stages: Vec<_> = modes.map(stage).collect();
        let mut reference = stage(DrawMode::Each);
        for (number, size) in SIZES.into_iter().enumerate() {
            let all = views_of(&still, &path, size);
            // Large ones take most of the time.
            for step in 0..if size[0] * size[1] > 1 << 18 { 1 } else { 3 } {
                let which = (number * 3 + step) % all.len();
                let view = &moved(&all[which], by);
                let expected = reference.draw(scene, view, Way::All);
                let own = expected.ids.iter().filter(|id| **id > 0).count();
                for stage in &mut stages {
                    let what = format!("{name}, {size:?}, view {which}, {:?}", stage.mode());
                    // The first frame after a jump, and the second.
                    for (frame, way) in
                        [Way::TwoPhases, Way::TwoPhases, Way::Cpu].iter().enumerate()
                    {
                        let found = stage.draw(scene, view, *way);
                        ties += assert_same(stage, &expected, &found, &what);
                        pixels += own;
                        let in_phase = [Phase::Early, Phase::Late].map(|phase| stage.drawn(phase));
                        late += in_phase[1] * u32::from(frame == 0);
                        let is_city = name.starts_with("city") && size[0] > 300;
                        if frame == 1 && is_city && stage.mode() == DrawMode::Each {
                            drawn += in_phase[0] + in_phase[1];
                            in_view += reference.drawn(Phase::Late);
                        }
                    }
                }
            }
        }
    }
    println!("{drawn} drawn of {in_view}, {late} late; {ties} ties of {pixels} pixels");
    assert!(late > 0 && drawn * 4 < in_view * 3, "{drawn} drawn of {in_view}, {late} late");
    // Of two that are equally near, the one that was drawn first is seen.
    assert!(pixels > 10_000_000 && ties * 100 < pixels, "{ties} of {pixels}");
}
