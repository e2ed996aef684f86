//! `cullet check-occlusion` as its users meet it: built-in scenes, adversaries, its messages and
//! exit codes.

use std::process::{Command, Output};

use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    let all = [&["check-occlusion"], args].concat();
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(all).output().unwrap()
}

/// The JSON of a run that must end well.
fn fine(args: &[&str]) -> Value {
    let out = cullet(&[args, &["--json", "-"]].concat());
    let error = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(0), "{args:?}: {error}");
    serde_json::from_slice(&out.stdout).unwrap()
}

/// Both outputs, with ordinary spaces.
fn said(out: &Output) -> String {
    let text = [&out.stdout[..], &out.stderr[..]].concat();
    String::from_utf8_lossy(&text).replace('\u{202f}', " ")
}

#[test]
fn built_in_scenes_claim_nothing_wrong() {
    for scene in ["city:cells=6", "office:floors=1", "solids:n=30"] {
        let json = fine(&[scene, "--views", "2", "--size", "240x135", "--samples", "4"]);
        assert_eq!((&json["schema"], &json["wrong"]), (&1.into(), &0.into()));
        assert_eq!(json["pixels"], 2 * 240 * 135);
        assert!(json["claimed"].as_u64().unwrap() > 500, "{json}");
        assert_eq!(json["scenes"][0]["views"].as_array().unwrap().len(), 2);
        assert_eq!(json["complete"], true);
    }
}

#[test]
fn adversaries_claim_nothing_wrong_and_each_has_a_row() {
    let args = ["--adversaries", "24", "--views", "1", "--size", "160x90", "--samples", "4"];
    let json = fine(&[&args[..], &["--seed", "3"]].concat());
    assert_eq!(json["scenes"].as_array().unwrap().len(), 24);
    assert!(json["claimed"].as_u64().unwrap() > 5000, "{json}");
    let out = cullet(&args);
    let text = said(&out);
    assert_eq!(out.status.code(), Some(0), "{text}");
    for words in ["0 sheets, one-sided", "23 hairline gaps, two-sided", "24 adversaries", "0 wrong"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(text.contains("16 samples each"), "{text}");
}

#[test]
fn one_view_may_be_given_and_a_wrong_command_line_says_why() {
    let json = fine(&[
        "city:cells=4",
        "--eye",
        "0,30,60",
        "--target",
        "0,0,0",
        "--size",
        "97x61",
        "--samples",
        "2",
    ]);
    assert_eq!(json["pixels"], 97 * 61);
    for (args, words) in [
        (&["--samples", "33"][..], "1..=32"),
        (&["--adversaries", "0"], "1..=1000000"),
        (&["--adversaries", "3", "--path", "walk"], "--path"),
        (&["no-such-file.glb"], "no-such-file.glb"),
    ] {
        let out = cullet(args);
        let text = said(&out);
        assert!(matches!(out.status.code(), Some(2 | 3)), "{args:?}: {text}");
        assert!(text.contains(words), "{args:?}: {text}");
    }
}
