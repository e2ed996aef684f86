//! `cullet-baker bake`, run as a program: what it writes is what the library makes, on any number
//! of threads and however often it was stopped.

use std::path::Path;
use std::process::{Command, Output};

use cullet::mesh::Part;
use cullet::{Instance, Mesh, MeshData, Scene, Transform, prepared::Preparation};
use cullet_bake::levels::{ChainOptions, HierarchyOptions, build_chain, build_hierarchy};
use cullet_bake::occluders::{OccluderOptions, occluders};
use cullet_io::baked::LevelKind;
use cullet_io::{Attributes, LoadOptions, Model, save};
use cullet_maps::load;
use cullet_testkit::{Folder, soups};
use serde_json::Value;

fn baker(args: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_cullet-baker");
    Command::new(program).arg("bake").args(args).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// Runs with `--json -`; the figures.
fn figures(args: &[&str]) -> Value {
    let output = baker(&[args, &["--json", "-"]].concat());
    assert!(output.status.success(), "{}", told(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn loaded(path: &str) -> Model {
    load(Path::new(path), &LoadOptions::default()).unwrap()
}

fn bytes(path: &str) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

/// A ball of two parts, large enough for a hierarchy; a small one; a triangle; and nothing but
/// triangles without area.
fn model() -> Model {
    let mut scene = Scene::new();
    let half = |(positions, indices): soups::Soup, half: u32| {
        let count = (indices.len() / 3) as u32;
        let part = |first_triangle, triangle_count, material| Part {
            first_triangle,
            triangle_count,
            material,
            ..Part::default()
        };
        let parts = vec![part(0, half, 0), part(half, count - half, 1)];
        Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap()
    };
    let flat = (vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![0, 1, 2, 0, 0, 1]);
    let single = (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2]);
    let meshes = [
        half(soups::ball(48, 64), 2000),
        half(soups::ball(12, 16), 100),
        half(single, 1),
        half(flat, 1),
    ];
    for (k, mesh) in meshes.into_iter().enumerate() {
        let mesh = scene.add_mesh(mesh);
        let place = Transform::from_scale_translation([1.0; 3], [k as f64 * 3.0, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap();
    }
    scene.sort();
    let mesh_names = ["large", "small", "single", "flat"].map(String::from).to_vec();
    let material = |name: &str| cullet_io::Material { name: name.into(), color: [1.0; 4] };
    let materials = vec![material("red"), material("blue")];
    Model { name: "balls".into(), scene, mesh_names, materials, ..Model::default() }
}

#[test]
fn levels_are_those_of_the_library_whatever_the_threads_and_stops() {
    let folder = Folder::new("same");
    let (plain, out) = (folder.path("plain.glb"), folder.path("out.glb"));
    save(&model(), Path::new(&plain)).unwrap();
    let record = figures(&[&plain, "-o", &out, "--threads", "1"]);
    assert_eq!((&record["schema"], &record["meshes"]), (&1.into(), &4.into()));
    assert_eq!((&record["chains"], &record["hierarchies"]), (&2.into(), &1.into()));
    let first = bytes(&out);
    assert_eq!(record["bytes"], first.len());
    let back = loaded(&out);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let baked = back.baked.as_ref().unwrap();
    let kinds = |mesh: usize| -> Vec<LevelKind> {
        baked.of(mesh as u32).map_or(Vec::new(), |m| m.levels.iter().map(|l| l.kind).collect())
    };
    assert_eq!(kinds(0), [LevelKind::Chain, LevelKind::Hierarchy]);
    assert_eq!([kinds(1), kinds(2), kinds(3)], [vec![LevelKind::Chain], vec![], vec![]]);
    let base = back.scene.meshes()[0].to_data();
    let direct = [
        build_chain(&base, &ChainOptions::default()).unwrap(),
        build_hierarchy(&base, None, &HierarchyOptions::default()).unwrap(),
    ];
    let mut stored = 0;
    for (made, found) in direct.into_iter().zip(back.scene.levels(0)) {
        let (mesh, levels) = made.into_levels().unwrap();
        assert_eq!(found.levels, levels);
        let held_by = &back.scene.meshes()[found.mesh as usize];
        assert_eq!((held_by.positions(), held_by.indices()), (mesh.positions(), mesh.indices()));
        assert_eq!(held_by.clusters(), mesh.clusters());
        assert_eq!(held_by.parts().len(), 2);
        stored += u64::from(mesh.triangle_count());
    }
    let small = back.scene.levels(1)[0].mesh;
    stored += u64::from(back.scene.meshes()[small as usize].triangle_count());
    assert_eq!(record["levels_triangles"], stored);

    let again = folder.path("again.glb");
    let kept = folder.path("kept");
    let resume = |threads: &str| {
        let args = [&plain, "-o", &again, "--threads", threads, "--resume", "--units", &kept];
        figures(&args)["resumed"].as_u64().unwrap()
    };
    assert_eq!(resume("2"), 0);
    assert!(bytes(&again) == first, "two threads");
    let mut files: Vec<_> = std::fs::read_dir(&kept).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len(), 3);
    // One is gone, one is damaged, one stays.
    std::fs::remove_file(&files[0]).unwrap();
    let mut odd = std::fs::read(&files[1]).unwrap();
    let middle = odd.len() / 2;
    odd[middle] ^= 1;
    std::fs::write(&files[1], odd).unwrap();
    std::fs::remove_file(&again).unwrap();
    assert_eq!(resume("1"), 1);
    assert!(bytes(&again) == first, "resumed");
    assert_eq!(resume("2"), 3);
    assert!(bytes(&again) == first, "all of it there");

    // Baked once more from what was baked, it is the same.
    let third = folder.path("third.glb");
    figures(&[&out, "-o", &third]);
    assert!(bytes(&third) == first, "of a baked file");
    let chains = folder.path("chains.glb");
    let record = figures(&[&plain, "-o", &chains, "--no-hierarchy"]);
    assert_eq!((&record["chains"], &record["hierarchies"]), (&2.into(), &0.into()));
}

#[test]
fn what_is_killed_leaves_the_file_before_and_goes_on_from_there() {
    let folder = Folder::new("killed");
    let (plain, out, kept) =
        (folder.path("plain.glb"), folder.path("out.glb"), folder.path("kept"));
    save(&model(), Path::new(&plain)).unwrap();
    let whole = folder.path("whole.glb");
    let start = std::time::Instant::now();
    figures(&[&plain, "-o", &whole, "--quiet"]);
    let (took, whole) = (start.elapsed(), bytes(&whole));
    for part in 0..=4u32 {
        std::fs::write(&out, b"good").unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_cullet-baker"))
            .args(["bake", &plain, "-o", &out, "--quiet", "--resume", "--units", &kept])
            .spawn()
            .unwrap();
        std::thread::sleep(took * part / 4);
        // One that has ended cannot be killed, and its file is whole.
        let _ = child.kill();
        child.wait().unwrap();
        let found = bytes(&out);
        assert!(found == b"good" || found == whole, "killed after {part} quarters");
    }
    figures(&[&plain, "-o", &out, "--quiet", "--resume", "--units", &kept]);
    assert!(bytes(&out) == whole);
}

/// Forty bumpy balls that touch, whose groups take most of the time, and one far away. Texture
/// coordinates are places.
fn row() -> Model {
    let mut scene = Scene::new();
    let (positions, indices) = soups::bumpy_ball(12, 0.1);
    let uvs = positions.iter().map(|&[x, y, _]| [x, y]).collect();
    let data = MeshData { positions, indices, ..MeshData::default() };
    let mesh = scene.add_mesh(Mesh::new(data).unwrap());
    for at in 0..41 {
        let far = if at == 40 { 57.0 } else { 0.0 };
        let place = [f64::from(at % 8) * 1.9 + far, 0.0, f64::from(at / 8) * 1.9];
        scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap();
    }
    scene.sort();
    let attributes = vec![Attributes { uvs, ..Attributes::default() }];
    let mesh_names = vec!["ball".into()];
    Model { name: "row".into(), scene, mesh_names, attributes, ..Model::default() }
}

#[test]
fn what_is_killed_between_merged_groups_goes_on_with_the_next() {
    let folder = Folder::new("groups");
    let [plain, whole, out, kept] =
        ["plain.glb", "whole.glb", "out.glb", "kept"].map(|name| folder.path(name));
    save(&row(), Path::new(&plain)).unwrap();
    let record = figures(&[&plain, "-o", &whole, "--merge", "--threads", "1"]);
    assert!(record["merged_groups"].as_u64().unwrap() > 1, "{record}");
    let options = LoadOptions { details: true, ..LoadOptions::default() };
    let back = load(Path::new(&whole), &options).unwrap();
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    for slot in back.scene.stand_in_slots() {
        let (mesh, m) = (back.scene.mesh(slot), back.scene.transform(slot).to_matrix());
        let uvs = &back.attributes[back.scene.mesh_id(slot) as usize].uvs;
        assert_eq!(uvs.len(), mesh.positions().len());
        // Where a vertex is in its ball, and the ball in its row.
        for (p, uv) in mesh.positions().iter().zip(uvs) {
            let along = (f64::from(p[0]) + m[12] - f64::from(uv[0])) / 1.9;
            let up = f64::from(p[1]) + m[13] - f64::from(uv[1]);
            assert!((along - along.round()).abs() < 1e-4 && up.abs() < 1e-4, "{p:?} {uv:?}");
        }
    }
    let args = ["--merge", "--threads", "1", "--quiet", "--resume", "--units"];
    let args = [&[plain.as_str(), "-o", &out][..], &args, &[&kept]].concat();
    let mut child =
        Command::new(env!("CARGO_BIN_EXE_cullet-baker")).arg("bake").args(&args).spawn().unwrap();
    let groups = || {
        let files = std::fs::read_dir(&kept).into_iter().flatten().flatten();
        files.filter(|f| f.path().extension().is_some_and(|e| e == "group")).count()
    };
    // Killed as soon as one group is there; should it be faster than that, all of them are.
    while groups() == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
    let (before, files) = (groups(), std::fs::read_dir(&kept).unwrap().count());
    assert!(before > 0 && files > before, "levels come before groups");
    let resumed = figures(&args)["resumed"].as_u64().unwrap();
    assert!(resumed as usize >= before, "{resumed} of {before} groups");
    assert!(bytes(&out) == bytes(&whole));
    let all = groups() as u64;
    assert!(figures(&args)["resumed"].as_u64().unwrap() > all, "and the levels too");
    assert!(bytes(&out) == bytes(&whole));
    // Without --resume nothing that is there counts, though it is kept anew.
    let fresh = [&args[..args.len() - 3], &["--units", &kept]].concat();
    assert_eq!(figures(&fresh)["resumed"], 0);
}

#[test]
fn occluders_are_those_that_are_made_of_each_mesh() {
    let folder = Folder::new("occluders");
    let (plain, out, kept) =
        (folder.path("plain.glb"), folder.path("out.glb"), folder.path("kept"));
    save(&model(), Path::new(&plain)).unwrap();
    let args = [&plain, "-o", &out, "--occluders", "--no-hierarchy", "--quiet", "--resume"];
    let args = [&args[..], &["--units", &kept]].concat();
    let record = figures(&args);
    assert_eq!((&record["occluders"], &record["resumed"]), (&4.into(), &0.into()));
    let back = loaded(&out);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let baked = back.baked.as_ref().unwrap();
    assert_eq!(baked.meshes.len(), 4);
    for one in &baked.meshes {
        let mesh = &back.scene.meshes()[one.mesh as usize];
        let (made, report) = occluders(mesh, &OccluderOptions::default()).unwrap();
        let stored = one.occluders.as_ref().unwrap();
        assert_eq!((stored, stored.efficiency), (&made, report.efficiency()));
        assert_eq!(one.levels.is_empty(), one.mesh >= 2);
    }
    assert!(!baked.meshes[0].occluders.as_ref().unwrap().boxes.is_empty(), "a ball is not flat");
    let first = bytes(&out);
    assert_eq!(figures(&args)["resumed"], 6);
    assert!(bytes(&out) == first);
    // A file that has them is baked as one that has none.
    figures(&[&out, "-o", &folder.path("again.glb"), "--occluders", "--no-hierarchy", "--quiet"]);
    assert!(bytes(&folder.path("again.glb")) == first);
}

#[test]
fn built_in_scenes_and_their_cells_are_baked() {
    let folder = Folder::new("office");
    let out = folder.path("office.glb");
    let name = "office:floors=1,corridors=1,rooms=2";
    let output = baker(&[name, "-o", &out, "--quiet"]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(output.stderr.is_empty(), "{}", told(&output));
    let (back, made) = (loaded(&out), cullet_scenes::build(name).unwrap());
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    assert_eq!(back.cells.cells, made.cells.cells);
    assert_eq!(back.scene.triangle_count(), made.scene.triangle_count());
    assert_eq!(back.cameras.len(), made.cameras.len());
    assert!(back.baked.is_some_and(|baked| !baked.meshes.is_empty()));
}

#[test]
fn what_cannot_be_written_or_baked_is_said() {
    let folder = Folder::new("bad");
    let ply = baker(&["city", "-o", &folder.path("a.ply")]);
    assert_eq!(ply.status.code(), Some(2), "{}", told(&ply));
    assert!(told(&ply).contains(".glb only"), "{}", told(&ply));
    let gone = baker(&[&folder.path("no.glb"), "-o", &folder.path("a.glb")]);
    assert_eq!(gone.status.code(), Some(3), "{}", told(&gone));
    let none = baker(&["city", "-o", &folder.path("a.glb"), "--no-chain", "--no-hierarchy"]);
    assert_eq!(none.status.code(), Some(2), "{}", told(&none));
    let empty = folder.path("empty.off");
    std::fs::write(&empty, "OFF\n0 0 0\n").unwrap();
    let record = figures(&[&empty, "-o", &folder.path("empty.glb"), "--quiet"]);
    assert_eq!((&record["meshes"], &record["levels_triangles"]), (&0.into(), &0.into()));
}

/// The mean time of the processor that nine runs took on this thread, in ms, as systems tell it in
/// steps; where the system does not tell it, that of the clock on the wall.
fn spent(run: &dyn Fn()) -> f64 {
    let start = std::time::Instant::now();
    let busy = || {
        let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let ns = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
        ns.unwrap_or_else(|| start.elapsed().as_nanos() as f64)
    };
    let before = busy();
    (0..9).for_each(|_| run());
    (busy() - before) / 9e6
}

/// How long a baked file takes to open beside the plain one. Run alone:
/// `cargo test --release -p cullet-baker --test bake -- --ignored --nocapture`.
#[test]
#[ignore = "prints times, and takes minutes"]
fn opening_a_baked_file() {
    let folder = Folder::new("open");
    for (name, path) in [
        ("armadillo", "armadillo/armadillo.obj"),
        ("buddha", "happy-buddha/buddha-100k.obj"),
        ("castle", "intel-castle/intel-castle.glb"),
    ] {
        let Some(path) = cullet_testkit::data(path) else { continue };
        let out = folder.path(&format!("{name}.glb"));
        let record = figures(&[path.to_str().unwrap(), "-o", &out, "--quiet"]);
        let time = |levels: bool| {
            let options =
                LoadOptions { levels, prepare: Preparation::NONE, ..LoadOptions::default() };
            spent(&|| drop(load(Path::new(&out), &options).unwrap()))
        };
        let (plain, all) = (time(false), time(true));
        println!("{name}: plain {plain:.1} ms, with levels {all:.1} ms; {record}");
    }
}

/// Bakes a model in shares, one of three never begun and one done twice; joined it has the bytes of
/// one process.
fn shares_join(model: &Model, options: &[&str], kinds: &[&str]) {
    let folder = Folder::new("shares");
    let [plain, out, whole] = ["plain.glb", "out.glb", "whole.glb"].map(|name| folder.path(name));
    save(model, Path::new(&plain)).unwrap();
    figures(&[&[plain.as_str(), "-o", &whole], options].concat());
    let of = [&[plain.as_str(), "-o", &out], options].concat();
    for share in ["3/3", "1/3", "3/3"] {
        let said = baker(&[&of[..], &["--unit", share]].concat());
        assert!(said.status.success(), "{}", told(&said));
        assert!(told(&said).contains(&format!("share {} of 3", &share[..1])), "{}", told(&said));
        assert!(!Path::new(&out).exists(), "a share writes no file");
    }
    let files = || -> Vec<_> {
        std::fs::read_dir(format!("{out}.units")).unwrap().map(|f| f.unwrap().path()).collect()
    };
    let there =
        |kind: &str| files().iter().filter(|f| f.extension().is_some_and(|e| e == kind)).count();
    kinds.iter().for_each(|kind| assert!(there(kind) > 0, "{kind}"));
    // What is damaged is made again.
    let damaged = files().into_iter().min().unwrap();
    std::fs::write(&damaged, b"torn").unwrap();
    let kept = files().len() as u64;
    let record = figures(&[&of[..], &["--resume"]].concat());
    assert_eq!(record["resumed"], kept - 1);
    assert!(bytes(&out) == bytes(&whole));
}

#[test]
fn shares_join_to_the_bytes_of_one_process() {
    shares_join(&model(), &["--occluders"], &["levels", "occluders"]);
    shares_join(&row(), &["--merge", "--threads", "1"], &["levels", "group"]);
}
