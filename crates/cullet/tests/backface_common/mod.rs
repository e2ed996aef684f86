//! What the tests of back-face culling share.
#![allow(dead_code, reason = "each test uses some of it")]

use cullet_testkit::data;

/// A small generator of numbers; the same on every machine.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    /// In -1..1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    }

    pub(crate) fn vector(&mut self) -> [f64; 3] {
        [self.unit(), self.unit(), self.unit()]
    }

    /// Of unit length.
    pub(crate) fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = self.vector();
            let length = dot(v, v).sqrt();
            if (0.01..=1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((self.unit() * 0.5 + 0.5) * n as f64) as usize
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Direction `i` of `count` of a Fibonacci lattice.
pub(crate) fn fibonacci(i: usize, count: usize) -> [f64; 3] {
    let z = (2 * i + 1) as f64 / count as f64 - 1.0;
    let angle = i as f64 * 2.399_963_229_728_653;
    let r = (1.0 - z * z).sqrt();
    [r * angle.cos(), r * angle.sin(), z]
}

/// n·e − d·w in f64, positive in front, and the size of its terms.
pub(crate) fn front(corners: [[f32; 3]; 3], eye: [f64; 4]) -> (f64, f64) {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let n = cross(std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    let e: [f64; 3] = std::array::from_fn(|k| eye[k] - a[k] * eye[3]);
    let terms = [n[0] * e[0], n[1] * e[1], n[2] * e[2]];
    (terms.iter().sum(), terms.iter().map(|t| t.abs()).sum())
}

/// A model of the test data; `None` where it is not there.
pub(crate) fn model(path: &str) -> Option<(Vec<[f32; 3]>, Vec<u32>)> {
    let file = data(path)?;
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    Some(if path.ends_with(".ply") { ply(&text) } else { obj(&text) })
}

/// ASCII PLY with positions first and triangles.
fn ply(text: &str) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (header, body) = text.split_once("end_header\n").expect("a header");
    let vertices: usize = header
        .lines()
        .find_map(|l| l.strip_prefix("element vertex "))
        .and_then(|n| n.trim().parse().ok())
        .expect("a number of vertices");
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for (i, line) in body.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        if i < vertices {
            positions.push(std::array::from_fn(|_| {
                words.next().and_then(|w| w.parse().ok()).expect("a coordinate")
            }));
        } else {
            indices.extend(words.skip(1).take(3).map(|w| w.parse::<u32>().expect("an index")));
        }
    }
    (positions, indices)
}

/// OBJ of positions and triangles.
fn obj(text: &str) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => positions.push(std::array::from_fn(|_| {
                words.next().and_then(|w| w.parse().ok()).expect("a coordinate")
            })),
            Some("f") => indices.extend(words.take(3).map(|w| {
                let index = w.split('/').next().and_then(|w| w.parse::<u32>().ok());
                index.expect("an index") - 1
            })),
            _ => {}
        }
    }
    (positions, indices)
}
