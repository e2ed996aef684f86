//! Additions of the baker to the commands that it shares with `cullet`.
//!
//! Some options of commands that only read need what bakes: `--cells auto` finds rooms,
//! `--occluders auto` makes occluders, `--units` keeps results to be joined. Their code is in
//! `cullet-baker`, which runs all of `cullet`'s commands too, once it has [provided](provide) it.
//! `cullet` itself starts `cullet-baker` for such a command line (`Command::needs_baker` of
//! `cullet-cli`).

use std::sync::OnceLock;

use cullet_io::Model;

use crate::args::{CullArgs, SceneArgs};
use crate::console::Console;
use crate::exit::Failure;
use crate::items::{Items, ItemsResult};

/// Work that only a program with the baker does.
#[derive(Clone, Copy, Debug)]
pub struct Bakery {
    /// Gives a model the cells of `--cells`: those found in it, or those that volumes of rooms
    /// make.
    pub cells: fn(&mut Model, &SceneArgs, &Console) -> Result<(), Failure>,
    /// Gives every mesh the occluder of `--occluders`.
    pub occluders: fn(&mut Model, &CullArgs, &Console) -> Result<(), Failure>,
    /// Does a share of a work, and keeps its units.
    pub units: fn(&Items<'_>, &Console) -> ItemsResult,
}

static BAKERY: OnceLock<Bakery> = OnceLock::new();

/// Provides the baker's work to the commands of this program; once, before any runs.
pub fn provide(bakery: Bakery) {
    let _ = BAKERY.set(bakery);
}

/// The baker's work.
///
/// # Errors
/// If this program has none.
pub fn get() -> Result<&'static Bakery, Failure> {
    BAKERY.get().ok_or_else(|| {
        Failure::usage("--cells, --occluders and --unit need the baker: run the same command with cullet-baker")
    })
}

impl Items<'_> {
    /// Does the work, with a bar.
    ///
    /// # Errors
    /// If a unit cannot be written or read; or where units are kept, in a program without the
    /// baker.
    pub fn run(&self, console: &Console) -> ItemsResult {
        if self.units.are_kept() { (get()?.units)(self, console) } else { self.run_whole(console) }
    }
}
