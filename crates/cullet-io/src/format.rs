//! Detection of a file's format: by content first, then by ending.

use std::path::Path;

use crate::{ErrorKind, shell_word};

/// A kind of file that is loaded here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// glTF or GLB: their loader tells them apart.
    Gltf,
    /// The JSON of 3D Tiles.
    Tileset,
    /// Wavefront OBJ.
    Obj,
    /// PLY.
    Ply,
    /// STL.
    Stl,
    /// OFF.
    Off,
    /// `OCCSCN01`.
    Occscn,
    /// A map of Quake, Half-Life, Quake 2 or Quake 3.
    Bsp,
}

/// The kind of a file that has `size` bytes and begins with `head`, the first
/// [`Source::HEAD`](crate::blocks::Source::HEAD) of them.
///
/// # Errors
/// [`ErrorKind::Unsupported`], with a way to convert the file where there is one.
pub fn recognise(path: &Path, head: &[u8], size: u64) -> Result<Format, ErrorKind> {
    if size == 0 {
        return Err(ErrorKind::invalid("file", "it is empty (0 bytes); export it again"));
    }
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if let Some(format) = by_signature(head, size) {
        return Ok(format);
    }
    if let Some(name) = foreign_signature(head, size) {
        return Err(foreign(path, name));
    }
    let format = match ending.as_str() {
        "glb" | "gltf" => Format::Gltf,
        "obj" => Format::Obj,
        "ply" => Format::Ply,
        "stl" => Format::Stl,
        "off" => Format::Off,
        "occscn" => Format::Occscn,
        // Its own reader says which kinds of map there are.
        "bsp" => Format::Bsp,
        _ if FOREIGN.iter().any(|f| f.endings.contains(&ending.as_str())) => {
            return Err(foreign(path, &ending));
        }
        _ if crate::stl::is_binary(head, size) => Format::Stl,
        _ if looks_like_obj(head) => Format::Obj,
        _ => {
            return Err(ErrorKind::Unsupported(
                "neither its content nor its ending is of a known kind; known are \
                 .glb .gltf .obj .ply .stl .off .occscn .bsp"
                    .into(),
            ));
        }
    };
    Ok(format)
}

impl Format {
    /// Name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf => "a glTF",
            Self::Tileset => "a tileset of 3D Tiles",
            Self::Obj => "an OBJ",
            Self::Ply => "a PLY",
            Self::Stl => "an STL",
            Self::Off => "an OFF",
            Self::Occscn => "OCCSCN01",
            Self::Bsp => "a Quake map",
        }
    }
}

/// Whether a file begins as a map of Quake (29, BSP2), Half-Life (30), Quake 2 (38) or Quake 3 (46)
/// does.
fn is_map(head: &[u8]) -> bool {
    let magics: [&[u8]; 5] =
        [&[29, 0, 0, 0], &[30, 0, 0, 0], b"BSP2", b"IBSP\x26\0\0\0", b"IBSP\x2e\0\0\0"];
    magics.iter().any(|magic| head.starts_with(magic))
}

/// Detects a format by the bytes that it must begin with.
fn by_signature(head: &[u8], size: u64) -> Option<Format> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    if head.starts_with(b"glTF") {
        return Some(Format::Gltf);
    }
    if head.starts_with(b"OCCSCN01") {
        return Some(Format::Occscn);
    }
    if is_map(head) {
        return Some(Format::Bsp);
    }
    if let [b'p', b'l', b'y', b'\r' | b'\n', ..] = head {
        return Some(Format::Ply);
    }
    match json_kind(text) {
        JsonKind::Tileset => return Some(Format::Tileset),
        JsonKind::Gltf => return Some(Format::Gltf),
        JsonKind::Unknown => {}
    }
    if text.starts_with(b"{") && !contains(text, b"\"CityJSON\"") {
        return Some(Format::Gltf);
    }
    let word = text.split(u8::is_ascii_whitespace).next().unwrap_or(&[]);
    if crate::off::keyword(word).is_some() {
        return Some(Format::Off);
    }
    let solid = word.eq_ignore_ascii_case(b"solid");
    if solid
        && (crate::stl::is_binary(head, size)
            || has_word(text, b"facet")
            || has_word(text, b"endsolid"))
    {
        return Some(Format::Stl);
    }
    None
}

