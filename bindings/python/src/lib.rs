//! The native half of the Python package `pycullet`: plain arrays in, plain arrays out, and the interpreter free to go on
//! while the engine works.
//!
//! What talks to trimesh, pyvista and notebooks is Python, beside this in `python/pycullet`.
#![forbid(unsafe_code)]

mod arrays;
mod camera;
mod cull;
mod culler;
mod draw;
mod edit;
mod explain;
mod jobs;
mod levels;
mod occluders;
mod program;
mod pvs;
mod result;
mod scene;
mod verify;
mod whole;
mod work;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(pycullet, FileError, PyValueError, "A file is of no known kind, or broken.");
create_exception!(
    pycullet,
    StaleError,
    PyRuntimeError,
    "A result is of a scene as it was before it changed."
);

/// A value that the engine refuses, in its own words.
pub(crate) fn value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::camera::{PyCamera, PyCameras};
    #[pymodule_export]
    use super::culler::PyCuller;
    #[pymodule_export]
    use super::program::program;
    #[pymodule_export]
    use super::pvs::PyPvs;
    #[pymodule_export]
    use super::result::{PyResultOne, PyResults};
    #[pymodule_export]
    use super::scene::PyScene;
    #[pymodule_export]
    use super::work::{PyJob, PyMade, PyUnitFolder, content_hash, plan_text};
    #[pymodule_export]
    use super::{FileError, StaleError};

    #[pymodule_init]
    fn init(m: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        m.add("__version__", env!("CARGO_PKG_VERSION"))?;
        m.add("STAGES", engine::Stage::ALL.map(engine::Stage::name))?;
        m.add("BUILTIN_SCENES", cullet_scenes::list().iter().map(|s| s.name).collect::<Vec<_>>())
    }
}
