//! Cameras: one, or thousands as arrays.

use cullet_scenes::paths::{Overrides, PathSpec};
use engine::{Camera, Depth, Projection, View};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PySlice, PyTuple};

use crate::arrays::{matrices, matrix, row, rows_or_row, shaped};
use crate::scene::PyScene;
use crate::{value_error, whole};

/// One camera: where it stands, what it projects, how many pixels, and which layers it sees. It never changes.
#[pyclass(frozen, module = "pycullet", name = "Camera")]
#[derive(Clone)]
pub(crate) struct PyCamera {
    pub(crate) view: View,
}

/// Many cameras, for `Scene.cull` and the like. It is a sequence: ``cameras[3]`` is a `Camera`, a slice `Cameras`.
#[pyclass(frozen, module = "pycullet", name = "Cameras")]
pub(crate) struct PyCameras {
    pub(crate) views: Vec<View>,
}

/// Width and height in pixels.
fn size(value: &Bound<'_, PyAny>) -> PyResult<[u32; 2]> {
    let error = || {
        let value = value.repr().map_or_else(|_| "that".into(), |r| r.to_string());
        PyValueError::new_err(format!(
            "size is {value}; it must be (width, height) in pixels, each from 1 to 65536"
        ))
    };
    let size: [i64; 2] = value.extract().map_err(|_| error())?;
    let side =
        |v: i64| u32::try_from(v).ok().filter(|v| (1..=65_536).contains(v)).ok_or_else(error);
    Ok([side(size[0])?, side(size[1])?])
}

fn depth(name: &str) -> PyResult<Depth> {
    match name {
        "standard" => Ok(Depth::Standard),
        "reversed" => Ok(Depth::Reversed),
        _ => Err(PyValueError::new_err(format!(
            "depth is {name:?}; it must be \"standard\" (0 near, 1 far) or \"reversed\" (1 near, 0 far)"
        ))),
    }
}

/// A view that looks from a point to another. `lens` makes its projection of the shape of the picture.
fn looking(
    eye: [f64; 3],
    target: [f64; 3],
    up: Option<[f64; 3]>,
    projection: Projection,
    size: [u32; 2],
    layers: u32,
) -> PyResult<View> {
    if eye == target {
        return Err(PyValueError::new_err(format!(
            "eye and target are both {eye:?}; a camera must look somewhere"
        )));
    }
    let mut camera = Camera::look_at(eye, target, projection);
    camera.up = up.unwrap_or(camera.up);
    Ok(View::new(&camera, Depth::Reversed, size).map_err(value_error)?.with_layers(layers))
}

fn perspective(size: [u32; 2], fov_y: f64, near: f64, far: f64) -> PyResult<Projection> {
    if !(fov_y > 0.0 && fov_y < 180.0) {
        return Err(PyValueError::new_err(format!(
            "fov_y is {fov_y}; it must be above 0 and below 180 degrees"
        )));
    }
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    Ok(Projection::Perspective { fov_y_radians: fov_y.to_radians(), aspect, near, far })
}

