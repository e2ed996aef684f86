//! Names the slowest link of a frame.
//!
//! A frame goes from the CPU over the bus through the transform of vertices to the filling of pixels, and these links work side by
//! side: how busy one is says little. So the work of one is doubled, and nothing else; by how much the frame takes longer is its
//! *elasticity*. Near 1 it is what the frame waits for, near 0 it is hidden behind others.
//!
//! After T. Akenine-Möller, E. Haines and N. Hoffman, *Real-Time Rendering*, 4th ed. 2018, §18.2.
#![forbid(unsafe_code)]

pub mod drawn;
pub mod elasticity;
pub mod link;
pub mod measure;
pub mod proof;
pub mod relief;
pub mod report;
