//! `cullet fetch`, without a network: from files, and by a program that stands in for curl.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use cullet_testkit::{Folder, data};
use flate2::Compression;
use flate2::write::GzEncoder;

/// The triangles of the bunny and of Spot.
const BUNNY: usize = 69_451;
const SPOT: usize = 5_856;

fn cullet(args: &[&str]) -> Output {
    with_path("/nonexistent", args)
}

fn with_path(path: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.arg("fetch").args(args).env("PATH", path).output().unwrap()
}

fn said(out: &Output) -> String {
    let all = [&out.stdout[..], &out.stderr].concat();
    String::from_utf8_lossy(&all).replace('\u{202f}', " ")
}

/// Runs a command, asserts its exit code, and returns its output.
fn ends(code: i32, args: &[&str]) -> String {
    let out = cullet(args);
    assert_eq!(out.status.code(), Some(code), "{args:?}: {}", said(&out));
    said(&out)
}

/// A strip of so many triangles.
fn ply(triangles: usize) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n",
        triangles + 2
    );
    for i in 0..triangles + 2 {
        writeln!(text, "{i} {} 0", i % 2).unwrap();
    }
    for i in 0..triangles {
        writeln!(text, "3 {i} {} {}", i + 1, i + 2).unwrap();
    }
    text.into_bytes()
}

fn obj(triangles: usize) -> Vec<u8> {
    let mut text = String::new();
    for i in 0..triangles + 2 {
        writeln!(text, "v {i} {} 0", i % 2).unwrap();
    }
    for i in 1..=triangles {
        writeln!(text, "f {i} {} {}", i + 1, i + 2).unwrap();
    }
    text.into_bytes()
}

/// A tar of files, each with the size that its header claims.
fn tar(files: &[(&str, usize, &[u8])]) -> Vec<u8> {
    let mut tar = Vec::new();
    for &(name, size, bytes) in files {
        let mut header = [0; 512];
        header[..name.len()].copy_from_slice(name.as_bytes());
        header[124..135].copy_from_slice(format!("{size:011o}").as_bytes());
        header[148..156].fill(b' ');
        let sum: u64 = header.iter().map(|&b| u64::from(b)).sum();
        header[148..154].copy_from_slice(format!("{sum:06o}").as_bytes());
        header[154] = 0;
        tar.extend_from_slice(&header);
        tar.extend_from_slice(bytes);
        tar.resize(tar.len().next_multiple_of(512), 0);
    }
    tar.extend_from_slice(&[0; 1024]);
    tar
}

fn bunny(triangles: usize) -> Vec<u8> {
    let (notes, model) = (b"notes", ply(triangles));
    tar(&[
        ("bunny/README", notes.len(), notes),
        ("bunny/reconstruction/bun_zipper.ply", model.len(), &model),
    ])
}

