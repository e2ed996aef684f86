//! Whole numbers at the door: one that does not fit is named with its range.

use std::fmt::Display;

use pyo3::exceptions::{PyIndexError, PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;

pub(crate) fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "that".into(), |n| n.to_string())
}

/// Returns an integer; none for one that is beyond every type here.
pub(crate) fn integer(value: &Bound<'_, PyAny>) -> PyResult<Option<i128>> {
    match value.extract() {
        Ok(number) => Ok(Some(number)),
        Err(e) if e.is_instance_of::<PyOverflowError>(value.py()) => Ok(None),
        Err(e) => Err(e),
    }
}

/// Returns the integer that a parameter is given; the error of another type names both.
pub(crate) fn named(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<i128>> {
    integer(value).map_err(|_| {
        let found = type_name(value);
        PyTypeError::new_err(format!("{name} must be an integer, not {found}"))
    })
}

/// Returns an integer from `least` to `most`.
fn within<T: TryFrom<i128> + PartialOrd + Display>(
    value: &Bound<'_, PyAny>,
    name: &str,
    [least, most]: [T; 2],
) -> PyResult<T> {
    let number = integer(value)?.and_then(|number| T::try_from(number).ok());
    number.filter(|number| (&least..=&most).contains(&number)).ok_or_else(|| {
        PyValueError::new_err(format!("{name} is {value}; it must be from {least} to {most}"))
    })
}

pub(crate) fn layers(value: &Bound<'_, PyAny>) -> PyResult<u32> {
    within(value, "layers", [0, u32::MAX])
}

/// Threads, as many as rayon can have; 0 is one for each processor.
pub(crate) fn threads(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    within(value, "threads", [0, 65_535])
}

pub(crate) fn samples(value: &Bound<'_, PyAny>) -> PyResult<u32> {
    within(value, "samples", [0, u32::MAX])
}

pub(crate) fn seed(value: &Bound<'_, PyAny>) -> PyResult<u64> {
    within(value, "seed", [0, u64::MAX])
}

pub(crate) fn rays(value: &Bound<'_, PyAny>) -> PyResult<u64> {
    within(value, "rays", [0, u64::MAX])
}

pub(crate) fn width(value: &Bound<'_, PyAny>) -> PyResult<u32> {
    within(value, "width", [0, u32::MAX])
}

pub(crate) fn units(value: &Bound<'_, PyAny>) -> PyResult<u32> {
    within(value, "units", [0, u32::MAX])
}

/// Cameras of a path.
pub(crate) fn count(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    within(value, "count", [1, cullet_scenes::paths::MAX_VIEWS])
}

/// Returns the index that `value` names among `len` cameras; below 0 it counts from the end.
pub(crate) fn camera(value: &Bound<'_, PyAny>, len: usize) -> PyResult<usize> {
    let at = named(value, "camera")?.map(|at| if at < 0 { at + len as i128 } else { at });
    let at = at.and_then(|at| usize::try_from(at).ok()).filter(|&at| at < len);
    at.ok_or_else(|| PyIndexError::new_err(format!("there is no camera {value}; there are {len}")))
}

/// Returns the number that `value` names among `len` meshes.
pub(crate) fn mesh(value: &Bound<'_, PyAny>, len: usize) -> PyResult<u32> {
    let number = named(value, "mesh")?.and_then(|number| u32::try_from(number).ok());
    number.filter(|&number| (number as usize) < len).ok_or_else(|| {
        PyIndexError::new_err(format!("there is no mesh {value}; the scene has {len}"))
    })
}
