//! The charts of the page: the funnel, and as inline SVG the curves over the views.

use std::fmt::Write;

use cullet::Stage;
use cullet_command::console::{grouped, percent};
use cullet_command::html::hex;
use cullet_draw::palette;

use crate::record::{Summary, ViewRecord};

/// A share of the triangles: its name for people, its colour, its number.
pub(crate) struct Share {
    pub(crate) label: String,
    pub(crate) color: String,
    pub(crate) count: u64,
}

/// The colour of what a stage took.
pub(crate) fn stage_color(stage: Stage) -> String {
    hex(palette::reason_color(Some(stage)))
}

/// The colour of what is drawn though no pixel shows it.
pub(crate) fn unseen_color() -> String {
    hex(palette::UNSEEN)
}

/// The colour of what is visible.
pub(crate) fn visible_color() -> String {
    hex(palette::reason_color(None))
}

/// The triangles that a stage culls, in words.
pub(crate) fn stage_words(stage: Stage) -> &'static str {
    match stage {
        Stage::Layer => "in another layer",
        Stage::Frustum => "outside the view",
        Stage::Pvs => "never seen from the cell",
        Stage::Portal => "in rooms out of sight",
        Stage::Detail => "too small to matter",
        Stage::Lod => "replaced by another level of detail",
        Stage::Occlusion => "occluded",
        Stage::Backface => "facing away",
        Stage::Degenerate => "degenerate",
    }
}

/// Shares of all triangles by the stage that culled them, in the order of the stages; then unseen
/// and visible ones.
pub(crate) fn shares(summary: &Summary) -> Vec<Share> {
    let share = |(&stage, &count): (&Stage, &u64)| Share {
        label: stage_words(stage).to_owned(),
        color: stage_color(stage),
        count,
    };
    let mut shares: Vec<Share> = summary.removed.iter().map(share).collect();
    let t = summary.triangles;
    let visible = t.visible.unwrap_or(0);
    if summary.verified_views.len() == summary.views {
        let unseen = t.potentially_visible.saturating_sub(visible);
        shares.push(Share {
            label: "drawn, never seen".into(),
            color: unseen_color(),
            count: unseen,
        });
        shares.push(Share { label: "visible".into(), color: visible_color(), count: visible });
    } else {
        let count = t.potentially_visible;
        shares.push(Share { label: "drawn".into(), color: visible_color(), count });
    }
    shares
}

/// The funnel: one bar a step, as long as what is left, with what the step took in its colour. Not
/// an SVG like the curves: its words must stay readable where the page is narrow.
pub(crate) fn funnel(summary: &Summary) -> String {
    let all = summary.triangles.all;
    let views = summary.views.max(1) as u64;
    let mut html = String::from("<ol class=\"funnel\">");
    let share = |n: u64| if all == 0 { 0.0 } else { n as f64 / all as f64 * 100.0 };
    let mut rest = all;
    for taken in shares(summary) {
        rest = rest.saturating_sub(taken.count);
        // The triangles that are left lie to the left; those culled by this step are cut off at the
        // right. However few they are, they can be seen.
        let least = if taken.count > 0 { "2px" } else { "0" };
        let _ = write!(
            html,
            "<li><span>{}</span><span class=\"track\"><i class=\"rest\" style=\"width:{:.3}%\"></i>\
             <i class=\"bar\" style=\"width:{:.3}%;min-width:{least};background:{}\"></i></span>\
             <b>{}</b><span class=\"dim\">{}</span></li>",
            taken.label,
            share(rest),
            share(taken.count),
            taken.color,
            percent(taken.count, all),
            grouped(taken.count / views),
        );
    }
    html.push_str("</ol>");
    html
}

/// One stacked column a view: what each stage took, what is unseen, what is visible.
pub(crate) fn columns(views: &[ViewRecord]) -> String {
    let (w, h, left, top) = (960.0, 260.0, 64.0, 12.0);
    let plot = (w - left - 8.0, h - top - 28.0);
    let most = views.iter().map(|v| v.triangles.all).max().unwrap_or(0).max(1);
    let step = plot.0 / views.len().max(1) as f64;
    // Without a gap where columns are but a few pixels wide.
    let gap = if step > 8.0 { 2.0 } else { 0.0 };
    let visible = visible_color();
    let mut svg = format!(
        "<svg class=\"chart\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"What became of the \
         triangles of each view\">"
    );
    grid(&mut svg, left, top, plot, most as f64, |v| short(v as u64));
    for (i, view) in views.iter().enumerate() {
        let x = left + i as f64 * step + gap / 2.0;
        let mut y = top + plot.1;
        let t = view.triangles;
        let mut stack: Vec<(String, u64, &str)> = Vec::new();
        match t.visible {
            Some(v) => {
                stack.push((visible_color(), v, "visible"));
                let unseen = t.potentially_visible.saturating_sub(v);
                stack.push((unseen_color(), unseen, "drawn, never seen"));
            }
            None => stack.push((visible_color(), t.potentially_visible, "drawn")),
        }
        for (&stage, &n) in view.removed.iter().rev() {
            stack.push((stage_color(stage), n, stage_words(stage)));
        }
        let _ = write!(svg, "<g><title>view {}", view.index);
        for (_, n, what) in &stack {
            let _ = write!(svg, "\n{} {what}", grouped(*n));
        }
        svg.push_str("</title>");
        for (color, n, _) in stack {
            let bar = n as f64 / most as f64 * plot.1;
            y -= bar;
            let _ = write!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{bar:.2}\" fill=\"{color}\"{}/>",
                (step - gap).max(0.5),
                // Visible triangles are nearly white, so they need an edge on white paper.
                if color == visible { " class=\"bar\"" } else { "" }
            );
        }
        svg.push_str("</g>");
    }
    view_numbers(&mut svg, views, left, step, top + plot.1 + 18.0);
    svg.push_str("</svg>");
    svg
}

