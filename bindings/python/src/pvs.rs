//! Potentially visible sets: what may be seen from boxes that an eye may be in.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use cullet_bake::sampled::{
    RayTree, RayTreeOptions, Region, SampledBake, SampledError, SampledSettings, SceneSets,
    ViewCells,
};
use cullet_bake::work::RunOptions;
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::{PyFileNotFoundError, PyIndexError, PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{ids, rows, rows_or_row, shaped};
use crate::jobs::interruptible;
use crate::scene::{NO_ID, PyScene};
use crate::{FileError, value_error, whole};

/// Visible sets of some cells, which are boxes that an eye may be in.
///
/// Found by sampled lines, so not conservative: `missing` says how much is likely to be missing.
#[pyclass(frozen, module = "pycullet", name = "Pvs")]
pub(crate) struct PyPvs {
    sets: SceneSets,
    /// Id of each handle, by the handle's index.
    ids: Vec<u32>,
    count: usize,
}

impl PyPvs {
    fn seen(&self, cell: u32) -> Vec<u32> {
        let id = |index: u32| self.ids.get(index as usize).copied().filter(|&id| id != NO_ID);
        let mut seen: Vec<u32> = self.sets.sets.seen_from(cell).filter_map(id).collect();
        seen.sort_unstable();
        seen
    }

    fn cell_at(&self, point: [f64; 3]) -> Option<u32> {
        let holds = |b: &Region| (0..3).all(|a| b[0][a] <= point[a] && point[a] <= b[1][a]);
        self.sets.cells.iter().position(holds).map(|at| at as u32)
    }

    fn check(&self, cell: u32) -> PyResult<u32> {
        let len = self.sets.cells.len();
        if (cell as usize) < len {
            return Ok(cell);
        }
        Err(PyIndexError::new_err(format!("there is no cell {cell}; there are {len}")))
    }
}

#[pymethods]
impl PyPvs {
    /// (n, 2, 3): low and high corners.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let cells = &self.sets.cells;
        shaped(py, cells.iter().flatten().flatten().copied().collect(), &[cells.len(), 2, 3])
    }

    /// (n,): the share of looks from each cell that is estimated to end on something that its set lacks.
    #[getter]
    fn missing<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.sets.missing)
    }

    /// Rays that were traced; 0 where it was opened from a file.
    #[getter]
    fn rays(&self) -> u64 {
        self.sets.rays
    }

    /// The cell of each point, −1 for one in none.
    fn cell_of<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let points: Vec<[f64; 3]> = rows_or_row(points, "points", None)?;
        let cells = points.iter().map(|&p| self.cell_at(p).map_or(-1, |cell| cell as i32));
        Ok(PyArray1::from_vec(py, cells.collect()))
    }

    /// The ids that may be seen from a cell, or from any of some, ascending.
    fn visible<'py>(
        &self,
        py: Python<'py>,
        cells: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let mut all = Vec::new();
        for cell in ids(cells, "cells")? {
            all.extend(self.seen(self.check(cell)?));
        }
        all.sort_unstable();
        all.dedup();
        Ok(PyArray1::from_vec(py, all))
    }

    /// (cells, ids): whether each cell sees each id.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let cells = self.sets.cells.len();
        let mut bits = vec![false; cells * self.count];
        for (cell, row) in (0..cells as u32).zip(bits.chunks_exact_mut(self.count.max(1))) {
            self.seen(cell).iter().for_each(|&id| row[id as usize] = true);
        }
        shaped(py, bits, &[cells, self.count])
    }

    /// Writes a file that `Scene.open_pvs` and the program ``cullet`` open.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        std::fs::write(&path, self.sets.to_bytes())
            .map_err(|e| PyOSError::new_err(format!("{}: cannot be written: {e}", path.display())))
    }

    fn __len__(&self) -> usize {
        self.sets.cells.len()
    }

    fn __repr__(&self) -> String {
        let [mean, _] = self.sets.stated_error();
        let (cells, share) = (self.sets.cells.len(), mean * 100.0);
        format!("<pycullet.Pvs: {cells} cells, {share:.3} % of looks estimated to miss something>")
    }
}

fn regions(scene: &PyScene, region: Option<&Bound<'_, PyAny>>) -> PyResult<Region> {
    match region {
        None => {
            let (b, origin) = (scene.scene().extent(), scene.scene().origin());
            let corner = |c: [f32; 3]| std::array::from_fn(|a| f64::from(c[a]) + origin[a]);
            Ok([b.min, b.max].map(corner))
        }
        Some(region) => match &rows::<3>(region, "region")?.0[..] {
            &[low, high] => Ok([low, high]),
            other => Err(PyValueError::new_err(format!(
                "region has the shape ({}, 3); it must be (2, 3): the low and the high corner",
                other.len()
            ))),
        },
    }
}

