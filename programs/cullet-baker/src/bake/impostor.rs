//! Impostors of the meshes for which they pay.

use std::path::Path;
use std::time::Instant;

use crate::bake_args::BakeArgs;
use cullet::math;
use cullet::{Mesh, Scene};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::Failure;
use cullet_command::files::replace;
use cullet_draw::{
    ImpostorOptions, ImpostorPlane, impostor_cards, impostor_sheet, make_impostor, palette,
};
use cullet_io::Model;
use cullet_io::baked::{Baked, BakedLevels, LevelKind, Measured, geometry_hash, hash};
use cullet_mesh::Impostor;

use super::chunk::{Folder, stopped};
use super::{Record, order, resumes};

/// Counted up whenever the same mesh and options give another impostor.
const VERSION: u32 = 1;

/// So many triangles must be left of a mesh by its levels at the error of its impostor: the box of
/// an impostor has 12, and each of its pixels costs as much as some triangles.
const LEAST_TRIANGLES: u64 = 64;
/// No impostor has a smaller error, in radii: of a mesh of which few triangles are left at that,
/// none is made.
const LEAST_ERROR: f64 = 0.05;

/// Makes impostors of the meshes with levels and gives them to the scene, beside those.
pub(super) fn add(
    model: &mut Model,
    baked: &mut Baked,
    kept: Option<&Folder>,
    args: &BakeArgs,
    record: &mut Record,
    console: &Console,
) -> Result<(), Failure> {
    let start = Instant::now();
    if let Some(folder) = &args.impostor_sheets {
        std::fs::create_dir_all(folder).map_err(|e| Failure::write(folder, &e))?;
    }
    let mut progress = console.progress("impostors of meshes", baked.meshes.len() as u64);
    for one in &mut baked.meshes {
        progress.steps(1);
        if interrupted() {
            return Err(stopped(kept));
        }
        let Some((made, was_there)) = make(model, one.mesh, kept, args, console)? else { continue };
        record.resumed += u64::from(was_there);
        if left_at(&model.scene, one.mesh, made.error().into()) < LEAST_TRIANGLES {
            continue;
        }
        if let Some(folder) = &args.impostor_sheets {
            write_sheets(folder, one.mesh, &made, &colors(model, one.mesh))?;
        }
        let name = name_of(model, one.mesh);
        let bytes = cullet_io::baked::impostor_to_bytes(&made).len() as u64;
        let held_by = match made.add_to(&mut model.scene, one.mesh) {
            Ok(held_by) => held_by,
            Err(problem) => {
                console.note(format!("note: mesh `{name}` has no impostor: {problem}"));
                continue;
            }
        };
        model.mesh_names.resize(held_by as usize, String::new());
        model.mesh_names.push(format!("{name}, {}", LevelKind::Impostor.name()));
        let options = ImpostorOptions::default();
        let measured = Measured {
            points: options.directions,
            reverse_points: 0,
            quantile: 0.999,
            most_over: 1.2,
            seed: options.seed,
        };
        one.levels.push(BakedLevels { kind: LevelKind::Impostor, held_by, measured });
        record.impostors += 1;
        record.impostors_bytes += bytes;
    }
    progress.finish();
    record.impostors_seconds = start.elapsed().as_secs_f64();
    Ok(())
}

/// Makes this process's share of the impostors of meshes with levels, and keeps them.
pub(super) fn share(
    model: &Model,
    baked: &Baked,
    kept: &Folder,
    args: &BakeArgs,
    console: &Console,
) -> Result<(), Failure> {
    let pays = |mesh: &u32| may_pay(model, *mesh);
    let meshes: Vec<u32> = baked.meshes.iter().map(|one| one.mesh).filter(pays).collect();
    let triangles = |&mesh: &u32| f64::from(model.scene.meshes()[mesh as usize].triangle_count());
    let own = order(&meshes.iter().map(triangles).collect::<Vec<_>>(), false, args);
    let mut progress = console.progress("impostors of meshes", own.len() as u64);
    // A mesh that is not for it is told of once all is joined.
    let quiet = Console::new(true, None);
    for at in own {
        if interrupted() {
            return Err(stopped(Some(kept)));
        }
        make(model, meshes[at], Some(kept), args, &quiet)?;
        progress.step();
    }
    progress.finish();
    Ok(())
}

