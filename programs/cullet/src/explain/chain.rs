//! The chain of tests of an instance: from the engine's explanation to a record.

use cullet::lod::{LevelEye, Lod, NO_GROUP, PixelScale};
use cullet::{
    Culler, Scene, Stage, View, Visible,
    explain::{Evidence, Explanation, Step},
};
use cullet_command::console::{agree, count, grouped};
use cullet_command::exit::Failure;
use cullet_draw::Frame;
use cullet_io::Model;

use super::record::{InstanceRecord, LevelRecord, StepRecord};
use super::triangle::plane_name;
use crate::names::{mesh_name, name_of, reason_text};

/// Explains an instance. `frame` is the view without culling, and `result` its cull with triangles,
/// reasons and drops.
pub(super) fn explain(
    model: &Model,
    view: &View,
    culler: &Culler,
    result: &Visible,
    frame: &Frame,
    slot: u32,
) -> Result<(InstanceRecord, Vec<u32>), Failure> {
    let scene = &model.scene;
    let handle = scene
        .handle(slot)
        .ok_or_else(|| Failure::usage(format!("instance {slot}: there is none in that slot")))?;
    let told = model.in_cells().explain(culler, view, handle).map_err(Failure::usage)?;
    let origin = scene.origin();
    let bounds = scene.bounds(slot);
    let world = |p: [f32; 3]| [0, 1, 2].map(|a| f64::from(p[a]) + origin[a]);
    let drawn = result.triangle_ranges.iter().filter(|r| r.slot == slot);
    let drawn_triangles = drawn.map(|r| u64::from(r.count)).sum();
    let owned_pixels = frame.ids.iter().filter(|id| id.slot == slot).count() as u64;
    let steps = told.steps.iter().map(|step| step_record(culler, step)).collect();
    let mut record = InstanceRecord {
        name: name_of(model, slot),
        handle,
        mesh: mesh_name(model, scene.mesh_id(slot)),
        bounds: [world(bounds.min), world(bounds.max)],
        triangles: u64::from(scene.mesh(slot).triangle_count()),
        drawn_triangles,
        owned_pixels,
        kept: told.reason.is_none(),
        stage: told.reason.map(|r| r.stage),
        reason: told.reason.map(reason_text),
        steps,
        hidden_by: told.hidden_by.iter().map(|&by| name_of(model, by)).collect(),
        level: level(scene, view, culler.lod.as_ref(), result, slot),
        triangle: None,
        sentence: String::new(),
    };
    record.sentence = sentence(&record, &told, view);
    Ok((record, told.hidden_by))
}

fn step_record(culler: &Culler, step: &Step) -> StepRecord {
    let outcome = match (step.left, step.entered) {
        (0, _) => "dropped",
        (left, entered) if left == entered => "passes",
        _ => "passes in part",
    };
    let is_size = matches!(step.evidence, Evidence::Size { .. });
    StepRecord {
        stage: step.stage,
        unit: step.unit,
        entered: step.entered,
        left: step.left,
        outcome,
        finding: step.to_string(),
        evidence: step.evidence.clone(),
        limit: culler.detail.filter(|_| is_size).map(|detail| detail.threshold_px),
    }
}

/// The level of detail that an instance is drawn at, and by how much it may be off.
fn level(
    scene: &Scene,
    view: &View,
    lod: Option<&Lod>,
    result: &Visible,
    slot: u32,
) -> Option<LevelRecord> {
    let allowed_px = result.lod_pixels?;
    let range = result.triangle_ranges.iter().find(|r| r.slot == slot && r.level > 0)?;
    let levels = &scene.levels(scene.mesh_id(slot)).get(range.level as usize - 1)?.levels;
    let lod = (*lod?).with_pixels(allowed_px).with_triangles(None);
    let scale = PixelScale::of(view, lod.at_corners);
    let eye = LevelEye::new(&lod, &scale, scene.transform(slot), view.eyes);
    let clusters = result.partial.iter().filter(|r| r.slot == slot);
    let clusters = clusters.flat_map(|r| r.first_cluster..r.first_cluster + r.cluster_count);
    let groups = clusters.filter_map(|c| levels.made_from().get(c as usize).copied());
    let errors = groups.filter(|&group| group != NO_GROUP).map(|group| {
        let of = levels.group(group as usize);
        // An error that is just allowed is as large as the threshold.
        f64::from(of.error) / f64::from(eye.allowed(of.centre, of.radius)) * allowed_px
    });
    let error_px = errors.fold(0.0, f64::max);
    Some(LevelRecord { level: range.level, error_px, allowed_px })
}

