//! `cullet-baker simplify`, run as a program, its results measured again without it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use cullet_draw::surface::deviation;
use cullet_io::{LoadOptions, Model};
use cullet_maps::load;
use cullet_testkit::{data, soups};
use serde_json::Value;

/// A folder of its own, gone when the test is.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("cullet-simplify-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn baker(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet-baker")).args(args).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// Runs with `--json -`; the figures.
fn figures(args: &[&str]) -> Value {
    let output = baker(&[&["simplify"], args, &["--json", "-"]].concat());
    assert!(output.status.success(), "{}", told(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn loaded(path: &str) -> Model {
    load(Path::new(path), &LoadOptions { details: true, ..LoadOptions::default() }).unwrap()
}

/// All instances of a model as one surface in world space.
fn surface(model: &Model) -> (Vec<[f32; 3]>, Vec<u32>) {
    let scene = &model.scene;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for slot in scene.slots() {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let base = positions.len() as u32;
        positions.extend(mesh.positions().iter().map(|p| -> [f32; 3] {
            std::array::from_fn(|a| {
                let turned: f64 =
                    (0..3).map(|c| f64::from(transform.linear[c][a]) * f64::from(p[c])).sum();
                (turned + transform.translation[a]) as f32
            })
        }));
        indices.extend(mesh.indices().iter().map(|i| i + base));
    }
    (positions, indices)
}

fn ply(path: &str, (positions, indices): &soups::Soup) {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        positions.len(),
        indices.len() / 3
    );
    for [x, y, z] in positions {
        text += &format!("{x} {y} {z}\n");
    }
    for t in indices.chunks_exact(3) {
        text += &format!("3 {} {} {}\n", t[0], t[1], t[2]);
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn every_format_holds_the_few_triangles_that_the_figures_speak_of() {
    let folder = Folder::new("formats");
    let source = folder.path("ball.ply");
    ply(&source, &soups::bumpy_ball(40, 0.1));
    let whole = surface(&loaded(&source));
    for name in ["small.ply", "small.glb", "small.obj"] {
        let out = folder.path(name);
        let told = figures(&[&source, "--error", "0.01", "--samples", "100000", "-o", &out]);
        let number = |key: &str| told[key].as_f64().unwrap_or_else(|| panic!("{key}: {told}"));
        assert_eq!(told["schema"], 1);
        assert!(number("error") > 0.0 && number("error") <= 0.0108 * 1.001, "{told}");
        assert!(number("error_measured_p999") <= 0.01, "{told}");
        assert!(number("error_measured_max") <= 0.012, "{told}");
        assert_eq!(number("open_edges"), 0.0);
        assert!(number("points") >= 200_000.0);
        let small = loaded(&out);
        assert_eq!(small.scene.triangle_count() as f64, number("triangles"));
        assert!(number("triangles") * 2.0 < number("triangles_before"), "{told}");
        // Measured once more, from other points.
        let small = surface(&small);
        let found = deviation((&whole.0, &whole.1), (&small.0, &small.1), 50_000, 77);
        let radius = number("radius");
        assert!(f64::from(found.p999) <= 0.01 * radius, "{found:?}");
        assert!(f64::from(found.max) <= 0.012 * radius, "{found:?}");
    }
}

#[test]
fn instances_of_different_size_keep_the_bound_of_the_scene() {
    let folder = Folder::new("instances");
    let out = folder.path("solids.glb");
    let told = figures(&["solids", "--error", "0.002", "--samples", "50000", "-o", &out]);
    let number = |key: &str| told[key].as_f64().unwrap_or_else(|| panic!("{key}: {told}"));
    let before = cullet_scenes::build("solids").unwrap();
    let (whole, small) = (surface(&before), surface(&loaded(&out)));
    let found = deviation((&whole.0, &whole.1), (&small.0, &small.1), 100_000, 77);
    assert!(f64::from(found.max) <= 0.0024 * number("radius"), "{found:?}, {told}");
    assert!(number("triangles") < number("triangles_before"), "{told}");
}

#[test]
fn an_eye_far_away_needs_fewer_triangles_and_sees_no_more_than_its_pixels() {
    let folder = Folder::new("eye");
    let source = folder.path("ball.ply");
    ply(&source, &soups::bumpy_ball(60, 0.1));
    let whole = surface(&loaded(&source));
    let mut before = f64::INFINITY;
    for distance in ["2", "8", "40"] {
        let out = folder.path("small.ply");
        let args =
            [&source, "--pixels", "1", "--distance", distance, "--samples", "20000", "-o", &out];
        let told = figures(&args);
        let number = |key: &str| told[key].as_f64().unwrap_or_else(|| panic!("{key}: {told}"));
        assert!(number("triangles") < before, "{told}");
        before = number("triangles");
        assert_eq!(number("open_edges"), 0.0, "{told}");
        // The back of it may be farther off than the front, by as much as it is farther away.
        let far: f64 = distance.parse().unwrap();
        let pixel = 0.577_350_27 / 540.0 * (far + 1.0) * number("radius");
        let small = surface(&loaded(&out));
        let found = deviation((&whole.0, &whole.1), (&small.0, &small.1), 50_000, 77);
        assert!(f64::from(found.max) <= 1.2 * pixel, "{found:?}, a pixel is {pixel}");
    }
    assert!(before < 2000.0, "{before}");
}

#[test]
fn no_error_allowed_leaves_the_shape_alone() {
    let folder = Folder::new("zero");
    let source = folder.path("block.ply");
    ply(&source, &soups::divided_block(6));
    let told = figures(&[&source, "--error", "0", "--samples", "2000"]);
    assert!(told["error_measured_max"].as_f64().unwrap() < 1e-6, "{told}");
    assert!(told["triangles"].as_u64() <= told["triangles_before"].as_u64());
}

#[test]
fn wrong_values_and_files_end_with_their_codes() {
    let folder = Folder::new("wrong");
    let source = folder.path("ball.ply");
    ply(&source, &soups::ball(6, 12));
    for (args, code, word) in [
        (&["simplify", "city"][..], 2, "--error"),
        (&["simplify", "city", "--error", "-1"], 2, "bounding radius"),
        (&["simplify", "city", "--pixels", "1"], 2, "--distance"),
        (&["simplify", "city", "--pixels", "-1", "--distance", "2"], 2, "pixels"),
        (&["simplify", "city", "--pixels", "1", "--distance", "0"], 2, "distance"),
        (&["simplify", "city", "--error", "1", "--pixels", "1", "--distance", "2"], 2, "--pixels"),
        (&["simplify", "city", "--error", "nan"], 2, "bounding radius"),
        (&["simplify", "city", "--error", "two"], 2, "bounding radius"),
        (&["simplify", &source, "--error", "0.1", "-o", "small.xyz"], 2, "small.xyz"),
        (&["simplify", "/nonexistent/a.ply", "--error", "0.1"], 3, "/nonexistent/a.ply"),
        (
            &["simplify", &source, "--error", "0.1", "-o", "/nonexistent/a.ply"],
            2,
            "no folder /nonexistent",
        ),
        (&["simplify", &source, "--error", "0.1", "--max-triangles", "9"], 4, "--max-triangles"),
    ] {
        let output = baker(args);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", told(&output));
        assert!(told(&output).contains(word), "{args:?}: {}", told(&output));
    }
}

#[test]
fn a_scan_and_a_machine_part_keep_their_bound() {
    for (name, error, most) in [
        ("classic-meshes/fandisk.obj", "0.001", 2600),
        ("classic-meshes/rocker-arm.obj", "0.003", 9000),
    ] {
        let Some(path) = data(name) else { continue };
        let told = figures(&[&path.to_string_lossy(), "--error", error, "--samples", "500000"]);
        let bound: f64 = error.parse().unwrap();
        let number = |key: &str| told[key].as_f64().unwrap_or_else(|| panic!("{key}: {told}"));
        assert!(number("error_measured_p999") <= bound, "{name}: {told}");
        assert!(number("error_measured_max") <= 1.2 * bound, "{name}: {told}");
        assert_eq!(told["open_edges"], told["open_edges_before"], "{name}");
        assert!(number("triangles") <= f64::from(most), "{name}: {told}");
    }
}
