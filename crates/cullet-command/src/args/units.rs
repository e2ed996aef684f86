//! Work in units, of which any process on any machine may do a share.

use std::path::{Path, PathBuf};

use clap::Args;

/// Options that choose the share of the work to do, and where units are kept.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "For work in units")]
pub struct UnitArgs {
    /// Do only the I-th of N shares, from 1, and keep it
    #[arg(long, value_name = "I/N", value_parser = share)]
    pub unit: Option<[u32; 2]>,
    /// Keep finished units, and go on from those that are there
    #[arg(long)]
    pub resume: bool,
    /// Folder of the units [default: the file with .units after its name]
    #[arg(long, value_name = "FOLDER")]
    pub units: Option<PathBuf>,
}

impl UnitArgs {
    /// Whether units are to be kept.
    #[must_use]
    pub fn are_kept(&self) -> bool {
        self.resume || self.unit.is_some() || self.units.is_some()
    }

    /// The share that is to be done, from 0, and how many there are.
    #[must_use]
    pub fn share(&self) -> Option<[u32; 2]> {
        self.unit.map(|[i, n]| [i - 1, n])
    }

    /// Where the units of a file lie, if they are to be kept.
    #[must_use]
    pub fn path(&self, of: &Path) -> Option<PathBuf> {
        let beside = || {
            let mut name = of.to_path_buf().into_os_string();
            name.push(".units");
            name.into()
        };
        self.are_kept().then(|| self.units.clone().unwrap_or_else(beside))
    }

    /// Returns the message for the end of a share: where it lies, and how it is joined.
    #[must_use]
    pub fn done(&self, at: &Path) -> String {
        let [i, n] = self.unit.unwrap_or([1, 1]);
        let at = at.display();
        format!(
            "share {i} of {n} is done, in {at}; once all are, join them by the same command with --resume --units {at} in the place of --unit"
        )
    }
}

fn share(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some([i.parse().ok()?, n.parse().ok()?]));
    match parts {
        Some([i, n]) if (1..=n).contains(&i) && n <= 10_000 => Ok([i, n]),
        _ => Err(format!("'{text}' is not I/N with I from 1 to N, at most 10000; try 1/4")),
    }
}
