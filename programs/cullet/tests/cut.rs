//! `cullet cut`, and reports that open the scene, run as programs.

use std::process::{Command, Output};

use cullet_io::LoadOptions;
use cullet_maps::load;
use cullet_testkit::Folder;

fn cullet(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", "/nonexistent/costs.json").output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

/// A box with a texture coordinate at each corner of each side, and colours.
const BOX: &str = "v 0 0 0 1 0 0\nv 2 0 0 1 0 0\nv 2 2 0 0 1 0\nv 0 2 0 0 1 0\nv 0 0 2 1 0 0\nv 2 0 2 1 0 0\n\
                   v 2 2 2 0 1 0\nv 0 2 2 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                   f 1/1 4/2 3/3 2/4\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/3 5/4\nf 3/1 4/2 8/3 7/4\n\
                   f 1/1 5/2 8/3 4/4\nf 2/1 3/2 7/3 6/4\n";

#[test]
fn texture_coordinates_and_colours_go_through_a_cut() {
    let folder = Folder::new("attributes");
    let source = folder.root().join("box.obj");
    std::fs::write(&source, BOX).unwrap();
    for name in ["half.glb", "half.ply", "half.obj"] {
        let out = folder.root().join(name);
        let args = ["cut", source.to_str().unwrap(), "--plane", "0,1,0,0.5", "--cap", "-o"];
        let output = cullet(&[&args[..], &[out.to_str().unwrap()]].concat());
        assert!(output.status.success(), "{}", told(&output));
        let model = load(&out, &LoadOptions { details: true, ..LoadOptions::default() }).unwrap();
        let (mesh, kept) = (&model.scene.meshes()[0], &model.attributes[0]);
        assert_eq!(kept.uvs.len(), mesh.positions().len(), "{name}");
        assert_eq!(cullet_mesh::solid(mesh), Ok(()), "{name}");
        // A quarter of the way from red to green; the cap is white.
        let cut = (0..mesh.positions().len()).filter(|&v| mesh.positions()[v][1] == 0.5);
        let (mut walls, mut caps) = (0, 0);
        for v in cut {
            match kept.colors[v] {
                [r, g, b, _] if (r - 0.75).abs() < 0.01 && (g - 0.25).abs() < 0.01 && b == 0.0 => {
                    walls += 1;
                }
                [1.0, 1.0, 1.0, _] => caps += 1,
                other => panic!("{name}: vertex {v} has the colour {other:?}"),
            }
        }
        assert!(walls >= 8 && caps >= 4, "{name}: {walls} of walls, {caps} of caps");
    }
}

#[test]
fn a_report_shows_the_scene_opened() {
    let folder = Folder::new("report");
    let out = folder.root().to_str().unwrap();
    let view = ["--views", "1", "--samples", "1", "--size", "96x64", "--out", out];
    let scene = ["report", "solids:n=20", "--cut", "0,0,1,0", "--cut-keep", "outside"];
    let output = cullet(&[&scene[..], &view].concat());
    assert!(output.status.success(), "{}", told(&output));
    assert!(folder.root().join("view-000-opened.png").exists());
    let page = std::fs::read_to_string(folder.root().join("index.html")).unwrap();
    assert!(page.contains("alt=\"Cut open at 0,0,1,0: what is outside is left."));
    for (cut, why) in
        [("0,0,1", "3 numbers"), ("0,0,0,1", "no direction"), ("1,0,0,0,1,1", "low x")]
    {
        let output = cullet(&[&["report", "solids:n=20", "--cut", cut][..], &view].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(told(&output).contains(why), "{}", told(&output));
    }
}
