//! `cullet-baker bake --impostors`, run as a program: impostors are made where they pay, come back
//! from the file, and are the same bytes whatever the threads.

use std::path::Path;
use std::process::Command;

use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_io::baked::LevelKind;
use cullet_io::{LoadOptions, Model, save};
use cullet_maps::load;
use cullet_mesh::Impostor;
use cullet_testkit::{Folder, Rng, soups};
use serde_json::Value;

fn figures(args: &[&str]) -> Value {
    let program = env!("CARGO_BIN_EXE_cullet-baker");
    let output =
        Command::new(program).arg("bake").args(args).args(["--json", "-"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Leaves around the crown of a tree, of which no simplification makes few that are near them; and
/// a block, of which that is easy.
fn model() -> Model {
    let mut rng = Rng(3);
    let mut leaf = || {
        let v = rng.vector(4.0);
        let length = v.iter().map(|v| v * v).sum::<f64>().sqrt().max(0.1);
        let [x, y, z] = v.map(|v| (v / length * 4.0) as f32);
        soups::block([x, y, z], [x + 1.3, y + 0.2, z + 1.1])
    };
    let leaves = soups::join((0..160).map(|_| leaf()));
    let mut scene = Scene::new();
    for (k, (positions, indices)) in (0..).zip([leaves, soups::divided_block(8)]) {
        let data = MeshData { positions, indices, ..MeshData::default() };
        let mesh = scene.add_mesh(Mesh::new(data).unwrap());
        let place = Transform::from_translation([f64::from(k) * 9.0, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.sort();
    let mesh_names = ["leaves", "block"].map(String::from).to_vec();
    Model { name: "tree".into(), scene, mesh_names, ..Model::default() }
}

#[test]
fn impostors_are_made_where_they_pay_and_are_the_same_with_any_threads() {
    let folder = Folder::new("impostors");
    let [plain, out, again, without] =
        ["plain.glb", "out.glb", "again.glb", "without.glb"].map(|name| folder.path(name));
    save(&model(), Path::new(&plain)).unwrap();
    let sheets = folder.path("sheets");
    let record = figures(&[
        &plain,
        "-o",
        &out,
        "--threads",
        "1",
        "--impostors",
        "--impostor-sheets",
        &sheets,
    ]);
    assert_eq!((&record["impostors"], &record["impostors_bytes"]), (&1.into(), &83_008.into()));
    let kept = folder.path("kept");
    let resumed = || {
        let args = [&plain, "-o", &again, "--threads", "2", "--impostors", "--resume"];
        let record = figures(&[&args[..], &["--units", &kept]].concat());
        assert!(std::fs::read(&out).unwrap() == std::fs::read(&again).unwrap(), "two threads");
        record["resumed"].as_u64().unwrap()
    };
    assert_eq!(resumed(), 0);
    let files = std::fs::read_dir(&kept).unwrap().map(|f| f.unwrap().path());
    let impostors = files.filter(|f| f.extension().is_some_and(|e| e == "impostor")).count();
    assert_eq!(impostors, 1);
    assert_eq!(resumed(), std::fs::read_dir(&kept).unwrap().count() as u64);

    let options = LoadOptions { impostors: true, ..LoadOptions::default() };
    let back = load(Path::new(&out), &options).unwrap();
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let baked = back.baked.as_ref().unwrap();
    let kinds = |mesh: u32| -> Vec<LevelKind> {
        baked.of(mesh).map_or(Vec::new(), |m| m.levels.iter().map(|l| l.kind).collect())
    };
    assert!(kinds(0).contains(&LevelKind::Impostor) && !kinds(1).contains(&LevelKind::Impostor));
    let impostor = back.scene.levels(0).iter().find_map(Impostor::of).unwrap();
    assert_eq!((impostor.grid(), impostor.texels()), (12, 12));
    for name in ["coverage.png", "color.png", "normal.png", "depth.png"] {
        assert!(Path::new(&format!("{sheets}/mesh-0-{name}")).is_file(), "{name}");
    }
    let cards = load(Path::new(&format!("{sheets}/mesh-0.gltf")), &options).unwrap();
    assert_eq!(cards.scene.triangle_count(), 12);

    // Baked once more without, there are none.
    let record = figures(&[&out, "-o", &without]);
    assert_eq!(record["impostors"], 0);
    let back = load(Path::new(&without), &options).unwrap();
    assert!(back.scene.levels(0).iter().all(|l| l.impostor.is_none()));
}

#[test]
fn shares_of_impostors_join_to_the_bytes_of_one_process() {
    let folder = Folder::new("impostor-shares");
    let [plain, out, whole] = ["plain.glb", "out.glb", "whole.glb"].map(|name| folder.path(name));
    save(&model(), Path::new(&plain)).unwrap();
    figures(&[&plain, "-o", &whole, "--impostors", "--merge"]);
    let units = format!("{out}.units");
    let impostors = || {
        let files = std::fs::read_dir(&units).unwrap().map(|f| f.unwrap().path());
        files.filter(|f| f.extension().is_some_and(|e| e == "impostor")).count()
    };
    // There is one impostor, which one of the shares makes.
    let made = ["2/2", "1/2"].map(|share| {
        let program = env!("CARGO_BIN_EXE_cullet-baker");
        let args = ["bake", &plain, "-o", &out, "--impostors", "--merge", "--unit", share];
        let output = Command::new(program).args(args).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        impostors()
    });
    assert_eq!(made, [0, 1]);
    let record = figures(&[&plain, "-o", &out, "--impostors", "--merge", "--resume"]);
    assert_eq!(record["resumed"], std::fs::read_dir(&units).unwrap().count());
    assert!(std::fs::read(&out).unwrap() == std::fs::read(&whole).unwrap());
}
