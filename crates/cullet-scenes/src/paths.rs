//! Camera paths: where to look at a model from.
//!
//! A path is named by a text: `orbit` (around the model, all of it in the picture), `walk` (at eye
//! height over its ground), `fly` (a sweep over and through it), `file:PATH` (JSON, see
//! [`to_json`]), `camera:NAME` (a camera of the model, along its animation; `camera:*` for all of
//! them in turn).
//!
//! The same model, path, count, viewport and seed give the same cameras. Cameras of `walk` and
//! `fly` stand free: nothing is nearer to the eye than a quarter of its height above the ground,
//! and it is inside of nothing that is closed; where a model leaves no such place, outside of the
//! whole model.

mod file;
mod free;
mod keys;
mod orbit;
mod roam;

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use cullet::bounds::Boxes;
use cullet::math;
use cullet::view::ViewError;
use cullet::{Camera, Depth, Projection, View};
use glam::{DVec2, DVec3};
use thiserror::Error;

pub use file::to_json;

use cullet_io::Model;

/// Path of a camera.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum PathSpec {
    /// Around the model, at changing height, as near as shows all of it.
    #[default]
    Orbit,
    /// Through the model at eye height above its ground, looking where the view is long.
    Walk,
    /// In from above, down through the model, and on.
    Fly,
    /// The cameras or keys of a JSON file.
    File(PathBuf),
    /// A camera of the model by its name; `*` for every camera in turn.
    Camera(String),
}

impl FromStr for PathSpec {
    type Err = PathError;

    fn from_str(text: &str) -> Result<Self, PathError> {
        let text = text.trim();
        match text.split_once(':') {
            Some(("file", path)) if !path.is_empty() => Ok(Self::File(path.into())),
            Some(("camera", name)) if !name.is_empty() => Ok(Self::Camera(name.to_owned())),
            _ => match text {
                "orbit" => Ok(Self::Orbit),
                "walk" => Ok(Self::Walk),
                "fly" => Ok(Self::Fly),
                _ => Err(PathError::Unknown(text.to_owned())),
            },
        }
    }
}

impl fmt::Display for PathSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Orbit => f.write_str("orbit"),
            Self::Walk => f.write_str("walk"),
            Self::Fly => f.write_str("fly"),
            Self::File(path) => write!(f, "file:{}", path.display()),
            Self::Camera(name) => write!(f, "camera:{name}"),
        }
    }
}

/// The path that shows the most of a built-in scene, named as for [`build`](crate::build): a walk
/// through those that one walks in, where frustum, occlusion and back faces all have something to
/// cull; around the others.
#[must_use]
pub fn of_builtin(scene: &str) -> PathSpec {
    match scene.split(':').next().unwrap_or_default().trim() {
        "city" | "office" | "plant" | "forest" | "moving" => PathSpec::Walk,
        _ => PathSpec::Orbit,
    }
}

/// The path of a file where nobody names one: from the starts of a map, around all else. By the
/// file's ending, for it is not read yet.
#[must_use]
pub fn of_file(file: &str) -> PathSpec {
    let ending = std::path::Path::new(file).extension();
    match ending.is_some_and(|e| e.eq_ignore_ascii_case("bsp")) {
        true => PathSpec::Camera("*".into()),
        false => PathSpec::Orbit,
    }
}

/// Settings of the cameras by the caller; those left out fit the scene, or are the file's.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Overrides {
    /// Full vertical field of view in degrees, above 0 and below 180. Default 60, or the file's.
    pub fov_degrees: Option<f64>,
    /// Distance of the near plane, above 0.
    pub near: Option<f64>,
    /// Distance of the far plane; may be infinite.
    pub far: Option<f64>,
    /// Clip depth that is near.
    pub depth: Depth,
    /// Another seed gives other places of the same kind.
    pub seed: u64,
}

/// The field of view where nobody says another, in degrees.
pub const DEFAULT_FOV_DEGREES: f64 = 60.0;
/// The most cameras of one path.
pub const MAX_VIEWS: usize = 1_000_000;

