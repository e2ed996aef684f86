//! Figures of JSON: a formula of numbers and of what commands wrote, and a figure as a text has it.
//!
//! `cargo xtask figures` shares this file, so it uses nothing but `serde_json`.

use std::iter::Peekable;
use std::str::SplitWhitespace;

use serde_json::Value;

type Words<'a> = Peekable<SplitWhitespace<'a>>;

/// Evaluates a formula: numbers and pointers into JSON, with `+ - * / ( )` between spaces.
///
/// A pointer begins with a slash, and with `2:` before it if it leads into the second of `runs`. A
/// segment `*` is every element of a list, and `name=frustum,unit=instances` those that have these
/// values; what several elements have is added up. A list counts its elements, an object and `true`
/// are 1, and a pointer that ends in `?` is 0 where it leads nowhere.
///
/// # Errors
/// If a pointer leads nowhere or to text, if a divisor is 0, or if the formula is none.
pub(crate) fn value(formula: &str, runs: &[&Value]) -> Result<f64, String> {
    let mut words = formula.split_whitespace().peekable();
    let value = sum(&mut words, runs)?;
    words.next().map_or(Ok(value), |word| Err(format!("no operator before {word:?}")))
}

fn sum(words: &mut Words<'_>, runs: &[&Value]) -> Result<f64, String> {
    let mut value = product(words, runs)?;
    while let Some(sign) = words.next_if(|w| matches!(*w, "+" | "-")) {
        let term = product(words, runs)?;
        value += if sign == "+" { term } else { -term };
    }
    Ok(value)
}

fn product(words: &mut Words<'_>, runs: &[&Value]) -> Result<f64, String> {
    let mut value = factor(words, runs)?;
    while let Some(sign) = words.next_if(|w| matches!(*w, "*" | "/")) {
        value = match (sign, factor(words, runs)?) {
            ("/", 0.0) => return Err("the figure is a share of nothing".into()),
            ("/", divisor) => value / divisor,
            (_, factor) => value * factor,
        };
    }
    Ok(value)
}

fn factor(words: &mut Words<'_>, runs: &[&Value]) -> Result<f64, String> {
    match words.next() {
        Some("(") => {
            let value = sum(words, runs)?;
            words.next_if_eq(&")").ok_or("a ) is missing")?;
            Ok(value)
        }
        Some(word) if word.contains('/') => pointed(word, runs),
        Some(word) => word.parse().map_err(|_| format!("{word:?} is no number and no pointer")),
        None => Err("a number or a pointer is missing".into()),
    }
}

/// The sum of all that a pointer leads to.
fn pointed(word: &str, runs: &[&Value]) -> Result<f64, String> {
    let (run, pointer) = word.split_once(":/").unwrap_or(("1", &word[1..]));
    let run = run.parse::<usize>().ok().and_then(|n| runs.get(n.wrapping_sub(1)));
    let mut reached = vec![*run.ok_or(format!("{word} is of no command"))?];
    let bare = pointer.trim_end_matches('?');
    for segment in bare.split('/') {
        reached = reached.into_iter().flat_map(|value| step(value, segment)).collect();
    }
    if reached.is_empty() && bare == pointer {
        return Err(format!("it wrote nothing at {word}"));
    }
    let number = |value: &Value| match value {
        Value::Array(list) => Some(list.len() as f64),
        Value::Object(_) => Some(1.0),
        Value::Bool(holds) => Some(f64::from(*holds)),
        value => value.as_f64(),
    };
    let numbers: Option<Vec<f64>> = reached.into_iter().map(number).collect();
    Ok(numbers.ok_or(format!("{word} is no number"))?.iter().sum())
}

/// Returns the values that a segment of a pointer leads to.
fn step<'a>(value: &'a Value, segment: &str) -> Vec<&'a Value> {
    let Value::Array(list) = value else { return value.get(segment).into_iter().collect() };
    if let Ok(index) = segment.parse::<usize>() {
        return list.get(index).into_iter().collect();
    }
    let wanted: Vec<(&str, &str)> = segment.split(',').filter_map(|w| w.split_once('=')).collect();
    let fits = |element: &&Value| {
        wanted.iter().all(|(key, wanted)| match &element[*key] {
            Value::String(text) => text == wanted,
            value => {
                let text = value.to_string();
                text == *wanted
            }
        })
    };
    list.iter().filter(|e| (segment == "*" || !wanted.is_empty()) && fits(e)).collect()
}

/// Writes a value as `held` is: with its digits grouped by the same character.
pub(crate) fn written(value: f64, decimals: usize, held: &str) -> String {
    let plain = format!("{value:.decimals$}");
    let (whole, rest) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    let by = if held.contains(' ') { ' ' } else { ',' };
    let mut grouped = String::new();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i) % 3 == 0 && digit.is_ascii_digit() && !grouped.ends_with('-')
        {
            grouped.push(by);
        }
        grouped.push(digit);
    }
    grouped + rest
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn pointers_lead_to_what_they_name_and_several_are_added_up() {
        let rows = json!({"rows": [{"n": 2, "of": "a", "v": 1.5}, {"n": 16, "of": "b", "v": 4}], "all": true});
        let other = json!({"v": 8, "none": null});
        let of = |formula: &str| value(formula, &[&rows, &other]);
        assert_eq!(of("/rows/n=16/v / ( 2:/v - /rows/0/v * 4 )"), Ok(2.0));
        assert_eq!(of("/rows/*/v"), Ok(5.5));
        assert_eq!(of("/rows/of=a,n=2/v + /rows + /rows/of=b + /all + /rows/of=c?"), Ok(5.5));
        assert_eq!(of("1e3 - 1 - 1"), Ok(998.0));
        for none in [
            "/rows/n=3/v",
            "3:/v",
            "2:/none",
            "/rows/0/of",
            "1 / 0",
            "( 1",
            "1 2",
            "1 +",
            "one",
            "",
        ] {
            assert!(of(none).is_err(), "{none}");
        }
    }
}
