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
