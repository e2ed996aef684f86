//! The program on frames whose slowest link is known, on scenes, and on what cannot be.

use std::process::{Command, Output};

use cullet_gpu::{Tier, testing};
use serde_json::Value;

/// Runs `cullet-profile profile` with some words; skips without a device.
fn profile(words: &[&str]) -> Option<Output> {
    testing::device(Tier::Compute, cullet_testkit::skip)?;
    let mut program = Command::new(env!("CARGO_BIN_EXE_cullet-profile"));
    Some(program.arg("profile").args(words).output().unwrap())
}

fn json(words: &[&str]) -> Option<Value> {
    let found = profile(words)?;
    let said = String::from_utf8_lossy(&found.stderr);
    assert!(found.status.success(), "{words:?}: {said}");
    Some(serde_json::from_slice(&found.stdout).unwrap())
}

/// Whether a frame that waits for one link is found to, in one of three tries: other tests run
/// beside.
fn is_named(link: &str) -> Option<bool> {
    for _ in 0..3 {
        let found = json(&["--quiet", link, "--rounds", "11", "--json", "-"])?;
        if found["limit"] == link {
            return Some(true);
        }
        eprintln!("{found:#}");
    }
    Some(false)
}

#[test]
fn what_a_frame_waits_for_is_named() {
    for link in ["fill", "transform", "bus", "cpu"] {
        let Some(named) = is_named(link) else { return };
        assert!(named, "{link}");
    }
}

/// Runs by hand, on a quiet machine: `cargo test --release -p cullet-profile -- --ignored
/// --nocapture`.
#[test]
#[ignore = "takes ten minutes, and a machine that does nothing else"]
fn what_a_frame_waits_for_is_named_in_twenty_of_twenty_runs() {
    for link in ["fill", "transform", "bus", "cpu"] {
        let run = |_: &i32| json(&[link, "--rounds", "15", "--json", "-"]).unwrap();
        let named = (0..20).filter(|n| run(n)["limit"] == link).count();
        println!("{link}: {named} of 20");
        assert_eq!(named, 20, "{link}");
    }
}

#[test]
fn a_scene_is_told_with_every_stage_and_drawn() {
    let folder = std::env::temp_dir().join(format!("cullet-profile-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let picture = folder.join("chain.svg");
    let words =
        ["city:cells=6", "--size", "160x90", "--views", "2", "--rounds", "3", "--json", "-"];
    let more = ["--out", picture.to_str().unwrap(), "--lod", "0"];
    let Some(found) = json(&[&words[..], &more].concat()) else { return };
    assert_eq!(found["schema"], 1);
    assert_eq!(found["rounds"], 3);
    assert!(found["frame_ms"].as_f64().unwrap() > 0.0);
    for link in ["fill", "transform", "bus", "cpu"] {
        assert!(found["elasticity"][link].is_f64());
        let [low, high] = [0, 1].map(|at| found["interval"][link][at].as_f64().unwrap());
        let value = found["elasticity"][link].as_f64().unwrap();
        assert!(low <= value && value <= high, "{link}");
    }
    let stages: Vec<&str> =
        found["relief"].as_array().unwrap().iter().map(|r| r["stage"].as_str().unwrap()).collect();
    assert_eq!(stages, ["frustum", "occlusion", "backface", "degenerate", "all"]);
    let drawn = std::fs::read_to_string(&picture).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("occlusion"));
}

#[test]
fn what_a_program_culls_already_is_not_tried_again() {
    let words =
        ["knobs:n=9", "--size", "64x64", "--views", "1", "--rounds", "3", "--already", "frustum"];
    let Some(found) = json(&[&words[..], &["--only", "occlusion", "--json", "-"]].concat()) else {
        return;
    };
    let relief = found["relief"].as_array().unwrap();
    assert_eq!(relief.len(), 1);
    assert_eq!(relief[0]["stage"], "occlusion");
}

#[test]
fn what_cannot_be_is_told() {
    for (words, code, told) in [
        (&["missing.glb"][..], 3, "missing.glb"),
        (&["city:cells=6", "--lod", "1"], 3, "cullet bake"),
        (&["city:cells=6", "--size", "16384x16384"], 4, "16384"),
        (&["city", "--rounds", "1"], 2, "--rounds"),
        (&["city", "--out", "no/such/profile.svg"], 2, "no folder no/such"),
    ] {
        let Some(found) = profile(words) else { return };
        let said = String::from_utf8_lossy(&found.stderr);
        assert_eq!(found.status.code(), Some(code), "{words:?}: {said}");
        assert!(said.contains(told), "{words:?}: {said}");
    }
}
