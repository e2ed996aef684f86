//! Names the slowest link of a frame, and the kind of culling that relieves it.
//!
//! A frame goes from the CPU over the bus through the transform of vertices to the filling of
//! pixels, and these links work side by side: how busy one is says little. So the work of one is
//! doubled, and nothing else; by how much the frame takes longer is its *elasticity*. Near 1 it is
//! what the frame waits for, near 0 it is hidden behind others.
//!
//! After T. Akenine-Möller, E. Haines and N. Hoffman, *Real-Time Rendering*, 4th ed. 2018, §18.2.
//!
//! ```text
//!  Scene, views ─► Drawn ─┐                   ┌─► elasticities ─► limit ─┐
//!                         ├─► Times::measure ─┤                          ├─► Profile ─► text, JSON, picture
//!  a link      ─► Proof ──┘   round by round  └─► times by culler ──┐    │
//!                                                                   ├─► Relief
//!  Drawn ─► Work: samples, triangles, bytes, seconds ─► predicted ──┘
//! ```
#![forbid(unsafe_code)]

mod covered;
mod drawing;
mod drawn;
mod elasticity;
mod link;
mod measure;
mod picture;
mod pipelines;
mod profile;
mod proof;
mod relief;

pub use drawn::Drawn;
pub use elasticity::{Elasticity, NAMED, limit};
pub use link::{Link, Way};
pub use measure::{Effort, Times, Workload};
pub use picture::picture;
pub use profile::{ByLink, Profile};
pub use proof::{Amounts, Proof};
pub use relief::{Relief, Waits, Work, predicted};
