//! `cullet picture`: one picture of one view.

mod args;

use cullet::{Output, Scene, View, ViewState, Visible};
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::inputs;
use cullet_draw::{Culled, Picture, RenderOptions, Selection};

use crate::{levels, opening};
use args::PictureKind;
pub(crate) use args::{HELP, PictureArgs};

/// Runs the command.
pub(crate) fn run(args: &PictureArgs, console: &Console) -> Outcome {
    let picture = of_scene(args, console)?;
    let out = args.out.clone().unwrap_or_else(|| format!("{}.png", args.kind.name()).into());
    std::fs::write(&out, picture.to_png()).map_err(|e| Failure::write(&out, &e))?;
    console.line(format!("{} written, {}x{}", out.display(), picture.width, picture.height));
    Ok(Exit::Fine)
}

/// The pictures that show a scene.
fn of_scene(args: &PictureArgs, console: &Console) -> Result<Picture, Failure> {
    let mut model = levels::load(&args.input.scene, &args.input.cull, console)?;
    inputs::give_occluders(&mut model, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let views = inputs::culled_views(&model, &args.input.view, &args.input.cull, console)?;
    if let Some(&seconds) = inputs::times(&args.input.view, views.len()).get(args.index as usize) {
        inputs::pose(&mut model, seconds)?;
    }
    let Some(view) = views.get(args.index as usize) else {
        let last = views.len().saturating_sub(1);
        return Err(Failure::usage(format!(
            "--view {}: the path's last view is {last}",
            args.index
        )));
    };
    let mut culler = inputs::culler(&args.input.cull);
    let of_levels = [PictureKind::Shaded, PictureKind::Levels, PictureKind::LevelsDifference];
    if !of_levels.contains(&args.kind) {
        // They show what becomes of the triangles of the scene itself.
        culler.lod = None;
    } else if culler.lod.is_none() && args.kind != PictureKind::Shaded {
        return Err(Failure::usage(format!(
            "{}: give --lod PX, by how many pixels levels of detail may be off; try --lod 1",
            args.kind.name()
        )));
    }
    culler.output = Output::Triangles;
    (culler.reasons, culler.dropped) = (true, true);
    model.scene.prepare(&culler);
    if matches!(args.kind, PictureKind::Portals | PictureKind::Cells) && model.placed.is_none() {
        return Err(no_cells(&args.input.scene.scene));
    }
    let (scene, world) = (&model.scene, model.in_cells());
    let colors = inputs::colors(&model);
    let options = RenderOptions { threads: args.input.view.threads, ..RenderOptions::default() };
    let cull = || {
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        world.cull(&culler, view, &mut state, &mut result);
        (state, result)
    };
    Ok(match args.kind {
        PictureKind::Kinds => {
            let (_, result) = cull();
            let (picture, opened) = opening::kinds(scene, view, &result, args.input.view.size);
            if let Some(height) = opened {
                console.note(format!(
                    "cut open at a height of {height:.4}, for what the view sees is covered from outside"
                ));
            }
            picture
        }
        PictureKind::Shaded => match culler.lod {
            Some(_) => as_drawn(scene, view, &cull().1, &colors, &options),
            None => in_full(scene, view, &colors, &options),
        },
        PictureKind::Levels => {
            let (_, result) = cull();
            console.line(format!(
                "{} drawn at their levels of detail",
                count(result.triangle_count, "triangle is", "triangles are")
            ));
            cullet_draw::level_colors(scene, view, &result)
        }
        PictureKind::LevelsDifference => {
            let (_, result) = cull();
            let before = in_full(scene, view, &colors, &options);
            let after = as_drawn(scene, view, &result, &colors, &options);
            let difference = cullet_draw::difference(&before, &after);
            // The font of pictures has no narrow space.
            let [all, left] = [scene.triangle_count(), result.triangle_count]
                .map(|n| grouped(n).replace('\u{202f}', ","));
            let words =
                [format!("in full: {all} triangles"), format!("as drawn: {left} triangles")];
            let small = [before, after, difference].map(|p| p.halved());
            let titles = [&words[0], &words[1], "the difference"];
            let shown: Vec<(&Picture, &str)> = small.iter().zip(titles).collect();
            cullet_draw::beside(&shown)
        }
        PictureKind::Depth => {
            let options = RenderOptions { count_layers: true, ..options };
            let frame = cullet_draw::render(scene, view, Selection::All, &options);
            cullet_draw::depth_complexity(&frame, None)
        }
        PictureKind::Map => {
            let (_, result) = cull();
            let seen = cullet_draw::render(scene, view, Selection::All, &options).visible();
            cullet_draw::top_down(scene, view, &result, &seen, args.input.view.size)
        }
        PictureKind::Hierarchy => cullet_draw::hierarchy(scene, view, args.input.view.size),
        PictureKind::OcclusionBuffer | PictureKind::Occluders | PictureKind::Hidden => {
            let (state, result) = cull();
            let culled = Culled { state: &state, result: &result };
            match args.kind {
                PictureKind::OcclusionBuffer => {
                    cullet_draw::occlusion_buffer(scene, view, &culled, args.input.view.size)
                }
                PictureKind::Occluders => cullet_draw::occluders(scene, view, &culled, &colors),
                _ => cullet_draw::hidden(scene, view, &culled, &colors),
            }
        }
        PictureKind::Portals | PictureKind::Cells => {
            let reached = world.reached(&culler, view);
            let reached = reached.as_ref();
            if reached.is_none() {
                console.note("portals hide nothing in this view; the picture says why, or --no-portal was given");
            }
            match args.kind {
                PictureKind::Portals => cullet_draw::portals(world, view, reached, &colors),
                _ => cullet_draw::cells(world, view, reached, args.input.view.size),
            }
        }
    })
}

/// The view with all of its triangles.
fn in_full(scene: &Scene, view: &View, colors: &[[f32; 4]], options: &RenderOptions) -> Picture {
    let frame = cullet_draw::render(scene, view, Selection::All, options);
    cullet_draw::shaded(scene, &frame, view, colors)
}

/// The view with what a culler left, at its levels of detail.
fn as_drawn(
    scene: &Scene,
    view: &View,
    result: &Visible,
    colors: &[[f32; 4]],
    options: &RenderOptions,
) -> Picture {
    let frame = cullet_draw::render(scene, view, Selection::Visible(result), options);
    cullet_draw::shaded_levels(scene, &frame, view, result, colors)
}

/// Says of a scene without cells why no picture of them is drawn.
#[must_use]
pub fn no_cells(scene: &str) -> Failure {
    Failure::input(format!(
        "{scene}: the scene has no cells, so there is nothing to draw; try office, or a file with cells and portals"
    ))
}
