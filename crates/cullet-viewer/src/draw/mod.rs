//! Who draws.

mod frame;

pub use frame::{DrawStats, LineVertex, Paint, Pane, Style};
