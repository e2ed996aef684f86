//! Culling as [wgpu] compute passes, with the answers of the engine: the lists are the same, byte
//! for byte, on every device.
//!
//! Devices round f32 differently. A device that multiplies and adds in one step, as WGSL allows,
//! gives another answer for one of 25 boxes that lie near a plane. Instances are therefore tested
//! in integers. The boxes of each [block](Blocks) of 256 are stored relative to a [`Grid`], as
//! 16-bit steps that are rounded outward. The CPU converts planes to the grid, and rounds them so
//! that "outside" is reported only if it is true. [`visible_ref`] is the same test on the CPU;
//! tests compare the passes with it.
//!
//! ```text
//!  Scene ──► Blocks ──upload──► boxes                      once, then what changed
//!              │
//!  View ──► BlockPlanes ─────► blocks in use, their planes  each frame, by the CPU: 1/256 of the tests
//!              │
//!              ▼
//!            test ──► bits ──► list of those seen before ──► drawn ──► depth ──► pyramid
//!                      │                                                           │
//!                      └─────────────────────► late test ◄─────────────────────────┘
//!                                                  │
//!                                                  ▼
//!                                   bits ──► list of what is new ──► drawn
//! ```
//!
//! The same method culls clusters that [face away](GridCone), boxes that are [too small](SizeRule),
//! and clusters whose level of detail is not the one that is [near enough](GridGroup). Rounding
//! keeps more, or selects a finer level. [`Settings`] has the switches and thresholds.
//!
//! [`Culling`] does all of this for one scene and one view at a time, in your own device and
//! encoder. Lists are in order, and each bucket of instances that are drawn alike is one indirect
//! draw. Boxes are tested against the frustum in integers. They are tested against the [`Pyramid`]
//! in floating point, which devices round differently; there the promise is that an instance that
//! owns a pixel is drawn.
//!
//! [`InView`] makes only the list, on the device or on the CPU, for programs that draw nothing.
//!
//! A [`Tier`] says what a device can do, and [`Gpu::open`] finds an adapter that reaches one. If a
//! device is absent, too small, full or lost, the [`GpuError`] says what to do. A browser does not
//! allow waiting for a device: await [`Gpu::request`], [`Gpu::read_later`] and [`Passes::request`]
//! there. Errors of uploads then go to the device's own listener (`on_uncaptured_error`).
//!
//! [`TrianglePass`] tests the triangles of single draws, by the class of their normal or by their
//! plane, and lists the remaining ones for one indirect draw each. It is for geometry that is drawn
//! more than once per frame, and for devices on which back faces are expensive.
#![forbid(unsafe_code)]

mod blocks;
mod buffers;
mod checked;
mod cluster_draws;
mod clusters;
mod cones;
mod counted;
mod culling;
mod device;
mod error;
mod facing;
mod geometry;
mod grid;
mod grid_cone;
mod grid_group;
mod grid_plane;
mod ids;
mod in_view;
mod instances;
mod lanes;
mod levels;
mod lists;
mod masks;
mod occlusion;
mod off_screen;
mod passes;
mod planes;
mod pyramid;
mod read_back;
mod reference;
mod rounding;
mod sizes;
#[doc(hidden)]
pub mod testing;
mod tier;
mod triangles;
mod units;

pub use blocks::{BLOCK, Blocks};
pub use clusters::{ArgumentPass, ClusterArguments, ClusterInstances};
pub use cones::{ConeBuffers, ConePass, Cones};
pub use counted::{CountedArguments, CountedPass};
pub use culling::{Culling, Settings};
pub use device::Gpu;
pub use error::GpuError;
pub use facing::{PlaneUniform, TriangleTest, TriangleView, triangles_ref};
pub use geometry::{Draw, GpuScene, Place};
pub use grid::{Grid, GridBox};
pub use grid_cone::{ConeEye, GridCone};
pub use grid_group::{GridGroup, GroupEye};
pub use grid_plane::GridPlane;
pub use ids::{EyeUniform, IdPass, IdTarget, PLACES, culled_faces};
pub use in_view::InView;
pub use instances::{InstanceBits, InstancePass};
pub use lanes::{Bucket, Kind, Lanes};
pub use levels::{LevelBuffers, LevelChoice, LevelPass};
pub use lists::{DrawArguments, LaneBuffers, ListPass, ListSource, Listed, SlotList};
pub use masks::{TriangleBlock, Triangles};
pub use occlusion::{OcclusionPass, VisibleBits};
pub use off_screen::OffScreen;
pub use passes::Passes;
pub use planes::{BlockPlanes, InUse};
pub use pyramid::{Pyramid, PyramidPass, level_sizes, pyramid_ref};
pub use read_back::wait;
pub use reference::visible_ref;
pub use sizes::SizeRule;
pub use tier::{Lack, Tier};
pub use triangles::{MeshTriangles, TriangleList, TrianglePass};
pub use units::{DrawMode, Phase};
