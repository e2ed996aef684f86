//! `report --cut`: the scene opened, with the frustum and what was culled inside.

use clap::Args;
use cullet::View;
use cullet_command::console::Console;
use cullet_command::exit::Failure;
use cullet_command::parse;
use cullet_cut::Keep;
use cullet_io::Model;

use super::drawing::Titled;
use crate::opening::Opening;
use crate::shape::{self, Shape};
use crate::survey::Seen;

/// How to open the scene.
#[derive(Clone, Debug, Args)]
pub(crate) struct OpenedArgs {
    /// Also show the scene cut open at this plane (NX,NY,NZ,D) or box (X0,Y0,Z0,X1,Y1,Z1), as in cullet cut; may
    /// be given several times
    #[arg(long, value_name = "PLANE|BOX", value_parser = shape::shape, allow_hyphen_values = true)]
    cut: Vec<Shape>,
    /// With --cut: which part is kept, what is inside of all planes, or the rest
    #[arg(long, value_parser = parse::choice(shape::KEPT), default_value = "inside", requires = "cut")]
    cut_keep: Keep,
}

/// A model that was cut open, once.
#[derive(Debug)]
pub(super) struct Opened {
    opening: Opening,
    words: String,
}

impl Opened {
    /// Cuts a model, with caps; `None` where it is not wanted.
    pub(super) fn new(
        args: &OpenedArgs,
        model: &Model,
        console: &Console,
    ) -> Result<Option<Self>, Failure> {
        if args.cut.is_empty() {
            return Ok(None);
        }
        let planes = shape::planes(&args.cut)?;
        let opening = Opening::new(&planes, args.cut_keep, None, model, [1280, 720], console)?;
        if opening.is_empty() {
            console.note("note: --cut leaves nothing of the scene on the side that is kept");
        }
        let texts: Vec<&str> = args.cut.iter().map(|s| s.text.as_str()).collect();
        let side = match args.cut_keep {
            Keep::Inside => "what is inside is left",
            Keep::Outside => "what is outside is left",
        };
        Ok(Some(Self { opening, words: format!("{}: {side}", texts.join(" and ")) }))
    }

    /// Draws every triangle of a view in the colour of the stage that culled it, in the opened scene.
    pub(super) fn picture(&self, model: &Model, view: &View, seen: &Seen) -> Titled {
        Titled {
            name: "opened",
            picture: self.opening.draw(model, view, &seen.result),
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
