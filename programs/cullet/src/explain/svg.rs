//! An explanation as a drawing: the chain of tests from top to bottom, each value on a scale beside
//! its limit.

use cullet::cull::detail::{Detail, Measure};
use cullet::{
    Stage, View,
    explain::{CoverTest, Evidence, PlaneTest},
};
use cullet_command::console::grouped;
use cullet_draw::palette;

use super::chain::at;
use super::gauge::{Gauge, Scale, Sheet};
use super::record::{ExplainRecord, InstanceRecord, StepRecord, TriangleRecord};
use super::text;
use super::triangle::plane_name;

/// How to read distances to planes.
const PLANES_NOTE: &str = "signed distances on a logarithmic scale, the limit at 0: what is wholly to the right of it is outside";

/// The drawing. `detail` is what sizes were held against.
pub(super) fn draw(record: &ExplainRecord, view: &View, detail: Option<&Detail>) -> String {
    let mut sheet = Sheet::default();
    sheet.skip(14.0);
    let name = match (&record.instance, &record.pixel) {
        (Some(instance), _) => format!("“{}”", instance.name),
        (None, Some(pixel)) => format!("pixel {},{}", pixel.at[0], pixel.at[1]),
        (None, None) => record.scene.clone(),
    };
    sheet.title(&name);
    for line in text::about(record) {
        sheet.plain(&line);
    }
    if let Some(instance) = &record.instance {
        sheet.skip(8.0);
        for step in &instance.steps {
            draw_step(&mut sheet, step, instance, view, detail);
            sheet.arrow();
        }
        if let Some(triangle) = &instance.triangle {
            draw_triangle(&mut sheet, triangle);
            sheet.arrow();
        }
        sheet.begin(palette::reason_color(instance.stage));
        sheet.words(&instance.sentence);
        sheet.end();
    }
    sheet.skip(20.0);
    let title = match &record.instance {
        Some(instance) => format!("{name}: {}", instance.sentence),
        None => name,
    };
    sheet.finish(&title)
}

/// A stage: what entered, what it measured, and what came of it.
fn draw_step(
    sheet: &mut Sheet,
    step: &StepRecord,
    instance: &InstanceRecord,
    view: &View,
    detail: Option<&Detail>,
) {
    let dropped = palette::reason_color(Some(step.stage));
    let color = match step.left {
        0 if step.entered > 0 => dropped,
        _ => palette::SEEN,
    };
    sheet.begin(color);
    sheet.head(step.stage.name(), step.unit.name(), step.outcome);
    if let Evidence::Planes(tests) = &step.evidence {
        draw_planes(sheet, tests, dropped);
    } else {
        let lines = text::numbers(step, view);
        if lines.is_empty() {
            sheet.words(&step.finding);
        }
        lines.iter().for_each(|line| sheet.words(line));
        if let Some((gauge, note)) = gauge(step, instance, view, detail) {
            let gauges = [gauge];
            sheet.gauge(&gauges[0], &Scale::of(&gauges, false), dropped);
            sheet.note(&note);
        }
    }
    if step.entered != 1 {
        let number = format!("{} of {}", grouped(step.left), grouped(step.entered));
        sheet.share("left", &number, step.left as f64 / step.entered as f64, dropped);
    }
    sheet.end();
}

fn draw_planes(sheet: &mut Sheet, tests: &[PlaneTest], tint: [u8; 3]) {
    let gauge = |t: &PlaneTest| Gauge {
        label: plane_name(t.plane),
        number: format!("{:.4} to {:.4}", t.nearest, t.farthest),
        value: [t.nearest, t.farthest],
        limit: 0.0,
        drops_above: true,
    };
    let gauges: Vec<Gauge> = tests.iter().map(gauge).collect();
    let scale = Scale::of(&gauges, true);
    gauges.iter().for_each(|gauge| sheet.gauge(gauge, &scale, tint));
    sheet.note(PLANES_NOTE);
}

/// Returns what a stage compared to a limit, and how to read it; none where no number was measured.
fn gauge(
    step: &StepRecord,
    instance: &InstanceRecord,
    view: &View,
    detail: Option<&Detail>,
) -> Option<(Gauge, String)> {
    match &step.evidence {
        Evidence::Size { pixels, weight } => size(*pixels, f64::from(*weight), detail?),
        Evidence::Cover(test) => Some(cover(test, view)),
        Evidence::Area { with_area, .. } => {
            let value = f64::from(*with_area);
            let (label, number) = ("with area".to_owned(), grouped(u64::from(*with_area)));
            let note = "triangles with an area, the limit at 0: with none it is dropped".to_owned();
            Some((at_point(label, number, value, 0.0, false), note))
        }
        Evidence::Levels { pixels, .. } => {
            let allowed = instance.level?.allowed_px;
            let (label, number) = ("off by".to_owned(), format!("{pixels:.3} px"));
            let note =
                format!("pixels; the limit is {allowed}, and coarser levels would be above it");
            Some((at_point(label, number, *pixels, allowed, true), note))
        }
        _ => None,
    }
}

fn at_point(label: String, number: String, value: f64, limit: f64, drops_above: bool) -> Gauge {
    Gauge { label, number, value: [value; 2], limit, drops_above }
}

fn size([w, h]: [f64; 2], weight: f64, detail: &Detail) -> Option<(Gauge, String)> {
    let (w, h) = (w * weight, h * weight);
    let (label, value, unit) = match detail.measure {
        Measure::WidthAndHeight => ("longer side", w.max(h), "px"),
        Measure::Area => ("area", w * h, "square px"),
        Measure::Diameter => ("diagonal", w.hypot(h), "px"),
    };
    let limit = detail.threshold_px;
    let note = format!("the limit is {limit} {unit}: what is below it is dropped");
    value.is_finite().then(|| {
        (at_point(label.to_owned(), format!("{value:.2} {unit}"), value, limit, false), note)
    })
}

/// How near it comes, against how near all that it may touch is covered.
fn cover(test: &CoverTest, view: &View) -> (Gauge, String) {
    let (nearness, covered) = (f64::from(test.nearness), f64::from(test.covered));
    let gauge = at_point("nearest".to_owned(), at(test.nearness, view), nearness, covered, false);
    let scale = if view.is_orthographic() { "nearness" } else { "1 / distance" };
    let note = match test.covered {
        0.0 => format!("{scale}, the limit at 0: some of its pixels are not covered at all"),
        limit => format!("{scale}; the limit is {}: what is farther is hidden", at(limit, view)),
    };
    (gauge, note)
}

/// The tests of a triangle.
fn draw_triangle(sheet: &mut Sheet, record: &TriangleRecord) {
    let color = palette::reason_color(record.stage);
    sheet.begin(color);
    let outcome = if record.drawn { "drawn" } else { "dropped" };
    sheet.head(&format!("triangle {}", record.triangle), "", outcome);
    draw_planes(sheet, &record.planes, palette::reason_color(Some(Stage::Frustum)));
    if let Some(value) = record.facing {
        let gauge = at_point("n·(eye − p)".to_owned(), format!("{value:.6}"), value, 0.0, false);
        let gauges = [gauge];
        let tint = palette::reason_color(Some(Stage::Backface));
        sheet.gauge(&gauges[0], &Scale::of(&gauges, false), tint);
        sheet.note(&format!(
            "the limit at 0: below it the eye is behind; it sees its {}",
            record.side
        ));
    }
    sheet.words(&record.sentence);
    sheet.end();
}
