//! The prototype in C++: found, compiled, run, and its output read.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::row::Figures;
use crate::tools::{command, cpp_compiler, root, run};

/// Names the folder of prototypes, where set and not empty.
const VARIABLE: &str = "CULLET_PROTOTYPES";
/// The prototype's folder below it.
const FOLDER: &str = "occlusion-patch";
/// The seed of the samples' shifts: with another the references would be others.
const SEED: &str = "1";

/// A SIMD level, by its name in `cullet` and as the compiler's options say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Level {
    pub(crate) name: &'static str,
    flags: &'static [&'static str],
}

const AVX2: Level =
    Level { name: "avx2", flags: &["-mavx2", "-mfma", "-mbmi", "-mbmi2", "-mlzcnt"] };
const AVX512: Level = Level {
    name: "avx512",
    flags: &[
        "-mavx2",
        "-mfma",
        "-mbmi",
        "-mbmi2",
        "-mlzcnt",
        "-mavx512f",
        "-mavx512cd",
        "-mavx512bw",
        "-mavx512dq",
        "-mavx512vl",
    ],
};

/// The levels of this machine that both have, best last; none where there is no AVX2.
pub(crate) fn levels() -> Vec<Level> {
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("avx2") && has!("fma") && has!("bmi2") && has!("lzcnt") {
            levels.push(AVX2);
        }
        // The last two stand for all that `cullet` wants of this level, and the prototype does not.
        let both = has!("avx512bw") && has!("avx512dq") && has!("avx512vl");
        if !levels.is_empty() && both && has!("avx512vbmi2") && has!("avx512bitalg") {
            levels.push(AVX512);
        }
    }
    levels
}

/// The prototype's sources, and where what is built of them goes.
#[derive(Debug)]
pub(crate) struct Prototype {
    sources: PathBuf,
    compiler: String,
    built: PathBuf,
}

impl Prototype {
    /// Finds the sources in `named`, else where the environment says, else beside the repository; and a compiler.
    pub(crate) fn find(named: Option<&str>, built: &Path) -> Result<Self, String> {
        let set = std::env::var_os(VARIABLE).filter(|v| !v.is_empty()).map(PathBuf::from);
        let folder = named.map(PathBuf::from).or(set);
        let folder = folder.unwrap_or_else(|| PathBuf::from("../shared/prototypes"));
        let sources = root().join(folder).join(FOLDER);
        if !sources.join("bench.cpp").is_file() {
            return Err(format!(
                "there is no {}: --prototype FOLDER or {VARIABLE} names the folder that {FOLDER} lies in; the table \
                 is ours beside that prototype, and `cullet bench occlusion --scene FILE` measures ours alone",
                sources.join("bench.cpp").display()
            ));
        }
        let compiler = cpp_compiler()?;
        Ok(Self { sources, compiler, built: built.to_owned() })
    }

    /// A program of it for a level; compiled where the sources are newer.
    fn program(&self, name: &str, level: Level) -> Result<PathBuf, String> {
        let out = self.built.join(format!("{name}-{}", level.name));
        let changed = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
        let headers = [self.sources.join("../scene.h")];
        let here = std::fs::read_dir(&self.sources).into_iter().flatten().flatten();
        let sources = here.map(|entry| entry.path()).chain(headers);
        let newest = sources.filter_map(|s| changed(&s)).max().unwrap_or(SystemTime::UNIX_EPOCH);
        if changed(&out).is_some_and(|built| built >= newest) {
            return Ok(out);
        }
        let source = self.sources.join(format!("{name}.cpp"));
        let mut compile = command(&self.compiler, &["-O3", "-std=c++17", "-pthread"]);
        compile.args(level.flags).arg(source).arg("-o").arg(&out);
        run(compile)?;
        Ok(out)
    }

