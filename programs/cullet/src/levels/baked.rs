//! Scenes with levels of detail: those of the file, or the baker's.

use std::collections::HashMap;
use std::ffi::OsString;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;

use cullet::{Mesh, Scene};
use cullet_command::args::{CullArgs, SceneArgs};
use cullet_command::console::{Console, count};
use cullet_command::exit::{Exit, Failure};
use cullet_command::inputs::{self, has_levels};
use cullet_io::{Model, shell_word};

use super::cache;
use crate::neighbours::BAKER;

/// Parts that a scene is loaded with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Levels of its meshes.
    Levels,
    /// Those, and its instances merged in groups.
    Groups,
}

/// Loads a scene as [`inputs::load`] does; where levels of detail are drawn, [with
/// some](load_with).
///
/// # Errors
/// As that.
pub fn load(args: &SceneArgs, cull: &CullArgs, console: &Console) -> Result<Model, Failure> {
    match cull.levels() {
        Some(_) => load_with(args, Wanted::Levels, console),
        None => inputs::load(args, console),
    }
}

/// Loads a scene with its levels of detail; where it has none, with those that the baker made of
/// it, now or before. With groups it is the baked file that is loaded, where the scene has none of
/// its own.
///
/// # Errors
/// If the scene cannot be read, or no levels can be had.
pub fn load_with(args: &SceneArgs, wanted: Wanted, console: &Console) -> Result<Model, Failure> {
    let mut model = inputs::load(args, console)?;
    let scene = &model.scene;
    if has_levels(scene) && (wanted == Wanted::Levels || scene.stand_in_slots().next().is_some()) {
        return Ok(model);
    }
    let start = Instant::now();
    let (path, is_new) = file(args, wanted, &model.name, console)?;
    let baked =
        inputs::load(&SceneArgs::of(path.to_string_lossy()), &Console::new(true, None)).map_err(
            |f| Failure { message: format!("{}; delete it, and it is made again", f.message), ..f },
        )?;
    let done = if is_new { "baked" } else { "read" };
    if wanted == Wanted::Groups {
        let (seconds, path) = (start.elapsed().as_secs_f64(), path.display());
        let groups = count(baked.scene.stand_in_slots().count() as u64, "group", "groups");
        console.note(format!("{}: {groups} {done} in {seconds:.1} s, in {path}", model.name));
        return Ok(Model { name: model.name, ..baked });
    }
    let given = give(&mut model.scene, &baked.scene);
    if given == 0 {
        let why = match has_levels(&baked.scene) {
            true => "its meshes are others than those that the baker wrote",
            false => "no mesh of it has fewer triangles within any bound that pays",
        };
        console.note(format!("{}: has no levels of detail, for {why}", model.name));
        return Ok(model);
    }
    console.note(format!(
        "{}: levels of detail of {} {done} in {:.1} s, in {}",
        model.name,
        count(given, "mesh", "meshes"),
        start.elapsed().as_secs_f64(),
        path.display()
    ));
    Ok(model)
}

/// The file that the baker makes of a scene, now or before, and whether it is new.
///
/// # Errors
/// If none can be made.
pub fn file(
    args: &SceneArgs,
    wanted: Wanted,
    name: &str,
    console: &Console,
) -> Result<(PathBuf, bool), Failure> {
    let folder = cache::folder().ok_or_else(|| {
        cannot(args, "the system tells no folder for files that can be made again; set XDG_CACHE_HOME or HOME")
    })?;
    let groups = if wanted == Wanted::Groups { "-groups" } else { "" };
    let path = folder.join(format!("{}{groups}.glb", cache::key(args)?));
    let is_new = !path.is_file();
    if is_new {
        std::fs::create_dir_all(&folder).map_err(|e| Failure::write(&folder, &e))?;
        console.note(format!("{name}: levels of detail are made of it, once"));
        bake(args, wanted, &path, console)?;
    }
    Ok((path, is_new))
}

