//! `docs/lectures.json`: items are whole, what they name is there, and what commands show holds.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Parser;
use cullet_cli::neighbours::{BAKER, Elsewhere, LAB, elsewhere};
use cullet_lab::lecture::{Item, Outcome, Runs, lectures, page};

/// All rows that the texts have.
const COUNT: u32 = 101;

fn read(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"))
}

#[derive(Debug, Parser)]
struct Of<C: clap::Subcommand> {
    #[command(subcommand)]
    command: C,
}

/// Whether any of the programs takes a command line.
fn can_be_typed(command: &str) -> bool {
    fn parses<C: clap::Subcommand>(words: &[&str]) -> bool {
        match Of::<C>::try_parse_from(words) {
            Ok(_) => true,
            Err(e) => e.kind() == clap::error::ErrorKind::DisplayHelp,
        }
    }
    let words: Vec<&str> = command.split(' ').collect();
    // The viewer, its server and the profiler know their own arguments.
    let is_elsewhere =
        |command: &Elsewhere| ![BAKER.name, LAB.name].contains(&command.program.name);
    elsewhere(words[1]).is_some_and(is_elsewhere)
        || parses::<cullet_cli::Command>(&words)
        || parses::<cullet_baker::Command>(&words)
        || parses::<cullet_lab::Command>(&words)
}

/// Whether a chapter has a heading by which `#anchor` leads to it.
fn has_heading(chapter: &str, anchor: &str) -> bool {
    let of = |line: &str| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    read(&format!("docs/src/{chapter}")).lines().any(|l| l.starts_with('#') && of(l) == anchor)
}

/// Whether the tests of an item are there, and hold what it says of them.
fn check_tests(item: &Item) {
    let mut files = String::new();
    for test in &item.check.test {
        let (file, name) = test.split_once("::").unwrap_or_else(|| panic!("{test}: no FILE::NAME"));
        let text = read(file);
        let (before, _) = text.split_once(&format!("fn {name}(")).unwrap_or_else(|| {
            panic!("item {}: {file} has no test {name}", item.number);
        });
        // Between the attribute and the function are at most other attributes and comments.
        let mark = before.rfind("#[test]").unwrap_or_else(|| panic!("{test} is no test"));
        let between = before[mark..].lines().skip(1).map(str::trim);
        assert!(
            between.clone().all(|l| l.is_empty() || l.starts_with(['#', '/'])),
            "{test} is no test"
        );
        files += &text;
    }
    let bare = |text: &str| text.split_whitespace().collect::<String>();
    let files = bare(&files);
    for words in &item.check.says {
        assert!(files.contains(&bare(words)), "item {}: no test says {words}", item.number);
    }
}

#[test]
fn each_item_is_whole_and_what_it_names_is_there() {
    let items = &lectures().items;
    assert!(items.iter().map(|item| item.number).eq(1..=COUNT));
    let titles: BTreeSet<&str> = items.iter().map(|item| &*item.title).collect();
    assert_eq!(titles.len(), items.len(), "a title stands twice");
    for item in items {
        let Item { number, claim, command, measured, figures, check, .. } = item;
        assert!(!item.title.is_empty() && claim.ends_with(['.', '?']), "item {number}: {claim}");
        let is_known = |name: &str| lectures().texts.iter().any(|text| text.name == name);
        let stands = item.places.iter().all(|p| is_known(&p.text) && !p.at.is_empty());
        assert!(!item.places.is_empty() && stands, "item {number} stands nowhere");
        for command in command.split(" && ") {
            assert!(can_be_typed(command), "item {number}: {command}");
        }
        let (chapter, heading) = item.chapter.split_once('#').unwrap_or((&item.chapter, ""));
        let is_there = if heading.is_empty() {
            !read(&format!("docs/src/{chapter}")).is_empty()
        } else {
            has_heading(chapter, heading)
        };
        assert!(is_there, "item {number}: {}", item.chapter);
        assert!(!measured.is_empty() && !measured.ends_with('.'), "item {number}: {measured}");
        assert_eq!(measured.matches("{}").count(), figures.len(), "item {number}");
        assert_eq!(check.run.is_empty(), check.holds.is_empty(), "item {number}");
        assert!(!check.run.is_empty() || !check.test.is_empty(), "nothing shows item {number}");
        check_tests(item);
    }
    for text in &lectures().texts {
        let places = items.iter().flat_map(|i| &i.places).filter(|p| p.text == text.name).count();
        assert!(places >= 10, "{}: {places}", text.name);
    }
    let faults = items.iter().filter(|i| i.fault.is_some()).count();
    assert!(faults >= 10, "{faults} faults of the texts are told");
}

/// Returns what is wrong with `items` that commands show, a line each.
fn wrong(items: &[&Item]) -> Vec<String> {
    let mut runs = Runs::new(cullet_testkit::data(""));
    let mut wrong = Vec::new();
    for item in items {
        let begin = std::time::Instant::now();
        let Some(mut found) = runs.check(item) else { continue };
        // Another program beside this one lengthens what is timed, now and then.
        let is_timed = item.check.holds.iter().any(|line| line.contains("seconds"));
        for _ in 0..if is_timed { 3 } else { 0 } {
            if let Outcome::Fails(_) = found.outcome {
                runs = Runs::new(cullet_testkit::data(""));
                found = runs.check(item).unwrap_or(found);
            }
        }
        println!(
            "{:>3} {:5.2} s {:?}: {}",
            item.number,
            begin.elapsed().as_secs_f32(),
            found.outcome,
            found.measured
        );
        let told = match (&item.fault, item.differs) {
            (Some(_), _) => Outcome::Mended,
            (None, true) => Outcome::Differs,
            (None, false) => Outcome::Holds,
        };
        let is_told = found.outcome == told || matches!(found.outcome, Outcome::NotHere(_));
        if !is_told || !found.others.is_empty() {
            wrong.push(format!("{}: {found:?}", item.number));
        }
    }
    wrong
}

/// The items that commands show, in two halves: those whose first command is the same stay
/// together, for it is run once.
fn halves() -> [Vec<&'static Item>; 2] {
    let shown = lectures().items.iter().filter(|item| !item.check.run.is_empty());
    let mut firsts: Vec<&str> = Vec::new();
    let mut halves = [Vec::new(), Vec::new()];
    for item in shown {
        let first = &*item.check.run[0];
        let at = firsts.iter().position(|f| *f == first).unwrap_or_else(|| {
            firsts.push(first);
            firsts.len() - 1
        });
        halves[at % 2].push(item);
    }
    halves
}

#[test]
fn each_claim_that_commands_show_holds_with_the_figures_of_the_book() {
    let wrong = wrong(&halves()[0]);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_other_claim_that_commands_show_holds_too() {
    let wrong = wrong(&halves()[1]);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_page_of_the_book_is_made_of_the_items() {
    let write = "write it again by cullet lecture --page docs/src/lectures.md";
    assert!(read("docs/src/lectures.md") == page(), "docs/src/lectures.md is another: {write}");
}