/// The curve of the tightness over the views, from 1 up.
pub(crate) fn tightness(views: &[ViewRecord]) -> Option<String> {
    let known: Vec<(usize, f64)> =
        views.iter().enumerate().filter_map(|(i, v)| v.tightness.map(|t| (i, t))).collect();
    let most = known.iter().map(|k| k.1).fold(1.0f64, f64::max);
    if known.len() < 2 {
        return None;
    }
    let (w, h, left, top) = (960.0, 190.0, 64.0, 12.0);
    let plot = (w - left - 8.0, h - top - 28.0);
    let step = plot.0 / views.len() as f64;
    let mut svg = format!(
        "<svg class=\"chart\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"Tightness of each view\">"
    );
    grid(&mut svg, left, top, plot, most, |v| match most {
        20.0.. => short(v as u64),
        _ => format!("{v:.1}"),
    });
    let at = |i: usize, t: f64| (left + (i as f64 + 0.5) * step, top + plot.1 - t / most * plot.1);
    let one = at(0, 1.0).1;
    let _ = write!(
        svg,
        "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{one:.1}\" y2=\"{one:.1}\" class=\"perfect\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" class=\"dim\" text-anchor=\"end\">1 is perfect</text>",
        left + plot.0,
        left + plot.0,
        one - 5.0
    );
    let points: Vec<String> =
        known.iter().map(|&(i, t)| at(i, t)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = write!(svg, "<polyline points=\"{}\" class=\"curve\"/>", points.join(" "));
    if known.len() <= 64 {
        for &(i, t) in &known {
            let (x, y) = at(i, t);
            let _ = write!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" class=\"dot\"><title>view {i}: {t:.2}</title></circle>"
            );
        }
    }
    view_numbers(&mut svg, views, left, step, top + plot.1 + 18.0);
    svg.push_str("</svg>");
    Some(svg)
}

/// Four lines at round values, with their labels.
fn grid(
    svg: &mut String,
    left: f64,
    top: f64,
    plot: (f64, f64),
    most: f64,
    label: impl Fn(f64) -> String,
) {
    let step = round_step(most / 3.5);
    let mut value = 0.0;
    while value <= most {
        let y = top + plot.1 - value / most * plot.1;
        let _ = write!(
            svg,
            "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\" class=\"grid\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" class=\"dim\" text-anchor=\"end\">{}</text>",
            left + plot.0,
            left - 8.0,
            y + 4.0,
            label(value)
        );
        value += step;
    }
}

/// The nearest of 1, 2 and 5 times a power of ten, at least `v`.
fn round_step(v: f64) -> f64 {
    let power = 10f64.powf(v.max(1e-9).log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= v);
    round.unwrap_or(10.0) * power
}

fn view_numbers(svg: &mut String, views: &[ViewRecord], left: f64, step: f64, y: f64) {
    let every = (views.len() / 16).max(1);
    for (i, view) in views.iter().enumerate().step_by(every) {
        let x = left + (i as f64 + 0.5) * step;
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y}\" class=\"dim{}\" text-anchor=\"middle\">{}</text>",
            // Left out where the page is narrow.
            if i / every % 2 == 1 { " alternate" } else { "" },
            view.index
        );
    }
}

/// A number in few characters: `1.2 M`.
pub(crate) fn short(n: u64) -> String {
    let (divisor, unit) = match n {
        0..1_000 => return n.to_string(),
        1_000..1_000_000 => (1e3, "k"),
        1_000_000..1_000_000_000 => (1e6, "M"),
        _ => (1e9, "G"),
    };
    let v = n as f64 / divisor;
    if v < 10.0 && (v * 10.0).round() % 10.0 != 0.0 {
        format!("{v:.1}\u{202f}{unit}")
    } else {
        format!("{v:.0}\u{202f}{unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (v, step) in [(0.9, 1.0), (1.0, 1.0), (1.2, 2.0), (33.0, 50.0), (70.0, 100.0)] {
            assert!((round_step(v) - step).abs() < 1e-9, "{v}: {}", round_step(v));
        }
    }

    #[test]
    fn numbers_are_short() {
        let plain = |n| short(n).replace('\u{202f}', "");
        assert_eq!(plain(999), "999");
        assert_eq!(plain(1_500), "1.5k");
        assert_eq!(plain(2_000_000), "2M");
        assert_eq!(plain(38_530_000_000), "39G");
    }
}
