//! Bézier patches: a patch that is culled whole has nothing in front, on its surface or in any
//! grid.

use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet_lab::methods::cluster::{
    Bound, EllipticConeQuantised, NoRegion, NormalCone, Pyramid, TwoWay, region,
};
use cullet_lab::methods::{BezierPatch, PatchError};
use cullet_testkit::Rng;
use cullet_testkit::vectors::{cross, dot, fibonacci};

type Point = [f64; 3];

struct Net {
    name: &'static str,
    degree: [usize; 2],
    points: Vec<[f32; 3]>,
}

impl Net {
    fn of(
        name: &'static str,
        degree: [usize; 2],
        mut at: impl FnMut(usize, usize) -> Point,
    ) -> Self {
        let grid = (0..=degree[0]).flat_map(|i| (0..=degree[1]).map(move |j| (i, j)));
        Self { name, degree, points: grid.map(|(i, j)| at(i, j).map(|v| v as f32)).collect() }
    }

    fn patch(&self) -> BezierPatch<'_> {
        BezierPatch::new(self.degree, &self.points).expect(self.name)
    }
}

/// The control points of a quarter of a circle, nearly.
const QUARTER: [[f64; 2]; 4] = [[1.0, 0.0], [1.0, 0.552_285], [0.552_285, 1.0], [0.0, 1.0]];

/// An eighth of a sphere with a pole, a quarter of a torus' tube, a sheet with a wave, a plane.
fn smooth() -> [Net; 4] {
    [
        Net::of("octant", [3, 3], |i, j| {
            let ([x, z], [r, y]) = (QUARTER[i], QUARTER[j]);
            // From +z to +x along u and to the pole +y along v: the front is outside.
            [z * r, y, x * r]
        }),
        Net::of("torus", [3, 3], |i, j| {
            let ([x, z], [r, y]) = (QUARTER[i], QUARTER[j]);
            let r = 2.0 + r;
            [z * r, y, x * r]
        }),
        Net::of("wave", [3, 3], |i, j| {
            let (x, y) = (i as f64 / 3.0, j as f64 / 3.0);
            [x, y, [0.0, 0.25, -0.25, 0.0][i] + 0.1 * y * y]
        }),
        Net::of("plane", [2, 1], |i, j| [i as f64, j as f64, 0.5 * i as f64]),
    ]
}

/// Sheets of any degrees, bent and shaken, turned and set somewhere.
fn random(rng: &mut Rng) -> Net {
    let degree = [1 + rng.index(4), 1 + rng.index(4)];
    let bend = [0.0, 0.2, 0.6, 1.2][rng.index(4)];
    let shake = [0.0, 0.02, 0.1][rng.index(3)];
    let size = [1e-3, 1.0, 50.0][rng.index(3)];
    let middle = rng.vector(1.0).map(|v| v * size * [0.0, 3.0, 100.0][rng.index(3)]);
    let axis = rng.direction();
    let side = cross(axis, rng.direction());
    let length = dot(side, side).sqrt().max(1e-2);
    let u = side.map(|v| v / length);
    let v = cross(axis, u);
    Net::of("random", degree, |i, j| {
        let (x, y) = (i as f64 / degree[0] as f64 - 0.5, j as f64 / degree[1] as f64 - 0.5);
        let height = -bend * (x * x + y * y) + shake * (rng.signed() - 0.5);
        std::array::from_fn(|k| (u[k] * x + v[k] * y + axis[k] * height) * size + middle[k])
    })
}

/// The grid of `cells` a side, as corners and normal of each triangle, with either diagonal.
fn tessellated(patch: &BezierPatch<'_>, cells: [usize; 2], other: bool) -> Vec<(Point, Point)> {
    let at =
        |i: usize, j: usize| patch.point(i as f64 / cells[0] as f64, j as f64 / cells[1] as f64);
    let mut triangles = Vec::new();
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            let q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let [a, b] = if other { [[0, 1, 3], [1, 2, 3]] } else { [[0, 1, 2], [0, 2, 3]] };
            for t in [a, b] {
                let [a, b, c] = t.map(|k: usize| q[k]);
                triangles.push((a, cross(minus(b, a), minus(c, a))));
            }
        }
    }
    triangles
}

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|k| a[k] - b[k])
}

