//! Shadow-caster culling: which instances can throw a shadow that a view sees, wherever they stand
//! themselves.
//!
//! The lit part of a view is the part R of its frustum that holds receivers and that the light
//! reaches. A caster matters only if it has a point on the way from some point of R to the light.
//! All those ways together are the convex hull of R and the light: for a directional light R swept
//! towards it without end, for a point or spot light a body with the light at its tip.
//! [`CasterRegion`] finds the planes of that hull once per light and view; then casters are culled
//! as by any frustum, sixteen at a time or by a tree. The culler does so for a
//! [`ShadowView`](crate::ShadowView).
//!
//! Sweeping the other way, each caster along the light against the planes of the frustum, drops
//! nothing that this keeps: a swept caster is outside a plane of R only where that plane leans away
//! from the light, and those planes bound the hull as well. The hull has more: the planes through
//! the light and the edges where R turns away from it. (Bittner, Mattausch, Silvennoinen & Wimmer,
//! *Shadow Caster Culling for Efficient Shadow Mapping*, 2011, go on from here with the pixels of
//! the receivers.)
//!
//! ```
//! use cullet::bounds::{Aabb, Boxes};
//! use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
//! use cullet::cull::shadow::{CasterRegion, Light};
//! use cullet::{Simd, View};
//!
//! // Ten units of floor in front of a camera, the sun straight above it.
//! let view = View::perspective([0.0, 2.0, 0.0], [0.0, 2.0, -1.0], 1.0, 0.1, 100.0, [640, 480])?;
//! let floor = Aabb::new([-5.0, 0.0, -12.0], [5.0, 0.0, -2.0]);
//! let sun = Light::Directional { direction: [0.0, -1.0, 0.0] };
//! let region = CasterRegion::new(&view.frustum(), Some(&floor), &sun);
//!
//! let casters = Boxes::from_slice(&[
//!     Aabb::new([-1.0, 30.0, -8.0], [1.0, 31.0, -6.0]), // far above the view, over the floor
//!     Aabb::new([-1.0, 30.0, 4.0], [1.0, 31.0, 6.0]),   // behind the camera
//!     Aabb::new([-1.0, -2.0, -8.0], [1.0, -1.0, -6.0]), // under the floor
//! ]);
//! let mut kept = Indices::new();
//! cull_boxes(Simd::best(), &Planes::new(region.frustum()), &casters, &mut kept);
//! assert_eq!(*kept, [0]);
//! # Ok::<(), cullet::view::ViewError>(())
//! ```

mod body;
mod light;
mod region;

pub use light::Light;
pub use region::{CasterReason, CasterRegion};
