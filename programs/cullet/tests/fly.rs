//! Worlds that are written as tiles, and flown through.

use std::process::{Command, Output};

use cullet::{Instance, Transform};
use cullet_io::baked::{Baked, BakedLevels, BakedMesh, LevelKind, Measured, geometry_hash};
use cullet_io::{Model, save};
use cullet_testkit::Folder;
use cullet_testkit::steps::Balls;
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

/// A file of balls in a row whose levels of detail are baked.
fn baked_balls(path: &str) {
    let mut model = Model::default();
    let Balls { mesh, coarse, levels } = Balls::new(&[24, 12, 6, 3], 1.0);
    let geometry = geometry_hash(&mesh);
    let (mesh, held_by) = (model.scene.add_mesh(mesh), model.scene.add_mesh(coarse));
    model.scene.add_levels(mesh, held_by, levels).expect("made for it");
    for k in 0..64 {
        let at = [f64::from(k % 8) * 4.0, 0.0, f64::from(k / 8) * 4.0];
        let ball = Instance::new(mesh, Transform::from_translation(at));
        model.scene.add(ball).expect("a ball");
    }
    model.scene.commit(&cullet::Culler::default());
    model.mesh_names = vec!["ball".into(), "levels".into()];
    let measured =
        Measured { points: 1, reverse_points: 1, quantile: 1.0, most_over: 1.0, seed: 1 };
    let levels = vec![BakedLevels { kind: LevelKind::Chain, held_by, measured }];
    let of = BakedMesh { mesh, geometry, levels, ..BakedMesh::default() };
    model.baked = Some(Baked { meshes: vec![of], ..Baked::default() });
    save(&model, std::path::Path::new(path)).expect("written");
}

#[test]
fn stand_ins_of_a_baked_scene_are_shown_from_afar_and_its_triangles_from_nearby() {
    let folder = Folder::new("fly-stand-ins");
    let path = |name: &str| folder.root().join(name).display().to_string();
    let (balls, tiles, page) = (path("balls.glb"), path("tiles"), path("page"));
    baked_balls(&balls);
    let written = json(&[
        "tiles",
        &balls,
        "--stand-ins",
        "--stand-in-triangles",
        "6000",
        "--triangles",
        "20000",
        "-o",
        &tiles,
    ]);
    assert_eq!(written["instances"], 64);
    assert!(written["stand_ins"].as_u64().expect("a number") > 3, "{written}");
    let error = written["stand_in_error"].as_f64().expect("a number");
    assert!(error > 0.01 && error < 0.5, "{written}");
    let flown =
        json(&["fly", &tiles, "--seconds", "1", "--check", "4", "--out", &page, "--lod", "1"]);
    assert_eq!((&flown["false_culls"], &flown["failed"]), (&0.into(), &Value::Array(vec![])));
    assert_eq!(flown["instances"], 64, "stand-ins are none of the world's");
    let whole = json(&["info", &format!("{tiles}/tileset.json")]);
    assert_eq!(whole["scene"]["instances"], 64, "{whole}");
}

#[test]
fn sets_of_view_cells_say_what_is_loaded_first() {
    let folder = Folder::new("fly-sets");
    let path = |name: &str| folder.root().join(name).display().to_string();
    let (sets, tiles, page) = (path("town.cpvs"), path("tiles"), path("page"));
    let town = "city:cells=8,objects=900";
    json(&[
        "pvs",
        town,
        "--view-cells",
        "20",
        "--heights",
        "1..2.5",
        "--rays",
        "200000",
        "-o",
        &sets,
    ]);
    let written = json(&["tiles", town, "--pvs", &sets, "-o", &tiles, "--instances", "100"]);
    let cells = written["cells"].clone();
    assert!(cells.as_u64().expect("a number") > 5, "{written}");
    let fly = |more: &[&str]| {
        let fly =
            ["fly", &tiles, "--seconds", "1", "--check", "2", "--budget", "2", "--out", &page];
        json(&[&fly[..], more].concat())
    };
    let (with, without) = (fly(&[]), fly(&["--no-sets"]));
    assert_eq!([&with["cells"], &without["cells"]], [&cells, &0.into()]);
    for flown in [with, without] {
        assert_eq!(flown["false_culls"], 0);
        assert!(flown["most_bytes"].as_u64().expect("bytes") <= 2 << 20);
    }
    // Of another scene.
    let out = cullet(&["tiles", "city:cells=9,objects=900", "--pvs", &sets, "-o", &path("other")]);
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(3) && said.contains("another scene"), "{said}");
}

#[test]
fn worlds_that_there_are_not_are_named() {
    for (world, code, words) in [
        ("town", 2, "try city:n=1e8"),
        ("city:n=1e12", 2, "n from 1 to 1e9"),
        ("/nowhere/tileset.json", 2, "no tileset.json that exists"),
    ] {
        let out = cullet(&["fly", world]);
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(code) && said.contains(words), "{said}");
    }
    // A report of it is of a flight, which has other figures.
    let out = cullet(&["report", "city:n=1e8", "--fail-if", "tightness>3"]);
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(2) && said.contains("cullet fly city:n=1e8"), "{said}");
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