#[pymethods]
impl PyScene {
    /// Finds what may be seen from each of some cells, by sampled lines; Ctrl-C ends it.
    ///
    /// ``cells`` are so many where geometry is near, or a grid of so many along each axis, in ``region``, (2, 3), or
    /// else the bounds of the scene. It ends after ``rays`` rays, or where the share of looks that is estimated to
    /// miss something is at most ``missing``. The same for any number of threads.
    #[pyo3(signature = (cells=None, *, region=None, rays=10_000_000, missing=2e-5, seed=1, threads=0))]
    #[expect(
        clippy::too_many_arguments,
        reason = "settings of a bake, each with its name in Python"
    )]
    fn bake_pvs<'py>(
        &self,
        py: Python<'py>,
        cells: Option<&Bound<'py, PyAny>>,
        region: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = whole::rays)] rays: u64,
        missing: f64,
        #[pyo3(from_py_with = whole::seed)] seed: u64,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<PyPvs> {
        if self.scene().instance_count() == 0 {
            return Err(PyValueError::new_err(
                "the scene has no instance, so there is nothing to see",
            ));
        }
        let cells = cells.map_or(Ok(Cells::Count(64)), cell_counts)?;
        let region = regions(self, region)?;
        let settings =
            SampledSettings::default().with_rays(rays).with_missing(missing).with_seed(seed);
        let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
        let sets = interruptible(py, |stop| -> Result<SceneSets, SampledError> {
            let tree = RayTree::new(self.scene(), &RayTreeOptions::default())?;
            let cells = match cells {
                Cells::Count(n) => ViewCells::adaptive(&tree, &[region], n, seed)?,
                Cells::Grid(counts) => ViewCells::grid(region, counts)?,
            };
            let mut bake = SampledBake::new(&tree, &cells, &settings)?;
            // Without a folder nothing can fail.
            let _ = bake.run(&RunOptions { threads, ..RunOptions::default() }, &|_| {
                !stop.load(Ordering::Relaxed)
            });
            Ok(bake.finish().to_sets())
        })?;
        let sets = sets.map_err(value_error)?;
        Ok(PyPvs { sets, ids: self.id_of.clone(), count: self.handles.len() })
    }

    /// Opens sets that were baked of this scene. Raises `FileError` where they are of another.
    fn open_pvs(&self, path: PathBuf) -> PyResult<PyPvs> {
        let bytes = std::fs::read(&path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => {
                PyFileNotFoundError::new_err(format!("there is no file {}", path.display()))
            }
            _ => PyOSError::new_err(format!("{}: cannot be read: {e}", path.display())),
        })?;
        let wrong = |e| FileError::new_err(format!("{}: {e}", path.display()));
        let sets = SceneSets::from_bytes(&bytes).map_err(wrong)?;
        let (found, expected) = (sets.scene_hash, cullet_bake::sampled::scene_hash(self.scene()));
        if found != expected {
            return Err(wrong(cullet_bake::sampled::SceneSetsError::OtherScene {
                found,
                expected,
            }));
        }
        Ok(PyPvs { sets, ids: self.id_of.clone(), count: self.handles.len() })
    }

    /// Culls by these sets from now on while the eye is in one of their cells; None for no more.
    fn set_pvs(&mut self, py: Python<'_>, pvs: &Bound<'_, PyAny>) -> PyResult<()> {
        if pvs.is_none() {
            self.model.placed = None;
            return Ok(());
        }
        let pvs = pvs
            .cast::<PyPvs>()
            .map_err(|_| PyTypeError::new_err("pvs must be a pycullet.Pvs, or None for no sets"))?;
        let sets = pvs.get().sets.clone();
        let placed = py.detach(|| sets.place_in(&mut self.model.scene)).map_err(value_error)?;
        self.model.placed = Some(placed);
        Ok(())
    }
}

/// How many view cells, or how many along each axis.
enum Cells {
    Count(u32),
    Grid([u32; 3]),
}

fn cell_counts(value: &Bound<'_, PyAny>) -> PyResult<Cells> {
    let wrong = || {
        let value = value.repr().map_or_else(|_| "that".into(), |r| r.to_string());
        PyValueError::new_err(format!(
            "cells is {value}; it must be a number of cells from 1, or one along each axis such as (8, 1, 8)"
        ))
    };
    if let Ok(count) = value.extract::<u32>() {
        return if count > 0 { Ok(Cells::Count(count)) } else { Err(wrong()) };
    }
    match value.extract::<[u32; 3]>() {
        Ok(counts) if counts.iter().all(|&n| n > 0) => Ok(Cells::Grid(counts)),
        _ => Err(wrong()),
    }
}
