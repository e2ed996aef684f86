//! Where costs are kept between runs, and the file they are kept in.

use cullet_io::shell_word;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::console::Console;
use crate::exit::Failure;
use crate::machine::Machine;
use crate::measured_costs::MeasuredCosts;

/// The number of the file's format; raised only when a key changes its meaning or goes.
const SCHEMA: u32 = 1;

/// Names the file, where set and not empty.
pub const VARIABLE: &str = "CULLET_COSTS";

/// A measured cost, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Spread {
    /// From the fastest of all rounds.
    pub ns: f64,
    /// The least of it and of what each third of the rounds alone gives.
    pub low: f64,
    /// The most of them.
    pub high: f64,
}

/// Contents of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stored {
    schema: u32,
    /// Version of the program that measured.
    version: String,
    /// The day, in universal time: `2026-03-09`.
    pub date: String,
    /// The processor, the system and the SIMD level.
    pub machine: String,
    /// Whose triangles were measured.
    pub renderer: String,
    /// Rounds of which the fastest counts.
    pub rounds: u32,
    /// Nanoseconds, by the names of [`MeasuredCosts::named`].
    costs: BTreeMap<String, Spread>,
    /// For readers; computed anew here.
    t_over_r: f64,
}

impl Stored {
    /// The costs measured here and now, in the order of [`MeasuredCosts::named`].
    #[must_use]
    pub fn now(spreads: [Spread; 8], rounds: u32) -> Self {
        let mut values = spreads.iter();
        let mut costs = BTreeMap::new();
        let fastest = MeasuredCosts::from_named(|name| {
            let Some(spread) = values.next() else { return f64::NAN };
            costs.insert(name.to_owned(), *spread);
            spread.ns
        });
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            date: today(),
            machine: this_machine(),
            renderer: "cullet's reference renderer on one thread".into(),
            rounds,
            costs,
            t_over_r: fastest.t_over_r(),
        }
    }

    /// The costs.
    pub fn costs(&self) -> MeasuredCosts {
        MeasuredCosts::from_named(|name| self.spread(name).ns)
    }

    /// A cost with its quartiles; NaN for a name that there is not.
    pub fn spread(&self, name: &str) -> Spread {
        let none = Spread { ns: f64::NAN, low: f64::NAN, high: f64::NAN };
        self.costs.get(name).copied().unwrap_or(none)
    }

    /// Whether it was measured on a machine like this one.
    pub fn is_of_here(&self) -> bool {
        self.machine == this_machine()
    }

    /// Reads a file; `None` where there is none.
    pub fn read(path: &Path) -> Result<Option<Self>, StoreError> {
        let fail = |what| StoreError { path: path.to_owned(), what };
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(fail(Damage::Unreadable(e.to_string()))),
        };
        Self::parse(&text).map(Some).map_err(fail)
    }

    /// The costs in the file `named`, else those that are kept, if any are, with the file they are
    /// in. A file that the user names must be sound; one that is only kept is passed over with a
    /// warning that says what is done without.
    pub fn find(
        named: Option<&Path>,
        console: &Console,
        without: &str,
    ) -> Result<Option<(PathBuf, Self)>, Failure> {
        let place = match named {
            Some(path) => Some(Place { path: path.to_owned(), named: true }),
            None => Place::find(),
        };
        let Some(place) = place else { return Ok(None) };
        match Self::read(&place.path) {
            Ok(Some(stored)) => Ok(Some((place.path, stored))),
            Ok(None) if named.is_some() => Err(Failure::input(format!(
                "{}: there is no such file; `cullet calibrate --out {}` measures and writes it",
                place.path.display(),
                shell_word(&place.path.to_string_lossy())
            ))),
            Ok(None) => Ok(None),
            Err(e) if place.named => Err(Failure::input(e)),
            Err(e) => {
                console.note(format!("warning: {without}, for {e}"));
                Ok(None)
            }
        }
    }

    fn parse(text: &str) -> Result<Self, Damage> {
        let value: Value =
            serde_json::from_str(text).map_err(|e| Damage::NotJson(e.to_string()))?;
        // Before all else, for another schema may have other keys.
        match &value["schema"] {
            Value::Null => return Err(Damage::NoSchema),
            schema if schema.as_u64() == Some(u64::from(SCHEMA)) => {}
            schema => return Err(Damage::Schema(schema.to_string())),
        }
        for (name, _) in MeasuredCosts::from_named(|_| 1.0).named() {
            let cost = &value["costs"][name];
            let refuse = |key: &str, allowed| {
                let value = cost[key].to_string();
                Damage::Cost { key: format!("costs.{name}.{key}"), value, allowed }
            };
            let ns = cost["ns"].as_f64().filter(|&ns| ns > 0.0 && ns <= MeasuredCosts::MOST_NS);
            let Some(ns) = ns else {
                return Err(refuse("ns", "nanoseconds above 0, to 1e9"));
            };
            // A cost that a third of the rounds gives may be below zero.
            if !cost["low"].as_f64().is_some_and(|low| low <= ns) {
                return Err(refuse("low", "nanoseconds, at most its ns"));
            }
            if !cost["high"].as_f64().is_some_and(|high| high >= ns) {
                return Err(refuse("high", "nanoseconds, at least its ns"));
            }
        }
        serde_json::from_value(value).map_err(|e| Damage::Shape(e.to_string()))
    }
}

