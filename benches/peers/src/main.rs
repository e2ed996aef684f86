//! cullet's frustum culling beside that of Bevy, over 1e5 distinct boxes, index list out:
//! `cargo run --release` in this folder.
//!
//! Both take the same boxes and the same view in turns, each pass timed, the fastest kept. Answers are
//! compared: Bevy tests in f32 without an error bound, so a few boxes on a border may differ.
#![forbid(unsafe_code)]

use std::hint::black_box;
use std::time::{Duration, Instant};

use bevy_camera::primitives::{Aabb as BevyAabb, Frustum as BevyFrustum, Sphere as BevySphere};
use bevy_math::{Affine3A, Mat4, Vec3};
use bevy_shape::ViewFrustum;
use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::{Camera, Depth, Level, Projection, View};

const ITEMS: usize = 100_000;
const SECONDS: f64 = 2.0;

fn main() {
    let boxes = random_boxes();
    let batch = Boxes::from_slice(&boxes);
    let theirs: Vec<BevyAabb> = boxes
        .iter()
        .map(|b| BevyAabb::from_min_max(Vec3::from(b.min), Vec3::from(b.max)))
        .collect();
    println!("{ITEMS} boxes; ns a box, and how many times cullet's");
    println!("visible  cullet  intersects_obb      sphere, then obb    intersects_obb_identity");
    for back in [-550.0, 650.0, 1450.0] {
        let view = view(back);
        // Bevy's matrices are reversed and its far plane is a half-space of its own.
        let matrix = view.clip_from_world().map(|v| v as f32);
        let bevy = BevyFrustum(ViewFrustum::from_clip_from_world(&Mat4::from_cols_array(&matrix)));
        let planes = Planes::new(&view.frustum());
        let mut ours = Indices::new();
        let mut lists = [Vec::new(), Vec::new(), Vec::new()];
        let mut best = [Duration::MAX; 4];
        let begin = Instant::now();
        while begin.elapsed().as_secs_f64() < SECONDS {
            best[0] = best[0].min(time(|| cull_boxes(Level::new(), &planes, &batch, &mut ours)));
            let at = black_box(Affine3A::IDENTITY);
            best[1] = best[1].min(time(|| {
                list(&theirs, &mut lists[0], |b| bevy.intersects_obb(b, &at, true, true));
            }));
            // What Bevy's check_visibility does for each entity.
            best[2] = best[2].min(time(|| {
                list(&theirs, &mut lists[1], |b| {
                    let center = at.transform_point3a(b.center);
                    let sphere = BevySphere { center, radius: b.half_extents.length() };
                    bevy.intersects_sphere(&sphere, true) && bevy.intersects_obb(b, &at, true, true)
                });
            }));
            best[3] = best[3].min(time(|| {
                list(&theirs, &mut lists[2], |b| bevy.intersects_obb_identity(b));
            }));
        }
        let differ = lists[0].len().abs_diff(ours.len());
        assert!(differ < ITEMS / 1000, "{} visible here, {} there", ours.len(), lists[0].len());
        let [a, b, c, d] = best.map(|t| t.as_nanos() as f64 / ITEMS as f64);
        println!(
            "{:5.1} %  {a:6.3}  {b:6.2} ({:5.1} x)     {c:6.2} ({:5.1} x)     {d:6.2} ({:5.1} x)",
            ours.len() as f64 * 100.0 / ITEMS as f64,
            b / a,
            c / a,
            d / a
        );
    }
}

fn time(run: impl FnOnce()) -> Duration {
    let start = Instant::now();
    run();
    start.elapsed()
}

fn list(boxes: &[BevyAabb], visible: &mut Vec<u32>, sees: impl Fn(&BevyAabb) -> bool) {
    visible.clear();
    visible.extend((0..).zip(boxes).filter(|(_, b)| sees(b)).map(|(i, _)| i));
    black_box(&visible);
}

fn view(back: f64) -> View {
    let along = [0.6, -0.3, -0.742];
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: 1e4 };
    let camera =
        Camera { eye: along.map(|v| -v * back), direction: along, up: [0.0, 1.0, 0.0], projection };
    View::new(&camera, Depth::Reversed, [1280, 800]).expect("a plain perspective")
}

fn random_boxes() -> Vec<Aabb> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut one = || {
        let min: [f32; 3] = std::array::from_fn(|_| next() * 2000.0 - 1000.0);
        Aabb::new(min, min.map(|v| v + next() * 10.0))
    };
    (0..ITEMS).map(|_| one()).collect()
}
