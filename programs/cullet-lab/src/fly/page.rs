//! The page of a flight: one HTML file without scripts, links or anything else to fetch.

use std::fmt::Write;

use cullet_command::console::{count, digits, grouped};
use cullet_command::html::escape;

use super::record::{Frame, Record, mebibytes};

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 70.0;

/// Value of a frame that is drawn.
type Value = fn(&Frame) -> f64;

/// The page.
pub(super) fn page(r: &Record, frames: &[Frame]) -> String {
    let world = escape(&r.world);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"referrer\" content=\"no-referrer\">\
         <title>{world} · cullet fly</title><style>\n{}</style></head><body><main>\n\
         <p class=\"kicker\">cullet fly · <b>{world}</b> · {} at 60 a second</p>\n\
         <h1>{} in {} MiB.</h1>\n\
         <p class=\"lead\">At the most {} of them were in memory, in {}. No frame waited for a load: to look took {} ms at the most.</p>\n",
        cullet_cli::STYLE,
        count(r.frames as u64, "frame", "frames"),
        count(r.instances, "instance", "instances"),
        mebibytes(r.most_bytes),
        grouped(r.most_instances.into()),
        count(r.most_tiles as u64, "tile", "tiles"),
        digits(r.longest_look_ms),
    );
    let badge = match (r.false_culls, r.checked) {
        (0, 0) => "<span class=\"badge warn\">not verified</span>".to_owned(),
        (0, n) => format!(
            "<span class=\"badge good\">Verified in {}: nothing visible of what is loaded was lost</span>",
            count(n.into(), "frame", "frames")
        ),
        (n, _) => format!("<span class=\"badge bad\">{n} visible and yet culled</span>"),
    };
    out.push_str(&badge);
    if !r.complete {
        out.push_str(" <span class=\"badge warn\">stopped early</span>");
    }
    let figure = |out: &mut String, value: String, words: &str| {
        let _ = write!(out, "<div class=\"figure\"><b>{value}</b><span>{words}</span></div>");
    };
    out.push_str("<div class=\"figures\">");
    figure(&mut out, format!("{} ms", digits(r.low.median_ms)), "cull a view, low, in the median");
    figure(
        &mut out,
        format!("{} ms", digits(r.high.median_ms)),
        "cull a view, high, in the median",
    );
    figure(
        &mut out,
        format!("{} of {} MiB", mebibytes(r.most_bytes), mebibytes(r.budget)),
        "counted at the most, of the budget",
    );
    if let Some(peak) = r.peak_bytes {
        figure(&mut out, format!("{} MiB", mebibytes(peak)), "the process took at the most");
    }
    figure(&mut out, grouped(r.loaded), "tiles were loaded");
    out.push_str("</div>\n<h2>Along the way</h2><p class=\"sub\">Half of the way low, half of it high; the line between them is dashed.</p>");
    let curves: [(&str, Value); 6] = [
        ("Culling a view, in ms", |f| f.cull_ms),
        ("Memory counted, in MiB", |f| f.bytes as f64 / f64::from(1 << 20)),
        ("Instances loaded", |f| f.instances.into()),
        ("Instances visible", |f| f.visible as f64),
        ("Triangles drawn", |f| f.triangles as f64),
        ("Tiles wanted and not there yet", |f| f.wanted as f64),
    ];
    for (title, value) in curves {
        let curve = curve(title, frames, value);
        let _ = writeln!(out, "<div class=\"panel\"><h3>{title}</h3>{curve}</div>");
    }
    if !r.failed.is_empty() {
        out.push_str("<h2>Tiles that could not be loaded</h2><ul>");
        r.failed.iter().for_each(|failed| {
            let _ = write!(out, "<li>{}</li>", escape(failed));
        });
        out.push_str("</ul>");
    }
    out.push_str("</main></body></html>\n");
    out
}

/// A value along the way as SVG: between its smallest and its largest of each group of frames, so
/// that no peak is lost.
fn curve(title: &str, frames: &[Frame], value: Value) -> String {
    let most = frames.iter().map(value).fold(0.0, f64::max).max(1e-9);
    let end = frames.last().map_or(1.0, |f| f.seconds).max(1e-9);
    let x = |seconds: f64| LEFT + seconds / end * (WIDTH - LEFT - 10.0);
    let y = |v: f64| 10.0 + (1.0 - v / most) * HEIGHT;
    let mut points = String::new();
    for group in frames.chunks(frames.len().div_ceil(300).max(1)) {
        let low = group.iter().map(value).fold(f64::INFINITY, f64::min);
        let high = group.iter().map(value).fold(0.0, f64::max);
        let _ =
            write!(points, "{0:.1},{1:.1} {0:.1},{2:.1} ", x(group[0].seconds), y(low), y(high));
    }
    let turn = frames.iter().find(|f| f.high).map_or(end, |f| f.seconds);
    let (zero, turn, label) = (y(0.0), x(turn), LEFT - 8.0);
    let (bottom, most, end) = (HEIGHT + 32.0, shown(most), digits(end));
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{title}: at the most {most}\">\
         <line class=\"grid\" x1=\"{LEFT}\" x2=\"{WIDTH}\" y1=\"{zero:.1}\" y2=\"{zero:.1}\"/>\
         <line class=\"grid\" x1=\"{LEFT}\" x2=\"{WIDTH}\" y1=\"10\" y2=\"10\"/>\
         <line class=\"perfect\" x1=\"{turn:.1}\" x2=\"{turn:.1}\" y1=\"10\" y2=\"{zero:.1}\"/>\
         <text x=\"{label}\" y=\"15\" text-anchor=\"end\">{most}</text>\
         <text x=\"{label}\" y=\"{zero:.1}\" text-anchor=\"end\">0</text>\
         <polyline class=\"curve\" points=\"{points}\"/>\
         <text class=\"dim\" x=\"{LEFT}\" y=\"{bottom:.1}\">0 s</text>\
         <text class=\"dim\" x=\"{WIDTH}\" y=\"{bottom:.1}\" text-anchor=\"end\">{end} s</text></svg>",
        HEIGHT + 36.0,
    )
}

fn shown(value: f64) -> String {
    if value >= 1000.0 { grouped(value.round() as u64) } else { digits(value) }
}
