//! From the command line to scenes, views and cullers.

use std::path::Path;

use cullet::cull::detail::{Detail, Measure};
use cullet::lod::Lod;
use cullet::view::EyeBall;
use cullet::{Backface, Culler, Scene, Stage, View, prepared::Preparation};
use cullet_cells::InCells;
use cullet_io::{ErrorKind, LoadOptions, Model, PoseError, shell_word};
use cullet_scenes::paths::{self, Overrides, PathSpec};

use crate::args::{CullArgs, OccluderKind, SceneArgs, ViewArgs};
use crate::bakery;
use crate::console::{Console, count};
use crate::exit::{Exit, Failure};
use crate::sets;

/// Loads a file, or makes a built-in scene.
pub fn load(args: &SceneArgs, console: &Console) -> Result<Model, Failure> {
    load_with(args, console, false)
}

/// Loads like [`load`], including all that a file written from it should have again.
pub fn load_to_save(args: &SceneArgs, console: &Console) -> Result<Model, Failure> {
    load_with(args, console, true)
}

fn load_with(args: &SceneArgs, console: &Console, details: bool) -> Result<Model, Failure> {
    let path = Path::new(&args.scene);
    let builtin = args.builtin();
    let two_sided = if args.one_sided { Some(false) } else { args.two_sided.then_some(true) };
    let mut model = if builtin {
        let mut model = cullet_scenes::build(&args.scene).map_err(Failure::usage)?;
        if let Some(two_sided) = two_sided {
            model.scene.edit_meshes(|_, m| m.set_two_sided(two_sided));
        }
        limit(&model, args)?;
        model
    } else {
        let mut options = LoadOptions {
            up: args.up,
            two_sided,
            details,
            // The reference renderer draws them.
            impostors: true,
            // Commands that cull know what they need.
            prepare: Preparation::NONE,
            ..LoadOptions::default()
        };
        if let Some(most) = args.max_triangles {
            options.max_triangles = most;
        }
        cullet_maps::load(path, &options).map_err(|e| match e.kind {
            ErrorKind::OverLimit { .. } => {
                let message = format!("{e}; --max-triangles sets that of triangles");
                Failure { exit: Exit::Limit, message }
            }
            _ if matches!(path.try_exists(), Ok(false)) => {
                Failure::input(cullet_scenes::no_such_file(&args.scene))
            }
            _ => Failure::input(e),
        })?
    };
    if args.cells.is_some() {
        (bakery::get()?.cells)(&mut model, args, console)?;
    } else if args.voxel.is_some() {
        return Err(Failure::usage("--voxel is of use with --cells auto alone"));
    }
    match &args.pvs {
        Some(path) => sets::place(&mut model, &args.scene, path)?,
        None => sets::place_stored(&mut model),
    }
    const SHOWN: usize = 5;
    let warnings = model.warnings.len();
    for w in model.warnings.iter().take(SHOWN) {
        console.note(format!("warning: {w}"));
    }
    if warnings > SHOWN {
        let more = warnings - SHOWN;
        let more = count(more as u64, "more warning", "more warnings");
        let scene = shell_word(&args.scene);
        console.note(format!("and {more}; `cullet info {scene} --all` lists them all"));
    }
    Ok(model)
}

/// Whether any mesh has levels of detail.
#[must_use]
pub fn has_levels(scene: &Scene) -> bool {
    (0..scene.meshes().len() as u32).any(|mesh| !scene.levels(mesh).is_empty())
}

/// For commands that measure: where levels of detail are asked for, the scene must have them, for
/// these do not bake.
///
/// # Errors
/// If it has none; with what to do.
pub fn demand_levels(model: &Model, scene: &str, args: &CullArgs) -> Result<(), Failure> {
    if args.levels().is_none() || has_levels(&model.scene) {
        return Ok(());
    }
    let word = shell_word(scene);
    Err(Failure::input(format!(
        "--lod: {scene} has no levels of detail; `cullet bake {word} -o baked.glb` writes a file that has them: give that"
    )))
}

