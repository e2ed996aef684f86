//! `cullet calibrate`, and reports that speak of milliseconds by what it measured.

use std::path::Path;
use std::process::Command;

use cullet_testkit::Folder;
use serde_json::Value;

use crate::ran::{code, cullet, cullet_with_costs, json, small, text};

/// A file of costs: 4 ns for a triangle that is rejected, 5 to 7 ns for one that is drawn.
fn costs_file() -> Value {
    let names = [
        "object_test",
        "cluster_test",
        "triangle_test",
        "rejected_triangle",
        "opaque_triangle",
        "masked_triangle",
        "blended_triangle",
        "draw",
    ];
    let spread = |i: usize| serde_json::json!({"ns": i + 1, "low": i + 1, "high": i + 1});
    let costs: serde_json::Map<String, Value> =
        names.iter().enumerate().map(|(i, name)| (name.to_string(), spread(i))).collect();
    serde_json::json!({
        "schema": 1, "version": "0.1.0", "date": "2026-03-09", "machine": "an abacus",
        "renderer": "a painter", "rounds": 3, "costs": costs, "t_over_r": 0.4,
    })
}

#[test]
fn what_calibrate_measures_is_kept_shown_and_forgotten() {
    let folder = Folder::new("calibrate");
    let file = folder.path("deep/costs.json");
    let run = |args: &[&str]| cullet_with_costs(&file, &[&["calibrate"], args].concat());
    assert_eq!(run(&["--show"]).status.code(), Some(3));
    let dry = run(&["--dry-run", "--rounds", "1", "--json", "-"]);
    // A machine may be so busy that one round is no measurement; it then says so, and keeps
    // nothing.
    match dry.status.code() {
        Some(0) => {
            let printed: Value = serde_json::from_slice(&dry.stdout).unwrap();
            assert!(printed["costs"]["cluster_test"]["ns"].as_f64().unwrap() > 0.0, "{printed}");
        }
        code => assert!(text(&dry.stderr).contains("too busy"), "{code:?} {}", text(&dry.stderr)),
    }
    assert!(!Path::new(&file).exists());
    // Measured times cannot be foreseen, but a stored measurement can be put in their place.
    std::fs::create_dir_all(folder.path("deep")).unwrap();
    std::fs::write(&file, costs_file().to_string()).unwrap();
    let shown = run(&["--show"]);
    assert_eq!(shown.status.code(), Some(0));
    let lines = text(&shown.stdout);
    for part in ["t/r = 0.40", "opaque triangle drawn", "another machine", "an abacus", &file] {
        assert!(lines.contains(part), "{part}: {lines}");
    }
    let shown = run(&["--show", "--json", "-"]);
    let printed: Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(printed["costs"]["draw"]["ns"], 8.0);
    for gone in ["costs.json removed", "nothing to forget"] {
        let out = run(&["--forget"]);
        assert_eq!(out.status.code(), Some(0));
        assert!(text(&out.stdout).contains(gone), "{}", text(&out.stdout));
    }
    assert!(!Path::new(&file).exists());
    for wrong in [&["--show", "--forget"][..], &["--dry-run", "--out", "x"], &["--rounds", "0"]] {
        assert_eq!(run(wrong).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
fn a_report_speaks_of_milliseconds_where_costs_are_known() {
    let folder = Folder::new("costs");
    let file = folder.path("costs.json");
    std::fs::write(&file, costs_file().to_string()).unwrap();
    let out = folder.path("r");
    let page = || std::fs::read_to_string(folder.path("r/index.html")).unwrap();
    let report = |args: &[&str]| {
        let args = small("report", &[&["--out", &out], args].concat());
        let lines = text(&cullet(&args).stdout);
        (lines, json(folder.path("r/report.json")))
    };
    let (lines, without) = report(&[]);
    assert!(lines.contains("`cullet calibrate` measures") && page().contains("cullet calibrate"));
    assert!(without["costs"].is_null());
    let (lines, with) = report(&["--costs", &file]);
    assert!(lines.contains("culling saves about"), "{lines}");
    assert!(lines.contains("measured with a painter on 2026-03-09, on another machine"), "{lines}");
    assert!(page().contains("culling saves about") && page().contains("4.0 ns for one outside"));
    // Occluded triangles would have been drawn; those culled by the other stages would have been
    // rejected.
    let drawn = with["costs"]["drawn_triangle_ns"].as_f64().unwrap();
    let removed = with["summary"]["removed"].as_object().unwrap();
    let price = |stage: &str| match stage {
        "frustum" | "backface" | "degenerate" => 4.0,
        "occlusion" => drawn,
        other => panic!("unexpected stage {other}"),
    };
    let ns: f64 = removed.iter().map(|(s, n)| price(s) * n.as_f64().unwrap()).sum();
    let saved = with["costs"]["saved_ms_per_view"].as_f64().unwrap();
    assert!(saved > 0.0 && (saved - ns / 3.0 * 1e-6).abs() < 1e-12, "{saved} of {ns}");
    let (lines, given) = report(&["--triangle-ns", "8"]);
    assert!(lines.contains("8.0 ns per triangle, as --triangle-ns says"), "{lines}");
    let all: f64 = removed.values().map(|n| n.as_f64().unwrap()).sum();
    let alike = given["costs"]["saved_ms_per_view"].as_f64().unwrap();
    assert!((alike - all * 8.0 / 3.0 * 1e-6).abs() < 1e-12, "{alike} for {all} triangles");
}

#[test]
fn costs_that_cannot_be_used_are_named_or_passed_over() {
    let folder = Folder::new("bad-costs");
    let (file, out) = (folder.path("costs.json"), folder.path("r"));
    let mut other = costs_file();
    other["schema"] = 9.into();
    let mut negative = costs_file();
    negative["costs"]["draw"]["ns"] = (-8).into();
    for (content, expected) in [
        ("{".to_owned(), "is not JSON"),
        (other.to_string(), "has schema 9"),
        (negative.to_string(), "costs.draw.ns is -8"),
    ] {
        std::fs::write(&file, content).unwrap();
        let named = small("report", &["--out", &out, "--costs", &file]);
        let kept = small("report", &["--out", &out]);
        for run in [cullet(&named), cullet_with_costs(&file, &kept)] {
            assert_eq!(run.status.code(), Some(3));
            let error = text(&run.stderr);
            for part in [&*file, expected, "cullet calibrate --out"] {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
        assert!(!Path::new(&out).exists(), "found before anything is done");
        assert_eq!(cullet_with_costs(&file, &["calibrate", "--show"]).status.code(), Some(3));
    }
    assert_eq!(code(&small("report", &["--out", &out, "--costs", &folder.path("no.json")])), 3);
    for wrong in [&["--triangle-ns", "0"][..], &["--triangle-ns", "5", "--costs", &file]] {
        assert_eq!(code(&small("report", wrong)), 2, "{wrong:?}");
    }
}

/// A file that nobody named, in the folder of settings, does not stop a report.
#[cfg(unix)]
#[test]
fn damaged_settings_cost_only_the_milliseconds() {
    let folder = Folder::new("settings");
    std::fs::create_dir_all(folder.path("cullet")).unwrap();
    std::fs::write(folder.path("cullet/costs.json"), "{}").unwrap();
    let out = Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args(small("report", &["--out", &folder.path("r")]))
        .env_remove("CULLET_COSTS")
        .env("XDG_CONFIG_HOME", folder.path(""))
        .output()
        .unwrap();
    assert_eq!(out.status.code(), Some(0));
    assert!(text(&out.stderr).contains("warning: no milliseconds"), "{}", text(&out.stderr));
}