/// Has the baker write a file, which is there only once it is whole.
fn bake(args: &SceneArgs, wanted: Wanted, path: &Path, console: &Console) -> Result<(), Failure> {
    let beside = path.with_extension(format!("{}.glb", std::process::id()));
    let mut words: Vec<OsString> = vec!["--quiet".into(), "bake".into(), (&args.scene).into()];
    if let Some(up) = args.up {
        words.extend(["--up".into(), format!("{up:?}").to_ascii_lowercase().into()]);
    }
    words.extend(args.one_sided.then(|| "--one-sided".into()));
    words.extend(args.two_sided.then(|| "--two-sided".into()));
    if let Some(most) = args.max_triangles {
        words.extend(["--max-triangles".into(), most.to_string().into()]);
    }
    words.extend((wanted == Wanted::Groups).then(|| "--merge".into()));
    words.extend(["-o".into(), beside.clone().into()]);
    let ended = BAKER.work(&words, console.quiet);
    let result = match ended {
        Ok(Exit::Fine) => std::fs::rename(&beside, path).map_err(|e| Failure::write(path, &e)),
        Ok(Exit::Interrupted) => Err(Failure {
            exit: Exit::Interrupted,
            message: "interrupted while levels of detail were made".into(),
        }),
        Ok(exit) => Err(Failure { exit, ..cannot(args, "the baker has said why") }),
        Err(f) => Err(Failure { exit: f.exit, ..cannot(args, &f.message) }),
    };
    if result.is_err() {
        // What is not whole is of no use to anybody.
        let _ = std::fs::remove_file(&beside);
    }
    result
}

fn cannot(args: &SceneArgs, why: &str) -> Failure {
    let scene = &args.scene;
    let word = shell_word(scene);
    Failure::input(format!(
        "{scene} has no levels of detail, and none can be made: {why}\n\
         Where the baker runs, `cullet bake {word} -o baked.glb` writes a file that has them; give that instead"
    ))
}

/// Gives the meshes of a scene the levels that equal meshes of another have: how many got some.
fn give(scene: &mut Scene, baked: &Scene) -> u64 {
    let of: HashMap<u64, u32> = (0..baked.meshes().len() as u32)
        .filter(|&mesh| !baked.levels(mesh).is_empty())
        .map(|mesh| (fingerprint(&baked.meshes()[mesh as usize]), mesh))
        .collect();
    let mut holders: HashMap<u32, u32> = HashMap::new();
    let mut given = 0;
    for mesh in 0..scene.meshes().len() as u32 {
        let Some(&twin) = of.get(&fingerprint(&scene.meshes()[mesh as usize])) else { continue };
        let mut any = false;
        for levels in baked.levels(twin) {
            let held_by = *holders
                .entry(levels.mesh)
                .or_insert_with(|| scene.add_mesh(baked.meshes()[levels.mesh as usize].clone()));
            any |= scene.add_levels(mesh, held_by, levels.levels.clone()).is_ok();
        }
        given += u64::from(any);
    }
    given
}

/// Hashes the corners of all triangles in their original order, however vertices are shared.
fn fingerprint(mesh: &Mesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    let data = mesh.to_data();
    for part in mesh.parts() {
        (part.first_triangle, part.triangle_count, part.two_sided).hash(&mut hasher);
    }
    for &vertex in &data.indices {
        // Adding zero makes −0 into 0, which is the same place.
        let place = data.positions[vertex as usize].map(|v| (v + 0.0).to_bits());
        place.hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Transform};
    use cullet_testkit::steps::Balls;

    use super::*;

    #[test]
    fn equal_meshes_get_the_levels_and_others_none() {
        let mut baked = Scene::new();
        let ball = Balls::new(&[16, 8, 4], 1.0).add_to(&mut baked);
        let mut scene = Scene::new();
        let other = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
        let twins = [0, 1].map(|_| scene.add_mesh(baked.meshes()[ball as usize].clone()));
        for mesh in [other, twins[0], twins[1]] {
            scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        }
        scene.commit(&cullet::Culler::default());
        assert!(!has_levels(&scene));
        assert_eq!(give(&mut scene, &baked), 2);
        assert_eq!(twins.map(|mesh| scene.levels(mesh).len()), [1, 1]);
        assert!(scene.levels(other).is_empty());
        // Both share the mesh that holds them.
        assert_eq!(scene.meshes().len(), 4);
        assert_eq!(super::super::holders(&scene), [false, false, false, true]);
        let mut strange = Scene::new();
        strange.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [2.0; 3]));
        assert_eq!(give(&mut strange, &baked), 0);
    }

    #[test]
    fn without_a_baker_it_is_said_what_to_do() {
        let told = cannot(&SceneArgs::of("a.glb"), "there is none");
        assert_eq!(told.exit, Exit::Input);
        assert!(told.message.contains("cullet bake a.glb -o baked.glb"), "{}", told.message);
        assert!(told.message.contains("there is none"));
    }
}
