//! Models through each command that writes files, and back: the same triangles, instances and
//! bounds, or a note about what is missing.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use cullet_io::{LoadOptions, Model, save, world};
use cullet_maps::load;
use cullet_testkit::{Folder, data};
use serde_json::Value;

/// Larger files of the test data, in bytes, would take longer than a minute.
const LARGEST: u64 = 250_000;
/// Files are looked for so deep.
const DEEPEST: u32 = 6;

/// Instances, triangles and bounds of a model.
#[derive(Clone, Copy, Debug)]
struct Facts {
    instances: u64,
    triangles: u64,
    low: [f64; 3],
    high: [f64; 3],
}

impl Facts {
    /// Facts about all instances that have a place, by their vertices.
    fn of(model: &Model) -> Self {
        let scene = &model.scene;
        let mut facts = Self {
            instances: 0,
            triangles: 0,
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        };
        for slot in scene.slots().filter(|&slot| scene.transform(slot).is_finite()) {
            let mesh = scene.mesh(slot);
            facts.instances += u64::from(mesh.triangle_count() > 0);
            facts.triangles += u64::from(mesh.triangle_count());
            for &v in mesh.indices() {
                let p = world(scene.transform(slot), mesh.positions()[v as usize]);
                for a in 0..3 {
                    (facts.low[a], facts.high[a]) =
                        (facts.low[a].min(p[a]), facts.high[a].max(p[a]));
                }
            }
        }
        facts
    }

    /// Returns the difference, if there is one. Bounds may be off by a share of the size and a step
    /// at their place.
    fn differs(
        &self,
        other: &Self,
        [share, step]: [f64; 2],
        with_instances: bool,
    ) -> Option<String> {
        if self.triangles != other.triangles {
            return Some(format!("{} triangles for {}", other.triangles, self.triangles));
        }
        if with_instances && self.instances != other.instances {
            return Some(format!("{} instances for {}", other.instances, self.instances));
        }
        let size = (0..3).map(|a| self.high[a] - self.low[a]).fold(0.0, f64::max);
        let far = (0..3).map(|a| self.high[a].abs().max(self.low[a].abs())).fold(0.0, f64::max);
        let most = size * share + far * step;
        let off = |a: [f64; 3], b: [f64; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > most);
        let is_off = self.triangles > 0 && (off(self.low, other.low) || off(self.high, other.high));
        is_off.then(|| format!("{other:?} for {self:?}"))
    }
}

fn try_load(path: &Path) -> Option<Model> {
    load(path, &LoadOptions::default()).ok()
}

