//! `--lod` as users meet it: what is stated of levels of detail, found, shown and refused.

use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, Output};

use cullet::lod::{Group, NO_GROUP};
use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_io::baked::{
    Baked, BakedLevels, BakedMesh, ClusterRow, LevelKind, LevelTables, Measured, geometry_hash,
};
use cullet_io::{Model, save};
use cullet_testkit::{Folder, soups};
use serde_json::Value;

/// Rings of a ball and of its levels, each of vertices of the one before.
const RINGS: [u32; 4] = [64, 32, 16, 8];

/// Runs the program with a folder of caches of its own.
fn cullet(caches: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", "/nonexistent/costs.json");
    command.env("XDG_CACHE_HOME", caches).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The levels of a ball, which state `honesty` times their true error.
fn tables(ball: &Mesh, honesty: f64) -> LevelTables {
    let bits = |p: [f32; 3]| p.map(|v| (v + 0.0).to_bits());
    let places: HashMap<[u32; 3], u32> =
        ball.positions().iter().zip(0..).map(|(p, i)| (bits(*p), i)).collect();
    let mut out = LevelTables::default();
    for (level, &rings) in (0u32..).zip(&RINGS[1..]) {
        let (positions, indices) = soups::ball(rings, 2 * rings);
        for some in indices.chunks(3 * 40) {
            let made_from = level;
            let replaced_by = if level + 2 == RINGS.len() as u32 { NO_GROUP } else { level + 1 };
            out.clusters.push(ClusterRow {
                first_triangle: (out.indices.len() / 3) as u32,
                triangle_count: (some.len() / 3) as u32,
                made_from,
                replaced_by,
            });
            out.indices.extend(some.iter().map(|&i| places[&bits(positions[i as usize])]));
        }
        // The circle around half of a square is as large as its diagonal.
        let step = std::f64::consts::PI / f64::from(rings);
        let error = ((1.0 - step.cos().sqrt()) * honesty) as f32;
        out.groups.push(Group { centre: [0.0; 3], radius: 1.0, error });
    }
    out.parts.push((out.indices.len() / 3) as u32);
    out
}

/// Writes balls at several distances, with levels.
fn write(path: &str, honesty: f64) {
    let (positions, indices) = soups::ball(RINGS[0], 2 * RINGS[0]);
    let ball = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
    let mut scene = Scene::new();
    let geometry = geometry_hash(&ball);
    let (held, levels) = tables(&ball, honesty).build(&ball).unwrap();
    let mesh = scene.add_mesh(ball);
    for k in 0..8 {
        let place = [f64::from(k % 3) * 2.5, 0.0, -3.0 * f64::from(k)];
        scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap();
    }
    scene.sort();
    let held_by = scene.add_mesh(held);
    scene.add_levels(mesh, held_by, levels).unwrap();
    let levels =
        vec![BakedLevels { kind: LevelKind::Chain, held_by, measured: Measured::default() }];
    let of_ball = BakedMesh { mesh, geometry, levels, ..BakedMesh::default() };
    let baked = Baked { meshes: vec![of_ball], ..Baked::default() };
    let mesh_names = vec!["ball".to_owned()];
    let model = Model { scene, mesh_names, baked: Some(baked), ..Model::default() };
    save(&model, Path::new(path)).unwrap();
}

const VIEWS: &[&str] = &["--views", "2", "--size", "240x150", "--samples", "2", "--quiet"];

#[test]
fn what_levels_state_is_what_verify_finds() {
    let folder = Folder::new("lod");
    let (honest, broken) = (folder.path("honest.glb"), folder.path("broken.glb"));
    write(&honest, 1.0);
    write(&broken, 0.2);
    let verify = |file: &str, json: &str, more: &[&str]| {
        let args = [&["verify", file, "--lod", "0.5", "--json", json][..], VIEWS, more].concat();
        let ended = cullet(&folder.path("cache"), &args);
        let found: Value = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
        (ended.status.code(), text(&ended.stdout), found)
    };
    let (code, said, found) = verify(&honest, &folder.path("honest.json"), &[]);
    assert_eq!(code, Some(0), "{said}");
    let levels = &found["summary"]["levels"];
    let d = &levels["deviation"];
    let number = |v: &Value| v.as_f64().unwrap();
    assert_eq!((number(&d["threshold_px"]), &d["kept"]), (0.5, &Value::Bool(true)));
    assert!(number(&d["max_px"]) <= 0.5 * 1.001 && number(&d["p999_px"]) > 0.05, "{d}");
    assert!(number(&d["points"]) > 100_000.0 && said.contains("kept"), "{said}");
    assert_eq!(found["summary"]["false_culls"], 0);
    let l = &levels["ladder"];
    let rungs: Vec<f64> = ["all", "frustum", "backface", "occlusion", "levels", "visible"]
        .map(|rung| number(&l[rung]))
        .into();
    assert!(rungs.is_sorted_by(|a, b| a >= b) && rungs[3] > rungs[4], "{l}");
    let drawn: f64 = levels["drawn"].as_array().unwrap().iter().map(number).sum();
    assert_eq!(drawn, rungs[4]);

    // A budget comes to a threshold of its own, which is the one that is stated; the second view
    // stays in the ball of the first.
    let more = ["--lod-triangles", "2300", "--lod-ball", "100"];
    let (code, said, found) = verify(&honest, &folder.path("budget.json"), &more);
    let levels = &found["summary"]["levels"];
    let d = &levels["deviation"];
    assert_eq!(
        (code, &d["kept"], &found["summary"]["false_culls"]),
        (Some(0), &true.into(), &0.into()),
        "{said}"
    );
    assert!(number(&d["threshold_px"]) > 0.5 && number(&d["max_px"]) > 0.1, "{d}");
    let steady: f64 = levels["drawn"].as_array().unwrap().iter().map(number).sum();
    assert!(steady <= 2.0 * 2000.0 && steady < drawn, "{steady} {drawn}");

    let (code, said, found) = verify(&broken, &folder.path("broken.json"), &["--lod-corners"]);
    let d = &found["summary"]["levels"]["deviation"];
    assert_eq!((code, &d["kept"]), (Some(1), &Value::Bool(false)), "{said}");
    assert!(number(&d["max_px"]) > 0.6 && said.contains("NOT KEPT"), "{said}");
    assert_eq!((&d["at_corners"], &found["summary"]["false_culls"]), (&true.into(), &0.into()));
}

#[test]
fn a_report_goes_from_all_to_visible_and_pictures_show_levels() {
    let folder = Folder::new("lod-report");
    let (file, out) = (folder.path("balls.glb"), folder.path("r"));
    write(&file, 1.0);
    let args =
        [&["report", &file, "--lod", "1", "--out", &out, "--triangle-ns", "5"], VIEWS].concat();
    let ended = cullet(&folder.path("cache"), &args);
    assert_eq!(ended.status.code(), Some(0), "{}", text(&ended.stderr));
    let page = std::fs::read_to_string(folder.path("r/index.html")).unwrap();
    for words in
        ["from all to visible", "with levels of detail", "level 2", "stated 1 px", "Estimated cost"]
    {
        assert!(page.contains(words), "{words}");
    }
    let record: Value =
        serde_json::from_slice(&std::fs::read(folder.path("r/report.json")).unwrap()).unwrap();
    // The mesh that holds levels is no mesh of the scene's own.
    assert_eq!(
        (&record["scene"]["meshes"], record["meshes"].as_array().unwrap().len()),
        (&1.into(), 1)
    );
    let cost = &record["levels"];
    assert!(cost["stored_level_triangles"].as_u64() > Some(0), "{cost}");
    assert!(cost["ms_per_view"][0].as_f64() > cost["ms_per_view"][1].as_f64(), "{cost}");
    for name in ["levels", "levels-drawn", "levels-difference"] {
        assert!(Path::new(&folder.path(&format!("r/view-000-{name}.png"))).is_file(), "{name}");
    }
    for kind in ["levels", "levels-difference", "shaded", "kinds"] {
        let png = folder.path(&format!("{kind}.png"));
        let args = ["picture", kind, &file, "--lod", "1", "--size", "240x150", "--out", &png];
        let ended = cullet(&folder.path("cache"), &args);
        assert_eq!(ended.status.code(), Some(0), "{kind}: {}", text(&ended.stderr));
        assert!(std::fs::metadata(&png).unwrap().len() > 1000);
    }
    let ended = cullet(&folder.path("cache"), &["picture", "levels", &file]);
    assert!(ended.status.code() == Some(2) && text(&ended.stderr).contains("--lod 1"));
}

#[test]
fn a_mesh_is_shown_beside_its_impostor() {
    let folder = Folder::new("picture-impostor");
    let png = folder.path("impostor.png");
    let args = ["picture", "impostor", "knobs", "--out", &png];
    let ended = cullet(&folder.path("cache"), &args);
    assert_eq!(ended.status.code(), Some(0), "{}", text(&ended.stderr));
    assert!(text(&ended.stdout).contains("12 x 12 frames"), "{}", text(&ended.stdout));
    assert!(std::fs::metadata(&png).unwrap().len() > 1000);
}

#[test]
fn thresholds_that_are_none_are_refused() {
    let folder = Folder::new("lod-usage");
    for bad in ["-1", "nan", "inf", "1px"] {
        let ended = cullet(&folder.path("cache"), &["verify", "solids", "--lod", bad]);
        let said = text(&ended.stderr);
        assert!(ended.status.code() == Some(2) && said.contains(bad), "{said}");
        assert!(said.contains("pixels") && said.contains("try 1"), "{said}");
    }
    for [name, bad, wanted] in
        [["--lod-triangles", "0", "number of triangles"], ["--lod-ball", "-1", "radius"]]
    {
        let given = format!("{name}={bad}");
        let ended = cullet(&folder.path("cache"), &["verify", "solids", "--lod", "1", &given]);
        let said = text(&ended.stderr);
        assert!(
            ended.status.code() == Some(2) && said.contains(wanted) && said.contains("try"),
            "{said}"
        );
    }
    let ended = cullet(&folder.path("cache"), &["verify", "solids", "--lod-corners"]);
    assert!(ended.status.code() == Some(2) && text(&ended.stderr).contains("--lod"));
}

#[test]
fn without_levels_and_baker_it_is_said_what_to_do() {
    let folder = Folder::new("lod-none");
    // Away from what cargo built, there is no baker beside it, but the lab.
    let copied = |name: &str| {
        let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
        let built = Path::new(env!("CARGO_BIN_EXE_cullet")).with_file_name(&name);
        let copy = folder.path(&name);
        std::fs::copy(built, &copy).unwrap();
        copy
    };
    let program = copied("cullet");
    copied("cullet-lab");
    let run = |args: &[&str]| {
        let mut command = Command::new(&program);
        command.args(args).env("XDG_CACHE_HOME", folder.path("cache")).env("PATH", folder.path(""));
        command.output().unwrap()
    };
    let small = ["solids:n=20", "--views", "1", "--size", "64x40", "--samples", "1"];
    let ended = run(&[&["verify", "--lod", "1"], &small[..]].concat());
    let said = text(&ended.stderr);
    assert_eq!(ended.status.code(), Some(3), "{said}");
    assert!(said.contains("cullet bake solids:n=20 -o baked.glb"), "{said}");
    assert!(said.contains("neither beside this program nor in PATH"), "{said}");
    // Nothing is lossy unless it is asked for.
    assert_eq!(run(&[&["verify", "--lod", "0"], &small[..]].concat()).status.code(), Some(0));
    let ended = run(&["bench", "culler", "solids", "--lod", "1", "--seconds", "0.01"]);
    assert!(ended.status.code() == Some(3) && text(&ended.stderr).contains("cullet bake"));
}

#[test]
fn a_film_moves_away_from_what_has_levels() {
    let folder = Folder::new("dolly");
    let file = folder.path("balls.glb");
    write(&file, 1.0);
    let out = folder.path("dolly.webp");
    let ended = cullet(
        &folder.path("caches"),
        &[
            "film", &file, "--of", "dolly", "--lod", "1", "--size", "320x180", "--frames", "4",
            "--out", &out,
        ],
    );
    assert_eq!(ended.status.code(), Some(0), "{}", text(&ended.stderr));
    assert!(std::fs::read(&out).unwrap().starts_with(b"RIFF"));
}
