//! The program as its users meet it: files written, exit codes, JSON on the standard output.

use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    cullet_with_costs("/nonexistent/costs.json", args)
}

/// Runs the program with its costs kept in a file of the test's own, never the user's.
fn cullet_with_costs(file: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", file).output().unwrap()
}

fn code(args: &[&str]) -> i32 {
    cullet(args).status.code().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// A scene and views small enough for any test.
const SMALL: &[&str] = &["solids:n=20", "--views", "3", "--size", "160x90", "--samples", "2"];

fn small<'a>(command: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command], SMALL, more].concat()
}

#[test]
fn a_report_has_the_files_and_the_figures_of_its_schema() {
    let folder = Folder::new("report");
    let out = cullet(&small("report", &["--out", &folder.path("r"), "--json", "-"]));
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let report = json(folder.path("r/report.json"));
    let printed: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(report, printed);
    assert_eq!(report["schema"], 1);
    for key in ["name", "meshes", "instances", "triangles", "solids"] {
        assert!(!report["scene"][key].is_null(), "scene.{key}");
    }
    let views = report["views"].as_array().unwrap();
    assert_eq!(views.len(), 3);
    let sum = |key: &str| views.iter().map(|v| v["triangles"][key].as_u64().unwrap()).sum::<u64>();
    let summary = &report["summary"];
    for key in ["all", "potentially_visible", "visible"] {
        assert_eq!(summary["triangles"][key], sum(key), "{key}");
    }
    let tightness = sum("potentially_visible") as f64 / sum("visible") as f64;
    assert!((summary["tightness"].as_f64().unwrap() - tightness).abs() < 1e-9);
    assert_eq!(summary["false_culls"], 0);
    assert!(summary["advice"].is_array());
    for view in views {
        assert_eq!(view["triangles"]["all"], report["scene"]["triangles"]);
        for stage in view["stages"].as_array().unwrap() {
            let unit = stage["unit"].as_str().unwrap();
            assert!(["instances", "clusters", "triangles"].contains(&unit), "{unit}");
            assert!(stage["in"].as_u64().unwrap() >= stage["out"].as_u64().unwrap(), "{stage}");
        }
        // Triangles culled by the stages and those left are all triangles.
        let removed: u64 =
            view["removed"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
        let left = view["triangles"]["potentially_visible"].as_u64().unwrap();
        assert_eq!(removed + left, view["triangles"]["all"].as_u64().unwrap());
    }
    let csv = std::fs::read_to_string(folder.path("r/views.csv")).unwrap();
    assert_eq!(csv.lines().count(), 4);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|l| l.split(',').count() == columns));
}

#[test]
fn the_page_fetches_nothing() {
    let folder = Folder::new("page");
    assert_eq!(code(&small("report", &["--out", &folder.path("r"), "--quiet"])), 0);
    let page = std::fs::read_to_string(folder.path("r/index.html")).unwrap();
    assert!(page.contains("drawn for nothing"));
    for word in ["http://", "https://", "<script", "@import", "url("] {
        assert!(!page.contains(word), "the page has {word}");
    }
    // Pictures are in the page; links lead only to files beside it.
    assert!(page.contains("src=\"data:image/png;base64,"));
    for link in page.split("href=\"").skip(1).filter_map(|l| l.split('"').next()) {
        assert!(Path::new(&folder.path("r")).join(link).is_file(), "{link}");
    }
}

#[test]
fn names_from_a_file_cannot_become_markup() {
    let folder = Folder::new("hostile");
    let file = folder.path("<b>&\"x.obj");
    let obj = "o <script>alert(1)</script>\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(&file, obj).unwrap();
    let args = [
        "report",
        &file,
        "--views",
        "1",
        "--size",
        "64x64",
        "--samples",
        "1",
        "--out",
        &folder.path("r"),
    ];
    let out = cullet(&args);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let page = std::fs::read_to_string(folder.path("r/index.html")).unwrap();
    assert!(!page.contains("<script") && !page.contains("<b>&\""));
}

#[test]
fn verify_agrees_and_counts() {
    let out = cullet(&small("verify", &["--json", "-"]));
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let result: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(result["summary"]["false_culls"], 0);
    assert!(text(&out.stderr).contains("0 false culls"));
}

#[test]
fn a_lossy_stage_is_caught_by_verify() {
    // Everything is under a million pixels, so everything visible is lost.
    let out = cullet(&small("verify", &["--detail", "1e6"]));
    assert_eq!(out.status.code(), Some(1));
    let lines = text(&out.stdout);
    assert!(lines.contains("LOST view 0") && lines.contains("dropped by detail"), "{lines}");
}

