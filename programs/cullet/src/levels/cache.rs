//! Where baked files are kept, and by what names.

use std::ffi::OsString;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Read;
use std::path::{Path, PathBuf};

use cullet_command::args::SceneArgs;

use super::LEVELS_VERSION;
use cullet_command::exit::Failure;

/// A format of several files: the whole folder counts, by names, lengths and times.
const WITH_OTHERS: [&str; 2] = ["gltf", "obj"];

/// The user's folder for files that can be made again. `None` where the system tells none.
pub(crate) fn folder() -> Option<PathBuf> {
    folder_from(|name| std::env::var_os(name), cfg!(windows))
}

fn folder_from(variable: impl Fn(&str) -> Option<OsString>, windows: bool) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let caches = if windows {
        set("LOCALAPPDATA")
    } else {
        // The XDG base directory specification has relative ones ignored.
        let xdg = set("XDG_CACHE_HOME").filter(|p| p.is_absolute());
        xdg.or_else(|| set("HOME").map(|home| home.join(".cache")))
    };
    Some(caches?.join("cullet"))
}

/// A name for what is baked of a scene: another for other bytes, other arguments, and another
/// version of the levels or of the program.
pub(crate) fn key(args: &SceneArgs) -> Result<String, Failure> {
    key_of(args, LEVELS_VERSION)
}

fn key_of(args: &SceneArgs, levels: u32) -> Result<String, Failure> {
    let version = (levels, env!("CARGO_PKG_VERSION"));
    let mut halves = [0u8, 1].map(|half| {
        let mut hasher = DefaultHasher::new();
        (half, version, args.one_sided, args.two_sided).hash(&mut hasher);
        format!("{:?}", args.up).hash(&mut hasher);
        hasher
    });
    if args.builtin() {
        halves.iter_mut().for_each(|hasher| ("built-in", &args.scene).hash(hasher));
    } else {
        add_file(Path::new(&args.scene), &mut halves)?;
    }
    let [a, b] = halves.map(|hasher| hasher.finish());
    Ok(format!("{a:016x}{b:016x}"))
}

fn add_file(path: &Path, halves: &mut [DefaultHasher; 2]) -> Result<(), Failure> {
    let fail =
        |e: std::io::Error| Failure::input(format!("{}: cannot be read: {e}", path.display()));
    let mut file = File::open(path).map_err(fail)?;
    let mut bytes = vec![0; 1 << 20];
    loop {
        let n = file.read(&mut bytes).map_err(fail)?;
        if n == 0 {
            break;
        }
        halves.iter_mut().for_each(|hasher| hasher.write(&bytes[..n]));
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if ending.is_some_and(|ending| WITH_OTHERS.contains(&ending.as_str())) {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).map_err(fail)?;
        let mut others: Vec<_> = entries
            .flatten()
            .filter_map(|entry| {
                let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
                Some((entry.file_name(), about.len(), about.modified().ok()))
            })
            .collect();
        others.sort();
        halves.iter_mut().for_each(|hasher| others.hash(hasher));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_the_users_own() {
        let of = |set: &[(&str, &str)], windows| {
            let find = |name: &str| set.iter().find(|s| s.0 == name).map(|s| OsString::from(s.1));
            folder_from(find, windows)
        };
        let path = |p: &str| Some(PathBuf::from(p));
        assert_eq!(of(&[("HOME", "/home/a")], false), path("/home/a/.cache/cullet"));
        let both = [("HOME", "/home/a"), ("XDG_CACHE_HOME", "/c")];
        assert_eq!(of(&both, false), path("/c/cullet"));
        let relative = [("HOME", "/home/a"), ("XDG_CACHE_HOME", "c")];
        assert_eq!(of(&relative, false), path("/home/a/.cache/cullet"));
        assert_eq!(of(&[("HOME", "")], false), None);
        assert_eq!(of(&[("HOME", "/home/a")], true), None);
    }

    #[test]
    fn other_bytes_arguments_and_neighbours_have_other_names() {
        let folder = std::env::temp_dir().join(format!("cullet-key-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.obj");
        let args = SceneArgs::of(path.to_string_lossy());
        assert!(key(&args).is_err(), "not there yet");
        std::fs::write(&path, "v 0 0 0\n").unwrap();
        let first = key(&args).unwrap();
        assert_eq!(key(&args).unwrap(), first);
        assert_ne!(key(&SceneArgs { one_sided: true, ..args.clone() }).unwrap(), first);
        assert_ne!(key_of(&args, LEVELS_VERSION - 1).unwrap(), first, "levels made otherwise");
        std::fs::write(folder.join("a.mtl"), "newmtl a\n").unwrap();
        let beside = key(&args).unwrap();
        assert_ne!(beside, first);
        std::fs::write(&path, "v 0 0 1\n").unwrap();
        assert_ne!(key(&args).unwrap(), beside);
        assert_ne!(
            key(&SceneArgs::of("city")).unwrap(),
            key(&SceneArgs::of("city:seed=2")).unwrap()
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
