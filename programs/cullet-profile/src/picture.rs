//! The chain of a frame as a picture: three stages, what doubling each link costs, and what culling
//! gives. Pure computation.

use std::fmt::Write as _;

use cullet_command::html::{escape, hex};
use cullet_draw::palette::{CHALK, DROPPED, INK, PAPER, PROVED, SUBJECT, UNSEEN};

use super::link::Link;
use super::profile::Profile;

/// The stages of the pipeline in the order of the work, what belongs to each, and its links.
const STAGES: [(&str, &str, &[Link]); 3] = [
    ("application", "culls, records, uploads", &[Link::Cpu, Link::Bus]),
    ("geometry", "transforms triangles", &[Link::Transform]),
    ("rasteriser", "fills pixels", &[Link::Fill]),
];

const WIDTH: f64 = 760.0;
/// Widths of a stage and of the gap between two.
const BOX: f64 = 224.0;
const GAP: f64 = 24.0;
const LEFT: f64 = 20.0;
/// A bar of 100 %.
const BAR: f64 = BOX - 24.0;

/// An SVG of a profile.
#[must_use]
pub fn picture(profile: &Profile) -> String {
    let top = 260.0;
    let height = top + 60.0 + 26.0 * profile.relief.len() as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"14\" fill=\"{}\">\n",
        hex(INK)
    );
    let Profile { scene, frame_ms, adapter, .. } = profile;
    let verdict = profile.verdict();
    let _ = writeln!(out, "<title>{}: {}</title>", escape(scene), escape(&verdict));
    let _ = writeln!(out, "<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"{}\"/>", hex(PAPER));
    text(&mut out, [LEFT, 32.0], "font-size=\"17\"", &verdict);
    let what = format!("{scene}, {frame_ms:.2} ms a frame on {adapter}");
    text(&mut out, [LEFT, 56.0], &fill(DROPPED), &what);
    for (at, (name, does, links)) in STAGES.iter().enumerate() {
        let x = LEFT + at as f64 * (BOX + GAP);
        stage(&mut out, profile, [x, 80.0], (name, does, links));
        if at > 0 {
            let (from, to) = (x - GAP + 2.0, x - 4.0);
            let _ = writeln!(
                out,
                "<path d=\"M{from} 150 H{to} m-7 -5 l7 5 l-7 5\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>",
                hex(INK)
            );
        }
    }
    reliefs(&mut out, profile, top);
    out.push_str("</svg>\n");
    out
}

/// A stage of the pipeline: a bar for each link, and where its value lies.
fn stage(
    out: &mut String,
    profile: &Profile,
    [x, y]: [f64; 2],
    (name, does, links): (&str, &str, &[Link]),
) {
    let limits = links.iter().any(|link| link.name() == profile.limit);
    let (edge, width) = if limits { (SUBJECT, 3) } else { (DROPPED, 1) };
    let _ = writeln!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{BOX}\" height=\"140\" rx=\"6\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"{width}\"/>",
        hex(edge)
    );
    let left = x + 12.0;
    text(out, [left, y + 24.0], "font-weight=\"bold\"", name);
    text(out, [left, y + 42.0], &fill(DROPPED), does);
    for (row, link) in links.iter().enumerate() {
        let y = y + 66.0 + row as f64 * 38.0;
        let (value, interval) = (profile.elasticity.of(*link), profile.interval.of(*link));
        let long = |v: f64| v.clamp(0.0, 1.0) * BAR;
        let named = link.name() == profile.limit;
        text(out, [left, y], "", &format!("{}: {:.0} %", link.name(), value * 100.0));
        rect(out, [left, y + 6.0], [BAR, 10.0], CHALK);
        rect(out, [left, y + 6.0], [long(value), 10.0], if named { SUBJECT } else { DROPPED });
        let [low, high] = interval.map(|v| left + long(v));
        let _ = writeln!(
            out,
            "<path d=\"M{low:.1} {0} v6 m0 -3 H{high:.1} m0 -3 v6\" fill=\"none\" stroke=\"{1}\"/>",
            y + 8.0,
            hex(INK)
        );
    }
}

/// Writes the predicted and measured gains of each kind of culling.
fn reliefs(out: &mut String, profile: &Profile, top: f64) {
    if profile.relief.is_empty() {
        return;
    }
    text(out, [LEFT, top], "font-weight=\"bold\"", "culling, and what of a frame it takes away");
    let (bars, long) = (LEFT + 110.0, 400.0);
    let key = [("measured", PROVED, 310.0), ("predicted", UNSEEN, 420.0)];
    for (word, color, at) in key {
        rect(out, [bars + at, top - 10.0], [12.0, 12.0], color);
        text(out, [bars + at + 18.0, top], "", word);
    }
    for (row, own) in profile.relief.iter().enumerate() {
        let y = top + 30.0 + 26.0 * row as f64;
        let share = |percent: f64| percent.clamp(0.0, 100.0) / 100.0 * long;
        text(out, [LEFT, y], "", &own.stage);
        rect(out, [bars, y - 11.0], [long, 14.0], CHALK);
        rect(out, [bars, y - 11.0], [share(own.measured_percent), 9.0], PROVED);
        rect(out, [bars, y - 2.0], [share(own.predicted_percent), 5.0], UNSEEN);
        let words = format!("{:.0} %: {:.2} times as fast", own.measured_percent, own.factor());
        text(out, [bars + long + 12.0, y], "", &words);
    }
}

fn fill(color: [u8; 3]) -> String {
    format!("fill=\"{}\"", hex(color))
}

fn text(out: &mut String, [x, y]: [f64; 2], style: &str, words: &str) {
    let _ = writeln!(out, "<text x=\"{x}\" y=\"{y}\" {style}>{}</text>", escape(words));
}

fn rect(out: &mut String, [x, y]: [f64; 2], [width, height]: [f64; 2], color: [u8; 3]) {
    let _ = writeln!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{width:.1}\" height=\"{height}\" fill=\"{}\"/>",
        hex(color)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::ByLink;
    use crate::relief::Relief;

    #[test]
    fn names_from_files_do_no_harm_and_broken_numbers_stay_on_the_paper() {
        let nothing = [f64::NEG_INFINITY, f64::INFINITY];
        let profile = Profile {
            schema: 1,
            scene: "<script>".to_owned(),
            adapter: "a & b".to_owned(),
            software: true,
            limit: "mixed".to_owned(),
            frame_ms: 0.0,
            rounds: 0,
            elasticity: ByLink { fill: 0.0, transform: -3.0, bus: 40.0, cpu: 1.0 },
            interval: ByLink { fill: nothing, transform: nothing, bus: nothing, cpu: nothing },
            relief: vec![Relief {
                stage: "frustum".to_owned(),
                predicted_percent: 278.0,
                measured_percent: -20.0,
                interval_percent: [-30.0, -10.0],
            }],
        };
        let drawn = picture(&profile);
        assert!(drawn.contains("&lt;script&gt;") && drawn.contains("a &amp; b"));
        assert!(!drawn.contains("<script>") && !drawn.contains("inf") && !drawn.contains("NaN"));
        let widths = drawn.split("width=\"").skip(1).filter_map(|s| s.split('"').next());
        for width in widths.map(|w| w.parse::<f64>().unwrap()) {
            assert!((0.0..=WIDTH).contains(&width), "{width}");
        }
    }
}
