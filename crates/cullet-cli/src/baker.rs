//! `cullet simplify`, `cullet bake`, `cullet bench lod`: start the baker, which has a simplifier that needs a C++ compiler.

use std::ffi::OsString;

use cullet_command::exit::Outcome;

use crate::peer::Peer;

/// The program that bakes levels of detail.
pub(crate) const BAKER: Peer =
    Peer { name: "cullet-baker", what: "the baker", example: "simplify city --error 0.001" };

/// Hands the command line on as it is, once it was found right here.
pub(crate) fn run(command: &str, quiet: bool) -> Outcome {
    let args = std::env::args_os().skip(1);
    BAKER.run_or_build(&handed_on(args, command, quiet), quiet)
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
