//! What the command prints.

use crate::lecture::{Item, Outcome, Text, items};
use cullet_command::console::{Console, count};

use super::record::{Checked, Record, places, word};

/// How wide lines are.
const WIDTH: usize = 100;
/// How far explanations stand in.
const INDENT: usize = 10;

pub(super) fn texts(console: &Console) {
    for text in Text::ALL {
        let of = items().filter(|i| i.places.iter().any(|p| p.text == text)).count();
        console.line(format!("{:<11} {:>3} items   {}", text.name(), of, text.reference()));
    }
    console.line("");
    console.line("cullet lecture TEXT lists the items of one, cullet lecture NUMBER shows one, --check measures all");
}

pub(super) fn list(text: Text, of: &[&Item], console: &Console) {
    console.line(format!("{}: {}", text.name(), text.reference()));
    for item in of {
        let at = item.places.iter().filter(|p| p.text == text).map(|p| p.at);
        let at = at.collect::<Vec<_>>().join(", ");
        let fault = if item.fault.is_some() { "   (the text errs)" } else { "" };
        console.line(format!("{:>4}  {:<52} {at}{fault}", item.number, item.title));
    }
}

pub(super) fn item(checked: &Checked, console: &Console) {
    let item = checked.item;
    console.line(format!("{}. {}", item.number, item.title));
    console.line(format!("{:INDENT$}{}", "", places(item.places)));
    paragraph("claim", item.claim, console);
    if let Some(said) = item.said {
        paragraph("said", said, console);
    }
    if let Some(found) = &checked.found {
        let here = match &found.outcome {
            Outcome::NotHere(missing) => format!("not tried: {missing}"),
            outcome => format!("{} ({})", found.measured, word(outcome)),
        };
        paragraph("here", &here, console);
    }
    if let Some(fault) = item.fault {
        paragraph("error", fault, console);
    }
    console.line(format!("{:<INDENT$}{}", "try", item.command));
    if let Some(live) = item.live {
        console
            .line(format!("{:<INDENT$}cullet view {} --state '{}'", "see", live.scene, live.state));
    }
    console.line(format!("{:<INDENT$}docs/src/{}", "read", item.chapter));
    console.line("");
}

pub(super) fn line(checked: &Checked, console: &Console) {
    let Some(found) = &checked.found else { return };
    let measured = match &found.outcome {
        Outcome::NotHere(missing) => missing,
        _ => &found.measured,
    };
    let (number, title) = (checked.item.number, checked.item.title);
    console.line(format!("{number:>4}  {:<13}  {title}: {measured}", word(&found.outcome)));
}

pub(super) fn summary(record: &Record, console: &Console) {
    let of = |wanted: fn(&Outcome) -> bool| {
        let outcomes = record.items.iter().filter_map(|c| c.found.as_ref());
        outcomes.filter(|f| wanted(&f.outcome)).count()
    };
    let wrong = record.items.iter().filter(|c| c.is_wrong()).count() as u64;
    console.line("");
    console.line(format!(
        "{}: {} hold, {} hold with another number, {} texts' errors are shown, {} cannot be tried here, {} not as told",
        count(record.items.len() as u64, "item", "items"),
        of(|o| *o == Outcome::Holds),
        of(|o| *o == Outcome::Differs),
        of(|o| *o == Outcome::Mended),
        of(|o| matches!(o, Outcome::NotHere(_))),
        wrong
    ));
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
