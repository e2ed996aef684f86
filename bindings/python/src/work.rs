//! Long bakes as units that other processes run: what `pycullet.distributed` stands on.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use cullet_bake::job::Job;
use cullet_bake::job::Made;
use cullet_bake::job::Plan;
use cullet_bake::job::Product;
use cullet_bake::job::WorkError;
use cullet_bake::job::content_of;
use cullet_bake::work::UnitFolder;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::jobs::interruptible;
use crate::{FileError, value_error, whole};

/// First item of a unit, and the one after its last.
type Items = (u32, u32);

/// Error of the kind that the interpreter has for it.
fn raise(error: &WorkError) -> PyErr {
    let text = error.to_string();
    match error {
        WorkError::Load(load) => match &load.kind {
            cullet_io::ErrorKind::Io(e) if e.kind() == std::io::ErrorKind::NotFound => {
                PyFileNotFoundError::new_err(text)
            }
            cullet_io::ErrorKind::Io(_) => PyOSError::new_err(text),
            _ => FileError::new_err(text),
        },
        WorkError::OtherContent { .. } | WorkError::OtherWork { .. } => FileError::new_err(text),
        WorkError::Gone => PyRuntimeError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// Plans a bake; the settings are JSON, as a plan has them. Loads the scene, to know what is baked of it.
#[pyfunction]
pub(crate) fn plan_text(py: Python<'_>, scene: &str, settings: &str) -> PyResult<String> {
    let settings = serde_json::from_str(settings).map_err(value_error)?;
    let plan = interruptible(py, |_| Plan::new(scene, &settings))?;
    plan.map(|plan| plan.to_text()).map_err(|e| raise(&e))
}

/// Hash of what a file contains; of a built-in scene none.
#[pyfunction]
pub(crate) fn content_hash(py: Python<'_>, scene: &str) -> PyResult<Option<u64>> {
    py.detach(|| content_of(scene)).map_err(|e| raise(&e.into()))
}

/// A folder of finished units, as `cullet pvs --units` has it.
#[pyclass(frozen, module = "pycullet", name = "UnitFolder")]
pub(crate) struct PyUnitFolder {
    folder: UnitFolder,
    path: PathBuf,
}

impl PyUnitFolder {
    fn fail(&self, error: &std::io::Error) -> PyErr {
        let at = self.path.display();
        PyOSError::new_err(format!(
            "{at}: a unit cannot be kept: {error}; what was finished is there"
        ))
    }
}

#[pymethods]
impl PyUnitFolder {
    /// A folder, which is made where it is not there.
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let folder = UnitFolder::new(&path).map_err(|e| {
            PyOSError::new_err(format!("{}: cannot be made a folder: {e}", path.display()))
        })?;
        Ok(Self { folder, path })
    }

    /// Items of the units of a round that lie there, whole or not.
    fn units(&self, key: u64, round: u32) -> PyResult<Vec<Items>> {
        let units = self.folder.units(key, round).map_err(|e| self.fail(&e))?;
        Ok(units.into_iter().map(|r| (r.start, r.end)).collect())
    }

    /// The bytes of a unit, or None.
    fn read<'py>(
        &self,
        py: Python<'py>,
        key: u64,
        round: u32,
        items: Items,
    ) -> Option<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.folder.read(key, round, &(items.0..items.1)));
        bytes.map(|bytes| PyBytes::new(py, &bytes))
    }

    /// Keeps a unit: all of it or nothing.
    fn write(
        &self,
        py: Python<'_>,
        key: u64,
        round: u32,
        items: Items,
        bytes: &[u8],
    ) -> PyResult<()> {
        let written = py.detach(|| self.folder.write(key, round, &(items.0..items.1), bytes));
        written.map_err(|e| self.fail(&e))
    }
}

/// Result of a job.
#[pyclass(frozen, module = "pycullet", name = "Made")]
pub(crate) struct PyMade(Made);

#[pymethods]
impl PyMade {
    /// The sets, as `cullet pvs -o` writes them.
    #[getter]
    fn sets<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.0.sets)
    }

    /// The map with the sets in it, where a map was baked.
    #[getter]
    fn map<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        self.0.map.as_deref().map(|bytes| PyBytes::new(py, bytes))
    }

    #[getter]
    fn cells(&self) -> u32 {
        self.0.cells
    }

    #[getter]
    fn targets(&self) -> u32 {
        self.0.targets
    }

    #[getter]
    fn visible_pairs(&self) -> u64 {
        self.0.visible_pairs
    }

    fn __repr__(&self) -> String {
        let Made { cells, targets, visible_pairs, .. } = &self.0;
        format!("<pycullet.Made: {cells} cells, {targets} targets, {visible_pairs} pairs are seen>")
    }
}

