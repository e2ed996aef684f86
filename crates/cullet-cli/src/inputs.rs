//! From the command line to scenes, views and cullers.

use std::path::Path;

use cullet::cull::detail::{Detail, Measure};
use cullet::{Backface, Culler, View};
use cullet_io::paths::{self, Overrides, PathSpec};
use cullet_io::{ErrorKind, LoadOptions, Model, Up, scenes};

use crate::args::{CullArgs, DetailMeasure, SceneArgs, UpAxis, ViewArgs};
use crate::console::Console;
use crate::exit::{Exit, Failure};

/// Loads a file, or makes a built-in scene.
pub(crate) fn load(args: &SceneArgs, console: &Console) -> Result<Model, Failure> {
    let path = Path::new(&args.scene);
    // A file of that name wins over a built-in scene, for a name can be changed with a `./`.
    let builtin = !path.exists() && scenes::is_builtin(&args.scene);
    let two_sided = if args.one_sided { Some(false) } else { args.two_sided.then_some(true) };
    let model = if builtin {
        let mut model = scenes::build(&args.scene).map_err(Failure::usage)?;
        if let Some(two_sided) = two_sided {
            model.scene.meshes_mut().for_each(|m| m.set_two_sided(two_sided));
        }
        limit(&model, args)?;
        model
    } else {
        let mut options = LoadOptions { two_sided, ..LoadOptions::default() };
        options.up = args.up.map(|up| match up {
            UpAxis::Y => Up::Y,
            UpAxis::Z => Up::Z,
        });
        if let Some(most) = args.max_triangles {
            options.max_triangles = most;
        }
        cullet_io::load(path, &options).map_err(|e| match e.kind {
            ErrorKind::OverLimit { .. } => {
                let message = format!("{e}; --max-triangles sets that of triangles");
                Failure { exit: Exit::Limit, message }
            }
            _ if !path.exists() => {
                let known: Vec<&str> = scenes::list().iter().map(|s| s.name).collect();
                Failure::input(format!("{e}; the built-in scenes are {}", known.join(", ")))
            }
            _ => Failure::input(e),
        })?
    };
    const SHOWN: usize = 5;
    let warnings = model.warnings.len();
    for w in model.warnings.iter().take(SHOWN) {
        console.note(format!("warning: {w}"));
    }
    if warnings > SHOWN {
        let more = warnings - SHOWN;
        console.note(format!("and {more} more warnings; cullet info --all lists them"));
    }
    Ok(model)
}

/// Built-in scenes know no limit of their own below that of memory.
fn limit(model: &Model, args: &SceneArgs) -> Result<(), Failure> {
    let stored: u64 = model.scene.meshes().iter().map(|m| u64::from(m.triangle_count())).sum();
    match args.max_triangles {
        Some(most) if stored > most => Err(Failure {
            exit: Exit::Limit,
            message: format!("{}: {stored} triangles exceed --max-triangles {most}", args.scene),
        }),
        _ => Ok(()),
    }
}

/// The views asked for, and a line that says what near and far came to.
pub(crate) fn views(
    model: &Model,
    args: &ViewArgs,
    console: &Console,
) -> Result<Vec<View>, Failure> {
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
    let [w, h] = args.size;
    let n = cameras.len();
    console.note(format!(
        "{}: {n} {} of {w}x{h}, near {}, far {}",
        model.name,
        if n == 1 { "view" } else { "views" },
        span(near),
        span(far)
    ));
    let view = |c| View::new(c, overrides.depth, args.size).map_err(Failure::usage);
    cameras.iter().map(view).collect()
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
pub(crate) fn path_words(args: &ViewArgs) -> String {
    match (args.eye, args.target) {
        (Some(eye), Some(target)) => {
            let point = |p: [f64; 3]| p.map(|v| v.to_string()).join(",");
            format!("from {} to {}", point(eye), point(target))
        }
        _ => args.path.clone(),
    }
}

/// The culler asked for.
pub(crate) fn culler(args: &CullArgs) -> Culler {
    let measure = match args.detail_by {
        DetailMeasure::Sides => Measure::WidthAndHeight,
        DetailMeasure::Area => Measure::Area,
        DetailMeasure::Diameter => Measure::Diameter,
    };
    Culler {
        frustum: !args.no_frustum,
        frustum_exact: args.exact_frustum,
        backface: if args.no_backface { Backface::Off } else { Backface::default() },
        degenerate: !args.no_degenerate,
        detail: args.detail.map(|threshold_px| Detail { measure, threshold_px }),
        ..Culler::default()
    }
}

/// The stages that are on, in words.
pub(crate) fn culling_words(args: &CullArgs) -> Vec<String> {
    let mut words = vec!["layer".to_owned()];
    if !args.no_frustum {
        words.push(if args.exact_frustum { "frustum (exact)" } else { "frustum" }.into());
    }
    if let Some(px) = args.detail {
        let unit = if args.detail_by == DetailMeasure::Area { "square px" } else { "px" };
        words.push(format!("detail under {px} {unit} (lossy)"));
    }
    if !args.no_backface {
        words.push("backface".into());
    }
    if !args.no_degenerate {
        words.push("degenerate".into());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_short() {
        assert_eq!(short(0.125), "0.125");
        assert_eq!(short(1234.567), "1235");
        assert_eq!(short(12.0), "12");
        assert_eq!(short(3e-5), "3.000e-5");
        assert_eq!(short(f64::INFINITY), "inf");
    }
}
