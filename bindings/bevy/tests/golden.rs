//! A baked file that Bevy loads as an asset gives the answers that it gives everywhere.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::app::TaskPoolPlugin;
use bevy::asset::{AssetPlugin, LoadState};
use bevy::prelude::*;
use bevy_cullet::engine::{Culler, Depth, View, ViewState, Visible, funnel::Counts};
use bevy_cullet::{CulletBaked, CulletBakedPlugin};
use serde_json::Value;

/// The folder of the shared answers; `None`, said aloud, where there is none.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("CULLET_GOLDEN").map(PathBuf::from);
    if folder.is_none() {
        let required = std::env::var_os("CULLET_REQUIRE_DATA").is_some_and(|v| v == "1");
        assert!(!required, "CULLET_GOLDEN names no folder: run cargo xtask bindings bevy");
        println!("skipped: CULLET_GOLDEN names no folder");
    }
    folder
}

fn app(folder: &std::path::Path) -> App {
    let mut app = App::new();
    let file_path = folder.to_string_lossy().into_owned();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin { file_path, ..default() },
        CulletBakedPlugin,
    ));
    app.finish();
    app.cleanup();
    app
}

fn load(app: &mut App, file: &str) -> Result<Handle<CulletBaked>, String> {
    let handle = app.world().resource::<AssetServer>().load::<CulletBaked>(file.to_owned());
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        app.update();
        match app.world().resource::<AssetServer>().load_state(&handle) {
            LoadState::Loaded => return Ok(handle),
            LoadState::Failed(error) => return Err(error.to_string()),
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    Err("not loaded within a minute".to_owned())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn baked_assets_give_the_answers_of_all_hosts() {
    let Some(folder) = folder() else { return };
    let folder = folder.canonicalize().expect("the folder");
    let text = std::fs::read_to_string(folder.join("golden.json")).expect("golden.json");
    let golden: Value = serde_json::from_str(&text).expect("JSON");
    let mut app = app(&folder);
    let scenes = golden["scenes"].as_array().expect("scenes");
    assert!(scenes.len() >= 5);
    for of in scenes {
        let name = of["file"].as_str().expect("a name");
        let handle = load(&mut app, name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let assets = app.world().resource::<Assets<CulletBaked>>();
        let model = &assets.get(&handle).expect("loaded").model;
        let scene = &model.scene;
        for (number, answer) in of["views"].as_array().expect("views").iter().enumerate() {
            let matrix: [f64; 16] =
                numbers(&answer["clip_from_world"]).try_into().expect("sixteen");
            let size = numbers(&answer["viewport"]);
            let view = View::from_matrix(matrix, Depth::Reversed, [size[0] as u32, size[1] as u32])
                .expect("a view");
            let culler = match answer["preset"].as_str().expect("a preset") {
                "exact" => Culler::exact(),
                "balanced" => Culler::balanced(),
                "fast" => Culler::fast(),
                other => panic!("preset {other}"),
            };
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            model.in_cells().cull(&culler, &view, &mut state, &mut visible);
            let mut ids: Vec<_> = visible
                .slots()
                .map(|slot| f64::from(scene.handle(slot).expect("full").index))
                .collect();
            ids.sort_by(f64::total_cmp);
            assert_eq!(ids, numbers(&answer["visible"]), "{name} {number}");
            let rows: Vec<_> = visible
                .funnel
                .rows
                .iter()
                .map(|row| {
                    let counts = |c: &Counts| [c.instances, c.clusters, c.triangles];
                    serde_json::json!({
                        "stage": row.stage.name(), "unit": row.unit.name(),
                        "in": counts(&row.entered), "out": counts(&row.left),
                    })
                })
                .collect();
            assert_eq!(Value::Array(rows), answer["funnel"], "{name} {number}");
        }
    }
}

#[test]
fn a_file_that_is_none_is_refused_with_its_name() {
    let folder = std::env::temp_dir().join(format!("bevy_cullet-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("broken.glb"), b"glTF and nothing more").expect("a file");
    let error = load(&mut app(&folder), "broken.glb").expect_err("it is no file of ours");
    std::fs::remove_dir_all(&folder).expect("removed");
    assert!(error.contains("broken.glb"), "{error}");
}
