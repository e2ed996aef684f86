//! Clipping: what is decided at a glance, by outcodes, and what must be cut: lines and polygons, at
//! planes, windows and convex regions, in object or world space and in clip space.
//!
//! | | a plane | a window | a convex region |
//! |---|---|---|---|
//! | points | [`HalfSpace::height`] | [`Window::outcode`] | [`Region::outcode`], proved: [`OutcodeRegion::outcode`] |
//! | lines | [`HalfSpace::clip_line`] | [`Window::cohen_sutherland`], [`Window::liang_barsky`] | [`Region::clip_line`] |
//! | polygons | [`Clipper::clip`], both parts: [`Clipper::split`] | by [`Window::region`] | [`Clipper::clip`], [`GuardBand::clip`] |
//!
//! On a plane is inside, everywhere. Decisions and cuts depend on the two ends of an edge alone and
//! not on the polygon they are computed for, so neighbours agree.
//!
//! A polygon with a colour, cut by a frustum in world space and by the same view's clip volume:
//!
//! ```
//! use cullet_draw::clip::{Clipper, Region, space};
//! use cullet::{Camera, Depth, Projection, View};
//!
//! let projection =
//!     Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: f64::INFINITY };
//! let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], projection);
//! let view = View::new(&camera, Depth::Standard, [640, 480])?;
//! // x, y, z, red: the last corner is behind the eye.
//! let triangle = [[-1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.5, 9.0, 1.0]];
//! let mut clipper = Clipper::new();
//! let in_world = clipper.clip(&Region::<f64, 3>::from(&view.frustum()), &triangle).to_vec();
//! let m = view.clip_from_world();
//! let projected = triangle.map(|[x, y, z, red]| {
//!     let row = |r: usize| m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r];
//!     [row(0), row(1), row(2), row(3), red]
//! });
//! let mut clipper = Clipper::new();
//! let in_clip = clipper.clip(&space::full::<f64>(Depth::Standard), &projected);
//! assert_eq!(in_world.len(), in_clip.len());
//! for (world, clip) in in_world.iter().zip(in_clip) {
//!     assert!((world[3] - clip[4]).abs() < 1e-9);
//! }
//! # Ok::<(), cullet::view::ViewError>(())
//! ```
//!
//! Outcodes of a triangle in the space of its mesh:
//!
//! ```
//! use cullet::bounds::Side;
//! use cullet_draw::clip::OutcodeRegion;
//! use cullet::{Camera, Depth, Projection, Transform, View};
//!
//! let projection =
//!     Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: f64::INFINITY };
//! let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], projection);
//! let view = View::new(&camera, Depth::Standard, [640, 480])?;
//! let region = OutcodeRegion::new(&view.frustum(), &Transform::IDENTITY);
//! let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
//! assert_eq!(region.classify(&triangle(0.0)), Side::Inside);
//! assert_eq!(region.classify(&triangle(50.0)), Side::Outside);
//! # Ok::<(), cullet::view::ViewError>(())
//! ```

pub mod line;
pub mod outcode;
pub mod polygon;
pub mod region;
pub mod space;

pub use line::Window;
pub use outcode::{Outcode, OutcodeRegion, OutcodeResult, Sorted};
pub use polygon::{Clipper, Vertex};
pub use region::{ClipError, HalfSpace, Region, Scalar};
pub use space::GuardBand;