#[test]
fn exit_codes_are_as_the_help_says() {
    let folder = Folder::new("codes");
    let help = text(&cullet(&["--help"]).stdout);
    assert!(help.contains("Exit codes") && help.contains("130 interrupted"));
    assert_eq!(code(&["--help"]), 0);
    for wrong in [
        &["report", "--size", "0x3"][..],
        &["report", "--eye", "0,0,0"],
        &["report", "city:nonsense=1"],
        &["report", "--path", "nowhere"],
        &["report", "--fail-if", "tight>3"],
        &["report", "--fail-if", "tightness>baseline"],
        &["nonsense"],
        &[],
    ] {
        assert_eq!(code(wrong), 2, "{wrong:?}");
    }
    assert_eq!(code(&["info", "/nonexistent/model.glb"]), 3);
    std::fs::write(folder.path("empty.obj"), "").unwrap();
    std::fs::write(folder.path("text.glb"), "no model").unwrap();
    assert_eq!(code(&["info", &folder.path("text.glb")]), 3);
    assert_eq!(code(&["info", "solids", "--max-triangles", "3"]), 4);
    let out = folder.path("r");
    assert_eq!(code(&small("report", &["--out", &out, "--fail-if", "all>0"])), 5);
    assert_eq!(code(&small("report", &["--out", &out, "--fail-if", "false_culls>0"])), 0);
    assert_eq!(code(&small("report", &["--out", &out, "--baseline", &folder.path("no.json")])), 3);
}

#[test]
fn a_report_is_its_own_baseline_without_change() {
    let folder = Folder::new("baseline");
    let first = folder.path("a");
    assert_eq!(code(&small("report", &["--out", &first])), 0);
    let old = format!("{first}/report.json");
    let more = ["--out", &folder.path("b"), "--baseline", &old, "--fail-if", "tightness>baseline"];
    let same = cullet(&small("report", &more));
    assert_eq!(same.status.code(), Some(0));
    assert!(text(&same.stdout).contains("nothing changed"), "{}", text(&same.stdout));
    let more = ["--out", &folder.path("b"), "--baseline", &old, "--no-backface"];
    let other = cullet(&small("report", &more));
    assert!(text(&other.stdout).contains("triangles left: "), "{}", text(&other.stdout));
}

#[test]
fn an_export_names_every_instance_once() {
    let folder = Folder::new("export");
    let export = folder.path("visible.json");
    // From inside the grid, so that some are dropped.
    let args = [
        "report",
        "solids:n=20",
        "--eye",
        "0,1,0",
        "--target",
        "5,1,0",
        "--size",
        "160x90",
        "--samples",
        "1",
        "--out",
        &folder.path("r"),
        "--export",
        &export,
    ];
    assert_eq!(code(&args), 0);
    let export = json(export);
    let report = json(folder.path("r/report.json"));
    let view = &export["views"][0];
    let list = |key: &str| view[key].as_array().unwrap().clone();
    let total = list("visible").len() + list("dropped").len();
    assert_eq!(report["scene"]["instances"], total);
    assert!(!list("dropped").is_empty());
    for item in list("dropped") {
        assert!(item["stage"].is_string() && item["name"].is_string(), "{item}");
        assert!(item["handle"].is_array() && item["reason"].is_string(), "{item}");
    }
    let drawn: u64 = list("visible").iter().map(|i| i["triangles"].as_u64().unwrap()).sum();
    assert_eq!(view["triangles"], drawn);
}

#[test]
fn info_and_scenes_speak_to_people_and_programs() {
    let info = cullet(&["info", "solids:n=20", "--json", "-"]);
    let value: Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!(value["scene"]["meshes"], value["scene"]["solids"]);
    assert!(text(&cullet(&["info", "solids:n=20"]).stdout).contains("triangles"));
    let scenes: Value = serde_json::from_slice(&cullet(&["scenes", "--json", "-"]).stdout).unwrap();
    let names: Vec<_> = scenes["scenes"].as_array().unwrap().iter().map(|s| &s["name"]).collect();
    assert!(names.contains(&&Value::from("city")) && names.contains(&&Value::from("forest")));
}

