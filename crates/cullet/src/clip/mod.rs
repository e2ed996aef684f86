//! Clipping: outcodes.

pub mod outcode;

pub use outcode::{ObjectRegion, Outcode, outcode_ref};
