//! Arrays at the door: what is wrong with one is said with its name, its type or shape, and what it should be.
//!
//! What is read is copied before the interpreter is let go, so that nobody changes it meanwhile; read-only arrays,
//! slices with steps and lists of numbers will do.

use bytemuck::Pod;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyList, PyTuple};

use crate::whole::{integer, type_name};

/// A module that is imported once.
pub(crate) fn numpy<'py>(py: Python<'py>) -> PyResult<&'py Bound<'py, PyAny>> {
    static NUMPY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let module =
        NUMPY.get_or_try_init(py, || Ok::<_, PyErr>(py.import("numpy")?.into_any().unbind()))?;
    Ok(module.bind(py))
}

/// Numbers of an array, in C order, with its shape.
pub(crate) struct Numbers {
    pub(crate) values: Vec<f64>,
    /// Whether they came as float32.
    pub(crate) single: bool,
    pub(crate) shape: Vec<usize>,
}

/// The array itself, or that of a list or tuple of numbers.
fn to_array<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    of: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let wrong = || {
        let found = type_name(value);
        PyTypeError::new_err(format!("{name} must be a NumPy array of {of}, not {found}"))
    };
    let numpy = numpy(value.py())?;
    let array = if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let dtype = if of.starts_with("float") { "float64" } else { "int64" };
        numpy.call_method1("array", (value, dtype)).map_err(|e| {
            if e.is_instance_of::<PyOverflowError>(value.py()) {
                return PyValueError::new_err(format!("{name} has a number beyond {dtype}"));
            }
            PyTypeError::new_err(format!("{name} must be numbers in rows of one length: {e}"))
        })?
    } else if value.is_instance_of::<PyUntypedArray>() {
        value.clone()
    } else {
        return Err(wrong());
    };
    // Whatever steps and alignment it has, from here on it lies as plain memory does.
    let array = numpy.call_method1("require", (array, numpy.py().None(), ("C", "A")))?;
    array.cast_into::<PyUntypedArray>().map_err(|_| wrong())
}

fn copied<T: numpy::Element + Copy>(array: &Bound<'_, PyUntypedArray>) -> PyResult<Option<Vec<T>>> {
    let Ok(array) = array.cast::<PyArrayDyn<T>>() else { return Ok(None) };
    let array = array.try_readonly().map_err(|e| PyValueError::new_err(e.to_string()))?;
    let values = array.as_slice().map_err(|e| PyValueError::new_err(e.to_string()))?;
    Ok(Some(values.to_vec()))
}

/// Numbers of float32 or float64.
pub(crate) fn numbers(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers> {
    let array = to_array(value, name, "float32 or float64")?;
    let shape = array.shape().to_vec();
    if let Some(values) = copied::<f32>(&array)? {
        let values = values.into_iter().map(f64::from).collect();
        return Ok(Numbers { values, single: true, shape });
    }
    match copied::<f64>(&array)? {
        Some(values) => Ok(Numbers { values, single: false, shape }),
        None => Err(PyTypeError::new_err(format!(
            "{name} must be of float32 or float64, not {}; use {name}.astype(numpy.float64)",
            array.dtype()
        ))),
    }
}

/// A shape as arrays print it.
fn shape_text(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let comma = if lengths.len() == 1 { "," } else { "" };
    format!("({}{comma})", lengths.join(", "))
}

fn shape_error(name: &str, found: &[usize], must: &str) -> PyErr {
    let found = shape_text(found);
    PyValueError::new_err(format!("{name} has the shape {found}; it must be {must}"))
}

/// Says which number is not finite.
fn check_finite(values: &[f64], columns: usize, name: &str) -> PyResult<()> {
    let Some(at) = values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
    Err(PyValueError::new_err(format!(
        "{name} has {} in row {}, column {}; all numbers must be finite",
        values[at],
        at / columns,
        at % columns
    )))
}

/// Rows of an array of the shape (n, `N`), all finite, and whether they came as float32.
pub(crate) fn rows<const N: usize>(
    value: &Bound<'_, PyAny>,
    name: &str,
) -> PyResult<(Vec<[f64; N]>, bool)> {
    let Numbers { values, single, shape } = numbers(value, name)?;
    if shape.len() != 2 || shape[1] != N {
        return Err(shape_error(name, &shape, &format!("(n, {N})")));
    }
    check_finite(&values, N, name)?;
    Ok((values.as_chunks().0.to_vec(), single))
}

/// An array of the shape (`N`,), all finite.
pub(crate) fn row<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    let Numbers { values, shape, .. } = numbers(value, name)?;
    if shape != [N] {
        return Err(shape_error(name, &shape, &format!("({N},)")));
    }
    check_finite(&values, N, name)?;
    Ok(values.as_chunks().0[0])
}

