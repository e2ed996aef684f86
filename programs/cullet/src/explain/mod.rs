//! `cullet explain`: why one instance of one view is drawn or not, test by test.

mod args;
mod chain;
mod gauge;
mod record;
mod svg;
mod target;
mod text;
mod triangle;

use std::path::Path;

use cullet::{Output, Stage, View, ViewState, Visible};
use cullet_command::console::Console;
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_draw::{Frame, Highlight, PixelId, RenderOptions, Selection};
use cullet_io::Model;

use crate::levels;
use crate::names::name_of;
pub(crate) use args::{ExplainArgs, HELP};
use record::{BehindRecord, ExplainRecord, PixelRecord, SCHEMA, ViewPlace};

/// Runs the command.
pub(crate) fn run(args: &ExplainArgs, console: &Console) -> Outcome {
    let form = args.out.as_deref().map(Form::of).transpose()?;
    let mut model = levels::load(&args.input.scene, &args.input.cull, console)?;
    inputs::give_occluders(&mut model, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let view = view(args, &mut model, console)?;
    let culler = inputs::culler(&args.input.cull)
        .with_output(Output::Triangles)
        .with_reasons(true)
        .with_dropped(true);
    model.scene.prepare(&culler);
    let scene = &model.scene;
    if let Some(pixel) = args.pixel {
        target::check_pixel(pixel, &view)?;
    }
    let named = args.instance.as_deref().map(|name| target::by_name(&model, name)).transpose()?;
    let mut result = Visible::default();
    model.in_cells().cull(&culler, &view, &mut ViewState::default(), &mut result);
    let threads = args.input.view.threads;
    let options = RenderOptions { threads, ..RenderOptions::default() };
    let frame = cullet_draw::render(scene, &view, Selection::All, &options);
    let pixel = args.pixel.map(|at| pixel_record(&model, &view, &result, &frame, at));
    let owner = args.pixel.map(|[x, y]| frame.id(x, y)).filter(|id| *id != PixelId::NONE);
    let slot = named.or(owner.map(|id| id.slot));
    let mut hidden_by = Vec::new();
    let mut instance = None;
    if let Some(slot) = slot {
        let (mut told, by) = chain::explain(&model, &view, &culler, &result, &frame, slot)?;
        let wanted = args.triangle.or(owner.map(|id| id.triangle));
        let in_full = told.level.is_none();
        told.triangle = wanted
            .filter(|_| in_full)
            .map(|t| triangle::explain(scene, &view, &result, &frame, (slot, t)))
            .transpose()?;
        (instance, hidden_by) = (Some(told), by);
    }
    let record = ExplainRecord {
        schema: SCHEMA,
        scene: model.name.clone(),
        view: ViewPlace {
            index: args.index,
            eye: view.eye(),
            size: view.viewport(),
            stages: inputs::stages(&args.input.cull, model.in_cells()).collect(),
        },
        pixel,
        instance,
    };
    text::lines(&record, &view).iter().for_each(|line| console.line(line));
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    if let (Some(path), Some(form)) = (&args.out, form) {
        let (bytes, size) = match form {
            Form::View => {
                let picture = picture(&model, &view, &record, slot, &hidden_by);
                (picture.to_png(), format!(", {}x{}", picture.width, picture.height))
            }
            Form::Chain => {
                (svg::draw(&record, &view, culler.detail.as_ref()).into_bytes(), String::new())
            }
        };
        std::fs::write(path, bytes).map_err(|e| Failure::write(path, &e))?;
        console.note(format!("{} written{size}", path.display()));
    }
    Ok(Exit::Fine)
}

/// Kind of drawing, chosen by the ending of the file.
#[derive(Clone, Copy, Debug)]
enum Form {
    /// The instance in its view, as PNG.
    View,
    /// The chain of its tests, as SVG.
    Chain,
}

impl Form {
    fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("png") => Ok(Self::View),
            Some("svg") => Ok(Self::Chain),
            _ => Err(Failure::usage(format!(
                "{}: a picture of the view is written as .png, the chain of tests as .svg",
                path.display()
            ))),
        }
    }
}

/// The view of the arguments; the model is posed for it.
fn view(args: &ExplainArgs, model: &mut Model, console: &Console) -> Result<View, Failure> {
    let mut views = inputs::culled_views(model, &args.input.view, &args.input.cull, console)?;
    let times = inputs::times(&args.input.view, views.len());
    if let Some(&seconds) = times.get(args.index as usize) {
        inputs::pose(model, seconds)?;
    }
    if args.index as usize >= views.len() {
        return Err(Failure::usage(format!(
            "--view {}: the path's last view is {}",
            args.index,
            views.len().saturating_sub(1)
        )));
    }
    Ok(views.swap_remove(args.index as usize))
}

/// Returns what is at a pixel and behind it.
fn pixel_record(
    model: &Model,
    view: &View,
    result: &Visible,
    frame: &Frame,
    at: [u32; 2],
) -> PixelRecord {
    let scene = &model.scene;
    let owner = Some(frame.id(at[0], at[1])).filter(|id| *id != PixelId::NONE);
    let (behind, more_behind) = target::behind(scene, view, result, at);
    let record = |b: target::Behind| {
        let handle = scene.handle(b.slot)?;
        let name = name_of(model, b.slot);
        Some(BehindRecord { name, handle, distance: b.distance, stage: b.stage })
    };
    PixelRecord {
        at,
        triangle: owner.map(|id| id.triangle),
        distance: owner.map(|_| target::distance_of(view, frame, at)),
        behind: behind.into_iter().filter_map(record).collect(),
        more_behind,
    }
}

/// The instance in its view; from outside, where it is not in it.
fn picture(
    model: &Model,
    view: &View,
    record: &ExplainRecord,
    slot: Option<u32>,
    hidden_by: &[u32],
) -> cullet_draw::Picture {
    let instance = record.instance.as_ref();
    let stage = instance.and_then(|instance| instance.stage);
    let highlight = Highlight {
        slot,
        stage,
        hidden_by,
        bounds: instance.and_then(|instance| text::screen_bounds(instance, view)),
        pixel: record.pixel.as_ref().map(|pixel| pixel.at),
        words: &text::caption(record),
    };
    let colors = inputs::colors(model);
    let is_beside = matches!(stage, Some(Stage::Frustum | Stage::Pvs | Stage::Portal));
    if is_beside {
        highlight.from_outside(&model.scene, view, &colors)
    } else {
        highlight.in_view(&model.scene, view, &colors)
    }
}
