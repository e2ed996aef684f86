//! What is measured, and how: medians of rounds, and slopes instead of times.

use std::hint::black_box;
use std::time::Instant;

use cullet::cull::Indices;
use cullet::cull::backface::Planes8;
use cullet::cull::backface::cluster::{Bound, ClusterBounds, ClusterPlanes, EllipticCone};
use cullet::cull::frustum::batch;
use cullet::mesh::{Alpha, Part};
use cullet::{Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Transform, View};
use cullet_draw::{RenderOptions, Selection, render};

use crate::bench::{bumpy_ball, planes_that_see, random_boxes};
use crate::console::interrupted;

/// Each point of a round is the fastest of so many, for what disturbs a machine only ever adds.
const TRIES: usize = 3;

/// A round of a test takes so long, or the clock would be measured.
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
/// Quads along the side of an instance: the sheet grows from 8,192 to 131,072 triangles and keeps its
/// pixels, so the slope of time over triangles holds none of them.
const QUADS: [u32; 4] = [8, 16, 24, 32];
/// Instances along the sides of a sheet that keeps its 32,768 triangles. No instance is more than one of
/// the renderer's blocks of 256 triangles.
const SPLITS: [u32; 3] = [16, 64, 128];
/// Quads along the side of that sheet.
const SPLIT_QUADS: u32 = 128;

/// A measured cost: nanoseconds, the median of all rounds, with the quartiles.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Spread {
    /// The median.
    pub(crate) ns: f64,
    /// A quarter of the rounds is below this.
    pub(crate) low: f64,
    /// A quarter of the rounds is above this.
    pub(crate) high: f64,
}

impl Spread {
    /// Of one value or more.
    fn of(mut rounds: Vec<f64>) -> Self {
        rounds.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * rounds.len().saturating_sub(1) as f64;
            let [low, high] = [place.floor(), place.ceil()].map(|i| rounds[i as usize]);
            low + (high - low) * place.fract()
        };
        Self { ns: at(0.5), low: at(0.25), high: at(0.75) }
    }
}

/// Measures every cost of [`cullet::Costs::named`], in that order; `step` is called after each round.
/// `None` where the user stopped it.
pub(super) fn measure(rounds: u32, mut step: impl FnMut()) -> Option<[Spread; 8]> {
    let mut tests = Tests::new();
    let view = sheet_view();
    let classes = [
        (Alpha::Opaque, Side::Away),
        (Alpha::Opaque, Side::Front),
        (Alpha::Masked, Side::Front),
        (Alpha::Blended, Side::Front),
    ];
    let sheets = classes.map(|(alpha, side)| QUADS.map(|quads| sheet(PATCHES, quads, alpha, side)));
    let splits = SPLITS.map(|n| sheet(n, SPLIT_QUADS / n, Alpha::Opaque, Side::Front));
    let triangles = |s: &Scene| s.triangle_count() as f64;
    let instances = |s: &Scene| f64::from(s.instance_count());
    let mut figures: [Vec<f64>; 8] = Default::default();
    // The first round warms caches and clocks, and does not count.
    for round in 0..=rounds {
        if interrupted() {
            return None;
        }
        let mut new = tests.round().to_vec();
        new.extend(sheets.iter().map(|s| drawing_slope(s, &view, triangles)));
        new.push(drawing_slope(&splits, &view, instances));
        if round > 0 {
            figures.iter_mut().zip(new).for_each(|(all, ns)| all.push(ns));
        }
        step();
    }
    Some(figures.map(Spread::of))
}

/// What the tests in batches need.
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
        let level = batch::levels()[0].1;
        let boxes = random_boxes(ITEMS);
        let frustum = planes_that_see(30, |p| batch::count_boxes(level, p, &boxes), ITEMS);
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
        let level = batch::levels()[0].1;
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

/// Nanoseconds an item of passes over `items`, for one round.
fn per_item(items: usize, mut pass: impl FnMut()) -> f64 {
    let start = Instant::now();
    let mut passes = 0u32;
    while start.elapsed().as_secs_f64() < ROUND_SECONDS {
        // So many passes that reading the clock costs nothing beside them.
        for _ in 0..16 {
            pass();
        }
        passes += 16;
    }
    start.elapsed().as_secs_f64() * 1e9 / (f64::from(passes) * items as f64)
}

/// Nanoseconds of drawing for each one more of what `count` counts, pixels and all else being equal.
fn drawing_slope(scenes: &[Scene], view: &View, count: impl Fn(&Scene) -> f64) -> f64 {
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    let points: Vec<[f64; 2]> = scenes
        .iter()
        .map(|scene| {
            let fastest = (0..TRIES).map(|_| {
                let start = Instant::now();
                black_box(render(scene, view, Selection::All, &options));
                start.elapsed().as_secs_f64() * 1e9
            });
            [count(scene), fastest.fold(f64::INFINITY, f64::min)]
        })
        .collect();
    slope(&points)
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

/// Which side of the sheet the viewer sees.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Front,
    /// The back of what has only a front.
    Away,
}

/// A flat sheet from −1 to 1, cut into `patches`² instances of one mesh of `quads`² quads. One mesh, so
/// that what the renderer prepares once a mesh is not counted once an instance.
fn sheet(patches: u32, quads: u32, alpha: Alpha, side: Side) -> Scene {
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
                Side::Front => [a, b, d, a, d, c],
                Side::Away => [a, d, b, a, c, d],
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
    scene.commit();
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
    fn the_spread_is_median_and_quartiles() {
        let s = Spread::of(vec![5.0, 1.0, 4.0, 2.0, 3.0]);
        assert_eq!((s.low, s.ns, s.high), (2.0, 3.0, 4.0));
        let s = Spread::of(vec![1.0, 2.0]);
        assert_eq!((s.low, s.ns, s.high), (1.25, 1.5, 1.75));
    }

    #[test]
    fn sheets_of_any_number_of_triangles_fill_the_same_pixels() {
        let view = sheet_view();
        let draw = |patches, quads, alpha, side| {
            let scene = sheet(patches, quads, alpha, side);
            let options = RenderOptions { threads: 1, ..RenderOptions::default() };
            (scene.triangle_count(), render(&scene, &view, Selection::All, &options))
        };
        let (few, a) = draw(2, 3, Alpha::Opaque, Side::Front);
        let (many, b) = draw(4, 9, Alpha::Opaque, Side::Front);
        assert_eq!((few, many), (72, 2592));
        assert_eq!(a.stats.covered_pixels, b.stats.covered_pixels);
        assert!(a.stats.covered_pixels > 240_000, "{}", a.stats.covered_pixels);
        for alpha in [Alpha::Masked, Alpha::Blended] {
            let (n, frame) = draw(2, 3, alpha, Side::Front);
            assert_eq!((frame.stats.covered_pixels, frame.blended.len() as u64), (0, n));
        }
        let (_, away) = draw(2, 3, Alpha::Opaque, Side::Away);
        assert_eq!(away.stats.covered_pixels, 0);
    }
}
