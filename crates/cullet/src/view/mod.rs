//! A view: eye, orientation, projection, viewport and layers; the frustum it sees; projected sizes.

mod camera;
pub(crate) mod corners;
mod eyes;
mod frustum;
#[cfg(feature = "serde")]
mod plain;
mod project;
mod ray;
mod slices;
mod stereo;

pub use camera::{Camera, Projection};
pub use eyes::EyeBall;
pub use frustum::{Frustum, FrustumPlane};
pub use project::ScreenRect;
pub use ray::Ray;

use glam::{DMat4, DVec3, DVec4};
use thiserror::Error;

use crate::array::Each;
use crate::bounds::{Plane, ROUNDING};
use crate::digits::{Digits, Point};
use crate::matrix::Matrix;

/// The end of the clip depth range that is near.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Depth {
    /// 0 at the near plane, 1 at the far plane.
    #[default]
    Standard,
    /// 1 at the near plane, 0 at the far plane: the better use of floating point.
    Reversed,
}

/// The order in which the vertices of a front face are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum FrontFace {
    /// Counter-clockwise, as in OpenGL and glTF.
    #[default]
    CounterClockwise,
    /// Clockwise.
    Clockwise,
}

/// Faces of one-sided meshes that are culled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum CullFace {
    /// No face.
    None,
    /// Faces seen from behind.
    #[default]
    Back,
    /// Faces seen from the front, as shadow passes do.
    Front,
}

/// Why a view cannot be made, or a frustum refuses a plane.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A number is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// The matrix has no inverse, so it shows no volume.
    #[error("the view-projection matrix is singular (determinant {})", Digits::Exponent(*_0))]
    Singular(f64),
    /// The direction is zero, or `up` lies along it.
    #[error(
        "direction {} and up {} span no plane",
        Point(*direction, Digits::Plain),
        Point(*up, Digits::Plain)
    )]
    NoOrientation {
        /// The direction given.
        direction: [f64; 3],
        /// The up vector given.
        up: [f64; 3],
    },
    /// A projection with an empty or inverted range.
    #[error("{what} is {}; it must be {must}", Digits::Plain(*value))]
    Range {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The range that it must lie in.
        must: &'static str,
    },
    /// A viewport with no pixel, or too many.
    #[error("viewport {0}x{1} is not between 1x1 and 65536x65536")]
    Viewport(u32, u32),
    /// Views of two eyes that no view is around.
    #[error("the views of the two eyes {what}")]
    Stereo {
        /// The fault of the pair, after "the views of the two eyes".
        what: &'static str,
    },
    /// A perspective matrix whose near plane is at the other end of the depth range.
    #[error(
        "the matrix has {found:?} depth, not {stated:?}: its near plane is at depth {}",
        *found as u8
    )]
    Depth {
        /// The depth that was stated.
        stated: Depth,
        /// The depth of the matrix.
        found: Depth,
    },
    /// A frustum has no more room: all 32 bits are taken.
    #[error(
        "a frustum has room for {limit} planes, numbers 0 to 5 being the view's own; \
         leave out the planes that reject least"
    )]
    TooManyPlanes {
        /// The most planes there may be.
        limit: usize,
    },
    /// A plane whose normal has no direction, or that has a number which is not finite.
    #[error("{0:?} is no plane: its normal must be finite and not zero, its d finite")]
    NoPlane(Plane),
}

/// A camera as a culler needs it.
///
/// World space is right-handed; a view looks along −Z of its own space; clip depth is 0..1,
/// standard or reversed. Everything is f64, so that a world of 1e7 units stays exact enough.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "plain::ViewData", into = "plain::ViewData"))]
pub struct View {
    clip_from_world: DMat4,
    eye: DVec4,
    mirrored: bool,
    depth: Depth,
    viewport: [u32; 2],
    /// Layers seen: an instance is drawn when it shares a bit.
    pub layers: u32,
    /// The winding that this view takes for front-facing.
    pub front_face: FrontFace,
    /// Faces of one-sided meshes that this view does not draw.
    pub cull_face: CullFace,
    /// The eyes that levels of detail are chosen for, where it is not the view's own alone; of
    /// parallel lines of sight nothing. Not written with a view.
    pub eyes: Option<EyeBall>,
    /// Half the way between the eyes of a stereo view, and how far their near planes lie apart in
    /// depth.
    apart: [f64; 3],
    near_depth: f64,
}

impl View {
    /// Whether it draws the fronts of one-sided meshes: where it draws their backs alone, as some
    /// shadow passes do, their fronts hide nothing.
    #[must_use]
    pub fn draws_fronts(&self) -> bool {
        match self.cull_face {
            CullFace::None => true,
            CullFace::Back => self.front_face == FrontFace::CounterClockwise,
            CullFace::Front => self.front_face == FrontFace::Clockwise,
        }
    }

