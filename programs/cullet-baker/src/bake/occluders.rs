//! Occluders of every mesh.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use cullet::{Mesh, MeshId};
use cullet_bake::occluders::{OccluderOptions, occluders};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::Failure;
use cullet_io::Model;
use cullet_io::baked::{Occluders, geometry_hash, hash};

use super::chunk::{Folder, stopped};

/// Counted up whenever the same mesh and options give other occluders.
const VERSION: u32 = 1;

/// Occluders of some meshes of a model, in their order, on some threads, and how many were there
/// before. What comes of each is a function of its mesh alone.
pub(super) fn make(
    model: &Model,
    meshes: &[MeshId],
    folder: Option<&Folder>,
    resume: bool,
    threads: usize,
    console: &Console,
) -> Result<(Vec<Occluders>, u64), Failure> {
    let mut order: Vec<usize> = (0..meshes.len()).collect();
    let of = |j: usize| &model.scene.meshes()[meshes[j] as usize];
    order.sort_by_key(|&j| std::cmp::Reverse(of(j).triangle_count()));
    let next = AtomicUsize::new(0);
    let mut made: Vec<Option<Occluders>> = meshes.iter().map(|_| None).collect();
    let (mut resumed, mut problem) = (0, None);
    let mut progress = console.progress("occluders", meshes.len() as u64);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.min(meshes.len()) {
            let (sender, order, next, of) = (sender.clone(), &order, &next, &of);
            scope.spawn(move || {
                while !interrupted() {
                    let Some(&j) = order.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    let one = one(of(j), folder, resume);
                    if sender.send((j, one)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (j, one) in receiver {
            match one {
                Ok((tables, before)) => {
                    made[j] = Some(tables);
                    resumed += u64::from(before);
                }
                Err(failure) => problem = Some(failure),
            }
            progress.step();
        }
    });
    progress.finish();
    if let Some(failure) = problem {
        return Err(failure);
    }
    let all: Option<Vec<Occluders>> = made.into_iter().collect();
    let all = all.ok_or_else(|| stopped(folder))?;
    Ok((all, resumed))
}

/// Returns the occluders of a mesh, and whether they were there before.
fn one(mesh: &Mesh, folder: Option<&Folder>, resume: bool) -> Result<(Occluders, bool), Failure> {
    let options = OccluderOptions::default();
    let key = folder.map(|folder| (folder, key(mesh, &options)));
    if let Some((folder, key)) = key.filter(|_| resume)
        && let Some(found) = folder.read_occluders(key)
    {
        return Ok((found, true));
    }
    let (tables, _) = occluders(mesh, &options).map_err(Failure::usage)?;
    if let Some((folder, key)) = key {
        folder.write_occluders(key, &tables)?;
    }
    Ok((tables, false))
}

/// Sum of all that the occluders of a mesh are a function of.
fn key(mesh: &Mesh, options: &OccluderOptions) -> u64 {
    let sides: Vec<_> = mesh.parts().iter().map(|p| (p.two_sided, p.alpha)).collect();
    let version = (VERSION, env!("CARGO_PKG_VERSION"), options, sides);
    let sums = [hash(format!("{version:?}").as_bytes()), geometry_hash(mesh)];
    hash(&sums.map(u64::to_le_bytes).concat())
}
