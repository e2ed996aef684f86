//! Clipping: triangles by their outcodes, lines against windows and planes, polygons in clip space
//! and in the world.

use std::hint::black_box;

use cullet::cull::frustum::triangles::ObjectRegion;
use cullet::{Camera, Depth, Projection, Transform, View};
use cullet_draw::clip::{Clipper, GuardBand, OutcodeRegion, Region, Sorted, Window, space};

use super::measure::beside_reading;
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{Random, size_name};

/// Triangles or lines of the workloads that cut: in the second cache, and no predictor learns them.
const PRIMITIVES: usize = 16_384;
/// Half the side of the cube of points, and where the camera stands in it.
const HALF: f32 = 100.0;

fn measure(
    options: &BenchOptions,
    workload: Workload,
    bytes: usize,
    each: &mut dyn FnMut(Measured),
    pass: impl FnMut(),
) {
    let times = beside_reading(options.seconds, workload.items * bytes, pass);
    each(workload.streaming(bytes, times));
}

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        sort(options, len, each);
    }
    lines(options, each);
    guard_band(options, each);
    both_places(options, each);
}

fn view() -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 16.0 / 9.0, near: 0.1, far: 1000.0 };
    let camera = Camera::look_at([0.0, 0.0, 0.0], [3.0, 1.0, -5.0], projection);
    View::new(&camera, Depth::Reversed, [1920, 1080]).expect("a plain perspective")
}

/// Triangles sorted by the outcodes of their points.
fn sort(options: &BenchOptions, len: usize, each: &mut dyn FnMut(Measured)) {
    let name = format!("clip/sort/{}", size_name(len));
    if !options.wants(&name) {
        return;
    }
    let mut random = Random::new();
    let points: Vec<[f32; 3]> = (0..len).map(|_| random.point(HALF)).collect();
    let region = OutcodeRegion::new(&view().frustum(), &Transform::IDENTITY);
    let culling = ObjectRegion::new(&view().frustum(), &Transform::IDENTITY);
    // Each point begins a triangle with the next two, so there are as many as points.
    let last = len.saturating_sub(1) as u32;
    let indices: Vec<u32> =
        (0..len as u32).flat_map(|i| [i, (i + 1).min(last), (i + 2).min(last)]).collect();
    let mut sorted = Sorted::default();
    region.sort_into(&points, &indices, 0..len as u32, &mut sorted);
    let visible = sorted.accepted.len() + sorted.candidates.len();
    let by_one = (0..len as u32).filter(|&t| {
        let corners = [0, 1, 2].map(|k| points[indices[t as usize * 3 + k] as usize]);
        culling.rejects(&corners, u32::MAX).is_none()
    });
    let checked = by_one.count() == visible;
    let workload = Workload { name, level: "scalar", items: len, visible, checked };
    measure(options, workload, 24, each, || {
        region.sort_into(&points, &indices, 0..len as u32, &mut sorted);
    });
}

