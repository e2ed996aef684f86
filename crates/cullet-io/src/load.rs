//! Loading a file by its content and ending.

use std::path::Path;

use crate::beside::Beside;
use crate::blocks::Source;
use crate::format::{Format, recognise};
use crate::{
    CellGraph, ErrorKind, LoadError, LoadOptions, Model, Warning, gltf, obj, off, ply, stl,
};

/// Loads a model: GLB, glTF, OBJ, PLY, STL or OFF, told by content first, then by ending. Maps, 3D
/// Tiles and `OCCSCN01` are recognised and refused: `cullet_maps::load` reads them too.
///
/// OBJ, PLY, STL and OFF say nothing of sides: their solids are one-sided, all else is two-sided.
/// Every vertex of the model is finite and every index in range; a file without triangles loads as
/// an empty scene with a warning. Memory stays within three times the decoded geometry (12 bytes a
/// vertex and 12 a triangle), what is prepared for culling, and a little: OBJ, PLY, STL and OFF are
/// read in blocks, and counts that a file claims are held against the bytes it has before anything
/// is allocated. What [`LoadOptions::details`] keeps comes on top: its own size, in OBJ twice that
/// and some 40 bytes for each combination of position, texture coordinates and normal.
///
/// # Errors
/// If the file cannot be read, is of no known kind, is invalid, or exceeds a limit of `options`.
/// The error names the file, the item (a line, a vertex, a face), the value and what would be
/// right.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_by(path, options, decode)
}

/// Loads a model from memory. `name` stands for the file's name in messages, and its ending helps
/// to recognise formats without a signature (OBJ). No other file is opened: the materials of an OBJ
/// stay grey, with a warning, and a glTF with external buffers is an error that names the first of
/// them; [`load_bytes_with`] takes such files along.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Model, LoadError> {
    load_bytes_with(name, bytes, &[], options)
}

/// Loads a model from memory with the files that it names: buffers of a glTF, material libraries of
/// an OBJ. `beside` has their names and contents; folders in names are passed over, on both sides,
/// and a name may differ in small letters and capitals where none is the same. What is not named is
/// not looked at.
///
/// # Errors
/// As [`load`]; a buffer that is not among them is named.
pub fn load_bytes_with(
    name: &str,
    bytes: &[u8],
    beside: &[(String, Vec<u8>)],
    options: &LoadOptions,
) -> Result<Model, LoadError> {
    load_bytes_by(name, bytes, beside, options, decode)
}

/// Decoder of a file: the model of a source, whose other files are beside it.
pub type Decode = fn(&Path, Source<'_>, &LoadOptions, Beside<'_>) -> Result<Model, ErrorKind>;

/// Loads a file as [`load`] does, with a decoder that knows other formats too.
///
/// # Errors
/// As [`load`].
pub fn load_by(path: &Path, options: &LoadOptions, decode: Decode) -> Result<Model, LoadError> {
    let read = || -> Result<Model, ErrorKind> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let model = decode(path, Source::open(path)?, options, Beside::Folder(folder))?;
        finished(model, options)
    };
    read().map_err(|kind| kind.at(path))
}

/// Loads bytes as [`load_bytes_with`] does, with a decoder that knows other formats too.
///
/// # Errors
/// As [`load`].
pub fn load_bytes_by(
    name: &str,
    bytes: &[u8],
    beside: &[(String, Vec<u8>)],
    options: &LoadOptions,
    decode: Decode,
) -> Result<Model, LoadError> {
    let path = Path::new(name);
    decode(path, Source::memory(bytes), options, Beside::Given(beside))
        .and_then(|model| finished(model, options))
        .map_err(|kind| kind.at(path))
}

/// Moves the scene's origin to the middle of a model that lies far from zero, as maps do, so that
/// the bounds of its instances, which are f32, stay tight; then prepares what is wanted, and finds
/// what is in its cells.
fn finished(mut model: Model, options: &LoadOptions) -> Result<Model, ErrorKind> {
    let extent = model.scene.extent();
    let length = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let centre = extent.center();
    if !extent.is_empty() && length(centre) > 8.0 * length(extent.half_extent()) {
        // Whole numbers, so that differences of coordinates stay exact.
        model.scene.rebase(centre.map(f64::round));
    }
    model.scene.prepare(options.prepare);
    if let Err(error) = model.place_cells() {
        // A map's were made here, so that it is no fault of the file.
        if !is_map(&model) {
            return Err(gltf::cells_error(&model.cells, &error));
        }
        let message = format!("portals hide nothing, for cells have no place: {error}");
        model.warnings.push(Warning { item: "cells".into(), message });
        model.cells = CellGraph::default();
        model.cell_sets = None;
    }
    Ok(model)
}

