//! Items are whole, and each claim comes out as it is told.

use std::collections::BTreeSet;
use std::path::Path;

use cullet_lab::lecture::{Lab, Outcome, Text, items};

/// All rows that the texts have.
const COUNT: u8 = 101;

#[test]
fn each_number_is_there_once_in_order() {
    let numbers: Vec<u8> = items().map(|item| item.number).collect();
    let expected: Vec<u8> = (1..=COUNT).collect();
    assert_eq!(numbers, expected);
}

#[test]
fn each_item_says_all_that_it_has_to() {
    let mut titles = BTreeSet::new();
    for item in items() {
        let n = item.number;
        assert!(titles.insert(item.title), "item {n}: its title stands twice");
        for (what, text) in
            [("title", item.title), ("claim", item.claim), ("chapter", item.chapter)]
        {
            assert!(!text.is_empty(), "item {n} has no {what}");
        }
        assert!(item.claim.ends_with('.') || item.claim.ends_with('?'), "item {n}: {}", item.claim);
        assert!(!item.places.is_empty(), "item {n} stands nowhere");
        assert!(item.command.starts_with("cullet "), "item {n}: {}", item.command);
    }
    for text in Text::ALL {
        let places = items().flat_map(|i| i.places).filter(|p| p.text == text).count();
        assert!(places >= 10, "{text}: {places}");
    }
    let faults = items().filter(|i| i.fault.is_some()).count();
    assert!(faults >= 10, "{faults} faults of the texts are told");
}

#[test]
fn what_is_said_of_chapters_is_there() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
    for item in items() {
        let (file, heading) = item.chapter.split_once('#').unwrap_or((item.chapter, ""));
        let text = std::fs::read_to_string(book.join(file));
        let text = text.unwrap_or_else(|e| panic!("item {}: {file}: {e}", item.number));
        let anchor = |line: &str| {
            let title = line.trim_start_matches('#').trim().to_lowercase();
            let kept =
                title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
        };
        let is_there = heading.is_empty()
            || text.lines().filter(|l| l.starts_with('#')).any(|l| anchor(l) == heading);
        assert!(is_there, "item {}: {file} has no heading #{heading}", item.number);
    }
}

#[test]
fn each_claim_comes_out_as_it_is_told() {
    let lab = Lab::new(cullet_testkit::data(""), None);
    // To work on some: `CULLET_ITEMS=29-60`.
    let some = std::env::var("CULLET_ITEMS").ok().and_then(|range| {
        let (first, last) = range.split_once('-')?;
        Some(first.parse::<u8>().ok()?..=last.parse::<u8>().ok()?)
    });
    let mut wrong = Vec::new();
    for item in items().filter(|i| some.as_ref().is_none_or(|some| some.contains(&i.number))) {
        let begin = std::time::Instant::now();
        let found = match (item.check)(&lab) {
            Ok(found) => found,
            Err(error) => {
                wrong.push(format!("{}: {error}", item.number));
                continue;
            }
        };
        let seconds = begin.elapsed().as_secs_f32();
        println!("{:>3} {seconds:5.2} s {:?}: {}", item.number, found.outcome, found.measured);
        let is_told = match &found.outcome {
            Outcome::Holds | Outcome::Differs => item.fault.is_none(),
            Outcome::Mended => item.fault.is_some(),
            Outcome::NotHere(_) => true,
            Outcome::Fails => false,
        };
        if !is_told {
            wrong.push(format!("{}: {:?}: {}", item.number, found.outcome, found.measured));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_model_is_found_by_its_folder_or_as_it_was_fetched() {
    let folder = cullet_testkit::Folder::new("fetched");
    let lab = |data: &str| Lab::new(Some(data.into()), None);
    let asked = "stanford-bunny/bun_zipper.ply";
    assert!(lab(&folder.path("")).model(asked).unwrap().is_none());
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    assert!(folder.file("bunny.ply", ply).ends_with("bunny.ply"));
    let found = lab(&folder.path("")).model(asked).unwrap().expect("as cullet fetch names it");
    assert_eq!(found.scene.triangle_count(), 1);
    assert!(lab(&folder.path("")).model("armadillo/armadillo.obj").unwrap().is_none());
    // What is there and cannot be read is no model that is missing.
    let broken = folder.file("armadillo.ply", "ply\nformat");
    assert!(lab(&folder.path("")).model("armadillo/armadillo.obj").is_err(), "{broken}");
}
