//! Test models: closed shapes made here, and files from the shared test data.
#![allow(dead_code, reason = "each test program uses its own share")]

use cullet_testkit::data;

/// Positions and indices.
pub(crate) type Soup = (Vec<[f32; 3]>, Vec<u32>);

/// The box between two corners, wound outward.
pub(crate) fn block(min: [f32; 3], max: [f32; 3]) -> Soup {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { max[a] } else { min[a] });
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    ((0..8).map(corner).collect(), indices)
}

/// A ball of `rings` × 2 `rings` quads, wound outward.
pub(crate) fn ball(center: [f32; 3], radius: f32, rings: u32) -> Soup {
    let mut positions = Vec::new();
    let around = rings * 2;
    for i in 0..=rings {
        for j in 0..around {
            let (a, b) = (i as f32 / rings as f32, j as f32 / around as f32);
            let (polar, azimuth) = (a * std::f32::consts::PI, b * std::f32::consts::TAU);
            // Exactly one point at each pole.
            let r = if i == 0 || i == rings { 0.0 } else { polar.sin() };
            let p = [r * azimuth.cos(), polar.cos(), r * azimuth.sin()];
            positions.push(std::array::from_fn(|k| center[k] + radius * p[k]));
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            let at = |i: u32, j: u32| i * around + j % around;
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            if i > 0 {
                indices.extend([a, b, c]);
            }
            if i + 1 < rings {
                indices.extend([a, c, d]);
            }
        }
    }
    (positions, indices)
}

/// A bumpy square sheet of `side`² quads, with a mean slope of about one half.
pub(crate) fn terrain(side: u32) -> Soup {
    let mut positions = Vec::new();
    for y in 0..=side {
        for x in 0..=side {
            let (u, v) = (x as f32 * 0.11, y as f32 * 0.07);
            positions.push([x as f32, (u.sin() + v.cos()) * 4.0, y as f32]);
        }
    }
    let mut indices = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let a = y * (side + 1) + x;
            indices.extend([a, a + side + 1, a + 1, a + 1, a + side + 1, a + side + 2]);
        }
    }
    (positions, indices)
}

/// Several soups as one.
pub(crate) fn join(soups: impl IntoIterator<Item = Soup>) -> Soup {
    let (mut positions, mut indices) = Soup::default();
    for (p, i) in soups {
        let base = positions.len() as u32;
        positions.extend(p);
        indices.extend(i.into_iter().map(|i| i + base));
    }
    (positions, indices)
}

/// Every triangle turned over.
pub(crate) fn turned((positions, mut indices): Soup) -> Soup {
    indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    (positions, indices)
}

/// Reads an ASCII PLY, an OFF or an OBJ file, as far as the test models need; polygons become fans.
pub(crate) fn read(name: &str) -> Option<Soup> {
    let bytes = std::fs::read(data(name)?).expect("readable");
    if name.ends_with(".ply") && !bytes.starts_with(b"ply\nformat ascii") {
        return Some(read_binary_ply(&bytes));
    }
    let text = String::from_utf8_lossy(&bytes);
    let (mut positions, mut indices) = Soup::default();
    let fan = |indices: &mut Vec<u32>, corners: &[u32]| {
        for i in 2..corners.len() {
            indices.extend([corners[0], corners[i - 1], corners[i]]);
        }
    };
    if name.ends_with(".obj") {
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let v: Vec<f32> = words.map(|w| w.parse().expect("number")).collect();
                    positions.push([v[0], v[1], v[2]]);
                }
                Some("f") => {
                    let index = |w: &str| {
                        let i: i64 = w.split('/').next().expect("index").parse().expect("index");
                        (if i < 0 { positions.len() as i64 + i } else { i - 1 }) as u32
                    };
                    fan(&mut indices, &words.map(index).collect::<Vec<_>>());
                }
                _ => {}
            }
        }
        return Some((positions, indices));
    }
    let count = |what: &str| {
        let line = text.lines().find(|l| l.starts_with(what)).expect("count");
        line.rsplit(' ').next().expect("count").trim().parse::<usize>().expect("count")
    };
    let (body, vertices, faces) = if name.ends_with(".ply") {
        let end = text.find("end_header").expect("header");
        (&text[end + 10..], count("element vertex"), count("element face"))
    } else {
        let mut lines = text.splitn(3, '\n');
        lines.next();
        let counts: Vec<usize> = lines
            .next()
            .expect("counts")
            .split_whitespace()
            .map(|w| w.parse().expect("n"))
            .collect();
        (lines.next().expect("body"), counts[0], counts[1])
    };
    let mut lines = body.lines().filter(|l| !l.trim().is_empty());
    for line in lines.by_ref().take(vertices) {
        let v: Vec<f32> = line.split_whitespace().map(|w| w.parse().expect("number")).collect();
        positions.push([v[0], v[1], v[2]]);
    }
    for line in lines.take(faces) {
        let f: Vec<u32> = line.split_whitespace().map(|w| w.parse().expect("index")).collect();
        fan(&mut indices, &f[1..=f[0] as usize]);
    }
    Some((positions, indices))
}

/// A little-endian PLY whose vertices are floats and whose faces are lists (u8, then u32).
fn read_binary_ply(bytes: &[u8]) -> Soup {
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let count = |what: &str| {
        let line = header.lines().find(|l| l.starts_with(what)).expect("count");
        line.rsplit(' ').next().expect("count").parse::<usize>().expect("count")
    };
    let stride = 4 * header.lines().filter(|l| l.starts_with("property float")).count();
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let vertices = count("element vertex");
    let positions = (0..vertices)
        .map(|v| [0, 4, 8].map(|k| f32::from_le_bytes(word(end + v * stride + k))))
        .collect();
    let (mut at, mut indices) = (end + vertices * stride, Vec::new());
    for _ in 0..count("element face") {
        let n = bytes[at] as usize;
        let corner = |i: usize| u32::from_le_bytes(word(at + 1 + i * 4));
        for i in 2..n {
            indices.extend([corner(0), corner(i - 1), corner(i)]);
        }
        at += 1 + n * 4;
    }
    (positions, indices)
}