/// Why there is no path.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PathError {
    /// The text names no path.
    #[error("there is no path '{0}'; paths are orbit, walk, fly, file:PATH and camera:NAME")]
    Unknown(String),
    /// Too few or too many cameras.
    #[error("{0} views; a path has 1 to {MAX_VIEWS}")]
    Count(usize),
    /// The model has no instance with finite bounds, so there is nowhere to look.
    #[error(
        "the model has no instance with finite bounds within ±1e18 to look at; give file:PATH or an eye and a target"
    )]
    Empty,
    /// The path's file cannot be read.
    #[error("{}: cannot be read: {error}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The path's file is too large.
    #[error("{}: {bytes} bytes exceed the limit of {limit}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The most that is read.
        limit: u64,
    },
    /// The path's file is no JSON, or not of the form that a path has; says where.
    #[error("{}: {error}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Defect and place.
        error: String,
    },
    /// A camera of the path's file makes no sense.
    #[error("{}: {item}: {message}", path.display())]
    Item {
        /// The file.
        path: PathBuf,
        /// Name of the camera.
        item: String,
        /// The defect.
        message: String,
    },
    /// The model has no such camera.
    #[error("the model has no camera '{name}'; {known}")]
    NoCamera {
        /// The name that was given.
        name: String,
        /// Cameras that it has, in words.
        known: String,
    },
    /// The camera is nowhere: it has no key.
    #[error("camera '{0}' has no position at any time")]
    NoKeys(String),
    /// A field of view for a camera that has none.
    #[error("camera '{0}' is not a symmetric perspective, so a field of view cannot be set")]
    NoFov(String),
    /// A camera cannot be written.
    #[error("camera {0} is off-centre, which a path's file cannot say")]
    NotWritable(usize),
    /// The numbers of a camera make no view.
    #[error("camera {index} of {path}: {error}")]
    View {
        /// Which, from 0.
        index: usize,
        /// Name of the path.
        path: String,
        /// The defect.
        error: ViewError,
    },
}

/// The views of a path: as [`cameras`], made into views on `viewport`.
///
/// # Errors
/// As [`cameras`].
pub fn views(
    model: &Model,
    path: &PathSpec,
    count: usize,
    viewport: [u32; 2],
    overrides: &Overrides,
) -> Result<Vec<View>, PathError> {
    let cameras = cameras(model, path, count, viewport, overrides)?;
    let view = |(index, c): (usize, &Camera)| {
        View::new(c, overrides.depth, viewport).map_err(|error| PathError::View {
            index,
            path: path.to_string(),
            error,
        })
    };
    cameras.iter().enumerate().map(view).collect()
}

/// The cameras of a path, with near and far as they will be used; [`range`] reads them.
///
/// `orbit`, `walk`, `fly` and moving cameras give `count`. A fixed camera of the model gives one. A
/// file that lists cameras, and `camera:*`, give at most `count` of theirs, evenly spread over the
/// list.
///
/// Unless given, near and far fit the scene: all of it is beyond near as far as it is in the
/// picture, except what is nearer to the eye than a hundred-thousandth of the scene's diagonal; all
/// is before far.
///
/// # Errors
/// If `count` is 0 or above [`MAX_VIEWS`], the model is empty, a file cannot be read, a camera does
/// not exist, or the numbers of one make no view.
pub fn cameras(
    model: &Model,
    path: &PathSpec,
    count: usize,
    viewport: [u32; 2],
    overrides: &Overrides,
) -> Result<Vec<Camera>, PathError> {
    if !(1..=MAX_VIEWS).contains(&count) {
        return Err(PathError::Count(count));
    }
    let lens = Lens::new(model, viewport, overrides);
    let cameras = match path {
        PathSpec::Orbit => orbit::orbit(model, &lens, count)?,
        PathSpec::Walk => roam::walk(model, &lens, count)?,
        PathSpec::Fly => roam::fly(model, &lens, count)?,
        PathSpec::File(file) => file::cameras(file, &lens, count)?,
        PathSpec::Camera(name) => keys::model_cameras(model, name, &lens, count)?,
    };
    for (index, camera) in cameras.iter().enumerate() {
        // Whoever makes a view of it meets no error.
        View::new(camera, overrides.depth, viewport).map_err(|error| PathError::View {
            index,
            path: path.to_string(),
            error,
        })?;
    }
    Ok(cameras)
}

/// The camera at `eye` that looks at `target`, with the field of view, near and far of a path's.
///
/// # Errors
/// If the numbers make no view; an empty model is none.
pub fn look_at(
    model: &Model,
    eye: [f64; 3],
    target: [f64; 3],
    viewport: [u32; 2],
    overrides: &Overrides,
) -> Result<Camera, PathError> {
    let lens = Lens::new(model, viewport, overrides);
    let camera = lens.look_at(eye.into(), target.into());
    let error = |error| PathError::View { index: 0, path: "--eye and --target".to_owned(), error };
    View::new(&camera, overrides.depth, viewport).map_err(error)?;
    Ok(camera)
}

