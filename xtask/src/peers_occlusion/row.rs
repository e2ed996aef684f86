//! Rows of the table: what is run, and what came of it in all rounds.

/// Who draws, and with which options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Who {
    Prototype(&'static [&'static str]),
    Ours(&'static [&'static str]),
}

/// Sides that triangles hide from: rows of the same number are held against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sides {
    One,
    Two,
}

/// A way to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) name: &'static str,
    pub(crate) sides: Sides,
    pub(crate) who: Who,
    /// Only of scenes whose meshes are convex.
    pub(crate) convex: bool,
}

const fn way(name: &'static str, sides: Sides, who: Who) -> Way {
    Way { name, sides, who, convex: false }
}

/// The ways, as the prototype's description names them.
pub(crate) const WAYS: [Way; 7] = [
    way("128 faces", Sides::One, Who::Prototype(&["-lg", "0"])),
    way("thrift 16", Sides::One, Who::Prototype(&["-lg", "0", "-th", "16"])),
    way("direct", Sides::One, Who::Prototype(&["-d", "2"])),
    way("cullet, surfaces", Sides::One, Who::Ours(&["--triangles", "--one-sided"])),
    Way { convex: true, ..way("cullet, outlines", Sides::One, Who::Ours(&["--one-sided"])) },
    way("direct", Sides::Two, Who::Prototype(&["-2", "-d", "2"])),
    way("cullet, surfaces", Sides::Two, Who::Ours(&["--triangles"])),
];

/// What one run gives: means over the views.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figures {
    /// Drawing, without what is hidden by then: of each view the fastest pass.
    pub(crate) ms: f64,
    /// The same, the median pass.
    pub(crate) median_ms: f64,
    /// How many per cent of what the first reference calls hidden were found.
    pub(crate) found: f64,
    /// For each reference how many were culled of how many that it sees.
    pub(crate) false_culls: Vec<(u64, u64)>,
}

/// A way at a SIMD level on a scene, with its rounds.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) scene: String,
    pub(crate) level: &'static str,
    pub(crate) way: Way,
    pub(crate) rounds: Vec<Figures>,
}

impl Row {
    /// The fastest round: other work only adds time.
    pub(crate) fn ms(&self) -> f64 {
        self.rounds.iter().map(|f| f.ms).fold(f64::INFINITY, f64::min)
    }

    /// The median of the rounds' medians.
    fn median_ms(&self) -> f64 {
        let mut all: Vec<f64> = self.rounds.iter().map(|f| f.median_ms).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// Whether each round gave the same answers.
    pub(crate) fn is_steady(&self) -> bool {
        let answers = |f: &Figures| (f.found.to_bits(), f.false_culls.clone());
        self.rounds.windows(2).all(|w| answers(&w[0]) == answers(&w[1]))
    }

    /// Whether something visible was culled.
    pub(crate) fn is_wrong(&self) -> bool {
        self.rounds.iter().any(|f| f.false_culls.iter().any(|c| c.0 > 0))
    }

    /// Its line. `rows` are all, among which the prototype's fastest is found.
    fn line(&self, rows: &[Self]) -> Option<String> {
        let last = self.rounds.last()?;
        let alike = |r: &&Self| {
            (&r.scene, r.level, r.way.sides) == (&self.scene, self.level, self.way.sides)
                && matches!(r.way.who, Who::Prototype(_))
        };
        let fastest = rows.iter().filter(alike).map(Self::ms).fold(f64::INFINITY, f64::min);
        let list = |of: fn(&(u64, u64)) -> u64| {
            let all: Vec<String> = last.false_culls.iter().map(|c| of(c).to_string()).collect();
            all.join("/")
        };
        Some(format!(
            "{:<10} {:<5} {:<17} {:<7} {:>8.3} {:>8.3} {:>6.2} {:>8.2} {:>9} of {}",
            self.scene,
            match self.way.sides {
                Sides::One => "one",
                Sides::Two => "two",
            },
            self.way.name,
            self.level,
            self.ms(),
            self.median_ms(),
            self.ms() / fastest,
            last.found,
            list(|c| c.0),
            list(|c| c.1)
        ))
    }
}

/// The whole table, a line each.
pub(crate) fn table(rows: &[Row]) -> Vec<String> {
    let heading = format!(
        "{:<10} {:<5} {:<17} {:<7} {:>8} {:>8} {:>6} {:>8} {:>9}",
        "scene", "sides", "row", "level", "ms", "(median)", "ratio", "found %", "false"
    );
    std::iter::once(heading).chain(rows.iter().filter_map(|row| row.line(rows))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(way: Way, ms: &[f64]) -> Row {
        let figures = |&ms: &f64| Figures {
            ms,
            median_ms: ms * 2.0,
            found: 98.5,
            false_culls: vec![(0, 10), (0, 12)],
        };
        let rounds = ms.iter().map(figures).collect();
        Row { scene: "castle".into(), level: "avx2", way, rounds }
    }

    #[test]
    fn a_ratio_is_to_the_fastest_of_the_prototype_with_as_many_sides() {
        let rows = [
            row(WAYS[0], &[0.5, 0.4, 0.9]),
            row(WAYS[1], &[0.2, 0.3, 0.8]),
            row(WAYS[3], &[0.1, 0.3, 0.2]),
            row(WAYS[5], &[1.0]),
            row(WAYS[6], &[0.7]),
        ];
        let lines = table(&rows);
        let ratios: Vec<&str> =
            lines[1..].iter().map(|l| l.split_whitespace().rev().nth(4).unwrap()).collect();
        assert_eq!(ratios, ["2.00", "1.00", "0.50", "1.00", "0.70"], "{lines:#?}");
        assert!(lines[3].contains("0.100    0.400") && lines[3].ends_with("0/0 of 10/12"));
    }

    #[test]
    fn a_false_cull_or_another_answer_in_any_round_is_seen() {
        let mut one = row(WAYS[0], &[0.5, 0.4]);
        assert!(one.is_steady() && !one.is_wrong());
        one.rounds[0].false_culls[1].0 = 1;
        assert!(!one.is_steady() && one.is_wrong());
    }
}
