//! Why an instance is drawn or not.

use pyo3::prelude::*;

use crate::scene::PyScene;
use crate::{camera, culler, value_error};

/// Stage, unit, how many came in, how many went on, and what was found.
type Step = (&'static str, &'static str, u64, u64, String);

#[pymethods]
impl PyScene {
    /// The stage that took the instance, the steps, and who hides it.
    #[pyo3(signature = (camera, id, culler=None))]
    fn _explain(
        &self,
        py: Python<'_>,
        camera: PyRef<'_, camera::PyCamera>,
        id: &Bound<'_, PyAny>,
        culler: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Option<&'static str>, Vec<Step>, Vec<u32>)> {
        let (culler, handle) = (culler::culler(culler)?, self.one(id)?);
        let view = camera.view.clone();
        let found = py
            .detach(|| self.model.in_cells().explain(&culler, &view, handle))
            .map_err(value_error)?;
        let steps = found.steps.into_iter();
        let steps =
            steps.map(|s| (s.stage.name(), s.unit.name(), s.entered, s.left, s.to_string()));
        let hidden_by = found.hidden_by.iter().filter_map(|&slot| self.id(slot));
        Ok((found.reason.map(|r| r.stage.name()), steps.collect(), hidden_by.collect()))
    }
}