/// n·(p − e), or n times the direction of sight.
fn behind((p, n): &(Point, Point), eye: [f64; 4]) -> f64 {
    let to: Point = std::array::from_fn(|k| p[k] * eye[3] - eye[k]);
    dot(*n, to)
}

fn eyes(rng: &mut Rng, planes: &ClusterPlanes) -> Vec<[f64; 4]> {
    let (centre, radius) = (planes.centre(), planes.radius());
    (0..300)
        .map(|i| {
            let d = rng.direction();
            if i % 9 == 0 {
                return [d[0], d[1], d[2], 0.0];
            }
            let far = radius * [0.3, 0.9, 1.5, 3.0, 20.0][rng.index(5)];
            let p: Point = std::array::from_fn(|k| centre[k] + d[k] * far);
            [p[0], p[1], p[2], 1.0]
        })
        .collect()
}

#[test]
fn a_culled_patch_has_nothing_in_front() {
    let mut rng = Rng(0x7EA9_0715);
    let nets = smooth()
        .into_iter()
        .chain((0..120).map(|_| random(&mut Rng(rng.index(1 << 30) as u64 + 1))));
    let nets: Vec<Net> = nets.collect();
    let (mut culled, mut bounded) = (0, 0);
    for net in &nets {
        let patch = net.patch();
        let mut samples: Vec<(Point, Point)> = Vec::new();
        for i in 0..=16 {
            for j in 0..=16 {
                let (u, v) = (f64::from(i) / 16.0, f64::from(j) / 16.0);
                samples.push((patch.point(u, v), patch.normal(u, v)));
            }
        }
        let surface = samples.clone();
        for cells in [[1, 1], [1, 2], [2, 1], [3, 5], [8, 8]] {
            samples.extend(tessellated(&patch, cells, false));
            samples.extend(tessellated(&patch, cells, true));
        }
        for (planes, samples) in [(patch.planes(), samples), (patch.surface_planes(), surface)] {
            let bounds = TwoWay::<EllipticCone>::fit(&planes);
            bounded += u32::from(bounds.back.is_some());
            let (pyramid, cone) = (Pyramid::<6>::fit(&planes), NormalCone::fit(&planes));
            let bytes = EllipticConeQuantised::fit(&planes);
            for eye in eyes(&mut rng, &planes) {
                let ideal = planes.is_behind(eye);
                let single = bounds.back.is_some_and(|b| b.is_behind(eye))
                    || pyramid.as_ref().is_some_and(|b| b.is_behind(eye))
                    || cone.as_ref().is_some_and(|b| b.is_behind(eye))
                    || bytes.as_ref().is_some_and(|b| b.is_behind(eye));
                assert!(ideal || !single, "{}: a bound is larger than its planes", net.name);
                let reach = (0..3).map(|k| (eye[k] - planes.centre()[k] * eye[3]).powi(2));
                let reach = reach.sum::<f64>().sqrt() + planes.radius();
                for sample in &samples {
                    let value = behind(sample, eye);
                    // Rounding error of f64 in a product of these sizes.
                    let error = 1e-12 * dot(sample.1, sample.1).sqrt() * reach
                        + 1e-14 * planes.radius().powi(2) * reach;
                    assert!(!ideal || value >= -error, "{}: {value} seen from {eye:?}", net.name);
                    let front = bounds.front.is_some_and(|b| b.is_behind(eye));
                    assert!(!front || value <= error, "{}: {value} front, {eye:?}", net.name);
                }
                culled += u32::from(ideal);
            }
        }
    }
    // Of 124 nets, twice.
    assert!(bounded > 120, "{bounded} of {} have a bound", 2 * nets.len());
    assert!(culled > 10_000, "{culled} culled");
}

