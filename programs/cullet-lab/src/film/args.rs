//! The command line of `cullet film`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cullet_command::args::{CullArgs, SceneArgs};
use cullet_command::parse;

/// End of `cullet film --help`.
pub(crate) const HELP: &str = "\
freeze  the eye goes along a street; culling freezes, and the eye that looks flies out and sees what was
        culled, in the colours of the kinds of culling
volume  a model, and one cluster of it with the eyes from which all of it faces away, while an eye goes round
portal  the eye goes through the doors of a scene with cells: the chain of portals, and a plan of it
dolly   levels of detail while the eye moves away, looked at from near by (--lod PX)

The same command gives the same bytes. An .webp or .png is animated; anything else is a folder, which gets each
frame as a PNG, and film.webp. Films are small because their light is even and their colours are few: --colors.

Examples
  cullet film city --of freeze --out freeze.webp
  cullet film office --of portal --out portal.webp --size 640x320
  cullet film knobs --of volume --out volume.png
  cullet film armadillo.glb --of dolly --lod 1 --out dolly.webp
  cullet film city --of freeze --seconds 8 --fps 15 --colors 96 --out frames";

/// `cullet film`
#[derive(Debug, Args)]
pub struct FilmArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Subject of the film
    #[arg(long, value_enum, value_name = "SUBJECT")]
    pub(crate) of: Subject,
    /// The file to write, .webp or .png, or a folder for single frames [default: SUBJECT.webp]
    #[arg(long, value_name = "PATH", value_parser = parse::output)]
    pub(crate) out: Option<PathBuf>,
    /// Pixels of a frame
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse::size)]
    pub(crate) size: [u32; 2],
    /// Frames a second
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=60))]
    pub(crate) fps: u32,
    /// How long it is
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = parse::seconds)]
    pub(crate) seconds: f64,
    /// How many frames there are [default: --seconds times --fps]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_FRAMES), conflicts_with = "seconds")]
    pub(crate) frames: Option<u32>,
    /// How many colours there are
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=255))]
    pub(crate) colors: u32,
    /// volume: which cluster of the first mesh, from 0 [default: the widest with a volume]
    #[arg(long, value_name = "N")]
    pub(crate) cluster: Option<u32>,
    /// Seed of the places where eyes stand
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) cull: CullArgs,
}

/// Frames of a film at the most: all of them are in memory.
const MOST_FRAMES: i64 = 2_000;

impl FilmArgs {
    /// How many frames are drawn, at least one and no more than the most.
    pub(crate) fn count(&self) -> u32 {
        let count = (self.seconds * f64::from(self.fps)).round();
        self.frames.unwrap_or_else(|| count.clamp(1.0, MOST_FRAMES as f64) as u32)
    }
}

/// Subject of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Subject {
    /// Culling freezes, and the eye flies out
    Freeze,
    /// A culling volume, and an eye that goes round
    Volume,
    /// A walk through portals
    Portal,
    /// Levels of detail as the eye moves away
    Dolly,
}

impl Subject {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Freeze => "freeze",
            Self::Volume => "volume",
            Self::Portal => "portal",
            Self::Dolly => "dolly",
        }
    }
}
