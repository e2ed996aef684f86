//! Polygons: the four cases of an edge, and one plane after another.

use cullet::clip::polygon::clip_polygon_ref;
use cullet::clip::{Clipper, HalfSpace, Region, Window};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::Random;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other};

/// The walk around the polygon, case by case, gives the engine's polygon.
pub(super) fn four_cases(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 2000;
    let mut random = Random::new(93);
    let mut clipper = Clipper::new();
    // Inside, leaving, outside, entering.
    let mut cases = [0_u32; 4];
    let (mut differ, mut worst) = (0, 0.0_f64);
    for _ in 0..CASES {
        let line =
            HalfSpace::new(random.point::<2>(1.0), random.between(-1.0, 1.0)).map_err(other)?;
        let polygon = around(&mut random, 5);
        let expected = walked(&line, &polygon, &mut cases);
        let region = Region::new([line]).map_err(other)?;
        let found = clipper.clip(&region, &polygon);
        // The walk begins its polygon at the end of the first edge.
        let turned = (0..expected.len()).find_map(|first| {
            let (before, after) = expected.split_at(first);
            let order = after.iter().chain(before);
            let off = order.zip(found).map(|(p, q)| (p[0] - q[0]).abs().max((p[1] - q[1]).abs()));
            let off = off.fold(0.0, f64::max);
            (off < 1e-9).then_some(off)
        });
        if expected.len() == found.len() && (found.is_empty() || turned.is_some()) {
            worst = worst.max(turned.unwrap_or(0.0));
        } else {
            differ += 1;
        }
        let exact = area(&clip_polygon_ref(&region, &polygon));
        worst = worst.max((area(found) - exact).abs());
    }
    let [inside, leaving, outside, entering] = cases;
    Ok(Finding::if_so(
        differ == 0 && worst < 1e-9 && leaving == entering && cases.iter().all(|&n| n > 100),
        format!(
            "of the edges of {} polygons {} are inside, {} outside, {} leave and {} enter; {differ} polygons differ from the engine's, \
             and areas from exact ones by {worst:.0e}",
            grouped(CASES),
            grouped(inside),
            grouped(outside),
            grouped(leaving),
            grouped(entering)
        ),
    ))
}

/// As the lecture has it.
fn walked(line: &HalfSpace<f64, 2>, polygon: &[[f64; 2]], cases: &mut [u32; 4]) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (from, to) = (line.height(&p), line.height(&q));
        let t = from / (from - to);
        let crossing = [0, 1].map(|k| p[k] + t * (q[k] - p[k]));
        match (from > 0.0, to > 0.0) {
            (false, false) => {
                cases[0] += 1;
                kept.push(q);
            }
            (false, true) => {
                cases[1] += 1;
                kept.push(crossing);
            }
            (true, true) => cases[2] += 1,
            (true, false) => {
                cases[3] += 1;
                kept.extend([crossing, q]);
            }
        }
    }
    kept
}

/// One side after another is all sides at once, in whatever order, and as exact arithmetic has it.
pub(super) fn one_after_another(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 300;
    let window = Window::new([-1.0, -1.0], [1.0, 1.0]).map_err(other)?.region();
    let mut random = Random::new(94);
    let mut clipper = Clipper::new();
    let (mut cut, mut convex_most, mut worst, mut differ) = (0, 0, 0.0_f64, 0);
    for _ in 0..CASES {
        let polygon = around(&mut random, 6);
        let at_once = clipper.clip(&window, &polygon).to_vec();
        let mut backwards = polygon.clone();
        let mut forwards = polygon.clone();
        let sides: Vec<_> = window.sides().map(|(_, side)| *side).collect();
        for (first, last) in sides.iter().zip(sides.iter().rev()) {
            let by = |side: &HalfSpace<f64, 2>| Region::new([*side]).map_err(other);
            forwards = clipper.clip(&by(first)?, &forwards).to_vec();
            backwards = clipper.clip(&by(last)?, &backwards).to_vec();
        }
        let exact = area(&clip_polygon_ref(&window, &polygon));
        for way in [&at_once, &forwards, &backwards] {
            worst = worst.max((area(way) - exact).abs());
            let outside = way.iter().flatten().filter(|v| v.abs() > 1.0 + 1e-12).count();
            differ += outside + usize::from(way.is_empty() != at_once.is_empty());
        }
        cut += u32::from(at_once != polygon);
        convex_most = convex_most.max(at_once.len());
    }
    Ok(Finding::if_so(
        worst < 1e-12 && differ == 0 && cut > 100 && convex_most <= 6 + 4,
        format!(
            "of {CASES} convex polygons of six corners {cut} are cut, to ten corners at the most ({convex_most} here); at once, one side \
             after another and in the other order areas are the exact ones within {worst:.0e}"
        ),
    ))
}

/// A convex polygon around a point near the origin, counter-clockwise.
fn around(random: &mut Random, corners: u32) -> Vec<[f64; 2]> {
    let (middle, size) = (random.point::<2>(1.0), random.between(0.3, 2.0));
    let first = random.between(0.0, 1.0);
    (0..corners)
        .map(|i| {
            let angle = (f64::from(i) + first) / f64::from(corners) * std::f64::consts::TAU;
            [middle[0] + size * angle.cos(), middle[1] + size * angle.sin()]
        })
        .collect()
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>() / 2.0
}
