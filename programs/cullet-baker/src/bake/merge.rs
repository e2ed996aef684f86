//! Groups of instances, merged.

use std::sync::Mutex;

use crate::bake_args::BakeArgs;
use cullet_bake::merged::{
    Keep, MEASURED, MergeInput, MergeOptions, MergedGroup, MeshAttributes, add_to_scene, merge,
};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::Failure;
use cullet_io::baked::Measured;
use cullet_io::{Attributes, Model};

use super::chunk::{Folder, Groups, stopped};
use super::{resumes, threads};

/// Result of merging.
pub(super) struct Merged {
    pub(super) groups: u64,
    /// Triangles of all levels of the groups.
    pub(super) triangles: u64,
    /// How many groups were there before.
    pub(super) resumed: u64,
}

/// Makes this process's share of the groups of a model's instances, and keeps them; before, those
/// of others that they are made of and that are not there.
pub(super) fn share(
    model: &Model,
    folder: &Folder,
    args: &BakeArgs,
    console: &Console,
) -> Result<(), Failure> {
    groups(model, Some(folder), args, console).map(drop)
}

/// Merges groups of a model's instances, or a share of them, and how many were there before.
fn groups(
    model: &Model,
    folder: Option<&Folder>,
    args: &BakeArgs,
    console: &Console,
) -> Result<(Vec<MergedGroup>, u64), Failure> {
    let mut options = MergeOptions::default();
    options.threads = threads(args);
    let kept = folder.map(|folder| Groups::new(folder, resumes(args)));
    const STEPS: u64 = 1000;
    let progress = Mutex::new((console.progress("merging instances", STEPS), 0));
    let go_on = |share: f64| {
        if let Ok(mut progress) = progress.lock() {
            let now = (share * STEPS as f64) as u64;
            if now > progress.1 {
                let more = now - progress.1;
                progress.0.steps(more);
                progress.1 = now;
            }
        }
        !interrupted() && !kept.as_ref().is_some_and(Groups::has_failed)
    };
    let attributes: Vec<MeshAttributes<'_>> = model
        .attributes
        .iter()
        .map(|a| MeshAttributes { uvs: &a.uvs, colors: &a.colors })
        .collect();
    let keep = kept.as_ref().map(|kept| kept as &dyn Keep);
    let input = MergeInput { attributes: &attributes, keep, share: args.units.share() };
    let found = merge(&model.scene, &input, &options, go_on);
    if let Ok((mut progress, _)) = progress.into_inner() {
        progress.finish();
    }
    let found = found.map_err(|e| fail(model, &e))?;
    let resumed = kept.map_or(Ok(0), Groups::finish)?;
    Ok((found.ok_or_else(|| stopped(folder))?, resumed))
}

fn fail(model: &Model, e: &dyn std::fmt::Display) -> Failure {
    Failure::input(format!("{}: --merge: {e}", model.name))
}

/// Merges groups of a model's instances, and gives them to its scene.
pub(super) fn run(
    model: &mut Model,
    folder: Option<&Folder>,
    args: &BakeArgs,
    console: &Console,
) -> Result<Merged, Failure> {
    let (groups, resumed) = groups(model, folder, args, console)?;
    let triangles = |g: &MergedGroup| (g.levels.mesh.indices.len() / 3) as u64;
    let (count, triangles) = (groups.len() as u64, groups.iter().map(triangles).sum());
    let merged = Merged { groups: count, triangles, resumed };
    let first = model.scene.meshes().len();
    add_to_scene(&mut model.scene, &groups).map_err(|e| fail(model, &e))?;
    if groups.iter().any(|g| !g.uvs.is_empty() || !g.colors.is_empty()) {
        model.attributes.resize(first, Attributes::default());
        model.attributes.extend(groups.iter().map(|g| Attributes {
            uvs: g.uvs.clone(),
            colors: g.colors.clone(),
            ..Attributes::default()
        }));
    }
    model.mesh_names.resize(first, String::new());
    model.mesh_names.extend(groups.iter().map(|g| {
        format!(
            "{} merged",
            cullet_command::console::count(g.members.len() as u64, "instance", "instances")
        )
    }));
    if let Some(baked) = model.baked.as_mut().filter(|_| merged.groups > 0) {
        baked.stand_ins = Some(Measured {
            points: MEASURED.points,
            reverse_points: MEASURED.reverse_points,
            quantile: 1.0,
            most_over: 1.0,
            seed: MEASURED.seed,
        });
    }
    Ok(merged)
}