/// Whether a model is a map, which says how high eyes are.
fn is_map(model: &Model) -> bool {
    model.eye_height.is_some()
}

/// Decodes a file of a format that is read here; `beside` is where files named by the model are
/// looked for.
///
/// # Errors
/// If the file is of another format, invalid, or over a limit.
pub fn decode(
    path: &Path,
    source: Source<'_>,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Model, ErrorKind> {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let head = source.head(Source::HEAD)?;
    // The bytes of the file are freed before meshes are made: the peak is the greater of the two
    // halves, not their sum.
    let builder = match recognise(path, &head, source.size())? {
        // Owned, so that it can be freed once it is decoded.
        Format::Gltf => return gltf::load(path, source.into_bytes()?, options, beside),
        Format::Obj => obj::read(&name, source, options, beside)?,
        Format::Ply => ply::read(&name, source, options)?,
        Format::Stl => stl::read(&name, source, options)?,
        Format::Off => off::read(&name, source, options)?,
        format @ (Format::Tileset | Format::Occscn | Format::Bsp) => {
            let name = format.name();
            return Err(ErrorKind::Unsupported(format!(
                "{name} is not read here; the programs of cullet read it, and crate cullet-maps"
            )));
        }
    };
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that a file says, or why not, when it is read in blocks of some size.
    fn told(name: &str, bytes: &[u8], block: usize) -> String {
        let source = Source::in_blocks(bytes, block);
        match decode(Path::new(name), source, &LoadOptions::default(), Beside::Given(&[])) {
            Ok(model) => {
                let meshes = model.scene.meshes().iter();
                let meshes: Vec<_> =
                    meshes.map(|m| (m.positions(), m.indices(), m.parts())).collect();
                format!("{meshes:?} {:?} {:?}", model.mesh_names, model.warnings)
            }
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn files_that_a_model_names_are_taken_from_what_was_given() {
        let triangle: Vec<u8> =
            [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
        let gltf = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data/A%20b.bin"}]}"#;
        let load = |name: &str, bytes: &[u8], beside: &[(&str, &[u8])]| {
            let beside: Vec<_> =
                beside.iter().map(|(n, b)| ((*n).to_owned(), b.to_vec())).collect();
            load_bytes_with(name, bytes, &beside, &LoadOptions::default())
        };
        for name in ["A b.bin", "some/where/A b.bin", "a B.BIN"] {
            let model = load("a.gltf", gltf, &[("b.bin", b"no"), (name, &triangle)]).unwrap();
            assert_eq!(model.scene.triangle_count(), 1, "{name}");
        }
        let error = load("a.gltf", gltf, &[("b.bin", &triangle)]).unwrap_err().to_string();
        for part in ["a.gltf", "A b.bin is missing", "together", ".glb"] {
            assert!(error.contains(part), "{error}");
        }
        let short = load("a.gltf", gltf, &[("A b.bin", &triangle[1..])]).unwrap_err().to_string();
        assert!(short.contains("36") && short.contains("35"), "{short}");

        let obj = b"mtllib my mats.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let red: &[u8] = b"newmtl red\nKd 1 0 0\n";
        let model = load("a.obj", obj, &[("my mats.mtl", red)]).unwrap();
        assert_eq!((model.materials[0].color, model.warnings.len()), ([1.0, 0.0, 0.0, 1.0], 0));
        let grey = load("a.obj", obj, &[]).unwrap();
        assert!(grey.warnings[0].to_string().contains("not given"), "{}", grey.warnings[0]);
    }

    #[test]
    fn blocks_of_every_size_give_the_same_model_and_the_same_words() {
        let obj = "\u{feff}# a \\\r\nmtllib a.mtl\ng a\nv 0 0 0\nv 1 0 0\\\n\nv 0 \\\n1 0\r\nfoo bar\n\
                   usemtl b\r\nf 1/2/3 2//4 \\\r\n 3\no c\nf -1 -2 -3\n\nbar\nl 1 2\nf 1 2 3 4\n\
                   v 1 1 0\n";
        let ply = "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\n\
                   property float y\nproperty list uchar int l\nproperty float z\n\
                   element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0 0\n1 0 2 7 8 0\n0\n1 0 0\n3 0 1 2\n2 0 1\n";
        let stl = " solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                   vertex 0 1 0\nendloop\nendfacet\nwhat 1\nendsolid\nsolid c\nfacet\n\
                   vertex 0 0 1\nvertex 1 0 1\nvertex 1 1 1\nvertex 0 1 1\nendfacet\n";
        let off = "OFF # c\n4 2 # none\n0 0 0 255\n1 0 0\n# c\n0\n1\n0\n1 1 0\n\n3 0 1 2 red\n\
                   3 1 3\n2\nmore\n";
        let bad = |text: &str, from: &str, to: &str| text.replacen(from, to, 1);
        let mut files = vec![
            ("a.obj", bad(obj, "f 1 2", "f x 2").into_bytes()),
            ("a.obj", bad(obj, "f 1 2", "f 9 2").into_bytes()),
            ("a.obj", bad(obj, "v 1 1", "v 1 1e99").into_bytes()),
            ("a.obj", b"one\ntwo\nthree\n".to_vec()),
            ("a.obj", obj.replace("\r\n", "\r").replace('\n', "\r").into_bytes()),
            ("a.ply", bad(ply, "3 0 1 2", "3 0 1 3").into_bytes()),
            ("a.ply", bad(ply, "2 0 1\n", "2 0").into_bytes()),
            ("a.ply", bad(ply, "2 0 1\n", "200 0").into_bytes()),
            ("a.ply", bad(ply, "end_header", "end").into_bytes()),
            ("a.ply", bad(ply, "vertex 3", "vertex 3000").into_bytes()),
            ("a.ply", ply.replace('\n', "\r\n").into_bytes()),
            ("a.stl", bad(stl, "vertex 1 0 1", "vertex 1 x 1").into_bytes()),
            ("a.stl", bad(stl, "endfacet\n", "").into_bytes()),
            ("a.off", bad(off, "3 1 3\n2", "3 1 3\n4").into_bytes()),
            ("a.off", bad(off, "1 1 0", "1 1 inf").into_bytes()),
            ("a.off", bad(off, "4 2", "4 2000").into_bytes()),
        ];
        for (name, text) in [("a.obj", obj), ("a.ply", ply), ("a.stl", stl), ("a.off", off)] {
            files.push((name, text.as_bytes().to_vec()));
        }
        for (order, turn) in [("little", false), ("big", true)] {
            let header = bad(ply, "ascii", &format!("binary_{order}_endian"));
            let end = header.find("end_header\n").map_or(0, |at| at + 11);
            let mut bytes = header.as_bytes()[..end].to_vec();
            let word = |v: [u8; 4]| if turn { v.into_iter().rev().collect() } else { v.to_vec() };
            for [x, y, z] in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
                [x, y].iter().for_each(|v| bytes.extend(word(v.to_le_bytes())));
                bytes.push(1);
                bytes.extend([9; 4]);
                bytes.extend(word(z.to_le_bytes()));
            }
            bytes.push(3);
            [0u32, 1, 2].iter().for_each(|v| bytes.extend(word(v.to_le_bytes())));
            bytes.push(0);
            files.push(("a.ply", bytes.clone()));
            files.push(("a.ply", bytes[..bytes.len() - 3].to_vec()));
        }
        let mut binary = vec![b's'; 80];
        binary.extend(2u32.to_le_bytes());
        for x in 0..2u8 {
            binary.extend([0; 12]);
            for v in [0u8, 0, x, 1, 0, x, 0, 1, x] {
                binary.extend(f32::from(v).to_le_bytes());
            }
            binary.extend([0; 2]);
        }
        files.push(("a.stl", binary.clone()));
        files.push(("a.stl", binary[..150].to_vec()));
        for (name, bytes) in &files {
            let whole = told(name, bytes, 1 << 20);
            for block in (1..40).chain([64, 100, 200]) {
                assert_eq!(told(name, bytes, block), whole, "{name} in blocks of {block}");
            }
        }
        let lines = |text: &[u8]| told("a.obj", text, 3);
        assert!(lines(b"v 1 2 3\nv 1 2\n").starts_with("line 2: expected z"));
        assert!(told("a.ply", ply.as_bytes(), 5).contains("1 faces of fewer than 3 vertices"));
    }
}
