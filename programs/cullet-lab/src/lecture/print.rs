//! Output of `cullet lecture`.

use cullet_command::console::{Console, count};
use cullet_io::shell_word;

use super::{Finding, Item, Outcome, Text, lectures};

/// How wide lines are.
const WIDTH: usize = 100;
/// How far explanations stand in.
const INDENT: usize = 10;

pub(super) fn texts(console: &Console) {
    for text in &lectures().texts {
        let of = lectures().items.iter().filter(|item| item.is_of(&text.name)).count();
        console.line(format!("{:<11} {:>3} items   {}", text.name, of, text.about));
    }
    console.line("");
    console.line("cullet lecture TEXT lists the items of one, cullet lecture NUMBER shows one, --check measures all");
}

pub(super) fn list(text: &Text, of: &[&Item], console: &Console) {
    console.line(format!("{}: {}", text.name, text.about));
    for item in of {
        let at = item.places.iter().filter(|p| p.text == text.name).map(|p| &*p.at);
        let at = at.collect::<Vec<_>>().join(", ");
        let fault = if item.fault.is_some() { "   (the text errs)" } else { "" };
        console.line(format!("{:>4}  {:<52} {at}{fault}", item.number, item.title));
    }
}

/// An item, with what its commands find now; what only tests show is told as the book has it.
pub(super) fn item(item: &Item, found: Option<&Finding>, console: &Console) {
    console.line(format!("{}. {}", item.number, item.title));
    console.line(format!("{:INDENT$}{}", "", item.stands()));
    paragraph("claim", &item.claim, console);
    if let Some(said) = &item.said {
        paragraph("said", said, console);
    }
    let here = match found {
        None => format!("{} ({})", item.told(), item.outcome().word()),
        Some(Finding { outcome: Outcome::NotHere(missing), .. }) => format!("not tried: {missing}"),
        Some(Finding { measured, outcome, .. }) => format!("{measured} ({})", said_of(outcome)),
    };
    paragraph("here", &here, console);
    if let Some(fault) = &item.fault {
        paragraph("error", fault, console);
    }
    for command in &item.check.run {
        console.line(format!("{:<INDENT$}cullet {command}", "by"));
    }
    for command in item.check.commands() {
        console.line(format!("{:<INDENT$}{command}", "test"));
    }
    console.line(format!("{:<INDENT$}{}", "try", item.command));
    if let Some(live) = &item.live {
        let [scene, state] = [&live.scene, &live.state].map(|word| shell_word(word));
        console.line(format!("{:<INDENT$}cullet view {scene} --state {state}", "see"));
    }
    console.line(format!("{:<INDENT$}docs/src/{}", "read", item.chapter));
    console.line("");
}

/// An item in a line, or in a line for each test where commands show nothing of it.
pub(super) fn line(item: &Item, found: Option<&Finding>, console: &Console) {
    let (number, title) = (item.number, &item.title);
    let (word, measured) = match found {
        None => ("by a test", item.told()),
        Some(Finding { outcome: Outcome::NotHere(missing), .. }) => ("not here", missing.clone()),
        Some(Finding { measured, outcome, .. }) => (outcome.word(), measured.clone()),
    };
    console.line(format!("{number:>4}  {word:<13}  {title}: {measured}"));
    if let Some(Finding { outcome: Outcome::Fails(why), .. }) = found {
        console.line(format!("{:21}{why}", ""));
    }
    if found.is_none() {
        item.check.commands().for_each(|command| console.line(format!("{:21}{command}", "")));
    }
}

pub(super) fn summary(all: &[(&Item, Option<Finding>)], console: &Console) {
    let of = |wanted: fn(&Outcome) -> bool| {
        let found = all.iter().filter_map(|(_, found)| found.as_ref());
        found.filter(|f| wanted(&f.outcome)).count()
    };
    let tests = all.iter().filter(|(_, found)| found.is_none()).count();
    console.line("");
    console.line(format!(
        "{}: {} hold, {} hold with another number, {} texts' errors are shown, {} cannot be tried here, {} not as told; \
         {tests} are shown by tests, which cargo xtask test runs",
        count(all.len() as u64, "item", "items"),
        of(|o| *o == Outcome::Holds),
        of(|o| *o == Outcome::Differs),
        of(|o| *o == Outcome::Mended),
        of(|o| matches!(o, Outcome::NotHere(_))),
        of(|o| matches!(o, Outcome::Fails(_))),
    ));
}

/// An outcome in words, with the reason where it is none that is told.
fn said_of(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Fails(why) => format!("FAILS: {why}"),
        outcome => outcome.word().to_owned(),
    }
}

/// A paragraph with a word before it.
fn paragraph(before: &str, text: &str, console: &Console) {
    let mut line = format!("{before:<INDENT$}");
    let mut length = INDENT;
    for word in text.split_whitespace() {
        let letters = word.chars().count();
        if length + letters > WIDTH && length > INDENT {
            console.line(line.trim_end());
            (line, length) = (" ".repeat(INDENT), INDENT);
        }
        line.push_str(word);
        line.push(' ');
        length += letters + 1;
    }
    console.line(line.trim_end());
}
