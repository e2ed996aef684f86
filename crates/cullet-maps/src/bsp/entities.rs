//! The entities of a map: a text of keys and values, and what it says of starts and lamps.

use cullet::math;
use cullet_io::ErrorKind;

/// Intensity of a lamp that states none.
const LIGHT: f64 = 300.0;

/// An object of a map: its keys and values, as they are written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entity {
    /// Keys and their values, in the order of the file.
    pub pairs: Vec<(String, String)>,
}

/// A place where a player appears.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Class of the entity: `info_player_start` and the like.
    pub class: String,
    /// Origin of the player, in the map's axes.
    pub origin: [f64; 3],
    /// Direction of the view, of unit length, in the map's axes.
    pub direction: [f64; 3],
}

/// A lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Class of the entity: `light`, `light_torch_small_walltorch` and the like.
    pub class: String,
    /// Its place, in the map's axes.
    pub origin: [f64; 3],
    /// Intensity, in the units of the map's light compiler; 300 where the map states none.
    pub intensity: f64,
    /// Colour, each component from 0 to 1; white where the map states none.
    pub color: [f64; 3],
}

impl Entity {
    /// The value of a key, told without regard to small letters and capitals; the last, where there
    /// are several.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        let found = self.pairs.iter().rev().find(|(k, _)| k.eq_ignore_ascii_case(key));
        found.map(|(_, value)| value.as_str())
    }

    /// Its class; empty if it has none.
    #[must_use]
    pub fn class(&self) -> &str {
        self.get("classname").unwrap_or_default()
    }

    /// Its place, in the map's axes; `None` if it has none, or none that is three finite numbers.
    #[must_use]
    pub fn origin(&self) -> Option<[f64; 3]> {
        self.vector("origin")
    }

    /// Pitch (down is positive), yaw and roll in degrees: its `mangle` or `angles`, or its `angle`
    /// as the yaw. 0 where it has none. An angle of −1 is up and of −2 down.
    #[must_use]
    pub fn angles(&self) -> [f64; 3] {
        if let Some(angles) = self.vector("mangle").or_else(|| self.vector("angles")) {
            return angles;
        }
        match self.number("angle") {
            Some(-1.0) => [-90.0, 0.0, 0.0],
            Some(-2.0) => [90.0, 0.0, 0.0],
            angle => [0.0, angle.unwrap_or(0.0), 0.0],
        }
    }

    /// Whether one may see through its brushes: an `alpha` below 1, or a `rendermode` of Half-Life
    /// other than 0 (normal) and 4 (with a mask).
    pub(crate) fn is_seen_through(&self) -> bool {
        let mode = self.get("rendermode").unwrap_or("0").trim();
        !matches!(mode, "" | "0" | "4") || self.number("alpha").is_some_and(|a| a != 0.0 && a < 1.0)
    }

    /// Direction of the view of [`angles`](Self::angles), in the map's axes.
    #[must_use]
    pub fn direction(&self) -> [f64; 3] {
        let angles = self.angles().map(|degrees| math::sin_cos(degrees.to_radians()));
        let [(up, ahead), (left, front), _] = angles;
        [ahead * front, ahead * left, -up]
    }

    /// Number of the brush model that it places (`"model" "*3"`).
    #[must_use]
    pub fn brush_model(&self) -> Option<u32> {
        self.get("model")?.strip_prefix('*')?.parse().ok()
    }

    /// The start that it is, if it is one.
    #[must_use]
    pub fn start(&self) -> Option<Start> {
        let class = self.class();
        let lower = class.to_ascii_lowercase();
        let is_start = lower.starts_with("info_player_")
            || lower == "info_intermission"
            || lower == "testplayerstart"
            || lower.starts_with("team_ctf_") && lower.ends_with("player")
            || lower.starts_with("team_ctf_") && lower.ends_with("spawn");
        let origin = self.origin()?;
        is_start.then(|| Start { class: class.into(), origin, direction: self.direction() })
    }

    /// The lamp that it is, if it is one.
    #[must_use]
    pub fn lamp(&self) -> Option<Lamp> {
        let class = self.class();
        let origin = self.origin()?;
        let is_lamp = class.get(..5).is_some_and(|c| c.eq_ignore_ascii_case("light"));
        is_lamp.then(|| {
            let mut color = self.vector("_color").or_else(|| self.vector("color"));
            // Written from 0 to 1, or from 0 to 255.
            if let Some(bytes) = color.as_mut().filter(|c| c.iter().any(|v| *v > 1.0)) {
                *bytes = bytes.map(|v| v / 255.0);
            }
            let intensity = self.number("light").or_else(|| self.number("_light"));
            Lamp {
                class: class.into(),
                origin,
                intensity: intensity.unwrap_or(LIGHT),
                color: color.unwrap_or([1.0; 3]).map(|v| v.clamp(0.0, 1.0)),
            }
        })
    }

    /// The first number of a value, if it is finite.
    fn number(&self, key: &str) -> Option<f64> {
        let word = self.get(key)?.split_ascii_whitespace().next()?;
        word.parse().ok().filter(|v: &f64| v.is_finite())
    }

    fn vector(&self, key: &str) -> Option<[f64; 3]> {
        let mut words = self.get(key)?.split_ascii_whitespace();
        let mut next = || words.next()?.parse().ok().filter(|v: &f64| v.is_finite());
        Some([next()?, next()?, next()?])
    }
}

/// Words and signs of the text, with the lines on which they begin.
struct Words<'a> {
    left: &'a [u8],
    line: usize,
}