/// A kind of JSON that is loaded here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JsonKind {
    /// A tileset has a root.
    Tileset,
    /// A glTF has scenes, nodes or meshes.
    Gltf,
    /// Neither, as far as it was read.
    Unknown,
}

/// Returns the kind of a text by the members of its outermost object; the text may be cut short.
#[must_use]
pub fn json_kind(text: &[u8]) -> JsonKind {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text).trim_ascii_start();
    if !text.starts_with(b"{") {
        return JsonKind::Unknown;
    }
    let (mut at, mut depth) = (0, 0_u32);
    while let Some(&byte) = text.get(at) {
        at += 1;
        match byte {
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth = depth.saturating_sub(1),
            b'"' => {
                let start = at;
                while text.get(at).is_some_and(|&b| b != b'"') {
                    at += if text[at] == b'\\' { 2 } else { 1 };
                }
                let Some(name) = text.get(start..at) else { break };
                at += 1;
                let rest = text.get(at..).unwrap_or_default().trim_ascii_start();
                if depth != 1 || !rest.starts_with(b":") {
                    continue;
                }
                match name {
                    b"root" => return JsonKind::Tileset,
                    b"scenes" | b"nodes" | b"meshes" | b"accessors" | b"bufferViews"
                    | b"buffers" => return JsonKind::Gltf,
                    _ => {}
                }
            }
            _ => {}
        }
    }
    JsonKind::Unknown
}

/// The first statement of a file that has no signature of its own.
fn looks_like_obj(head: &[u8]) -> bool {
    let mut lines = head
        .split(|&b| b == b'\n' || b == b'\r')
        .map(<[u8]>::trim_ascii)
        .filter(|l| !l.is_empty() && !l.starts_with(b"#"));
    let word = lines.next().and_then(|l| l.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|w| matches!(w, b"v" | b"vt" | b"vn" | b"g" | b"o" | b"mtllib" | b"usemtl"))
}

/// A kind of file that is not loaded here, and how to make one that is.
struct Foreign {
    name: &'static str,
    endings: &'static [&'static str],
    /// Advice on how to convert it; `{in}` stands for the file's name, `{out.glb}` for the same with
    /// another ending.
    advice: &'static str,
}

const ASSIMP: &str = "convert it with Assimp: `assimp export {in} {out.glb}`";

const FOREIGN: &[Foreign] = &[
    Foreign {
        name: "FBX",
        endings: &["fbx"],
        advice: "convert it with FBX2glTF: `FBX2glTF -b -i {in} -o {out.glb}`",
    },
    Foreign {
        name: "STEP",
        endings: &["step", "stp", "p21"],
        advice: "tessellate it with Gmsh: `gmsh {in} -2 -o {out.stl}`",
    },
    Foreign {
        name: "IGES",
        endings: &["iges", "igs"],
        advice: "tessellate it with Gmsh: `gmsh {in} -2 -o {out.stl}`",
    },
    Foreign {
        name: "IFC",
        endings: &["ifc", "ifczip", "ifcxml"],
        advice: "convert it with IfcOpenShell: `IfcConvert {in} {out.glb}`",
    },
    Foreign {
        name: "USD",
        endings: &["usd", "usda", "usdc", "usdz"],
        advice: "convert it with Blender: `blender -b --python-expr \"import bpy, sys; a = sys.argv; \
                 bpy.ops.wm.read_homefile(use_empty=True); bpy.ops.wm.usd_import(filepath=a[-2]); \
                 bpy.ops.export_scene.gltf(filepath=a[-1])\" -- {in} {out.glb}`",
    },
    Foreign {
        name: "Blender",
        endings: &["blend"],
        advice: "export it with Blender: `blender -b {in} --python-expr \"import bpy, sys; \
                 bpy.ops.export_scene.gltf(filepath=sys.argv[-1])\" -- {out.glb}`",
    },
    Foreign { name: "COLLADA", endings: &["dae"], advice: ASSIMP },
    Foreign { name: "3DS", endings: &["3ds"], advice: ASSIMP },
    Foreign { name: "VRML or X3D", endings: &["wrl", "vrml", "x3d", "x3dv"], advice: ASSIMP },
    Foreign { name: "DirectX", endings: &["x"], advice: ASSIMP },
    Foreign { name: "LightWave", endings: &["lwo", "lws"], advice: ASSIMP },
    Foreign { name: "3MF", endings: &["3mf"], advice: ASSIMP },
    Foreign { name: "AMF", endings: &["amf"], advice: ASSIMP },
    Foreign { name: "DXF", endings: &["dxf"], advice: ASSIMP },
    Foreign { name: "MD2, MD3 or MD5", endings: &["md2", "md3", "md5mesh"], advice: ASSIMP },
    Foreign {
        name: "CityJSON",
        endings: &["cityjson"],
        advice: "convert it with cjio: `cjio {in} export glb {out.glb}`",
    },
    Foreign {
        name: "Draco",
        endings: &["drc"],
        advice: "unpack it with Draco's own tool: `draco_decoder -i {in} -o {out.obj}`",
    },
    Foreign {
        name: "point cloud",
        endings: &["las", "laz", "e57", "pcd", "xyz"],
        advice: "it has points and no surface; make a surface first, for example with MeshLab",
    },
    Foreign {
        name: "3ds Max, Maya, Cinema 4D, Rhino or SketchUp",
        endings: &["max", "ma", "mb", "c4d", "3dm", "skp"],
        advice: "export it as glTF from the program that made it",
    },
    Foreign {
        name: "compressed",
        endings: &["zip", "gz", "xz", "zst", "bz2", "7z", "3tz"],
        advice: "unpack it first",
    },
];