fn gz(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn put(folder: &Folder, name: &str, bytes: &[u8]) -> String {
    std::fs::write(folder.root().join(name), bytes).unwrap();
    folder.path(name)
}

/// The names in a folder; none where there is no folder.
fn names(folder: &str) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn without_a_name_all_are_listed_with_their_terms() {
    let text = ends(0, &[]);
    for word in ["bunny", "69 451 triangles", "armadillo", "345 944", "teapot", "dragon", "buddha"]
    {
        assert!(text.contains(word), "{word} is not in {text}");
    }
    assert!(text.matches("  terms: ").count() == text.matches("  from https://").count());
    let text = ends(2, &["buny"]);
    assert!(text.contains("did you mean 'bunny'?") && text.contains("armadillo"), "{text}");
}

#[test]
fn terms_that_bind_are_shown_and_must_be_accepted() {
    let folder = Folder::new("fetch-terms");
    let out = folder.path("models");
    let text = ends(2, &["bunny", "--out", &out]);
    assert!(text.contains("Stanford 3D Scanning Repository"), "{text}");
    assert!(text.contains("Commercial use") && text.contains("add --accept"), "{text}");
    assert!(!Path::new(&out).exists(), "nothing is made before");
}

#[test]
fn the_model_is_taken_out_of_its_archive() {
    let folder = Folder::new("fetch-archive");
    let out = folder.path("models");
    let from = put(&folder, "mirror.tar.gz", &gz(&bunny(BUNNY)));
    let args = ["bunny", "--accept", "--out", &out, "--from", &from];
    let text = ends(0, &args);
    let kept = Path::new(&out).join("bunny.ply");
    let shown = kept.display().to_string();
    assert!(text.contains(&format!("{shown} written: 69 451 triangles")), "{text}");
    assert!(text.ends_with(&format!("try: cullet report {shown}\n")), "{text}");
    assert_eq!(names(&out), ["bunny.ply", "bunny.terms.txt"]);
    assert_eq!(std::fs::read(&kept).unwrap(), ply(BUNNY));
    let terms = std::fs::read_to_string(Path::new(&out).join("bunny.terms.txt")).unwrap();
    assert!(terms.contains("Stanford") && terms.contains("3Dscanrep"), "{terms}");
    // What is there is not fetched again, nor asked for.
    let text = ends(0, &["bunny", "--out", &out]);
    assert!(text.contains("is there already: 69 451 triangles"), "{text}");
    std::fs::write(&kept, ply(2)).unwrap();
    let text = ends(3, &["bunny", "--out", &out]);
    assert!(text.contains("2 triangles") && text.contains("Remove it"), "{text}");
}

#[test]
fn plain_and_packed_files_serve_as_well() {
    let folder = Folder::new("fetch-plain");
    let forms = [("plain", obj(SPOT)), ("packed", gz(&obj(SPOT)))];
    for (form, bytes) in forms {
        let (from, out) = (put(&folder, form, &bytes), folder.path(&format!("{form}-out")));
        // No terms bind here.
        let text = ends(0, &["spot", "--out", &out, "--from", &from]);
        assert!(text.contains("CC0") && text.contains("5 856 triangles"), "{text}");
        assert_eq!(std::fs::read(Path::new(&out).join("spot.obj")).unwrap(), obj(SPOT));
    }
    let unpacked = put(&folder, "unpacked.tar", &bunny(BUNNY));
    let out = folder.path("tar-out");
    let _ = ends(0, &["bunny", "--accept", "--out", &out, "--from", &unpacked]);
}

#[test]
fn what_is_not_the_model_is_not_kept() {
    let folder = Folder::new("fetch-wrong");
    let out = folder.path("models");
    let wrong = |code: i32, bytes: &[u8], words: &[&str]| {
        let from = put(&folder, "wrong", bytes);
        let text = ends(code, &["bunny", "--accept", "--out", &out, "--from", &from]);
        for word in words {
            assert!(text.contains(word), "{word} is not in {text}");
        }
        assert!(text.contains(&from), "{text}");
        assert_eq!(names(&out), [""; 0], "{text}");
    };
    wrong(3, &gz(&bunny(7)), &["7 triangles", "69 451"]);
    wrong(3, &bunny(7), &["7 triangles", "69 451"]);
    let whole = gz(&bunny(BUNNY));
    wrong(3, &whole[..whole.len() / 2], &["broken or not all of it"]);
    let whole = bunny(BUNNY);
    wrong(3, &whole[..whole.len() / 2], &["of the", "bun_zipper.ply"]);
    wrong(3, &whole[..700], &["broken or not all of it", "did not come"]);
    wrong(
        3,
        &tar(&[("bunny/README", 5, b"notes")]),
        &["there is no bunny/", "it has bunny/README"],
    );
    // A size that no such file has is refused before a byte of it is looked for.
    let claim = tar(&[("bunny/reconstruction/bun_zipper.ply", 0o77_777_777_777, b"ply")]);
    wrong(4, &claim, &["bytes or more"]);
    wrong(3, b"PK\x03\x04....", &["a zip"]);
    wrong(3, b"<html>moved</html>", &["cannot be read as bunny"]);
    wrong(3, b"", &["cannot be read as bunny"]);
    let missing = folder.path("nowhere.tar.gz");
    let text = ends(3, &["bunny", "--accept", "--out", &out, "--from", &missing]);
    assert!(text.contains(&missing) && text.contains("cannot be read"), "{text}");
    let text = ends(3, &["bunny", "--accept", "--out", &out, "--from", &out]);
    assert!(text.contains("not a regular file"), "{text}");
}

#[test]
fn without_curl_it_says_what_else_there_is() {
    let folder = Folder::new("fetch-missing");
    let text = ends(3, &["armadillo", "--accept", "--out", &folder.path("models")]);
    assert!(text.contains("'curl'") && text.contains("--from"), "{text}");
    assert!(text.contains("https://graphics.stanford.edu/"), "{text}");
    assert_eq!(names(&folder.path("models")), [""; 0]);
}

/// A program in place of curl: notes its arguments, and does what the test says.
#[cfg(unix)]
fn in_place_of_curl(folder: &Folder, does: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let programs = folder.path("programs");
    std::fs::create_dir_all(&programs).unwrap();
    let path = Path::new(&programs).join("curl");
    let noted = folder.path("noted");
    let text = format!(
        "#!/bin/sh\nprintf '%s\\n' \"$@\" > '{noted}'\nwhile [ \"$1\" != --output ]; do shift; done\n{does}\n"
    );
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    format!("{programs}:/usr/bin:/bin")
}

#[cfg(unix)]
#[test]
fn curl_fetches_within_limits() {
    let folder = Folder::new("fetch-curl");
    let mirror = put(&folder, "spot.obj", &obj(SPOT));
    let path = in_place_of_curl(&folder, &format!("cp '{mirror}' \"$2\""));
    let out = folder.path("models");
    let got = with_path(&path, &["spot", "--out", &out]);
    assert_eq!(got.status.code(), Some(0), "{}", said(&got));
    assert_eq!(names(&out), ["spot.obj", "spot.terms.txt"]);
    let noted = std::fs::read_to_string(folder.path("noted")).unwrap();
    let noted: Vec<&str> = noted.lines().collect();
    let behind = |word: &str| noted.iter().skip_while(|w| **w != word).nth(1).copied();
    assert_eq!(behind("--max-filesize"), Some("4000000"));
    assert_eq!(behind("--proto-redir"), Some("=http,https"));
    assert!(behind("--url").is_some_and(|url| url.ends_with("/data/spot.obj")), "{noted:?}");
    // An address in place of its own.
    let other = folder.path("others");
    let mirror = "https://localhost/mirror/spot.obj";
    let got = with_path(&path, &["spot", "--out", &other, "--from", mirror]);
    assert_eq!(got.status.code(), Some(0), "{}", said(&got));
    let noted = std::fs::read_to_string(folder.path("noted")).unwrap();
    assert!(noted.ends_with(&format!("--url\n{mirror}\n")), "{noted}");
}

#[cfg(unix)]
#[test]
fn what_curl_could_not_get_is_told() {
    let folder = Folder::new("fetch-curl-fails");
    let out = folder.path("models");
    let large = "head -c 5000000 /dev/zero > \"$2\"";
    for (does, code, words) in [
        ("exit 22", 3, &["exit code 22", "--from"][..]),
        ("echo half > \"$2\"; exit 63", 4, &["larger than 4000000 bytes"]),
        // One that does not know the limit, or was not told the size.
        (large, 4, &["larger than 4000000 bytes"]),
        ("exit 0", 3, &["cannot be read"]),
    ] {
        let path = in_place_of_curl(&folder, does);
        let got = with_path(&path, &["spot", "--out", &out]);
        assert_eq!(got.status.code(), Some(code), "{does}: {}", said(&got));
        for word in words {
            assert!(said(&got).contains(word), "{does}: {}", said(&got));
        }
        assert_eq!(names(&out), [""; 0], "{does}");
    }
}

#[test]
fn real_models_have_the_triangles_of_the_table() {
    let folder = Folder::new("fetch-real");
    let out = folder.path("models");
    for (name, file) in [
        ("bunny", "stanford-bunny/bun_zipper.ply"),
        ("teapot", "classic-meshes/teapot.obj"),
        ("spot", "classic-meshes/spot.obj"),
    ] {
        let Some(file) = data(file) else { continue };
        let from = file.display().to_string();
        let text = ends(0, &[name, "--accept", "--out", &out, "--from", &from]);
        assert!(text.contains("written"), "{text}");
    }
}