/// Runs a command; its figures and all that it said.
fn run(args: &[&str]) -> Result<(Value, String), String> {
    let program = env!("CARGO_BIN_EXE_cullet-baker");
    let output = Command::new(program).args(args).args(["--json", "-"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if !output.status.success() {
        return Err(said);
    }
    Ok((serde_json::from_slice(&output.stdout).unwrap(), said))
}

/// Sends a model through each command; what is wrong.
fn wrong(path: &Path, folder: &Folder) -> Vec<String> {
    let Some(model) = try_load(path).filter(|model| model.scene.triangle_count() > 0) else {
        return Vec::new();
    };
    let facts = Facts::of(&model);
    let text = path.to_str().unwrap();
    let out = |name: &str| folder.path(name);
    let miss = format!("1,0,0,{:?}", facts.high[0] + (facts.high[0] - facts.low[0]) + 1.0);
    let mut found = Vec::new();
    let mut check = |what: &str, args: &[&str], back: &str, share: f64| {
        let with_instances = back.ends_with(".glb") || back.ends_with(".json");
        let problem = match run(args) {
            // A refusal names why; that is no loss without a word.
            Err(said) if said.contains("would have an area in the 32-bit") => None,
            Err(said) if said.contains("more than 1e18; scale it down") => None,
            Err(said) => Some(format!("failed: {said}")),
            Ok((json, said)) => match try_load(Path::new(back)) {
                None => Some("what it wrote is not read".to_owned()),
                Some(again) => {
                    let again = Facts::of(&again);
                    let counted = ["triangles_after", "triangles"];
                    // The baker counts each mesh once.
                    let mut counted = counted.iter().filter(|_| what != "bake");
                    let counted = counted.find_map(|key| json[*key].as_u64());
                    match counted.filter(|&count| count != again.triangles) {
                        Some(count) => Some(format!(
                            "it counts {count} triangles; the file has {}",
                            again.triangles
                        )),
                        None if said.contains("left out") && said.contains("instance") => None,
                        None if what == "simplify" => None,
                        None => {
                            // Places in f64 are rounded too; vertices of an OBJ or PLY are read as f32.
                            let is_f32 = back.ends_with(".obj") || back.ends_with(".ply");
                            let step = if is_f32 { 6e-8 } else { 1e-14 };
                            facts.differs(&again, [share, step], with_instances)
                        }
                    }
                }
            },
        };
        found.extend(problem.map(|problem| format!("{}: {what}: {problem}", path.display())));
    };
    let tiles = out("tiles");
    check("tiles", &["tiles", text, "-o", &tiles], &(tiles.clone() + "/tileset.json"), 1e-6);
    let _ = std::fs::remove_dir_all(&tiles);
    for name in ["cut.glb", "cut.obj", "cut.ply", "cut.stl"] {
        let out = out(name);
        // f32 has 24 bits, and what is far from zero for its size is not rounded to it.
        check(name, &["cut", text, "--plane", &miss, "-o", &out], &out, 1e-4);
    }
    let baked = out("baked.glb");
    check("bake", &["bake", text, "-o", &baked], &baked, 1e-6);
    let few = out("few.glb");
    check(
        "simplify",
        &["simplify", text, "--error", "1e-9", "--samples", "1000", "-o", &few],
        &few,
        1e-6,
    );
    found
}

/// Sends all models through all commands, two side by side.
fn send(paths: &[PathBuf]) -> Vec<String> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(path) = paths.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let one = wrong(path, &Folder::new("round-trip"));
                    found.lock().unwrap().extend(one);
                }
            });
        }
    });
    found.into_inner().unwrap()
}

/// Files with the endings of models, of a folder and those below it.
fn models(folder: &Path, depth: u32, all: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if path.is_dir() && depth < DEEPEST {
            models(&path, depth + 1, all);
        } else if ["glb", "gltf", "obj", "ply", "stl", "off", "bsp"].contains(&ending.as_str())
            && path.metadata().is_ok_and(|m| m.len() <= LARGEST)
        {
            all.push(path);
        }
    }
}