/// The name in [`FOREIGN`], or an ending there, of a file known by its first bytes.
fn foreign_signature(head: &[u8], size: u64) -> Option<&'static str> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let is = |magic: &[u8]| head.starts_with(magic);
    if is(b"Kaydara FBX Binary") || text.starts_with(b"; FBX ") {
        return Some("FBX");
    }
    if text.starts_with(b"ISO-10303-21") {
        let ifc = contains(text, b"FILE_SCHEMA(('IFC") || contains(text, b"FILE_SCHEMA (('IFC");
        return Some(if ifc { "IFC" } else { "STEP" });
    }
    if is(b"PXR-USDC") || text.starts_with(b"#usda") {
        return Some("USD");
    }
    if is(b"BLENDER") {
        return Some("Blender");
    }
    if is(b"DRACO") {
        return Some("Draco");
    }
    if text.starts_with(b"#VRML") {
        return Some("VRML or X3D");
    }
    if is(b"xof 0") {
        return Some("DirectX");
    }
    // A 3DS main chunk holds the file's size, give or take a little padding.
    if let [0x4d, 0x4d, a, b, c, d, ..] = *head {
        let stated = u64::from(u32::from_le_bytes([a, b, c, d]));
        if stated.abs_diff(size) < 64 {
            return Some("3DS");
        }
    }
    if text.starts_with(b"<") {
        let table: [(&[u8], &str); 4] = [
            (b"<COLLADA", "COLLADA"),
            (b"<X3D", "VRML or X3D"),
            (b"<amf", "AMF"),
            (b"<ifcXML", "IFC"),
        ];
        return table.iter().find(|(word, _)| contains(text, word)).map(|&(_, name)| name);
    }
    if text.starts_with(b"{") && contains(text, b"\"CityJSON\"") {
        return Some("CityJSON");
    }
    let packed: [&[u8]; 5] =
        [b"\x1f\x8b", b"\xfd7zXZ\0", b"\x28\xb5\x2f\xfd", b"BZh", b"7z\xbc\xaf\x27\x1c"];
    if packed.iter().any(|magic| is(magic)) {
        return Some("compressed");
    }
    None
}

/// The refusal of a file of a kind that is named, or has an ending, in [`FOREIGN`].
fn foreign(path: &Path, name_or_ending: &str) -> ErrorKind {
    let known =
        FOREIGN.iter().find(|f| f.name == name_or_ending || f.endings.contains(&name_or_ending));
    let Some(foreign) = known else {
        return ErrorKind::Unsupported(format!("{name_or_ending} files are not loaded here"));
    };
    let word = |path: &Path| shell_word(&path.to_string_lossy());
    let mut advice = foreign.advice.to_owned();
    for ending in ["glb", "stl", "obj"] {
        let made = word(&path.with_extension(ending));
        advice = advice.replace(&format!("{{out.{ending}}}"), &made);
    }
    // Last: a name may hold anything.
    let advice = advice.replace("{in}", &word(path));
    ErrorKind::Unsupported(format!("{} files are not loaded here; {advice}", foreign.name))
}