/// A file of costs that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct StoreError {
    path: PathBuf,
    what: Damage,
}

/// Its defect.
#[derive(Clone, Debug, PartialEq)]
enum Damage {
    Unreadable(String),
    NotJson(String),
    NoSchema,
    Schema(String),
    Cost { key: String, value: String, allowed: &'static str },
    Shape(String),
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        write!(f, "{path}: ")?;
        match &self.what {
            Damage::Unreadable(e) => write!(f, "cannot be read: {e}"),
            Damage::NotJson(e) => write!(f, "is not JSON: {e}"),
            Damage::NoSchema => write!(f, "holds no costs: it has no \"schema\""),
            Damage::Schema(s) => write!(f, "has schema {s}; this program reads {SCHEMA}"),
            Damage::Cost { key, value, allowed } => {
                write!(f, "{key} is {value}; it must be a number of {allowed}")
            }
            Damage::Shape(e) => write!(f, "holds no costs: {e}"),
        }?;
        let word = shell_word(&self.path.to_string_lossy());
        write!(f, "; `cullet calibrate --out {word}` measures anew and replaces it")
    }
}

/// Where costs are kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// The user named this very file, so that what is wrong with it is an error.
    pub named: bool,
}

impl Place {
    /// The file that `CULLET_COSTS` names, else that in the user's folder of settings. `None` where
    /// the system tells no such folder.
    pub fn find() -> Option<Self> {
        Self::from(|name| std::env::var_os(name), cfg!(windows))
    }

    fn from(variable: impl Fn(&str) -> Option<OsString>, windows: bool) -> Option<Self> {
        let set = |name| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        if let Some(path) = set(VARIABLE) {
            return Some(Self { path, named: true });
        }
        let settings = if windows {
            set("APPDATA")
        } else {
            // The XDG base directory specification has relative ones ignored.
            let xdg = set("XDG_CONFIG_HOME").filter(|p| p.is_absolute());
            xdg.or_else(|| set("HOME").map(|home| home.join(".config")))
        };
        let path = settings?.join("cullet").join("costs.json");
        Some(Self { path, named: false })
    }
}

fn this_machine() -> String {
    let m = Machine::here();
    format!(
        "{}, {}, {}, {}",
        m.cpu.as_deref().unwrap_or("unknown processor"),
        m.arch,
        m.os,
        m.level
    )
}

fn today() -> String {
    // A clock before 1970 is wrong anyway.
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let [year, month, day] = civil(seconds / 86_400);
    format!("{year}-{month:02}-{day:02}")
}

