//! Visible instances of one camera, and of many.

use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::{Pod, Zeroable};
use engine::{Culler, Output, View, ViewState, Visible, funnel::FunnelRow};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{mask_into, structured};
use crate::jobs::{interruptible, on_threads};
use crate::scene::PyScene;
use crate::{StaleError, draw, levels, whole};

/// Characters of names in a structured array.
const NAME: usize = 10;

/// A row of a funnel as `pycullet._dtypes` describes it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Row {
    /// Instances, clusters and triangles in, then out.
    counts: [u64; 6],
    stage: [u32; NAME],
    unit: [u32; NAME],
    camera: u32,
    padding: u32,
}

impl Row {
    fn of(row: &FunnelRow, camera: usize) -> Self {
        let counts = |c: &engine::funnel::Counts| [c.instances, c.clusters, c.triangles];
        let ([a, b, c], [d, e, f]) = (counts(&row.entered), counts(&row.left));
        let name = |text: &str| {
            let mut letters = [0; NAME];
            letters.iter_mut().zip(text.chars()).for_each(|(to, c)| *to = c.into());
            letters
        };
        Self {
            counts: [a, b, c, d, e, f],
            stage: name(row.stage.name()),
            unit: name(row.unit.name()),
            camera: camera as u32,
            padding: 0,
        }
    }
}

/// The answer on one view, by ids.
#[derive(Default)]
pub(crate) struct Answer {
    /// Ascending.
    pub(crate) ids: Vec<u32>,
    /// Level of each id; empty where all are drawn in full.
    levels: Vec<u32>,
    /// Instance, level, first cluster, how many.
    partial: Vec<[u32; 4]>,
    /// Instance and original triangle.
    triangles: Vec<[u32; 2]>,
    /// Stage and detail of each id; no stage for a visible instance.
    reasons: Vec<[u8; 2]>,
    funnel: Vec<Row>,
    triangle_count: u64,
}

impl Answer {
    fn of(this: &PyScene, visible: &Visible, culler: &Culler, camera: usize) -> Self {
        let scene = this.scene();
        let partial = visible
            .partial
            .iter()
            .filter_map(|d| Some([this.id(d.slot)?, d.level, d.first_cluster, d.cluster_count]));
        let ids = ascending(this, visible);
        let levels = match culler.lod {
            Some(_) => levels::drawn(this, visible, &ids),
            None => Vec::new(),
        };
        let mut triangles = Vec::new();
        if culler.output == Output::Triangles {
            triangles.reserve_exact(visible.triangles.len());
            for range in &visible.triangle_ranges {
                let original = scene.mesh_at(range.slot, range.level).original_triangle();
                let Some(id) = this.id(range.slot) else { continue };
                let own = &visible.triangles[range.first as usize..][..range.count as usize];
                triangles.extend(own.iter().map(|&t| [id, original[t as usize]]));
            }
        }
        let mut reasons = Vec::new();
        if culler.reasons {
            reasons = vec![[0, 0]; this.handles.len()];
            for (slot, reason) in (0..).zip(&visible.reasons) {
                if let (Some(reason), Some(id)) = (reason, this.id(slot)) {
                    reasons[id as usize] = [reason.stage as u8, reason.detail];
                }
            }
        }
        Self {
            partial: partial.collect(),
            triangles,
            reasons,
            funnel: visible.funnel.rows.iter().map(|row| Row::of(row, camera)).collect(),
            triangle_count: visible.triangle_count,
            ids,
            levels,
        }
    }
}

/// The ids of what is visible, ascending: set as bits and read again, which takes less than sorting.
fn ascending(this: &PyScene, visible: &Visible) -> Vec<u32> {
    let mut bits = vec![0_u64; this.handles.len().div_ceil(64)];
    for id in visible.slots().filter_map(|slot| this.id(slot)) {
        bits[id as usize / 64] |= 1 << (id % 64);
    }
    let mut ids = Vec::with_capacity(visible.instance_count as usize);
    for (word, mut bits) in (0_u32..).zip(bits) {
        while bits != 0 {
            ids.push(word * 64 + bits.trailing_zeros());
            bits &= bits - 1;
        }
    }
    ids
}

/// Culls for one view.
pub(crate) fn one(this: &PyScene, view: &View, culler: &Culler) -> Answer {
    this.with_state(|state| {
        let mut visible = Visible::default();
        this.model.in_cells().cull(culler, view, state, &mut visible);
        Answer::of(this, &visible, culler, 0)
    })
}

