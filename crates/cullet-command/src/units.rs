//! Work in units, run by a command: its share of it, with a bar, until all is done or Ctrl-C.

use std::path::{Path, PathBuf};

use cullet_bake::work::{self, Rounds, RunEnd, RunOptions, UnitFolder};

use crate::args::UnitArgs;
use crate::console::{Console, interrupted};
use crate::exit::Failure;

/// The units of a command: where they are kept, if they are, and which share of them is done.
#[derive(Debug)]
pub struct Units<'a> {
    args: &'a UnitArgs,
    kept: Option<(PathBuf, UnitFolder)>,
}

impl<'a> Units<'a> {
    /// Those of a file, in a folder that is made where it is not there.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn open(args: &'a UnitArgs, of: &Path) -> Result<Self, Failure> {
        Ok(Self { args, kept: args.folder(of)? })
    }

    /// The folder in which they are kept.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.kept.as_ref().map(|(path, _)| path.as_path())
    }

    /// Runs what is left of a work, or this process's share of it. Of `options` folder and share are those of the units.
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

    /// As [`run`](Self::run) of a [`OneRound`](work::OneRound), each of whose items is kept as soon as it is made.
    ///
    /// # Errors
    /// As of [`run`](Self::run).
    pub fn run_each<R: Rounds>(&self, work: &mut R, console: &Console) -> Result<RunEnd, Failure> {
        self.run(work, &RunOptions { units: u32::MAX, ..RunOptions::default() }, console)
    }

    /// Reads what all items of a [`OneRound`](work::OneRound) made, whoever made it; `None` where not all are done.
    ///
    /// # Errors
    /// If one cannot be read, which no checksum tells.
    pub fn read<T>(
        &self,
        made: Option<Vec<Vec<u8>>>,
        read: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Option<Vec<T>>, Failure> {
        let Some(made) = made else { return Ok(None) };
        let all: Option<Vec<T>> = made.iter().map(|bytes| read(bytes)).collect();
        let at = self.folder().unwrap_or(Path::new("")).display();
        let damaged = || Failure::input(format!("{at}: units of another cullet; delete it"));
        all.map(Some).ok_or_else(damaged)
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
