//! Cutting a sphere open: with one plane and with the six of a box, left open and capped.

use cullet::bounds::Plane;
use cullet_cut::{CapOptions, CutInput, CutMesh, CutOptions, Keep, box_planes, cut};
use cullet_mesh::Topology;
use glam::DVec3;

use super::measure::beside_reading;
use super::measured::{Measured, Workload};
use super::options::BenchOptions;

/// Triangles of the sphere.
const TRIANGLES: usize = 1_000_000;
/// Numbers a vertex: a normal, texture coordinates and a colour.
const STRIDE: usize = 3 + 2 + 4;

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    let len = options.sizes.iter().copied().max().unwrap_or(0).min(TRIANGLES);
    let plane = vec![Plane::new([0.48, 0.6, 0.64], 0.05)];
    let cube = box_planes([-0.6, -0.5, -0.7], [0.5, 0.6, 0.4]).to_vec();
    let name = |what: &str| {
        let digits = (len as f64).log10().floor() as u32;
        format!("cut/{what}/{}e{digits}", len / 10usize.pow(digits))
    };
    let work = [
        ("plane/open", &plane, false, 0),
        ("plane/open+uv", &plane, false, STRIDE),
        ("plane/capped", &plane, true, 0),
        ("box/open", &cube, false, 0),
        ("box/open+uv", &cube, false, STRIDE),
        ("box/capped", &cube, true, 0),
    ];
    let wanted = |name: &str| options.filter.as_ref().is_none_or(|f| name.contains(f.as_str()));
    if !work.iter().any(|w| wanted(&name(w.0))) {
        return;
    }
    let (positions, indices) = sphere(len);
    for (what, planes, capped, stride) in work.into_iter().filter(|w| wanted(&name(w.0))) {
        let attributes = vec![0.5; positions.len() * stride];
        let input =
            CutInput { positions: &positions, indices: &indices, attributes: &attributes, stride };
        let caps = capped.then(CapOptions::default);
        let settings = CutOptions { keep: Keep::Inside, caps };
        let mut done = CutMesh::default();
        let items = indices.len() / 3;
        // Bytes that must be read, and bytes that must be written, each once.
        let read = positions.len() * (12 + stride * 4) + indices.len() * 4;
        let first = cut(&input, planes, &settings).unwrap_or_default();
        let written = first.positions.len() * (12 + stride * 4) + first.indices.len() * 4;
        let times = beside_reading(options.seconds, read + written, || {
            done = cut(&input, planes, &settings).unwrap_or_default();
        });
        let checked = if capped {
            Topology::of(&done.positions, &done.indices).boundary_edges == 0
                && !done.caps.is_empty()
        } else {
            let (left, right) = (area(&done.positions, &done.indices), area_ref(&input, planes));
            done == first && (left - right).abs() < right * 1e-5
        };
        let visible = done.origin.len();
        let workload = Workload { name: name(what), level: "scalar", items, visible, checked };
        each(workload.streaming((read + written) / items, times));
    }
}

/// A closed sphere of about so many triangles.
fn sphere(len: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    // Twice as many around as from pole to pole, two triangles each.
    let rings = ((len as f64 / 4.0).sqrt().round() as u32).max(3);
    let around = rings * 2;
    let (mut positions, mut indices) = (vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], vec![]);
    for i in 1..rings {
        let (r, y) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
        for j in 0..around {
            let (s, c) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            positions.push([(r * c) as f32, y as f32, (-r * s) as f32]);
        }
    }
    let at = |i: u32, j: u32| 2 + (i - 1) * around + j % around;
    for i in 0..rings {
        for j in 0..around {
            match i {
                0 => indices.extend([0, at(1, j), at(1, j + 1)]),
                _ if i == rings - 1 => indices.extend([1, at(i, j + 1), at(i, j)]),
                _ => {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    indices.extend([a, b, c, a, c, d]);
                }
            }
        }
    }
    (positions, indices)
}

fn area(positions: &[[f32; 3]], indices: &[u32]) -> f64 {
    let at = |v: u32| DVec3::from(positions[v as usize].map(f64::from));
    let one = |t: &[u32]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).length() * 0.5;
    indices.chunks_exact(3).map(one).sum()
}

/// The oracle: each triangle clipped on its own, in f64 (Sutherland & Hodgman, *Reentrant Polygon
/// Clipping*, 1974).
fn area_ref(input: &CutInput<'_>, planes: &[Plane]) -> f64 {
    let one = |t: &[u32]| {
        let at = |v: u32| DVec3::from(input.positions[v as usize].map(f64::from));
        let mut polygon: Vec<DVec3> = t.iter().map(|&v| at(v)).collect();
        for plane in planes {
            let mut clipped = Vec::with_capacity(polygon.len() + 1);
            for (i, &p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                let (a, b) = (plane.distance(p), plane.distance(q));
                if a <= 0.0 {
                    clipped.push(p);
                }
                if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                    clipped.push(p + (q - p) * (a / (a - b)));
                }
            }
            polygon = clipped;
        }
        let fan = |w: &[DVec3]| (w[0] - polygon[0]).cross(w[1] - polygon[0]).length() * 0.5;
        polygon.windows(2).map(fan).sum::<f64>()
    };
    input.indices.chunks_exact(3).map(one).sum()
}
