//! Models that tests of the viewer open.

use std::fmt::Write as _;
use std::path::PathBuf;

/// A ball with lumps, as a rabbit or an armadillo has limbs, of some thousand triangles as OBJ, which says nothing of sides; without the last `missing` triangles,
/// so that it is open.
pub(crate) fn ball(missing: usize) -> String {
    const RINGS: usize = 40;
    const AROUND: usize = 60;
    let mut out = String::from("v 0 1 0\n");
    for ring in 1..RINGS {
        let polar = std::f64::consts::PI * ring as f64 / RINGS as f64;
        let (out_of, up) = polar.sin_cos();
        for i in 0..AROUND {
            let turn = std::f64::consts::TAU * i as f64 / AROUND as f64;
            let (sin, cos) = turn.sin_cos();
            let far = 1.0 + 0.3 * (5.0 * turn).sin() * (6.0 * polar).sin();
            let [x, y, z] = [far * out_of * sin, far * up, far * out_of * cos];
            let _ = writeln!(out, "v {x} {y} {z}");
        }
    }
    out.push_str("v 0 -1 0\n");
    let at = |ring: usize, i: usize| 2 + (ring - 1) * AROUND + i % AROUND;
    let mut faces = Vec::new();
    for i in 0..AROUND {
        faces.push([1, at(1, i), at(1, i + 1)]);
        for ring in 1..RINGS - 1 {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)];
            faces.extend([[a, c, d], [a, d, b]]);
        }
    }
    let last = 2 + (RINGS - 1) * AROUND;
    faces.extend((0..AROUND).map(|i| [at(RINGS - 1, i), last, at(RINGS - 1, i + 1)]));
    faces.truncate(faces.len() - missing);
    for [a, b, c] in faces {
        let _ = writeln!(out, "f {a} {b} {c}");
    }
    out
}

/// A model of the shared test data, or `None`, with a line that says so, where it is not there.
#[allow(dead_code, reason = "not every test file opens one")]
pub(crate) fn data(path: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CULLET_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = folder.join(path);
    let there = path.is_file();
    if !there {
        println!("skipped: {} is not there; set CULLET_DATA", path.display());
    }
    there.then_some(path)
}
