//! The house in order: no circle of files in any crate, and no arrow that runs upward between
//! crates and between the rooms of the engine. `rooms/known.txt` lists what still breaks this; a
//! line that no longer does must go. No file of tests is left out.

mod imports;
mod openings;
mod tests_listed;
mod unused;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::runner::{Ended, all};
use crate::tools::root;
use imports::Files;

/// The crates, from the ground up. One may depend on those of lower floors.
const CRATES: &[&[&str]] = &[
    &["cullet"],
    &["cullet-cells"],
    &["cullet-testkit"],
    &["cullet-mesh"],
    &["cullet-draw", "cullet-gpu", "cullet-io"],
    &["cullet-cut", "cullet-scenes"],
    &["cullet-maps"],
    &["cullet-bake", "cullet-command", "cullet-tiles"],
    &["cullet-cli"],
    &["cullet-baker", "cullet-profile"],
    &["cullet-lab"],
    &["cullet-viewer"],
];

/// The rooms of the engine, from the ground up. One may name those of lower floors, and of its own
/// where no circle comes of it.
const ROOMS: &[&[&str]] = &[
    &["bits", "exact", "simd"],
    &["bounds", "transform"],
    &["view"],
    &["hierarchy", "mesh"],
    &["costs", "cull", "lod", "prepared"],
    &["funnel", "scene", "visible"],
    &["culler"],
];

/// The kinds of culling, which do not know each other.
const KINDS: &[&str] =
    &["backface", "degenerate", "detail", "frustum", "horizon", "occlusion", "shadow"];

/// Crates in which not even a module and those that it lies in name each other.
const STRICT: &[&str] = &["cullet-cli", "cullet-command", "cullet-cut"];

const KNOWN: &str = include_str!("rooms/known.txt");

/// The step: every line of what breaks the order is one of those that are known, and the other way
/// round.
pub(crate) fn check() -> Ended {
    tests_listed::check()?;
    openings::check()?;
    unused::check()?;
    let found = faults()?;
    let is_line = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let known: BTreeSet<&str> = KNOWN.lines().map(str::trim).filter(is_line).collect();
    let new: Vec<&str> = found.iter().map(String::as_str).filter(|f| !known.contains(f)).collect();
    let gone: Vec<&str> = known.iter().copied().filter(|k| !found.contains(*k)).collect();
    println!("{} known to break the order of the house", known.len());
    new.iter().for_each(|line| println!("new: {line}"));
    gone.iter().for_each(|line| println!("mended: {line}"));
    all(match (new.len(), gone.len()) {
        (0, 0) => Ok(()),
        (0, n) => Err(format!("{n} mended; take the lines from xtask/src/rooms/known.txt")),
        (n, _) => Err(format!("{n} new: circles of files, or arrows that run upward")),
    })
}

/// A line for each file that is in a circle, and for each arrow that runs upward.
fn faults() -> Result<BTreeSet<String>, String> {
    let mut faults = BTreeSet::new();
    let crates = [members("crates")?, members("programs")?].concat();
    for (name, folder) in &crates {
        faults.extend(upward_crates(name, &crates, folder)?);
    }
    // Bindings stand beside each other above all crates, and this program beside them; in them
    // there is no more to hold than that files form no circle.
    let others = [members("bindings")?, vec![("xtask".to_owned(), root().join("xtask"))]].concat();
    for (name, folder) in crates.into_iter().chain(others) {
        let src = folder.join("src");
        let short = |p: &Path| p.strip_prefix(&src).unwrap_or(p).to_string_lossy().into_owned();
        let arrows = Files::read(&src)?.arrows(STRICT.contains(&name.as_str()));
        let arrows: BTreeSet<(String, String)> =
            arrows.iter().map(|(a, b)| (short(a), short(b))).collect();
        faults.extend(circles(&arrows).into_iter().map(|file| format!("circle {name}/{file}")));
        if name == "cullet" {
            let up = arrows.iter().filter(|(a, b)| is_upward(a, b));
            faults.extend(up.map(|(a, b)| format!("up {name}/{a} -> {b}")));
        }
    }
    Ok(faults)
}

