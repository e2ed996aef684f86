//! Measurement of the costs: the fastest of many rounds, and slopes instead of times.

use cullet_command::stored_costs::{Spread, Stored};
use std::hint::black_box;
use std::time::Instant;

use crate::methods::Bulk;
use crate::methods::cluster::{Bound, ClusterBounds};
use cullet::cull::Indices;
use cullet::cull::backface::Planes8;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::cull::frustum::batch;
use cullet::mesh::{Alpha, Part};
use cullet::{Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Transform, View};
use cullet_command::console::interrupted;
use cullet_draw::{RenderOptions, Selection, render};

use crate::bench::world::{camera_over, planes_of, random_boxes};
use crate::shapes::bumpy_ball;

/// A round of a test takes so long.
const ROUND_SECONDS: f64 = 0.01;

/// Boxes and triangles in a batch; clusters are fewer, as in a scene.
const ITEMS: usize = 100_000;
const CLUSTERS: usize = 16_384;
/// Clusters that are fitted; the others repeat them.
const DISTINCT: usize = 256;
/// Triangles of a cluster.
const CLUSTER: usize = 64;

/// Pixels along the sides of the picture.
const SIDE: u32 = 512;
/// Instances along the sides of the sheet that is drawn.
const PATCHES: u32 = 8;
/// Quads along the side of an instance: the sheet grows from 8,192 to 131,072 triangles and keeps
/// its pixels, so the slope of time over triangles holds none of them.
const QUADS: [u32; 4] = [8, 16, 24, 32];
/// Instances along the sides of a sheet that keeps its 32,768 triangles. No instance is more than
/// one of the renderer's blocks of 256 triangles.
const SPLITS: [u32; 3] = [16, 64, 128];
/// Quads along the side of that sheet.
const SPLIT_QUADS: u32 = 128;

/// Times of one round, in nanoseconds.
struct Round {
    /// An item of each test.
    tests: [f64; 3],
    /// A frame of each scene of each series.
    frames: Vec<Vec<f64>>,
}

/// Scenes that fill the same pixels and differ in one count, whose cost is wanted.
struct Series {
    scenes: Vec<Scene>,
    counts: Vec<f64>,
}

impl Series {
    fn new(scenes: impl IntoIterator<Item = Scene>, count: fn(&Scene) -> f64) -> Self {
        let scenes: Vec<Scene> = scenes.into_iter().collect();
        let counts = scenes.iter().map(count).collect();
        Self { scenes, counts }
    }
}

/// Measures every cost of
/// [`MeasuredCosts::named`](cullet_command::measured_costs::MeasuredCosts::named) in so many
/// rounds; `step` is called after each. Where a cost comes out as one that cannot be, the machine
/// was busy, and rounds are added up to four times as many, or 24. `None` where the user stopped
/// it.
pub(super) fn measure(rounds: u32, mut step: impl FnMut()) -> Option<Stored> {
    let mut tests = Tests::new();
    let view = sheet_view();
    let by_triangles = |alpha, side| {
        let scenes = QUADS.map(|quads| sheet(PATCHES, quads, alpha, side));
        Series::new(scenes, |s| s.triangle_count() as f64)
    };
    let splits = SPLITS.map(|n| sheet(n, SPLIT_QUADS / n, Alpha::Opaque, Seen::Front));
    let series = [
        by_triangles(Alpha::Opaque, Seen::Away),
        by_triangles(Alpha::Opaque, Seen::Front),
        by_triangles(Alpha::Masked, Seen::Front),
        by_triangles(Alpha::Blended, Seen::Front),
        Series::new(splits, |s| f64::from(s.instance_count())),
    ];
    let mut done = Vec::new();
    // The first round warms caches and clocks, and does not count.
    let most = rounds.saturating_mul(4).max(24);
    let mut round = 0;
    loop {
        if interrupted() {
            return None;
        }
        let frames = |s: &Series| s.scenes.iter().map(|scene| frame_ns(scene, &view)).collect();
        let now = Round { tests: tests.round(), frames: series.iter().map(frames).collect() };
        if round > 0 {
            done.push(now);
        }
        step();
        if round >= rounds {
            let stored = Stored::now(spreads(&done, &series), round);
            if round >= most || stored.costs().check().is_ok() {
                return Some(stored);
            }
        }
        round += 1;
    }
}

