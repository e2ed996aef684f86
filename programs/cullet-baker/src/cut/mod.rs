//! `cullet cut`: a scene cut open at planes, with caps.

mod defects;
mod picture;
mod standpoint;
mod svg;

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use cullet::bounds::Plane;
use cullet_command::args::{PictureViewArgs, SceneArgs};
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{save_model, write_json};
use cullet_command::{inputs, parse};
use cullet_cut::{
    CutModel, Keep, MAX_CUT_PLANES, ModelError, ModelOptions, ModelReport, box_planes, cut_model,
};
use cullet_io::{Model, Motion, SaveErrorKind, SaveFormat};
use serde::Serialize;

use cullet_cli::SCHEMA;
use cullet_cli::shape;

/// End of `cullet cut --help`.
pub(crate) const HELP: &str = "\
A plane is nx,ny,nz,d: all points with n.x = d, in world units. What has n.x < d is kept. Several planes
make a convex region; --keep outside keeps all but that. --cap closes what was closed before the cut:
each cap is a part of its own, with the material 'cut face'. Instances that no plane touches stay as they
are and go on sharing their mesh. Normals, texture coordinates and colours of vertices are carried along, and
in GLB the tree of nodes.

Where the outline at the cut does not close, because the surface has a hole there, there is no cap, and
it is said of which mesh; --weld DISTANCE first moves vertices as near as that to one position, which closes
seams that do not quite meet, and --heal DISTANCE joins ends as near as that by a straight line.

Examples
  cullet cut model.glb --plane 0,0,1,0 --cap -o half.glb
  cullet cut house.glb --plane 0,1,0,2.4 --cap --section plan.svg --picture plan.png
  cullet cut engine.glb --box 0,0,0,9,9,9 --keep outside --cap -o open.stl
  cullet cut scan.ply --plane 1,0,0,0 --cap --weld 0.001 --heal 0.01 -o half.ply";

/// `cullet cut`
#[derive(Debug, Args)]
pub struct CutArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Cut at this plane; may be given several times
    #[arg(long, value_name = "NX,NY,NZ,D", value_parser = shape::plane, allow_hyphen_values = true, required_unless_present = "cut_box")]
    plane: Vec<Plane>,
    /// Cut at the six planes of this box
    #[arg(long = "box", value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = shape::bounds, allow_hyphen_values = true)]
    cut_box: Option<[f64; 6]>,
    /// Part that is kept: the inside of all planes, or the rest
    #[arg(long, value_parser = parse::choice(KEPT), default_value = "inside")]
    keep: Keep,
    /// Close the cut
    #[arg(long)]
    cap: bool,
    /// Distance up to which --cap and --section join ends of an open outline, in world units
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    heal: Option<f64>,
    /// Distance up to which --cap and --section move vertices of a mesh to one position before the
    /// cut, in world units
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    weld: Option<f64>,
    /// The file to write: .glb, .ply, .obj or .stl
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    out: Option<PathBuf>,
    /// Write the section as filled outlines
    #[arg(long, value_name = "SVG")]
    section: Option<PathBuf>,
    /// Draw what is left, seen from where it was opened
    #[arg(long, value_name = "PNG")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    aim: PictureViewArgs,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// Parts that may be kept, by their names on the command line.
const KEPT: &[(&str, Keep, &str)] = &[
    ("inside", Keep::Inside, "What is inside of all planes"),
    ("outside", Keep::Outside, "What is outside of any"),
];

/// The figures of a cut.
#[derive(Debug, Serialize)]
struct CutRecord<'a> {
    schema: u32,
    #[serde(flatten)]
    report: &'a ModelReport,
}

