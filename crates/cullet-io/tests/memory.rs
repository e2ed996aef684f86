//! Loading takes at most three times the decoded geometry, in every format that has no test of its own:
//! files are read in blocks, arrays grow by little, and the check for solids is lean.

use std::fmt::Write as _;
use std::time::Instant;

use cullet::prepared::Preparation;
use cullet_io::{LoadOptions, load};
use cullet_testkit::memory::{Counting, peak_of};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A torus of 2·n² triangles: closed, so that the check for solids goes all the way.
fn torus(n: u32) -> Soup {
    let turn = |i: u32| (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
    let points = (0..n * n).map(|i| {
        let ((s, c), (t, d)) = (turn(i / n), turn(i % n));
        let r = 3.0 + d;
        [r * c, t, -r * s]
    });
    let triangles = (0..n * n).flat_map(|i| {
        let (u, v) = (i / n, i % n);
        let at = |u: u32, v: u32| u % n * n + v % n;
        let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u, v + 1), at(u + 1, v + 1)];
        [[a, b, c], [c, b, d]]
    });
    (points.collect(), triangles.collect())
}

/// The same triangles, none of which shares a vertex with another, and drawn apart.
fn shattered((points, triangles): &Soup) -> Soup {
    let corners = triangles
        .iter()
        .enumerate()
        .flat_map(|(k, t)| t.map(|v| points[v as usize].map(|x| x + k as f32 * 0.01)));
    let triangles = (0..triangles.len() as u32).map(|t| [t * 3, t * 3 + 1, t * 3 + 2]);
    (corners.collect(), triangles.collect())
}

fn obj((points, triangles): &Soup) -> Vec<u8> {
    let mut out = String::from("o torus\n");
    for [x, y, z] in points {
        writeln!(out, "v {x} {y} {z}").unwrap();
    }
    for t in triangles {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(out, "f {a}//1 {b}//1 {c}//1").unwrap();
    }
    out.into_bytes()
}

/// Two groups with two materials each, none in one stretch.
fn obj_groups((points, triangles): &Soup) -> Vec<u8> {
    let mut out = String::new();
    for [x, y, z] in points {
        writeln!(out, "v {x} {y} {z}").unwrap();
    }
    for (k, t) in triangles.iter().enumerate() {
        if k % 1000 == 0 {
            let (group, material) = (k / 1000 % 2, k / 2000 % 2);
            writeln!(out, "g group{group}\nusemtl material{material}").unwrap();
        }
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(out, "f {a} {b} {c}").unwrap();
    }
    out.into_bytes()
}

fn ply_header((points, triangles): &Soup, format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    )
}

fn ply_ascii(soup: &Soup) -> Vec<u8> {
    let mut out = ply_header(soup, "ascii");
    for [x, y, z] in &soup.0 {
        writeln!(out, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in &soup.1 {
        writeln!(out, "3 {a} {b} {c}").unwrap();
    }
    out.into_bytes()
}

fn ply_binary(soup: &Soup) -> Vec<u8> {
    let mut out = ply_header(soup, "binary_little_endian").into_bytes();
    soup.0.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
    for t in &soup.1 {
        out.push(3);
        t.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    out
}

fn off((points, triangles): &Soup) -> Vec<u8> {
    let mut out = format!("OFF\n{} {} 0\n", points.len(), triangles.len());
    for [x, y, z] in points {
        writeln!(out, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(out, "3 {a} {b} {c}").unwrap();
    }
    out.into_bytes()
}

fn stl_binary((points, triangles): &Soup) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0; 12]);
        t.iter().flat_map(|&v| points[v as usize]).for_each(|x| out.extend(x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn stl_ascii((points, triangles): &Soup) -> Vec<u8> {
    let mut out = String::from("solid torus\n");
    for t in triangles {
        out.push_str("facet normal 0 0 1\nouter loop\n");
        for [x, y, z] in t.map(|v| points[v as usize]) {
            writeln!(out, "vertex {x} {y} {z}").unwrap();
        }
        out.push_str("endloop\nendfacet\n");
    }
    out.push_str("endsolid torus\n");
    out.into_bytes()
}

/// Triangles along each side of the torus; the variable sets another size, to measure.
fn side() -> u32 {
    std::env::var("CULLET_MEMORY_SIDE").ok().and_then(|n| n.parse().ok()).unwrap_or(354)
}

/// Data prepared for culling would come on top of what a file takes.
fn unprepared() -> LoadOptions {
    LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() }
}

#[test]
fn loading_takes_at_most_three_times_the_geometry() {
    type Writer = fn(&Soup) -> Vec<u8>;
    let (joined, apart) = (torus(side()), shattered(&torus(side())));
    let formats: [(&str, &Soup, Writer); 11] = [
        ("a.obj", &joined, obj),
        ("groups.obj", &joined, obj_groups),
        ("ascii.ply", &joined, ply_ascii),
        ("binary.ply", &joined, ply_binary),
        ("a.off", &joined, off),
        ("binary.stl", &joined, stl_binary),
        ("ascii.stl", &joined, stl_ascii),
        ("apart.obj", &apart, obj),
        ("apart.ply", &apart, ply_binary),
        ("apart.stl", &apart, stl_binary),
        ("apart-ascii.stl", &apart, stl_ascii),
    ];
    let mut over = Vec::new();
    for (name, soup, write) in formats {
        let file = std::env::temp_dir().join(format!("cullet-{}-{name}", std::process::id()));
        std::fs::write(&file, write(soup)).unwrap();
        let start = Instant::now();
        let (model, peak) = peak_of(|| load(&file, &unprepared()));
        let elapsed = start.elapsed();
        std::fs::remove_file(&file).unwrap();
        let model = model.unwrap();
        let meshes = model.scene.meshes();
        let triangles: usize = meshes.iter().map(|m| m.triangle_count() as usize).sum();
        assert_eq!(triangles, soup.1.len(), "{name}");
        let solid = std::ptr::eq(soup, &joined) && meshes.len() == 1;
        assert!(meshes.iter().all(|m| m.is_two_sided() != solid), "{name}");
        let geometry: usize =
            meshes.iter().map(|m| size_of_val(m.positions()) + size_of_val(m.indices())).sum();
        let ratio = peak as f64 / geometry as f64;
        println!("{name}: {triangles} triangles in {elapsed:?}, {ratio:.2} times {geometry} bytes");
        if ratio > 3.0 {
            over.push(format!("{name} took {ratio:.2} times its geometry"));
        }
    }
    assert_eq!(over, Vec::<String>::new());
}
