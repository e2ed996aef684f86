//! `cullet` takes a scene and a view and decides what need not be drawn. It is conservative (nothing
//! visible is dropped), fast, and says why each thing went.
#![forbid(unsafe_code)]

mod bits;
pub mod bounds;
pub mod clip;
mod costs;
pub mod cull;
mod culler;
pub mod exact;
mod funnel;
pub mod hierarchy;
pub mod mesh;
mod scene;
mod transform;
pub mod view;
mod visible;

pub use costs::{Costs, CostsError};
pub use culler::{Backface, CullError, Culler, Explanation, Output, Step, ViewState};
pub use fearless_simd::Level;
pub use funnel::{
    Counts, FrustumWork, Funnel, FunnelRow, OcclusionTimes, OcclusionWork, Reason, Stage, Unit,
};
pub use hierarchy::{Commit, Handle};
pub use mesh::{Mesh, MeshData};
pub use scene::{
    BoundsOverride, Instance, InstanceFlags, MeshId, Scene, SceneBoundsMut, SceneError, Stray,
};
pub use transform::Transform;
pub use view::{Camera, CullFace, Depth, FrontFace, Frustum, Projection, View};
pub use visible::{DrawRange, DroppedRange, SlotRange, TriangleRange, Visible};
