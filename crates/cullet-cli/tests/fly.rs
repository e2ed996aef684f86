//! Worlds that are written as tiles, and flown through.

use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(args).output().expect("the program")
}

fn json(args: &[&str]) -> Value {
    let out = cullet(&[args, &["--json", "-", "--quiet"]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("JSON")
}

#[test]
fn a_scene_is_written_as_tiles_flown_through_and_read_whole() {
    let folder = Folder::new("fly-tiles");
    let path = |name: &str| folder.root().join(name).display().to_string();
    let (tiles, page) = (path("tiles"), path("page"));
    let town = "city:cells=8,objects=900";
    let written = json(&["tiles", town, "-o", &tiles, "--instances", "100"]);
    assert!(written["tiles"].as_u64().expect("tiles") > 10);
    let flown =
        json(&["fly", &tiles, "--seconds", "1", "--check", "3", "--out", &page, "--budget", "64"]);
    assert_eq!(flown["frames"], 60);
    assert_eq!(flown["instances"], written["instances"]);
    assert_eq!((&flown["false_culls"], &flown["complete"]), (&0.into(), &true.into()));
    assert!(flown["most_bytes"].as_u64().expect("bytes") <= 64 << 20);
    assert!(flown["failed"].as_array().expect("a list").is_empty());
    let frames = std::fs::read_to_string(path("page/frames.csv")).expect("frames");
    assert_eq!(frames.lines().count(), 61);
    let html = std::fs::read_to_string(path("page/index.html")).expect("a page");
    assert_eq!(html.matches("<svg").count(), 6);
    let whole = json(&["info", &format!("{tiles}/tileset.json")]);
    assert_eq!(whole["scene"]["instances"], written["instances"], "{whole}");
}

#[test]
fn worlds_that_there_are_not_are_named() {
    for (world, code, words) in [
        ("town", 2, "try city:n=1e8"),
        ("city:n=1e12", 2, "n from 1 to 1e9"),
        ("/nowhere/tileset.json", 2, "neither a tileset.json that exists"),
    ] {
        let out = cullet(&["fly", world]);
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(code) && said.contains(words), "{said}");
    }
}

#[test]
fn every_file_of_a_folder_gets_a_report_in_shares_too() {
    let folder = Folder::new("report-folder");
    let path = |name: &str| folder.root().join(name).display().to_string();
    std::fs::create_dir_all(path("models/sub")).expect("folders");
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for name in ["models/a.obj", "models/sub/b.obj"] {
        std::fs::write(path(name), cube).expect("written");
    }
    std::fs::write(path("models/bad.obj"), "v 0 0").expect("written");
    let (models, whole, joined) = (path("models"), path("whole"), path("joined"));
    let options = ["--views", "2", "--size", "64x64", "--samples", "1"];
    let report = |more: &[&str]| cullet(&[&["report", &models][..], &options, more].concat());
    let out = report(&["--out", &whole]);
    assert_eq!(out.status.code(), Some(3), "one of them cannot be read");
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(said.contains("bad.obj: ") && said.contains("sub/b.obj: 4 triangles"), "{said}");
    for page in ["whole/index.html", "whole/a.obj/index.html", "whole/sub/b.obj/report.json"] {
        assert!(std::path::Path::new(&path(page)).is_file(), "{page}");
    }
    for share in ["2/2", "1/2"] {
        let out = report(&["--out", &joined, "--unit", share]);
        assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
        assert!(!std::path::Path::new(&path("joined/index.json")).exists());
    }
    let out = report(&["--out", &joined, "--resume"]);
    assert_eq!(out.status.code(), Some(3));
    let index =
        |folder: &str| std::fs::read(path(&format!("{folder}/index.json"))).expect("an index");
    assert!(index("joined") == index("whole"));
}
