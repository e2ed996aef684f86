//! Pictures of views: what the renderer offers, put together for the page.

use clap::ValueEnum;
use cullet::{Stage, View, ViewState};
use cullet_command::console::grouped;
use cullet_command::inputs;
use cullet_draw::{Culled, Picture, RenderOptions, Selection};
use cullet_io::Model;

use crate::opening;
use crate::survey::Seen;

/// Optional pictures of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Show {
    /// The walk of the scene's hierarchy, level by level
    Hierarchy,
}

/// A picture with its words.
#[derive(Debug)]
pub(crate) struct Titled {
    /// Part of the file's name.
    pub(crate) name: &'static str,
    pub(crate) picture: Picture,
    pub(crate) caption: String,
    /// How wide it is where the page carries it, at the most.
    pub(crate) embed_px: u32,
    pub(crate) wide: bool,
    /// Whether it stands for its view in the gallery.
    pub(crate) thumbnail: bool,
}

/// The pictures of a view: the view and its map, and for the one that is shown large also the depth
/// complexity before and after, and the scene coloured by kinds.
pub(crate) fn of_view(
    model: &Model,
    view: &View,
    state: &ViewState,
    seen: &Seen,
    featured: bool,
    show: &[Show],
) -> Vec<Titled> {
    let scene = &model.scene;
    let colors = inputs::colors(model);
    let mut pictures = Vec::new();
    if featured && seen.full.is_some() {
        pictures.extend(of_levels(model, view, seen, &colors));
    }
    // The others show what became of the scene's own triangles.
    let as_drawn = seen;
    let seen = seen.in_full();
    let owners = seen.verification.as_ref().map_or(&[][..], |v| &v.seen);
    // Of the other views the page has a thumbnail alone, so half the size is enough.
    let part = if featured { 1 } else { 2 };
    if let Some(v) = &seen.verification {
        let thinned = (!featured).then(|| v.frame.thinned(part));
        let frame = thinned.as_ref().unwrap_or(&v.frame);
        pictures.push(Titled {
            name: "shaded",
            picture: cullet_draw::shaded(scene, frame, view, &colors),
            caption: "The view itself, drawn by the reference renderer.".into(),
            embed_px: 1280,
            wide: true,
            thumbnail: true,
        });
    }
    pictures.push(Titled {
        name: "map",
        picture: cullet_draw::top_down(
            scene,
            view,
            &seen.result,
            owners,
            [1280 / part, 800 / part],
        ),
        caption: "From above: the frustum, and every instance by what became of it.".into(),
        embed_px: 1280,
        wide: true,
        thumbnail: seen.verification.is_none(),
    });
    if show.contains(&Show::Hierarchy) {
        pictures.push(Titled {
            name: "hierarchy",
            picture: cullet_draw::hierarchy(scene, view, [1280, 960]),
            caption: "The walk of the hierarchy, level by level from the top: what lies under a box that is \
                      outside or inside is never tested."
                .into(),
            embed_px: 1280,
            wide: true,
            thumbnail: false,
        });
    }
    if featured && seen.verification.is_some() {
        let (picture, opened) = opening::kinds(scene, view, &seen.result, [1280, 720]);
        let open = if opened.is_some() { ", cut open above the eye" } else { "" };
        pictures.push(Titled {
            name: "kinds",
            picture,
            caption: format!(
                "From outside{open}: each triangle in the colour of what became of it."
            ),
            embed_px: 1280,
            wide: true,
            thumbnail: false,
        });
        let culled = Culled { state, result: &seen.result };
        pictures.extend(of_occlusion(model, view, &culled, &colors));
        let small = half(view);
        let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
        let draw = |selection| cullet_draw::render(scene, &small, selection, &options);
        let (before, after) = (draw(Selection::All), draw(Selection::Visible(&as_drawn.result)));
        pictures.push(Titled {
            name: "depth",
            picture: cullet_draw::depth_complexity(&before, Some(&after)),
            caption:
                "How often each pixel is filled, before culling and after it, at half the size."
                    .into(),
            embed_px: 1320,
            wide: true,
            thumbnail: false,
        });
    }
    pictures
}

/// Draws levels of detail: their colours, what they make of the view, and what that differs from.
fn of_levels(model: &Model, view: &View, seen: &Seen, colors: &[[f32; 4]]) -> Vec<Titled> {
    let scene = &model.scene;
    let titled = |name, picture, caption: String| Titled {
        name,
        picture,
        caption,
        embed_px: 1280,
        wide: true,
        thumbnail: false,
    };
    let mut pictures = vec![titled(
        "levels",
        cullet_draw::level_colors(scene, view, &seen.result),
        "What is drawn with levels of detail, each triangle in the colour of how often it was simplified.".into(),
    )];
    let proofs = (&seen.verification, seen.full.as_ref().and_then(|f| f.verification.as_ref()));
    if let (Some(drawn), Some(full)) = proofs {
        let before = cullet_draw::shaded(scene, &full.frame, view, colors);
        let frame = &drawn.culled_frame;
        let after = cullet_draw::shaded_levels(scene, frame, view, &seen.result, colors);
        let difference = cullet_draw::difference(&before, &after);
        let [all, left] = [scene.triangle_count(), seen.result.triangle_count].map(grouped);
        pictures.push(titled(
            "levels-drawn",
            after,
            format!("The view as it is drawn with levels of detail: {left} triangles of {all}."),
        ));
        pictures.push(titled(
            "levels-difference",
            difference,
            "Where that differs from the view in full, by the shading of pixels: dark grey is alike.".into(),
        ));
    }
    pictures
}

/// Draws occlusion culling in a view; nothing where it is off.
fn of_occlusion(
    model: &Model,
    view: &View,
    culled: &Culled<'_>,
    colors: &[[f32; 4]],
) -> Vec<Titled> {
    if !culled.result.funnel.rows.iter().any(|row| row.stage == Stage::Occlusion) {
        return Vec::new();
    }
    let scene = &model.scene;
    let titled = |name, picture, caption: &str| Titled {
        name,
        picture,
        caption: caption.into(),
        embed_px: 1280,
        wide: true,
        thumbnail: false,
    };
    vec![
        titled(
            "occlusion-buffer",
            cullet_draw::occlusion_buffer(scene, view, culled, [1280, 720]),
            "The occlusion buffer beside the true depth. A pixel is proved only where occluders cover all of \
             it, so edges stay open; none may claim to be nearer than what is there.",
        ),
        titled(
            "occluders",
            cullet_draw::occluders(scene, view, culled, colors),
            "What each occluder that was drawn is proved to cover, a colour for each instance. Where the view \
             is pale, nothing hides anything.",
        ),
        titled(
            "hidden",
            cullet_draw::hidden(scene, view, culled, colors),
            "What occlusion culling hid, shining through as ghosts.",
        ),
    ]
}

/// The same view on half as many pixels each way: two such pictures stand side by side on a page
/// with their legends still legible.
fn half(view: &View) -> View {
    let size = view.viewport().map(|v| (v / 2).max(1));
    // The matrix made a view before, so it makes one again.
    let Ok(mut small) = View::from_matrix(view.clip_from_world(), view.depth(), size) else {
        return view.clone();
    };
    (small.layers, small.front_face, small.cull_face) =
        (view.layers, view.front_face, view.cull_face);
    small
}
