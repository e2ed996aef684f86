//! `cullet` takes a scene and a view and decides what need not be drawn. It is conservative (nothing
//! visible is dropped), fast, and says why each thing went.
#![forbid(unsafe_code)]

pub mod bounds;
pub mod clip;
pub mod cull;
mod culler;
mod exact;
pub mod mesh;
mod scene;
mod transform;
pub mod view;
mod visible;

pub use culler::{Backface, CullError, Culler, Explanation, Output, Step, ViewState};
pub use fearless_simd::Level;
pub use mesh::{Mesh, MeshData};
pub use scene::{
    BoundsOverride, Commit, Handle, Instance, InstanceFlags, MeshId, Scene, SceneError,
};
pub use transform::Transform;
pub use view::{Camera, CullFace, Depth, FrontFace, Frustum, Projection, View};
pub use visible::{
    DrawRange, Funnel, FunnelRow, Reason, SlotRange, Stage, TriangleRange, Unit, Visible,
};
