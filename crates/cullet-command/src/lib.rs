//! Parts that the programs of `cullet` share: groups of arguments, and the way from them to scenes,
//! views and cullers; messages, progress bars and Ctrl-C; exit codes; stored costs; written files;
//! starting a [neighbour](peer).
//!
//! It knows no command.
//!
//! ```
//! use cullet_command::console::{count, percent};
//! use cullet_command::parse;
//!
//! assert_eq!(count(2, "view", "views"), "2 views");
//! assert_eq!(percent(1, 2), "50 %");
//! assert_eq!(parse::size("640x480"), Ok([640, 480]));
//! ```
#![forbid(unsafe_code)]

pub mod args;
pub mod bakery;
pub mod clock;
pub mod console;
pub mod exit;
pub mod files;
pub mod html;
pub mod inputs;
pub mod items;
pub mod machine;
pub mod measured_costs;
pub mod parse;
pub mod peer;
pub mod process;
pub mod program;
pub mod sets;
pub mod stored_costs;