/// Year, month and day of a day since 1970 in the Gregorian calendar.
fn civil(mut days: u64) -> [u64; 3] {
    let mut year = 1970;
    let leap = |y: u64| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    while days >= 365 + u64::from(leap(year)) {
        days -= 365 + u64::from(leap(year));
        year += 1;
    }
    let february = 28 + u64::from(leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    [year, month, days + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Costs of 1 ns, 2 ns and so on, in the order of the fields.
    fn counted() -> Stored {
        let spread = |i: usize| {
            let ns = (i + 1) as f64;
            Spread { ns, low: ns - 2.0, high: ns * 1.1 }
        };
        Stored::now(std::array::from_fn(spread), 3)
    }

    #[test]
    fn what_is_written_is_read_again() {
        let stored = counted();
        let text = serde_json::to_string(&stored).unwrap();
        assert_eq!(Stored::parse(&text).as_ref(), Ok(&stored));
        assert_eq!(
            stored.costs().named().map(|(_, v)| v),
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        );
        assert_eq!(stored.t_over_r, 0.4);
        assert!(stored.is_of_here());
    }

    #[test]
    fn damage_is_named_with_its_value_and_what_to_try() {
        let changed = |change: &dyn Fn(&mut Value)| {
            let mut value = serde_json::to_value(counted()).unwrap();
            change(&mut value);
            value.to_string()
        };
        let cases = [
            ("{\"schema\": 1,".to_owned(), "is not JSON"),
            ("[]".into(), "has no \"schema\""),
            (changed(&|v| v["schema"] = 7.into()), "has schema 7; this program reads 1"),
            (changed(&|v| v["schema"] = "x".into()), "has schema \"x\""),
            (changed(&|v| v["costs"]["draw"]["ns"] = 0.into()), "costs.draw.ns is 0;"),
            (changed(&|v| v["costs"]["draw"]["ns"] = 1e10.into()), "costs.draw.ns is 10000000000"),
            (changed(&|v| v["costs"]["draw"]["low"] = 9.into()), "costs.draw.low is 9;"),
            (changed(&|v| v["costs"]["draw"]["high"] = 2.into()), "costs.draw.high is 2;"),
            (
                changed(&|v| v["costs"]["cluster_test"] = Value::Null),
                "costs.cluster_test.ns is null",
            ),
            (changed(&|v| v["machine"] = 3.into()), "holds no costs: invalid type"),
        ];
        for (text, expected) in cases {
            let what = Stored::parse(&text).unwrap_err();
            let path = PathBuf::from("/a/costs.json");
            let message = StoreError { path, what }.to_string();
            assert!(message.starts_with("/a/costs.json: "), "{message}");
            assert!(message.contains(expected), "{message}");
            assert!(message.contains("cullet calibrate --out /a/costs.json"), "{message}");
        }
    }

    #[test]
    fn the_place_is_where_the_platform_wants_it() {
        let find = |set: &[(&str, &str)], windows| {
            let get = |name: &str| set.iter().find(|s| s.0 == name).map(|s| s.1.into());
            Place::from(get, windows)
        };
        let own = |path: &str| Some(Place { path: path.into(), named: false });
        let (home, xdg) = (("HOME", "/h"), ("XDG_CONFIG_HOME", "/x"));
        assert_eq!(find(&[home], false), own("/h/.config/cullet/costs.json"));
        assert_eq!(find(&[home, xdg], false), own("/x/cullet/costs.json"));
        let relative = [home, ("XDG_CONFIG_HOME", "x")];
        assert_eq!(find(&relative, false), own("/h/.config/cullet/costs.json"));
        assert_eq!(find(&[("APPDATA", "/a"), home], true), own("/a/cullet/costs.json"));
        assert_eq!(find(&[home], true), None);
        let named = Some(Place { path: "c.json".into(), named: true });
        assert_eq!(find(&[home, (VARIABLE, "c.json")], false), named);
        assert_eq!(find(&[home, (VARIABLE, "")], false), own("/h/.config/cullet/costs.json"));
        assert_eq!(find(&[], false), None);
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        assert_eq!(civil(0), [1970, 1, 1]);
        assert_eq!(civil(59), [1970, 3, 1]);
        assert_eq!(civil(11_016), [2000, 2, 29]);
        assert_eq!(civil(11_017), [2000, 3, 1]);
        assert_eq!(civil(20_088), [2024, 12, 31]);
        assert_eq!(civil(20_089), [2025, 1, 1]);
    }
}