/// Lines of which a third is accepted or rejected by outcodes and the rest is cut.
fn lines(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    let mut random = Random::new();
    let ends: Vec<[[f32; 3]; 2]> =
        (0..PRIMITIVES).map(|_| [random.point(2.0), random.point(2.0)]).collect();
    let window = Window::new([-1.0_f32; 3], [1.0; 3]).expect("low is below high");
    let region = window.region();
    type LineTest<'a> = Box<dyn Fn(&[[f32; 3]; 2]) -> Option<[f32; 2]> + 'a>;
    let ways: [(&str, LineTest<'_>); 3] = [
        ("cohen-sutherland", Box::new(|[a, b]| window.cohen_sutherland(a, b))),
        ("liang-barsky", Box::new(|[a, b]| window.liang_barsky(a, b))),
        ("cyrus-beck", Box::new(|[a, b]| region.clip_line(a, b))),
    ];
    let same = |t: Option<[f32; 2]>, u: Option<[f32; 2]>| match (t, u) {
        (Some(t), Some(u)) => (t[0] - u[0]).abs() < 1e-4 && (t[1] - u[1]).abs() < 1e-4,
        (t, u) => t.or(u).is_none_or(|t| t[1] - t[0] < 1e-4),
    };
    let wide = window_in_f64();
    for (name, way) in &ways {
        let name = format!("clip/lines/{name}");
        if !options.wants(&name) {
            continue;
        }
        let checked = ends.iter().all(|line| {
            let [a, b] = line.map(|p| p.map(f64::from));
            same(way(line), wide.clip_line(&a, &b).map(|t| t.map(|v| v as f32)))
        });
        let visible = ends.iter().filter(|line| way(line).is_some()).count();
        let mut found = vec![None; PRIMITIVES];
        let workload = Workload { name, level: "scalar", items: PRIMITIVES, visible, checked };
        measure(options, workload, 24, each, || {
            for (found, line) in found.iter_mut().zip(&ends) {
                *found = way(line);
            }
            black_box(&found);
        });
    }
}

fn window_in_f64() -> Region<f64, 3> {
    Window::new([-1.0; 3], [1.0; 3]).expect("low is below high").region()
}

/// Triangles of a soup around the eye that all straddle the band or the near plane, none of them
/// outside of the view: what is left to cut when all that can be told at a glance has gone. Each
/// straddles at most so many planes; one with a corner behind the eye straddles several, for that
/// is outside of left or right whatever its x.
fn straddling(guard: &GuardBand<f32>, planes: u32) -> Vec<[[f32; 4]; 3]> {
    let mut random = Random::new();
    let m = view().clip_from_world();
    let mut found = Vec::with_capacity(PRIMITIVES);
    while found.len() < PRIMITIVES {
        let at: [f32; 3] = random.point(4.0);
        let corners = [0; 3].map(|_| {
            let off: [f32; 3] = random.point(2.0);
            let [x, y, z] = [0, 1, 2].map(|i| f64::from(at[i] + off[i]));
            [0, 1, 2, 3].map(|r| (m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]) as f32)
        });
        let codes = corners.map(|p| guard.outcodes(&p));
        let and = |k: usize| codes[0][k] & codes[1][k] & codes[2][k];
        let or = codes[0][1] | codes[1][1] | codes[2][1];
        if and(0) == 0 && or != 0 && or.count_ones() <= planes {
            found.push(corners);
        }
    }
    found
}

fn guard_band(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    let guard = GuardBand::new(Depth::Reversed, 16.0_f32).expect("16 is a width");
    let names =
        ["one-plane", "guard-band", "full", "near"].map(|what| format!("clip/triangles/{what}"));
    if !names.iter().any(|name| options.wants(name)) {
        return;
    }
    let [one, triangles] = [1, 6].map(|planes| straddling(&guard, planes));
    let [full, near] = [space::full::<f32>(Depth::Reversed), space::near(Depth::Reversed)];
    let wide = |r: &Region<f32, 4>| {
        let sides = r.sides().map(|(_, s)| {
            let (n, d) = (s.normal().map(f64::from), f64::from(s.d()));
            cullet_draw::clip::HalfSpace::new(n, d)
        });
        sides.collect::<Result<Vec<_>, _>>().and_then(Region::new).expect("they were planes")
    };
    let mut clipper = Clipper::new();
    let mut run =
        |name: &str, triangles: &[[[f32; 4]; 3]], region: &Region<f32, 4>, banded: bool| {
            if !options.wants(name) {
                return;
            }
            let mut in_f64 = Clipper::new();
            let region_in_f64 = wide(region);
            let mut visible = 0;
            let checked = triangles.iter().all(|t| {
                let cut = clip(&guard, region, banded, &mut clipper, t);
                visible += usize::from(!cut.is_empty());
                let area = area_of(cut.iter().map(|p| p.map(f64::from)));
                let exact = in_f64.clip(&region_in_f64, &t.map(|p| p.map(f64::from)));
                let exact = area_of(exact.iter().copied());
                (0..3).all(|i| (area[i] - exact[i]).abs() < 1e-2)
            });
            let (name, items) = (name.to_owned(), PRIMITIVES);
            let workload = Workload { name, level: "scalar", items, visible, checked };
            let mut vertices = Vec::with_capacity(PRIMITIVES * 9);
            measure(options, workload, 48, each, || {
                vertices.clear();
                for t in triangles {
                    vertices.extend_from_slice(clip(&guard, region, banded, &mut clipper, t));
                }
                black_box(&vertices);
            });
        };
    run(&names[0], &one, guard.region(), true);
    run(&names[1], &triangles, guard.region(), true);
    run(&names[2], &triangles, &full, false);
    run(&names[3], &triangles, &near, false);
}

