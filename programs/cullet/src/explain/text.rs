//! An explanation in lines.

use cullet::{
    View,
    explain::{Evidence, PlaneTest},
};
use cullet_command::console::{count, grouped};

use super::chain::at;
use super::record::{ExplainRecord, InstanceRecord, StepRecord, TriangleRecord};
use super::triangle::plane_name;

/// All lines.
pub(super) fn lines(record: &ExplainRecord, view: &View) -> Vec<String> {
    let mut lines: Vec<String> = owner(record).into_iter().collect();
    if let Some(instance) = &record.instance {
        lines.extend(of_instance(instance, view));
    }
    if let Some(pixel) = &record.pixel {
        if pixel.behind.is_empty() {
            lines.push("no culled instance lies at that pixel".to_owned());
        } else {
            lines.push("culled instances at that pixel, the nearest first:".to_owned());
        }
        for behind in &pixel.behind {
            let (distance, name, stage) = (behind.distance, &behind.name, behind.stage.name());
            lines.push(format!("  at distance {distance:>10.4}  “{name}”, dropped by {stage}"));
        }
        if pixel.more_behind {
            lines.push("  and more".to_owned());
        }
    }
    lines
}

/// Returns the owner of the pixel that was asked for.
fn owner(record: &ExplainRecord) -> Option<String> {
    let pixel = record.pixel.as_ref()?;
    let [x, y] = pixel.at;
    let owner = match (&record.instance, pixel.triangle, pixel.distance) {
        (Some(of), Some(triangle), Some(distance)) => {
            format!("owned by triangle {triangle} of “{}”, at distance {distance:.4}", of.name)
        }
        _ => "nothing is there".to_owned(),
    };
    Some(format!("pixel {x},{y}: {owner}"))
}

/// Returns the lines beneath the name of an instance: its mesh, its view, and the owner of the
/// pixel.
pub(super) fn about(record: &ExplainRecord) -> Vec<String> {
    let view = format!("view {} of {}", record.view.index, record.scene);
    let mesh = record.instance.as_ref().map(mesh);
    mesh.into_iter().chain([view]).chain(owner(record)).collect()
}

fn mesh(record: &InstanceRecord) -> String {
    let triangles = count(record.triangles, "triangle", "triangles");
    let cullet::Handle { index, generation } = record.handle;
    format!("mesh “{}”, {triangles}, handle {index}:{generation}", record.mesh)
}

fn of_instance(record: &InstanceRecord, view: &View) -> Vec<String> {
    let mut lines = vec![format!("“{}”: {}", record.name, mesh(record))];
    for step in &record.steps {
        lines.extend(of_step(step, view));
    }
    if let Some(level) = record.level {
        lines.push(format!(
            "  level {} is drawn: off by {:.3} pixels at the most, {} allowed",
            level.level, level.error_px, level.allowed_px
        ));
    }
    if let Some(triangle) = &record.triangle {
        lines.extend(of_triangle(triangle));
    }
    lines.push(record.sentence.clone());
    lines
}

/// A stage: its name, what came of it, and its numbers.
fn of_step(step: &StepRecord, view: &View) -> Vec<String> {
    let (stage, unit) = (step.stage.name(), step.unit.name());
    let counts = if step.entered == 1 {
        String::new()
    } else {
        format!(", {} of {} left", grouped(step.left), grouped(step.entered))
    };
    let head = format!("  {stage:<10} {unit:<9} {}{counts}", step.outcome);
    let mut lines = vec![head];
    let numbers = numbers(step, view);
    if numbers.is_empty() {
        lines.push(format!("             {}", step.finding));
    }
    lines.extend(numbers.into_iter().map(|line| format!("             {line}")));
    lines
}

/// The numbers of a stage, in lines; none where words are all there is.
pub(super) fn numbers(step: &StepRecord, view: &View) -> Vec<String> {
    match &step.evidence {
        Evidence::Planes(tests) => planes(tests),
        Evidence::Size { pixels: [w, h], weight } => {
            let limit = step.limit.map_or_else(String::new, |px| format!(", limit {px}"));
            vec![format!("{w:.2} x {h:.2} pixels on the screen, counted {weight} times{limit}")]
        }
        Evidence::Cover(test) => {
            let ([x0, y0], [x1, y1], [w, h]) = (test.min, test.max, test.buffer);
            let open = test.open.map_or_else(
                || "no pixel lets it through".to_owned(),
                |[x, y]| format!("pixel {x},{y} lets it through"),
            );
            vec![
                format!("screen bounds {x0}..={x1} x {y0}..={y1} of a buffer of {w}x{h}"),
                format!(
                    "its nearest point {}, covered there {}: {open}",
                    at(test.nearness, view),
                    at(test.covered, view)
                ),
            ]
        }
        _ => Vec::new(),
    }
}

/// Signed distances of the nearest and the farthest corner to each plane.
fn planes(tests: &[PlaneTest]) -> Vec<String> {
    let line = |t: &PlaneTest| {
        let outside = if t.nearest > 0.0 { "  outside" } else { "" };
        format!("{:<7} {:>12.4} to {:>12.4}{outside}", plane_name(t.plane), t.nearest, t.farthest)
    };
    tests.iter().map(line).collect()
}

fn of_triangle(record: &TriangleRecord) -> Vec<String> {
    let cluster = record.cluster.map_or("no cluster".to_owned(), |c| format!("cluster {c}"));
    let mut lines =
        vec![format!("  triangle {} of {cluster}, area {:.6}", record.triangle, record.area)];
    lines.extend(planes(&record.planes).into_iter().map(|line| format!("             {line}")));
    if let Some(value) = record.facing {
        let side = record.side;
        lines.push(format!("             n·(eye − p) = {value:.6}: the eye sees its {side}"));
    }
    if let Some(cone) = record.cone {
        let not = if cone.behind { "" } else { "not " };
        lines.push(format!(
            "             cone of its cluster: along {:.6} (below 0), within {:.6} (above 0): {not}all of it faces away",
            cone.along, cone.within
        ));
    }
    lines.push(format!("  {}", record.sentence));
    lines
}

/// The screen bounds of an instance in pixels of its view, as occlusion took them: the first corner
/// and the last.
pub(super) fn screen_bounds(record: &InstanceRecord, view: &View) -> Option<[[f64; 2]; 2]> {
    let cover = record.steps.iter().find_map(|step| match step.evidence {
        Evidence::Cover(cover) => Some(cover),
        _ => None,
    })?;
    let viewport = view.viewport();
    let pixel = |v: [u32; 2]| {
        [0, 1].map(|a| f64::from(v[a]) * f64::from(viewport[a]) / f64::from(cover.buffer[a]))
    };
    Some([pixel(cover.min), pixel(cover.max.map(|v| v + 1))])
}

/// The words of a picture: who it is, and why.
pub(super) fn caption(record: &ExplainRecord) -> Vec<String> {
    match &record.instance {
        None => vec!["nothing is at that pixel".to_owned()],
        Some(instance) => {
            let mut lines = vec![format!("“{}”", instance.name)];
            lines.extend(wrapped(&instance.sentence));
            // The font of pictures has no narrow space.
            lines.into_iter().map(|line| line.replace('\u{202f}', ",")).collect()
        }
    }
}

/// Lines of some words each.
fn wrapped(text: &str) -> Vec<String> {
    const MOST: usize = 92;
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last].push_str(word);
        } else if lines[last].len() + word.len() < MOST {
            lines[last] += &format!(" {word}");
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}