/// The impostor of a mesh, and whether it was there before; `None` where none pays or can be made.
fn make(
    model: &Model,
    mesh: u32,
    kept: Option<&Folder>,
    args: &BakeArgs,
    console: &Console,
) -> Result<Option<(Impostor, bool)>, Failure> {
    if !may_pay(model, mesh) {
        return Ok(None);
    }
    let options = ImpostorOptions::default();
    let of = &model.scene.meshes()[mesh as usize];
    let key = kept.map(|folder| (folder, key(of, &options)));
    if let Some((folder, key)) = key.filter(|_| resumes(args))
        && let Some(impostor) = folder.read_impostor(key)
    {
        return Ok(Some((impostor, true)));
    }
    let threads = args.threads.map_or(0, |n| n as usize);
    match in_pool(threads, || make_impostor(of, &options)) {
        Ok((impostor, _)) => {
            if let Some((folder, key)) = key {
                folder.write_impostor(key, &impostor)?;
            }
            Ok(Some((impostor, false)))
        }
        Err(problem) => {
            let name = name_of(model, mesh);
            console.note(format!("note: mesh `{name}` has no impostor: {problem}"));
            Ok(None)
        }
    }
}

/// Whether enough is left of a mesh by its levels that an impostor can pay.
fn may_pay(model: &Model, mesh: u32) -> bool {
    let radius = radius(&model.scene.meshes()[mesh as usize]);
    left_at(&model.scene, mesh, LEAST_ERROR * radius) >= LEAST_TRIANGLES
}

fn name_of(model: &Model, mesh: u32) -> String {
    model.mesh_names.get(mesh as usize).cloned().unwrap_or_default()
}

/// Sum of all that the impostor of a mesh is a function of.
fn key(mesh: &Mesh, options: &ImpostorOptions) -> u64 {
    let sides: Vec<_> =
        mesh.parts().iter().map(|p| (p.triangle_count, p.two_sided, p.alpha)).collect();
    let version = (VERSION, env!("CARGO_PKG_VERSION"), options, sides);
    let sums = [hash(format!("{version:?}").as_bytes()), geometry_hash(mesh)];
    hash(&sums.map(u64::to_le_bytes).concat())
}

/// The fewest triangles that are drawn of a mesh with an error of no more than `error`.
fn left_at(scene: &Scene, mesh: u32, error: f64) -> u64 {
    let own = &scene.meshes()[mesh as usize];
    let whole = u64::from(own.triangle_count() - own.degenerate_count());
    let of_levels = scene.levels(mesh).iter().map(|levels| {
        let drawn = levels.levels.select_where(|group| f64::from(group.error) > error);
        let clusters = scene.meshes()[levels.mesh as usize].clusters();
        let counts = clusters.iter().zip(drawn).filter(|c| c.1).map(|c| c.0.triangle_count);
        counts.map(u64::from).sum()
    });
    // Of a chain whose finest level is the mesh itself, nothing is drawn where that is needed.
    of_levels.filter(|&count| count > 0).fold(whole, u64::min)
}

fn radius(mesh: &Mesh) -> f64 {
    mesh.bounds().half_extent().iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Runs `work` on so many threads; 0 is as many as there are cores.
fn in_pool<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// Colours of the parts of a mesh, in sRGB.
fn colors(model: &Model, mesh: u32) -> Vec<[u8; 3]> {
    let color = |part: &cullet::mesh::Part| {
        let given = model.materials.get(part.material as usize);
        given.map_or_else(
            || palette::material_color(part.material),
            |m| {
                let byte = |v: f32| {
                    let v = f64::from(v).clamp(0.0, 1.0);
                    let s = if v <= 0.003_130_8 {
                        v * 12.92
                    } else {
                        1.055 * math::pow(v, 1.0 / 2.4) - 0.055
                    };
                    (s * 255.0).round() as u8
                };
                [m.color[0], m.color[1], m.color[2]].map(byte)
            },
        )
    };
    model.scene.meshes()[mesh as usize].parts().iter().map(color).collect()
}

/// The four planes as PNGs, and a glTF of cards, each file named by the number of the mesh.
fn write_sheets(
    folder: &Path,
    mesh: u32,
    impostor: &Impostor,
    colors: &[[u8; 3]],
) -> Result<(), Failure> {
    let name = format!("mesh-{mesh}");
    for plane in ImpostorPlane::ALL {
        let sheet = impostor_sheet(impostor, plane, colors);
        replace(&folder.join(format!("{name}-{}.png", plane.name())), &sheet.to_png())?;
    }
    let cards = impostor_cards(impostor, &name, colors);
    replace(&folder.join(format!("{name}.bin")), &cards.bin)?;
    replace(&folder.join(format!("{name}.png")), &cards.png)?;
    replace(&folder.join(format!("{name}.gltf")), cards.gltf.as_bytes())
}
