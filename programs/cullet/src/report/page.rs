//! The page: one HTML file without scripts, links or anything else to fetch.

use std::fmt::Write;

use super::{charts, levels_page};
use cullet_command::console::{agree, count, grouped, percent};
use cullet_command::html::{self, escape, with_code};

use super::record::Record;
use super::saved;
use super::tables;
use crate::record::Summary;

/// A picture of the page: where its full size lies, the smaller one that the page carries, and
/// words.
#[derive(Clone, Debug)]
pub(crate) struct Image {
    /// The file beside the page.
    pub(crate) file: String,
    /// The embedded picture, as a `data:` address.
    pub(crate) data: String,
    /// Its size, so that the page does not jump while it is read.
    pub(crate) size: [u32; 2],
    pub(crate) caption: String,
    pub(crate) wide: bool,
}

/// The pictures of the page.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gallery {
    /// The view that is shown large, by its index.
    pub(crate) featured: usize,
    pub(crate) large: Vec<Image>,
    /// A small one of each view.
    pub(crate) thumbs: Vec<Image>,
}

/// The headline: how much is drawn for nothing, in plain words.
fn headline(summary: &Summary) -> String {
    let t = summary.triangles;
    let views = summary.views.max(1) as u64;
    if t.all == 0 {
        return "There is nothing to draw in this scene.".into();
    }
    let Some(visible) = t.visible.filter(|_| summary.verified_views.len() == summary.views) else {
        let culled = t.all - t.potentially_visible;
        return format!(
            "{} of {} per view need not be drawn.",
            grouped(culled / views),
            count(t.all / views, "triangle", "triangles")
        );
    };
    let waste = t.all.saturating_sub(visible);
    let share = percent(visible, t.all);
    // "under 0.1 %" says by itself how little it is, and half is not little.
    let only = if share.starts_with("under") || visible * 2 >= t.all { "" } else { "only " };
    format!(
        "{} of {} per view {} drawn for nothing: {only}{share} can be seen.",
        grouped(waste / views),
        count(t.all / views, "triangle", "triangles"),
        agree(waste / views, "is", "are"),
    )
}

/// The headline, with the milliseconds that culling saves where costs are known.
pub(crate) fn full_headline(record: &Record) -> String {
    let saved = record.costs.as_ref().filter(|_| record.summary.triangles.all > 0);
    headline(&record.summary) + &saved.map_or_else(String::new, saved::CostsRecord::headline)
}

/// The assumption behind the milliseconds of the headline, or how to get some; `None` where costs
/// are known and culling saves nothing.
pub(crate) fn assumption(record: &Record) -> Option<&str> {
    match &record.costs {
        None => Some(saved::UNKNOWN),
        Some(costs) => costs.saves().then_some(&costs.assumption),
    }
}

/// The sentence below it: what culling does about it, and how near to perfect that is.
pub(crate) fn lead(summary: &Summary) -> String {
    let t = summary.triangles;
    let culled = t.all.saturating_sub(t.potentially_visible);
    let mut text = format!("Culling removes {} of all triangles", percent(culled, t.all));
    let mut best: Vec<(cullet::Stage, u64)> =
        summary.removed.iter().map(|(k, v)| (*k, *v)).collect();
    best.sort_by_key(|b| std::cmp::Reverse(b.1));
    match best[..] {
        [] => {}
        [(stage, _)] => {
            let _ = write!(text, ", each of them because it is {}", charts::stage_words(stage));
        }
        [(stage, n), ..] => {
            let why = charts::stage_words(stage);
            let _ = write!(text, ", {} of them because they are {why}", percent(n, culled));
        }
    }
    text.push('.');
    if let Some(tightness) = summary.tightness {
        let _ = write!(
            text,
            " What is left is {} times what is visible, where 1 would be perfect.",
            times(tightness)
        );
    }
    text
}

/// A ratio with as many digits as say something.
fn times(ratio: f64) -> String {
    if ratio >= 100.0 { grouped(ratio.round() as u64) } else { format!("{ratio:.2}") }
}

