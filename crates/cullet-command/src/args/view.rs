//! Options that choose the views.

use clap::Args;
use cullet_scenes::paths;

use super::scene::SceneArgs;
use crate::parse;

/// Options that choose the views.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Views")]
pub struct ViewArgs {
    /// Pixels of a view
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    pub size: [u32; 2],
    /// How many views along the path
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub views: u32,
    /// One of orbit, walk, fly, `file:PATH`, `camera:NAME`; auto is walk for the built-in scenes
    /// that one walks in (city, office, plant, forest, moving), `camera:*` (the starts of players)
    /// for a .bsp file, else orbit
    #[arg(long, default_value = AUTO)]
    pub path: String,
    /// One view, from this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "target")]
    pub eye: Option<[f64; 3]>,
    /// One view, looking at this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "eye")]
    pub target: Option<[f64; 3]>,
    /// Vertical field of view, in degrees [default: the path's own, else 60]
    #[arg(long, value_name = "DEGREES", value_parser = parse::angle)]
    pub fov: Option<f64>,
    /// Distance of the near plane [default: fits the scene]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    pub near: Option<f64>,
    /// Distance of the far plane, or inf [default: fits the scene]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    pub far: Option<f64>,
    /// Pose what moves at T seconds; A..B lets the time pass evenly over the views
    #[arg(long, value_name = "T|A..B", value_parser = parse::span, allow_hyphen_values = true)]
    pub time: Option<[f64; 2]>,
    /// Seed of the jittered samples
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads that draw; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// The path that depends on the scene.
const AUTO: &str = "auto";

impl ViewArgs {
    /// Puts the path that suits the scene where none was given.
    pub fn settle(&mut self, scene: &SceneArgs) {
        if self.path == AUTO {
            let of = if scene.builtin() { paths::of_builtin } else { paths::of_file };
            let path = of(&scene.scene);
            self.path = path.to_string();
        }
    }
}

/// The view of a picture of a whole model.
#[derive(Clone, Debug, Args)]
pub struct PictureViewArgs {
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    pub size: [u32; 2],
    /// Draw the picture from this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "target")]
    eye: Option<[f64; 3]>,
    /// Draw the picture looking at this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "eye")]
    target: Option<[f64; 3]>,
}

impl PictureViewArgs {
    /// From where to where it looks, if that was given.
    #[must_use]
    pub fn line(&self) -> Option<([f64; 3], [f64; 3])> {
        self.eye.zip(self.target)
    }
}