/// Rows of an array of the shape (n, `N`), or one row, which stands for each of `count`.
pub(crate) fn rows_or_row<const N: usize>(
    value: &Bound<'_, PyAny>,
    name: &str,
    count: Option<usize>,
) -> PyResult<Vec<[f64; N]>> {
    let Numbers { values, shape, .. } = numbers(value, name)?;
    let must = count.map_or(format!("(n, {N}) or ({N},)"), |n| format!("({n}, {N}) or ({N},)"));
    let is_rows = shape.len() == 2 && shape[1] == N && count.is_none_or(|n| n == shape[0]);
    if !is_rows && shape != [N] {
        return Err(shape_error(name, &shape, &must));
    }
    check_finite(&values, N, name)?;
    let rows = values.as_chunks().0.to_vec();
    Ok(if is_rows { rows } else { rows.repeat(count.unwrap_or(1)) })
}

/// Matrices of an array of the shape (n, 4, 4), or (4, 4) for one, column-major as the engine has them.
pub(crate) fn matrices(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; 16]>> {
    let Numbers { values, shape, .. } = numbers(value, name)?;
    if !matches!(shape[..], [4, 4] | [_, 4, 4]) {
        return Err(shape_error(name, &shape, "(4, 4) or (n, 4, 4)"));
    }
    let turned = |m: &[f64; 16]| std::array::from_fn(|i| m[i % 4 * 4 + i / 4]);
    Ok(values.as_chunks().0.iter().map(turned).collect())
}

/// One matrix of the shape (4, 4), column-major.
pub(crate) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 16]> {
    match &matrices(value, name)?[..] {
        [one] => Ok(*one),
        many => Err(shape_error(name, &[many.len(), 4, 4], "(4, 4)")),
    }
}

/// Whole numbers from 0 of an array of any integer type, with its shape. `wrong` makes the error of
/// a number that is beyond `u32`.
fn whole(
    value: &Bound<'_, PyAny>,
    name: &str,
    wrong: fn(String) -> PyErr,
) -> PyResult<(Vec<u32>, Vec<usize>)> {
    let array = to_array(value, name, "integers")?;
    let shape = array.shape().to_vec();
    if array.len() == 0 {
        return Ok((Vec::new(), shape));
    }
    let kind: char = array.dtype().getattr("kind")?.extract()?;
    if kind == 'b' {
        return Err(PyTypeError::new_err(format!(
            "{name} must be of integers, not bool; use numpy.flatnonzero({name})"
        )));
    }
    if kind != 'i' && kind != 'u' {
        return Err(PyTypeError::new_err(format!(
            "{name} must be of integers, not {}; use {name}.astype(numpy.uint32)",
            array.dtype()
        )));
    }
    if let Some(values) = copied::<u32>(&array)? {
        return Ok((values, shape));
    }
    let widest = if kind == 'i' { "int64" } else { "uint64" };
    let wide = array.call_method1("astype", (widest,))?;
    let wide = wide.cast_into::<PyUntypedArray>().map_err(PyErr::from)?;
    let values: Vec<i128> = match (copied::<i64>(&wide)?, copied::<u64>(&wide)?) {
        (Some(signed), _) => signed.into_iter().map(i128::from).collect(),
        (_, unsigned) => unsigned.unwrap_or_default().into_iter().map(i128::from).collect(),
    };
    let to_u32 = |(at, &v): (usize, &i128)| {
        u32::try_from(v).map_err(|_| {
            wrong(format!("{name} has {v} at {at}; it must be from 0 to {}", u32::MAX))
        })
    };
    Ok((values.iter().enumerate().map(to_u32).collect::<PyResult<_>>()?, shape))
}

