//! The reference renderer of `cullet`: the exact visible set, the proof that culling lost nothing
//! of it, and pictures.
//!
//! ```
//! use cullet::{Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Transform, View};
//! use cullet_draw::{RenderOptions, Selection, render};
//!
//! let mut scene = Scene::new();
//! let triangle = scene.add_mesh(Mesh::new(MeshData {
//!     positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
//!     indices: vec![0, 1, 2],
//!     ..MeshData::default()
//! })?);
//! scene.add(Instance::new(triangle, Transform::IDENTITY))?;
//! let projection =
//!     Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.1, far: f64::INFINITY };
//! let camera = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], projection);
//! let view = View::new(&camera, Depth::Reversed, [96, 64])?;
//! let frame = render(&scene, &view, Selection::All, &RenderOptions::default());
//! assert_eq!(frame.visible().len(), 1);
//! assert_eq!(frame.id(48, 32).slot, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a frame is
//!
//! All numbers are f64. A vertex in clip space is the view's matrix times the transform, both in
//! f64, times the f32 vertex. Nothing is snapped, and no clipping moves an edge. A pixel has one
//! sample. A triangle covers the sample if its three homogeneous edge functions are positive there,
//! or zero on a top or left edge, and if its depth is within 0..1. An edge is evaluated in one
//! order of its vertices. Two triangles that share an edge therefore agree bit for bit, and each
//! sample on the edge belongs to exactly one of them. The nearest triangle owns the pixel. Among
//! equally near triangles, the one with the lowest slot wins, then the one with the lowest original
//! triangle number. One-sided parts are drawn from their front only, as defined by the view and the
//! transform, mirrored ones included. Blended and masked triangles hide nothing. They are tested
//! against the opaque triangles, and [`Frame::blended`] lists each of them that is somewhere not
//! behind those.
//!
//! The result does not depend on the order of drawing, on the number of threads, or on work that is
//! skipped because it is hidden or off the screen: [`render_ref`], which skips nothing, returns the
//! same frame. The reference renderer uses none of the engine's cullers.
//!
//! # The proof
//!
//! [`verify`] draws a view with and without culling and compares the owners of all pixels. It then
//! looks for dropped instances at N × N jittered samples per pixel.
//!
//! With levels of detail the picture may differ. [`verify_levels`] separates the differences that
//! the levels allow from those that they do not.
//!
//! Two other judges say whether boxes of any kind are hidden. [`sampled_boxes`] looks at samples,
//! so it can only prove that a box is visible. A [`Prover`] proves that a box is hidden, also
//! between the samples.
#![forbid(unsafe_code)]

mod bounds;
pub mod clip;
mod clipped;
mod cut;
mod frame;
mod geometry;
mod impostor;
mod levels;
mod meter;
mod occlusion;
mod parallel;
pub mod picture;
mod places;
mod prepare;
mod random;
mod reference;
mod render;
mod sample;
mod sort;
mod steps;
pub mod surface;
mod tally;
mod tile;
mod verify;

pub use clipped::{ClipPlace, render_clipped};
pub use frame::{Frame, FrameStats, PixelId, RenderOptions, Selection};
pub use impostor::{ImpostorCards, impostor_cards};
pub use impostor::{
    ImpostorJudge, ImpostorMeasure, ImpostorOptions, ImpostorPlane, capture_impostor,
    impostor_sheet, make_impostor, measure_impostor,
};
pub use levels::{LevelPixels, LevelsVerification, verify_levels};
pub use meter::{MOST_EXCESS, Measured, Meter};
pub use occlusion::proof::{Proof, ProofOptions, Prover, prove_hidden};
pub use occlusion::reference::{SampleOptions, Sampled, sampled_boxes, sampled_instances};
pub use occlusion::{OccluderError, OccluderTriangles, occluder_scene};
pub use picture::{
    Culled, FrozenView, Highlight, Opening, Outlook, Picture, Trace, before_cut, cut_away,
    depth_complexity, even, even_levels, hidden, hierarchy, kinds, kinds_of, occluders,
    occlusion_buffer, palette, shaded, top_down,
};
pub use picture::{
    DoorInView, PairShown, PortalWalk, ShownPortal, caption, cells, depth_color, matrix_order,
    portals, pvs_matrix, shown_portals, shut_doors, walk_order,
};
pub use picture::{
    beside, difference, impostor_beside, key_strip, levels as level_colors, shaded_clear,
    shaded_levels,
};
pub use random::Random;
pub use reference::render_ref;
pub use render::{in_pool, render};
pub use steps::LevelSteps;
pub use tally::{BackfaceCounts, BackfaceTest, BoundsCounts, BoundsTest};
pub use tally::{PixelCounts, facing_away, pixels_of_meshes, twins};
pub use verify::{FalseCull, Verification, VerifyOptions, verify, verify_visible};
