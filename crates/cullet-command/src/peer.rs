//! Programs beside this one, which its commands start: the baker, the lab, the viewer. They are
//! apart so that building `cullet` stays quick.

use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::exit::{Exit, Failure, Outcome};

/// A program beside this one.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    /// Its name, which is its package's too, without the ending that some systems give programs.
    pub name: &'static str,
    /// Its name, for people.
    pub what: &'static str,
    /// A value of it, as an example.
    pub example: &'static str,
    /// Requirements of its build besides Rust.
    pub needs: &'static str,
    /// Whether its command lines begin with a command, as those of `cullet` do.
    pub has_commands: bool,
    /// Arguments with which cargo builds it.
    pub build: &'static [&'static str],
}

impl Peer {
    /// Where it lies: beside this program, or in PATH.
    pub fn path(&self) -> Option<PathBuf> {
        let beside = std::env::current_exe().ok();
        let folders = std::env::var_os("PATH").unwrap_or_default();
        self.find(beside.as_deref(), &folders)
    }

    /// Starts it and ends when it does.
    pub fn run(&self, args: &[OsString]) -> Outcome {
        self.run_with(args, Stdio::inherit)
    }

    fn run_with(&self, args: &[OsString], output: fn() -> Stdio) -> Outcome {
        let program = self.path().ok_or_else(|| self.missing())?;
        self.is_of_this_version(&program)?;
        self.start(&program, args, output())
    }

