//! Parts of a reader: what a format that is read elsewhere shares with those that are read here.
//!
//! [`Source`] is a file or bytes in memory, [`Beside`] the files that it names, and a [`Builder`]
//! makes the model, within the limits of [`LoadOptions`](crate::LoadOptions).

pub use crate::beside::{Beside, Missing};
pub use crate::blocks::Source;
pub use crate::builder::Builder;
pub use crate::cells::{box_planes, numbers, plane};
pub use crate::compact::Compact;
pub use crate::convex::Convex;
pub use crate::format::{Format, JsonKind, json_kind, recognise};
#[cfg(not(target_family = "wasm"))]
pub use crate::gltf::{Counts, counts};
pub use crate::gltf::{UriSource, load as load_gltf, load_tile, read_uri_in};
pub use crate::json::{FromJson, Integer, Json, Object};
pub use crate::load::{Decode, decode, load_by, load_bytes_by};
pub use crate::polygon::Triangulator;
pub use crate::text::quote;
pub use crate::weld::Welder;
pub use crate::winding::{Cut, ON, Winding};
