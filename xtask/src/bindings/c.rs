//! The C and C++ interface: installed, then compiled against and run as its users do, by each
//! compiler that is there.

mod bakes;
mod sizes;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::golden;
use crate::runner::{End, Ended, Skip};
use crate::tools::{
    Done, alone, cargo_program, command, data, install, install_words, is_ci, is_set, output, root,
    run, target,
};

/// Profile in which it is published.
pub(super) const PROFILE: &str = "library";
/// Features and profile of a library with bakes.
pub(super) const BAKE_FEATURES: &str = bakes::FEATURES;
pub(super) const BAKE_PROFILE: &str = bakes::BUILT;
const SANITISED: &[&str] = &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
/// Tests in C that need no files.
const TESTS: [&str; 5] =
    ["tests/mistakes.c", "tests/boxes.c", "tests/more.c", "tests/sets.c", "tests/allocator.c"];
const WRAPPERS: [&str; 2] = ["tests/wrapper.cpp", "tests/wrapper_queries.cpp"];
const WARNINGS: &[&str] = &["-Wall", "-Wextra", "-Werror", "-pedantic", "-g", "-O1"];
/// Words that name the program with a frame in Rust.
const BORDER: [&str; 7] =
    ["--quiet", "--profile", PROFILE, "--package", "cullet-c", "--example", "border"];
/// Libraries that a static library of Rust needs beside it.
const STATIC: &[&str] = &["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl"];
/// Programs that are not needed to build, with the Debian package of each.
const TOOLS: &[(&str, &str)] = &[
    ("cmake", "cmake"),
    ("pkg-config", "pkg-config"),
    ("valgrind", "valgrind"),
    ("clang", "clang"),
];

/// Installs into the target folder and tests what is there.
pub(crate) fn test() -> Ended {
    let needed = ["gcc", "g++"];
    if needed.iter().any(|c| output(c, &["--version"]).is_none()) {
        if !is_ci() {
            let what = "the C and C++ interface";
            return Ok(End::Skipped(Skip::new(what, install_words(&needed))));
        }
        install(&needed)?;
    }
    let missing = |(program, _): &&(&str, &str)| output(program, &["--version"]).is_none();
    let mut absent: Vec<_> = TOOLS.iter().filter(missing).collect();
    if !absent.is_empty() && is_ci() {
        let packages: Vec<&str> = absent.iter().map(|(_, package)| *package).collect();
        install(&packages)?;
        absent.retain(missing);
    }
    let mut skips: Vec<Skip> = absent
        .iter()
        .map(|(program, package)| {
            Skip::new(format!("the C interface by {program}"), install_words(&[package]))
        })
        .collect();
    let has = |program: &str| absent.iter().all(|(name, _)| *name != program);
    let host = Host::install("whole", &[])?;
    let boxes = Host::install("boxes", &[("CULLET_FEATURES", "boxes")])?;
    sizes::test(&host, &boxes, &mut skips)?;
    boxes.boxes_alone(&has)?;
    host.examples()?;
    host.programs(&has, &mut skips)?;
    host.packages(&has)?;
    bakes::test(&host, SANITISED)?;
    host.border()?;
    Ok(if skips.is_empty() { End::Passed } else { End::Partly(skips) })
}

/// Builds the library as the step installs it, before that, and the program that measures it.
pub(crate) fn build_ahead() -> Done {
    Host::install("ahead", &[("CULLET_FEATURES", "boxes")])?;
    Host::install("ahead", &[])?;
    if sizes::has_source() {
        sizes::install_least("ahead")?;
    }
    let _alone = alone("c")?;
    run(command(&cargo_program(), &[&["build"][..], &BORDER].concat()))
}

/// An install tree, and the folder of what is compiled against it.
struct Host {
    source: PathBuf,
    prefix: PathBuf,
    work: PathBuf,
}

impl Host {
    /// Installs what settings of the script ask for.
    fn install(name: &str, settings: &[(&str, &str)]) -> Result<Self, String> {
        Self::install_in(name, PROFILE, settings)
    }

    /// The same in another profile.
    fn install_in(name: &str, profile: &str, settings: &[(&str, &str)]) -> Result<Self, String> {
        // All parts and the least of them are built into one folder.
        let _alone = alone("c")?;
        let folder = target().join("host-c").join(name);
        let _ = fs::remove_dir_all(&folder);
        let host = Self {
            source: root().join("bindings/c"),
            prefix: folder.join("installed"),
            work: folder.join("work"),
        };
        fs::create_dir_all(&host.work).map_err(|e| format!("{}: {e}", host.work.display()))?;
        let script = text(&host.source.join("install.sh"));
        let mut install = command("sh", &[&script, &text(&host.prefix), profile]);
        install.env("CARGO", cargo_program()).env("CARGO_TARGET_DIR", target());
        install.envs(settings.iter().copied());
        run(install)?;
        Ok(host)
    }