    /// Makes the references of a scene that are not there yet, of `length` bytes each.
    pub(crate) fn refer(
        &self,
        scene: &Path,
        samples: &[u32],
        length: u64,
        level: Level,
    ) -> Result<(), String> {
        for n in samples {
            let path = reference(scene, *n);
            if path.metadata().is_ok_and(|m| m.len() == length) {
                continue;
            }
            let program = self.program("ref_jitter", level)?;
            println!("drawing {}", path.display());
            let mut draw = command(&program.to_string_lossy(), &[]);
            draw.arg(scene).arg(n.to_string()).arg(SEED).stderr(std::process::Stdio::null());
            run(draw)?;
        }
        Ok(())
    }

    /// Measures a scene once.
    pub(crate) fn measure(
        &self,
        scene: &Path,
        options: &[&str],
        samples: &[u32],
        passes: u32,
        level: Level,
    ) -> Result<Figures, String> {
        let program = self.program("bench", level)?;
        let mut bench = command(&program.to_string_lossy(), &[]);
        bench.arg(scene).arg("-n").arg(passes.to_string()).args(options);
        for n in samples {
            bench.arg("-ref").arg(format!("{n}j"));
        }
        let out = bench.output().map_err(|e| format!("{}: {e}", program.display()))?;
        let text = String::from_utf8_lossy(&out.stdout);
        if !out.status.success() {
            let why = String::from_utf8_lossy(&out.stderr);
            return Err(format!("{}: {}: {}", program.display(), out.status, why.trim()));
        }
        let figures = read(&text).filter(|f| f.false_culls.len() == samples.len());
        figures.ok_or_else(|| format!("{}: cannot be understood:\n{text}", program.display()))
    }
}

/// Where the reference of N × N jittered samples lies: `cullet bench occlusion` looks there too.
pub(crate) fn reference(scene: &Path, samples: u32) -> PathBuf {
    let mut name = scene.as_os_str().to_owned();
    name.push(format!(".ref{samples}j"));
    name.into()
}

/// The figures in the prototype's output; the share found is that of the first reference.
fn read(text: &str) -> Option<Figures> {
    let after = |line: &str, word: &str| -> Option<f64> {
        let rest = line.split_once(word)?.1.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        rest[..end].parse().ok()
    };
    let times = text.lines().find(|l| l.contains("render min"))?;
    let references: Vec<&str> =
        text.lines().filter(|l| l.trim_start().starts_with("ref")).collect();
    let counts = |l: &&str| Some((after(l, "FALSE")? as u64, after(l, " of ")? as u64));
    Some(Figures {
        ms: after(times, "render min")?,
        median_ms: after(times, "median")?,
        found: after(references.first()?, "found")?,
        false_culls: references.iter().map(counts).collect::<Option<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_output_of_the_prototype_is_read() {
        let text = "\
scene.bin: 48700 tris, 28417 prims, 99 comps, 610 pieces, ring 0.52 of own, edges 1 open 2 (66 ms)
 prep 0.010 clear 0.0014 render min 0.332 median 0.361 ms | test 58.0 ns
 pieces: seen 1 cone 2 hidden 3 drawn 4 | faces 5
 ref1j  hidden 50436 found 98.00% FALSE 0 of 4915
 ref4j  hidden 50417 found 98.03% FALSE 7 of 4934
";
        let found = read(text).unwrap();
        assert_eq!((found.ms, found.median_ms, found.found), (0.332, 0.361, 98.0));
        assert_eq!(found.false_culls, [(0, 4915), (7, 4934)]);
        assert!(read("").is_none());
        assert!(read("render min 1 median 2 ms\n").is_none(), "nothing was held against it");
    }

    #[test]
    fn what_is_missing_is_named() {
        let folder = std::env::temp_dir().join("cullet-no-such-prototypes");
        let why = Prototype::find(Some(&folder.to_string_lossy()), &folder).unwrap_err();
        assert!(why.contains("bench.cpp") && why.contains("--prototype"), "{why}");
    }

    #[test]
    fn references_lie_where_the_bench_looks() {
        assert_eq!(reference(Path::new("a/b.occscn"), 4), Path::new("a/b.occscn.ref4j"));
    }
}
