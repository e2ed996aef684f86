//! The tables of the page.

use std::fmt::Write;

use cullet::{Stage, funnel::Unit};

use super::charts::{short, stage_color};
use cullet_command::console::{count, grouped, percent};
use cullet_command::html::escape;

use super::record::Record;
use crate::record::{BackfaceRecord, DepthRecord, Summary, ViewRecord};

/// More rows than this are left to report.json: a table of a thousand meshes cannot be read.
const MESHES_SHOWN: usize = 60;
const LOSSES_SHOWN: usize = 100;

fn n(value: u64) -> String {
    let zero = if value == 0 { " zero" } else { "" };
    format!("<td class=\"n{zero}\">{}</td>", grouped(value))
}

/// Table of the visible triangles that were culled; nothing where there are none.
pub(crate) fn losses(out: &mut String, views: &[ViewRecord]) {
    let all: Vec<_> = views.iter().flat_map(|v| &v.losses).collect();
    if all.is_empty() {
        return;
    }
    out.push_str(
        "<h2>Visible, but dropped</h2><p class=\"sub\">Each of these owns a pixel or a sample in the picture \
         drawn without culling, and is missing from what culling left.</p><div class=\"scroll\"><table><thead>\
         <tr><th class=\"n\">View</th><th>Instance</th><th class=\"n\">Triangle</th><th>Pixel</th><th>Stage</th>\
         <th>Reason</th></tr></thead><tbody>",
    );
    for l in all.iter().take(LOSSES_SHOWN) {
        let _ = write!(
            out,
            "<tr><td class=\"n\">{}</td><td class=\"name\">{}</td><td class=\"n\">{}</td><td>{}, {}</td>\
             <td>{}</td><td>{}</td></tr>",
            l.view,
            escape(&l.instance),
            l.triangle.map_or_else(|| "whole".into(), |t| t.to_string()),
            l.pixel[0],
            l.pixel[1],
            l.stage.map_or("–", Stage::name),
            escape(&l.reason)
        );
    }
    out.push_str("</tbody></table></div>");
    if all.len() > LOSSES_SHOWN {
        let _ = write!(
            out,
            "<p>and {} more, in report.json</p>",
            grouped((all.len() - LOSSES_SHOWN) as u64)
        );
    }
}

