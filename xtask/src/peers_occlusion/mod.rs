//! `cargo xtask peers-occlusion`: drawing occluders by `cullet` beside a prototype in C++, in rounds of one run.
//!
//! Both draw the same file at the same SIMD level, time what their own thread takes, leave out what is hidden by then,
//! and are held against the same references, which the prototype draws once and which are kept.

mod prototype;
mod row;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::tools::{Done, cargo, command, root, target};
use prototype::{Level, Prototype, levels};
use row::{Figures, Row, WAYS, Way, Who, table};

/// References: so many jittered samples a pixel, to each side.
const SAMPLES: [u32; 3] = [1, 4, 8];

/// Scenes where none is named, with what `cullet occscn` is told; `DATA` is the folder of the test data.
const SCENES: [(&str, &str); 3] = [
    (
        "castle",
        "DATA/intel-castle/intel-castle.glb --occluders castleLargeOccluders --occluders ground",
    ),
    ("sponza", "DATA/crytek-sponza/crytek-sponza.ply --up z"),
    ("city", "city:ground=0"),
];

/// Options of the command line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Options {
    prototype: Option<String>,
    scenes: Vec<String>,
    rounds: u32,
    passes: u32,
}

impl Options {
    /// Of what follows the command's name.
    pub(crate) fn parse(words: &[&str]) -> Result<Self, String> {
        let mut options = Self { prototype: None, scenes: Vec::new(), rounds: 3, passes: 15 };
        let mut words = words.iter();
        while let Some(&word) = words.next() {
            let value = words.next().ok_or_else(|| format!("{word} wants a value"))?;
            let number = || match value.parse::<u32>() {
                Ok(n) if (1..=1000).contains(&n) => Ok(n),
                _ => Err(format!("{word} {value}: it must be a number from 1 to 1000")),
            };
            match word {
                "--prototype" => options.prototype = Some((*value).to_owned()),
                "--scene" => options.scenes.push((*value).to_owned()),
                "--rounds" => options.rounds = number()?,
                "--passes" => options.passes = number()?,
                _ => return Err(format!("peers-occlusion has no option {word}")),
            }
        }
        Ok(options)
    }
}

/// A scene as a file of triangles, boxes and views.
struct Scene {
    name: String,
    path: PathBuf,
    is_convex: bool,
}

/// Builds both, measures in turns, and prints one table; an error where something visible was culled.
pub(crate) fn compare(options: &Options) -> Done {
    let levels = levels();
    if levels.is_empty() {
        return Err(
            "the prototype needs a processor with AVX2 and FMA; this one has not both".into()
        );
    }
    let folder = target().join("peers-occlusion");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let prototype = Prototype::find(options.prototype.as_deref(), &folder)?;
    cargo(&["build", "--quiet", "--release", "--package", "cullet-cli"])?;
    let mut scenes = Vec::new();
    for name in named(&options.scenes) {
        match export(&name, &folder)? {
            Some(scene) => scenes.push(scene),
            None => println!("skipped, for want of its model: {name}"),
        }
    }
    let mut rows: Vec<Row> = Vec::new();
    for scene in &scenes {
        let length = answers(&scene.path)?;
        prototype.refer(&scene.path, &SAMPLES, length, levels[levels.len() - 1])?;
        for way in WAYS.into_iter().filter(|w| scene.is_convex || !w.convex) {
            for level in &levels {
                let scene = scene.name.clone();
                rows.push(Row { scene, level: level.name, way, rounds: Vec::new() });
            }
        }
    }
    for round in 1..=options.rounds {
        println!("round {round} of {}", options.rounds);
        for row in &mut rows {
            let scene = scenes.iter().find(|s| s.name == row.scene);
            let level = levels.iter().find(|l| l.name == row.level);
            let (Some(scene), Some(&level)) = (scene, level) else { continue };
            let figures = measure(&prototype, scene, &row.way, level, options.passes)?;
            row.rounds.push(figures);
        }
    }
    println!(
        "{}; load {}; 1280x720, one thread, 16 views; fastest of {} rounds of {} passes, and the median",
        processor(),
        load(),
        options.rounds,
        options.passes
    );
    table(&rows).iter().for_each(|line| println!("{line}"));
    let faults = rows.iter().filter(|row| row.is_wrong() || !row.is_steady());
    let faults: Vec<String> =
        faults.map(|r| format!("{} of {} at {}", r.way.name, r.scene, r.level)).collect();
    if faults.is_empty() {
        return Ok(());
    }
    Err(format!("false culls, or other answers from round to round: {}", faults.join(", ")))
}

fn measure(
    prototype: &Prototype,
    scene: &Scene,
    way: &Way,
    level: Level,
    passes: u32,
) -> Result<Figures, String> {
    match way.who {
        Who::Prototype(options) => prototype.measure(&scene.path, options, &SAMPLES, passes, level),
        Who::Ours(options) => ours(&scene.path, options, passes, level),
    }
}

/// The scenes that are named, or all.
fn named(names: &[String]) -> Vec<String> {
    match names {
        [] => SCENES.iter().map(|s| s.0.to_owned()).collect(),
        names => names.to_vec(),
    }
}