enum Word {
    Open,
    Close,
    Text(String),
}

impl Words<'_> {
    fn error(&self, message: impl Into<String>) -> ErrorKind {
        ErrorKind::invalid(format!("lump entities, line {}", self.line), message)
    }

    fn skip(&mut self, count: usize) {
        let (passed, left) = self.left.split_at(count);
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        self.left = left;
    }

    fn next(&mut self) -> Result<Option<Word>, ErrorKind> {
        loop {
            let blank = self.left.iter().take_while(|b| **b <= b' ').count();
            self.skip(blank);
            match self.left {
                [] => return Ok(None),
                [b'/', b'/', ..] => {
                    let line = self.left.iter().take_while(|b| **b != b'\n').count();
                    self.skip(line);
                }
                [b'{', ..] => {
                    self.skip(1);
                    return Ok(Some(Word::Open));
                }
                [b'}', ..] => {
                    self.skip(1);
                    return Ok(Some(Word::Close));
                }
                [b'"', rest @ ..] => {
                    let Some(length) = rest.iter().position(|b| *b == b'"') else {
                        return Err(self.error("a text has no closing quotation mark"));
                    };
                    let text = String::from_utf8_lossy(&rest[..length]).into_owned();
                    self.skip(length + 2);
                    return Ok(Some(Word::Text(text)));
                }
                bare => {
                    let end = |b: &u8| *b <= b' ' || matches!(*b, b'{' | b'}' | b'"');
                    let length = bare.iter().position(end).unwrap_or(bare.len());
                    let text = String::from_utf8_lossy(&bare[..length]).into_owned();
                    self.skip(length);
                    return Ok(Some(Word::Text(text)));
                }
            }
        }
    }
}

/// Reads entities: `{ "key" "value" ... }`, one after the other, up to the first zero byte.
///
/// # Errors
/// The first defect and its line: a brace or a quotation mark that is not closed, a key without a
/// value, text outside.
pub(crate) fn parse(bytes: &[u8]) -> Result<Vec<Entity>, ErrorKind> {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let mut words = Words { left: &bytes[..end], line: 1 };
    let mut entities = Vec::new();
    while let Some(word) = words.next()? {
        match word {
            Word::Open => {}
            Word::Close => return Err(words.error("found }, expected {")),
            Word::Text(text) => {
                return Err(words.error(format!("found \"{}\", expected {{", brief(&text))));
            }
        }
        let mut entity = Entity::default();
        loop {
            let key = match words.next()? {
                Some(Word::Close) => break,
                Some(Word::Text(key)) => key,
                Some(Word::Open) => return Err(words.error("found {, expected a key or }")),
                None => return Err(words.error("it ends within an entity; } is missing")),
            };
            match words.next()? {
                Some(Word::Text(value)) => entity.pairs.push((key, value)),
                _ => return Err(words.error(format!("the key \"{}\" has no value", brief(&key)))),
            }
        }
        entities.push(entity);
    }
    Ok(entities)
}

fn brief(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entities_are_keys_and_values() {
        let text = b"// a comment\n{\n\"classname\" \"worldspawn\"\n\"message\" \"a { b }\"\n}\n{ \
            \"classname\" \"Light_torch\" \"origin\" \"1 -2.5 3e1\" \"light\" \"150\" \"_color\" \"255 0 51\"\n}\
            {classname info_player_start origin \"4 5 6\" angle 90}\n\0\0junk";
        let entities = parse(text).unwrap();
        assert_eq!(entities.len(), 3);
        assert_eq!(
            (entities[0].class(), entities[0].get("MESSAGE")),
            ("worldspawn", Some("a { b }"))
        );
        let lamp = entities[1].lamp().unwrap();
        assert_eq!((lamp.origin, lamp.intensity), ([1.0, -2.5, 30.0], 150.0));
        assert_eq!(lamp.color, [1.0, 0.0, 0.2]);
        assert!(entities[1].start().is_none() && entities[2].lamp().is_none());
        let start = entities[2].start().unwrap();
        assert_eq!(start.origin, [4.0, 5.0, 6.0]);
        assert!((start.direction[1] - 1.0).abs() < 1e-12 && start.direction[0].abs() < 1e-12);
    }

    #[test]
    fn angles_are_told_in_three_ways() {
        let of = |key: &str, value: &str| {
            Entity { pairs: vec![(key.into(), value.into())] }.direction().map(f64::round)
        };
        assert_eq!(of("angle", "180"), [-1.0, 0.0, -0.0]);
        assert_eq!(of("angle", "-1"), [0.0, 0.0, 1.0]);
        assert_eq!(of("angle", "-2"), [0.0, 0.0, -1.0]);
        assert_eq!(of("mangle", "90 0 0"), [0.0, 0.0, -1.0]);
        assert_eq!(of("angles", "0 90 0"), [0.0, 1.0, -0.0]);
        assert_eq!(of("angles", "0 x 0"), [1.0, 0.0, -0.0]);
    }

    #[test]
    fn defects_name_their_line() {
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(
            error("{\n\"a\" \"b\"\n"),
            "lump entities, line 3: it ends within an entity; } is missing"
        );
        assert_eq!(error("{\n\"a\" }"), "lump entities, line 2: the key \"a\" has no value");
        assert!(error("{ \"a").contains("line 1: a text has no closing"));
        assert!(error("\n}").contains("line 2: found }, expected {"));
        assert!(error("x { }").contains("found \"x\", expected {"));
        assert!(error("{ { } }").contains("expected a key or }"));
        assert_eq!(parse(b"").unwrap(), []);
    }
}