fn contains(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|w| w == word)
}

/// Whether a blank-separated word is among the first, in any case.
fn has_word(text: &[u8], word: &[u8]) -> bool {
    text.split(u8::is_ascii_whitespace).any(|w| w.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, bytes: &[u8]) -> Result<Format, String> {
        recognise(Path::new(name), bytes, bytes.len() as u64).map_err(|e| e.to_string())
    }

    #[test]
    fn content_comes_before_the_ending() {
        assert_eq!(of("a.obj", b"ply\nformat"), Ok(Format::Ply));
        assert_eq!(of("a.stl", b"  OFF\n"), Ok(Format::Off));
        assert_eq!(of("a.txt", b"glTF\x02"), Ok(Format::Gltf));
        assert_eq!(of("a", b"\xef\xbb\xbf{\"asset\":{}}"), Ok(Format::Gltf));
        let tileset = br#"{"schema":{"nodes":["root\"{"]},"root":{}}"#;
        assert_eq!(of("a.json", tileset), Ok(Format::Tileset));
        let gltf = br#"{"asset":{"root":1},"nodes":[{"extras":{"boundingVolume":0}}],"root":2}"#;
        assert_eq!(of("a.gltf", gltf), Ok(Format::Gltf));
        for end in 0..tileset.len() {
            let _ = json_kind(&tileset[..end]);
        }
        assert_eq!(of("a.obj", b"solid a\n facet normal"), Ok(Format::Stl));
        assert_eq!(of("a.bin", b"OCCSCN01"), Ok(Format::Occscn));
        assert_eq!(of("a.map", b"BSP2\0\0\0\0"), Ok(Format::Bsp));
        assert_eq!(of("a.glb", b"IBSP\x2e\0\0\0"), Ok(Format::Bsp));
    }

    #[test]
    fn the_ending_decides_what_content_cannot() {
        assert_eq!(of("a.OBJ", b"# comment"), Ok(Format::Obj));
        assert_eq!(of("a.off", b"8 6 0\n"), Ok(Format::Off));
        assert_eq!(of("a.data", b"# by hand\nv 1 2 3\n"), Ok(Format::Obj));
        assert!(of("a.data", b"hello").unwrap_err().contains(".glb"));
    }

    #[test]
    fn other_formats_name_a_converter() {
        for (name, bytes, word) in [
            ("a.fbx", &b"Kaydara FBX Binary  \0"[..], "`FBX2glTF -b -i a.fbx -o a.glb`"),
            ("a.step", b"ISO-10303-21;\nHEADER;", "`gmsh a.step -2"),
            ("a.x", b"ISO-10303-21;\nFILE_SCHEMA(('IFC2X3'));", "`IfcConvert a.x a.glb`"),
            ("a.usdc", b"PXR-USDC\0", "-- a.usdc a.glb`"),
            ("a.usdz", b"PK\x03\x04", "usd_import"),
            ("a.dae", b"<?xml?>\n<COLLADA>", "assimp export a.dae"),
            ("a.blend", b"BLENDER-v300", "export_scene.gltf"),
            ("a.json", b"{\"type\":\"CityJSON\"}", "cjio a.json"),
            ("a.3ds", b"whatever", "assimp export"),
            ("a.glb", b"\x1f\x8b\x08", "unpack"),
        ] {
            let error = of(name, bytes).unwrap_err();
            assert!(error.contains(word), "{name}: {error}");
        }
    }

    #[test]
    fn every_ending_has_advice() {
        for foreign in FOREIGN {
            for ending in foreign.endings {
                let error = of(&format!("x.{ending}"), b"\x01\x02\x03").unwrap_err();
                assert!(error.starts_with(foreign.name), "{error}");
                assert!(!error.contains('{'), "{error}");
            }
        }
    }

    #[test]
    fn empty_files_are_refused() {
        assert!(of("a.obj", b"").unwrap_err().contains("empty"));
    }
}