    /// Tests of a build of boxes alone, and of a project of `CMake` that builds the library along with itself.
    fn boxes_alone(&self, has: &dyn Fn(&str) -> bool) -> Done {
        self.run(&self.compile("gcc", "tests/boxes.c", &["-DCOUNT_ALLOCATIONS"])?, &[])?;
        if !has("cmake") {
            return Ok(());
        }
        let from = text(&self.source.join("tests/add_subdirectory"));
        for fetch in ["OFF", "ON"] {
            let build = self.work.join(format!("cmake_{fetch}"));
            let mut configure = command("cmake", &["-S", &from, "-B", &text(&build)]);
            configure.arg(format!("-DFETCH={fetch}"));
            configure.arg(format!("-DCULLET_TARGET_DIR={}", text(&target())));
            // CMake takes a name alone for a file beside the build; it finds cargo itself then.
            let cargo = cargo_program();
            if Path::new(&cargo).is_absolute() {
                configure.arg(format!("-DCULLET_CARGO={cargo}"));
            }
            run(configure)?;
            run(command("cmake", &["--build", &text(&build)]))?;
            for program in ["boxes_shared", "boxes_static"] {
                run(command(&text(&build.join(program)), &[]))?;
            }
        }
        Ok(())
    }

    /// Compiles sources against the shared library; returns the program.
    fn compile(&self, compiler: &str, source: &str, flags: &[&str]) -> Result<PathBuf, String> {
        let name = source.rsplit('/').next().unwrap_or(source).replace('.', "_");
        let program = self.work.join(format!("{name}_{}", compiler.replace('+', "p")));
        let is_cpp = source.ends_with(".cpp");
        let standard = if is_cpp { "-std=c++17" } else { "-std=c11" };
        let mut compile = command(compiler, &[standard]);
        compile.args(WARNINGS).arg(format!("-I{}", text(&self.prefix.join("include"))));
        compile.arg(self.source.join(source)).arg("-o").arg(&program).args(flags);
        compile.arg(format!("-L{}", text(&self.prefix.join("lib"))));
        run({
            compile.args(["-lcullet", "-lpthread", "-lm"]);
            compile
        })?;
        Ok(program)
    }

    /// A command that finds the shared library, in the folder of work.
    fn command(&self, program: &str) -> Command {
        let mut command = command(program, &[]);
        command.current_dir(&self.work).env("LD_LIBRARY_PATH", self.prefix.join("lib"));
        command
    }

    fn run(&self, program: &Path, args: &[&Path]) -> Done {
        let mut command = self.command(&text(program));
        command.args(args);
        run(command)
    }

    /// Runs what a reader types first, as the README and the chapter have it; and the other
    /// examples, one against the static library.
    fn examples(&self) -> Done {
        let read = |name: &str| {
            let path = self.source.join(name);
            fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
        };
        for (name, most) in [("boxes.c", 20), ("first.c", 10)] {
            let example = read(&format!("examples/{name}"))?;
            for text in ["README.md", "../../docs/src/c.md"] {
                if !read(text)?.contains(&example) {
                    return Err(format!(
                        "bindings/c/{text} does not have examples/{name} as it is"
                    ));
                }
            }
            if example.lines().count() > most {
                return Err(format!("examples/{name} has more than {most} lines"));
            }
        }
        fs::copy(golden::folder().join("city.glb"), self.work.join("scene.glb"))
            .map_err(|e| format!("city.glb of the golden answers: {e}"))?;
        for (compiler, example) in [
            ("gcc", "examples/boxes.c"),
            ("gcc", "examples/first.c"),
            ("g++", "examples/boxes.cpp"),
            ("g++", "examples/own_objects.cpp"),
        ] {
            self.run(&self.compile(compiler, example, &[])?, &[])?;
        }
        let program = self.work.join("frames_static");
        let mut compile = command("gcc", &["-std=c11"]);
        compile.args(WARNINGS).arg(format!("-I{}", text(&self.prefix.join("include"))));
        compile.arg(self.source.join("examples/frames.c")).arg("-o").arg(&program);
        compile.arg(self.prefix.join("lib/libcullet.a")).args(STATIC);
        run(compile)?;
        self.run(&program, &[])
    }

