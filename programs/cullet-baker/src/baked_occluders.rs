//! Occluders that a baked file has, or that are baked when a scene is opened.

use cullet::prepared::Preparation;
use cullet_bake::occluders::{OccluderOptions, OccluderPolygon, Occluders, occluders};
use cullet_command::args::{CullArgs, OccluderKind};
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_io::Model;
use cullet_io::baked::pays;
use rayon::prelude::*;

/// Does something for each mesh, or number of a mesh, several at a time, in their order.
///
/// # Errors
/// The first that `of` gives, or that Ctrl-C was pressed.
pub fn of_meshes<M: Sync, T: Send>(
    meshes: &[M],
    console: &Console,
    of: impl Fn(&M) -> Result<T, Failure> + Sync,
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
/// Polygons off the axes lie near the surface and not in it, by a tolerance that a buffer would
/// have to allow for at each slope; they are left out.
///
/// # Errors
/// If one cannot be made, or Ctrl-C was pressed.
pub fn give(model: &mut Model, args: &CullArgs, console: &Console) -> Result<(), Failure> {
    if args.no_occlusion || args.occluders == OccluderKind::Mesh {
        return Ok(());
    }
    let mut options = OccluderOptions::default();
    if args.occluders == OccluderKind::Baked {
        // Their efficiency is not used.
        options.directions = 0;
    }
    model.scene.prepare(Preparation { occluder: true, ..Preparation::NONE });
    // What the file has need not be made, nor anything for meshes that are there to hold the levels
    // of others.
    let baked = model.baked.as_ref();
    let stored = |id: u32| baked?.of(id)?.occluders.as_ref();
    let mut drawn = vec![false; model.scene.meshes().len()];
    model.scene.slots().for_each(|s| drawn[model.scene.mesh_id(s) as usize] = true);
    let missing: Vec<u32> = (0..model.scene.meshes().len() as u32)
        .filter(|&id| drawn[id as usize] && stored(id).is_none())
        .collect();
    let made = of_meshes(&missing, console, |&id| {
        let mesh = &model.scene.meshes()[id as usize];
        occluders(mesh, &options).map_err(Failure::usage)
    })?;
    let made = made.into_iter().map(|(made, _)| made);
    let mut found: Vec<(u32, Occluders)> = missing.iter().copied().zip(made).collect();
    let meshes = 0..model.scene.meshes().len() as u32;
    found.extend(meshes.filter_map(|id| stored(id).map(|of_file| (id, of_file.clone()))));
    found.sort_unstable_by_key(|(id, _)| *id);
    let (mut given, mut boxes, mut polygons, mut own, mut sloped) = (0u64, 0, 0, 0, 0);
    let meshes = found.len() as u64;
    for (id, made) in found {
        let (exact, off): (Vec<&OccluderPolygon>, Vec<&OccluderPolygon>) =
            made.polygons.iter().partition(|p| p.tolerance == 0.0);
        let occluder = made.to_engine().map_err(Failure::input)?;
        let take = match args.occluders {
            OccluderKind::Auto => {
                let own = model.scene.prepared()[id as usize].occluder();
                made.hide_enough() && own.is_some_and(|own| pays(&occluder, own))
            }
            _ => true,
        };
        if take {
            given += u64::from(!occluder.shapes().is_empty());
            boxes += made.boxes.len() as u64;
            polygons += exact.len() as u64;
            own += made.own_triangles();
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
        count(meshes, "mesh", "meshes"),
        count(boxes, "box", "boxes"),
        count(polygons, "polygon", "polygons"),
        count(own, "triangle", "triangles")
    ));
    Ok(())
}
