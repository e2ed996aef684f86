//! The share of each stage in a report, against runs of that stage alone, triangle for triangle.

use std::process::Command;

use cullet::cull::occlusion::Occlusion;
use cullet::{Culler, Stage, View, ViewState, Visible, funnel::Unit};
use cullet_io::{LoadOptions, Model};
use cullet_maps::load;
use cullet_scenes::paths::{self, Overrides, PathSpec};
use cullet_testkit::oracles::alone;
use serde_json::Value;

const VIEWS: usize = 2;
const SIZE: [u32; 2] = [480, 270];

/// Records of `cullet verify` for every view.
fn verified(scene: &str, path: &str) -> Vec<Value> {
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let views = VIEWS.to_string();
    let out = Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args(["verify", scene, "--path", path, "--views", &views, "--size", &size])
        .args(["--samples", "1", "--json", "-", "--quiet", "--occlusion-budget", "100000"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{scene} on {path}: {error}");
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    json["views"].as_array().unwrap().clone()
}

/// The same views, and the culler that the program has with that budget.
fn inputs(model: &Model, path: &str) -> (Vec<View>, Culler) {
    let overrides = Overrides::default();
    let spec: PathSpec = path.parse().unwrap();
    let cameras = paths::cameras(model, &spec, VIEWS, SIZE, &overrides).unwrap();
    let view = |camera| View::new(camera, overrides.depth, SIZE).unwrap();
    let occlusion = Some(Occlusion::default().with_budget(100_000.0));
    (cameras.iter().map(view).collect(), Culler::default().with_occlusion(occlusion))
}

/// Holds the shares of a scene's views against the stages run alone; returns what each took.
fn check(scene: &str, model: &Model, path: &str) -> [u64; Stage::ALL.len() + 1] {
    let (views, culler) = inputs(model, path);
    let telling = alone::telling(&culler);
    let mut sums = [0; Stage::ALL.len() + 1];
    for (index, (view, said)) in views.iter().zip(verified(scene, path)).enumerate() {
        let mut result = Visible::default();
        model.in_cells().cull(&telling, view, &mut ViewState::default(), &mut result);
        let together = alone::fates(&model.scene, &result);
        let alone = alone::fates_alone(&culler, model.in_cells(), view);
        assert!(together == alone, "{scene} on {path}: a stage alone takes other triangles");
        alone::check_rows(&model.scene, &result, &together);
        for stage in Stage::ALL {
            let units = [Unit::Instances, Unit::Clusters, Unit::Triangles];
            let taken: u64 = units.map(|unit| alone::taken(&alone, stage, unit)).iter().sum();
            let said = said["removed"][stage.name()].as_u64().unwrap_or(0);
            assert_eq!(said, taken, "{scene} on {path}, view {index}: {stage:?}");
            sums[stage as usize] += taken;
        }
    }
    sums
}

#[test]
fn built_in_scenes_share_as_their_stages_do_alone() {
    let mut sums = [0; Stage::ALL.len() + 1];
    for (scene, path) in [
        ("city:objects=1000,cells=16", "walk"),
        ("city:objects=300,cells=8,sub=5", "fly"),
        ("office", "walk"),
        ("plant:bays=3,floors=2,kinds=4", "walk"),
        ("forest:n=2000", "walk"),
        ("solids", "fly"),
        ("knobs", "orbit"),
        ("moving", "walk"),
    ] {
        let of_scene = check(scene, &cullet_scenes::build(scene).unwrap(), path);
        sums.iter_mut().zip(of_scene).for_each(|(sum, n)| *sum += n);
    }
    for stage in [Stage::Frustum, Stage::Occlusion, Stage::Backface] {
        assert!(sums[stage as usize] > 10_000, "{stage:?} took {}", sums[stage as usize]);
    }
}

#[test]
fn models_share_as_their_stages_do_alone() {
    for (file, path) in [
        ("armadillo/armadillo.obj", "orbit"),
        ("room-godot/room.glb", "walk"),
        ("duplex-bim/duplex.glb", "walk"),
        ("cad-2cylinder/2CylinderEngine.glb", "orbit"),
    ] {
        let Some(file) = cullet_testkit::data(file) else { continue };
        let model = load(&file, &LoadOptions::default()).unwrap();
        check(&file.to_string_lossy(), &model, path);
    }
}

/// All of the armadillo is in the picture: what it hides of itself is not outside the view.
#[test]
fn the_frustum_takes_nothing_of_the_armadillo() {
    let Some(file) = cullet_testkit::data("armadillo/armadillo.obj") else { return };
    for view in verified(&file.to_string_lossy(), "orbit") {
        let removed = &view["removed"];
        assert_eq!(removed.get("frustum"), None, "{removed}");
        assert!(removed["occlusion"].as_u64() > Some(10_000), "{removed}");
    }
}

/// Where the whole model is in the picture, the frustum takes nothing.
#[test]
fn what_hides_itself_is_not_outside_the_view() {
    let views = verified("knobs", "orbit");
    for view in views {
        let removed = &view["removed"];
        assert_eq!(removed.get("frustum"), None, "{removed}");
        assert!(removed["backface"].as_u64() > Some(0), "{removed}");
    }
}