/// Gives every mesh the occluder of the arguments: its own triangles, or what was baked.
///
/// # Errors
/// If one cannot be made, Ctrl-C was pressed, or this program has no baker.
pub fn give_occluders(
    model: &mut Model,
    args: &CullArgs,
    console: &Console,
) -> Result<(), Failure> {
    if args.no_occlusion || args.occluders == OccluderKind::Mesh {
        return Ok(());
    }
    (bakery::get()?.occluders)(model, args, console)
}

/// Built-in scenes know no limit of their own below that of memory.
fn limit(model: &Model, args: &SceneArgs) -> Result<(), Failure> {
    let stored: u64 = model.scene.meshes().iter().map(|m| u64::from(m.triangle_count())).sum();
    match args.max_triangles {
        Some(most) if stored > most => Err(Failure {
            exit: Exit::Limit,
            message: format!(
                "{}: {} --max-triangles {most}",
                args.scene,
                count(stored, "triangle exceeds", "triangles exceed")
            ),
        }),
        _ => Ok(()),
    }
}

/// Poses a model at the first of the given times, so that paths find it where it is.
pub fn begin(model: &mut Model, args: &ViewArgs, console: &Console) -> Result<(), Failure> {
    let Some([first, _]) = args.time else {
        let seconds = model.motion.as_ref().and_then(cullet_io::Motion::seconds);
        match seconds {
            Some(s) if s > 0.0 => console.note(format!(
                "{}: what moves in it stands as it is stored; --time 0..{} lets it move",
                model.name,
                short(s)
            )),
            _ => {}
        }
        return Ok(());
    };
    if model.motion.is_none() {
        // No error: of a folder some files move, and others stand.
        let unread = model.unread.iter().find(|unread| unread.may_move);
        console.note(match unread {
            Some(unread) => format!(
                "{}: {} may move what is in it, but is not read: all stands at all times",
                model.name, unread.name
            ),
            None => {
                format!("{}: nothing in it moves, so --time changes nothing", model.name)
            }
        });
        return Ok(());
    }
    pose(model, first)?;
    model.scene.sort();
    model.update_cells();
    Ok(())
}

/// Poses a model.
pub fn pose(model: &mut Model, seconds: f64) -> Result<(), Failure> {
    let posed = model.pose(seconds);
    posed.map_err(|e| match e {
        PoseError::Time(_) | PoseError::Made(_) => Failure::usage(format!("--time: {e}")),
        e => Failure::input(format!("{}: {e}", model.name)),
    })
}

/// The time of each of `views` views; none where no time was given.
pub fn times(args: &ViewArgs, views: usize) -> Vec<f64> {
    let Some([first, last]) = args.time else { return Vec::new() };
    let steps = views.saturating_sub(1).max(1) as f64;
    (0..views).map(|i| first + (last - first) * (i as f64 / steps)).collect()
}

/// The requested views, and a line with their near and far distances.
pub fn views(model: &Model, args: &ViewArgs, console: &Console) -> Result<Vec<View>, Failure> {
    let overrides =
        Overrides { fov_degrees: args.fov, near: args.near, far: args.far, ..Overrides::default() };
    let cameras = if let (Some(eye), Some(target)) = (args.eye, args.target) {
        vec![paths::look_at(model, eye, target, args.size, &overrides).map_err(Failure::usage)?]
    } else {
        let spec: PathSpec = args.path.parse().map_err(Failure::usage)?;
        let cameras = paths::cameras(model, &spec, args.views as usize, args.size, &overrides);
        cameras.map_err(|e| match spec {
            PathSpec::File(_) => Failure::input(e),
            _ => Failure::usage(e),
        })?
    };
    let (mut near, mut far) = ([f64::INFINITY, 0.0f64], [f64::INFINITY, 0.0f64]);
    for c in &cameras {
        let [n, f] = paths::range(&c.projection);
        near = [near[0].min(n), near[1].max(n)];
        far = [far[0].min(f), far[1].max(f)];
    }
    let span = |[low, high]: [f64; 2]| match low == high {
        true => short(low),
        false => format!("{} to {}", short(low), short(high)),
    };
    let time = args.time.map_or_else(String::new, |t| format!(", time {} s", span(t)));
    let [w, h] = args.size;
    console.note(format!(
        "{}: {} of {w}x{h}, near {}, far {}{time}",
        model.name,
        count(cameras.len() as u64, "view", "views"),
        span(near),
        span(far)
    ));
    let view = |c| View::new(c, overrides.depth, args.size).map_err(Failure::usage);
    cameras.iter().map(view).collect()
}

