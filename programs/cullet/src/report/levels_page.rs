//! The part of the page on levels of detail: from all triangles to those that are seen, which
//! levels are drawn, how far they are off, and what they cost.

use std::fmt::Write;

use cullet_command::console::{count, grouped, percent};
use cullet_command::html::{escape, hex};
use cullet_draw::palette;

use super::charts;
use super::record::{LevelsCost, Record};
use crate::levels::{DeviationRecord, LevelsSummary};

/// Nothing where levels of detail are off.
pub(crate) fn section(out: &mut String, record: &Record) {
    let Some(levels) = &record.summary.levels else { return };
    let views = record.summary.views.max(1) as u64;
    out.push_str(
        "<h2>Levels of detail: from all to visible</h2><p class=\"sub\">Each step includes those before it. \
         Averages over the views.</p><div class=\"panel\">",
    );
    ladder(out, levels, views);
    out.push_str("</div>\n");
    table(out, levels, views);
    if let Some(deviation) = &levels.deviation {
        found(out, deviation, levels);
    }
    if let Some(cost) = &record.levels {
        costs(out, cost, views);
    }
}

/// A bar a step, as long as what is left.
fn ladder(out: &mut String, levels: &LevelsSummary, views: u64) {
    let l = &levels.ladder;
    let of = |stage| charts::stage_color(stage);
    let mut rungs = vec![
        ("all", l.all, hex(palette::DROPPED)),
        ("in the frustum", l.frustum, of(cullet::Stage::Frustum)),
        ("not facing away", l.backface, of(cullet::Stage::Backface)),
        ("not hidden", l.occlusion, of(cullet::Stage::Occlusion)),
        ("with levels of detail", l.levels, of(cullet::Stage::Lod)),
    ];
    rungs.extend(l.visible.map(|n| ("visible of those", n, charts::visible_color())));
    rungs.extend(l.visible_in_full.map(|n| ("visible in full", n, charts::visible_color())));
    out.push_str("<ol class=\"funnel\">");
    for (label, n, color) in rungs {
        let least = if n > 0 { "2px" } else { "0" };
        let share = if l.all == 0 { 0.0 } else { n as f64 / l.all as f64 * 100.0 };
        let _ = write!(
            out,
            "<li><span>{label}</span><span class=\"track\"><i class=\"bar\" style=\"width:{share:.3}%;min-width:{least};\
             background:{color}\"></i></span><b>{}</b><span class=\"dim\">{}</span></li>",
            percent(n, l.all),
            grouped(n / views),
        );
    }
    out.push_str("</ol>");
    if let Some(ratio) = levels.drawn_over_visible_in_full {
        let _ = write!(
            out,
            "<p class=\"sub\">Triangles drawn with levels over triangles visible in full: {ratio:.2}.</p>"
        );
    }
}

/// Triangles by level.
fn table(out: &mut String, levels: &LevelsSummary, views: u64) {
    let [drawn, chosen] = [&levels.drawn, &levels.chosen].map(|c| c.iter().sum::<u64>());
    out.push_str(
        "<div class=\"scroll\"><table><thead><tr><th>Level</th><th class=\"n\">Drawn per view</th>\
         <th class=\"n\">Of what is drawn</th><th class=\"n\">Without other culling</th></tr></thead><tbody>",
    );
    for (step, &n) in (0u32..).zip(&levels.drawn) {
        let all = levels.chosen.get(step as usize).copied().unwrap_or(0);
        if n == 0 && all == 0 {
            continue;
        }
        let name = levels.name(step);
        let without = if chosen == 0 { "–".to_owned() } else { grouped(all / views) };
        let _ = write!(
            out,
            "<tr><td><i class=\"swatch\" style=\"background:{}\"></i>{name}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{without}</td></tr>",
            hex(palette::level_color(step)),
            grouped(n / views),
            percent(n, drawn),
        );
    }
    out.push_str(
        "</tbody></table></div><p class=\"sub\">A level is how often its triangles were simplified: the number of a chain's \
         level, or the depth in a hierarchy of clusters.</p>\n",
    );
}

/// The error that is stated, and the one that was found.
fn found(out: &mut String, deviation: &DeviationRecord, levels: &LevelsSummary) {
    let badge = if deviation.kept { "good" } else { "bad" };
    let _ =
        write!(out, "<p><span class=\"badge {badge}\">{}</span></p>", escape(&deviation.text()));
    if let Some(p) = levels.pixels {
        let _ = writeln!(
            out,
            "<p class=\"sub\">{} of the pixels show another instance than in full, {} at silhouettes before the background. \
             {} what was taken for small or out of reach of the eye's cell.</p>",
            percent(p.differ, p.all),
            percent(p.silhouette, p.all),
            count(p.uncovered, "pixel shows", "pixels show"),
        );
    }
}

/// Size against cost.
fn costs(out: &mut String, cost: &LevelsCost, views: u64) {
    out.push_str(
        "<div class=\"scroll\"><table><thead><tr><th></th><th class=\"n\">In full</th><th class=\"n\">With levels</th>\
         </tr></thead><tbody>",
    );
    let mut row = |what: &str, a: String, b: String| {
        let _ =
            write!(out, "<tr><td>{what}</td><td class=\"n\">{a}</td><td class=\"n\">{b}</td></tr>");
    };
    let both = cost.stored_triangles + cost.stored_level_triangles;
    row("Triangles stored, each mesh once", grouped(cost.stored_triangles), grouped(both));
    let [before, after] = cost.drawn_triangles.map(|n| grouped(n / views));
    row("Triangles drawn per view", before, after);
    if let Some([before, after]) = cost.ms_per_view {
        let ms = |v: f64| format!("{v:.3} ms");
        row("Estimated cost of drawing them", ms(before), ms(after));
    }
    out.push_str("</tbody></table></div>\n");
}
