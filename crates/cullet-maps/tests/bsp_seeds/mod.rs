//! Small maps that are made.

use std::path::Path;

/// The small maps that fuzzing begins with: a room in two leafs, with a fence, water, a brush model, a start and a lamp.
pub(crate) fn small() -> Vec<(&'static str, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/bsp");
    let names = ["quake", "one-cell", "unbaked", "bsp2", "halflife", "quake2", "quake3"];
    names.map(|name| (name, std::fs::read(folder.join(name)).unwrap())).to_vec()
}

/// One of them.
pub(crate) fn of(name: &str) -> Vec<u8> {
    small().into_iter().find(|(n, _)| *n == name).unwrap().1
}
