//! `cullet bake`: a GLB with levels of every mesh beside it.

mod chunk;
mod impostor;
mod merge;
mod mesh;
mod occluders;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use crate::bake_args::BakeArgs;
use cullet::Scene;
use cullet_bake::levels::LevelsError;
use cullet_bake::work::order_of_share;
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{save_model, write_json};
use cullet_command::inputs;
use cullet_io::baked::{
    Baked, BakedLevels, BakedMesh, LevelKind, LevelTables, geometry_hash, hash,
};
use cullet_io::{Model, SaveFormat, save_original};
use serde::Serialize;

use chunk::{Folder, stopped};
use mesh::Source;

/// Version of the JSON.
const SCHEMA: u32 = 1;

/// The figures.
#[derive(Debug, Default, Serialize)]
struct Record {
    schema: u32,
    /// Meshes that are drawn, and how many of them have levels.
    meshes: u64,
    meshes_with_levels: u64,
    /// Their triangles, each mesh counted once.
    triangles: u64,
    chains: u64,
    hierarchies: u64,
    /// Impostors, and the bytes of their pictures.
    impostors: u64,
    impostors_bytes: u64,
    impostors_seconds: f64,
    /// Triangles of all levels, the original ones among them.
    levels_triangles: u64,
    /// Meshes for which occluders were looked for.
    occluders: u64,
    /// Groups of instances, merged, and triangles of all their levels.
    merged_groups: u64,
    merged_triangles: u64,
    /// How many chains, hierarchies, impostors, merged groups and meshes with occluders were taken
    /// from finished ones.
    resumed: u64,
    /// Bytes of the file.
    bytes: u64,
    /// Sum of its bytes.
    bytes_hash: String,
    /// Whether the file is the one that was read, and something added to it.
    original_kept: bool,
    bake_seconds: f64,
    /// The most memory at once, where the system tells it.
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_bytes: Option<u64>,
}

/// Levels of one kind that are to be made of a mesh.
struct Job {
    mesh: u32,
    kind: LevelKind,
    triangles: u32,
}

/// Result of a mesh: levels, if it has any, and whether they were there before.
type Made = Result<(Option<LevelTables>, bool), Problem>;

/// Why a job came to nothing.
enum Problem {
    /// The mesh is not for it, which others need not suffer for.
    Levels(LevelsError),
    /// The result cannot be kept.
    Failure(Failure),
}

