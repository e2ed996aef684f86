//! Pictures of cells and portals on the command line.

use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::Folder;

fn picture(args: &[&str], out: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet"))
        .arg("picture")
        .args(args)
        .args(["--size", "320x200", "--out", out])
        .output()
        .unwrap()
}

fn is_written(done: &Output, out: &str) {
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(std::fs::read(out).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"), "{out}");
    std::fs::remove_file(out).unwrap();
}

#[test]
fn cells_portals_and_the_matrix_of_an_office_are_drawn() {
    let folder = Folder::new("seen");
    let out = folder.path("p.png");
    for kind in ["portals", "cells", "pvs-matrix"] {
        is_written(&picture(&[kind, "office", "--path", "walk", "--views", "2"], &out), &out);
    }
    // Without the stage there is nothing to show of the walk, and it is said.
    let done = picture(&["portals", "office", "--path", "walk", "--no-portal"], &out);
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    is_written(&done, &out);
    assert!(said.contains("portals hide nothing in this view"), "{said}");
}

#[test]
fn a_matrix_is_drawn_of_a_graph_and_of_its_baked_sets() {
    let folder = Folder::new("seen-graph");
    let (prt, sets, out) = (folder.path("row.prt"), folder.path("row.cpvs"), folder.path("p.png"));
    // Three rooms in a row, the last door out of line.
    let door = |x: i32, z: i32| {
        format!("({x} 0 {z} ) ({x} 10 {z} ) ({} 10 {z} ) ({} 0 {z} )", x + 10, x + 10)
    };
    let text = format!("PRT1\n3\n2\n4 0 1 {}\n4 1 2 {}\n", door(0, 0), door(40, 50));
    std::fs::write(&prt, text).unwrap();
    is_written(&picture(&["pvs-matrix", &prt], &out), &out);
    let mut bake = Command::new(env!("CARGO_BIN_EXE_cullet"));
    assert_eq!(bake.args(["pvs", &prt, "-o", &sets, "--quiet"]).status().unwrap().code(), Some(0));
    is_written(&picture(&["pvs-matrix", &sets], &out), &out);
    std::fs::write(&sets, b"CULLPVS1 and no more").unwrap();
    let done = picture(&["pvs-matrix", &sets], &out);
    assert_eq!(done.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&done.stderr).contains("row.cpvs"));
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_scene_without_cells_is_told_what_to_try() {
    let folder = Folder::new("seen-none");
    let out = folder.path("p.png");
    for kind in ["portals", "cells", "pvs-matrix"] {
        let done = picture(&[kind, "solids:n=3"], &out);
        assert_eq!(done.status.code(), Some(3), "{kind}");
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(said.contains("solids:n=3: the scene has no cells"), "{said}");
        assert!(!Path::new(&out).exists());
    }
}