/// Ids: an integer, or an array of the shape (n,). A number that cannot be one is an `IndexError`.
pub(crate) fn ids(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<u32>> {
    if let Ok(one) = integer(value) {
        let one = one.and_then(|one| u32::try_from(one).ok()).ok_or_else(|| {
            PyIndexError::new_err(format!("{name} is {value}; it must be from 0 to {}", u32::MAX))
        })?;
        return Ok(vec![one]);
    }
    let (ids, shape) = whole(value, name, PyIndexError::new_err)?;
    if shape.len() != 1 {
        return Err(shape_error(name, &shape, "(n,)"));
    }
    Ok(ids)
}

/// Triangles of an array of the shape (n, 3), with indices below `vertices`.
pub(crate) fn faces(value: &Bound<'_, PyAny>, name: &str, vertices: usize) -> PyResult<Vec<u32>> {
    let (indices, shape) = whole(value, name, PyValueError::new_err)?;
    if shape.len() != 2 || shape[1] != 3 {
        return Err(shape_error(name, &shape, "(n, 3)"));
    }
    if let Some(at) = indices.iter().position(|&index| index as usize >= vertices) {
        return Err(PyValueError::new_err(format!(
            "{name} has {} in row {}, column {}, but there are {vertices} vertices; indices start at 0",
            indices[at],
            at / 3,
            at % 3
        )));
    }
    Ok(indices)
}

/// Rows of plain data as a structured array; `dtype` is a name in `pycullet._dtypes`.
pub(crate) fn structured<'py, T: Pod>(
    py: Python<'py>,
    rows: &[T],
    dtype: &str,
) -> PyResult<Bound<'py, PyAny>> {
    static DTYPES: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let dtypes = DTYPES.get_or_try_init(py, || {
        Ok::<_, PyErr>(py.import("pycullet._dtypes")?.into_any().unbind())
    })?;
    let bytes = PyArray1::<u8>::from_slice(py, bytemuck::cast_slice(rows));
    bytes.call_method1("view", (dtypes.bind(py).getattr(dtype)?,))
}

/// A flat list as an array of a shape.
pub(crate) fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.to_vec())
}

/// Calls `fill` with the bytes of `out`, an array of bool of this shape that can be written, or of a new one.
pub(crate) fn mask_into<'py>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
    fill: impl FnOnce(&mut [bool]),
) -> PyResult<Bound<'py, PyAny>> {
    let Some(out) = out else {
        let mut mask = vec![false; shape.iter().product()];
        fill(&mut mask);
        return Ok(shaped(py, mask, shape)?.into_any());
    };
    let array = out.cast::<PyArrayDyn<bool>>().map_err(|_| {
        let found = out.getattr("dtype").map_or_else(|_| type_name(out), |d| d.to_string());
        let shape = shape_text(shape);
        PyTypeError::new_err(format!(
            "out must be a NumPy array of bool of the shape {shape}, not {found}"
        ))
    })?;
    if array.shape() != shape {
        return Err(shape_error("out", array.shape(), &shape_text(shape)));
    }
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err(
            "out is not contiguous in C order, so it cannot be written in one go; leave it out, or give numpy.ascontiguousarray(out)",
        ));
    }
    let mut array = array.try_readwrite().map_err(|_| {
        PyValueError::new_err(
            "out is read-only; give an array that can be written, or leave it out",
        )
    })?;
    let values = array.as_slice_mut().map_err(|e| PyValueError::new_err(e.to_string()))?;
    values.fill(false);
    fill(values);
    Ok(out.clone())
}
