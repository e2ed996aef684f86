//! The scenes that are measured where none is named: what is built in, and the models of a folder.

use std::path::{Path, PathBuf};

use cullet_command::args::SceneArgs;
use cullet_io::Up;

/// Folder of the models where nobody names one, from the repository.
const DATA: &str = "../shared/data";
/// Models with defects, made to be refused, or to have nothing to see.
const BROKEN: &str = "broken";
/// Endings of files that hold a scene.
const ENDINGS: [&str; 8] = ["glb", "gltf", "obj", "ply", "stl", "off", "occscn", "bsp"];
/// Names of models whose z axis points up, which their files do not say.
const Z_UP: [&str; 2] = ["crytek-sponza.ply", "3-20-DELFSHAVEN.gltf"];

/// The folder of the models: the one that is named, else `CULLET_DATA`, else the one beside the
/// repository.
pub(super) fn folder(named: Option<&Path>) -> PathBuf {
    let set = || std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty()).map(PathBuf::from);
    named.map(Path::to_owned).or_else(set).unwrap_or_else(|| DATA.into())
}

/// Every built-in scene, and every model in a folder and those in it, in the order of their names.
/// A folder that is not there has none.
pub(super) fn all(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    collect(folder, &mut found);
    found.sort();
    let builtin = cullet_scenes::list().iter().map(|s| s.name.to_owned());
    builtin.chain(found.iter().map(|p| p.display().to_string())).collect()
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if path.is_dir() {
            if entry.file_name() != BROKEN {
                collect(&path, found);
            }
        } else if ending.is_some_and(|e| ENDINGS.contains(&e.as_str())) {
            found.push(path);
        }
    }
}

/// The arguments that load a scene.
pub(super) fn args(scene: &str) -> SceneArgs {
    let up = Z_UP.iter().any(|name| scene.ends_with(name)).then_some(Up::Z);
    let scene = scene.to_owned();
    SceneArgs { up, ..SceneArgs::of(scene) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_found_in_folders_and_broken_ones_left_out() {
        let folder = std::env::temp_dir().join(format!("cullet-pays-{}", std::process::id()));
        for file in ["b/two.GLB", "a/one.obj", "a/readme.txt", "broken/three.glb"] {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let builtin = cullet_scenes::list().len();
        let found = all(&folder);
        let names: Vec<_> =
            found[builtin..].iter().map(|f| f.rsplit('/').next().unwrap()).collect();
        assert_eq!(names, ["one.obj", "two.GLB"]);
        assert_eq!(found[0], "city");
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(all(&folder).len(), builtin);
    }
}
