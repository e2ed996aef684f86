//! Advice on occlusion culling: where it does not pay, and which meshes ought to hide more.

use cullet::Stage;
use cullet::mesh::Alpha;
use cullet_command::console::{agree, count, grouped, percent};

use super::context::{Context, shown};
use crate::record::{Advice, MeshRecord, StageRecord};

/// Under this share of what is in the frustum, occlusion culling does not pay.
const FEW_PERCENT: u64 = 3;
/// A mesh that owns less than this share of the pixels could hide little.
const LARGE_PERCENT: u64 = 2;

/// The stage took longer than what it dropped would have cost, or dropped next to nothing.
pub(super) fn does_not_pay(ctx: &Context<'_>, drawn_ns: Option<f64>) -> Option<Advice> {
    let rows = || ctx.summary.stages.iter().filter(|s| s.stage == Stage::Occlusion);
    let entered = rows().next()?;
    let views = ctx.views as u64;
    let took = rows().filter_map(|s| s.ms).sum::<f64>() / views as f64;
    let triangles: u64 = rows().map(StageRecord::taken).sum();
    let hidden: u64 = rows().map(|s| s.instances[0].saturating_sub(s.instances[1])).sum();
    let few = triangles * 100 < entered.triangles[0] * FEW_PERCENT;
    let saved = drawn_ns.map(|ns| triangles as f64 * ns * 1e-6 / views as f64);
    let is_slower = saved.is_some_and(|ms| took > ms);
    if entered.entered == 0 || !(few || is_slower) {
        return None;
    }
    let found = format!(
        "It hid {} of {} in the frustum per view, and with their hidden parts {} of the triangles there, in \
         {took:.2} ms",
        grouped(hidden / views),
        count(entered.instances[0] / views, "instance", "instances"),
        percent(triangles, entered.triangles[0]),
    );
    let text = match saved {
        Some(ms) => format!("{found}; drawing those would have taken {ms:.2} ms."),
        None => format!("{found}."),
    } + " On views like these, leave it out (--no-occlusion), or lower --occlusion-width.";
    let title = if few {
        "Next to nothing is hidden: occlusion culling does not pay".to_owned()
    } else {
        "Occlusion culling takes longer than it saves".to_owned()
    };
    Some(ctx.advice("occlusion-does-not-pay", title, text, 0, Vec::new()))
}

/// Meshes that fill much of the views, and yet are proved to cover little of what they fill.
pub(super) fn poor_occluders(ctx: &Context<'_>) -> Option<Advice> {
    let tallies = &ctx.survey.meshes;
    let pixels: u64 = tallies.iter().map(|t| t.pixels).sum();
    let mut found: Vec<(u64, u64, &MeshRecord)> = ctx
        .meshes
        .iter()
        .filter_map(|m| {
            let t = tallies.get(m.mesh as usize)?;
            let large = t.pixels * 100 >= pixels * LARGE_PERCENT && t.pixels > 0;
            (large && t.open_pixels * 2 >= t.pixels).then_some((t.open_pixels, t.pixels, m))
        })
        .collect();
    found.sort_by_key(|&(open, _, m)| (std::cmp::Reverse(open), m.mesh));
    let &(open, owned, first) = found.first()?;
    let names: Vec<String> = found.iter().map(|f| f.2.name.clone()).collect();
    let text = format!(
        "{} much of the views, yet nothing is proved to lie behind most of {}: {}. The most: \u{201c}{}\u{201d} owns {} of all \
         pixels drawn, of which {} hide nothing, for {}. A large plain wall or box behind it would hide what \
         it cannot; `cullet occluders` makes such.",
        count(found.len() as u64, "mesh fills", "meshes fill"),
        agree(found.len() as u64, "it", "them"),
        shown(&names),
        first.name,
        percent(owned, pixels),
        percent(open, owned),
        why(ctx, first),
    );
    let title = format!(
        "{} much and {} little",
        count(found.len() as u64, "mesh covers", "meshes cover"),
        agree(found.len() as u64, "hides", "hide")
    );
    let drawn = found.iter().map(|f| f.2.drawn).sum();
    Some(ctx.advice("poor-occluder", title, text, drawn, names))
}

/// The reason why a mesh does not occlude.
fn why(ctx: &Context<'_>, record: &MeshRecord) -> String {
    let mesh = &ctx.model.scene.meshes()[record.mesh as usize];
    let see_through = mesh.parts().iter().filter(|p| p.alpha != Alpha::Opaque).count();
    if mesh.is_deformable() {
        "it deforms, and is elsewhere in the next frame".into()
    } else if see_through > 0 {
        match mesh.parts().len() {
            1 => "it can be seen through".into(),
            all => format!("{see_through} of its {all} parts can be seen through"),
        }
    } else if ctx.model.scene.prepared()[record.mesh as usize].shapes().is_empty() {
        "it has no proxy (`--occluders mesh` draws the mesh itself)".into()
    } else if let Some(defect) = &record.defect {
        format!("{defect}, and its parts are too thin to cover whole pixels")
    } else {
        "its parts are too thin to cover whole pixels, or the budget did not reach to it".into()
    }
}
