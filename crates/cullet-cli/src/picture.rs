//! `cullet picture`: one picture of one view.

use cullet::{Output, ViewState, Visible};
use cullet_draw::{Picture, RenderOptions, Selection};

use crate::args::{PictureArgs, PictureKind};
use crate::console::Console;
use crate::drawing;
use crate::exit::{Exit, Failure, Outcome};
use crate::inputs;

/// Runs the command.
pub(crate) fn run(args: &PictureArgs, console: &Console) -> Outcome {
    let model = inputs::load(&args.scene, console)?;
    let views = inputs::views(&model, &args.view, console)?;
    let Some(view) = views.get(args.index as usize) else {
        let last = views.len().saturating_sub(1);
        return Err(Failure::usage(format!(
            "--view {}: the path's last view is {last}",
            args.index
        )));
    };
    let mut culler = inputs::culler(&args.cull);
    culler.output = Output::Triangles;
    culler.reasons = true;
    let scene = &model.scene;
    let colors = drawing::colors(&model);
    let options = RenderOptions { threads: args.view.threads, ..RenderOptions::default() };
    let picture: Picture = match args.kind {
        PictureKind::Kinds => cullet_draw::kinds(scene, view, &culler, args.view.size),
        PictureKind::Shaded => {
            let frame = cullet_draw::render(scene, view, Selection::All, &options);
            cullet_draw::shaded(scene, &frame, view, &colors)
        }
        PictureKind::Depth => {
            let options = RenderOptions { count_layers: true, ..options };
            let frame = cullet_draw::render(scene, view, Selection::All, &options);
            cullet_draw::depth_complexity(&frame, None)
        }
        PictureKind::Map => {
            let mut result = Visible::default();
            culler.cull_one(scene, view, &mut ViewState::default(), &mut result);
            let seen = cullet_draw::render(scene, view, Selection::All, &options).visible();
            cullet_draw::top_down(scene, view, &result, &seen, args.view.size)
        }
    };
    let out = args.out.clone().unwrap_or_else(|| format!("{}.png", args.kind.name()).into());
    std::fs::write(&out, picture.to_png()).map_err(|e| Failure::write(&out, &e))?;
    console.line(format!("{} written, {}x{}", out.display(), picture.width, picture.height));
    Ok(Exit::Fine)
}