#[inline]
fn clip<'a>(
    guard: &GuardBand<f32>,
    region: &Region<f32, 4>,
    banded: bool,
    clipper: &'a mut Clipper<[f32; 4]>,
    triangle: &[[f32; 4]; 3],
) -> &'a [[f32; 4]] {
    if banded { guard.clip(clipper, triangle) } else { clipper.clip(region, triangle) }
}

/// Twice the vector area of a polygon in (x, y, w).
fn area_of(polygon: impl Iterator<Item = [f64; 4]>) -> [f64; 3] {
    let points: Vec<[f64; 3]> = polygon.map(|p| [p[0], p[1], p[3]]).collect();
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).fold([0.0; 3], |n, (p, q)| {
        std::array::from_fn(|i| {
            n[i] + p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3]
        })
    })
}

/// The whole way of a triangle in the world to a polygon in clip space, clipped before projection
/// or after it, of triangles of which some are accepted, some rejected and some cut.
fn both_places(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    let names = ["world", "clip-space"].map(|what| format!("clip/place/{what}"));
    if !names.iter().any(|name| options.wants(name)) {
        return;
    }
    let view = view();
    let mut random = Random::new();
    let triangles: Vec<[[f64; 3]; 3]> = (0..PRIMITIVES)
        .map(|_| {
            let at: [f32; 3] = random.point(20.0);
            [0; 3].map(|_| {
                let off: [f32; 3] = random.point(6.0);
                std::array::from_fn(|i| f64::from(at[i] + off[i]))
            })
        })
        .collect();
    let frustum = Region::<f64, 3>::from(&view.frustum());
    let volume = space::full::<f64>(view.depth());
    let m = view.clip_from_world();
    let project = |[x, y, z]: [f64; 3]| -> [f64; 4] {
        std::array::from_fn(|r| m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r])
    };
    let (mut world, mut clip) = (Clipper::new(), Clipper::new());
    let mut vertices: [Vec<[f64; 4]>; 2] = [Vec::new(), Vec::new()];
    let mut in_world = |t: &[[f64; 3]; 3], out: &mut Vec<[f64; 4]>| {
        out.extend(world.clip(&frustum, t).iter().map(|&p| project(p)));
    };
    let mut in_clip = |t: &[[f64; 3]; 3], out: &mut Vec<[f64; 4]>| {
        out.extend_from_slice(clip.clip(&volume, &t.map(project)));
    };
    let (mut visible, mut checked) = (0, true);
    for t in &triangles {
        vertices.iter_mut().for_each(Vec::clear);
        in_world(t, &mut vertices[0]);
        in_clip(t, &mut vertices[1]);
        visible += usize::from(!vertices[1].is_empty());
        let [a, b] = [0, 1].map(|i| area_of(vertices[i].iter().copied()));
        checked &= (0..3).all(|i| (a[i] - b[i]).abs() < 1e-6);
    }
    type Clip<'a> = &'a mut dyn FnMut(&[[f64; 3]; 3], &mut Vec<[f64; 4]>);
    let places: [Clip<'_>; 2] = [&mut in_world, &mut in_clip];
    for (name, place) in names.iter().zip(places) {
        if !options.wants(name) {
            continue;
        }
        let (name, items) = (name.clone(), PRIMITIVES);
        let workload = Workload { name, level: "scalar", items, visible, checked };
        let out = &mut vertices[0];
        measure(options, workload, 72, each, || {
            out.clear();
            triangles.iter().for_each(|t| place(t, out));
            black_box(&*out);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_straddle() {
        let guard = GuardBand::new(Depth::Reversed, 16.0_f32).unwrap();
        let full = space::full::<f32>(Depth::Reversed);
        let mut clipper = Clipper::new();
        for t in straddling(&guard, 6).into_iter().chain(straddling(&guard, 1)) {
            let cut = guard.clip(&mut clipper, &t);
            assert!(cut != t, "one that is not cut does not count");
            let codes = t.map(|p| full.outcode(&p));
            assert_eq!(codes[0] & codes[1] & codes[2], 0);
        }
    }
}