/// Culls for many views, on the threads of rayon's pool or so many of its own.
pub(crate) fn many(
    py: Python<'_>,
    this: &PyScene,
    views: &[View],
    culler: &Culler,
    threads: usize,
) -> PyResult<Vec<Answer>> {
    let work = |stop: &AtomicBool| {
        let answer = |(state, visible): &mut (ViewState, Visible), (at, view): (usize, &View)| {
            if stop.load(Ordering::Relaxed) {
                return Answer::default();
            }
            this.model.in_cells().cull(culler, view, state, visible);
            Answer::of(this, visible, culler, at)
        };
        let all = views.par_iter().enumerate();
        on_threads(threads, || all.map_init(Default::default, answer).collect())
    };
    interruptible(py, |stop| work(stop))
}

/// Visible instances of one camera: everything it sees is among them. In a notebook it shows both
/// pictures and the funnel.
#[pyclass(frozen, module = "pycullet", name = "Result")]
pub(crate) struct PyResultOne {
    scene: Py<PyScene>,
    version: u64,
    /// How many ids there were.
    count: usize,
    view: View,
    culler: Culler,
    visible: Py<PyArray1<u32>>,
    answer: Answer,
}

impl PyResultOne {
    pub(crate) fn new(
        mut answer: Answer,
        scene: &Bound<'_, PyScene>,
        view: View,
        culler: Culler,
    ) -> Self {
        let this = scene.borrow();
        let ids = std::mem::take(&mut answer.ids);
        Self {
            version: this.scene().change_version(),
            count: this.handles.len(),
            visible: PyArray1::from_vec(scene.py(), ids).unbind(),
            scene: scene.clone().unbind(),
            view,
            culler,
            answer,
        }
    }
}

#[pymethods]
impl PyResultOne {
    /// (n,): ids of visible instances, ascending. The same array each time.
    #[getter]
    fn visible<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.visible.bind(py).clone()
    }

    /// (ids,): whether each id is visible; written into ``out`` where it is given.
    #[pyo3(signature = (out=None))]
    fn mask<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let ids = self.visible.bind(py).try_readonly().map_err(crate::value_error)?;
        let ids = ids.as_slice().map_err(crate::value_error)?;
        mask_into(py, out, &[self.count], |mask| {
            // The array is the caller's by now, who may have written into it.
            for &id in ids {
                if let Some(bit) = mask.get_mut(id as usize) {
                    *bit = true;
                }
            }
        })
    }

    /// (n,): the level of detail that is drawn of each instance in ``visible``, 0 for the mesh itself.
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        Ok(match self.culler.lod {
            Some(_) => PyArray1::from_slice(py, &self.answer.levels),
            None => PyArray1::zeros(py, self.visible.bind(py).len()?, false),
        })
    }

    /// Clusters of instances that are drawn in part: ``id``, ``level``, ``first_cluster``, ``cluster_count``.
    ///
    /// An id that is visible and not in here is drawn whole.
    #[getter]
    fn partial<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        structured(py, &self.answer.partial, "PARTIAL")
    }

    /// Every triangle that is left: ``id`` and ``triangle``, by its number in the mesh as it was given; of an instance
    /// that is drawn at a level above 0, in `Scene.level_mesh`.
    ///
    /// Raises `AttributeError` unless the culler's ``output`` is ``triangles``.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if self.culler.output != Output::Triangles {
            return Err(pyo3::exceptions::PyAttributeError::new_err(
                "triangles are listed where they were asked for: cull with pycullet.Culler(output=\"triangles\")",
            ));
        }
        structured(py, &self.answer.triangles, "TRIANGLES")
    }

    /// Number of the ``stage`` in `pycullet.STAGES` that dropped each id, from 1, and a ``detail``
    /// (for the frustum, which plane); 0 for a visible instance. Raises `AttributeError` unless the
    /// culler keeps ``reasons``.
    #[getter]
    fn reasons<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if !self.culler.reasons {
            return Err(pyo3::exceptions::PyAttributeError::new_err(
                "reasons are kept where they were asked for: cull with pycullet.Culler(reasons=True)",
            ));
        }
        structured(py, &self.answer.reasons, "REASONS")
    }

    /// A row for each stage that ran: ``stage``, ``unit``, and how many instances, clusters and triangles came in
    /// (``instances_in``, ...) and went on (``instances_out``, ...).
    #[getter]
    fn funnel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        structured(py, &self.answer.funnel, "FUNNEL")
    }

    /// How many triangles will be drawn.
    #[getter]
    fn triangle_count(&self) -> u64 {
        self.answer.triangle_count
    }

    /// The scene that was culled.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<PyScene> {
        self.scene.clone_ref(py)
    }

    /// The camera that it was culled for.
    #[getter]
    fn camera(&self) -> crate::camera::PyCamera {
        crate::camera::PyCamera { view: self.view.clone() }
    }

    /// PNG files of what the camera sees, and of the scene from outside by the kind of culling, ``width`` pixels
    /// wide (320 to 4096). Raises `StaleError` where the scene has changed since.
    #[pyo3(signature = (width=480))]
    fn pictures<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = whole::width)] width: u32,
    ) -> PyResult<[Bound<'py, pyo3::types::PyBytes>; 2]> {
        let this = self.scene.bind(py).borrow();
        if this.scene().change_version() != self.version {
            return Err(StaleError::new_err(
                "the scene has changed since this was culled; cull again",
            ));
        }
        draw::pictures(py, &this, &self.view, &self.culler, width)
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("pycullet._html")?.call_method1("of_result", (slf,))?.extract()
    }

    /// How many instances are visible.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.visible.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (seen, triangles) = (self.visible.bind(py).len()?, self.answer.triangle_count);
        let of = self.answer.funnel.first().map_or(0, |row| row.counts[0]);
        Ok(format!("<pycullet.Result: {seen} of {of} instances visible, {triangles} triangles>"))
    }
}

