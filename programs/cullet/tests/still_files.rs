//! Files that hold figures, run as programs: every command shows them as they are stored.

use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::Folder;

fn cullet(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", "/nonexistent/costs.json").output().unwrap()
}

#[track_caller]
fn fine(args: &[&str]) -> String {
    let output = cullet(args);
    let told = [&output.stdout[..], &output.stderr].concat();
    let told = String::from_utf8_lossy(&told).replace('\u{202f}', " ");
    assert_eq!(output.status.code(), Some(0), "{args:?}: {told}");
    told
}

fn report(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/cullet-io/tests/reports");
    folder.join(name).to_str().unwrap().to_owned()
}

/// A figure that its joints place: its node says 999 and 50 times as large.
const FIGURE: &str = "skin-mixamo-001.glb";

const SMALL: [&str; 4] = ["--views", "2", "--size", "96x64"];

#[test]
fn every_command_shows_a_figure_where_its_joints_place_it() {
    let (folder, figure) = (Folder::new("figure"), report(FIGURE));
    let path = |name: &str| folder.root().join(name).to_str().unwrap().to_owned();
    let size = "1.000 × 6.000 × 1.000";
    assert!(fine(&["info", &figure]).contains(size));
    let page = path("page");
    fine(&[&["report", &figure, "--out", &page][..], &SMALL].concat());
    fine(&[&["verify", &figure][..], &SMALL].concat());
    fine(&[&["picture", "map", &figure, "--out", &path("a.png")][..], &SMALL].concat());
    fine(&[&["explain", &figure, "--pixel", "48,32"][..], &SMALL].concat());
    fine(&[&["check-occlusion", &figure][..], &SMALL].concat());
    fine(&[
        "film",
        &figure,
        "--of",
        "freeze",
        "--out",
        &path("a.webp"),
        "--size",
        "640x360",
        "--frames",
        "2",
    ]);
    fine(&[&["bench", "culler", &figure, "--seconds", "0.01"][..], &SMALL].concat());
    fine(&["occscn", &figure, "--views", "1", "-o", &path("a.occscn")]);
    let written = [
        (&["cut", "--plane", "1,0,0,0.5", "--cap", "-o"][..], "cut.glb", "0.500 × 3.500 × 1.000"),
        (&["simplify", "--error", "1e-6", "-o"], "simple.glb", size),
        (&["bake", "-o"], "baked.glb", size),
    ];
    for (command, name, size) in written {
        let out = path(name);
        fine(&[&command[..1], &[&figure], &command[1..], &[&out]].concat());
        let told = fine(&["info", &out]);
        assert!(told.contains(size), "{name}: {told}");
    }
}

#[test]
fn a_folder_of_moving_and_still_files_is_read_at_a_time() {
    let folder = Folder::new("moving");
    let inputs = folder.root().join("in");
    std::fs::create_dir(&inputs).unwrap();
    for name in [FIGURE, "skin-and-cube.glb", "anim-pointer.glb", "glb-json-unaligned.glb"] {
        std::fs::copy(report(name), inputs.join(name)).unwrap();
    }
    let page = folder.root().join("page");
    let args = ["report", inputs.to_str().unwrap(), "--out", page.to_str().unwrap()];
    for time in [&[][..], &["--time", "0"], &["--time", "0..1"]] {
        fine(&[&args[..], &SMALL, time].concat());
    }
    let told =
        fine(&[&["verify", &report("glb-json-unaligned.glb"), "--time", "0"][..], &SMALL].concat());
    assert!(told.contains("nothing in it moves"), "{told}");
    // What pointers move, moves.
    let told =
        fine(&[&["verify", &report("anim-pointer.glb"), "--time", "0.5"][..], &SMALL].concat());
    assert!(!told.contains("nothing in it moves"), "{told}");
}

#[test]
fn nothing_is_said_to_stand_still_while_an_extension_that_may_move_it_is_not_read() {
    let folder = Folder::new("unread");
    let path = folder.root().join("a.gltf");
    let bytes = std::fs::read(report("glb-json-unaligned.glb")).unwrap();
    let end = 20 + u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let mut json: serde_json::Value = serde_json::from_slice(&bytes[20..end]).unwrap();
    std::fs::write(folder.root().join("a.bin"), &bytes[end + 8..]).unwrap();
    json["buffers"][0]["uri"] = "a.bin".into();
    json["extensionsUsed"] = serde_json::json!(["KHR_interactivity"]);
    std::fs::write(&path, json.to_string()).unwrap();
    let path = path.to_str().unwrap();
    let told = fine(&[&["verify", path, "--time", "0.5"][..], &SMALL].concat());
    assert!(told.contains("KHR_interactivity may move what is in it"), "{told}");
    assert!(!told.contains("nothing in it moves"), "{told}");
    let told = fine(&["info", path]);
    assert!(told.contains("not read: KHR_interactivity, behaviour"), "{told}");
}

#[test]
fn sizes_are_of_vertices_and_all_commands_agree_on_what_has_none() {
    let told = fine(&["info", &report("sphere-rot45.glb")]);
    assert!(told.contains("2.000 × 2.000 × 2.000"), "{told}");
    let huge = report("scale-1e30.glb");
    let told = fine(&["info", &huge]);
    assert!(told.contains("without finite bounds within ±1e18"), "{told}");
    assert!(!told.contains("size"), "{told}");
    let folder = Folder::new("large");
    let large = folder.root().join("large.glb");
    let mut bytes = std::fs::read(&huge).unwrap();
    let text = bytes.windows(19).position(|at| at == b"1e+30, 1e+30, 1e+30").unwrap();
    bytes[text..text + 19].copy_from_slice(b"1e+17, 1e+17, 1e+17");
    std::fs::write(&large, bytes).unwrap();
    fine(&[&["verify", large.to_str().unwrap()][..], &SMALL].concat());
    let output = cullet(&["verify", &huge]);
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("no instance with finite bounds within ±1e18"), "{told}");
}
