//! The classes for C#: compiled and run by Mono, beside the C library that they call.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use super::{c, golden};
use crate::runner::{End, Ended, Skip};
use crate::tools::{
    Done, alone, cargo_program, command, install, install_words, is_ci, output, root, run, target,
};

/// Packages of Debian with the compiler and the runtime, and the compiler of C for what stands
/// beside them.
const PACKAGES: &[&str] = &["mono-mcs", "mono-runtime", "gcc"];
/// Ways to compile: with the host's spans, and with spans over arrays.
const WAYS: [(&str, &[&str]); 2] = [("spans", &[]), ("no_spans", &["-define:CULLET_NO_SPAN"])];

/// Installs the C library into the target folder, and tests the classes against it.
pub(crate) fn test() -> Ended {
    if ["mcs", "mono", "gcc"].iter().any(|c| output(c, &["--version"]).is_none()) {
        if !is_ci() {
            return Ok(End::Skipped(Skip::new("the classes for C#", install_words(PACKAGES))));
        }
        install(PACKAGES)?;
    }
    let host = Host::install("host-csharp", c::PROFILE, &[])?;
    let bakes = Host::install(
        "host-csharp-bake",
        c::BAKE_PROFILE,
        &[("CULLET_FEATURES", c::BAKE_FEATURES)],
    )?;
    host.printed()?;
    host.examples()?;
    host.tests(&bakes)?;
    Ok(End::Passed)
}

/// An install tree of the C library, and the folder of what is compiled against it.
struct Host {
    source: PathBuf,
    prefix: PathBuf,
    work: PathBuf,
}

impl Host {
    /// Installs the library that a profile and settings of the script make.
    fn install(name: &str, profile: &str, settings: &[(&str, &str)]) -> Result<Self, String> {
        let folder = target().join(name);
        let _ = fs::remove_dir_all(&folder);
        let host = Self {
            source: root().join("bindings/csharp"),
            prefix: folder.join("installed"),
            work: folder.join("work"),
        };
        fs::create_dir_all(&host.work).map_err(|e| format!("{}: {e}", host.work.display()))?;
        // Another step may have built the library: then this copies it.
        let _alone = alone("c")?;
        let script = root().join("bindings/c/install.sh");
        let mut install = command("sh", &[]);
        install.arg(script).arg(&host.prefix).arg(profile).envs(settings.iter().copied());
        install.env("CARGO", cargo_program()).env("CARGO_TARGET_DIR", target());
        run(install)?;
        Ok(host)
    }

    /// A command in the folder of work that finds the C library.
    fn command(&self, program: &str, args: &[&str]) -> Command {
        let mut command = command(program, args);
        command.current_dir(&self.work).env("LD_LIBRARY_PATH", self.prefix.join("lib"));
        command
    }

    /// Compiles files of the binding, by patterns, into a program of the folder of work.
    fn compile(&self, program: &str, files: &[&str], flags: &[&str]) -> Done {
        let words = ["-unsafe", "-langversion:7.2", "-warnaserror", "-r:System.Core.dll"];
        let mut compile = self.command("mcs", &[&words[..], flags].concat());
        compile.arg(format!("-out:{program}"));
        // mcs takes patterns itself.
        compile.args(files.iter().map(|file| self.source.join(file)));
        run(compile)
    }

    /// Runs the commands that the README and the chapter print after the install of the C library.
    fn printed(&self) -> Done {
        let read = |name: &str| {
            let path = self.source.join(name);
            fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
        };
        let example = read("examples/Boxes.cs")?;
        for name in ["README.md", "../../docs/src/csharp.md"] {
            let text = read(name)?;
            if !text.contains(&example) {
                return Err(format!(
                    "bindings/csharp/{name} does not have examples/Boxes.cs as it is"
                ));
            }
            let block = text.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next());
            let commands = block.and_then(|b| b.split_once("\nmcs ")).map(|(_, rest)| rest);
            let commands = commands.ok_or_else(|| format!("{name} has no commands"))?;
            let commands = commands.replace("$HOME/cullet", &self.prefix.to_string_lossy());
            let commands =
                commands.replace("bindings/", &format!("{}/bindings/", root().display()));
            let line = format!("mcs {commands}");
            let mut shell = command("sh", &["-euc", &line]);
            shell.current_dir(&self.work);
            run(shell)?;
        }
        Ok(())
    }

    fn examples(&self) -> Done {
        self.compile("frames.exe", &["src/*.cs", "examples/Frames.cs"], &[])?;
        run(self.command("mono", &["frames.exe"]))
    }

    /// The tests, each way; the frames beside C once, for they take the longest. `bakes` has the
    /// library that bakes what this one opens.
    fn tests(&self, bakes: &Self) -> Done {
        let include = format!("-I{}", self.prefix.join("include").display());
        let header = self.prefix.join("include/cullet.h").to_string_lossy().into_owned();
        let golden = golden::folder().to_string_lossy().into_owned();
        let words = ["-O2", "-shared", "-fPIC", &include, "-o"];
        let mut frames = self.command("gcc", &words);
        frames.arg(self.prefix.join("lib/libframes.so")).arg(self.source.join("tests/frames.c"));
        frames.arg(format!("-L{}", self.prefix.join("lib").display())).args(["-lcullet", "-lm"]);
        run(frames)?;
        for (way, flags) in WAYS {
            let program = format!("{way}.exe");
            self.compile(&program, &["src/*.cs", "tests/*.cs", "Unity/*.cs"], flags)?;
            let test = |words: &[&str]| run(self.command("mono", &[&[&*program], words].concat()));
            test(&["layouts", &header, "layouts.c"])?;
            run(self.command("gcc", &["-std=c11", "-fsyntax-only", &include, "layouts.c"]))?;
            for words in [&["answers"][..], &["mistakes"], &["unity"], &["golden", &golden]] {
                test(words)?;
            }
            let baked = self.work.join("baked");
            let _ = fs::remove_dir_all(&baked);
            fs::create_dir_all(&baked).map_err(|e| format!("{}: {e}", baked.display()))?;
            let (program, baked) = (self.work.join(&program), baked.to_string_lossy());
            run(bakes.command("mono", &[&program.to_string_lossy(), "bakes", &baked]))?;
            test(&["sets", &baked])?;
        }
        run(self.command("mono", &["spans.exe", "frames", "1"]))
    }
}
