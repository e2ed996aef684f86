//! The scene: opened and asked.

use std::ffi::CString;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use cullet_io::{LoadOptions, Model, SaveErrorKind, Up};
use engine::{Handle, Scene, ViewState};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::{PyFileNotFoundError, PyIndexError, PyOSError, PyUserWarning, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{ids, shaped};
use crate::{FileError, value_error, whole};

/// The id of no instance.
pub(crate) const NO_ID: u32 = u32::MAX;

/// Native part of `pycullet.Scene`.
#[pyclass(subclass, module = "pycullet", name = "Scene")]
#[derive(Default)]
pub(crate) struct PyScene {
    pub(crate) model: Model,
    /// Handle of each id: none where the instance was removed.
    pub(crate) handles: Vec<Option<Handle>>,
    /// Id of each handle, by the handle's index.
    pub(crate) id_of: Vec<u32>,
    /// States of views, for whoever culls next: an answer never depends on them.
    states: Mutex<Vec<ViewState>>,
}

impl PyScene {
    pub(crate) fn scene(&self) -> &Scene {
        &self.model.scene
    }

    /// Takes a model over, whose instances count up in the order of the file.
    fn take(&mut self, model: Model) {
        let mut handles: Vec<Handle> =
            model.scene.slots().filter_map(|slot| model.scene.handle(slot)).collect();
        handles.sort_unstable_by_key(|h| h.index);
        *self = Self { model, ..Self::default() };
        handles.into_iter().for_each(|handle| {
            self.note(handle);
        });
    }

    /// Gives a new instance its id.
    pub(crate) fn note(&mut self, handle: Handle) -> u32 {
        let (id, index) = (self.handles.len() as u32, handle.index as usize);
        self.handles.push(Some(handle));
        if self.id_of.len() <= index {
            self.id_of.resize(index + 1, NO_ID);
        }
        self.id_of[index] = id;
        id
    }

    /// The handle of an id.
    pub(crate) fn handle(&self, id: u32) -> PyResult<Handle> {
        match self.handles.get(id as usize) {
            Some(Some(handle)) => Ok(*handle),
            Some(None) => Err(PyIndexError::new_err(format!("instance {id} was removed"))),
            None => Err(self.no_instance(id)),
        }
    }

    /// The handle of an id that was given as a number of any size.
    pub(crate) fn one(&self, id: &Bound<'_, PyAny>) -> PyResult<Handle> {
        let number = whole::named(id, "id")?.and_then(|number| u32::try_from(number).ok());
        number.map_or_else(|| Err(self.no_instance(id)), |number| self.handle(number))
    }

    fn no_instance(&self, id: impl Display) -> PyErr {
        PyIndexError::new_err(format!(
            "there is no instance {id}; ids of this scene are at least 0 and below {}",
            self.handles.len()
        ))
    }

    /// The id of what is in a slot; none for what only stands for others.
    pub(crate) fn id(&self, slot: u32) -> Option<u32> {
        let handle = self.scene().handle(slot)?;
        self.id_of.get(handle.index as usize).copied().filter(|&id| id != NO_ID)
    }

    pub(crate) fn slot(&self, id: u32) -> PyResult<u32> {
        self.scene().slot(self.handle(id)?).map_err(value_error)
    }

    pub(crate) fn with_state<R>(&self, work: impl FnOnce(&mut ViewState) -> R) -> R {
        let states = || self.states.lock().unwrap_or_else(PoisonError::into_inner);
        let mut state = states().pop().unwrap_or_default();
        let done = work(&mut state);
        states().push(state);
        done
    }

    fn chosen(&self, ids: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<u32>> {
        match ids {
            Some(ids) => self::ids(ids, "ids"),
            None => Ok(self.present().collect()),
        }
    }

    fn present(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.handles).filter(|(_, handle)| handle.is_some()).map(|(id, _)| id)
    }
}

#[pymethods]
impl PyScene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    #[pyo3(signature = (path, *, up=None, two_sided=None))]
    fn _open(
        &mut self,
        py: Python<'_>,
        path: PathBuf,
        up: Option<&str>,
        two_sided: Option<bool>,
    ) -> PyResult<()> {
        let up = match up {
            None => None,
            Some("y") => Some(Up::Y),
            Some("z") => Some(Up::Z),
            Some(other) => {
                return Err(PyValueError::new_err(format!(
                    "up is {other:?}; it must be \"y\" or \"z\", the axis of the file that points up"
                )));
            }
        };
        let options = LoadOptions { up, two_sided, ..LoadOptions::default() };
        let model =
            py.detach(|| cullet_maps::load(&path, &options)).map_err(|e| match &e.kind {
                cullet_io::ErrorKind::Io(io) if io.kind() == std::io::ErrorKind::NotFound => {
                    PyFileNotFoundError::new_err(format!("there is no file {}", path.display()))
                }
                cullet_io::ErrorKind::Io(_) => PyOSError::new_err(e.to_string()),
                _ => FileError::new_err(e.to_string()),
            })?;
        self.take(model);
        Ok(())
    }

    fn _build(&mut self, py: Python<'_>, spec: &str) -> PyResult<()> {
        let model = py.detach(|| cullet_scenes::build(spec)).map_err(value_error)?;
        self.take(model);
        Ok(())
    }

    /// Writes GLB, PLY, OBJ or STL, by the ending. Warns of what the file does not have.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let saved = py.detach(|| cullet_io::save(&self.model, &path));
        let saved = saved.map_err(|e| match &e.kind {
            SaveErrorKind::Io(_) => PyOSError::new_err(e.to_string()),
            _ => FileError::new_err(e.to_string()),
        })?;
        for note in saved.notes {
            let text = CString::new(note.to_string())?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        Ok(())
    }

    #[getter]
    fn title(&self) -> &str {
        &self.model.name
    }

    #[setter(title)]
    fn set_title(&mut self, title: String) {
        self.model.name = title;
    }

    /// Defects of the file that did not stop it from loading.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model.warnings.iter().map(ToString::to_string).collect()
    }

    /// How many instances there are.
    #[getter]
    fn instance_count(&self) -> u32 {
        self.scene().instance_count()
    }

    /// Ids given so far, those of removed instances included: the length of masks.
    #[getter]
    fn id_count(&self) -> usize {
        self.handles.len()
    }

    /// How many meshes they share.
    #[getter]
    fn mesh_count(&self) -> usize {
        self.scene().meshes().len()
    }

    /// Triangles of all instances.
    #[getter]
    fn triangle_count(&self) -> u64 {
        self.scene().triangle_count()
    }

    /// Rises with every change.
    #[getter]
    fn version(&self) -> u64 {
        self.scene().change_version()
    }

    /// The ids of all instances that are there.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_vec(py, self.present().collect())
    }

    /// (2, 3): low and high corner of everything; None for an empty scene.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let (extent, origin) = (self.scene().extent(), self.scene().origin());
        if extent.is_empty() {
            return Ok(None);
        }
        let corner =
            |c: [f32; 3]| std::array::from_fn::<f64, 3, _>(|a| f64::from(c[a]) + origin[a]);
        let both = [corner(extent.min), corner(extent.max)].concat();
        shaped(py, both, &[2, 3]).map(Some)
    }

    /// (n, 2, 3): the boxes that culling tests, rounded outward to float32, of all instances or of ``ids``.
    #[pyo3(signature = (ids=None))]
    fn boxes<'py>(
        &self,
        py: Python<'py>,
        ids: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (ids, origin) = (self.chosen(ids)?, self.scene().origin());
        let mut boxes = Vec::with_capacity(ids.len() * 6);
        for &id in &ids {
            let b = self.scene().bounds(self.slot(id)?);
            boxes.extend(
                [b.min, b.max].iter().flat_map(|c| (0..3).map(|a| f64::from(c[a]) + origin[a])),
            );
        }
        shaped(py, boxes, &[ids.len(), 2, 3])
    }

    /// (n, 4, 4): where all instances are, or ``ids``.
    #[pyo3(signature = (ids=None))]
    fn transforms<'py>(
        &self,
        py: Python<'py>,
        ids: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let ids = self.chosen(ids)?;
        let mut all = Vec::with_capacity(ids.len() * 16);
        for &id in &ids {
            let m = self.scene().transform(self.slot(id)?).to_matrix();
            all.extend((0..16).map(|i| m[i % 4 * 4 + i / 4]));
        }
        shaped(py, all, &[ids.len(), 4, 4])
    }

    /// (n,): the number of the mesh of each.
    #[pyo3(signature = (ids=None))]
    fn mesh_of<'py>(
        &self,
        py: Python<'py>,
        ids: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let ids = self.chosen(ids)?;
        let mesh = |&id: &u32| Ok(self.scene().mesh_id(self.slot(id)?));
        Ok(PyArray1::from_vec(py, ids.iter().map(mesh).collect::<PyResult<_>>()?))
    }

    /// The name of an instance: that of its node, or of its mesh with a number.
    fn name(&self, id: &Bound<'_, PyAny>) -> PyResult<String> {
        Ok(self.model.instance_name(self.one(id)?).into_owned())
    }

    fn __len__(&self) -> usize {
        self.scene().instance_count() as usize
    }
}