fn badge(record: &Record) -> String {
    let s = &record.summary;
    let verified = s.verified_views.len();
    let samples = match record.settings.samples {
        0 | 1 => "at 1 sample a pixel".to_owned(),
        n => format!("pixel for pixel, and with {n}×{n} samples"),
    };
    if s.false_culls > 0 {
        let n = count(s.false_culls, "visible instance was", "visible instances were");
        return format!("<span class=\"badge bad\">{n} lost: see below</span>");
    }
    if verified == 0 {
        return "<span class=\"badge warn\">not verified</span>".into();
    }
    if verified < s.views {
        let list: Vec<String> = s.verified_views.iter().map(ToString::to_string).collect();
        return format!(
            "<span class=\"badge warn\">Verified in {verified} of {} views ({}) {samples}: nothing visible \
             was lost</span>",
            s.views,
            list.join(", ")
        );
    }
    let views = if verified == 1 { "1 view".into() } else { format!("all {verified} views") };
    format!(
        "<span class=\"badge good\">Verified in {views} {samples}: nothing visible was lost</span>"
    )
}

/// The page. `changes` are lines against a baseline.
pub(crate) fn page(record: &Record, gallery: &Gallery, changes: &[String]) -> String {
    let s = &record.summary;
    let scene = &record.scene;
    let [w, h] = record.settings.size;
    let mut out = String::with_capacity(1 << 20);
    let name = escape(&scene.name);
    let _ = write!(
        out,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"referrer\" content=\"no-referrer\">\
         <title>{name} · cullet report</title><style>\n{}</style></head><body><main>\n\
         <p class=\"kicker\">cullet report · <b>{name}</b> · {} on the path <b>{}</b> · {w}×{h}</p>\n\
         <h1>{}</h1>\n<p class=\"lead\">{}</p>\n\
         {}{}\n",
        include_str!("style.css"),
        count(s.views as u64, "view", "views"),
        escape(&record.settings.path),
        escape(&full_headline(record)),
        lead(s),
        assumption(record).map_or_else(String::new, |words| {
            format!("<p class=\"kicker\">{}</p>\n", with_code(words))
        }),
        badge(record),
    );
    if !record.complete {
        out.push_str(" <span class=\"badge warn\">stopped early: the views done so far</span>\n");
    }
    figures(&mut out, s);
    out.push_str(
        "<h2>Where the triangles go</h2><p class=\"sub\">Each step culls the coloured part; the grey part \
         passes on to the next. Averages over the views.</p><div class=\"panel\">",
    );
    out.push_str(&charts::funnel(s));
    out.push_str("</div>\n");
    changes_section(&mut out, changes);
    advice(&mut out, record);
    pictures(&mut out, gallery);
    levels_page::section(&mut out, record);
    tables::whole(&mut out, s);
    views(&mut out, record);
    tables::losses(&mut out, &record.views);
    tables::depth(&mut out, s);
    tables::bounds(&mut out, s);
    tables::meshes(&mut out, record);
    tables::stages(&mut out, s);
    tables::hierarchy(&mut out, s);
    tables::backfaces(&mut out, s);
    tables::views(&mut out, &record.views);
    warnings(&mut out, record);
    words(&mut out, record);
    out.push_str("</main></body></html>\n");
    out
}

fn figures(out: &mut String, s: &Summary) {
    let views = s.views.max(1) as u64;
    let t = s.triangles;
    let visible = t.visible.filter(|_| !s.verified_views.is_empty());
    let verified = s.verified_views.len().max(1) as u64;
    let mut row = vec![
        (grouped(t.all / views), "triangles in the scene, each instance counted".to_owned()),
        (grouped(t.potentially_visible / views), "left after culling, per view".to_owned()),
    ];
    if let Some(v) = visible {
        row.push((grouped(v / verified), "own a pixel, per view".into()));
    }
    if let Some(x) = s.tightness {
        row.push((format!("{}×", times(x)), "tightness: left over visible".into()));
    }
    row.push((grouped(s.false_culls), "false culls".into()));
    out.push_str("<div class=\"figures\">");
    for (value, what) in row {
        let _ = write!(out, "<div class=\"figure\"><b>{value}</b><span>{what}</span></div>");
    }
    out.push_str("</div>\n");
}

fn changes_section(out: &mut String, changes: &[String]) {
    if changes.is_empty() {
        return;
    }
    out.push_str("<h2>Against the baseline</h2><div class=\"panel\"><ul>");
    for line in changes {
        let _ = write!(out, "<li>{}</li>", escape(line));
    }
    out.push_str("</ul></div>\n");
}

