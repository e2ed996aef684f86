//! The scene culled: for one camera, or for many.

use pyo3::prelude::*;

use crate::result::{self, PyResultOne, PyResults};
use crate::scene::PyScene;
use crate::{camera, culler, levels, whole};

#[pymethods]
impl PyScene {
    /// Returns what a camera, or each of many, may see.
    ///
    /// Conservative: nothing visible is missing. Many cameras are spread over ``threads`` threads, 0 for as many as
    /// there are processors; the answers are the same. Other threads of Python go on meanwhile, and may cull the same
    /// scene; one that changes it then gets a `RuntimeError`.
    ///
    /// With ``lod``, an instance whose mesh has levels is drawn at the coarsest one whose error is at most that many
    /// pixels at the centre of the picture, as `Result.levels` says; at 0 and without, in full.
    #[pyo3(signature = (camera, culler=None, *, lod=None, threads=0))]
    fn cull<'py>(
        slf: &Bound<'py, Self>,
        py: Python<'py>,
        camera: &Bound<'py, PyAny>,
        culler: Option<&Bound<'py, PyAny>>,
        lod: Option<f64>,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (views, is_one) = camera::views(camera)?;
        let culler = levels::with_pixels(culler::culler(culler)?, lod)?;
        let borrowed = slf.try_borrow()?;
        let this: &Self = &borrowed;
        if is_one && let [view] = &views[..] {
            let answer = py.detach(|| result::one(this, view, &culler));
            let result = PyResultOne::new(answer, slf, view.clone(), culler);
            return Ok(Bound::new(py, result)?.into_any());
        }
        let answers = result::many(py, this, &views, &culler, threads)?;
        Ok(Bound::new(py, PyResults::new(answers, this))?.into_any())
    }
}
