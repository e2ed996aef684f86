//! `cullet picture`: each kind is there, and what cannot be drawn is said.

use std::path::Path;

use cullet_testkit::Folder;

use crate::ran::{code, cullet, text};

#[test]
fn every_picture_is_a_png() {
    let folder = Folder::new("pictures");
    for kind in ["kinds", "shaded", "depth", "map"] {
        let out = folder.path(&format!("{kind}.png"));
        let args = [
            "picture",
            kind,
            "solids:n=20",
            "--views",
            "2",
            "--view",
            "1",
            "--size",
            "160x90",
            "--out",
            &out,
        ];
        assert_eq!(code(&args), 0, "{kind}");
        assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"), "{kind}");
    }
    assert_eq!(code(&["picture", "map", "solids:n=20", "--views", "2", "--view", "2"]), 2);
}

#[test]
fn every_teaching_picture_is_a_png() {
    let folder = Folder::new("teaching");
    let kinds = [
        "normal-mask",
        "normal-partition",
        "conservative-set",
        "culling-volume",
        "clusters",
        "cones",
        "back-regions",
    ];
    let help = |words: &[&str]| String::from_utf8(cullet(words).stdout).unwrap();
    // The list names them all; each has a line in the help of the program that draws it.
    let (list, lines) = (help(&["picture", "--help"]), help(&["picture", kinds[0], "--help"]));
    for kind in kinds {
        assert!(list.contains(kind), "{kind} is not in the list");
        let begin = format!("- {kind}:");
        assert!(lines.lines().any(|l| l.trim_start().starts_with(&begin)), "{kind} has no line");
        let out = folder.path(&format!("{kind}.png"));
        assert_eq!(code(&["picture", kind, "knobs:n=6", "--size", "160x90", "--out", &out]), 0);
        assert!(std::fs::read(&out).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"), "{kind}");
    }
}

#[test]
fn a_diagram_reads_no_scene() {
    let folder = Folder::new("diagrams");
    let out = folder.path("diagram.png");
    for kind in ["normal-mask", "normal-partition", "conservative-set"] {
        assert_eq!(code(&["picture", kind, "no-such-file.glb", "--out", &out]), 0, "{kind}");
    }
    let still = ["--eye", "1,2,3", "--target", "1,2,3"];
    assert_eq!(code(&[&["picture", "normal-mask", "--out", &out], &still[..]].concat()), 2);
    assert_eq!(code(&["picture", "clusters", "no-such-file.glb", "--out", &out]), 3);
}

#[test]
fn a_cluster_that_is_not_there_is_refused_with_the_limit() {
    let folder = Folder::new("no-cluster");
    let out = folder.path("volume.png");
    let run = |n: &str| {
        cullet(&["picture", "culling-volume", "knobs:n=6", "--cluster", n, "--out", &out])
    };
    let refused = run("100000");
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("--cluster 100000: the first mesh has "), "{message}");
    assert!(message.contains(" clusters, numbered from 0"), "{message}");
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_solid_without_a_culling_volume_is_not_called_two_sided() {
    let folder = Folder::new("cube");
    let cube = folder.path("cube.obj");
    let corners = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2));
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(&cube, corners.collect::<String>() + faces).unwrap();
    let out = folder.path("volume.png");
    let volume = |more: &[&str]| {
        cullet(&[&["picture", "culling-volume", &cube, "--out", &out], more].concat())
    };
    let solid = volume(&[]);
    assert_eq!(solid.status.code(), Some(3));
    assert!(
        text(&solid.stderr).contains("face all ways") && !text(&solid.stderr).contains("two-sided")
    );
    assert!(text(&volume(&["--two-sided"]).stderr).contains("--one-sided"));
}

#[test]
fn kinds_opens_a_scene_above_the_eye_where_it_is_covered() {
    let folder = Folder::new("kinds");
    let out = folder.path("kinds.png");
    let kinds = |scene: &str, eye: &str| {
        let target = "4,1.5,40";
        let still = ["--eye", eye, "--target", target, "--size", "320x200", "--out", &out];
        let done = cullet(&[&["picture", "kinds", scene], &still[..]].concat());
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        text(&done.stderr).contains("cut open at a height of")
    };
    assert!(kinds("office:roof=1,floors=1", "4,1.6,4"));
    assert!(!kinds("knobs:n=6", "0,1,5"));
}
