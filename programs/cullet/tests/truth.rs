//! The project's conscience: every built-in scene and every model of the test data is drawn with
//! and without culling, nothing visible may be lost, and culling must stay as good as it was
//! recorded.

use std::process::Command;

use cullet_testkit::{cases, data};
use serde_json::Value;

/// Verifies a scene in four small views and returns its summary.
fn verify(scene: &str, path: &str, more: &[&str]) -> Value {
    let out = Command::new(env!("CARGO_BIN_EXE_cullet"))
        .args(["verify", scene, "--path", path, "--views", "4", "--size", "480x270"])
        .args(["--json", "-", "--quiet", "--occlusion-budget", "100000"])
        .args(more)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{scene} on {path}: {error}");
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["summary"]["false_culls"], 0, "{scene} on {path}");
    json["summary"].clone()
}

/// Fails where more than `most` percent of all triangles are kept, or none is seen.
fn check(scene: &str, path: &str, most: f64) {
    let summary = verify(scene, path, &[]);
    let count = |what: &str| summary["triangles"][what].as_f64().unwrap();
    let kept = 100.0 * count("potentially_visible") / count("all");
    assert!(count("visible") > 0.0, "{scene} on {path} shows nothing");
    assert!(kept <= most, "{scene} on {path}: {kept:.1} % kept, recorded {most} %");
}

#[test]
fn built_in_scenes() {
    // Percent of all triangles that were kept when this was written, and 1 more.
    let scenes = [
        ("city:objects=5000,cells=40", [50.0, 22.0, 24.0]),
        ("solids", [51.0, 18.0, 21.0]),
        ("office", [53.0, 23.0, 18.0]),
        ("plant:bays=4,floors=2,kinds=6", [51.0, 8.0, 22.0]),
        ("forest:n=20000", [60.0, 22.0, 26.0]),
        // Deforming instances are culled whole or not at all, so an orbit leaves nearly all.
        ("moving", [97.0, 45.0, 44.0]),
        ("moving:t=1500", [97.0, 49.0, 44.0]),
        ("moving:t=5300", [97.0, 44.0, 44.0]),
    ];
    for (number, (scene, most)) in scenes.into_iter().enumerate() {
        let paths = ["orbit", "walk", "fly"].into_iter().zip(most);
        // A path each in turn; all of them where all cases are wanted.
        let paths = paths.cycle().skip(number).take(cases(4).min(3) as usize);
        for (path, most) in paths {
            check(scene, path, most);
        }
    }
}

/// Models, and the percent of triangles kept on an orbit: about half of what is one-sided; all of
/// what is two-sided, since an orbit leaves nothing outside of the frustum.
const MODELS: &[(&str, f64)] = &[
    ("cad-2cylinder/2CylinderEngine.glb", 46.0),
    ("cad-satellite/FM1_satellite.glb", 50.0),
    ("city-delft/delft.glb", 83.7),
    ("city-rotterdam/delfshaven.glb", 53.0),
    ("city-rotterdam/original-gltf/3-20-DELFSHAVEN.gltf", 49.0),
    ("duplex-bim/duplex-spaces.glb", 47.0),
    ("duplex-bim/duplex.glb", 46.0),
    ("intel-castle/intel-castle.glb", 52.0),
    ("room-godot/room.glb", 49.0),
    ("armadillo/armadillo.obj", 47.0),
    ("broken/truck-misoriented.obj", 100.0),
    ("classic-meshes/beetle.obj", 100.0),
    ("classic-meshes/cow.obj", 45.0),
    ("classic-meshes/fandisk.obj", 51.0),
    ("classic-meshes/rocker-arm.obj", 43.0),
    ("classic-meshes/spot.obj", 43.0),
    ("classic-meshes/suzanne.obj", 100.0),
    ("classic-meshes/teapot.obj", 100.0),
    ("classic-meshes/woody.obj", 100.0),
    ("happy-buddha/buddha-100k.obj", 100.0),
    ("crytek-sponza/crytek-sponza.ply", 100.0),
    ("stanford-bunny/bun_zipper.ply", 100.0),
    ("stanford-bunny/bun_zipper_res2.ply", 100.0),
    ("stanford-bunny/bun_zipper_res3.ply", 100.0),
    ("stanford-bunny/bun_zipper_res4.ply", 100.0),
    ("stanford-bunny/bunny-closed-7k.off", 42.0),
];

#[test]
fn models() {
    for (file, most) in MODELS {
        let Some(path) = data(file) else { continue };
        check(&path.to_string_lossy(), "orbit", *most);
    }
    // From inside, where most is behind the eye or out of sight.
    for (file, most) in [
        ("intel-castle/intel-castle.glb", 25.0),
        ("duplex-bim/duplex.glb", 18.0),
        ("crytek-sponza/crytek-sponza.ply", 6.5),
    ] {
        let Some(path) = data(file) else { continue };
        check(&path.to_string_lossy(), "fly", most);
    }
}

/// Fails where occlusion takes less than `least` percent of all triangles.
fn check_occlusion(scene: &str, path: &str, least: f64) {
    // Portals hide most of a house before occlusion has its turn.
    let summary = verify(scene, path, &["--no-portal"]);
    let all = summary["triangles"]["all"].as_f64().unwrap();
    let hidden = 100.0 * summary["removed"]["occlusion"].as_f64().unwrap_or(0.0) / all;
    assert!(hidden >= least, "{scene} on {path}: {hidden:.1} % hidden, recorded {least} %");
}

#[test]
fn portals_alone_lose_nothing_of_the_office() {
    for (spec, path) in [("office", "walk"), ("office:roof=1,floors=3,closed=60", "fly")] {
        let summary = verify(spec, path, &["--no-occlusion", "--no-backface"]);
        assert!(summary["removed"]["portal"].as_f64().unwrap() > 0.0, "{spec} on {path}");
    }
}

#[test]
fn occlusion_hides_as_much_as_it_did() {
    // Percent of all triangles that were hidden when this was written, and 1 less.
    for (scene, path, least) in [
        ("city:objects=5000,cells=40", "walk", 49.0),
        ("city:objects=5000,cells=40", "fly", 38.4),
        ("office", "walk", 42.3),
        ("plant:bays=4,floors=2,kinds=6", "fly", 35.8),
    ] {
        check_occlusion(scene, path, least);
    }
    for (file, least) in [
        ("duplex-bim/duplex.glb", 27.5),
        ("city-delft/delft.glb", 35.2),
        ("room-godot/room.glb", 20.5),
    ] {
        let Some(path) = data(file) else { continue };
        check_occlusion(&path.to_string_lossy(), "fly", least);
    }
}