/// The costs by all rounds, and how far each third of them is from that. Of every time the fastest
/// counts: what disturbs a machine only ever adds.
fn spreads(rounds: &[Round], series: &[Series; 5]) -> [Spread; 8] {
    let all = figures(rounds, series);
    let thirds: Vec<_> = rounds.chunks(rounds.len().div_ceil(3).max(1)).collect();
    let thirds: Vec<[f64; 8]> = thirds.iter().map(|third| figures(third, series)).collect();
    std::array::from_fn(|i| {
        let ns = all[i];
        let values = || thirds.iter().map(|t| t[i]);
        Spread { ns, low: values().fold(ns, f64::min), high: values().fold(ns, f64::max) }
    })
}

fn figures(rounds: &[Round], series: &[Series; 5]) -> [f64; 8] {
    let fastest =
        |time: &dyn Fn(&Round) -> f64| rounds.iter().map(time).fold(f64::INFINITY, f64::min);
    std::array::from_fn(|i| match i.checked_sub(3) {
        None => fastest(&|r| r.tests[i]),
        Some(of) => {
            let counts = series[of].counts.iter().enumerate();
            let points = counts.map(|(scene, &n)| [n, fastest(&|r| r.frames[of][scene])]);
            slope(&points.collect::<Vec<_>>())
        }
    })
}

/// Data of the tests in batches.
struct Tests {
    boxes: cullet::bounds::Boxes,
    frustum: batch::Planes,
    cones: ClusterBounds<EllipticCone>,
    planes: Planes8,
    kept: Indices,
    culled: Vec<u64>,
}

impl Tests {
    fn new() -> Self {
        let boxes = random_boxes(ITEMS);
        let frustum = planes_of(&camera_over(30, &boxes));
        let (positions, indices) = bumpy_ball(DISTINCT * CLUSTER);
        let cones: Vec<Option<EllipticCone>> = indices
            .chunks(CLUSTER * 3)
            .map(|c| {
                let corners = c.as_chunks::<3>().0.iter();
                let corners = corners.map(|t| t.map(|v| positions[v as usize]));
                EllipticCone::fit(&ClusterPlanes::new(corners))
            })
            .collect();
        let cones = cones.into_iter().cycle().take(CLUSTERS).collect();
        let (positions, indices) = bumpy_ball(ITEMS);
        let planes = Planes8::new(&positions, &indices);
        Self { boxes, frustum, cones, planes, kept: Indices::new(), culled: Vec::new() }
    }

    /// Nanoseconds an item of the frustum test, of the cones and of the planes, at the best level.
    fn round(&mut self) -> [f64; 3] {
        let level = cullet_command::machine::levels()[0].1;
        // Three radii from the middle, where about half of all faces away.
        let eye = [1.8, -0.9, 2.226, 1.0];
        let Self { boxes, frustum, cones, planes, kept, culled } = self;
        [
            per_item(ITEMS, || batch::cull_boxes(level, frustum, boxes, kept)),
            per_item(CLUSTERS, || cones.cull(level, eye, culled)),
            per_item(ITEMS, || planes.keep(level, eye, kept)),
        ]
    }
}

/// Nanoseconds an item of passes over `items`, the fastest of a round.
fn per_item(items: usize, mut pass: impl FnMut()) -> f64 {
    // So many passes that reading the clock costs nothing beside them.
    const PASSES: u32 = 16;
    let begin = Instant::now();
    let mut fastest = f64::INFINITY;
    while begin.elapsed().as_secs_f64() < ROUND_SECONDS {
        let start = Instant::now();
        (0..PASSES).for_each(|_| pass());
        fastest = fastest.min(start.elapsed().as_secs_f64());
    }
    fastest * 1e9 / (f64::from(PASSES) * items as f64)
}

/// Nanoseconds of drawing a scene once.
fn frame_ns(scene: &Scene, view: &View) -> f64 {
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    let start = Instant::now();
    black_box(render(scene, view, Selection::All, &options));
    start.elapsed().as_secs_f64() * 1e9
}

/// The slope of the line of least squares through points (x, y) with at least two distinct x.
fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let [mx, my] = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
    let (mut xy, mut xx) = (0.0, 0.0);
    for [x, y] in points {
        xy += (x - mx) * (y - my);
        xx += (x - mx) * (x - mx);
    }
    xy / xx
}

/// Side of the sheet that the viewer sees.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Front,
    /// The back of what has only a front.
    Away,
}