#[pymethods]
impl PyCamera {
    /// A perspective camera.
    ///
    /// ``size`` is width and height in pixels, 1280 × 720 unless given; ``fov_y`` the full vertical angle in degrees,
    /// above 0 and below 180; ``near`` above 0; ``far`` beyond it, and infinite unless given; ``up`` is +Y unless
    /// given, or +Z where the camera looks along Y. Instances that share no bit with ``layers`` are not seen.
    ///
    /// Raises `ValueError` for numbers that are out of range or not finite, and where eye and target are one point.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, size=None, fov_y=60.0, near=0.1, far=f64::INFINITY, up=None, layers=u32::MAX))]
    #[expect(
        clippy::too_many_arguments,
        reason = "a camera has so many numbers, each with its name in Python"
    )]
    fn look_at(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        size: Option<&Bound<'_, PyAny>>,
        fov_y: f64,
        near: f64,
        far: f64,
        up: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok([1280, 720]), self::size)?;
        let up = up.map(|up| row(up, "up")).transpose()?;
        let lens = perspective(size, fov_y, near, far)?;
        let view = looking(row(eye, "eye")?, row(target, "target")?, up, lens, size, layers)?;
        Ok(Self { view })
    }

    /// A camera with parallel lines of sight, ``height`` units of the world from the lower edge to the upper one.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, height, near, far, size=None, up=None, layers=u32::MAX))]
    #[expect(
        clippy::too_many_arguments,
        reason = "a camera has so many numbers, each with its name in Python"
    )]
    fn orthographic(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        height: f64,
        near: f64,
        far: f64,
        size: Option<&Bound<'_, PyAny>>,
        up: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok([1280, 720]), self::size)?;
        let up = up.map(|up| row(up, "up")).transpose()?;
        let top = height * 0.5;
        let right = top * f64::from(size[0]) / f64::from(size[1]);
        let lens = Projection::Orthographic { left: -right, right, bottom: -top, top, near, far };
        let view = looking(row(eye, "eye")?, row(target, "target")?, up, lens, size, layers)?;
        Ok(Self { view })
    }

    /// A camera of its view-projection matrix, (4, 4): projection @ view, clip depth from 0 to 1.
    ///
    /// ``depth`` is ``standard`` where 0 is near, ``reversed`` where 1 is. A matrix of OpenGL, whose depth goes from
    /// −1 to 1, is to be turned first: ``m[2] = (m[2] + m[3]) / 2``.
    #[staticmethod]
    #[pyo3(signature = (clip_from_world, *, size, depth="standard", layers=u32::MAX))]
    fn from_matrix(
        clip_from_world: &Bound<'_, PyAny>,
        size: &Bound<'_, PyAny>,
        depth: &str,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Self> {
        let (m, depth) = (matrix(clip_from_world, "clip_from_world")?, self::depth(depth)?);
        let view = View::from_matrix(m, depth, self::size(size)?).map_err(value_error)?;
        Ok(Self { view: view.with_layers(layers) })
    }

    /// (3,): where it stands; None for parallel lines of sight.
    #[getter]
    fn eye<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let [x, y, z, _] = self.view.eye();
        (!self.view.is_orthographic()).then(|| PyArray1::from_slice(py, &[x, y, z]))
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.view.viewport().into()
    }

    /// The layers that it sees, a bit each.
    #[getter]
    fn layers(&self) -> u32 {
        self.view.layers
    }

    /// Clip depth that is near: 0 in the standard, 1 where it is reversed, as `look_at` makes it.
    #[getter]
    fn depth(&self) -> &'static str {
        match self.view.depth() {
            Depth::Standard => "standard",
            Depth::Reversed => "reversed",
        }
    }

    /// Whether lines of sight are parallel.
    #[getter]
    fn is_orthographic(&self) -> bool {
        self.view.is_orthographic()
    }

    /// (4, 4): projection @ view.
    #[getter]
    fn clip_from_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let m = self.view.clip_from_world();
        shaped(py, (0..16).map(|i| m[i % 4 * 4 + i / 4]).collect(), &[4, 4])
    }

    /// The same camera with other pixels; what it projects stays, so that another shape stretches the picture.
    fn with_size(&self, size: &Bound<'_, PyAny>) -> PyResult<Self> {
        let size = self::size(size)?;
        let view = View::from_matrix(self.view.clip_from_world(), self.view.depth(), size);
        Ok(Self { view: view.map_err(value_error)?.with_layers(self.view.layers) })
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.view == other.view
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let rebuild = py.import("pycullet._dtypes")?.getattr("rebuild_camera")?;
        let args = (self.clip_from_world(py)?, self.size(), self.depth(), self.layers());
        Ok((rebuild, args.into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        // Without the sign of a zero.
        let ([x, y, z, w], [width, height]) =
            (self.view.eye().map(|v| v + 0.0), self.view.viewport());
        match w == 0.0 {
            true => format!(
                "<pycullet.Camera orthographic from ({x:.4}, {y:.4}, {z:.4}), {width} x {height}>"
            ),
            false => format!("<pycullet.Camera at ({x:.4}, {y:.4}, {z:.4}), {width} x {height}>"),
        }
    }
}

#[pymethods]
impl PyCameras {
    /// Returns cameras like `Camera.look_at`, for ``eyes`` (n, 3) and ``targets`` (n, 3), or one
    /// target for all.
    #[staticmethod]
    #[pyo3(signature = (eyes, targets, *, size=None, fov_y=60.0, near=0.1, far=f64::INFINITY, up=None, layers=u32::MAX))]
    #[expect(
        clippy::too_many_arguments,
        reason = "a camera has so many numbers, each with its name in Python"
    )]
    fn look_at(
        eyes: &Bound<'_, PyAny>,
        targets: &Bound<'_, PyAny>,
        size: Option<&Bound<'_, PyAny>>,
        fov_y: f64,
        near: f64,
        far: f64,
        up: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok([1280, 720]), self::size)?;
        let eyes: Vec<[f64; 3]> = rows_or_row(eyes, "eyes", None)?;
        let targets = rows_or_row(targets, "targets", Some(eyes.len()))?;
        let up = up.map(|up| row(up, "up")).transpose()?;
        let lens = perspective(size, fov_y, near, far)?;
        let view = |(at, (&eye, &target)): (usize, (&[f64; 3], &[f64; 3]))| {
            looking(eye, target, up, lens, size, layers).map_err(|e| numbered(at, &e))
        };
        let views = eyes.iter().zip(&targets).enumerate().map(view).collect::<PyResult<_>>()?;
        Ok(Self { views })
    }

    /// Returns cameras like `Camera.from_matrix`, for matrices (n, 4, 4).
    #[staticmethod]
    #[pyo3(signature = (clip_from_world, *, size, depth="standard", layers=u32::MAX))]
    fn from_matrices(
        clip_from_world: &Bound<'_, PyAny>,
        size: &Bound<'_, PyAny>,
        depth: &str,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Self> {
        let (size, depth) = (self::size(size)?, self::depth(depth)?);
        let all = matrices(clip_from_world, "clip_from_world")?;
        let view = |(at, m): (usize, &[f64; 16])| match View::from_matrix(m, depth, size) {
            Ok(view) => Ok(view.with_layers(layers)),
            Err(e) => Err(numbered(at, &value_error(e))),
        };
        Ok(Self { views: all.iter().enumerate().map(view).collect::<PyResult<_>>()? })
    }

    /// Cameras around a scene (``orbit``), through it (``walk``, ``fly``), or its file's own (``camera:NAME``).
    ///
    /// +Y is up. Near and far fit the scene. Raises `ValueError` where the scene is empty.
    #[staticmethod]
    #[pyo3(signature = (scene, path="orbit", count=8, *, size=None, fov_y=None, near=None, far=None, seed=0))]
    #[expect(
        clippy::too_many_arguments,
        reason = "a path has so many numbers, each with its name in Python"
    )]
    fn along(
        scene: &PyScene,
        path: &str,
        #[pyo3(from_py_with = whole::count)] count: usize,
        size: Option<&Bound<'_, PyAny>>,
        fov_y: Option<f64>,
        near: Option<f64>,
        far: Option<f64>,
        #[pyo3(from_py_with = whole::seed)] seed: u64,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok([1280, 720]), self::size)?;
        let spec: PathSpec = path.parse().map_err(value_error)?;
        let depth = Depth::Reversed;
        let overrides = Overrides { fov_degrees: fov_y, near, far, depth, seed };
        let views = cullet_scenes::paths::views(&scene.model, &spec, count, size, &overrides);
        Ok(Self { views: views.map_err(value_error)? })
    }

    /// One camera or many, as many.
    #[staticmethod]
    fn _of(camera: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self { views: views(camera)?.0 })
    }

    fn __len__(&self) -> usize {
        self.views.len()
    }

    fn __getitem__<'py>(&self, at: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, len) = (at.py(), self.views.len());
        if let Ok(slice) = at.cast::<PySlice>() {
            let range = slice.indices(len as isize)?;
            let nth = |k| self.views[(range.start + k as isize * range.step) as usize].clone();
            let views = (0..range.slicelength).map(nth).collect();
            return Ok(Bound::new(py, Self { views })?.into_any());
        }
        if whole::integer(at).is_err() {
            return Err(PyTypeError::new_err("cameras are numbered by an integer or a slice"));
        }
        let view = self.views[whole::camera(at, len)?].clone();
        Ok(Bound::new(py, PyCamera { view })?.into_any())
    }

    /// (n, 3): where they stand; NaN for parallel lines of sight.
    #[getter]
    fn eyes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let eyes = self.views.iter().flat_map(|v| {
            let [x, y, z, w] = v.eye();
            if w == 0.0 { [f64::NAN; 3] } else { [x, y, z] }
        });
        shaped(py, eyes.collect(), &[self.views.len(), 3])
    }

    fn __repr__(&self) -> String {
        format!("<pycullet.Cameras: {}>", self.views.len())
    }
}

fn numbered(at: usize, error: &PyErr) -> PyErr {
    Python::attach(|py| PyValueError::new_err(format!("camera {at}: {}", error.value(py))))
}

/// The views of one camera or of many, and whether it is one.
pub(crate) fn views(cameras: &Bound<'_, PyAny>) -> PyResult<(Vec<View>, bool)> {
    if let Ok(one) = cameras.cast::<PyCamera>() {
        return Ok((vec![one.get().view.clone()], true));
    }
    if let Ok(many) = cameras.cast::<PyCameras>() {
        return Ok((many.get().views.clone(), false));
    }
    let found = cameras.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "camera must be a pycullet.Camera or pycullet.Cameras, not {found}; make one with pycullet.Camera.look_at(eye, target)"
    )))
}
