//! Answers of the engine on five baked files, with which every host is compared, bit for bit.
//!
//! The files and the answers in full, `golden.json`, are written to the folder that `CULLET_GOLDEN`
//! names, else to one of this test, so that hosts can read them. `answers.txt` has a line for each
//! view, so that a change of an answer is seen where it is made; `CULLET_WRITE_GOLDEN=1` takes the
//! new ones over.

mod answer;
mod view;

use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;

use answer::{Golden, Scene};

/// The answers that are kept.
const KEPT: &str = include_str!("answers.txt");

/// The files, and the scenes that they are baked from.
const SCENES: &[(&str, &str)] = &[
    ("city", "city:cells=8,objects=300"),
    ("forest", "forest:n=600"),
    ("knobs", "knobs:n=12"),
    ("office", "office:rooms=3,corridors=1,floors=1"),
    ("solids", "solids:n=48"),
];

fn folder() -> PathBuf {
    let named = std::env::var_os("CULLET_GOLDEN").filter(|v| !v.is_empty());
    named.map_or_else(|| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("golden"), PathBuf::from)
}

#[test]
fn answers_on_baked_files_are_those_of_before() {
    let folder = folder();
    std::fs::create_dir_all(&folder).unwrap();
    let mut scenes = Vec::new();
    for (name, scene) in SCENES {
        let file = folder.join(name).with_extension("glb");
        let mut bake = Command::new(env!("CARGO_BIN_EXE_cullet-baker"));
        let baked = bake.args(["--quiet", "bake", scene, "--occluders", "-o"]).arg(&file).status();
        assert!(baked.unwrap().success(), "{scene}");
        scenes.push(Scene::of(&file).unwrap());
    }
    let golden = Golden { scenes };
    std::fs::write(folder.join("golden.json"), serde_json::to_vec(&golden).unwrap()).unwrap();
    let lines = lines(&golden);
    if std::env::var_os("CULLET_WRITE_GOLDEN").is_some() {
        let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/answers.txt");
        std::fs::write(kept, &lines).unwrap();
        return;
    }
    let other: Vec<&str> =
        lines.lines().filter(|line| !KEPT.lines().any(|kept| kept == *line)).collect();
    assert!(other.is_empty() && lines == KEPT, "other answers:\n{}", other.join("\n"));
}

/// A line for each view: how much is visible, and a sum over which.
fn lines(golden: &Golden) -> String {
    let mut text = String::new();
    for scene in &golden.scenes {
        for (number, view) in scene.views.iter().enumerate() {
            // FNV-1a, over the indices and all counts.
            let counts = view.funnel.iter().flat_map(|row| [row.entered, row.left].concat());
            let numbers = view.visible.iter().map(|&index| u64::from(index)).chain(counts);
            let sum =
                numbers.flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| {
                    (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
                });
            let (name, of) = (&scene.name, scene.instances);
            let _ = writeln!(
                text,
                "{name} {number} {}: {} of {of}, {sum:016x}",
                view.preset,
                view.visible.len()
            );
        }
    }
    text
}