/// The distances of near and far plane of a projection, for printing.
#[must_use]
pub fn range(projection: &Projection) -> [f64; 2] {
    match *projection {
        Projection::Perspective { near, far, .. }
        | Projection::OffCentre { near, far, .. }
        | Projection::Orthographic { near, far, .. } => [near, far],
    }
}

/// Inputs that all cameras of a path share: the picture's shape, the caller's settings, and the
/// scene's extent.
struct Lens {
    /// The scene's finite extent in world space; `None` if there is none.
    extent: Option<[DVec3; 2]>,
    /// Some instance is visible wherever one looks: then nothing bounds the far plane.
    endless: bool,
    aspect: f64,
    overrides: Overrides,
}

impl Lens {
    fn new(model: &Model, viewport: [u32; 2], overrides: &Overrides) -> Self {
        let scene = &model.scene;
        let origin = DVec3::from(scene.origin());
        let limit = f64::from(Boxes::LIMIT);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut endless = false;
        // The boxes made ready for culling are at hand; computing ten million again takes seconds.
        for s in 0..scene.slot_count() as usize {
            let stored = scene.boxes().get(s);
            let [a, b] = [stored.min, stored.max].map(|v| DVec3::from(v.map(f64::from)));
            if a.cmpgt(b).any() {
                continue;
            }
            if a.min_element() <= -limit || b.max_element() >= limit {
                endless = true;
                continue;
            }
            (low, high) = (low.min(a), high.max(b));
        }
        Self {
            extent: low.is_finite().then(|| [low + origin, high + origin]),
            endless,
            aspect: f64::from(viewport[0]) / f64::from(viewport[1]),
            overrides: *overrides,
        }
    }

    fn extent(&self) -> Result<[DVec3; 2], PathError> {
        self.extent.ok_or(PathError::Empty)
    }

    fn fov_radians(&self) -> f64 {
        self.overrides.fov_degrees.unwrap_or(DEFAULT_FOV_DEGREES).to_radians()
    }

    /// Half the picture's width and height at distance 1.
    fn tangents(&self, fov_y_radians: f64) -> DVec2 {
        let t = math::tan(fov_y_radians * 0.5);
        DVec2::new(t * self.aspect, t)
    }

    /// Near and far that fit the scene as seen from `eye`, less what is given.
    fn fit(&self, eye: DVec3, fov_y_radians: f64, near: Option<f64>, far: Option<f64>) -> [f64; 2] {
        let [low, high] = self.extent.unwrap_or([eye - 1.0, eye + 1.0]);
        let size = (high - low).length().max(f64::MIN_POSITIVE);
        let distance = eye.clamp(low, high).distance(eye);
        // Depth is distance times the cosine of the angle off the axis, which is largest in a
        // corner.
        let corner = 1.0 / (1.0 + self.tangents(fov_y_radians).length_squared()).sqrt();
        let mut fit_near = (0.9 * distance * corner).max(1e-5 * size);
        let reach = (eye - low).abs().max((eye - high).abs()).length();
        let mut fit_far = if self.endless { f64::INFINITY } else { reach * 1.01 };
        if let Some(near) = near.filter(|v| v.is_finite()) {
            fit_far = fit_far.max(near * 2.0);
        } else if let Some(far) = far {
            fit_near = fit_near.min(far * 0.5);
        }
        fit_far = fit_far.max(fit_near * 2.0);
        [near.unwrap_or(fit_near), far.unwrap_or(fit_far)]
    }

    /// Near and far that hold the whole scene between them, for parallel lines of sight.
    fn fit_parallel(&self, eye: DVec3, direction: DVec3) -> [f64; 2] {
        let [low, high] = self.extent.unwrap_or([eye - 1.0, eye + 1.0]);
        let along = direction.normalize_or(DVec3::NEG_Z);
        let middle = ((low + high) * 0.5 - eye).dot(along);
        let half = ((high - low) * 0.5).dot(along.abs()).max(f64::MIN_POSITIVE) * 1.01;
        [middle - half, middle + half]
    }

    /// The perspective of a camera at `eye`, as far as the caller leaves it open.
    fn perspective(&self, eye: DVec3) -> Projection {
        let fov_y_radians = self.fov_radians();
        let [near, far] = self.fit(eye, fov_y_radians, self.overrides.near, self.overrides.far);
        Projection::Perspective { fov_y_radians, aspect: self.aspect, near, far }
    }

    fn look_at(&self, eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at(eye, target, self.perspective(eye))
    }

    fn look_along(&self, eye: DVec3, direction: DVec3) -> Camera {
        // Far from zero a step of 1 would be lost.
        let step = (eye.abs().max_element() * 1e-9).max(1.0);
        self.look_at(eye, eye + direction * step)
    }
}