/// A flat sheet from −1 to 1, cut into `patches`² instances of one mesh of `quads`² quads. One
/// mesh, so that what the renderer prepares once a mesh is not counted once an instance.
fn sheet(patches: u32, quads: u32, alpha: Alpha, side: Seen) -> Scene {
    let width = 2.0 / f64::from(patches);
    let step = width / f64::from(quads);
    let at = |i: u32| (f64::from(i) * step) as f32;
    let corners = (0..=quads).flat_map(|y| (0..=quads).map(move |x| (x, y)));
    let positions: Vec<[f32; 3]> = corners.map(|(x, y)| [at(x), at(y), 0.0]).collect();
    let mut indices = Vec::with_capacity((quads * quads * 6) as usize);
    for y in 0..quads {
        for x in 0..quads {
            let a = y * (quads + 1) + x;
            let (b, c, d) = (a + 1, a + quads + 1, a + quads + 2);
            indices.extend(match side {
                Seen::Front => [a, b, d, a, d, c],
                Seen::Away => [a, d, b, a, c, d],
            });
        }
    }
    let triangle_count = quads * quads * 2;
    let part = Part { triangle_count, two_sided: false, alpha, ..Part::default() };
    let data = MeshData { positions, indices, parts: vec![part], ..MeshData::default() };
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(data).expect("a grid is a mesh"));
    for y in 0..patches {
        for x in 0..patches {
            let corner = [x, y].map(|v| f64::from(v) * width - 1.0);
            let place = Transform::from_translation([corner[0], corner[1], 0.0]);
            scene.add(Instance::new(mesh, place)).expect("few instances of a mesh that is there");
        }
    }
    scene.commit(&cullet::Culler::default());
    scene
}

/// A view that the sheet nearly fills.
fn sheet_view() -> View {
    // The sheet is 1 high to each side, 2 away; a little more keeps its border inside.
    let fov_y_radians = 2.0 * (1.02f64 / 2.0).atan();
    let projection = Projection::Perspective { fov_y_radians, aspect: 1.0, near: 0.1, far: 10.0 };
    let camera = Camera::look_at([0.0, 0.0, 2.0], [0.0; 3], projection);
    View::new(&camera, Depth::Reversed, [SIDE; 2]).expect("a plain perspective")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_forgets_what_does_not_grow() {
        let points = [1.0, 2.0, 5.0, 9.0].map(|x| [x, 1000.0 + 7.0 * x]);
        assert!((slope(&points) - 7.0).abs() < 1e-9);
    }

    #[test]
    fn the_fastest_count_and_thirds_give_the_range() {
        let series = || Series { scenes: Vec::new(), counts: vec![1.0, 2.0, 3.0] };
        let series = [series(), series(), series(), series(), series()];
        // Each second round is disturbed; the last two of the six cost one more a step.
        let round = |i: usize| {
            let extra = if i % 2 == 1 { 50.0 } else { 0.0 };
            let step = if i < 4 { 10.0 } else { 11.0 };
            let frames = [1.0, 2.0, 3.0].map(|n| 100.0 + n * step + extra).to_vec();
            Round { tests: [1.0 + extra, 2.0 + extra, 3.0 + extra], frames: vec![frames; 5] }
        };
        let rounds: Vec<Round> = (0..6).map(round).collect();
        let spreads = spreads(&rounds, &series);
        assert_eq!(spreads.map(|s| s.ns), [1.0, 2.0, 3.0, 10.0, 10.0, 10.0, 10.0, 10.0]);
        assert_eq!((spreads[0].low, spreads[0].high), (1.0, 1.0));
        assert_eq!((spreads[7].low, spreads[7].high), (10.0, 11.0));
        let one = super::spreads(&rounds[..1], &series);
        assert_eq!((one[3].low, one[3].ns, one[3].high), (10.0, 10.0, 10.0));
    }

    #[test]
    fn sheets_of_any_number_of_triangles_fill_the_same_pixels() {
        let view = sheet_view();
        let draw = |patches, quads, alpha, side| {
            let scene = sheet(patches, quads, alpha, side);
            let options = RenderOptions { threads: 1, ..RenderOptions::default() };
            (scene.triangle_count(), render(&scene, &view, Selection::All, &options))
        };
        let (few, a) = draw(2, 3, Alpha::Opaque, Seen::Front);
        let (many, b) = draw(4, 9, Alpha::Opaque, Seen::Front);
        assert_eq!((few, many), (72, 2592));
        assert_eq!(a.stats.covered_pixels, b.stats.covered_pixels);
        assert!(a.stats.covered_pixels > 240_000, "{}", a.stats.covered_pixels);
        for alpha in [Alpha::Masked, Alpha::Blended] {
            let (n, frame) = draw(2, 3, alpha, Seen::Front);
            assert_eq!((frame.stats.covered_pixels, frame.blended.len() as u64), (0, n));
        }
        let (_, away) = draw(2, 3, Alpha::Opaque, Seen::Away);
        assert_eq!(away.stats.covered_pixels, 0);
    }
}
