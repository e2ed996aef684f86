//! The program as its users meet it: files written, exit codes, JSON on the standard output.

use std::path::Path;
use std::process::Command;

use cullet_testkit::Folder;
use serde_json::Value;

use crate::ran::{code, cullet, json, small, text};

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