/// Why, in a sentence.
fn sentence(record: &InstanceRecord, told: &Explanation, view: &View) -> String {
    let Some(reason) = told.reason else { return kept(record, view) };
    let name = reason.stage.name();
    let step = told.steps.iter().rev().find(|step| step.stage == reason.stage && step.left == 0);
    let whole = step.map(|step| &step.evidence);
    let why = match (reason.stage, whole) {
        (Stage::Frustum, Some(Evidence::Planes(tests))) => {
            let named = tests.iter().find(|t| t.plane == reason.detail && t.nearest > 0.0);
            named.map_or_else(
                || "no plane alone has all of its box outside, but it is beyond the frustum".to_owned(),
                |t| {
                    format!(
                        "all of its box is outside the {} plane, by {:.4} units at the nearest corner",
                        plane_name(t.plane),
                        t.nearest
                    )
                },
            )
        }
        (Stage::Frustum, _) => "its parts are outside of different planes".to_owned(),
        (Stage::Occlusion, Some(Evidence::Cover(cover))) => {
            let [x0, y0] = cover.min;
            let [x1, y1] = cover.max;
            format!(
                "its nearest point is {}, and every pixel of its screen bounds ({x0}..={x1} x {y0}..={y1} of the buffer's \
                 {}x{}) is covered {} or nearer{}",
                at(cover.nearness, view),
                cover.buffer[0],
                cover.buffer[1],
                at(cover.covered, view),
                by(&record.hidden_by)
            )
        }
        (Stage::Occlusion, _) => "each of its clusters that was left is occluded".to_owned(),
        (Stage::Detail, Some(Evidence::Size { pixels: [w, h], .. })) => {
            format!("on the screen it is {w:.2} x {h:.2} pixels, under the limit")
        }
        (Stage::Backface, _) => {
            "each of its triangles that was left faces away from the eye".to_owned()
        }
        _ => step.map_or_else(|| reason_text(reason), Step::to_string),
    };
    format!("dropped by {name}: {why}")
}

fn kept(record: &InstanceRecord, view: &View) -> String {
    let [w, h] = view.viewport().map(u64::from);
    let drawn = format!(
        "{} of its {} {} drawn",
        grouped(record.drawn_triangles),
        count(record.triangles, "triangle", "triangles"),
        agree(record.drawn_triangles, "is", "are")
    );
    let all = grouped(w * h);
    match record.owned_pixels {
        0 => format!(
            "kept: drawn because no stage could prove it invisible, though it owns none of {all} pixels; {drawn}"
        ),
        n => format!(
            "kept: drawn because no stage could prove it invisible; it owns {} of {all}; {drawn}",
            count(n, "pixel", "pixels")
        ),
    }
}

/// Where something of a nearness is, in words.
pub(super) fn at(nearness: f32, view: &View) -> String {
    match (view.is_orthographic(), nearness) {
        (_, 0.0) => "nowhere".to_owned(),
        (true, nearness) => format!("at nearness {nearness}"),
        // The distance along the line of sight of the view's centre.
        (false, nearness) => format!("at distance {:.4}", 1.0 / f64::from(nearness)),
    }
}

/// Who hides something, in words: the first names.
fn by(names: &[String]) -> String {
    const NAMED: usize = 3;
    let named: Vec<String> = names.iter().take(NAMED).map(|n| format!("“{n}”")).collect();
    match names.len() {
        0 => String::new(),
        n if n <= NAMED => format!(", by {}", named.join(", ")),
        n => format!(", by {} and {} more", named.join(", "), n - NAMED),
    }
}