/// Shares of views at three radii: culled by grid planes, by an elliptic cone of these, by surface
/// planes, and the share of views in which an 8 × 8 grid is all back-facing.
fn shares(net: &Net) -> [f64; 4] {
    let patch = net.patch();
    let (grid, surface) = (patch.planes(), patch.surface_planes());
    let cone = EllipticCone::fit(&grid);
    let triangles = tessellated(&patch, [8, 8], false);
    let centre = surface.centre();
    let mut shares = [0.0; 4];
    for i in 0..1000 {
        let d = fibonacci(i, 1000);
        let p: Point = std::array::from_fn(|k| centre[k] + 3.0 * surface.radius() * d[k]);
        let eye = [p[0], p[1], p[2], 1.0];
        let exact = triangles.iter().all(|t| behind(t, eye) >= -1e-9);
        let answers = [
            grid.is_behind(eye),
            cone.as_ref().is_some_and(|b| b.is_behind(eye)),
            surface.is_behind(eye),
            exact,
        ];
        for (share, yes) in shares.iter_mut().zip(answers) {
            *share += f64::from(u8::from(yes)) * 0.1;
        }
    }
    shares
}

#[test]
fn patches_are_culled_in_most_views_that_see_no_front() {
    // Least share that is culled, in per cent of views: measured, less half a point.
    let floors = [[5.7, 3.8, 19.2], [6.1, 4.0, 18.8], [14.7, 14.3, 26.2], [49.4, 49.1, 49.4]];
    for (net, floors) in smooth().iter().zip(floors) {
        let [grid, cone, surface, exact] = shares(net);
        let name = net.name;
        println!(
            "{name}: grids {grid:.1} %, by cone {cone:.1}, surface {surface:.1}, all {exact:.1}"
        );
        for (share, floor) in [grid, cone, surface].into_iter().zip(floors) {
            assert!(share >= floor && share <= exact + 1e-9, "{name}: {share} of {exact}");
        }
    }
}

#[test]
fn nets_that_are_none_are_refused() {
    let points = [[0.0f32; 3]; 16];
    let refused = |degree, points: &[[f32; 3]]| BezierPatch::new(degree, points).err();
    assert_eq!(refused([0, 3], &points), Some(PatchError::Degree { along: 'u', degree: 0 }));
    assert_eq!(refused([3, 9], &points), Some(PatchError::Degree { along: 'v', degree: 9 }));
    let error = refused([3, 2], &points).expect("12 points, not 16");
    assert_eq!(error.to_string(), "16 control points; degrees 3 by 2 need 12");
    let mut nan = points;
    nan[5][1] = f32::NAN;
    assert!(matches!(refused([3, 3], &nan), Some(PatchError::NotFinite { point: 5, .. })));
}

#[test]
fn patches_without_a_region_say_why() {
    // All points one: nothing is drawn, and nothing is proved.
    let point = [[2.0f32; 3]; 16];
    let patch = BezierPatch::new([3, 3], &point).expect("a net");
    assert_eq!(region(&patch.planes()), Err(NoRegion::Empty));
    assert!(!patch.planes().is_behind([9.0, 0.0, 0.0, 1.0]));
    // A sheet folded over itself.
    let folded = Net::of("folded", [2, 1], |i, j| [[0.0, 2.0, 0.0][i], j as f64, i as f64 * 0.1]);
    assert_eq!(region(&folded.patch().surface_planes()), Err(NoRegion::Hemisphere));
    // A pole is no obstacle, and a corner with parallel sides that rounding turned is one.
    let [octant, ..] = smooth();
    assert!(octant.patch().surface_planes().is_complete());
    let corner = Net::of("corner", [1, 1], |i, j| {
        [[[0.0, 0.0, 0.0], [2.0, 1e-9, 0.0]], [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]][i][j]
    });
    assert_eq!(region(&corner.patch().planes()), Err(NoRegion::NotCertain));
}
