//! Measurements that are run by hand.

use crate::tools::{Done, cargo, command, root, run, target};

/// `cullet bench`, and the benches for developers.
pub(crate) fn all() -> Done {
    cargo(&["run", "--release", "--", "bench"])?;
    let rooms = ["--manifest-path", "benches/peers/Cargo.toml", "--no-default-features"];
    cargo(&[&["bench", "--benches"], &rooms[..]].concat())?;
    cargo(&["bench", "--workspace", "--benches"])
}

/// Measures what each stage of culling saves the viewer's renderer in a scene; in the city and in
/// the office where none is named.
pub(crate) fn viewer(scene: Option<&str>) -> Done {
    let scenes = scene.map_or(vec!["city", "office"], |s| vec![s]);
    scenes.into_iter().try_for_each(|scene| {
        cargo(&["run", "--release", "-q", "-p", "cullet-viewer", "--", scene, "--bench"])
    })
}

/// Culling on the graphics device.
pub(crate) fn gpu() -> Done {
    cargo(&["bench", "-p", "cullet-gpu", "--bench", "device"])
}

/// The normal masks' table and graph on the graphics device, into a folder.
pub(crate) fn masks(folder: Option<&str>) -> Done {
    // The bench runs in the folder of its crate.
    let out = match folder {
        Some(folder) => std::env::current_dir().map_err(|e| e.to_string())?.join(folder),
        None => target().join("bench-gpu"),
    };
    let out = out.to_string_lossy().into_owned();
    cargo(&["bench", "-p", "cullet-gpu", "--bench", "masks", "--", "--out", &out])?;
    println!("written to {out}");
    Ok(())
}

/// The cuts of `cullet bench`, and of trimesh and VTK beside them.
pub(crate) fn peers_cut() -> Done {
    cargo(&["build", "--release", "--package", "cullet-lab"])?;
    let script = root().join("benches/peers/cut_python.py");
    let program = target().join("release/cullet-lab");
    run(command("python3", &[&script.to_string_lossy(), &program.to_string_lossy()]))
}
