//! `cullet lecture`: what three lectures and a paper say, each claim shown and measured here.

use std::path::PathBuf;

use clap::Args;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome as Ended};
use cullet_command::files::{replace, write_json};
use serde::Serialize;

use super::{Finding, Item, Outcome, Runs, Text, lectures, page, print};

/// End of `cullet lecture --help`.
pub const HELP: &str = "\
Three lectures and a paper on culling, item by item: the claim in our words, where it stands, the number that it gives, the number that is
measured here, and where a text errs, both the error and what is right.

  zachmann     G. Zachmann, Culling, 2013 and 2014
  ucsd         CSE 167, University of California, San Diego, 2015
  kaist        S.-E. Yoon, Clipping and Culling, CS 380
  zhang-hoff   H. Zhang and K. E. Hoff III, Fast Backface Culling Using Normal Masks, 1997

Examples
  cullet lecture                       the texts, and how many items each has
  cullet lecture ucsd                  the items of one, in the order of its slides
  cullet lecture 21                    one item, measured
  cullet lecture zachmann 21           the same
  cullet lecture kaist outcodes        the items whose title has that word
  cullet lecture --check               all of them: which claims hold here? Exit code 1 if one does not
  cullet lecture zhang-hoff --check    those of one text

What commands show is measured now, by running them; of what tests show, the figures of the book are told, which the tests
hold, and how to run them. The models that everybody knows are found in the folder --data, CULLET_DATA or models, where
cullet fetch puts them.";

/// `cullet lecture`
#[derive(Debug, Args)]
pub struct LectureArgs {
    /// A text (zachmann, ucsd, kaist, zhang-hoff), an item's number, or a word of its title; a text
    /// and an item
    #[arg(value_name = "TEXT | ITEM", num_args = 0..=2)]
    what: Vec<String>,
    /// Measure all items, or those of the text, and say which claims hold here
    #[arg(long)]
    check: bool,
    /// Where real models lie, a folder for each
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Write all items as a page of the book
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    page: Option<PathBuf>,
    /// Write items, and what was measured, as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// Choice made by the words on the command line.
#[derive(Debug)]
struct Choice {
    text: Option<&'static Text>,
    items: Vec<&'static Item>,
    /// Whether single items were named.
    is_named: bool,
}

/// Items with what was measured of them.
#[derive(Debug, Serialize)]
struct Record<'a> {
    schema: u32,
    items: Vec<Checked<'a>>,
}

#[derive(Debug, Serialize)]
struct Checked<'a> {
    #[serde(flatten)]
    item: &'a Item,
    /// The measured sentence of the book.
    told: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<&'a Finding>,
}

/// Runs the command.
pub(crate) fn run(args: &LectureArgs, console: &Console) -> Ended {
    if let Some(path) = &args.page {
        replace(path, page().as_bytes())?;
        console.line(format!("{} written", path.display()));
    }
    let choice = choose(&args.what)?;
    let measures = args.check || choice.is_named;
    let named = args.data.clone().or_else(|| std::env::var_os("CULLET_DATA").map(PathBuf::from));
    let mut runs = Runs::new(named);
    let mut all: Vec<(&Item, Option<Finding>)> = Vec::new();
    match choice.text {
        _ if measures => {
            let mut progress = console.progress("items", choice.items.len() as u64);
            for item in choice.items {
                if interrupted() {
                    break;
                }
                let found = runs.check(item);
                progress.step();
                if args.check {
                    print::line(item, found.as_ref(), console);
                } else {
                    print::item(item, found.as_ref(), console);
                }
                all.push((item, found));
            }
            progress.finish();
            if args.check {
                print::summary(&all, console);
            }
        }
        _ if args.page.is_some() => {}
        None => {
            print::texts(console);
            all.extend(choice.items.into_iter().map(|item| (item, None)));
        }
        Some(text) => {
            print::list(text, &choice.items, console);
            all.extend(choice.items.into_iter().map(|item| (item, None)));
        }
    }
    if let Some(path) = &args.json {
        let pairs = all.iter();
        let items =
            pairs.map(|(item, found)| Checked { item, told: item.told(), found: found.as_ref() });
        write_json(path, &Record { schema: 2, items: items.collect() })?;
    }
    let fails = |found: &Finding| matches!(found.outcome, Outcome::Fails(_));
    Ok(match () {
        () if interrupted() => Exit::Interrupted,
        () if all.iter().any(|(_, found)| found.as_ref().is_some_and(fails)) => Exit::FalseCull,
        () => Exit::Fine,
    })
}

fn choose(words: &[String]) -> Result<Choice, Failure> {
    let text_of = |name: &String| lectures().texts.iter().find(|text| text.name == *name);
    let (text, rest) = match words.split_first() {
        Some((first, rest)) if text_of(first).is_some() => (text_of(first), rest),
        _ => (None, words),
    };
    let of_text = |item: &&Item| text.is_none_or(|text| item.is_of(&text.name));
    let mut items: Vec<&'static Item> = lectures().items.iter().filter(of_text).collect();
    match rest {
        [] => {}
        [word] => {
            let word = word.to_lowercase();
            match word.parse::<u32>() {
                Ok(number) => items.retain(|item| item.number == number),
                Err(_) => items.retain(|item| item.title.to_lowercase().contains(&word)),
            }
            if items.is_empty() {
                return Err(Failure::usage(no_such_item(text, &word)));
            }
        }
        [first, ..] => {
            return Err(Failure::usage(match text {
                None => format!("there is no text '{first}'; the texts are {}", names()),
                Some(_) => "give a text, an item, or a text and an item".to_owned(),
            }));
        }
    }
    Ok(Choice { text, items, is_named: !rest.is_empty() })
}

/// The texts' names, in words.
fn names() -> String {
    let names: Vec<&str> = lectures().texts.iter().map(|text| &*text.name).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    format!("{} and {last}", others.join(", "))
}

fn no_such_item(text: Option<&Text>, word: &str) -> String {
    let in_text = text.map(|t| format!(" of {}", t.name)).unwrap_or_default();
    format!(
        "there is no item{in_text} '{word}': items have the numbers 1 to {}, and titles, which `cullet lecture {}` lists; texts are {}",
        lectures().items.len(),
        text.map_or("zachmann", |t| &t.name),
        names()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(words: &[&str]) -> Result<Choice, Failure> {
        choose(&words.iter().map(|&w| w.to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn texts_numbers_and_words_of_titles_choose_items() {
        assert_eq!(of(&[]).expect("all").items.len(), lectures().items.len());
        let lecture = of(&["zachmann"]).expect("a text");
        assert!(!lecture.is_named && lecture.items.len() > 10);
        for words in [&["21"][..], &["zachmann", "21"], &["worked example"]] {
            let one = of(words).expect("an item");
            assert!(one.is_named);
            assert_eq!(one.items.iter().map(|i| i.number).collect::<Vec<_>>(), [21]);
        }
    }

    #[test]
    fn what_is_not_there_is_said_with_what_is() {
        for words in [&["kant"][..], &["0"], &["102"], &["ucsd", "21"], &["kant", "21"]] {
            let failure = of(words).expect_err("nothing of that name");
            assert_eq!(failure.exit, Exit::Usage);
            assert!(failure.message.contains("zachmann, ucsd, kaist"), "{}", failure.message);
        }
    }
}