    /// An error where it says that it is of another version than this program, whose commands it
    /// would take for others.
    fn is_of_this_version(&self, program: &Path) -> Result<(), Failure> {
        // The rest shows windows, whatever it is asked.
        let said = self.has_commands.then(|| Command::new(program).arg("--version").output());
        let said =
            said.and_then(Result::ok).map(|out| String::from_utf8_lossy(&out.stdout).into_owned());
        let (what, own, build) = (self.what, env!("CARGO_PKG_VERSION"), self.build.join(" "));
        match said
            .as_deref()
            .and_then(|said| said.trim().strip_prefix(self.name)?.strip_prefix(' '))
        {
            Some(version) if version != own => Err(Failure::input(format!(
                "{what} {} is of version {version} and this program of {own}: build it again, by cargo build --release {build}",
                program.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Runs it like [`run`](Self::run). Where the program is missing and this one was built from
    /// its own source, by cargo, it is built beside this one first.
    pub fn run_or_build(&self, args: &[OsString], quiet: bool) -> Outcome {
        self.be_there(quiet)?;
        self.run(args)
    }

    /// Hands this program's own command line on, from a command on, and ends when that does. The
    /// program is built first where it is missing and can be.
    ///
    /// # Errors
    /// If it can be neither found nor built.
    pub fn hand_on(&self, command: &str, quiet: bool) -> Outcome {
        let args = std::env::args_os().skip(1);
        self.run_or_build(&handed_on(args, command, quiet), quiet)
    }

    /// Runs a command of it, with what follows the command's name. The program is built first where
    /// it is missing and can be.
    ///
    /// # Errors
    /// If it can be neither found nor built.
    pub fn run_command(&self, command: &str, rest: &[OsString], quiet: bool) -> Outcome {
        let mut args = Vec::new();
        if self.has_commands {
            args.extend(quiet.then(|| "--quiet".into()));
            args.push(command.into());
        }
        args.extend_from_slice(rest);
        self.run_or_build(&args, quiet)
    }

    /// Runs it like [`run_or_build`](Self::run_or_build), for a step of another command: only its
    /// errors are shown.
    pub fn work(&self, args: &[OsString], quiet: bool) -> Outcome {
        self.be_there(quiet)?;
        self.run_with(args, Stdio::null)
    }

    fn be_there(&self, quiet: bool) -> Result<(), Failure> {
        let beside = std::env::current_exe().ok();
        let folders = std::env::var_os("PATH").unwrap_or_default();
        if self.find(beside.as_deref(), &folders).is_none()
            && let Some(checkout) = beside.as_deref().and_then(Checkout::of)
        {
            self.build(&checkout, quiet)?;
        }
        Ok(())
    }

    fn build(&self, checkout: &Checkout, quiet: bool) -> Result<(), Failure> {
        let Self { name, what, needs, .. } = self;
        if !quiet {
            let _ = writeln!(
                std::io::stderr().lock(),
                "{what} '{name}' is built now, once, which takes {needs}: cargo build --profile {} {}",
                checkout.profile,
                self.build.join(" ")
            );
        }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(cargo)
            .args(["build", "--quiet", "--profile", &checkout.profile])
            .args(self.build)
            .arg("--target-dir")
            .arg(&checkout.target)
            .current_dir(&checkout.root)
            .status();
        match built {
            Ok(status) if status.success() => Ok(()),
            Ok(_) => Err(Failure::input(format!(
                "{what} '{name}' cannot be built: cargo has said why. It takes {needs} besides Rust"
            ))),
            Err(e) => {
                let missing = self.missing().message;
                Err(Failure::input(format!("cargo cannot be started: {e}. {missing}")))
            }
        }
    }

    fn start(&self, program: &Path, args: &[OsString], output: Stdio) -> Outcome {
        let ended = Command::new(program).args(args).stdout(output).status().map_err(|e| {
            let (what, program) = (self.what, program.display());
            Failure::input(format!("{program}: {what} cannot be started: {e}"))
        })?;
        // It has said why on its own.
        Ok(match ended.code() {
            Some(0) => Exit::Fine,
            Some(1) => Exit::FalseCull,
            Some(2) => Exit::Usage,
            Some(4) => Exit::Limit,
            Some(5) => Exit::FailIf,
            Some(70) => Exit::Internal,
            Some(130) | None => Exit::Interrupted,
            Some(_) => Exit::Input,
        })
    }

    fn missing(&self) -> Failure {
        let Self { name, what, example, .. } = self;
        let build = self.build.join(" ");
        Failure::input(format!(
            "{what} '{name}' is neither beside this program nor in PATH. Build it in the folder of the \
             source:\n  cargo build --release {build}\nor let cargo start it:\n  cargo run --release {build} -- {example}"
        ))
    }

    /// The one beside the program `beside`, or in one of the `folders` of a PATH.
    fn find(&self, beside: Option<&Path>, folders: &OsStr) -> Option<PathBuf> {
        let name = format!("{}{}", self.name, std::env::consts::EXE_SUFFIX);
        let own = beside.and_then(Path::parent).map(Path::to_owned);
        own.into_iter()
            .chain(std::env::split_paths(folders))
            .map(|folder| folder.join(&name))
            .find(|path| path.is_file())
    }
}

/// Where this program was built by cargo from its own source.
#[derive(Debug, PartialEq)]
struct Checkout {
    root: PathBuf,
    target: PathBuf,
    profile: String,
}

impl Checkout {
    /// The checkout of a program in `ROOT/.../TARGET/PROFILE/`, where the root holds the source of
    /// `cullet`.
    fn of(exe: &Path) -> Option<Self> {
        let folder = exe.parent()?;
        let target = folder.parent()?;
        let is_root = |path: &&Path| {
            path.join("Cargo.toml").is_file() && path.join("programs/cullet").is_dir()
        };
        let root = target.ancestors().skip(1).find(is_root)?.to_owned();
        let profile = match folder.file_name()?.to_str()? {
            // The one profile whose folder has another name.
            "debug" => "dev",
            name => name,
        };
        Some(Self { root, target: target.to_owned(), profile: profile.to_owned() })
    }
}

/// The command and what follows it; what stands before it is said by `quiet`.
fn handed_on(args: impl Iterator<Item = OsString>, command: &str, quiet: bool) -> Vec<OsString> {
    let silence = quiet.then(|| "--quiet".into());
    silence.into_iter().chain(args.skip_while(|a| a != command).filter(|a| !is_quiet(a))).collect()
}

fn is_quiet(arg: &OsString) -> bool {
    arg == "--quiet" || arg == "-q"
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEER: Peer = Peer {
        name: "cullet-peer",
        what: "the peer",
        example: "city",
        needs: "time",
        has_commands: true,
        build: &["--package", "cullet-peer"],
    };

    #[test]
    fn the_peer_beside_goes_before_that_in_the_path() {
        let root = std::env::temp_dir().join(format!("cullet-peer-{}", std::process::id()));
        let (own, other) = (root.join("own"), root.join("other"));
        let name = format!("{}{}", PEER.name, std::env::consts::EXE_SUFFIX);
        for folder in [&own, &other] {
            std::fs::create_dir_all(folder).unwrap();
        }
        let path = other.as_os_str();
        let program = own.join("cullet");
        assert_eq!(PEER.find(Some(&program), path), None);
        std::fs::write(other.join(&name), "").unwrap();
        assert_eq!(PEER.find(Some(&program), path), Some(other.join(&name)));
        std::fs::write(own.join(&name), "").unwrap();
        assert_eq!(PEER.find(Some(&program), path), Some(own.join(&name)));
        assert_eq!(PEER.find(None, OsStr::new("")), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn only_a_program_in_a_target_folder_of_its_own_source_is_built_beside() {
        let root = std::env::temp_dir().join(format!("cullet-checkout-{}", std::process::id()));
        std::fs::create_dir_all(root.join("programs/cullet")).unwrap();
        let exe = root.join("target/release/cullet");
        assert_eq!(Checkout::of(&exe), None);
        std::fs::write(root.join("Cargo.toml"), "").unwrap();
        let found = Checkout::of(&exe).unwrap();
        assert_eq!((found.root, found.target), (root.clone(), root.join("target")));
        assert_eq!(found.profile, "release");
        let debug = Checkout::of(&root.join("target/debug/cullet")).unwrap();
        assert_eq!(debug.profile, "dev");
        assert_eq!(Checkout::of(Path::new("cullet")), None);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn the_exit_code_of_a_peer_is_handed_on() {
        use Exit::*;
        for exit in [Fine, FalseCull, Usage, Input, Limit, FailIf, Internal, Interrupted] {
            let args = ["-c".into(), format!("exit {}", exit as u8).into()];
            let ended = PEER.start(Path::new("/bin/sh"), &args, Stdio::null()).unwrap();
            assert_eq!(ended, exit);
        }
    }

    #[test]
    fn a_missing_peer_is_told_with_what_to_do() {
        let told = PEER.missing();
        assert_eq!(told.exit, Exit::Input);
        assert!(told.message.contains("cargo build --release --package cullet-peer"));
    }

    #[test]
    #[cfg(unix)]
    fn a_peer_of_another_version_is_refused_and_told_what_to_do() {
        use std::os::unix::fs::PermissionsExt;
        let file = std::env::temp_dir().join(format!("cullet-old-peer-{}", std::process::id()));
        for (version, is_right) in [("0.0.1", false), (env!("CARGO_PKG_VERSION"), true)] {
            std::fs::write(&file, format!("#!/bin/sh\necho cullet-peer {version}\n")).unwrap();
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
            // A test beside this one may have been forked while the file was open: it cannot be run
            // until that has ended.
            let can_run = (0..500).any(|_| {
                std::thread::sleep(std::time::Duration::from_millis(5));
                Command::new(&file).output().is_ok()
            });
            assert!(can_run, "{} cannot be run", file.display());
            let told = PEER.is_of_this_version(&file).map_err(|told| told.message);
            assert_eq!(told.is_ok(), is_right, "{told:?}");
            assert!(
                is_right
                    || told.unwrap_err().contains("cargo build --release --package cullet-peer")
            );
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn a_peer_that_cannot_be_built_is_told_with_what_it_takes() {
        // A checkout of a workspace without it.
        let root = std::env::temp_dir().join(format!("cullet-unbuilt-{}", std::process::id()));
        std::fs::create_dir_all(&root).unwrap();
        std::fs::write(root.join("Cargo.toml"), "[workspace]\n").unwrap();
        let checkout =
            Checkout { root: root.clone(), target: root.join("target"), profile: "release".into() };
        let told = PEER.build(&checkout, true).unwrap_err();
        assert_eq!(told.exit, Exit::Input);
        assert!(told.message.contains("cannot be built") && told.message.contains("It takes time"));
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn the_command_is_handed_on_with_what_follows() {
        let args = |line: &str| -> Vec<OsString> { line.split(' ').map(OsString::from).collect() };
        let handed = |line| handed_on(args(line).into_iter(), "simplify", true);
        let handed_first = handed("-q simplify a.glb --error 0.1 -o b.ply");
        assert_eq!(handed_first, args("--quiet simplify a.glb --error 0.1 -o b.ply"));
        assert_eq!(
            handed("simplify simplify -q --error 1"),
            args("--quiet simplify simplify --error 1")
        );
    }
}