/// The requested views of what is culled, with the eyes that levels of detail are chosen for: see
/// [`CullArgs::lod_ball`].
///
/// # Errors
/// As [`views`].
pub fn culled_views(
    model: &Model,
    args: &ViewArgs,
    cull: &CullArgs,
    console: &Console,
) -> Result<Vec<View>, Failure> {
    let mut views = views(model, args, console)?;
    if let Some(radius) = cull.lod_ball {
        let mut ball: Option<EyeBall> = None;
        for view in &mut views {
            let [x, y, z, w] = view.eye();
            if w == 0.0 {
                continue;
            }
            let centre = [x, y, z];
            let own = EyeBall { centre, radius };
            ball = Some(ball.map_or(own, |ball| ball.follow(centre, radius)));
            view.eyes = ball;
        }
    }
    Ok(views)
}

/// Four digits are enough to see what a distance is.
fn short(v: f64) -> String {
    if v == 0.0 || (0.01..1e5).contains(&v.abs()) {
        let digits = (3 - v.abs().max(0.01).log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{v:.digits$}");
        return match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        };
    }
    format!("{v:.3e}")
}

/// The path, as people wrote it.
pub fn path_words(args: &ViewArgs) -> String {
    let mut words = match (args.eye, args.target) {
        (Some(eye), Some(target)) => {
            let point = |p: [f64; 3]| p.map(|v| v.to_string()).join(",");
            format!("from {} to {}", point(eye), point(target))
        }
        _ => args.path.clone(),
    };
    if let Some([first, last]) = args.time {
        words += &match first == last {
            true => format!(", at {first} s"),
            false => format!(", from {first} s to {last} s"),
        };
    }
    words
}

/// The culler of the arguments: a preset, with what the other options change, and without a limit
/// to what occlusion may stake.
pub fn culler(args: &CullArgs) -> Culler {
    let mut culler = args.preset.culler();
    culler.frustum &= !args.no_frustum;
    culler.pvs &= !args.no_pvs;
    if args.no_portal {
        culler.portal = false;
    }
    culler.frustum_exact |= args.exact_frustum;
    culler.degenerate &= !args.no_degenerate;
    if args.no_backface {
        culler.backface = Backface::Off;
    }
    if let Some(threshold_px) = args.detail {
        let detail = Detail::default()
            .with_measure(args.detail_by)
            .with_threshold_px(threshold_px)
            .with_clusters(args.detail_clusters);
        culler.detail = (threshold_px > 0.0).then_some(detail);
    }
    culler.lod = args.levels();
    if args.no_occlusion {
        culler.occlusion = None;
    }
    if let Some(occlusion) = &mut culler.occlusion {
        occlusion.width = args.occlusion_width.unwrap_or(occlusion.width);
        occlusion.budget = args.occlusion_budget.unwrap_or(occlusion.budget);
        // The program shows what is hidden, also where it would not pay.
        occlusion.risk = args.occlusion_risk;
    }
    match args.only {
        None => culler,
        Some(stage) => culler.only(stage),
    }
}

/// The stages that are on, in words, in the order in which they run; sets and portals are none in a
/// scene without.
pub fn culling_words(args: &CullArgs, world: InCells<'_>) -> Vec<String> {
    let culler = culler(args);
    let words = |stage: Stage| match stage {
        Stage::Frustum if culler.frustum_exact => "frustum (exact)".into(),
        Stage::Detail => {
            let Detail { measure, threshold_px: px, clusters, .. } =
                culler.detail.unwrap_or_default();
            let clusters = if clusters { ", clusters too" } else { "" };
            let unit = if measure == Measure::Area { "square px" } else { "px" };
            format!("detail under {px} {unit}{clusters} (lossy)")
        }
        Stage::Lod => {
            let Lod { pixels, at_corners, triangles, .. } = culler.lod.unwrap_or_default();
            let corners = if at_corners { ", in the corners too" } else { "" };
            let ball = args.lod_ball.map_or_else(String::new, |r| format!(", steady within {r}"));
            let within = match (triangles, pixels > 0.0) {
                (None, _) => format!("within {pixels} px"),
                (Some(n), false) => format!("of at most {}", count(n, "triangle", "triangles")),
                (Some(n), true) => {
                    format!("within {pixels} px, of at most {}", count(n, "triangle", "triangles"))
                }
            };
            format!("levels of detail {within}{corners}{ball} (lossy)")
        }
        Stage::Occlusion => match args.occluders {
            OccluderKind::Mesh => "occlusion".into(),
            OccluderKind::Baked => "occlusion (baked occluders)".into(),
            OccluderKind::Auto => "occlusion (occluders baked where cheaper)".into(),
        },
        stage => stage.name().to_owned(),
    };
    stages(args, world).map(words).collect()
}