/// The packages in a folder: their names, and where they lie.
fn members(folder: &str) -> Result<Vec<(String, PathBuf)>, String> {
    let path = root().join(folder);
    let folders = std::fs::read_dir(&path).map_err(|e| format!("{folder}: {e}"))?;
    let package = |folder: PathBuf| {
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).ok()?;
        let name = manifest.lines().find_map(|line| line.strip_prefix("name = "))?;
        Some((name.trim_matches('"').to_owned(), folder))
    };
    let mut found: Vec<_> = folders.filter_map(|f| package(f.ok()?.path())).collect();
    found.sort();
    Ok(found)
}

/// Dependencies of a crate that do not stand below it; those of its tests alone do not count.
fn upward_crates(
    name: &str,
    crates: &[(String, PathBuf)],
    folder: &Path,
) -> Result<Vec<String>, String> {
    let floor = |name: &str| {
        let at = CRATES.iter().position(|floor| floor.contains(&name));
        at.ok_or_else(|| format!("{name}: say in xtask/src/rooms.rs on which floor it stands"))
    };
    let path = folder.join("Cargo.toml");
    let manifest =
        std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut up = Vec::new();
    let mut counts = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            counts = line.ends_with("dependencies]") && !line.contains("dev-dependencies");
        }
        let other = line.split(['.', ' ', '=']).next().unwrap_or_default();
        if counts && crates.iter().any(|(n, _)| n == other) && floor(other)? >= floor(name)? {
            up.push(format!("up {name} -> {other}"));
        }
    }
    Ok(up)
}

/// Whether a file of the engine names one that does not stand below it.
fn is_upward(from: &str, to: &str) -> bool {
    let room = |file: &str| file.split(['/', '.']).next().unwrap_or_default().to_owned();
    let floor = |file: &str| ROOMS.iter().position(|f| f.contains(&room(file).as_str()));
    let kind = |file: &str| {
        let kind = file.strip_prefix("cull/")?.split(['/', '.']).next()?;
        KINDS.contains(&kind).then(|| kind.to_owned())
    };
    match (floor(from), floor(to)) {
        (Some(from), Some(to)) if from < to => true,
        _ => kind(from).zip(kind(to)).is_some_and(|(from, to)| from != to),
    }
}

/// The files from which arrows lead back to themselves.
fn circles(arrows: &BTreeSet<(String, String)>) -> BTreeSet<String> {
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    arrows.iter().for_each(|(a, b)| next.entry(a).or_default().push(b));
    let reaches_itself = |start: &&str| {
        let (mut seen, mut queue) = (BTreeSet::new(), vec![*start]);
        while let Some(at) = queue.pop() {
            for &to in next.get(at).into_iter().flatten() {
                if to == *start {
                    return true;
                }
                if seen.insert(to) {
                    queue.push(to);
                }
            }
        }
        false
    };
    next.keys().copied().filter(reaches_itself).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_leads_back_to_himself_is_in_a_circle_and_who_leads_to_one_is_not() {
        let arrow = |(a, b): (&str, &str)| (a.to_owned(), b.to_owned());
        let arrows = [("a", "b"), ("b", "c"), ("c", "b"), ("c", "d"), ("d", "e")].map(arrow);
        let found = circles(&arrows.into());
        assert_eq!(found.into_iter().collect::<Vec<_>>(), ["b", "c"]);
    }

    #[test]
    fn rooms_know_what_stands_below_them_and_kinds_of_culling_not_each_other() {
        for (from, to) in [
            ("view/mod.rs", "mesh/mod.rs"),
            ("mesh/mod.rs", "cull/backface/mod.rs"),
            ("cull/shadow/body.rs", "cull/occlusion/query/batch.rs"),
            ("cull/detail.rs", "scene/mod.rs"),
        ] {
            assert!(is_upward(from, to), "{from} {to}");
        }
        for (from, to) in [
            ("culler/mod.rs", "cull/detail.rs"),
            ("clip/line.rs", "mesh/mod.rs"),
            ("cull/occlusion/query/batch.rs", "cull/occlusion/raster/tile.rs"),
            ("cull/detail.rs", "cull/output.rs"),
        ] {
            assert!(!is_upward(from, to), "{from} {to}");
        }
    }
}
