//! Command lines in messages: each is run as it is printed, against what provoked it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use cullet_testkit::Folder;

/// Names that a shell reads something into.
const NAMES: [&str; 4] = ["a b", "it's", "-n $HOME", "50%#1&;é"];

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Runs a command line as a user types it, in a folder.
fn typed(line: &str, folder: &Folder) -> Output {
    let programs = Path::new(env!("CARGO_BIN_EXE_cullet")).parent().expect("in a folder");
    let paths = [programs.to_path_buf(), PathBuf::from("/usr/bin"), PathBuf::from("/bin")];
    Command::new("sh")
        .args(["-c", line])
        .current_dir(folder.path(""))
        .env("PATH", std::env::join_paths(paths).expect("no colons"))
        .env("CULLET_COSTS", folder.path("no-costs.json"))
        .env("XDG_CACHE_HOME", folder.path("cache"))
        .output()
        .expect("a shell")
}

/// Output of a command, and its errors.
fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// The command lines between backticks.
fn advised(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Provokes a message and runs the command in it that begins with `begin`.
fn follow(line: &str, begin: &str, folder: &Folder) -> String {
    let text = said(&typed(line, folder));
    let found = advised(&text).into_iter().find(|advice| advice.starts_with(begin));
    let advice = found.unwrap_or_else(|| panic!("{line}: no {begin} in {text}"));
    let followed = typed(&advice, folder);
    assert_eq!(followed.status.code(), Some(0), "{advice}: {}", said(&followed));
    said(&followed)
}

#[cfg(unix)]
#[test]
fn advice_of_the_programs_works_for_files_of_any_name() {
    let folder = Folder::new("advice");
    std::fs::create_dir_all(folder.path("in a folder")).unwrap();
    for name in NAMES {
        // Six warnings: a statement is unknown, and five libraries are missing.
        let file = format!("in a folder/{name}.obj");
        let libraries: String = (0..5).map(|i| format!("mtllib missing{i}.mtl\n")).collect();
        let _ = folder.file(&file, &format!("{libraries}{TRIANGLE}what is this\n"));
        let word = cullet_io::shell_word(&file);
        let picture = "--views 1 --size 64x40 --samples 1";
        let all = follow(&format!("cullet verify {word} {picture}"), "cullet info", &folder);
        assert!(all.contains("missing4.mtl"), "{all}");
        let baked = follow(
            &format!("cullet bench culler {word} --lod 1 --seconds 0.01"),
            "cullet bake",
            &folder,
        );
        assert!(baked.contains("baked.glb"), "{baked}");
        let recording = cullet_io::shell_word(&format!("{name}.occ"));
        follow(
            &format!("cullet verify {word} {picture} --record {recording}"),
            "cullet replay",
            &folder,
        );
    }
    let costs = "cullet report solids:n=20 --views 1 --size 64x40 --costs 'my costs.json'";
    follow(costs, "cullet calibrate", &folder);
    assert!(typed(costs, &folder).status.success());
    let _ = folder.file("my costs.json", "{}");
    follow(costs, "cullet calibrate", &folder);
}

/// Options and words that other tools document, by the tool's name: those that a command of ours
/// may name.
const TOOLS: [(&str, &[&str]); 8] = [
    // https://github.com/facebookincubator/FBX2glTF#running
    ("FBX2glTF", &["-b", "-i", "-o"]),
    // https://gmsh.info/doc/texinfo/gmsh.html#Gmsh-command_002dline-interface
    ("gmsh", &["-2", "-o"]),
    // https://docs.ifcopenshell.org/ifcconvert/usage.html
    ("IfcConvert", &[]),
    // https://docs.blender.org/manual/en/latest/advanced/command_line/arguments.html
    ("blender", &["-b", "--python-expr", "--"]),
    // https://github.com/assimp/assimp/blob/master/tools/assimp_cmd/Export.cpp
    ("assimp", &["export"]),
    // https://github.com/cityjson/cjio#using-the-cli
    ("cjio", &["export", "glb"]),
    // https://github.com/google/draco#decoding-tool
    ("draco_decoder", &["-i", "-o"]),
    // https://gltf-transform.dev/cli and https://github.com/CesiumGS/3d-tiles-tools#command-line-tools
    ("npx", &["@gltf-transform/cli", "copy"]),
];

#[cfg(unix)]
#[test]
fn advice_for_other_tools_is_of_their_documented_form_for_files_of_any_name() {
    let folder = Folder::new("advice-tools");
    // What a shell makes of the words, one a line.
    let words = |line: &str| -> Vec<String> {
        let output = typed(&format!("for w in {line}; do printf '%s\\n' \"$w\"; done"), &folder);
        assert!(output.status.success(), "{line}: {}", said(&output));
        said(&output).lines().map(str::to_owned).collect()
    };
    let endings = [
        "fbx", "step", "iges", "ifc", "usdc", "usda", "blend", "dae", "3ds", "wrl", "x", "lwo",
        "3mf", "amf", "dxf", "md3", "cityjson", "drc",
    ];
    for ending in endings {
        for name in NAMES {
            let file = folder.file(&format!("{name}.{ending}"), "\u{1}\u{2}");
            let output = Command::new(env!("CARGO_BIN_EXE_cullet"))
                .args(["info", "--", &format!("{name}.{ending}")])
                .current_dir(folder.path(""))
                .output()
                .unwrap();
            let text = said(&output);
            let [advice] = &advised(&text)[..] else { panic!("{file}: {text}") };
            let words = words(advice);
            let (_, known) = TOOLS
                .iter()
                .find(|(tool, _)| words[0] == *tool)
                .unwrap_or_else(|| panic!("{advice}: whose command is it?"));
            let is_file = |w: &String| w.ends_with(&format!("{name}.{ending}"));
            let made = |w: &String| {
                ["glb", "stl", "obj"].iter().any(|e| w.ends_with(&format!("{name}.{e}")))
            };
            assert_eq!(words.iter().filter(|w| is_file(w)).count(), 1, "{advice}");
            assert_eq!(words.iter().filter(|w| made(w)).count(), 1, "{advice}");
            for word in &words[1..] {
                let script = word.starts_with("import bpy");
                assert!(
                    is_file(word) || made(word) || script || known.contains(&word.as_str()),
                    "{advice}: '{word}' is no documented word of {}",
                    words[0]
                );
            }
        }
    }
}