#[test]
fn what_is_baked_is_told_without_reading_the_scene() {
    let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/baked/file");
    let info = |args: &[&str]| {
        let out = cullet(&[&["info", "--baked", "--json", "-"], args].concat());
        let (code, words) = (out.status.code(), text(&out.stderr));
        (code, serde_json::from_slice(&out.stdout).unwrap_or(Value::Null), words)
    };
    for (args, state) in
        [(&[seed][..], "sums were not looked at"), (&[seed, "--all"], "sums are right")]
    {
        let (code, record, words) = info(args);
        assert_eq!(code, Some(0), "{words}");
        let mesh = &record["baked"]["meshes"][0];
        assert_eq!((&mesh["mesh"], &mesh["intact"]), (&0.into(), &true.into()));
        assert_eq!(mesh["levels"][0]["triangles_by_level"], serde_json::json!([2, 1]));
        assert_eq!(record["file_bytes"], std::fs::metadata(seed).unwrap().len());
        assert!(words.contains(state) && words.contains("2 → 1"), "{words}");
    }
    let plain = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/gltf/binary");
    let (code, _, words) = info(&[plain]);
    assert_eq!(code, Some(3), "{words}");
    assert!(words.contains("nothing is baked") && words.contains("cullet bake"), "{words}");
    let (code, _, words) = info(&["no such file.glb"]);
    assert_eq!(code, Some(3), "{words}");
    assert!(words.contains("no such file.glb"), "{words}");
}

#[test]
fn info_tells_what_is_baked_and_why_it_is_left_out() {
    let folder = Folder::new("baked");
    let seed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/gltf/baked");
    let good = std::fs::read_to_string(seed).unwrap();
    let info = |file: &str| -> (Value, String) {
        let out = cullet(&["info", file, "--json", "-"]);
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        (serde_json::from_slice(&out.stdout).unwrap(), text(&out.stderr))
    };
    let (record, words) = info(&folder.file("good.gltf", &good));
    assert_eq!((&record["scene"]["meshes"], &record["baked"]["problems"]), (&1.into(), &0.into()));
    let levels = &record["baked"]["meshes"][0]["levels"][0];
    assert_eq!(levels["triangles_by_level"], serde_json::json!([2, 1]));
    assert_eq!((&levels["kind"], &levels["groups"]), (&"chain".into(), &1.into()));
    assert_eq!(levels["errors"], serde_json::json!([0.75, 0.75]));
    assert_eq!(levels["measured"]["seed"], 7);
    for part in ["by make_seeds, version 1", "sums are right", "chain", "2 → 1", "0.75"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let (record, words) =
        info(&folder.file("odd.gltf", &good.replace("\"seed\": 7", "\"seed\": 8")));
    assert_eq!(
        (&record["baked"]["problems"], &record["scene"]["triangles"]),
        (&1.into(), &2.into())
    );
    assert_eq!(record["baked"]["meshes"][0]["intact"], false);
    assert!(words.contains("1 mesh has levels that are left out"), "{words}");
    let newer =
        good.replace("\"CULLET_baked\": {\"version\": 1", "\"CULLET_baked\": {\"version\": 3");
    assert_ne!(newer, good);
    let (record, words) = info(&folder.file("newer.gltf", &newer));
    assert!(record["baked"]["problem"].as_str().unwrap().starts_with("version 3"));
    assert!(words.contains("left out: version 3"), "{words}");
}

#[test]
fn every_picture_is_a_png() {
    let folder = Folder::new("pictures");
    for kind in ["kinds", "shaded", "depth", "map"] {
        let out = folder.path(&format!("{kind}.png"));
        let args = [
            "picture",
            kind,
            "solids:n=20",
            "--views",
            "2",
            "--view",
            "1",
            "--size",
            "160x90",
            "--out",
            &out,
        ];
        assert_eq!(code(&args), 0, "{kind}");
        assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"), "{kind}");
    }
    assert_eq!(code(&["picture", "map", "solids:n=20", "--views", "2", "--view", "2"]), 2);
}

#[test]
fn every_teaching_picture_is_a_png() {
    let folder = Folder::new("teaching");
    let kinds = [
        "normal-mask",
        "normal-partition",
        "conservative-set",
        "culling-volume",
        "clusters",
        "cones",
        "back-regions",
    ];
    let help = cullet(&["picture", "--help"]);
    let help = String::from_utf8(help.stdout).unwrap();
    for kind in kinds {
        assert!(help.lines().any(|l| l.starts_with(&format!("{kind} "))), "{kind} has no line");
        let out = folder.path(&format!("{kind}.png"));
        assert_eq!(code(&["picture", kind, "knobs:n=6", "--size", "160x90", "--out", &out]), 0);
        assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"), "{kind}");
    }
}

#[test]
fn a_diagram_reads_no_scene() {
    let folder = Folder::new("diagrams");
    let out = folder.path("diagram.png");
    for kind in ["normal-mask", "normal-partition", "conservative-set"] {
        assert_eq!(code(&["picture", kind, "no-such-file.glb", "--out", &out]), 0, "{kind}");
    }
    let still = ["--eye", "1,2,3", "--target", "1,2,3"];
    assert_eq!(code(&[&["picture", "normal-mask", "--out", &out], &still[..]].concat()), 2);
    assert_eq!(code(&["picture", "clusters", "no-such-file.glb", "--out", &out]), 3);
}

#[test]
fn a_cluster_that_is_not_there_is_refused_with_the_limit() {
    let folder = Folder::new("no-cluster");
    let out = folder.path("volume.png");
    let run = |n: &str| {
        cullet(&["picture", "culling-volume", "knobs:n=6", "--cluster", n, "--out", &out])
    };
    let refused = run("100000");
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("--cluster 100000: the first mesh has "), "{message}");
    assert!(message.contains(" clusters, numbered from 0"), "{message}");
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_solid_without_a_culling_volume_is_not_called_two_sided() {
    let folder = Folder::new("cube");
    let cube = folder.path("cube.obj");
    let corners = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2));
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(&cube, corners.collect::<String>() + faces).unwrap();
    let out = folder.path("volume.png");
    let volume = |more: &[&str]| {
        cullet(&[&["picture", "culling-volume", &cube, "--out", &out], more].concat())
    };
    let solid = volume(&[]);
    assert_eq!(solid.status.code(), Some(3));
    assert!(
        text(&solid.stderr).contains("face all ways") && !text(&solid.stderr).contains("two-sided")
    );
    assert!(text(&volume(&["--two-sided"]).stderr).contains("--one-sided"));
}