    /// The tests, by each compiler; with sanitisers, and under valgrind.
    fn programs(&self, has: &dyn Fn(&str) -> bool, skips: &mut Vec<Skip>) -> Done {
        let golden = golden::folder();
        let castle = castle();
        if castle.is_none() {
            let what = "masked occlusion culling's interface on intel-castle";
            skips.push(Skip::new(what, "set CULLET_DATA to the folder of test data"));
            if is_set("CULLET_REQUIRE_DATA", "1") {
                return Err("intel-castle is not there, and CULLET_REQUIRE_DATA=1".into());
            }
        }
        let model: Vec<&Path> = castle.as_deref().into_iter().collect();
        let compilers = [("gcc", "g++"), ("clang", "clang++")];
        for (c, cpp) in compilers.into_iter().filter(|(c, _)| *c == "gcc" || has(c)) {
            for test in TESTS {
                let program = self.compile(c, test, &[])?;
                self.run(&program, &[])?;
                if c == "gcc" && has("valgrind") {
                    let mut valgrind = self.command("valgrind");
                    valgrind.args(["-q", "--leak-check=full", "--error-exitcode=3"]).arg(&program);
                    run(valgrind)?;
                }
            }
            self.run(&self.compile(c, "tests/golden.c", &[])?, &[&golden])?;
            for test in WRAPPERS {
                self.run(&self.compile(cpp, test, &[])?, &[])?;
            }
            self.run(&self.compile(cpp, "tests/moc.cpp", &[])?, &model)?;
        }
        for test in TESTS {
            self.run(&self.compile("gcc", test, SANITISED)?, &[])?;
        }
        self.run(&self.compile("gcc", "tests/golden.c", SANITISED)?, &[&golden])?;
        for test in WRAPPERS {
            self.run(&self.compile("g++", test, SANITISED)?, &[])?;
            // The last -std counts.
            self.run(&self.compile("g++", test, &["-std=c++20"])?, &[])?;
        }
        // Seconds, and a seed.
        let random = "tests/random/random.c";
        self.run(&self.compile("gcc", random, SANITISED)?, &["5", "1"].map(Path::new))?;
        if has("clang") {
            self.run(&self.compile("clang", random, &[])?, &["1", "2"].map(Path::new))?;
        }
        self.run(&self.compile("gcc", "tests/boxes.c", &["-DCOUNT_ALLOCATIONS"])?, &[])?;
        self.run(&self.compile("g++", "tests/moc.cpp", SANITISED)?, &[])?;
        self.run(&self.compile("gcc", "tests/border.c", &["-DALONE"])?, &[])
    }

    /// Runs the commands that a text prints after the install, with the prefix of this tree.
    fn printed(&self, text_of: &str) -> Done {
        let path = self.source.join(text_of);
        let lines = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let block = lines.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next());
        let commands = block.and_then(|b| b.split_once("\nexport ")).map(|(_, rest)| rest);
        let commands = commands.ok_or_else(|| format!("{text_of} has no commands"))?;
        let commands = commands.replace("$HOME/cullet", &text(&self.prefix));
        run({
            let mut shell = command("sh", &["-euc", &format!("export {commands}")]);
            shell.current_dir(&self.work).env_remove("LD_LIBRARY_PATH");
            shell
        })
    }

    /// `find_package` and `pkg-config`, from the install tree.
    fn packages(&self, has: &dyn Fn(&str) -> bool) -> Done {
        if has("cmake") {
            let build = self.work.join("cmake");
            let from = self.source.join("tests/find_package");
            let mut configure = command("cmake", &["-S", &text(&from), "-B", &text(&build)]);
            configure.arg(format!("-DCMAKE_PREFIX_PATH={}", text(&self.prefix)));
            run(configure)?;
            run(command("cmake", &["--build", &text(&build)]))?;
            // Found where they were linked, without LD_LIBRARY_PATH.
            for program in ["frames_shared", "frames_static", "own_objects"] {
                run(command(&text(&build.join(program)), &[]))?;
            }
        }
        if has("pkg-config") {
            let first = self.source.join("examples/boxes.c");
            fs::copy(&first, self.work.join("boxes.c"))
                .map_err(|e| format!("{}: {e}", first.display()))?;
            self.printed("README.md")?;
            self.printed("../../docs/src/c.md")?;
            let folder = text(&self.prefix.join("lib/pkgconfig"));
            let program = text(&self.work.join("frames_pkg_config"));
            let line = "exec gcc -std=c11 \"$1\" -o \"$2\" $(pkg-config --cflags --libs cullet)";
            let source = text(&self.source.join("examples/frames.c"));
            let mut compile = command("sh", &["-euc", line, "sh", &source, &program]);
            compile.env("PKG_CONFIG_PATH", folder);
            run(compile)?;
            self.run(Path::new(&program), &[])?;
        }
        Ok(())
    }

    /// A frame in C beside the same in Rust: the same count of instances, and both times.
    fn border(&self) -> Done {
        let library = self.compile("gcc", "tests/border.c", &["-shared", "-fPIC"])?;
        let mut border = command(&cargo_program(), &[&["run"][..], &BORDER].concat());
        border.arg("--").arg(library).env("LD_LIBRARY_PATH", self.prefix.join("lib"));
        run(border)
    }
}

/// The model that masked occlusion culling is known by.
fn castle() -> Option<PathBuf> {
    data().map(|data| data.join("intel-castle/intel-castle.glb")).filter(|file| file.is_file())
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