/// Runs the command.
pub(crate) fn run(args: &CutArgs, console: &Console) -> Outcome {
    // Known before minutes of work are done.
    if let Some(out) = args.out.as_deref().filter(|p| SaveFormat::of(p).is_none()) {
        let kind = SaveErrorKind::Unsupported;
        return Err(Failure::usage(format!("{}: {kind}", out.display())));
    }
    let mut planes = args.plane.clone();
    if let Some([a, b, c, d, e, f]) = args.cut_box {
        planes.extend(box_planes([a, b, c], [d, e, f]));
    }
    let count = planes.len();
    if count > MAX_CUT_PLANES {
        return Err(Failure::usage(format!(
            "{count} planes exceed the limit of {MAX_CUT_PLANES}; cut the result again"
        )));
    }
    let model = inputs::load_to_save(&args.scene, console)?;
    let scene = &model.scene;
    let has_levels = (0..scene.meshes().len() as u32).any(|m| !scene.levels(m).is_empty());
    let lost = [
        (model.textures > 0, "textures (not read)"),
        (model.motion.as_ref().is_some_and(Motion::moves), "motions (it is cut as it stands)"),
        (!model.views.is_empty(), "views that are matrices"),
        (!model.cells.cells.is_empty(), "cells and portals"),
        (has_levels, "levels of detail"),
    ];
    let lost: Vec<&str> = lost.iter().filter(|l| l.0).map(|l| l.1).collect();
    if !lost.is_empty() {
        console.note(format!("note: a cut leaves out {}", lost.join(", ")));
    }
    let options = ModelOptions {
        planes: &planes,
        keep: args.keep,
        caps: args.cap,
        outlines: args.section.is_some(),
        heal: args.heal.unwrap_or(0.0),
        weld: args.weld.unwrap_or(0.0),
        ..ModelOptions::default()
    };
    let CutModel { model: mut cut, mut report, sections, cap_material, .. } =
        cut(&model, &options, console)?;
    if let Some(path) = &args.out {
        report.triangles_after = save_model(&cut, path, console)?.triangles;
    }
    print(args, console, &report);
    if let Some(path) = &args.out {
        console.line(format!("{} written", path.display()));
    }
    if let Some(path) = &args.section {
        let text = svg::draw(&model, &planes, &sections);
        std::fs::write(path, text).map_err(|e| Failure::write(path, &e))?;
        console.line(format!("{} written", path.display()));
    }
    if let Some(path) = &args.picture {
        let eye = args.aim.line();
        let whole = model.scene.extent();
        let picture = picture::draw(&mut cut, &whole, &options, cap_material, eye, args.aim.size)?;
        std::fs::write(path, picture.to_png()).map_err(|e| Failure::write(path, &e))?;
        let (w, h) = (picture.width, picture.height);
        console.line(format!("{} written, {w}x{h}", path.display()));
    }
    if let Some(path) = &args.json {
        write_json(path, &CutRecord { schema: SCHEMA, report: &report })?;
    }
    Ok(Exit::Fine)
}

/// Cuts a model, with a bar and Ctrl-C.
fn cut(model: &Model, options: &ModelOptions<'_>, console: &Console) -> Result<CutModel, Failure> {
    let mut progress = console.progress("cutting", u64::from(model.scene.instance_count()));
    let each = || {
        progress.step();
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    cut_model(model, options, each).map_err(|e| match e {
        ModelError::Stopped => {
            let message = "interrupted; nothing was written".into();
            Failure { exit: Exit::Interrupted, message }
        }
        e => Failure::input(e),
    })
}

fn print(args: &CutArgs, console: &Console, r: &ModelReport) {
    console.line(format!(
        "{} before, {} after; of {} {} untouched, {} cut, {} dropped",
        count(r.triangles_before, "triangle", "triangles"),
        grouped(r.triangles_after),
        count(r.instances_before, "instance", "instances"),
        count(r.instances_untouched, "is", "are"),
        grouped(r.instances_cut),
        grouped(r.instances_dropped)
    ));
    if args.cap {
        console.line(format!(
            "caps: {}, {:.6} square units",
            count(r.cap_triangles, "triangle", "triangles"),
            r.cap_area
        ));
    }
    let found = [
        (
            count(r.duplicates_dropped, "duplicate triangle", "duplicate triangles"),
            r.duplicates_dropped,
            "at the cut dropped",
        ),
        (count(r.welded, "vertex was", "vertices were"), r.welded, "moved to meet others"),
        (
            count(r.healed, "gap in outlines was", "gaps in outlines were"),
            r.healed,
            "joined by a straight line",
        ),
        (
            count(r.even_odd_outlines, "outline has", "outlines have"),
            r.even_odd_outlines,
            "walls wound both ways: filled by the even-odd rule",
        ),
        (
            count(r.crossings, "point", "points"),
            r.crossings,
            "where the surface penetrates itself at the cut",
        ),
        (
            count(r.folded_caps, "cap crosses itself", "caps cross themselves"),
            r.folded_caps,
            "so often that the result is closed, but folded",
        ),
    ];
    for (many, _, what) in found.iter().filter(|f| f.1 > 0) {
        console.note(format!("note: {many} {what}"));
    }
    for line in defects::lines(&r.open_meshes, args.weld.is_some(), args.heal.is_some()) {
        console.note(line);
    }
    if r.triangles_after == 0 {
        console.note("note: nothing is left on the side that is kept");
    }
}
