//! Models cut open, with a bar and Ctrl-C: for every command that shows the inside of one.

use std::ops::ControlFlow;

use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_cut::{CutModel, ModelError, ModelOptions, cut_model};
use cullet_io::Model;

/// Cuts a model.
pub fn cut(
    model: &Model,
    options: &ModelOptions<'_>,
    console: &Console,
) -> Result<CutModel, Failure> {
    let mut progress = console.progress("cutting", u64::from(model.scene.instance_count()));
    let each = || {
        progress.step();
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    cut_model(model, options, each).map_err(|e| match e {
        ModelError::Stopped => {
            let message = "interrupted; nothing was written".into();
            Failure { exit: Exit::Interrupted, message }
        }
        e => Failure::input(e),
    })
}
