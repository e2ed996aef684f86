//! `cullet simplify`: a scene of few triangles, and how far it is off.

mod eye;
mod mesh;
mod uses;

use crate::simplify_args::SimplifyArgs;
use cullet_command::console::{Console, count, grouped, interrupted, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{save_model, write_json};
use cullet_command::inputs;
use cullet_io::{Model, SaveErrorKind, SaveFormat};
use serde::Serialize;

use eye::eyes;
use mesh::{Goal, Settings, Simplified};
use uses::Uses;

/// Version of the JSON.
const SCHEMA: u32 = 1;

/// The figures. Lengths are shares of the bounding radius; counts are of what is drawn, each
/// instance of a mesh anew.
#[derive(Debug, Default, Serialize)]
struct Record {
    schema: u32,
    /// Triangles of the result.
    triangles: u64,
    /// The largest deviation that was measured while it was made: at most 1.08 of what was asked
    /// for where that is one bound for all. Of the hierarchy of clusters, the largest error that it
    /// states of what is drawn.
    error: f64,
    /// The largest deviation of independent points.
    error_measured_max: f64,
    /// Bound that 99.9 % of the independent points of every mesh stay within.
    error_measured_p999: f64,
    /// Open edges of the result, by positions.
    open_edges: u64,
    triangles_before: u64,
    open_edges_before: u64,
    /// Independent points that were measured.
    points: u64,
    /// The bounding radius, in world units.
    radius: f64,
}

/// Runs the command.
pub(crate) fn run(args: &SimplifyArgs, console: &Console) -> Outcome {
    // Known before minutes of work are done.
    if let Some(out) = args.out.as_deref().filter(|p| SaveFormat::of(p).is_none()) {
        let kind = SaveErrorKind::Unsupported;
        return Err(Failure::usage(format!("{}: {kind}", out.display())));
    }
    let mut model = inputs::load_to_save(&args.scene, console)?;
    if model.motion.take().is_some_and(|motion| motion.moves()) {
        console.note("note: what moves in it stands as it is stored, and moves no longer");
    }
    let mut record = simplify(&mut model, args, console)?;
    if let Some(path) = &args.out {
        record.triangles = save_model(&model, path, console)?.triangles;
    }
    print(&record, console);
    if let Some(path) = &args.out {
        console.line(format!("{} written", path.display()));
    }
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(Exit::Fine)
}

/// Puts simplified meshes in the place of those that are drawn.
fn simplify(model: &mut Model, args: &SimplifyArgs, console: &Console) -> Result<Record, Failure> {
    let uses = Uses::of(&model.scene);
    let mut record = Record {
        schema: SCHEMA,
        triangles_before: model.scene.triangle_count(),
        radius: uses.radius,
        ..Record::default()
    };
    let seen = args.pixels.zip(args.distance);
    let seen = seen.map(|(pixels, distance)| eyes(&model.scene, &uses, pixels, distance));
    let drawn = uses.meshes.iter().filter(|u| u.count > 0).count();
    let mut progress = console.progress("simplifying", drawn as u64);
    let mut seams = 0;
    for (number, of) in uses.meshes.iter().enumerate().filter(|(_, u)| u.count > 0) {
        if interrupted() {
            let message = "interrupted; nothing was written".into();
            return Err(Failure { exit: Exit::Interrupted, message });
        }
        let goal = match &seen {
            Some(eyes) => Goal::Seen(&eyes[number]),
            // In the mesh's own units, where its largest instance keeps the bound.
            None if of.scale > 0.0 => {
                Goal::Bound(args.error.unwrap_or(0.0) * uses.radius / of.scale)
            }
            None => Goal::Bound(0.0),
        };
        let settings =
            Settings { goal, weld: args.weld, samples: uses.samples(number, args.samples) };
        let mesh = &model.scene.meshes()[number];
        let attributes = model.attributes.get(number);
        let made = mesh::simplify(mesh, attributes, &settings).map_err(|e| {
            let name = model.mesh_names.get(number).map_or("", String::as_str);
            Failure::input(format!("{}: mesh `{name}`: {e}", args.scene.scene))
        })?;
        let Simplified { mesh, attributes, error, deviation, split } = made;
        let share = |length: f32| {
            if uses.radius > 0.0 { f64::from(length) * of.scale / uses.radius } else { 0.0 }
        };
        record.error = record.error.max(share(error));
        record.error_measured_max = record.error_measured_max.max(share(deviation.max));
        record.error_measured_p999 = record.error_measured_p999.max(share(deviation.p999));
        record.open_edges_before += u64::from(deviation.open_edges[0]) * of.count;
        record.open_edges += u64::from(deviation.open_edges[1]) * of.count;
        record.points += deviation.points;
        seams += split;
        if let Some(mesh) = mesh {
            model.scene.edit_mesh(number as u32, |m| *m = mesh);
            if let Some(slot) = model.attributes.get_mut(number) {
                *slot = attributes;
            }
        }
        progress.step();
    }
    progress.finish();
    record.triangles = model.scene.triangle_count();
    if seams > 0 {
        console.note(format!(
            "note: {} of normals, texture coordinates or colours; --weld joins them, for fewer triangles",
            count(seams, "position lies on a seam", "positions lie on seams")
        ));
    }
    Ok(record)
}

fn print(r: &Record, console: &Console) {
    console.line(format!(
        "{} of {} triangles left, {}",
        grouped(r.triangles),
        grouped(r.triangles_before),
        percent(r.triangles, r.triangles_before)
    ));
    console.line(format!(
        "off by {:.6} of the bounding radius ({:.6} units) at most, as measured from {}; 99.9 % by no more than {:.6}",
        r.error_measured_max,
        r.error_measured_max * r.radius,
        count(r.points, "other point", "other points"),
        r.error_measured_p999
    ));
    console.line(format!(
        "open edges: {} before, {} after",
        grouped(r.open_edges_before),
        grouped(r.open_edges)
    ));
}
