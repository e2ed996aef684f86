//! The files that a model names and that must be copied along with it.

use std::path::{Component, Path, PathBuf};

use crate::blocks::Source;
use crate::format::{Format, recognise};
use crate::{ErrorKind, LoadError, gltf, obj};

/// The files that loading a model looks for beside it: buffers of a glTF, material libraries of an
/// OBJ. Paths from the model's folder, in it or below, without `..`, in the order in which they are
/// named, none twice; whether they are there is not checked. What an OBJ names with blanks in it is
/// one file or several, so all of them are told. Other formats name nothing.
///
/// Reads the JSON of a glTF or GLB, and all of an OBJ.
///
/// # Errors
/// If the file cannot be read, is of no known kind, or its JSON is none.
pub fn files_named(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let named = || named(path, Source::open(path)?);
    named().map_err(|kind| kind.at(path))
}

/// [`files_named`] of a model in memory; `name` stands for the file's name.
///
/// # Errors
/// As [`files_named`].
pub fn files_named_in(name: &str, bytes: &[u8]) -> Result<Vec<PathBuf>, LoadError> {
    let path = Path::new(name);
    named(path, Source::memory(bytes)).map_err(|kind| kind.at(path))
}

fn named(path: &Path, source: Source<'_>) -> Result<Vec<PathBuf>, ErrorKind> {
    let all = match recognise(path, &source.head(Source::HEAD)?, source.size())? {
        Format::Gltf => gltf::named(path, &source)?,
        Format::Obj => obj::named(source)?,
        // Tiles name more tiles: what they need is told only by loading them.
        Format::Tileset
        | Format::Ply
        | Format::Stl
        | Format::Off
        | Format::Occscn
        | Format::Bsp => Vec::new(),
    };
    let mut files = Vec::new();
    for file in all.iter().filter_map(|file| below(file)) {
        if !files.contains(&file) {
            files.push(file);
        }
    }
    Ok(files)
}

/// A path without `.`; `None` if it leaves its folder, or names nothing.
fn below(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(part) => out.push(part),
            Component::CurDir => {}
            _ => return None,
        }
    }
    (!out.as_os_str().is_empty()).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, bytes: &[u8]) -> Vec<String> {
        let files = files_named_in(name, bytes).unwrap();
        files.iter().map(|f| f.to_string_lossy().replace('\\', "/")).collect()
    }

    const JSON: &[u8] = br#"{"asset":{"version":"2.0"},"buffers":[
        {"byteLength":4,"uri":"parts/my%20triangle.bin"},
        {"byteLength":4,"uri":"data:application/octet-stream;base64,AAAAAA=="},
        {"byteLength":4,"uri":"./b.bin"}, {"byteLength":4,"uri":"b.bin"}, {"byteLength":4},
        {"byteLength":4,"uri":"../secret.bin"}, {"byteLength":4,"uri":"/etc/passwd"},
        {"byteLength":4,"uri":"http://example.org/c.bin"}]}"#;

    #[test]
    fn a_gltf_names_its_buffers_and_nothing_outside_its_folder() {
        assert_eq!(of("a.gltf", JSON), ["parts/my triangle.bin", "b.bin"]);
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        let word = |n: usize| (n as u32).to_le_bytes();
        glb.extend(word(20 + JSON.len()));
        glb.extend(word(JSON.len()));
        glb.extend(b"JSON");
        glb.extend(JSON);
        assert_eq!(of("a.glb", &glb), ["parts/my triangle.bin", "b.bin"]);
        for end in [4, 12, 19, 20, 40, glb.len() - 1] {
            assert!(files_named_in("a.glb", &glb[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn what_cannot_be_loaded_is_refused_in_the_same_words() {
        for (name, bytes) in [("a.glb", &b"junk"[..]), ("a.gltf", b"junk"), ("a.txt", b"junk")] {
            let loaded = crate::load_bytes(name, bytes, &crate::LoadOptions::default());
            let named = files_named_in(name, bytes);
            assert_eq!(named.unwrap_err().to_string(), loaded.unwrap_err().to_string());
        }
    }

    #[test]
    fn an_obj_names_its_libraries() {
        let text = b"# mtllib no.mtl\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n  mtllib b c.mtl\r\nf 1 2 3\n\
            mtllib sub\\d.mtl\nmtllib a.mtl\nmtllib ../e.mtl\nmtllib";
        assert_eq!(of("a.obj", text), ["a.mtl", "b c.mtl", "b", "c.mtl", "sub/d.mtl"]);
        assert_eq!(of("a.stl", b"solid a\nendsolid a\n"), [""; 0]);
        assert!(files_named_in("a.obj", b"").is_err());
    }
}