#[test]
fn built_in_models_and_those_of_reports_come_back_from_every_writer() {
    let folder = Folder::new("round-trip-models");
    let mut paths = Vec::new();
    for (k, scene) in ["solids:n=20", "city:cells=4,objects=40,sub=2", "office", "forest:n=300"]
        .iter()
        .enumerate()
    {
        let Ok(model) = cullet_scenes::build(scene) else { panic!("{scene}") };
        let path = folder.root().join(format!("{k}.glb"));
        let _ = save(&model, &path).unwrap();
        paths.push(path);
    }
    models(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reports"), 0, &mut paths);
    assert!(paths.len() > 9);
    let found = send(&paths);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn files_of_the_test_data_come_back_from_every_writer() {
    let Some(root) = data("broken").and_then(|path| path.parent().map(Path::to_owned)) else {
        return;
    };
    let mut paths = Vec::new();
    models(&root, 0, &mut paths);
    assert!(paths.len() > 100, "{}", paths.len());
    let found = send(&paths);
    assert!(found.is_empty(), "{} of {}:\n{}", found.len(), paths.len(), found.join("\n"));
}

fn report(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reports");
    folder.join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_skinned_figure_is_in_the_tiles_beside_the_cube_and_counted() {
    let folder = Folder::new("skin-tiles");
    let out = folder.path("x");
    let (json, said) = run(&["tiles", &report("skin-and-cube.glb"), "-o", &out]).unwrap();
    assert_eq!((json["instances"].as_u64(), json["triangles"].as_u64()), (Some(2), Some(24)));
    assert!(!said.contains("left out: \""), "{said}");
    let again = Facts::of(&try_load(&Path::new(&out).join("tileset.json")).unwrap());
    assert_eq!((again.instances, again.triangles), (2, 24));
}

/// Areas of the triangles of an OBJ, whose places are read as f64.
fn areas(path: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(path).unwrap();
    let words = |key: &'static str| {
        text.lines().filter_map(move |line| line.strip_prefix(key)).map(|rest| rest.split(' '))
    };
    let vertices: Vec<[f64; 3]> = words("v ")
        .map(|line| line.map(|v| v.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
        .collect();
    let area = |corners: [[f64; 3]; 3]| {
        let [a, b, c] = corners;
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
        let cross: [f64; 3] = std::array::from_fn(|k| {
            u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]
        });
        cross.iter().map(|v| v * v).sum::<f64>().sqrt() * 0.5
    };
    let corner = |w: &str| vertices[w.split('/').next().unwrap().parse::<usize>().unwrap() - 1];
    words("f ").map(|line| area(line.map(corner).collect::<Vec<_>>().try_into().unwrap())).collect()
}

#[test]
fn a_cut_far_from_zero_has_the_areas_that_it_says() {
    let folder = Folder::new("far-cut");
    let plane = "1,0,0,-299510455.5";
    let cut = |name: &str| {
        let out = folder.path(name);
        let args = ["cut", &report("far-299M.glb"), "--plane", plane, "--cap", "-o", &out];
        let (json, said) = run(&args).unwrap();
        assert_eq!(json["cap_area"].as_f64(), Some(1.0));
        (out, said)
    };
    let (obj, _) = cut("f.obj");
    let found = areas(&obj);
    assert_eq!(found.len(), 20);
    // Half a cube: two sides whole, four halved.
    assert!((found.iter().sum::<f64>() - 4.0).abs() < 1e-6, "{found:?}");
    let svg = folder.path("f.svg");
    run(&["cut", &report("far-299M.glb"), "--plane", plane, "--section", &svg]).unwrap();
    let drawn = std::fs::read_to_string(&svg).unwrap();
    // The side of the cube, from whole numbers nearby.
    assert!(drawn.contains("data-from=\"") && drawn.contains("1.000000"), "{drawn}");
    assert!(!drawn.contains("M9842") && !drawn.contains("M-97"), "{drawn}");
    for name in ["f.stl", "f.glb"] {
        let (out, said) = cut(name);
        let facts = Facts::of(&try_load(Path::new(&out)).unwrap());
        let size: [f64; 3] = std::array::from_fn(|a| facts.high[a] - facts.low[a]);
        assert!((0..3).all(|a| (size[a] - [0.5, 1.0, 1.0][a]).abs() < 1e-6), "{name}: {size:?}");
        assert_eq!(
            said.contains("counted from (-299510456, 98424297, -975000)"),
            name == "f.stl",
            "{said}"
        );
    }
}

#[test]
fn a_sphere_that_is_simplified_far_from_zero_has_no_triangle_without_area() {
    let folder = Folder::new("far-sphere");
    let (positions, indices) = cullet_testkit::soups::ball(24, 48);
    let data = cullet::mesh::MeshData { positions, indices, ..Default::default() };
    let mut model = Model::default();
    let mesh = model.scene.add_mesh(cullet::Mesh::new(data).unwrap());
    let at = cullet::Transform::from_translation([-299_510_456.0, 98_424_296.0, -975_000.0]);
    model.scene.add(cullet::Instance::new(mesh, at)).unwrap();
    model.scene.commit(&cullet::Culler::default());
    let source = folder.path("ball.glb");
    let _ = save(&model, Path::new(&source)).unwrap();
    let out = folder.path("few.obj");
    let (json, _) = run(&["simplify", &source, "--error", "0.01", "-o", &out]).unwrap();
    let found = areas(&out);
    assert_eq!(Some(found.len() as u64), json["triangles"].as_u64());
    assert!(found.len() < 1500 && found.iter().all(|&area| area > 1e-4), "{}", found.len());
}
