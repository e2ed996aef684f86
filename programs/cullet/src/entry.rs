//! The program `cullet` from its command line to its exit: its own commands, and those of the programs
//! beside it by name.

use std::ffi::OsString;

use crate::Command;
use crate::neighbours::{BAKER, ELSEWHERE, LAB, LAB_PICTURES, elsewhere, hand_on};
use clap::{Arg, ArgAction, ArgMatches, FromArgMatches, Subcommand};
use cullet_command::exit::{Exit, Outcome};
use cullet_command::program;

const ABOUT: &str =
    "Finds what a 3D scene draws for nothing, and proves that nothing visible was lost";

const EXAMPLES: &str = "\
Examples
  cullet report                              the built-in city: a page with pictures, figures, advice
  cullet report model.glb --out page/        the same for your own model
  cullet report models/                      every file in a folder, and a page over all of them
  cullet report model.glb --path walk --views 32 --size 1920x1080
  cullet report model.glb --eye 0,2,9 --target 0,1,0 --fov 60
                                             one view of your choice
  cullet report house.glb --cut 0,1,0,2.4    also shows it cut open, with what was culled inside
  cullet report model.glb --detail 2         also drop what stays under 2 pixels (lossy)
  cullet report model.glb --lod 1            levels of detail, off by a pixel at most (lossy)
  cullet report model.glb --baseline old/report.json --fail-if 'tightness>3'
                                             for CI: what changed, and exit code 5 if too loose
  cullet verify model.glb                    only the proof: culled and unculled images must agree
  cullet check-occlusion model.glb           each pixel of the occlusion buffer against samples
  cullet replay frame.occ                    a recorded frame of occlusion culling, played again
  cullet info model.glb                      what is in a file, and what is wrong with it
  cullet scenes                              the built-in scenes and their settings
  cullet fetch bunny --accept                bunny, teapot and armadillo, on their makers' terms
  cullet picture kinds --out kinds.png       each triangle in the colour of what dropped it
  cullet explain city --pixel 640,360        why that is drawn, and what was culled behind it
  cullet film city --of freeze               a short clip: culling freezes, and the eye flies out
  cullet cut model.glb --plane 0,0,1,0 --cap -o half.glb
                                             cut it open; the caps leave no gap
  cullet simplify model.glb --error 0.001 -o small.glb
                                             few triangles, none off by more than a 1,000th of its radius
  cullet bake model.glb -o baked.glb         levels of detail beside every mesh, with measured errors
  cullet occluders model.glb --picture o.png boxes inside of it, and polygons in its surface
  cullet cells house.glb --cells rooms.glb -o out.glb
                                             cells and portals from the volumes of its rooms
  cullet pvs map.prt -o map.cpvs             which cells of a map see each other, and what proves it
  cullet tiles city.glb -o city              3D Tiles, for worlds that are loaded piece by piece
  cullet fly city:n=1e8                      a hundred million instances, loaded on the way
  cullet profile model.glb                   which link of a frame is the slowest, and which culling helps
  cullet view model.glb                      a window: turn it, freeze it, click what is missing
  cullet serve model.glb                     the same as a page, on localhost
  cullet bench                               the batch tests against this machine's streaming rate
  cullet bench hierarchy                     walks of a million boxes against flat sweeps of them
  cullet occscn city:ground=0 -o city.bin    triangles, boxes and views, for comparing occlusion cullers
  cullet bench occlusion --scene city.bin    what hiding boxes takes on such a file
  cullet bench culler forest --path walk     what each stage of culling takes on a scene
  cullet bench pays                          whether occlusion gives back what it takes, scene by scene
  cullet lecture                             three lectures and a paper, each claim measured here
  cullet quiz frustum-1 2.5                  the exercises of the book: is that the answer?
  cullet reproduce assarsson-moller          what each trick of the paper on frustum culling gains
  cullet reproduce zhang-hoff                Table 1 and Graph 1 of the paper on normal masks
  cullet reproduce mesh-reduction --model armadillo.obj
                                             smaller and smaller, of fewer and fewer triangles
  cullet calibrate                           what a triangle costs here, for reports in milliseconds
  cullet reproduce johannsen-carter          clusters and their bounds, beside the ideal

Exit codes
  0 fine        1 something visible was culled, or a wrong claim      2 wrong command line
  3 input unreadable or invalid     4 over a limit      5 a --fail-if holds
  70 internal error                 130 interrupted, with a valid report of what was done";

/// The arguments of a command of another program, which reads them itself.
const REST: &str = "rest";

/// Runs the program on `args`, of which the first is its name, and returns how it ends. Wrong command
/// lines end the process with code 2, `--help` and `--version` with 0.
pub fn run(args: &[OsString]) -> Exit {
    // Kinds of pictures are values, which a command of another program cannot be told by.
    if let [_, command, rest @ ..] = args
        && command == "picture"
        && rest.iter().filter_map(|arg| arg.to_str()).any(|arg| LAB_PICTURES.contains(&arg))
    {
        return program::run("cullet", || LAB.run_command("picture", rest, false));
    }
    let matches = command_line().get_matches_from(args);
    program::run("cullet", || run_matched(&matches))
}

/// The whole command line: the commands of this program, and those of others by name.
fn command_line() -> clap::Command {
    let quiet = Arg::new("quiet")
        .long("quiet")
        .short('q')
        .global(true)
        .action(ArgAction::SetTrue)
        .help("Print nothing but results and errors");
    let own = clap::Command::new("cullet")
        .version(env!("CARGO_PKG_VERSION"))
        .about(ABOUT)
        .after_help(EXAMPLES)
        .arg_required_else_help(true)
        .subcommand_required(true)
        .arg(quiet);
    let others = ELSEWHERE.iter().map(|command| {
        let rest = Arg::new(REST)
            .num_args(0..)
            .trailing_var_arg(true)
            .allow_hyphen_values(true)
            .value_parser(clap::value_parser!(OsString));
        clap::Command::new(command.name)
            .about(format!("{} ({})", command.about, command.program.name))
            .disable_help_flag(true)
            .arg(rest)
    });
    Command::augment_subcommands(own).subcommands(others)
}

fn run_matched(matches: &ArgMatches) -> Outcome {
    let quiet = matches.get_flag("quiet");
    if let Some((name, found)) = matches.subcommand()
        && let Some(command) = elsewhere(name)
    {
        let rest: Vec<OsString> = found.get_many(REST).into_iter().flatten().cloned().collect();
        return hand_on(command, &rest, quiet);
    }
    let mut command = Command::from_arg_matches(matches).unwrap_or_else(|e| e.exit());
    command.settle();
    if command.needs_baker() {
        return BAKER.hand_on(command.name(), quiet);
    }
    command.run(quiet)
}
