//! `report --cut`: the scene opened, with the frustum and what was culled inside.

use clap::{ArgAction, Args};
use cullet::{Scene, View};
use cullet_command::console::Console;
use cullet_command::exit::Failure;
use cullet_command::parse;
use cullet_draw::Opening;

use super::drawing::Titled;
use crate::shape::{self, Shape};
use crate::survey::Seen;

/// How to open the scene.
#[derive(Clone, Debug, Args)]
pub(crate) struct OpenedArgs {
    /// Also show the scene cut open at this plane (NX,NY,NZ,D) or box (X0,Y0,Z0,X1,Y1,Z1), as in
    /// cullet cut; may be given several times
    #[arg(long, value_name = "PLANE|BOX", value_parser = shape::shape, allow_hyphen_values = true)]
    cut: Vec<Shape>,
    /// Part that --cut keeps: the inside of all planes, or the rest
    #[arg(long, action = ArgAction::Set, value_parser = parse::choice(KEPT), default_value = "inside", requires = "cut")]
    cut_keep: bool,
}

/// Whether what is outside is kept, by the names on the command line.
const KEPT: &[(&str, bool, &str)] = &[
    ("inside", false, "What is inside of all planes"),
    ("outside", true, "What is outside of any"),
];

/// A scene that is cut open, and the words for it.
#[derive(Debug)]
pub(super) struct Opened {
    opening: Opening,
    words: String,
}

impl Opened {
    /// Opens a scene; `None` where it is not wanted, or nothing would be left.
    pub(super) fn new(
        args: &OpenedArgs,
        scene: &Scene,
        console: &Console,
    ) -> Result<Option<Self>, Failure> {
        if args.cut.is_empty() {
            return Ok(None);
        }
        let region = shape::region(&args.cut)?;
        let Some(opening) = Opening::new(scene, region, args.cut_keep, None, [1280, 720]) else {
            console.note("note: --cut leaves nothing of the scene on the side that is kept");
            return Ok(None);
        };
        let texts: Vec<&str> = args.cut.iter().map(|s| s.text.as_str()).collect();
        let side = if args.cut_keep { "outside" } else { "inside" };
        let words = format!("{}: what is {side} is left", texts.join(" and "));
        Ok(Some(Self { opening, words }))
    }

    /// Draws every triangle of a view in the colour of the stage that culled it, in the opened
    /// scene.
    pub(super) fn picture(&self, scene: &Scene, view: &View, seen: &Seen) -> Titled {
        Titled {
            name: "opened",
            picture: self.opening.draw(scene, view, &seen.result),
            caption: format!(
                "Cut open at {}. The frustum, and every triangle in the colour of what became of it; cut \
                 faces are darker.",
                self.words
            ),
            embed_px: 1280,
            wide: true,
            thumbnail: false,
        }
    }
}
