//! A state as the text of a link, and back: `scene=city&stages.frustum=false`. Only what differs
//! from the default is written, so links stay short and readable.

use serde_json::{Map, Value};
use thiserror::Error;

use crate::state::{OnDevice, State, WIDEST_BUFFER};

/// The longest link that is read.
pub const MAX_LENGTH: usize = 16_384;

/// Why a link is not followed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LinkError {
    /// It is too long.
    #[error("the link has {0} characters; at most {MAX_LENGTH} are read")]
    TooLong(usize),
    /// A part has no `=`, or its percent signs make no text.
    #[error("the link's part '{0}' is not of the form name=value")]
    Part(String),
    /// A name or a value that a state does not have.
    #[error("the link cannot be read: {0}")]
    Value(String),
}

/// The text of a state.
#[must_use]
pub fn to_text(state: &State) -> String {
    let (now, usual) = (value(state), value(&State::default()));
    let mut parts = Vec::new();
    write(&now, &usual, "", &mut parts);
    parts.join("&")
}

/// The state of a text; a leading `#` or `?` is not minded. An empty text is the default.
///
/// # Errors
/// If anything of it is unknown, not finite or out of its range. Whoever shows a link that failed
/// shows the default state, and says why.
pub fn from_text(text: &str) -> Result<State, LinkError> {
    if text.len() > MAX_LENGTH {
        return Err(LinkError::TooLong(text.len()));
    }
    let text = text.trim().trim_start_matches(['#', '?']);
    let parts: Vec<&str> = text.split('&').filter(|p| !p.is_empty()).collect();
    let state = read(&parts)?.map_err(|why| {
        // A value that cannot be is told by its type alone: the part is the one without which all
        // can be.
        let all_but = |n: usize| [&parts[..n], &parts[n + 1..]].concat();
        let few = parts.len() <= MOST_TRIED;
        let invalid = (0..parts.len()).find(|&n| few && matches!(read(&all_but(n)), Ok(Ok(_))));
        let invalid = invalid.map_or(String::new(), |n| format!("{}: ", shortened(parts[n])));
        LinkError::Value(format!("{invalid}{why}"))
    })?;
    check(&state)?;
    Ok(state)
}

/// Most portals that a walk may pass.
const MOST_STEPS: u32 = 4096;
/// Most parts of a link among which the wrong one is looked for.
const MOST_TRIED: usize = 64;

fn shortened(part: &str) -> String {
    part.chars().take(60).collect()
}

/// The state of the parts of a link; or, where they make none, what is wrong with a value.
fn read(parts: &[&str]) -> Result<Result<State, serde_json::Error>, LinkError> {
    let mut all = value(&State::default());
    for part in parts {
        let wrong = || LinkError::Part(shortened(part));
        let (name, raw) = part.split_once('=').ok_or_else(wrong)?;
        let raw = unescape(raw).ok_or_else(wrong)?;
        // Text that is no JSON is a string: `scene=city` reads better than `scene="city"`.
        let new = serde_json::from_str(&raw).unwrap_or(Value::String(raw));
        let (path, leaf) = name.rsplit_once('.').map_or(("", name), |(p, l)| (p, l));
        let mut place = &mut all;
        for step in path.split('.').filter(|s| !s.is_empty()) {
            place = match place {
                Value::Object(map) => {
                    map.entry(step.to_owned()).or_insert_with(|| Value::Object(Map::new()))
                }
                _ => {
                    return Err(LinkError::Value(format!("'{name}' is not the name of a setting")));
                }
            };
            // A camera that is absent by default begins as an empty object.
            if place.is_null() {
                *place = Value::Object(Map::new());
            }
        }
        match place {
            Value::Object(map) => map.insert(leaf.to_owned(), new),
            _ => return Err(LinkError::Value(format!("'{name}' is not the name of a setting"))),
        };
    }
    Ok(serde_json::from_value(all))
}

fn value(state: &State) -> Value {
    // Plain numbers, texts and lists always have a value.
    serde_json::to_value(state).unwrap_or_default()
}