/// Visible instances of many cameras. ``results[i]`` has the ids of camera i, ascending.
#[pyclass(frozen, module = "pycullet", name = "Results")]
pub(crate) struct PyResults {
    answers: Vec<Answer>,
    /// How many ids there were.
    count: usize,
}

impl PyResults {
    pub(crate) fn new(answers: Vec<Answer>, this: &PyScene) -> Self {
        Self { answers, count: this.handles.len() }
    }
}

#[pymethods]
impl PyResults {
    /// The ids of all cameras, one after the other.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let ids: Vec<&[u32]> = self.answers.iter().map(|a| &a.ids[..]).collect();
        PyArray1::from_vec(py, ids.concat())
    }

    /// (cameras + 1,): those of camera i are ``ids[offsets[i]:offsets[i + 1]]``.
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let ends = self.answers.iter().scan(0, |end, a| {
            *end += a.ids.len() as i64;
            Some(*end)
        });
        PyArray1::from_vec(py, std::iter::once(0).chain(ends).collect())
    }

    /// The level of detail that is drawn of each of ``ids``, 0 for the mesh itself.
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let levels = self.answers.iter().flat_map(|a| {
            let level = |at| a.levels.get(at).copied().unwrap_or(0);
            (0..a.ids.len()).map(level)
        });
        PyArray1::from_vec(py, levels.collect())
    }

    /// (cameras,): how many instances each sees.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_vec(py, self.answers.iter().map(|a| a.ids.len() as i64).collect())
    }

    /// (cameras,): how many triangles will be drawn for each.
    #[getter]
    fn triangle_counts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_vec(py, self.answers.iter().map(|a| a.triangle_count).collect())
    }

    /// Funnels of all cameras like `Result.funnel`, with the number of the ``camera``.
    #[getter]
    fn funnel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows: Vec<&[Row]> = self.answers.iter().map(|a| &a.funnel[..]).collect();
        structured(py, &rows.concat(), "FUNNELS")
    }

    /// (cameras, ids): whether each camera sees each id; written into ``out`` where it is given.
    #[pyo3(signature = (out=None))]
    fn mask<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        mask_into(py, out, &[self.answers.len(), self.count], |mask| {
            for (row, answer) in mask.chunks_exact_mut(self.count.max(1)).zip(&self.answers) {
                answer.ids.iter().for_each(|&id| row[id as usize] = true);
            }
        })
    }

    fn __len__(&self) -> usize {
        self.answers.len()
    }

    fn __getitem__<'py>(&self, at: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let at_camera = whole::camera(at, self.answers.len())?;
        Ok(PyArray1::from_slice(at.py(), &self.answers[at_camera].ids))
    }

    fn __repr__(&self) -> String {
        let seen: usize = self.answers.iter().map(|a| a.ids.len()).sum();
        let (cameras, ids) = (self.answers.len(), self.count);
        let mean = seen as f64 / cameras.max(1) as f64;
        format!(
            "<pycullet.Results: {cameras} cameras, {mean:.1} of {ids} instances visible on average>"
        )
    }
}