    /// The view of `camera` on a viewport of `width` × `height` pixels.
    ///
    /// # Errors
    /// If the camera's numbers make no view; the message names the number.
    pub fn new(camera: &Camera, depth: Depth, viewport: [u32; 2]) -> Result<Self, ViewError> {
        let m = camera.clip_from_world(depth)?;
        Self::from_matrix(m.to_cols_array(), depth, viewport)
    }

    /// A perspective view from `eye` to `target`, +Y up, that fills the viewport; `far` may be
    /// infinite. Depth is standard. For more say [`Camera`] and [`View::new`].
    ///
    /// # Errors
    /// If the numbers make no view; the message names the number.
    pub fn perspective(
        eye: impl Into<[f64; 3]>,
        target: impl Into<[f64; 3]>,
        fov_y_radians: f64,
        near: f64,
        far: f64,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        let [width, height] = check_viewport(viewport)?;
        let aspect = width / height;
        let projection = Projection::Perspective { fov_y_radians, aspect, near, far };
        Self::new(&Camera::look_at(eye, target, projection), Depth::Standard, viewport)
    }

    /// An orthographic view from `eye` towards `target`, +Y up, `height` units high and as wide as
    /// the viewport needs; `near` may be negative. Depth is standard.
    ///
    /// # Errors
    /// If the numbers make no view; the message names the number.
    pub fn orthographic(
        eye: impl Into<[f64; 3]>,
        target: impl Into<[f64; 3]>,
        height: f64,
        near: f64,
        far: f64,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        let [columns, rows] = check_viewport(viewport)?;
        let (x, y) = (height * 0.5 * columns / rows, height * 0.5);
        let projection =
            Projection::Orthographic { left: -x, right: x, bottom: -y, top: y, near, far };
        Self::new(&Camera::look_at(eye, target, projection), Depth::Standard, viewport)
    }

    /// The view of any invertible matrix, column-major, that takes world to clip space:
    /// perspective, orthographic, off-centre, mirrored, with a finite or infinite far plane, times
    /// any factor.
    ///
    /// A point is inside where a graphics card keeps it: −w ≤ x ≤ w, −w ≤ y ≤ w, 0 ≤ z ≤ w. A
    /// matrix is refused as singular where rounding hides the sign of its determinant: 1e17 units
    /// from the origin there is no room in f64 for a near plane at 0.1, so let matrix and scene
    /// share an origin near the eye.
    ///
    /// # Errors
    /// If a number is not finite, the matrix is singular, a perspective matrix has its near plane
    /// at the other end of the depth range than `depth` says, or the viewport is empty.
    pub fn from_matrix(
        clip_from_world: impl Into<Matrix>,
        depth: Depth,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        let Matrix(clip_from_world) = clip_from_world.into();
        if !clip_from_world.iter().all(|v| v.is_finite()) {
            return Err(ViewError::NotFinite("view-projection matrix"));
        }
        check_viewport(viewport)?;
        let m = DMat4::from_cols_array(&clip_from_world);
        let (eye, mirrored) = homogeneous_eye(&m, depth)?;
        Ok(Self {
            clip_from_world: m,
            eye,
            mirrored,
            depth,
            viewport,
            layers: u32::MAX,
            front_face: FrontFace::default(),
            cull_face: CullFace::default(),
            eyes: None,
            apart: [0.0; 3],
            near_depth: 0.0,
        })
    }

    /// Makes the view of a matrix for clip depth −1..1, as OpenGL, WebGL and three.js have it: −1
    /// at the near plane in [`Depth::Standard`], 1 in [`Depth::Reversed`]. The view holds the
    /// matrix of the same volume for depth 0..1.
    ///
    /// Such a matrix given to [`from_matrix`](Self::from_matrix) moves the near plane to about
    /// twice its distance, which no check can notice.
    ///
    /// # Errors
    /// The errors of [`from_matrix`](Self::from_matrix).
    pub fn from_gl_matrix(
        clip_from_world: impl Into<Matrix>,
        depth: Depth,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        let Matrix(mut m) = clip_from_world.into();
        for column in m.chunks_exact_mut(4) {
            column[2] = 0.5 * column[2] + 0.5 * column[3];
        }
        Self::from_matrix(m, depth, viewport)
    }

    /// Returns the view with other layers.
    #[must_use]
    pub fn with_layers(mut self, layers: u32) -> Self {
        self.layers = layers;
        self
    }

    /// World to clip space, column-major.
    #[must_use]
    pub fn clip_from_world(&self) -> [f64; 16] {
        self.clip_from_world.to_cols_array()
    }