/// Runs the command.
pub(crate) fn run(args: &BakeArgs, console: &Console) -> Outcome {
    // Known before minutes of work are done.
    if SaveFormat::of(&args.out) != Some(SaveFormat::Glb) {
        let message = format!("{}: what is baked is written to a .glb only", args.out.display());
        return Err(Failure::usage(message));
    }
    let mut model = inputs::load_to_save(&args.scene, console)?;
    let keep = keeps_original(&model, args);
    if args.msft_lod && !keep {
        let message = "--msft-lod adds to a glTF that is written as it is; bake this scene without it first, then what came of it";
        return Err(Failure::usage(message));
    }
    if keep {
        let deformed = model.scene.meshes().iter().filter(|m| m.is_deformable()).count() as u64;
        if deformed > 0 {
            let what = count(deformed, "mesh that deforms has", "meshes that deform have");
            console.note(format!("note: {what} no levels"));
        }
    } else if model.motion.take().is_some_and(|motion| motion.moves()) {
        console.note("note: what moves in it stands as it is stored, and moves no longer");
    }
    if args.units.unit.is_some() {
        return share(&mut model, keep, args, console);
    }
    let start = Instant::now();
    let mut record = bake(&mut model, keep, args, console)?;
    record.original_kept = keep;
    if keep {
        let original = Path::new(&args.scene.scene);
        let warnings =
            save_original(&model, original, &args.out, args.msft_lod).map_err(Failure::input)?;
        warnings.iter().for_each(|w| console.note(format!("warning: {w}")));
    } else {
        save_model(&model, &args.out, console)?;
    }
    record.bake_seconds = start.elapsed().as_secs_f64();
    record.peak_bytes = peak_bytes();
    let bytes = std::fs::read(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    record.bytes = bytes.len() as u64;
    record.bytes_hash = format!("{:016x}", hash(&bytes));
    print(&record, args, console);
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(Exit::Fine)
}

/// Whether what is written is the file that was read, with what was baked added: that of a glTF,
/// unless options say that the scene is another than the one in the file.
fn keeps_original(model: &Model, args: &BakeArgs) -> bool {
    let scene = &args.scene;
    let other = scene.up.is_some() || scene.one_sided || scene.two_sided || scene.cells.is_some();
    !model.file_meshes.is_empty() && !other
}

/// Gives the scene of a model levels of its meshes, and what else is asked for.
fn bake(
    model: &mut Model,
    rigid: bool,
    args: &BakeArgs,
    console: &Console,
) -> Result<Record, Failure> {
    let (jobs, rigid_meshes, mut record) = jobs(model, rigid, args);
    let folder = folder(args)?;
    let folder = folder.as_ref();
    let made = run_jobs(model, &jobs, &order(&costs_of(&jobs), true, args), folder, args, console)?;
    let mut baked = give_levels(model, &jobs, made, &mut record, console)?;
    if args.impostors {
        impostor::add(model, &mut baked, folder, args, &mut record, console)?;
    }
    if args.occluders {
        add_occluders(model, &mut baked, (&rigid_meshes, folder), args, console, &mut record)?;
    }
    model.baked = Some(baked);
    if args.merge {
        let merged = merge::run(model, folder, args, console)?;
        record.resumed += merged.resumed;
        (record.merged_groups, record.merged_triangles) = (merged.groups, merged.triangles);
    }
    Ok(record)
}

/// Gives the scene of a model the levels that were made of its meshes; what is baked of these.
fn give_levels(
    model: &mut Model,
    jobs: &[Job],
    made: Vec<Option<Made>>,
    record: &mut Record,
    console: &Console,
) -> Result<Baked, Failure> {
    let mut baked = Baked {
        generator: concat!("cullet-baker ", env!("CARGO_PKG_VERSION")).to_owned(),
        ..Baked::default()
    };
    for (job, made) in jobs.iter().zip(made) {
        let name = model.mesh_names.get(job.mesh as usize).map_or("", String::as_str);
        let name = name.to_owned();
        let (tables, resumed) = match made {
            Some(Ok((Some(tables), resumed))) => (tables, resumed),
            Some(Err(Problem::Failure(failure))) => return Err(failure),
            Some(Err(Problem::Levels(problem))) => {
                console.note(format!("note: mesh `{name}` has no {}: {problem}", job.kind.name()));
                continue;
            }
            _ => continue,
        };
        let triangles = (tables.indices.len() / 3) as u64;
        let given =
            tables.build(&model.scene.meshes()[job.mesh as usize]).and_then(|(held, levels)| {
                let held_by = model.scene.add_mesh(held);
                model.scene.add_levels(job.mesh, held_by, levels)?;
                Ok(held_by)
            });
        let held_by = match given {
            Ok(held_by) => held_by,
            Err(problem) => {
                console.note(format!("note: mesh `{name}` has no {}: {problem}", job.kind.name()));
                continue;
            }
        };
        model.mesh_names.resize(held_by as usize, String::new());
        model.mesh_names.push(format!("{name}, {}", job.kind.name()));
        record.levels_triangles += triangles;
        record.resumed += u64::from(resumed);
        match job.kind {
            LevelKind::Chain => record.chains += 1,
            LevelKind::Hierarchy => record.hierarchies += 1,
            LevelKind::Impostor => {}
        }
        if baked.meshes.last().is_none_or(|last| last.mesh != job.mesh) {
            let geometry = geometry_hash(&model.scene.meshes()[job.mesh as usize]);
            baked.meshes.push(BakedMesh { mesh: job.mesh, geometry, ..BakedMesh::default() });
        }
        let measured = mesh::measured(job.kind);
        if let Some(last) = baked.meshes.last_mut() {
            last.levels.push(BakedLevels { kind: job.kind, held_by, measured });
        }
    }
    record.meshes_with_levels = baked.meshes.len() as u64;
    Ok(baked)
}

/// Does a share of all that is baked of a model, and leaves it in the folder.
fn share(model: &mut Model, rigid: bool, args: &BakeArgs, console: &Console) -> Outcome {
    let path = args.units.path(&args.out).unwrap_or_default();
    let folder = Folder::new(&path)?;
    let (jobs, meshes, mut record) = jobs(model, rigid, args);
    // Impostors and merged groups are made of the levels of all meshes, so those of others that are
    // not there by then are made too.
    let needs_all = args.impostors || args.merge;
    let order_of_jobs = order(&costs_of(&jobs), needs_all, args);
    let made = run_jobs(model, &jobs, &order_of_jobs, Some(&folder), args, console)?;
    if args.occluders {
        let triangles = |&m: &u32| f64::from(model.scene.meshes()[m as usize].triangle_count());
        let costs: Vec<f64> = meshes.iter().map(triangles).collect();
        let own: Vec<u32> = order(&costs, false, args).into_iter().map(|k| meshes[k]).collect();
        occluders::make(model, &own, Some(&folder), resumes(args), threads(args), console)?;
    }
    // A mesh that is not for it is told of once all is joined.
    let quiet = Console::new(true, None);
    let baked = give_levels(model, &jobs, made, &mut record, &quiet)?;
    if args.impostors {
        impostor::share(model, &baked, &folder, args, console)?;
    }
    if args.merge {
        merge::share(model, &folder, args, console)?;
    }
    console.line(args.units.done(&path));
    Ok(Exit::Fine)
}

/// The levels that are to be made of a model's meshes, in the place of those that it has, and of
/// which meshes; of those alone that are `rigid` where the file keeps the others as they deform.
/// With the figures of what is there.
fn jobs(model: &mut Model, rigid: bool, args: &BakeArgs) -> (Vec<Job>, Vec<u32>, Record) {
    model.scene.clear_stand_ins();
    let used = used(&model.scene);
    (0..used.len() as u32).for_each(|mesh| model.scene.clear_levels(mesh));
    let stored = |m: usize| u64::from(model.scene.meshes()[m].triangle_count());
    let drawn = || (0..used.len()).filter(|&m| used[m] && stored(m) > 0);
    let record = Record {
        schema: SCHEMA,
        meshes: drawn().count() as u64,
        triangles: drawn().map(stored).sum(),
        ..Record::default()
    };
    let wanted = |kind: &LevelKind| match kind {
        LevelKind::Chain => !args.no_chain,
        LevelKind::Hierarchy => !args.no_hierarchy,
        LevelKind::Impostor => false,
    };
    let mut jobs = Vec::new();
    let mut rigid_meshes = Vec::new();
    for mesh in drawn() {
        let of = &model.scene.meshes()[mesh];
        if rigid && of.is_deformable() {
            continue;
        }
        rigid_meshes.push(mesh as u32);
        let triangles = of.triangle_count() - of.degenerate_count();
        let job = |kind| Job { mesh: mesh as u32, kind, triangles };
        jobs.extend(mesh::kinds(triangles).filter(wanted).map(job));
    }
    (jobs, rigid_meshes, record)
}

/// Makes occluders of meshes, and puts them beside what else is baked of these.
fn add_occluders(
    model: &Model,
    baked: &mut Baked,
    (meshes, folder): (&[u32], Option<&Folder>),
    args: &BakeArgs,
    console: &Console,
    record: &mut Record,
) -> Result<(), Failure> {
    let (made, resumed) =
        occluders::make(model, meshes, folder, resumes(args), threads(args), console)?;
    record.resumed += resumed;
    record.occluders = made.len() as u64;
    for (&mesh, tables) in meshes.iter().zip(made) {
        let at = baked.meshes.partition_point(|m| m.mesh < mesh);
        if baked.meshes.get(at).is_none_or(|m| m.mesh != mesh) {
            let geometry = geometry_hash(&model.scene.meshes()[mesh as usize]);
            baked.meshes.insert(at, BakedMesh { mesh, geometry, ..BakedMesh::default() });
        }
        baked.meshes[at].occluders = Some(tables);
    }
    Ok(())
}

/// Where what is finished lies, if it is kept.
fn folder(args: &BakeArgs) -> Result<Option<Folder>, Failure> {
    args.units.path(&args.out).map(|path| Folder::new(&path)).transpose()
}

/// Whether what lies there is taken.
fn resumes(args: &BakeArgs) -> bool {
    args.units.resume || args.units.unit.is_some()
}

/// The numbers of items that cost so much, in the order in which they are made: all, or this
/// process's share of them and after these, where they are needed too, those of others.
fn order(costs: &[f64], needs_all: bool, args: &BakeArgs) -> Vec<usize> {
    order_of_share(costs, args.units.share().unwrap_or([0, 1]), !needs_all)
}

/// Each kind of levels takes about as long as its triangles are many.
fn costs_of(jobs: &[Job]) -> Vec<f64> {
    jobs.iter().map(|job| job.triangles.into()).collect()
}

fn threads(args: &BakeArgs) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    args.threads.map_or(cores, |n| n as usize)
}

