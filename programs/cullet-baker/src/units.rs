//! Work in units, run by a command: its share of it, with a bar, until all is done or Ctrl-C.

use std::path::{Path, PathBuf};

use cullet_bake::job::contents_of;
use cullet_bake::work::{self, OneRound, Rounds, RunEnd, RunOptions, UnitFolder};

use cullet_command::args::UnitArgs;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::Failure;
use cullet_command::items::{Items, ItemsEnd, ItemsResult};
use cullet_io::baked::hash;

/// The units of a command: where they are kept, if they are, and which share of them is done.
#[derive(Debug)]
pub struct Units<'a> {
    args: &'a UnitArgs,
    kept: Option<(PathBuf, UnitFolder)>,
}

impl<'a> Units<'a> {
    /// Opens the units of a file, in a folder that is made where it does not exist.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn open(args: &'a UnitArgs, of: &Path) -> Result<Self, Failure> {
        let Some(path) = args.path(of) else { return Ok(Self { args, kept: None }) };
        let folder = UnitFolder::new(&path).map_err(|e| Failure::write(&path, &e))?;
        Ok(Self { args, kept: Some((path, folder)) })
    }

    /// The folder in which they are kept.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.kept.as_ref().map(|(path, _)| path.as_path())
    }

    /// Runs what is left of a work, or this process's share of it. Of `options` folder and share
    /// are those of the units.
    ///
    /// # Errors
    /// If a unit cannot be written to the folder, or that cannot be read.
    pub fn run<R: Rounds>(
        &self,
        work: &mut R,
        options: &RunOptions<'_>,
        console: &Console,
    ) -> Result<RunEnd, Failure> {
        let folder = self.kept.as_ref().map(|(_, folder)| folder);
        let options = RunOptions { folder, share: self.args.share(), ..*options };
        let bar = console.share_bar();
        let end = work::run(work, &options, &|share| {
            bar.to(share);
            !interrupted()
        });
        bar.finish();
        end.map_err(|e| Failure::write(self.folder().unwrap_or(Path::new("")), &e))
    }

    /// Runs a [`OneRound`] like [`run`](Self::run), keeping each item as soon as it is made.
    ///
    /// # Errors
    /// As of [`run`](Self::run).
    pub fn run_each<R: Rounds>(&self, work: &mut R, console: &Console) -> Result<RunEnd, Failure> {
        self.run(work, &RunOptions { units: u32::MAX, ..RunOptions::default() }, console)
    }

    /// Says that a share is done, where it lies, and how it is joined.
    pub fn tell_done(&self, console: &Console) {
        console.line(self.args.done(self.folder().unwrap_or(Path::new(""))));
    }

    /// Says what goes on after Ctrl-C, where anything is kept; whether it is.
    pub fn tell_stopped(&self, console: &Console) -> bool {
        let folder = self.folder();
        if let Some(at) = folder {
            console.note(format!("interrupted; the same command goes on from {}", at.display()));
        }
        folder.is_some()
    }
}

/// Does a share of the items of a command, and keeps them, or joins what others kept.
///
/// # Errors
/// If a unit cannot be written or read.
pub fn run_items(items: &Items<'_>, console: &Console) -> ItemsResult {
    let units = Units::open(items.units, items.of)?;
    let contents: Vec<_> =
        items.files.iter().map(|file| contents_of(file).ok().flatten()).collect();
    let key = hash(format!("{:?}", (&items.options, contents)).as_bytes());
    let mut rounds = OneRound::new(key, items.costs.clone(), items.make);
    let end = units.run_each(&mut rounds, console)?;
    let end = match end {
        RunEnd::Stopped => {
            units.tell_stopped(console);
            ItemsEnd::Stopped
        }
        RunEnd::Share => {
            units.tell_done(console);
            ItemsEnd::Share
        }
        RunEnd::Whole => ItemsEnd::Whole,
    };
    Ok((end, rounds.finish()))
}