/// The stages that are on and have something to go by in a scene, in the order in which they run.
pub fn stages(args: &CullArgs, world: InCells<'_>) -> impl Iterator<Item = Stage> {
    let culler = culler(args);
    let has = move |stage: Stage| match stage {
        Stage::Pvs => world.cells.is_some_and(|cells| cells.visible_sets().is_some()),
        Stage::Portal => world.graph().is_some_and(|graph| !graph.portals().is_empty()),
        _ => true,
    };
    Stage::ALL.into_iter().filter(move |&stage| culler.runs(stage) && has(stage))
}

/// The colours of a model's materials.
#[must_use]
pub fn colors(model: &Model) -> Vec<[f32; 4]> {
    model.materials.iter().map(|m| m.color).collect()
}

#[cfg(test)]
mod tests {
    use clap::Args as _;

    use super::*;

    fn culled_by(words: &str) -> Culler {
        let args = std::iter::once("test").chain(words.split_whitespace());
        let args =
            CullArgs::augment_args(clap::Command::new("test")).try_get_matches_from(args).unwrap();
        culler(&clap::FromArgMatches::from_arg_matches(&args).unwrap())
    }

    #[test]
    fn what_no_option_changes_is_the_preset_of_the_engine() {
        let same = |words: &str, of: Culler| {
            let occlusion = of.occlusion.map(|o| o.with_risk(None));
            let of = of.with_occlusion(occlusion);
            let ours = culled_by(words);
            assert_eq!(format!("{ours:?}"), format!("{of:?}"), "{words}");
        };
        same("", Culler::balanced());
        for (name, preset, _) in crate::args::PRESETS {
            same(&format!("--preset {name}"), preset.culler());
        }
        let fast = Culler::fast();
        let wide = fast.occlusion.map(|o| o.with_width(99));
        same("--preset fast --occlusion-width 99", fast.clone().with_occlusion(wide));
        let small = Some(Detail::default().with_measure(Measure::Area).with_threshold_px(3.0));
        same("--preset fast --detail 3 --detail-by area", fast.with_detail(small));
        same("--detail 0", Culler::balanced());
        let lod = Some(Lod::default().with_pixels(1.5).with_at_corners(true));
        same("--lod 1.5 --lod-corners", Culler::balanced().with_lod(lod));
        same("--lod 0", Culler::balanced());
        let lod = Some(Lod::default().with_pixels(0.0).with_triangles(5000));
        same("--lod-triangles 5000", Culler::balanced().with_lod(lod));
        let lod = Some(Lod::default().with_pixels(2.0).with_triangles(70));
        same("--lod 2 --lod-triangles 70", Culler::balanced().with_lod(lod));
        let clusters = Some(Detail::default().with_threshold_px(2.0).with_clusters(true));
        same("--detail 2 --detail-clusters", Culler::balanced().with_detail(clusters));
        same("--no-occlusion", Culler::balanced().with_occlusion(None));
    }

    #[test]
    fn a_stage_alone_has_its_own_settings() {
        assert_eq!(culled_by("--only lod").lod, Some(Lod::default()));
        let lod = culled_by("--only lod --lod 3").lod;
        assert_eq!(lod, Some(Lod::default().with_pixels(3.0)));
        assert_eq!(culled_by("--only frustum --lod 3").lod, None);
    }

    #[test]
    fn distances_are_short() {
        assert_eq!(short(0.125), "0.125");
        assert_eq!(short(1234.567), "1235");
        assert_eq!(short(12.0), "12");
        assert_eq!(short(3e-5), "3.000e-5");
        assert_eq!(short(f64::INFINITY), "inf");
    }
}
