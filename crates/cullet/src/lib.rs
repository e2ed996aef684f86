//! A visibility engine: takes a scene and a view and decides what need not be drawn.
//!
//! The engine is conservative: exact stages drop nothing that the view sees. It is fast, and it
//! gives the reason for each culled instance.
//!
//! ```
//! use cullet::{Camera, Culler, Depth, Instance, Mesh, MeshData, Projection, Scene, Transform, View};
//! use cullet::{ViewState, Visible};
//!
//! # fn draw_indexed(mesh: u32, indices: std::ops::Range<u32>, instance: u32) { assert_eq!(indices, 0..12); }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let positions = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
//! # let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
//! let mut scene = Scene::new();
//! let mesh = scene.add_mesh(Mesh::new(MeshData { positions, indices, ..MeshData::default() })?);
//! for x in 0..1000 {
//!     scene.add(Instance::new(mesh, Transform::from_translation([x as f64 * 4.0, 0.0, -20.0])))?;
//! }
//! let (culler, mut state, mut visible) = (Culler::default(), ViewState::default(), Visible::default());
//! scene.commit(&culler);
//!
//! // Each frame:
//! let projection = Projection::Perspective { fov_y_radians: 0.9, aspect: 1.6, near: 0.1, far: 500.0 };
//! let view = View::new(&Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection), Depth::Reversed, [1280, 720])?;
//! culler.cull_one(&scene, &view, &mut state, &mut visible);
//! for draw in visible.draws(&scene)? {
//!     draw_indexed(draw.mesh, draw.indices, draw.slot);
//! }
//! # assert!(visible.instance_count > 2 && visible.instance_count < 10);
//! # Ok(())
//! # }
//! ```
//!
//! Start with [`Visible::draws`]. [`DrawList`] fills arrays for indirect draws and allocates
//! nothing. Both refuse a result that is older than the last commit of its scene. A renderer
//! without a [`Scene`] can call the modules below it, which are plain functions over slices.
//!
//! # Where to find what
//!
//! | module | holds |
//! |---|---|
//! | [`bounds`] | planes, spheres, boxes, and batches of them |
//! | [`view`] | cameras, frusta, projected sizes |
//! | [`mesh`] | checked geometry: parts, clusters, welding |
//! | [`hierarchy`] | bounding-volume hierarchies over instances and clusters |
//! | [`cull`] | one room for each kind of culling: [`frustum`](cull::frustum), [`backface`](cull::backface), [`detail`](cull::detail), [`degenerate`](cull::degenerate), [`horizon`](cull::horizon), [`occlusion`](cull::occlusion), [`shadow`](cull::shadow) |
//! | [`lod`] | levels of detail: which clusters are drawn for an eye |
//! | [`draw`] | draw lists, and the arrays that they fill |
//! | [`funnel`], [`explain`] | how much each stage took, and why it took an instance |
//! | [`candidates`] | instances that are culled by what the caller knows |
//! | [`costs`], [`prepared`] | what occluders are chosen by, and what is made of a mesh beforehand |
//! | [`scene`] | changes, versions, levels and overrides of a [`Scene`] |
//! | the root | what every frame needs: [`Scene`], [`View`], [`Culler`], [`ViewState`], [`Visible`], [`DrawList`] |
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | `candidates` | on by default; [`Culler::cull_among`] |
//! | `clusters` | on by default; [`Output::Clusters`] and [`Output::Triangles`], and with them the culling of back faces |
//! | `digits` | on by default; numbers with fractions in messages as decimal digits, and not as their bits, for a host that writes them itself |
//! | `lossy` | on by default; [`Culler::detail`] and [`Culler::lod`] |
//! | `shadows` | on by default; [`Culler::cull_shadow`] |
//! | `mint` | matrices of [`mint`](https://docs.rs/mint), and so of glam, nalgebra and cgmath, where a [`Matrix`] is expected |
//! | `std` | on by default; without it the crate needs no more than `core` and `alloc`, and takes [`Simd::best`] as what the compiler was told that the target has |
//! | `rayon` | [`Culler::cull`] takes its views, and [`Scene::prepare`] its meshes, side by side on rayon's pool; and [`jobs::Rayon`], for [`Culler::cull_one_on`] |
//! | `serde` | settings and results can be written and read; what is read is checked |
//! | `force_support_fallback` | the scalar code beside that of the machine's SIMD levels, for tests |
//!
//! Without any, the crate opens no file, reads no clock and starts no thread.
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![forbid(unsafe_code)]
#![warn(clippy::std_instead_of_core, clippy::std_instead_of_alloc, clippy::alloc_instead_of_core)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(target_endian = "big")]
compile_error!(
    "cullet needs a little-endian target: its SIMD code takes the bytes of words in that order"
);

extern crate alloc;

mod array;
mod bits;
pub mod bounds;
pub mod costs;
pub mod cull;
mod culler;
mod digits;
pub mod exact;
pub mod funnel;
pub mod hierarchy;
pub mod jobs;
pub mod lod;
#[doc(hidden)]
pub mod math;
mod matrix;
pub mod mesh;
pub mod prepared;
pub mod scene;
mod simd;
mod sort;
mod transform;
pub mod view;
mod visible;

/// Candidates: instances that may be visible, as the caller knows from elsewhere.
pub mod candidates {
    pub use crate::culler::{Candidates, Look};
}

/// Draws of what is left, one by one or in arrays for indirect draws.
pub mod draw {
    pub use crate::visible::{
        Draw, DrawCommand, DrawKey, DrawRange, DrawState, DroppedRange, InstanceNumbers, MeshPlace,
        SlotRange, TriangleRange,
    };
}

/// Explanations: why an instance is drawn or not, stage by stage.
pub mod explain {
    pub use crate::culler::{CellTest, CoverTest, Evidence, Explanation, PlaneTest, Sight, Step};
}

pub use culler::{Backface, CullError, Culler, Output, ShadowView, ViewState};
pub use funnel::{Reason, Stage};
pub use hierarchy::Handle;
pub use matrix::Matrix;
pub use mesh::{Mesh, MeshData};
pub use scene::{Instance, InstanceFlags, MeshId, Scene, SceneError};
pub use simd::Simd;
pub use transform::Transform;
pub use view::{Camera, Depth, Projection, View};
pub use visible::{DrawList, Visible};
