//! `cargo xtask bench-gpu --record`: the bench of the graphics device, kept in `docs/gpu.json`, and
//! the table of the book made of it.

use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::tools::{Done, cargo, root, target};

/// Measurements, one record for each device.
const LIST: &str = "docs/gpu.json";
/// The page, and what stands before and behind its table.
const PAGE: &str = "docs/src/gpu.md";
const MARKS: [&str; 2] = ["<!-- bench-gpu -->\n", "<!-- /bench-gpu -->"];
/// Seconds after which no part begins: the rest of four minutes is for the part under way.
const WITHIN: &str = "200";

/// Measures, and writes list and table. Compiling comes first and is not counted.
pub(crate) fn record() -> Done {
    let bench = ["bench", "-p", "cullet-gpu", "--bench", "device"];
    cargo(&[&bench[..], &["--no-run"]].concat())?;
    let out = target().join("bench-gpu.json");
    let _ = fs::remove_file(&out);
    let path = out.to_string_lossy();
    cargo(&[&bench[..], &["--", "--json", &path, "--within", WITHIN]].concat())?;
    let text = fs::read_to_string(&out)
        .map_err(|_| "nothing was measured: no device, as is said above".to_owned())?;
    let mut new: Value = serde_json::from_str(&text).map_err(|e| format!("{path}: {e}"))?;
    new["date"] = Value::String(today());
    let list = root().join(LIST);
    let old = fs::read_to_string(&list).unwrap_or_else(|_| "[]".to_owned());
    let old: Vec<Value> = serde_json::from_str(&old).map_err(|e| format!("{LIST}: {e}"))?;
    let records = replaced(old, new);
    let page = root().join(PAGE);
    let text = fs::read_to_string(&page).map_err(|e| format!("{PAGE}: {e}"))?;
    let text = with_table(&text, &table(&records))?;
    let json = serde_json::to_string_pretty(&json!(records)).map_err(|e| e.to_string())?;
    fs::write(&list, json + "\n").map_err(|e| format!("{LIST}: {e}"))?;
    fs::write(&page, text).map_err(|e| format!("{PAGE}: {e}"))?;
    println!("written to {LIST} and {PAGE}");
    Ok(())
}

/// The records with a new one in place of that of the same device. Software is one device, whatever
/// its version, and comes last.
fn replaced(mut records: Vec<Value>, new: Value) -> Vec<Value> {
    let is_software = |of: &Value| of["software"] == true;
    let is_same = |old: &Value| match is_software(&new) {
        true => is_software(old),
        false => ["adapter", "backend"].iter().all(|key| old[key] == new[key]),
    };
    records.retain(|old| !is_same(old));
    records.push(new);
    records.sort_by_key(is_software);
    records
}

/// The lines of the table, and under it on what each column was measured.
fn table(records: &[Value]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for row in records.iter().flat_map(|record| record["rows"].as_array()).flatten() {
        let name = row[0].as_str().unwrap_or_default();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let text = |of: &Value, key: &str| of[key].as_str().unwrap_or_default().to_owned();
    let mut lines = vec!["| what |".to_owned(), "|---|".to_owned()];
    let device = records.iter().any(|record| record["software"] != true);
    for record in records {
        let kind = if record["software"] == true { "software: " } else { "" };
        lines[0] += &format!(" {kind}{}, {} |", text(record, "adapter"), text(record, "backend"));
        lines[1] += "---|";
    }
    for name in names {
        let mut line = format!("| {name} |");
        for record in records {
            let rows = record["rows"].as_array().into_iter().flatten();
            let found = rows.filter(|row| row[0] == name).find_map(|row| row[1].as_f64());
            line += &found.map_or_else(|| " – |".to_owned(), |v| format!(" {} |", digits(v)));
        }
        lines.push(line);
    }
    lines.push(String::new());
    if !device {
        lines.push("No real device has been measured yet.".to_owned());
    }
    for record in records {
        let whole = if record["complete"] == false {
            "; its time ended before all was measured"
        } else {
            ""
        };
        lines.push(format!(
            "Measured on {} on a machine with {} ({}), in {} s{whole}.",
            text(record, "date"),
            text(record, "adapter"),
            text(record, "driver"),
            record["seconds"]
        ));
    }
    lines.join("\n") + "\n"
}

/// A number with two digits that say something.
fn digits(value: f64) -> String {
    match value.abs() {
        v if v >= 10.0 => format!("{value:.0}"),
        v if v >= 1.0 => format!("{value:.1}"),
        v if v >= 0.1 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// A page with another table between the marks.
fn with_table(page: &str, table: &str) -> Result<String, String> {
    let [begin, end] = MARKS;
    let lacks = || format!("{PAGE} lacks the marks {begin:?} and {end:?}");
    let (before, rest) = page.split_once(begin).ok_or_else(lacks)?;
    let (_, after) = rest.split_once(end).ok_or_else(lacks)?;
    Ok(format!("{before}{begin}{table}{end}{after}"))
}

/// Today's date, as 2026-11-28.
fn today() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    date(since.as_secs() / 86_400)
}

/// The date so many days after 1970-01-01: years begin with March, so that leap days come last
/// (H. Hinnant, *chrono-Compatible Low-Level Date Algorithms*, 2014).
fn date(days: u64) -> String {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", era * 400 + year + next)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(adapter: &str, software: bool, found: f64) -> Value {
        json!({
            "adapter": adapter, "backend": "vulkan", "driver": "d 1", "software": software,
            "seconds": 9, "complete": true, "date": "2026-11-28", "rows": [["frames", found]],
        })
    }

    #[test]
    fn a_device_replaces_itself_and_software_is_never_in_its_column() {
        let mut records = replaced(Vec::new(), record("pipe 1", true, 5.0));
        assert!(table(&records).contains("No real device has been measured yet."));
        for (adapter, found) in [("card", 0.5), ("other", 0.25), ("card", 0.034)] {
            records = replaced(records, record(adapter, false, found));
        }
        records = replaced(records, record("pipe 2", true, 12.3));
        let text = table(&records);
        assert!(text.starts_with(
            "| what | other, vulkan | card, vulkan | software: pipe 2, vulkan |\n|---|---|---|---|\n| frames | 0.25 | 0.034 | 12 |\n"
        ), "{text}");
        assert!(!text.contains("No real device") && !text.contains("pipe 1"));
    }

    #[test]
    fn the_table_stands_between_its_marks() {
        let page = "a\n<!-- bench-gpu -->\nold\n<!-- /bench-gpu -->\nb";
        let new = with_table(page, "new\n").expect("marks");
        assert_eq!(new, "a\n<!-- bench-gpu -->\nnew\n<!-- /bench-gpu -->\nb");
        assert!(with_table("no marks", "new").is_err());
    }

    #[test]
    fn days_are_dates() {
        let known = [(0, "1970-01-01"), (11_016, "2000-02-29"), (20_785, "2026-11-28")];
        for (days, expected) in known {
            assert_eq!(date(days), expected);
        }
    }
}
