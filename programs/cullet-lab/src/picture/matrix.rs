//! `cullet picture pvs-matrix`: which cells see each other, of what was baked, or is baked for the
//! picture.

use std::path::Path;

use cullet_bake::job::CellSource;
use cullet_bake::pvs::{Bake, PairState, Pvs, PvsSettings};
use cullet_bake::work::{RunEnd, RunOptions};
use cullet_cells::cell::CellGraph;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_command::inputs;
use cullet_draw::{PairShown, Picture, matrix_order, pvs_matrix};

use super::PictureArgs;
use cullet_baker::pvs::failure;
use cullet_cli::picture::no_cells;

/// Draws the matrix of a `.prt`, a map, a `.cpvs`, or a scene with cells.
pub(super) fn draw(args: &PictureArgs, console: &Console) -> Result<Picture, Failure> {
    let name = &args.input.scene.scene;
    let path = Path::new(name);
    let ends = |with: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(with));
    let (pvs, neighbours) = if args.input.scene.builtin() {
        of_scene(args, console)?
    } else if ends("cpvs") {
        let bytes =
            std::fs::read(path).map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
        let pvs = Pvs::from_bytes(&bytes)
            .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
        // Without the graph, who sees another is the nearest to being its neighbour.
        let seen = |a: u32| (0..pvs.cell_count()).filter(move |&b| b != a);
        let neighbours = (0..pvs.cell_count())
            .map(|a| seen(a).filter(|&b| pvs.state(a, b) != PairState::Hidden).collect())
            .collect();
        (pvs, neighbours)
    } else if ends("prt") || ends("bsp") {
        of_graph(&CellSource::open(path).map_err(failure)?.graph, args, console)?
    } else {
        of_scene(args, console)?
    };
    let order = matrix_order(&neighbours);
    let file = path.file_name().map_or(name.into(), |file| file.to_string_lossy());
    let title = format!("Which of {} cells see which: {file}", pvs.cell_count());
    let state = |a: u32, b: u32| match pvs.state(a, b) {
        // A cell is not baked against itself, and sees itself.
        _ if a == b => PairShown::Visible,
        PairState::Visible => PairShown::Visible,
        PairState::Undecided => PairShown::Undecided,
        PairState::Hidden => PairShown::Hidden,
    };
    Ok(pvs_matrix(&order, state, &title, args.input.view.size))
}

fn of_scene(args: &PictureArgs, console: &Console) -> Result<(Pvs, Vec<Vec<u32>>), Failure> {
    let model = inputs::load(&args.input.scene, console)?;
    of_graph(
        model.in_cells().graph().ok_or_else(|| no_cells(&args.input.scene.scene))?,
        args,
        console,
    )
}

/// Bakes a graph.
fn of_graph(
    graph: &CellGraph,
    args: &PictureArgs,
    console: &Console,
) -> Result<(Pvs, Vec<Vec<u32>>), Failure> {
    let neighbours =
        (0..graph.cell_count()).map(|cell| graph.neighbours_of(cell).collect()).collect();
    let threads = match args.input.view.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let mut bake = Bake::new(graph, &PvsSettings::default(), threads);
    let bar = console.share_bar();
    let end = bake.run(&RunOptions { threads, ..RunOptions::default() }, &|share| {
        bar.to(share);
        !interrupted()
    });
    bar.finish();
    match end {
        Ok(RunEnd::Whole) => Ok((bake.finish(), neighbours)),
        Ok(_) => Err(Failure {
            exit: Exit::Interrupted,
            message: "stopped before all pairs were decided; no picture is written".into(),
        }),
        // Nothing is written without a folder.
        Err(e) => Err(Failure::input(e.to_string())),
    }
}