/// The classic table: what is left of whole instances, kind of culling after kind of culling.
pub(crate) fn whole(out: &mut String, s: &Summary) {
    let views = s.views.max(1) as u64;
    let verified = s.verified_views.len() as u64;
    let (t, i, w) = (s.triangles, s.instances, s.whole);
    let mut rows = vec![("Full model", [i.all, t.all], views)];
    rows.push(("After view-frustum culling", w.in_frustum, views));
    let occluders = w.occluders[0] > 0;
    if occluders {
        rows.push(("After occlusion culling", w.not_hidden, views));
    }
    if let (Some(instances), Some(triangles), 1..) = (i.visible, t.visible, verified) {
        rows.push(("Visible", [instances, triangles], verified));
    }
    out.push_str(
        "<h2>If whole instances alone were culled</h2><p class=\"sub\">As a renderer sees it that draws instance by \
         instance: the mean over the views.",
    );
    if occluders {
        let [considered, drawn] = w.occluders.map(|n| n / views);
        let considered = count(considered, "occluder", "occluders");
        let _ = write!(
            out,
            " A view considered {considered} and drew {} of them to hide others.",
            grouped(drawn)
        );
    }
    out.push_str(
        "</p><div class=\"scroll\"><table><thead><tr><th></th><th class=\"n\">Triangles</th>\
         <th class=\"n\">Of all</th><th class=\"n\">Objects</th></tr></thead><tbody>",
    );
    for (what, [objects, triangles], views) in rows {
        let _ = write!(
            out,
            "<tr><td>{what}</td>{}<td class=\"n\">{}</td>{}</tr>",
            n(triangles / views),
            percent(triangles * s.views as u64, t.all * views),
            n(objects / views)
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// Depth complexity before and after.
pub(crate) fn depth(out: &mut String, s: &Summary) {
    let (Some(before), Some(after)) = (s.depth_before, s.depth_after) else { return };
    out.push_str(
        "<h2>How often each pixel is filled</h2><p class=\"sub\">Depth complexity: the triangles that cover a \
         pixel, whichever of them wins. Before culling, and after.</p><div class=\"scroll\"><table><thead><tr>\
         <th></th><th class=\"n\">Before</th><th class=\"n\">After</th></tr></thead><tbody>",
    );
    let mut row = |what: &str, value: &dyn Fn(&DepthRecord) -> String| {
        let _ = write!(
            out,
            "<tr><td>{what}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            value(&before),
            value(&after)
        );
    };
    row("Layers on a covered pixel, mean", &|d| format!("{:.2}", d.mean_layers));
    row("Layers on a pixel, most", &|d| d.max_layers.to_string());
    row("Fragments, all views", &|d| short(d.fragments));
    row("Triangles submitted for each pixel", &|d| format!("{:.3}", d.primitives_per_pixel));
    out.push_str("</tbody></table></div>\n");
}

/// Boxes against spheres.
pub(crate) fn bounds(out: &mut String, s: &Summary) {
    let Some(b) = s.bounds else { return };
    let _ = write!(
        out,
        "<h2>Boxes or spheres?</h2><p class=\"sub\">Both bounds of every instance against the frustum of every \
         view. A false keep is an instance kept though none of its triangles is in the frustum.</p>\
         <div class=\"scroll\"><table><thead><tr><th>Bound</th><th class=\"n\">Kept per view</th>\
         <th class=\"n\">False keeps per view</th><th class=\"n\">Share of all instances</th>\
         <th class=\"n\">Cost of a test</th></tr></thead><tbody>"
    );
    let views = s.views.max(1) as u64;
    for (name, kept, ns) in
        [("Box", b.boxes_kept, b.box_ns), ("Sphere", b.spheres_kept, b.sphere_ns)]
    {
        let false_keeps = kept.saturating_sub(b.in_frustum);
        let _ = write!(
            out,
            "<tr><td>{name}</td>{}{}<td class=\"n\">{}</td><td class=\"n\">{ns:.2} ns</td></tr>",
            n(kept / views),
            n(false_keeps / views),
            percent(false_keeps, b.tested)
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// Meshes, those that waste the most first.
pub(crate) fn meshes(out: &mut String, record: &Record) {
    let views = record.summary.views;
    let _ = write!(
        out,
        "<h2>Meshes</h2><p class=\"sub\">{} of {} are solid. Ordered by triangles drawn for nothing after \
         culling.</p><div class=\"scroll\"><table><thead><tr><th>Mesh</th><th class=\"n\">Triangles</th>\
         <th class=\"n\">Instances</th><th class=\"n\">Seen in views</th><th class=\"n\">Drawn per view</th>\
         <th class=\"n\">Visible per view</th><th>Solid?</th></tr></thead><tbody>",
        grouped(record.scene.solids),
        grouped(record.scene.meshes),
    );
    let per_view = |v: u64| n(v / views.max(1) as u64);
    let verified = record.summary.verified_views.len();
    for m in record.meshes.iter().take(MESHES_SHOWN) {
        let seen = match m.views_seen {
            _ if verified == 0 => "<td class=\"n\">–</td>".to_owned(),
            0 => "<td class=\"n hot\">none</td>".to_owned(),
            s => format!("<td class=\"n\">{s} of {verified}</td>"),
        };
        let solid = match &m.defect {
            None => "yes".to_owned(),
            Some(why) => format!("<span class=\"why\">no: {}</span>", escape(why)),
        };
        let _ = write!(
            out,
            "<tr><td class=\"name\">{}</td>{}{}{seen}{}{}<td>{solid}</td></tr>",
            escape(&m.name),
            n(m.triangles),
            n(m.instances),
            per_view(m.drawn),
            per_view(m.visible),
        );
    }
    out.push_str("</tbody></table></div>\n");
    let more = record.meshes.len().saturating_sub(MESHES_SHOWN);
    if more > 0 {
        let _ = write!(
            out,
            "<p class=\"kicker\">and {} more, in report.json</p>",
            grouped(more as u64)
        );
    }
}

/// Table of the triangles that each stage received and left.
pub(crate) fn stages(out: &mut String, s: &Summary) {
    if s.stages.is_empty() {
        return;
    }
    out.push_str(
        "<h2>Stages</h2><p class=\"sub\">Sums over the views, in the order in which they run.</p>\
         <div class=\"scroll\"><table><thead><tr><th>Stage</th><th>Counts</th><th class=\"n\">In</th>\
         <th class=\"n\">Out</th><th class=\"n\">Taken</th><th class=\"n\">Triangles taken</th>\
         <th class=\"n\">Time per view</th></tr></thead><tbody>",
    );
    for r in &s.stages {
        let ms =
            r.ms.map_or_else(|| "–".into(), |ms| format!("{:.3} ms", ms / s.views.max(1) as f64));
        let _ = write!(
            out,
            "<tr><td><i class=\"swatch\" style=\"background:{}\"></i>{}</td><td>{}</td>{}{}<td class=\"n\">{}\
             </td>{}<td class=\"n\">{ms}</td></tr>",
            stage_color(r.stage),
            r.stage.name(),
            r.unit.name(),
            n(r.entered),
            n(r.left),
            percent(r.entered.saturating_sub(r.left), r.entered),
            n(r.taken()),
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// Work of the frustum stage on the hierarchy, in a line below the stages.
pub(crate) fn hierarchy(out: &mut String, s: &Summary) {
    let views = s.views.max(1) as u64;
    let (h, instances) = (s.hierarchy, s.instances.all / views);
    let [nodes, blocks, tests, swept] =
        [h.nodes, h.blocks, h.plane_tests, h.swept].map(|v| grouped(v / views));
    let _ = write!(
        out,
        "<p class=\"sub\">To find the instances in the frustum among {}, a view tested on average {nodes} nodes of \
         the hierarchy and {blocks} blocks of sixteen instances, with {tests} tests of sixteen boxes against a plane. \
         Instances swept without a test of a node: {swept}.</p>",
        grouped(instances)
    );
}

/// Back faces by cluster and by triangle, the ideal beside the actual.
pub(crate) fn backfaces(out: &mut String, s: &Summary) {
    let Some(b) = s.backfaces.filter(|b| b.one_sided > 0) else { return };
    let views = b.views.max(1);
    let _ = write!(
        out,
        "<h2>Back faces: ideal beside actual</h2><p class=\"sub\">Of {} one-sided triangles per view in clusters \
         that come to this stage, {} ({}) face away. A whole cluster goes where its bound proves that all of it \
         does: who draws clusters has that for next to nothing. Then each triangle is tried by a plane of four bytes, and what \
         that leaves in doubt from its corners.{}</p>\
         <div class=\"scroll\"><table><thead><tr><th>Taken</th><th class=\"n\">Ideal per view</th>\
         <th class=\"n\">Actual per view</th><th class=\"n\">Of the ideal</th><th class=\"n\">Of what faces away</th>\
         <th class=\"n\">Time per view</th></tr></thead><tbody>",
        grouped(b.one_sided / views),
        grouped(b.facing_away / views),
        percent(b.facing_away, b.one_sided),
        counted(s.views as u64, &b),
    );
    for (name, unit, ideal, actual) in [
        ("with whole clusters", Some(Unit::Clusters), b.ideal_by_cluster, b.by_cluster),
        ("by the plane of each triangle too", None, b.facing_away, b.by_plane),
        (
            "and from the corners, where in doubt",
            Some(Unit::Triangles),
            b.facing_away,
            b.facing_away,
        ),
    ] {
        let of_unit = s.stages.iter().find(|r| r.stage == Stage::Backface && Some(r.unit) == unit);
        let ms = of_unit.and_then(|r| r.ms);
        let ms =
            ms.map_or_else(|| "–".into(), |ms| format!("{:.3} ms", ms / s.views.max(1) as f64));
        let _ = write!(
            out,
            "<tr><td>{name}</td>{}{}<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{ms}</td></tr>",
            n(ideal / views),
            n(actual / views),
            if ideal > 0 { percent(actual, ideal) } else { "–".into() },
            percent(actual, b.facing_away),
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// Notes on what the figures on back faces leave out, if anything.
fn counted(views: u64, b: &BackfaceRecord) -> String {
    let mut text = String::new();
    if b.views < views {
        let _ = write!(text, " Counted in {} of {views} views.", b.views);
    }
    if b.exact_instances > 0 {
        let _ = write!(
            text,
            " {} of {} instances are tested from their corners alone: so thin are their triangles, for where \
             they stand, that only that test is fine enough.",
            grouped(b.exact_instances / b.views.max(1)),
            grouped(b.instances / b.views.max(1)),
        );
    }
    text
}

/// Every view, folded away.
pub(crate) fn views(out: &mut String, views: &[ViewRecord]) {
    out.push_str(
        "<details><summary>All views as a table</summary><div class=\"scroll\"><table><thead><tr>\
         <th class=\"n\">View</th><th>Eye</th><th class=\"n\">Near</th><th class=\"n\">Far</th>\
         <th class=\"n\">Triangles</th><th class=\"n\">Left</th><th class=\"n\">Visible</th>\
         <th class=\"n\">Tightness</th><th class=\"n\">False culls</th><th class=\"n\">Instances left</th></tr>\
         </thead><tbody>",
    );
    let number = |v: Option<f64>| v.map_or_else(|| "–".into(), |v| format!("{v:.4}"));
    for v in views {
        let eye =
            v.eye.map_or_else(|| "parallel".into(), |e| e.map(|c| format!("{c:.1}")).join(", "));
        let _ = write!(
            out,
            "<tr><td class=\"n\">{}</td><td>{eye}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>{}{}\
             <td class=\"n\">{}</td><td class=\"n\">{}</td>{}{}</tr>",
            v.index,
            number(v.near),
            v.far.map_or_else(|| "∞".into(), |f| format!("{f:.1}")),
            n(v.triangles.all),
            n(v.triangles.potentially_visible),
            v.triangles.visible.map_or_else(|| "–".into(), grouped),
            v.tightness.map_or_else(|| "–".into(), |t| format!("{t:.2}")),
            n(v.false_culls),
            n(v.instances.potentially_visible),
        );
    }
    out.push_str("</tbody></table></div></details>\n");
}
