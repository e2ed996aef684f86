//! `cullet film`: clips that are the same each time, small, and readable by others.

use std::process::{Command, Output};

use cullet_testkit::Folder;

fn cullet(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).replace('\u{202f}', " ")
}

/// Few small frames.
const SMALL: &[&str] = &["--size", "640x360", "--frames", "5"];

fn film(scene: &str, of: &str, out: &str) -> Vec<u8> {
    let told = cullet(&[&["film", scene, "--of", of, "--out", out], SMALL].concat());
    assert_eq!(told.status.code(), Some(0), "{}", text(&told.stderr));
    assert!(text(&told.stdout).contains("5 frames of 640x360"), "{}", text(&told.stdout));
    std::fs::read(out).unwrap()
}

/// The chunks of a RIFF file: their names and contents.
fn chunks(mut bytes: &[u8]) -> Vec<(String, &[u8])> {
    let mut all = Vec::new();
    while let Some((head, rest)) = bytes.split_first_chunk::<8>() {
        let [a, b, c, d, size @ ..] = *head;
        let size = u32::from_le_bytes(size) as usize;
        all.push((text(&[a, b, c, d]), &rest[..size]));
        bytes = &rest[size.next_multiple_of(2)..];
    }
    all
}

#[test]
fn each_subject_is_the_same_film_each_time() {
    let folder = Folder::new("film");
    let city = "city:cells=8,objects=60";
    for (scene, of) in [(city, "freeze"), ("knobs", "volume"), ("office", "portal")] {
        let bytes = film(scene, of, &folder.path("a.webp"));
        assert!(bytes == film(scene, of, &folder.path("b.webp")), "{of}");
        let riff = chunks(&bytes);
        assert!(riff.len() == 1 && riff[0].0 == "RIFF");
        let inner = chunks(riff[0].1.strip_prefix(b"WEBP").unwrap());
        let frames: Vec<_> = inner.iter().filter(|c| c.0 == "ANMF").map(|c| c.1).collect();
        assert_eq!(frames.len(), 5, "{of}");
        // Something happens in it.
        assert!(frames.windows(2).any(|w| w[0] != w[1]), "{of}");
        assert!(bytes.len() < 300_000, "{of}: {}", bytes.len());
    }
}

#[test]
fn a_folder_gets_frames_and_a_png_is_animated() {
    let folder = Folder::new("frames");
    let out = folder.path("frames");
    let told = cullet(&[&["film", "knobs", "--of", "volume", "--out", &out], SMALL].concat());
    assert_eq!(told.status.code(), Some(0), "{}", text(&told.stderr));
    let mut names: Vec<String> = (std::fs::read_dir(&out).unwrap())
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["0000.png", "0001.png", "0002.png", "0003.png", "0004.png", "film.webp"]);
    let png = film("knobs", "volume", &folder.path("film.png"));
    assert!(png.starts_with(b"\x89PNG"));
    let has = |name: &[u8]| png.windows(4).any(|w| w == name);
    assert!(has(b"acTL") && has(b"fcTL") && has(b"fdAT") && has(b"PLTE"));
}

#[test]
fn what_is_no_film_says_what_would_be() {
    let folder = Folder::new("nofilm");
    let wrong = |args: &[&str], code: i32, words: &str| {
        let out = cullet(&[&["film"], args, SMALL].concat());
        let said = text(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.contains(words), "{args:?}: {said}");
    };
    let gif = folder.path("film.gif");
    wrong(&["knobs", "--of", "volume", "--out", &gif], 2, ".webp or .png");
    wrong(&["knobs", "--of", "dolly"], 2, "--lod");
    wrong(&["knobs", "--of", "portal"], 3, "--cells auto");
    wrong(&["knobs", "--of", "volume", "--cluster", "99999"], 2, "--cluster 99999");
    wrong(&["knobs", "--of", "nothing"], 2, "freeze");
    // Closed, of one cluster, which faces all ways.
    let small = folder.file(
        "small.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    );
    wrong(&[&small, "--of", "volume"], 3, "knobs");
}