fn write(now: &Value, usual: &Value, name: &str, parts: &mut Vec<String>) {
    if now == usual {
        return;
    }
    if let Value::Object(map) = now {
        let dot = if name.is_empty() { "" } else { "." };
        for (key, now) in map {
            let usual = usual.get(key).unwrap_or(&Value::Null);
            write(now, usual, &format!("{name}{dot}{key}"), parts);
        }
        return;
    }
    let text = match now {
        // A text that reads as JSON must be quoted to stay a text.
        Value::String(s) if serde_json::from_str::<Value>(s).is_err() => s.clone(),
        other => other.to_string(),
    };
    parts.push(format!("{name}={}", escape(&text)));
}

fn check(state: &State) -> Result<(), LinkError> {
    let wrong = |what: &str, v: f64, must: &str| {
        // Three hundred digits say no more than their exponent.
        let v = if v.abs() < 1e6 { v.to_string() } else { format!("{v:e}") };
        Err(LinkError::Value(format!("{what} is {v}; it must be {must}")))
    };
    for rig in [&state.camera, &state.frozen].into_iter().flatten() {
        if let Err((what, v, must)) = rig.check() {
            return wrong(what, v, must);
        }
    }
    let parts = [state.cut.check(), state.study.check(), state.clipping.check()];
    if let Some((what, v, must)) = parts.into_iter().find_map(Result::err) {
        return wrong(what, v, must);
    }
    if !(0.0..=1.0).contains(&state.wipe) {
        return wrong("wipe", f64::from(state.wipe), "between 0 and 1");
    }
    if !(0.0..=1e6).contains(&state.stages.detail_px) {
        return wrong("stages.detail_px", state.stages.detail_px, "between 0 and 1000000 pixels");
    }
    if !(0.0..=1e6).contains(&state.stages.lod_px) {
        return wrong("stages.lod_px", state.stages.lod_px, "between 0 and 1000000 pixels");
    }
    let s = &state.stages;
    if !(0.0..=60.0).contains(&s.lod_fade) {
        return wrong("stages.lod_fade", s.lod_fade, "between 0 and 60 seconds");
    }
    for (what, v) in [("stages.detail_fade", s.detail_fade), ("stages.lod_ball", s.lod_ball)] {
        if !(0.0..=1000.0).contains(&v) {
            return wrong(what, v, "a share, 0 to 1000");
        }
    }
    if !(1..=WIDEST_BUFFER).contains(&s.occlusion_width) {
        return wrong("stages.occlusion_width", f64::from(s.occlusion_width), "1 to 4096 pixels");
    }
    if !(0.0..=1e9).contains(&s.occlusion_budget) {
        let must = "0 to 1000000000 microseconds";
        return wrong("stages.occlusion_budget", f64::from(s.occlusion_budget), must);
    }
    if state.structure.step > MOST_STEPS {
        return wrong("structure.step", f64::from(state.structure.step), "4096 at most");
    }
    if state.device.level >= OnDevice::MOST_LEVELS {
        return wrong("device.level", f64::from(state.device.level), "15 at most");
    }
    if state.structure.level > 64 {
        return wrong("structure.level", f64::from(state.structure.level), "64 at most");
    }
    Ok(())
}

/// Whether a byte may stand in a fragment of an address and is none of ours.
fn plain(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b"-_.~:,/[]*+!".contains(&b)
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for b in text.bytes() {
        if plain(b) {
            out.push(char::from(b));
        } else {
            out.push_str(&format!("%{b:02X}"));
        }
    }
    out
}

fn unescape(text: &str) -> Option<String> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        if b == b'%' {
            let digit = |b: Option<u8>| char::from(b?).to_digit(16);
            let (high, low) = (digit(bytes.next())?, digit(bytes.next())?);
            out.push((high * 16 + low) as u8);
        } else {
            out.push(b);
        }
    }
    String::from_utf8(out).ok()
}
