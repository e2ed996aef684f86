//! The scenes that Bevy's users measure by, with the plugin and without it.
//!
//! | command | does |
//! |---|---|
//! | `cargo run --release --example scenes` | draws all scenes without a window, by turns with Bevy alone, with the plugin and with occlusion; prints the parts of a frame, and how many pixels differ from Bevy's |
//! | `... --example scenes rooms spots` | the same with these |
//! | `... --example scenes window city` | opens one in a window |
//! | `... --example scenes pictures FOLDER` | writes the pictures of the overlay that the book shows |
//!
//! | key in the window | does |
//! |---|---|
//! | arrows, page up, page down | walk and turn, rise and sink |
//! | O | occlusion on and off |
//! | L | lights that matter to nothing drawn: left out or kept |
//! | F3, F4 | overlay on and off; freeze what is drawn, and walk on to see it from elsewhere |

mod build;
mod city;
mod measure;
#[path = "../../tests/common/picture.rs"]
mod picture;
mod window;

use std::path::Path;
use std::process::ExitCode;

use build::SCENES;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let find = |name: &str| SCENES.iter().find(|scene| scene.name == name);
    match args[..] {
        ["window", name] if let Some(scene) = find(name) => window::open(scene),
        ["pictures", folder] => measure::pictures(Path::new(folder)),
        _ if args.iter().all(|name| find(name).is_some()) => {
            println!("{}", measure::HEAD);
            let chosen = |name| args.is_empty() || args.contains(name);
            SCENES.iter().filter(|scene| chosen(&scene.name)).for_each(measure::compare);
        }
        _ => {
            let names: Vec<&str> = SCENES.iter().map(|scene| scene.name).collect();
            eprintln!(
                "scenes [window SCENE | pictures FOLDER | SCENE...], of {}",
                names.join(", ")
            );
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
