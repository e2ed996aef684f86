//! `--fail-if`: a limit that ends the run with exit code 5.

use serde_json::Value;

use crate::record::Summary;

/// `KEY OP VALUE`
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FailIf {
    text: String,
    key: Key,
    op: Op,
    value: Limit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Key {
    Tightness,
    FalseCulls,
    All,
    PotentiallyVisible,
    Visible,
    CulledPercent,
}

const KEYS: [(&str, Key); 6] = [
    ("tightness", Key::Tightness),
    ("false_culls", Key::FalseCulls),
    ("all", Key::All),
    ("potentially_visible", Key::PotentiallyVisible),
    ("visible", Key::Visible),
    ("culled_percent", Key::CulledPercent),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    Greater,
    AtLeast,
    Less,
    AtMost,
    Equal,
    Differs,
}

// Longer ones first, so that `>=` is not read as `>`.
const OPS: [(&str, Op); 6] = [
    (">=", Op::AtLeast),
    ("<=", Op::AtMost),
    ("==", Op::Equal),
    ("!=", Op::Differs),
    (">", Op::Greater),
    ("<", Op::Less),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Limit {
    Number(f64),
    /// The baseline's value, times this.
    Baseline(f64),
}

impl FailIf {
    /// Reads an expression; the message says what would be right.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let fail = |what: String| {
            let keys = KEYS.map(|k| k.0).join(", ");
            format!("--fail-if '{text}': {what}; it is KEY OP VALUE, with a KEY of {keys}")
        };
        // The leftmost operator, and of those that start there the longest.
        let (at, symbol, op) = OPS
            .iter()
            .filter_map(|&(s, op)| text.find(s).map(|at| (at, s, op)))
            .min_by_key(|&(at, s, _)| (at, std::cmp::Reverse(s.len())))
            .ok_or_else(|| fail("there is no comparison in it".into()))?;
        let (name, value) = (text[..at].trim(), text[at + symbol.len()..].trim());
        let key = KEYS
            .iter()
            .find(|k| k.0 == name)
            .map(|k| k.1)
            .ok_or_else(|| fail(format!("'{name}' is not a key")))?;
        let value = limit(value).ok_or_else(|| fail(format!("'{value}' is not a value")))?;
        Ok(Self { text: text.to_owned(), key, op, value })
    }

    /// Whether it needs a baseline.
    pub(crate) fn needs_baseline(&self) -> bool {
        matches!(self.value, Limit::Baseline(_))
    }

    /// Whether it holds, as a sentence that says so. A figure that is not there (the tightness of
    /// nothing) holds nothing.
    pub(crate) fn holds(&self, summary: &Summary, baseline: Option<&Value>) -> Option<String> {
        let value = now(self.key, summary)?;
        let limit = match self.value {
            Limit::Number(n) => n,
            Limit::Baseline(factor) => factor * then(self.key, baseline?)?,
        };
        let holds = match self.op {
            Op::Greater => value > limit,
            Op::AtLeast => value >= limit,
            Op::Less => value < limit,
            Op::AtMost => value <= limit,
            Op::Equal => value == limit,
            Op::Differs => value != limit,
        };
        holds.then(|| {
            let [value, limit] = told_apart(value, limit);
            format!("--fail-if '{}' holds: it is {value}, against {limit}", self.text)
        })
    }
}

/// Two figures with four digits, or with as many more as tell them apart; whole numbers in full.
fn told_apart(a: f64, b: f64) -> [String; 2] {
    let short = |v: f64, digits: usize| {
        if v.fract() == 0.0 {
            return v.to_string();
        }
        let before = v.abs().log10().floor().max(0.0) as usize + 1;
        // Rounded, then as short as that number is.
        let text = format!("{v:.0$}", digits.saturating_sub(before).max(1));
        text.parse().map_or(text, |v: f64| v.to_string())
    };
    let texts = (4..17).map(|digits| [a, b].map(|v| short(v, digits)));
    let apart = |t: &[String; 2]| {
        a == b || (t[0] != t[1] && t[0].parse() != Ok(b) && t[1].parse() != Ok(a))
    };
    texts.into_iter().find(apart).unwrap_or_else(|| [a, b].map(|v| v.to_string()))
}