/// A planned bake that is held open while its units are run here and elsewhere.
#[pyclass(frozen, module = "pycullet", name = "Job")]
pub(crate) struct PyJob(Mutex<Option<Job>>);

impl PyJob {
    fn with<R: Send>(
        &self,
        py: Python<'_>,
        ask: impl FnOnce(&mut Job) -> Result<R, WorkError> + Send,
    ) -> PyResult<R> {
        py.detach(|| self.lock().as_mut().map(ask))
            .ok_or_else(|| PyValueError::new_err("the job is finished"))?
            .map_err(|e| raise(&e))
    }

    fn lock(&self) -> MutexGuard<'_, Option<Job>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyJob {
    /// Opens a plan with its scene at a place of this machine.
    #[new]
    #[pyo3(signature = (plan, scene, threads=1))]
    fn new(
        py: Python<'_>,
        plan: &str,
        scene: &str,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<Self> {
        let job = interruptible(py, |_| Job::open(&Plan::parse(plan)?, scene, threads))?;
        Ok(Self(Mutex::new(Some(job.map_err(|e| raise(&e))?))))
    }

    /// ``cells`` or ``view-cells``.
    #[getter]
    fn product(&self, py: Python<'_>) -> PyResult<&'static str> {
        self.with(py, |job| {
            Ok(match job.product() {
                Product::Cells => "cells",
                Product::ViewCells => "view-cells",
            })
        })
    }

    #[getter]
    fn key(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |job| Ok(job.key()))
    }

    #[getter]
    fn round(&self, py: Python<'_>) -> PyResult<u32> {
        self.with(py, |job| Ok(job.round()))
    }

    #[getter]
    fn is_done(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |job| Ok(job.is_done()))
    }

    /// The share of the work that is over before the round that is next, and once that has ended.
    #[getter]
    fn shares(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.with(py, |job| Ok(job.shares().into()))
    }

    /// The units that the round lacks beside those that there are, so many at the most, the largest first.
    fn missing(
        &self,
        py: Python<'_>,
        have: Vec<Items>,
        #[pyo3(from_py_with = whole::units)] units: u32,
    ) -> PyResult<Vec<Items>> {
        let missing = self.with(py, |job| Ok(job.missing(&ranges(&have), units)))?;
        Ok(missing.into_iter().map(|r| (r.start, r.end)).collect())
    }

    /// Returns the units that lie end to end, of those that there are.
    fn tiles(&self, py: Python<'_>, have: Vec<Items>) -> PyResult<Vec<Items>> {
        let tiles = self.with(py, |job| Ok(job.tiles(&ranges(&have))))?;
        Ok(tiles.into_iter().map(|r| (r.start, r.end)).collect())
    }

    /// Whether bytes are a whole unit of these items of the round that is next.
    fn is_whole(&self, py: Python<'_>, items: Items, bytes: &[u8]) -> PyResult<bool> {
        let bytes = bytes.to_vec();
        self.with(py, |job| job.is_whole(items.0..items.1, bytes))
    }

    /// Runs a unit of the round that is next. Ctrl-C ends it.
    #[pyo3(signature = (items, threads=1))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        items: Items,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let finished = || PyValueError::new_err("the job is finished");
        let found = interruptible(py, |stop| {
            self.lock().as_ref().map(|job| job.run(items.0..items.1, threads, stop))
        });
        let bytes = found?.ok_or_else(finished)?.map_err(|e| raise(&e))?;
        // Where it is stopped the interpreter has raised what stopped it.
        Ok(PyBytes::new(py, &bytes.unwrap_or_default()))
    }

    /// Ends the round with its units: ``[(items, bytes), ...]`` in any order.
    fn merge(&self, py: Python<'_>, units: Vec<(Items, Vec<u8>)>) -> PyResult<()> {
        let units = units.into_iter().map(|((start, end), bytes)| (start..end, bytes)).collect();
        self.with(py, |job| job.merge(units))
    }

    /// Ends the job.
    fn finish(&self, py: Python<'_>) -> PyResult<PyMade> {
        self.with(py, |job| match job.is_done() {
            true => Ok(()),
            false => Err(WorkError::Unfinished { round: job.round() }),
        })?;
        let made = py.detach(|| self.lock().take().map(Job::finish));
        let made = made.ok_or_else(|| PyValueError::new_err("the job is finished"))?;
        made.map(PyMade).map_err(|e| raise(&e))
    }
}

fn ranges(items: &[Items]) -> Vec<Range<u32>> {
    items.iter().map(|&(start, end)| start..end).collect()
}
