//! Culling as [wgpu] compute passes, with the answers of the engine: the same lists, byte for byte,
//! whichever device makes them.
//!
//! Devices round f32 differently: one that multiplies and adds in one step, as WGSL allows it,
//! gives another answer for one of 25 boxes that lie near a plane. So instances are tested in
//! integers. Their boxes are stored relative to a [`Grid`] for each [block](Blocks) of 256, as
//! steps that fit 16 bits, rounded outward; planes are brought to the grid by the CPU, rounded so
//! that "outside" is only said where it is true. [`visible_ref`] is the same test on the CPU, and
//! what the passes are held against.
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
//! By the same means go clusters that [face away](GridCone), what is [too small](SizeRule), and
//! clusters of other levels of detail than that which is [near enough](GridGroup): what is rounded
//! keeps more, or is finer. [`Settings`] has their switches and thresholds.
//!
//! [`Culling`] is all of it for one scene and one view at a time, in a program's own device and
//! encoder; lists are in order, and each bucket of instances that are drawn alike is one indirect
//! draw. Boxes are tested in integers. Against the [`Pyramid`] they are tested in floating point,
//! which devices round differently: there the promise is that what owns a pixel is drawn.
//!
//! [`InView`] is the list alone, for programs that draw nothing, by the device or by the CPU in its
//! place.
//!
//! Devices differ in what they can do: a [`Tier`] says it, and [`Gpu::open`] finds an adapter that
//! has one. A device that is absent, too small, full or lost is a [`GpuError`] that says what to
//! do. In a browser nobody may wait for a device: there [`Gpu::request`], [`Gpu::read_later`] and
//! [`Passes::request`] are awaited, and what goes wrong when something is uploaded comes to the
//! device's own listener (`on_uncaptured_error`).
//!
//! [`TrianglePass`] tests the triangles of single draws, by the class of their normal or by their
//! plane, and lists what is left for one indirect draw each: for what is drawn more than once a
//! frame, and for devices to which a back face is dear.
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