    /// Clip space to world, column-major: the inverse of
    /// [`clip_from_world`](Self::clip_from_world), rounded.
    #[must_use]
    pub fn world_from_clip(&self) -> [f64; 16] {
        self.clip_from_world.inverse().to_cols_array()
    }

    /// The homogeneous eye: (position, 1) in perspective; (unit direction from the scene towards
    /// the viewer, 0) in orthographic. A triangle with outward plane n·x = d is front-facing iff
    /// n·eye.xyz − d·eye.w > 0, in both.
    #[must_use]
    pub fn eye(&self) -> [f64; 4] {
        self.eye.into()
    }

    /// Whether lines of sight are parallel.
    #[must_use]
    pub fn is_orthographic(&self) -> bool {
        self.eye.w == 0.0
    }

    /// Whether the projection mirrors, so that windings on the screen are opposite to those seen
    /// from the eye.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// How far the near planes of the two eyes of a stereo view lie apart in depth; 0 for one eye.
    pub(crate) fn near_depth(&self) -> f64 {
        self.near_depth
    }

    /// Returns which end of the clip depth range is near.
    #[must_use]
    pub fn depth(&self) -> Depth {
        self.depth
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn viewport(&self) -> [u32; 2] {
        self.viewport
    }

    /// The frustum in world space, from the rows of the matrix.
    #[must_use]
    pub fn frustum(&self) -> Frustum {
        Frustum::from_matrix(&self.clip_from_world, self.depth)
    }
}

fn check_viewport(viewport: [u32; 2]) -> Result<[f64; 2], ViewError> {
    if viewport.iter().any(|&v| v == 0 || v > 65536) {
        return Err(ViewError::Viewport(viewport[0], viewport[1]));
    }
    Ok(viewport.each(f64::from))
}

/// The point that the rows x, y and w of the matrix send to zero, and whether the projection
/// mirrors.
///
/// It is the generalised cross product E of the three rows, and by Cauchy–Binet det[(x, y, w) of
/// three points] = E·(n, −d) for the plane (n, d) of the three points: positive on the screen means
/// counter-clockwise, so the sign of E also tells whether the projection mirrors. E is scaled to w
/// = 1, or to a unit direction towards the viewer where the eye is at infinity. Fails where the
/// matrix is singular, or shows that its depth is not `depth`.
fn homogeneous_eye(m: &DMat4, depth: Depth) -> Result<(DVec4, bool), ViewError> {
    // Each row to about unit size: a positive factor changes neither the eye nor a sign, and
    // products of four tiny or huge numbers would leave f64.
    let row = |i: usize| m.row(i) / m.row(i).abs().max_element();
    let (x, y, z, w) = (row(0), row(1), row(2), row(3));
    // A minor, and the sum of its terms' sizes, which its rounding error is relative to.
    let minor = |i: usize, j: usize, k: usize| {
        let [a, b, c] = [x, y, w].each(|r| DVec3::new(r[i], r[j], r[k]));
        let sizes = DVec3::new(
            (b.y * c.z).abs() + (b.z * c.y).abs(),
            (b.z * c.x).abs() + (b.x * c.z).abs(),
            (b.x * c.y).abs() + (b.y * c.x).abs(),
        );
        (a.dot(b.cross(c)), a.abs().dot(sizes))
    };
    let minors = [minor(1, 2, 3), minor(0, 2, 3), minor(0, 1, 3), minor(0, 1, 2)];
    let [p, q, r, s] = minors.each(|m| m.0);
    let e = DVec4::new(p, -q, r, -s);
    // z·E is the determinant up to sign: where it is only rounding, the matrix flattens space.
    let rounding = z.abs().dot(DVec4::from(minors.each(|m| m.1))) * (ROUNDING * 0.5);
    let certain = z.dot(e).abs() > rounding;
    if !(e.is_finite() && certain) {
        return Err(ViewError::Singular(m.determinant()));
    }
    let position = e / e.w;
    if e.w != 0.0 && position.is_finite() {
        // Clip z of the eye, where w is zero: it lies beyond the near plane, which is z = 0 or z =
        // w.
        let is_standard = (z.dot(e) < 0.0) == (e.w > 0.0);
        let found = if is_standard { Depth::Standard } else { Depth::Reversed };
        if found != depth {
            return Err(ViewError::Depth { stated: depth, found });
        }
        return Ok((position, e.w < 0.0));
    }
    // Lines of sight are parallel to E; the viewer is on the side where depth is nearer.
    let nearer = match depth {
        Depth::Standard => -z.dot(e),
        Depth::Reversed => z.dot(e),
    };
    let direction = e.truncate().normalize() * nearer.signum();
    Ok((direction.extend(0.0), nearer < 0.0))
}
