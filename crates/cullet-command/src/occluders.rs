//! Occluders that are baked when a scene is opened.

use cullet::{Mesh, OccluderCosts, Preparation};
use cullet_bake::occluders::{OccluderOptions, Occluders, Polygon, occluders};
use cullet_io::Model;
use rayon::prelude::*;

use crate::args::{CullArgs, OccluderKind};
use crate::console::{Console, count, grouped, interrupted};
use crate::exit::{Exit, Failure};

/// How many triangles of a mesh stand for themselves.
#[must_use]
pub fn own_triangles(made: &Occluders) -> u64 {
    made.sheets.iter().map(|s| s.triangles.len() as u64).sum()
}

/// Does something for each mesh, several at a time, in their order.
///
/// # Errors
/// The first that `of` gives, or that Ctrl-C was pressed.
pub fn of_meshes<T: Send>(
    meshes: &[Mesh],
    console: &Console,
    of: impl Fn(&Mesh) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    /// Meshes between two looks at the clock: more than there are processors, since some take long.
    const SOME: usize = 64;
    let mut bar = console.progress("occluders", meshes.len() as u64);
    let mut all = Vec::with_capacity(meshes.len());
    for some in meshes.chunks(SOME) {
        if interrupted() {
            let message = "interrupted while occluders were made".into();
            return Err(Failure { exit: Exit::Interrupted, message });
        }
        all.extend(some.par_iter().map(&of).collect::<Result<Vec<T>, Failure>>()?);
        some.iter().for_each(|_| bar.step());
    }
    bar.finish();
    Ok(all)
}

/// Gives every mesh the occluder of the arguments, and prints a line with the result.
///
/// Polygons off the axes lie near the surface and not in it, by a tolerance that a buffer would have to allow for at
/// each slope; they are left out.
///
/// # Errors
/// If one cannot be made, or Ctrl-C was pressed.
pub fn give(model: &mut Model, args: &CullArgs, console: &Console) -> Result<(), Failure> {
    /// Pixels at which costs are compared: those of an instance that pays for its drawing.
    const PIXELS: f32 = 10_000.0;
    /// The share of its mesh's silhouette that proxies must hide to be taken for it.
    const LEAST_EFFICIENCY: f64 = 0.9;
    if args.no_occlusion || args.occluders == OccluderKind::Mesh {
        return Ok(());
    }
    let (mut options, costs) = (OccluderOptions::default(), OccluderCosts::default());
    if args.occluders == OccluderKind::Baked {
        // Their efficiency is not used.
        options.directions = 0;
    }
    model.scene.prepare(Preparation { occluder: true, ..Preparation::NONE });
    let found = of_meshes(model.scene.meshes(), console, |mesh| {
        occluders(mesh, &options).map_err(Failure::usage)
    })?;
    let (mut given, mut boxes, mut polygons, mut own, mut sloped) = (0u64, 0, 0, 0, 0);
    for (id, (made, report)) in (0..).zip(found) {
        let (exact, off): (Vec<&Polygon>, Vec<&Polygon>) =
            made.polygons.iter().partition(|p| p.tolerance == 0.0);
        let occluder = made.to_engine().map_err(Failure::input)?;
        let own_cost = |id| {
            let own = model.scene.prepared()[id as usize].occluder();
            own.map_or(0.0, |own| own.cost(&costs, PIXELS))
        };
        let take = match args.occluders {
            OccluderKind::Auto => {
                off.is_empty()
                    && report.efficiency() >= LEAST_EFFICIENCY
                    && occluder.cost(&costs, PIXELS) * 2.0 < own_cost(id)
            }
            _ => true,
        };
        if take {
            given += u64::from(!occluder.shapes().is_empty());
            boxes += made.boxes.len() as u64;
            polygons += exact.len() as u64;
            own += own_triangles(&made);
            sloped += off.len() as u64;
            model.scene.set_occluder(id, occluder);
        }
    }
    let left_out = match sloped {
        0 => String::new(),
        n => format!("; {} on slopes left out", grouped(n)),
    };
    console.note(format!(
        "occluders: {} of {} by {}, {} and {}{left_out}",
        grouped(given),
        count(model.scene.meshes().len() as u64, "mesh", "meshes"),
        count(boxes, "box", "boxes"),
        count(polygons, "polygon", "polygons"),
        count(own, "triangle", "triangles")
    ));
    Ok(())
}
