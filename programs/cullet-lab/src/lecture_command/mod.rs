//! `cullet lecture`: what three lectures and a paper say, each claim shown and measured here.

mod page;
mod print;
mod record;

use std::path::PathBuf;
use std::time::Instant;

use crate::lecture::{Item, Lab, Text, items};
use clap::Args;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};

use cullet_cli::neighbours::PROFILER;
use record::{Checked, Record};

/// End of `cullet lecture --help`.
pub(crate) const HELP: &str = "\
Three lectures and a paper on culling, item by item: the claim in our words, where it stands, the number that it gives, the number that is
measured here and now, and where a text errs, both the error and what is right.

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
  cullet lecture zhang-hoff --check    with the bunny, once cullet fetch bunny has put it into models

The models that everybody knows are found in the folder --data, CULLET_DATA or models, where cullet fetch puts them; without
them built-in scenes stand in.";

/// `cullet lecture`
#[derive(Debug, Args)]
pub struct LectureArgs {
    /// A text (zachmann, ucsd, kaist, zhang-hoff), an item's number, or a word of its title; a text and an item
    #[arg(value_name = "TEXT | ITEM", num_args = 0..=2)]
    what: Vec<String>,
    /// Measure all items, or those of the text, and say which claims hold here
    #[arg(long)]
    check: bool,
    /// Where real models lie, a folder for each
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Write the items as a page of the book, with what --check measured
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output, requires = "check")]
    page: Option<PathBuf>,
    /// Write items, and what was measured, as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// What the words on the command line choose.
#[derive(Debug)]
struct Choice {
    text: Option<Text>,
    /// Of one text those in the order of its slides, else in the order of the subject.
    items: Vec<&'static Item>,
    /// Whether single items were named.
    is_named: bool,
}

/// Runs the command.
pub(crate) fn run(args: &LectureArgs, console: &Console) -> Outcome {
    let choice = choose(&args.what)?;
    let measures = args.check || choice.is_named;
    if !measures {
        match choice.text {
            None => print::texts(console),
            Some(text) => print::list(text, &choice.items, console),
        }
        if let Some(path) = &args.json {
            let record = Record::of(choice.items.iter().map(|&item| Checked::unmeasured(item)));
            write_json(path, &record)?;
        }
        return Ok(Exit::Fine);
    }
    let named = args.data.clone().or_else(|| std::env::var_os("CULLET_DATA").map(PathBuf::from));
    let data = named.or_else(|| Some(PathBuf::from("models")).filter(|folder| folder.is_dir()));
    let lab = Lab::new(data, PROFILER.path());
    let mut progress = console.progress("items", choice.items.len() as u64);
    let mut all = Vec::with_capacity(choice.items.len());
    for &item in &choice.items {
        if interrupted() {
            break;
        }
        let begin = Instant::now();
        let found =
            (item.check)(&lab).map_err(|e| Failure::input(format!("item {}: {e}", item.number)))?;
        let checked = Checked::new(item, found, begin.elapsed().as_secs_f64());
        progress.step();
        if args.check {
            print::line(&checked, console);
        } else {
            print::item(&checked, console);
        }
        all.push(checked);
    }
    progress.finish();
    let record = Record::of(all);
    if args.check {
        print::summary(&record, console);
    }
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    if let Some(path) = &args.page {
        replace(path, page::page(&record).as_bytes())?;
        console.line(format!("{} written", path.display()));
    }
    Ok(match () {
        () if interrupted() => Exit::Interrupted,
        () if record.items.iter().any(Checked::is_wrong) => Exit::FalseCull,
        () => Exit::Fine,
    })
}

fn choose(words: &[String]) -> Result<Choice, Failure> {
    let (text, rest) = match words.split_first() {
        Some((first, rest)) if first.parse::<Text>().is_ok() => (first.parse().ok(), rest),
        _ => (None, words),
    };
    let of_text = |item: &&Item| text.is_none_or(|t| item.places.iter().any(|p| p.text == t));
    let mut chosen: Vec<&'static Item> = items().filter(of_text).collect();
    match rest {
        [] => {}
        [word] => {
            let word = word.to_lowercase();
            match word.parse::<u32>() {
                Ok(number) => chosen.retain(|item| u32::from(item.number) == number),
                Err(_) => chosen.retain(|item| item.title.to_lowercase().contains(&word)),
            }
            if chosen.is_empty() {
                return Err(Failure::usage(no_such_item(text, &word)));
            }
        }
        [first, ..] => {
            let message = match first.parse::<Text>() {
                Err(error) => error.to_string(),
                Ok(_) => "give a text, an item, or a text and an item".to_owned(),
            };
            return Err(Failure::usage(message));
        }
    }
    Ok(Choice { text, items: chosen, is_named: !rest.is_empty() })
}

fn no_such_item(text: Option<Text>, word: &str) -> String {
    let all = items().count();
    let in_text = text.map(|t| format!(" of {t}")).unwrap_or_default();
    format!(
        "there is no item{in_text} '{word}': items have the numbers 1 to {all}, and titles, which `cullet lecture{}` lists; texts are \
         zachmann, ucsd, kaist and zhang-hoff",
        text.map_or(" zachmann".to_owned(), |t| format!(" {t}"))
    )
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Of<C: clap::Subcommand> {
        #[command(subcommand)]
        command: C,
    }

    fn parses<C: clap::Subcommand>(words: &[&str]) -> bool {
        match Of::<C>::try_parse_from(words) {
            Ok(_) => true,
            Err(e) => e.kind() == clap::error::ErrorKind::DisplayHelp,
        }
    }

    /// Whether any of the programs takes a command line.
    fn can_be_typed(words: &[&str]) -> bool {
        words.get(1) == Some(&"profile")
            || parses::<cullet_cli::Command>(words)
            || parses::<cullet_baker::Command>(words)
            || parses::<crate::Command>(words)
    }

    fn of(words: &[&str]) -> Result<Choice, Failure> {
        choose(&words.iter().map(|&w| w.to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn texts_numbers_and_words_of_titles_choose_items() {
        assert_eq!(of(&[]).expect("all").items.len(), items().count());
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

    #[test]
    fn commands_of_all_items_can_be_typed() {
        for item in items() {
            for command in item.command.split(" && ") {
                let words: Vec<&str> = command.split(' ').collect();
                assert!(can_be_typed(&words), "item {}: {command}", item.number);
            }
        }
    }
}
