//! `cullet reproduce assarsson-moller`: all answers agree, the tricks save what they promise, and
//! bad input is told.

use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::Value;

fn reproduce(out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args(["reproduce", "assarsson-moller", "--json", "-", "--frames", "20"])
        .arg("--out")
        .arg(out)
        .args(more)
        .output()
        .unwrap()
}

fn found(output: &Output) -> Value {
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn tricks_save_tests_and_change_no_answer() {
    let folder = Folder::new("assarsson-moller");
    for more in [["--degrees", "1.2"], ["--degrees", "0"]] {
        let output = reproduce(folder.root(), &[&["--model", "forest:n=5000"], &more[..]].concat());
        let record = found(&output);
        assert_eq!(record["schema"], 1);
        assert_eq!((&record["boxes"], &record["frames"]), (&5001.into(), &20.into()));
        for fault in ["frames_differing", "lost"] {
            assert_eq!(record[fault], 0, "{fault}");
        }
        assert!(record["visible_in_all"].as_u64().unwrap() > 1000);
        let rows = record["rows"].as_array().unwrap();
        let tests = |variant: &str| {
            let row = rows.iter().find(|r| r["variant"] == variant).unwrap();
            row["plane_tests"].as_f64().unwrap()
        };
        let plain = tests("plain");
        assert!(tests("octant test") < 0.7 * plain);
        assert!(tests("masking") < 0.5 * plain);
        assert!(tests("plane coherency") < plain);
        assert!(tests("motion coherency") < plain);
        assert!(tests("all four") < tests("masking"));
        assert_eq!(record["wide"].as_array().unwrap().len(), 1);
        for name in ["assarsson-moller.svg", "assarsson-moller.png", "assarsson-moller.json"] {
            assert!(folder.root().join(name).metadata().unwrap().len() > 1000, "{name}");
        }
    }
}

#[test]
fn what_cannot_be_is_said() {
    let folder = Folder::new("assarsson-moller-bad");
    for (more, code, words) in [
        (["--degrees", "NaN"], 2, "not an angle of 0 to 180"),
        (["--stride", "far"], 2, "not a length of 0 to 1e9"),
        (["--model", "nowhere.glb"], 3, "built-in scenes"),
    ] {
        let output = reproduce(folder.root(), &more);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{error}");
        assert!(error.contains(words), "{error}");
    }
}
