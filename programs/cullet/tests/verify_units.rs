//! `cullet verify` in shares, joined.

use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::Value;

fn verify(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args(["verify", "city:cells=3,objects=40", "--path", "walk", "--views", "7"])
        .args(["--size", "160x90", "--samples", "1", "--lod", "1"])
        .args(args)
        .output()
        .expect("the program")
}

/// The views and the sum, without what is another at each run: times.
fn findings(out: &Output) -> Value {
    let error = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{error}");
    let mut json: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    timeless(&mut json);
    json
}

fn timeless(json: &mut Value) {
    match json {
        Value::Object(keys) => {
            ["seconds", "ms", "box_ns", "sphere_ns"].iter().for_each(|k| drop(keys.remove(*k)));
            keys.values_mut().for_each(timeless);
        }
        Value::Array(items) => items.iter_mut().for_each(timeless),
        _ => {}
    }
}

#[test]
fn shares_find_what_one_process_finds() {
    let folder = Folder::new("verify-units");
    let units = folder.root().join("units").display().to_string();
    let whole = findings(&verify(&["--json", "-", "--quiet"]));
    for share in ["2/3", "1/3"] {
        let out = verify(&["--unit", share, "--units", &units]);
        let said = String::from_utf8_lossy(&out.stdout).into_owned();
        assert_eq!(out.status.code(), Some(0), "{said}");
        assert!(said.contains(&format!("share {} of 3 is done", &share[..1])), "{said}");
        // A view of the last share is none of these.
        assert!(!said.contains("view   6"), "{said}");
    }
    let count = || Path::new(&units).read_dir().expect("units").count();
    assert_eq!(count(), 4, "a file a view");
    let joined = findings(&verify(&["--resume", "--units", &units, "--json", "-", "--quiet"]));
    assert_eq!(count(), 7);
    assert_eq!(joined, whole);
    // Of other options nothing is taken.
    let out = verify(&["--resume", "--units", &units, "--seed", "5", "--quiet"]);
    assert_eq!(out.status.code(), Some(0));
    assert_eq!(count(), 14);
}