#[test]
fn kinds_opens_a_scene_above_the_eye_where_it_is_covered() {
    let folder = Folder::new("kinds");
    let out = folder.path("kinds.png");
    let kinds = |scene: &str, eye: &str| {
        let target = "4,1.5,40";
        let still = ["--eye", eye, "--target", target, "--size", "320x200", "--out", &out];
        let done = cullet(&[&["picture", "kinds", scene], &still[..]].concat());
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        text(&done.stderr).contains("cut open at a height of")
    };
    assert!(kinds("office:roof=1,floors=1", "4,1.6,4"));
    assert!(!kinds("knobs:n=6", "0,1,5"));
}

#[test]
fn the_city_is_walked_through_and_a_model_looked_at_from_all_around() {
    let folder = Folder::new("paths");
    let path = |scene: &str, more: &[&str]| {
        let (page, out) = (folder.path("page"), folder.path("v.json"));
        let views = ["--views", "1", "--size", "64x48", "--samples", "1"];
        let files = ["--out", &page, "--json", &out];
        let done = cullet(&[&["report", scene], &views[..], &files, more].concat());
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        json(&out)["settings"]["path"].as_str().unwrap().to_owned()
    };
    assert_eq!(path("city:cells=6,objects=20", &[]), "walk");
    assert_eq!(path("city:cells=6,objects=20", &["--path", "orbit"]), "orbit");
    assert_eq!(path("knobs:n=6", &[]), "orbit");
}

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
    // A machine may be so busy that one round is no measurement; it then says so, and keeps nothing.
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
    // Occluded triangles would have been drawn; those culled by the other stages would have been rejected.
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

/// The signal that Ctrl-C sends ends the run early, with a report that can be read.
#[cfg(unix)]
#[test]
fn an_interrupted_report_is_valid() {
    let folder = Folder::new("interrupt");
    let out = folder.path("r");
    let mut child = Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args([
            "report",
            "solids:n=20",
            "--views",
            "100000",
            "--size",
            "64x64",
            "--samples",
            "1",
            "--out",
            &out,
            "-q",
        ])
        .env("CULLET_COSTS", "/nonexistent/costs.json")
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // The first part is on disk once the first view is done.
    let report = Path::new(&out).join("report.json");
    let start = std::time::Instant::now();
    while !report.exists() && start.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let report = json(report);
    assert_eq!(report["complete"], false);
    let views = report["views"].as_array().unwrap().len();
    assert!(views > 0 && views < 100_000);
    assert_eq!(report["summary"]["views"], views);
}

#[test]
fn the_bench_of_the_culler_counts_what_each_stage_leaves_and_checks_it() {
    let scene = ["bench", "culler", "city:cells=6,objects=300", "--path", "walk"];
    let out = cullet(&[&scene[..], &["--views", "2", "--seconds", "0.01", "--json", "-"]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let record: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!((&record["schema"], &record["checked"]), (&2.into(), &true.into()));
    let stages = record["stages"].as_array().unwrap();
    for (stage, unit) in [("frustum", "instances"), ("occlusion", "instances")] {
        let row = stages.iter().find(|s| s["stage"] == stage && s["unit"] == unit).unwrap();
        assert!(row["left"].as_f64() < row["entered"].as_f64(), "{row}");
        assert!(row["worst_ms"].as_f64() >= row["ms"].as_f64(), "{row}");
    }
    assert!(record["occlusion"]["drawn"].as_f64() > Some(0.0));
    // Options of the other benches are not accepted here.
    assert_eq!(code(&["bench", "culler", "--large"]), 2);
}