/// Returns for each mesh whether an instance draws it.
fn used(scene: &Scene) -> Vec<bool> {
    let mut used = vec![false; scene.meshes().len()];
    scene.slots().for_each(|s| used[scene.mesh_id(s) as usize] = true);
    used
}

/// Does the jobs of these numbers, in their order, on some threads. What comes of each is a
/// function of its mesh alone.
fn run_jobs(
    model: &Model,
    jobs: &[Job],
    order: &[usize],
    folder: Option<&Folder>,
    args: &BakeArgs,
    console: &Console,
) -> Result<Vec<Option<Made>>, Failure> {
    let threads = threads(args);
    let workers = threads.min(order.len()).max(1);
    // Only where there are fewer jobs than threads.
    let inner = (threads / workers).max(1);
    let next = AtomicUsize::new(0);
    let mut made: Vec<Option<Made>> = jobs.iter().map(|_| None).collect();
    let all = order.iter().map(|&j| u64::from(jobs[j].triangles)).sum();
    let mut progress = console.progress("baking triangles", all);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                while !interrupted() {
                    let Some(&j) = order.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    let made = run_job(model, &jobs[j], folder, resumes(args), inner);
                    if sender.send((j, made)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (j, one) in receiver {
            made[j] = Some(one);
            progress.steps(jobs[j].triangles.into());
        }
    });
    progress.finish();
    if order.iter().any(|&j| made[j].is_none()) {
        return Err(stopped(folder));
    }
    Ok(made)
}