/// Writes a scene's file. References that lie beside it stay while the file is the same.
fn export(name: &str, folder: &Path) -> Result<Option<Scene>, String> {
    let words = SCENES.iter().find(|s| s.0 == name).map_or(name, |s| s.1);
    let data = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty());
    let data = data.map_or_else(|| root().join("../shared/data"), |d| root().join(d));
    let mut args = vec!["--quiet".to_owned(), "occscn".to_owned()];
    for word in words.split(' ') {
        match word.strip_prefix("DATA") {
            Some(file) if !data.join(file.trim_start_matches('/')).is_file() => return Ok(None),
            Some(file) => args.push(format!("{}{file}", data.display())),
            None => args.push(word.to_owned()),
        }
    }
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let short: String = name.rsplit('/').next().unwrap_or(name).chars().map(plain).collect();
    let path = folder.join(format!("{short}.occscn"));
    let new = folder.join(format!("{short}.new"));
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let mut write = command(&program(), &[]);
    write.args(&args).args(["--views", "16", "--out"]).arg(&new);
    let out = write.output().map_err(|e| format!("{}: {e}", program()))?;
    if !out.status.success() {
        return Err(format!("{name}: {}", String::from_utf8_lossy(&out.stderr).trim()));
    }
    let is_same = fs::read(&path).is_ok_and(|old| fs::read(&new).is_ok_and(|new| old == new));
    if !is_same {
        for n in SAMPLES {
            // Absent ones are no fault.
            let _ = fs::remove_file(prototype::reference(&path, n));
        }
    }
    fs::rename(&new, &path).map_err(|e| fail(&new, e))?;
    Ok(Some(Scene { is_convex: name.starts_with("city"), name: short, path }))
}

/// How many answers a file has: an object in a view each.
fn answers(path: &Path) -> Result<u64, String> {
    let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let count = |i: usize| {
        let word = bytes.get(8 + i * 4..12 + i * 4)?;
        Some(u64::from(u32::from_le_bytes(word.try_into().ok()?)))
    };
    let counts = count(3).zip(count(4)).map(|(cameras, objects)| cameras * objects);
    counts.ok_or_else(|| format!("{}: it ends within its header", path.display()))
}

/// The program that is measured.
fn program() -> String {
    target().join("release/cullet").to_string_lossy().into_owned()
}

/// Measures a scene once with `cullet`.
fn ours(scene: &Path, options: &[&str], passes: u32, level: Level) -> Result<Figures, String> {
    let mut bench = command(&program(), &["--quiet", "bench", "occlusion", "--json", "-"]);
    bench.arg("--scene").arg(scene).args(["--level", level.name]).args(options);
    bench.args(["--passes", &passes.to_string()]);
    let out = bench.output().map_err(|e| format!("{}: {e}", program()))?;
    // Code 1 is a false cull, which the figures tell as well.
    if !matches!(out.status.code(), Some(0 | 1)) {
        return Err(format!("{}: {}", program(), String::from_utf8_lossy(&out.stderr).trim()));
    }
    let json = serde_json::from_slice(&out.stdout).map_err(|e| format!("{}: {e}", program()))?;
    read(&json).ok_or_else(|| format!("{}: its JSON has other keys than expected", program()))
}

/// The figures in what `cullet bench occlusion` writes.
fn read(json: &Value) -> Option<Figures> {
    let modes = json["modes"].as_array()?;
    let mode = modes.iter().find(|m| m["name"] == "interleaved")?;
    let reference = |&n: &u32| {
        let all = json["references"].as_array()?;
        all.iter().find(|r| r["samples"] == n && r["jittered"] == true)
    };
    let references = SAMPLES.iter().map(reference).collect::<Option<Vec<_>>>()?;
    let counts = |r: &&Value| Some((r["false_culls"].as_u64()?, r["visible"].as_u64()?));
    Some(Figures {
        ms: mode["render_ms"].as_f64()?,
        median_ms: mode["median_ms"].as_f64()?,
        found: references.first()?["efficiency"].as_f64()?,
        false_culls: references.iter().map(counts).collect::<Option<_>>()?,
    })
}

fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'));
    line.map_or_else(|| "an unknown processor".to_owned(), |l| l.1.trim().to_owned())
}

/// How many programs ran at once, on the average of a minute: with as many as cores times are too long.
fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().filter(|t| !t.is_empty()).unwrap_or("unknown").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_and_others_refused() {
        let of = |words: &str| Options::parse(&words.split_whitespace().collect::<Vec<_>>());
        let all = of("--scene castle --prototype p --scene a.glb --rounds 5 --passes 3").unwrap();
        assert_eq!((all.rounds, all.passes), (5, 3));
        assert_eq!(all.scenes, ["castle", "a.glb"]);
        assert_eq!(all.prototype.as_deref(), Some("p"));
        assert_eq!(of("").unwrap().rounds, 3);
        for wrong in ["--rounds 0", "--rounds", "--what 3", "castle", "--passes x"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn our_figures_are_those_that_leave_out_what_is_hidden() {
        let reference = |samples: u32, jittered: bool, false_culls: u64| {
            serde_json::json!({"samples": samples, "jittered": jittered, "visible": 10,
                "efficiency": 90.0 + f64::from(samples), "false_culls": false_culls})
        };
        let mode = |name: &str, ms: f64| serde_json::json!({"name": name, "render_ms": ms, "median_ms": ms + 1.0});
        let mut json = serde_json::json!({
            "modes": [mode("raw", 9.0), mode("sorted", 7.0), mode("interleaved", 5.0)],
            "references": [reference(1, false, 9), reference(1, true, 0), reference(4, true, 1),
                reference(8, true, 2)],
        });
        let figures = read(&json).unwrap();
        assert_eq!((figures.ms, figures.median_ms, figures.found), (5.0, 6.0, 91.0));
        assert_eq!(figures.false_culls, [(0, 10), (1, 10), (2, 10)]);
        json["references"] = serde_json::json!([]);
        assert_eq!(read(&json), None, "nothing was held against it");
    }
}
