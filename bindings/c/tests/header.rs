//! The header in the tree is the one that the source makes.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_source() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("settings");
    config.header = Some(include_str!("../include/opening.h").trim_end().to_owned());
    let bindings = cbindgen::Builder::new()
        .with_crate(folder)
        .with_config(config)
        .generate()
        .expect("a header of the source");
    let mut fresh = Vec::new();
    bindings.write(&mut fresh);
    let fresh = String::from_utf8(fresh).expect("a text");
    let kept = folder.join("include/cullet.h");
    if std::env::var_os("CULLET_WRITE").is_some_and(|v| v == "1") {
        std::fs::write(&kept, &fresh).expect("the header is written");
    }
    let kept = std::fs::read_to_string(&kept).unwrap_or_default();
    let other = kept.lines().zip(fresh.lines()).position(|(a, b)| a != b);
    assert!(
        kept == fresh,
        "include/cullet.h differs from the source in line {:?}: CULLET_WRITE=1 cargo test -p cullet-c --test header",
        other.map(|line| line + 1)
    );
}

/// Returns the functions that a header declares.
fn declared(header: &str) -> Vec<&str> {
    let is_declaration = |line: &&str| line.starts_with(|c: char| c.is_ascii_lowercase());
    let name = |line| {
        let (before, _) = str::split_once(line, '(')?;
        let name = before.rsplit([' ', '*']).next()?;
        name.starts_with("cullet_").then_some(name)
    };
    header.lines().filter(is_declaration).filter_map(name).collect()
}

#[test]
fn every_function_of_the_header_is_called_at_random() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/random");
    let mut calls = String::new();
    for entry in std::fs::read_dir(folder).expect("tests/random") {
        calls += &std::fs::read_to_string(entry.expect("a file").path()).expect("a text");
    }
    let functions = declared(include_str!("../include/cullet.h"));
    assert!(functions.len() > 60, "{} functions in include/cullet.h", functions.len());
    let is_called = |name: &str| {
        let listed = format!("CALL({})", name.trim_start_matches("cullet_"));
        calls.contains(&format!("{name}(")) && calls.contains(&listed)
    };
    let missing = |name: &&&str| !is_called(name);
    let missing: Vec<_> = functions.iter().filter(missing).collect();
    assert!(
        missing.is_empty(),
        "tests/random calls none of these: give each a function and a CALL(...) there: {missing:#?}"
    );
    for name in ["cullet_boxes_create", "cullet_version", "cullet_view_look_at"] {
        assert!(functions.contains(&name), "{name}");
    }
}