fn limit(text: &str) -> Option<Limit> {
    let Some(rest) = text.strip_prefix("baseline") else {
        let number: f64 = text.parse().ok()?;
        return number.is_finite().then_some(Limit::Number(number));
    };
    let rest: String = rest.split_whitespace().collect();
    if rest.is_empty() {
        return Some(Limit::Baseline(1.0));
    }
    let percent: f64 = rest.strip_suffix('%')?.parse().ok()?;
    let signed = rest.starts_with(['+', '-']) && percent.is_finite();
    signed.then(|| Limit::Baseline(1.0 + percent / 100.0))
}

fn culled_percent(all: f64, left: f64) -> Option<f64> {
    (all > 0.0).then(|| (all - left) / all * 100.0)
}

fn now(key: Key, s: &Summary) -> Option<f64> {
    let t = s.triangles;
    match key {
        Key::Tightness => s.tightness,
        Key::FalseCulls => Some(s.false_culls as f64),
        Key::All => Some(t.all as f64),
        Key::PotentiallyVisible => Some(t.potentially_visible as f64),
        Key::Visible => t.visible.map(|v| v as f64),
        Key::CulledPercent => culled_percent(t.all as f64, t.potentially_visible as f64),
    }
}

fn then(key: Key, report: &Value) -> Option<f64> {
    let s = &report["summary"];
    let t = &s["triangles"];
    match key {
        Key::Tightness => s["tightness"].as_f64(),
        Key::FalseCulls => s["false_culls"].as_f64(),
        Key::All => t["all"].as_f64(),
        Key::PotentiallyVisible => t["potentially_visible"].as_f64(),
        Key::Visible => t["visible"].as_f64(),
        Key::CulledPercent => {
            culled_percent(t["all"].as_f64()?, t["potentially_visible"].as_f64()?)
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::record::Counts;

    fn summary() -> Summary {
        let mut s = Summary::of(&[]);
        s.triangles = Counts { all: 1000, potentially_visible: 300, visible: Some(100) };
        s.tightness = Some(3.0);
        s
    }

    fn holds(text: &str) -> bool {
        let baseline = json!({"summary": {"tightness": 2.8, "triangles":
            {"all": 1000, "potentially_visible": 290, "visible": 100}}});
        FailIf::parse(text).unwrap().holds(&summary(), Some(&baseline)).is_some()
    }

    #[test]
    fn each_comparison() {
        assert!(!holds("tightness>3") && holds("tightness >= 3") && holds("tightness==3"));
        assert!(holds("tightness<3.1") && holds("tightness<=3") && !holds("tightness!=3"));
        assert!(holds("culled_percent<71") && !holds("culled_percent<70"));
        assert!(!holds("false_culls>0"));
    }

    #[test]
    fn against_the_baseline() {
        assert!(holds("tightness>baseline") && holds("tightness > baseline+5%"));
        assert!(!holds("tightness>baseline+10%"));
        assert!(holds("potentially_visible>baseline - 0%") && holds("visible==baseline"));
    }

    #[test]
    fn figures_are_short_and_told_apart() {
        let told = |a, b| told_apart(a, b).join(" ");
        assert_eq!(told(3.791_111_111_111_111_3, 3.0), "3.791 3");
        assert_eq!(told(70.000_000_1, 70.0), "70.0000001 70");
        assert_eq!(told(1_234_567.0, 1e6), "1234567 1000000");
        assert_eq!(told(12_345.678, 1.0), "12345.7 1");
        assert_eq!(told(0.05, 2.8 * 1.05), "0.05 2.94");
        assert_eq!(told(0.1 + 0.2, 0.3), "0.30000000000000004 0.3");
        assert_eq!(told(2.5, 2.5), "2.5 2.5");
        let text = FailIf::parse("tightness>1.123456789").unwrap().holds(&summary(), None).unwrap();
        assert!(text.ends_with("it is 3, against 1.123"), "{text}");
    }

    #[test]
    fn what_is_not_there_holds_nothing() {
        let f = FailIf::parse("tightness>1").unwrap();
        assert_eq!(f.holds(&Summary::of(&[]), None), None);
        let f = FailIf::parse("all>baseline").unwrap();
        assert!(f.needs_baseline());
        assert_eq!(f.holds(&summary(), None), None);
    }

    #[test]
    fn mistakes_are_named() {
        let bad = [
            "tightness",
            "tight>3",
            "tightness>",
            "tightness>x",
            "all>baseline+5",
            ">3",
            "all>nan",
        ];
        for text in bad {
            assert!(FailIf::parse(text).unwrap_err().contains("KEY OP VALUE"), "{text}");
        }
    }
}
