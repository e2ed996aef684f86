//! A source with its mutants in it.

use std::ops::Range;

use crate::sites::{Change, Site};

/// Marks before and after a mutant, which [`lines`] looks for and [`clean`] takes away.
fn mark(number: usize, end: bool) -> String {
    format!("/*{}{number}*/", if end { "\u{2}" } else { "\u{1}" })
}

/// The source with each of these mutants behind the switch, and with marks.
pub(crate) fn apply(text: &str, mutants: &[(usize, &Site)], switch: &str) -> String {
    let mut mutants = mutants.to_vec();
    // The outer of two comes first; both of one place stand side by side.
    mutants.sort_by_key(|(n, s)| (s.whole.start, std::cmp::Reverse(s.whole.end), *n));
    render(text, 0..text.len(), &mutants, switch)
}

fn render(text: &str, of: Range<usize>, mutants: &[(usize, &Site)], switch: &str) -> String {
    let (mut out, mut at, mut rest) = (String::new(), of.start, mutants);
    while let [(_, first), ..] = rest {
        let whole = first.whole.clone();
        let same = rest.iter().take_while(|(_, s)| s.whole == whole).count();
        let inside = rest.iter().take_while(|(_, s)| s.whole.start < whole.end).count();
        out.push_str(&text[at..whole.start]);
        out.push_str(&place(text, &rest[..same], &rest[same..inside], switch));
        (at, rest) = (whole.end, &rest[inside..]);
    }
    out.push_str(&text[at..of.end]);
    out
}

/// The mutants of one place, around those within it.
fn place(text: &str, here: &[(usize, &Site)], inner: &[(usize, &Site)], switch: &str) -> String {
    let whole = here[0].1.whole.clone();
    let on = |n: usize| format!("if {switch}::mutant::on({n})");
    let plain = render(text, whole.clone(), inner, switch);
    let marks = |end: bool| here.iter().map(|(n, _)| mark(*n, end)).collect::<String>();
    if matches!(here[0].1.change, Change::Return(_)) {
        let mut early = String::new();
        for (n, site) in here {
            let Change::Return(what) = site.change else { continue };
            early += &format!("{} {{ return {what}; }} ", on(*n));
        }
        // Marks before the brace and behind it: the rest of the body is none of the mutant's.
        return format!("{{{}{early}{}{}", marks(false), marks(true), &plain[1..]);
    }
    let mut out = format!("({}", marks(false));
    for (n, site) in here {
        let changed = match &site.change {
            Change::Replace(part, by) => {
                let (before, after): (Vec<_>, Vec<_>) =
                    inner.iter().copied().partition(|(_, s)| s.whole.end <= part.start);
                let before = render(text, whole.start..part.start, &before, switch);
                before + by + &render(text, part.end..whole.end, &after, switch)
            }
            _ => format!("{plain} - {plain}"),
        };
        out += &format!("{} {{ {changed} }} else ", on(*n));
    }
    format!("{out}{{ {plain} }}{})", marks(true))
}

/// First and last line of a mutant, counted from 1.
pub(crate) fn lines(changed: &str, number: usize) -> [usize; 2] {
    [changed.find(&mark(number, false)), changed.rfind(&mark(number, true))]
        .map(|at| at.map_or(0, |at| changed[..at].matches('\n').count() + 1))
}

/// Without the marks.
pub(crate) fn clean(changed: &str) -> String {
    let mut out = String::with_capacity(changed.len());
    let mut rest = changed;
    while let Some(at) = rest.find("/*\u{1}").into_iter().chain(rest.find("/*\u{2}")).min() {
        out.push_str(&rest[..at]);
        let end = rest[at..].find("*/").map_or(rest.len(), |e| at + e + 2);
        rest = &rest[end..];
    }
    out + rest
}