fn run_job(
    model: &Model,
    job: &Job,
    folder: Option<&Folder>,
    resume: bool,
    threads: usize,
) -> Made {
    let mesh = &model.scene.meshes()[job.mesh as usize];
    let source = Source::new(mesh, model.attributes.get(job.mesh as usize));
    let key = folder.map(|folder| (folder, source.key(job.kind)));
    if let Some((folder, key)) = key.filter(|_| resume)
        && let Some(found) = folder.read(key)
        && found.as_ref().is_none_or(|tables| tables.clone().build(mesh).is_ok())
    {
        return Ok((found, true));
    }
    let made = source.build(job.kind, threads).map_err(Problem::Levels)?;
    if let Some((folder, key)) = key {
        folder.write(key, made.as_ref()).map_err(Problem::Failure)?;
    }
    Ok((made, false))
}

/// The most memory that was resident at once, where the system tells it (Linux).
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok().map(|kib: u64| kib * 1024)
}

fn print(r: &Record, args: &BakeArgs, console: &Console) {
    console.line(format!(
        "{} of {} with levels: {}, {}",
        grouped(r.meshes_with_levels),
        count(r.meshes, "mesh", "meshes"),
        count(r.chains, "chain", "chains"),
        count(r.hierarchies, "hierarchy", "hierarchies")
    ));
    console.line(format!(
        "{} in all levels, of {}",
        count(r.levels_triangles, "triangle", "triangles"),
        grouped(r.triangles)
    ));
    if args.impostors {
        console.line(format!(
            "{}: {} bytes in {:.1} s",
            count(r.impostors, "impostor", "impostors"),
            grouped(r.impostors_bytes),
            r.impostors_seconds
        ));
    }
    if r.occluders > 0 {
        let meshes = count(r.occluders, "mesh", "meshes");
        console.line(format!("occluders looked for in {meshes}"));
    }
    if args.merge {
        console.line(format!(
            "{}, with {} in all levels",
            count(r.merged_groups, "merged group of instances", "merged groups of instances"),
            count(r.merged_triangles, "triangle", "triangles")
        ));
    }
    if r.resumed > 0 {
        console.line(format!("{} taken from what was finished before", grouped(r.resumed)));
    }
    console.line(format!(
        "{} written: {} bytes in {:.1} s",
        args.out.display(),
        grouped(r.bytes),
        r.bake_seconds
    ));
}