fn advice(out: &mut String, record: &Record) {
    out.push_str(
        "<h2>What to do about it</h2><p class=\"sub\">Computed from this run, what concerns the most \
         triangles first.</p>",
    );
    if record.summary.advice.is_empty() {
        out.push_str("<div class=\"panel\">No advice: nothing was found to change.</div>");
    }
    for a in &record.summary.advice {
        let _ = writeln!(
            out,
            "<div class=\"advice\"><h3>{}</h3><p>{}</p></div>",
            escape(&a.title),
            escape(&a.text)
        );
    }
}

fn image(out: &mut String, image: &Image, link: bool) {
    let (open, close) = if link {
        (format!("<a href=\"{}\">", html::link(&image.file)), "</a>")
    } else {
        (String::new(), "")
    };
    let _ = write!(
        out,
        "<figure{}>{open}<img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\">{close}<figcaption>{}\
         </figcaption></figure>",
        if image.wide { " class=\"wide\"" } else { "" },
        image.data,
        image.size[0],
        image.size[1],
        escape(&image.caption),
        escape(&image.caption),
    );
}

fn pictures(out: &mut String, gallery: &Gallery) {
    if gallery.large.is_empty() && gallery.thumbs.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "<h2>What it looks like</h2><p class=\"sub\">View {}, and below it all views; each opens in its full \
         size from the files beside this page.</p><div class=\"pictures\">",
        gallery.featured
    );
    gallery.large.iter().for_each(|i| image(out, i, true));
    out.push_str("</div><div class=\"thumbs\">");
    gallery.thumbs.iter().for_each(|i| image(out, i, true));
    out.push_str("</div>\n");
}

fn views(out: &mut String, record: &Record) {
    if record.views.is_empty() {
        return;
    }
    out.push_str(
        "<h2>View by view</h2><p class=\"sub\">What became of all triangles in each view.</p>\
         <div class=\"panel\">",
    );
    out.push_str(&charts::columns(&record.views));
    out.push_str("<ul class=\"legend\">");
    for share in charts::shares(&record.summary).iter().rev() {
        let _ = write!(out, "<li><i style=\"background:{}\"></i>{}</li>", share.color, share.label);
    }
    out.push_str("</ul></div>");
    if let Some(curve) = charts::tightness(&record.views) {
        let _ = writeln!(
            out,
            "<div class=\"panel\"><h3>Tightness: triangles left over triangles visible</h3>{curve}</div>"
        );
    }
}

fn warnings(out: &mut String, record: &Record) {
    let warnings = &record.scene.warnings;
    if warnings.is_empty() {
        return;
    }
    const SHOWN: usize = 50;
    let n = warnings.len();
    out.push_str("<h2>Oddities of the file</h2><p class=\"sub\">Loaded all the same.</p><div class=\"panel\"><ul>");
    for w in warnings.iter().take(SHOWN) {
        let _ = write!(out, "<li>{}</li>", escape(w));
    }
    out.push_str("</ul>");
    if n > SHOWN {
        let _ = write!(out, "<p>and {} more, in report.json</p>", n - SHOWN);
    }
    out.push_str("</div>\n");
}

fn words(out: &mut String, record: &Record) {
    let _ = write!(
        out,
        "<h2>Words</h2><div class=\"panel\"><dl class=\"words\">\
         <dt>drawn for nothing</dt><dd>submitted, yet the owner of no pixel.</dd>\
         <dt>visible</dt><dd>owns a pixel in a reference picture drawn with no culling at all, or is blended \
         over one.</dd>\
         <dt>left after culling</dt><dd>what an engine would draw: everything visible, and some that is not.\
         </dd>\
         <dt>tightness</dt><dd>triangles left over triangles visible. 1 is perfect; below 1 something visible \
         was lost.</dd>\
         <dt>false cull</dt><dd>something visible that was dropped. With exact stages there must be none.\
         </dd>\
         <dt>solid</dt><dd>closed, wound outward everywhere, opaque: its back can never be seen.</dd>\
         </dl></div>\n<footer>Made by cullet {} · culling: {} · figures also in <code>report.json</code> and \
         <code>views.csv</code></footer>\n",
        escape(record.settings.version),
        escape(&record.settings.culling.join(", ")),
    );
}
