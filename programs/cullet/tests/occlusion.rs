//! Benchmark scenes for occlusion culling, from the making to the measuring.

use std::process::{Command, Output};

use cullet_testkit::{Folder, Rng, data};
use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(args).output().unwrap()
}

/// Runs the program, which must end with this code, and returns what it said on standard error.
fn ends(args: &[&str], code: i32) -> String {
    let out = cullet(args);
    let error = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(code), "{args:?}: {error}");
    error
}

const CITY: &str = "city:ground=0,cells=6,objects=200";

fn bench(scene: &str, more: &[&str]) -> (i32, Value) {
    let fixed = ["bench", "occlusion", "--scene", scene, "--resolution", "160x90", "--json", "-"];
    let out = cullet(&[&fixed, more].concat());
    let json = serde_json::from_slice(&out.stdout).unwrap_or(Value::Null);
    (out.status.code().unwrap(), json)
}

#[test]
fn a_scene_is_made_measured_and_held_against_references() {
    let folder = Folder::new("occlusion");
    let (scene, answers) = (folder.path("a.bin"), folder.path("answers.bin"));
    ends(&["occscn", CITY, "--views", "4", "-o", &scene], 0);
    let (code, json) = bench(&scene, &["--answers", &answers, "--reference", "2"]);
    assert_eq!(code, 0, "{json}");
    assert_eq!(json["schema"], 1);
    assert_eq!((&json["views"], &json["resolution"][0]), (&4.into(), &160.into()));
    let names: Vec<&str> = (0..3).map(|i| json["modes"][i]["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["raw", "sorted", "interleaved"]);
    for mode in json["modes"].as_array().unwrap() {
        assert!(mode["clear_ms"].as_f64().unwrap() > 0.0, "{mode}");
        assert!(mode["render_ms"].as_f64().unwrap() > 0.0, "{mode}");
        assert!(mode["prepare_ms"].as_f64().unwrap() >= 0.0, "{mode}");
    }
    let answers = std::fs::read(&answers).unwrap();
    assert_eq!(answers.len(), 4 * 200);
    let mean = |a: u8| answers.iter().filter(|&&x| x == a).count() as f64 / 4.0;
    let test = &json["test"];
    assert_eq!(test["culled"].as_f64().unwrap(), mean(2));
    assert_eq!(test["visible"].as_f64().unwrap(), mean(1));
    assert_eq!(test["in_frustum"].as_f64().unwrap(), mean(1) + mean(2));
    assert!(test["ns_per_object"].as_f64().unwrap() > 0.0);
    let drawn = &json["references"][0];
    assert_eq!((&drawn["samples"], &drawn["false_culls"]), (&2.into(), &0.into()));
    assert!(drawn["found"].as_u64().unwrap() > 0, "{drawn}");

    // A reference that saw everything finds false culls.
    std::fs::write(folder.path("a.bin.ref1"), [1; 800]).unwrap();
    let (code, json) = bench(&scene, &[]);
    assert_eq!(code, 1, "{json}");
    assert!(json["references"][0]["false_culls"].as_u64().unwrap() > 0);
    std::fs::write(folder.path("a.bin.ref1"), [1; 799]).unwrap();
    assert_eq!(bench(&scene, &[]).0, 3);
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = Folder::new("occlusion-bad");
    let bad = folder.path("bad.bin");
    let run = |more: &[&'static str]| [&["bench", "occlusion", "--scene", &bad], more].concat();
    assert!(ends(&run(&[]), 3).contains("cannot be read"));
    std::fs::write(&bad, "solid cube").unwrap();
    assert!(ends(&run(&[]), 3).contains("cullet occscn makes such a file"));
    ends(&["occscn", CITY, "--views", "1", "-o", &bad], 0);
    assert!(ends(&run(&["--resolution", "0x5"]), 2).contains("0x5"));
    assert!(ends(&run(&["--level", "mmx"]), 2).contains("not a SIMD level of this machine"));
    assert!(ends(&["bench", "frustum", "--scene", &bad], 2).contains("bench occlusion"));
    assert!(ends(&["bench", "occlusion", "--reference", "4"], 2).contains("--scene"));
    assert!(
        ends(&["occscn", CITY, "--occluders", "cathedral", "-o", &bad], 3).contains("cathedral")
    );
    let nowhere = folder.path("no/such/folder");
    assert!(ends(&["occscn", CITY, "-o", &nowhere], 2).contains("there is no folder"));
    // One pixel is a resolution too.
    ends(&run(&["--resolution", "1x1"]), 0);
}

#[test]
fn the_castle_has_the_published_number_of_occluders() {
    let Some(castle) = data("intel-castle/intel-castle.glb") else { return };
    let folder = Folder::new("occlusion-castle");
    let out = folder.path("castle.bin");
    let castle = castle.to_string_lossy();
    let named = ["--occluders", "castleLargeOccluders", "--occluders", "ground"];
    ends(&[&["occscn", &castle, "-o", &out, "--views", "2"][..], &named].concat(), 0);
    let bytes = std::fs::read(&out).unwrap();
    let count = |i: usize| u32::from_le_bytes(bytes[8 + 4 * i..12 + 4 * i].try_into().unwrap());
    assert_eq!([count(1), count(2), count(3), count(4)], [48_700, 512, 2, 20_000]);
}

#[test]
fn a_report_has_the_classic_table_and_baked_occluders_lose_nothing() {
    let folder = Folder::new("occlusion-report");
    let out = folder.path("report");
    let common = ["--path", "walk", "--views", "2", "--size", "160x90", "--out", &out];
    for kind in ["mesh", "auto"] {
        let args = [&["report", "city:cells=4,objects=60", "--occluders", kind][..], &common];
        ends(&args.concat(), 0);
        let page = std::fs::read_to_string(folder.path("report/index.html")).unwrap();
        for words in ["After occlusion culling", "After view-frustum culling", "Full model"] {
            assert!(page.contains(words), "{kind}: no {words:?}");
        }
        let json = std::fs::read(folder.path("report/report.json")).unwrap();
        let json: Value = serde_json::from_slice(&json).unwrap();
        let whole = &json["summary"]["whole"];
        let [before, after] =
            ["in_frustum", "not_hidden"].map(|key| whole[key][1].as_u64().unwrap());
        assert!(after < before && after > 0, "{kind}: {whole}");
        assert_eq!(json["summary"]["false_culls"], 0);
        for picture in ["occlusion-buffer", "occluders", "hidden"] {
            assert!(
                std::fs::metadata(folder.path(&format!("report/view-000-{picture}.png"))).is_ok()
            );
        }
    }
    let off = [&["report", "solids", "--no-occlusion"][..], &common].concat();
    ends(&off, 0);
    let page = std::fs::read_to_string(folder.path("report/index.html")).unwrap();
    assert!(!page.contains("After occlusion culling"));
}

/// Leaves over a board: three thousand triangles that do not touch, each of a few pixels.
fn leaves() -> String {
    let mut rng = Rng(1);
    let mut random = |low, high| rng.range(low, high);
    let mut text =
        "o board\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 3 2\nf 1 4 3\no leaves\n".to_owned();
    for leaf in 0..3000 {
        let middle = [random(-1.0, 1.0), random(0.1, 2.0), random(-1.0, 1.0)];
        for _ in 0..3 {
            let [x, y, z] = middle.map(|m| m + random(-0.05, 0.05));
            text += &format!("v {x} {y} {z}\n");
        }
        let v = 5 + leaf * 3;
        text += &format!("f {v} {} {}\n", v + 1, v + 2);
    }
    text
}

#[test]
fn a_report_names_what_is_too_thin_to_hide() {
    let folder = Folder::new("occlusion-leaves");
    let (file, out) = (folder.path("leaves.obj"), folder.path("report"));
    std::fs::write(&file, leaves()).unwrap();
    let advice = |kind: &str| {
        let views = ["--views", "2", "--size", "160x90", "--occluders", kind, "--out", &out];
        ends(&[&["report", &file][..], &views].concat(), 0);
        let json = std::fs::read(folder.path("report/report.json")).unwrap();
        let json: Value = serde_json::from_slice(&json).unwrap();
        let list = json["summary"]["advice"].as_array().unwrap();
        let found = list.iter().find(|a| a["kind"] == "poor-occluder").cloned();
        found.unwrap_or_else(|| panic!("{kind}: {list:?}"))
    };
    // Baked, a few of its triangles stand for it, which are no thicker.
    for kind in ["mesh", "baked"] {
        let found = advice(kind);
        assert_eq!(found["names"], serde_json::json!(["leaves"]), "{kind}");
        let text = found["text"].as_str().unwrap();
        assert!(text.contains("9000 boundary edges, and its parts are too thin"), "{kind}: {text}");
    }
}

#[test]
fn occluders_are_compared_by_what_they_find() {
    let folder = Folder::new("occlusion-compare");
    let out = folder.path("compared.json");
    let args = ["occluders", "city:cells=8,objects=400", "--own", "building", "--size", "320x180"];
    ends(&[&args[..], &["--compare", "--json", &out]].concat(), 0);
    let json: Value = serde_json::from_slice(&std::fs::read(&out).unwrap()).unwrap();
    let kinds = json["comparison"]["kinds"].as_array().unwrap();
    let of = |key: &str| kinds.iter().map(|k| k[key].as_u64().unwrap()).collect::<Vec<u64>>();
    let names: Vec<&str> = kinds.iter().map(|k| k["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["own", "baked", "all triangles"]);
    assert_eq!(of("false_culls"), [0, 0, 0]);
    let found = of("found");
    assert!(found[1] * 100 >= found[0] * 95 && found[2] >= found[0], "{found:?}");
    assert!(found[0] > 0 && found[2] <= of("hidden")[0], "{found:?}");
    // Names without a comparison, and one that nothing has.
    ends(&args, 2);
    let bad = ["occluders", "city:cells=2", "--compare", "--own", "cathedral"];
    assert!(ends(&bad, 3).contains("cathedral"));
}
