//! Clipping: outcodes.
//!
//! ```
//! use cullet::bounds::Side;
//! use cullet::clip::ObjectRegion;
//! use cullet::{Camera, Depth, Projection, Transform, View};
//!
//! let projection =
//!     Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: f64::INFINITY };
//! let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], projection);
//! let view = View::new(&camera, Depth::Standard, [640, 480])?;
//! let region = ObjectRegion::new(&view.frustum(), &Transform::IDENTITY);
//! let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
//! assert_eq!(region.classify(&triangle(0.0)), Side::Inside);
//! assert_eq!(region.classify(&triangle(50.0)), Side::Outside);
//! # Ok::<(), cullet::view::ViewError>(())
//! ```

pub mod cut;
pub mod outcode;

pub use outcode::{ObjectRegion, Outcode, outcode_ref};
