//! Settings of culling.

use engine::cull::detail::Detail;
use engine::{Culler, Output, Stage};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Settings of culling. They never change; the name of a preset stands for its settings wherever one is taken.
#[pyclass(frozen, module = "pycullet", name = "Culler")]
#[derive(Clone)]
pub(crate) struct PyCuller {
    pub(crate) culler: Culler,
    preset: &'static str,
}

fn preset(name: &str) -> PyResult<(Culler, &'static str)> {
    match name {
        "exact" => Ok((Culler::exact(), "exact")),
        "balanced" => Ok((Culler::balanced(), "balanced")),
        "fast" => Ok((Culler::fast(), "fast")),
        _ => Err(PyValueError::new_err(format!(
            "there is no preset {name:?}; there are \"exact\", \"balanced\" and \"fast\""
        ))),
    }
}

#[pymethods]
impl PyCuller {
    /// ``exact`` finds as much as can be proved, ``balanced`` what pays in most frames, ``fast`` what is found
    /// soonest; none drops anything visible.
    ///
    /// ``output`` is how deep the answer goes, ``reasons`` whether `Result.reasons` is kept, ``without`` the stages
    /// that are left out, of `pycullet.STAGES`. With ``min_pixels``, what is narrower and lower than that on the screen
    /// is dropped too, which is the one setting that may lose something visible.
    #[new]
    #[pyo3(signature = (preset="balanced", *, output="clusters", reasons=false, without=Vec::new(), min_pixels=None))]
    fn new(
        preset: &str,
        output: &str,
        reasons: bool,
        without: Vec<String>,
        min_pixels: Option<f64>,
    ) -> PyResult<Self> {
        let (mut culler, preset) = self::preset(preset)?;
        for name in &without {
            let stage = Stage::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| {
                let all = Stage::ALL.map(Stage::name).join(", ");
                PyValueError::new_err(format!("there is no stage {name:?}; there are {all}"))
            })?;
            culler = culler.without(stage);
        }
        culler.output = match output {
            "instances" => Output::Instances,
            "clusters" => Output::Clusters,
            "triangles" => Output::Triangles,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "output is {output:?}; it must be \"instances\", \"clusters\" or \"triangles\""
                )));
            }
        };
        culler.reasons = reasons;
        if let Some(threshold_px) = min_pixels {
            if !(threshold_px >= 0.0 && threshold_px.is_finite()) {
                return Err(PyValueError::new_err(format!(
                    "min_pixels is {threshold_px}; it must be a number of pixels from 0"
                )));
            }
            culler.detail = Some(Detail::default().with_threshold_px(threshold_px));
        }
        Ok(Self { culler, preset })
    }

    /// The preset that it was made of.
    #[getter]
    fn preset(&self) -> &'static str {
        self.preset
    }

    /// The stages that run, in their order; in scenes without cells, ``pvs`` and ``portal`` do nothing.
    #[getter]
    fn stages(&self) -> Vec<&'static str> {
        let runs = |stage: &Stage| self.culler.runs(*stage);
        Stage::ALL.into_iter().filter(runs).map(Stage::name).collect()
    }

    fn __repr__(&self) -> String {
        format!("<pycullet.Culler {}: {}>", self.preset, self.stages().join(", "))
    }
}

/// The culler that was given: settings, the name of a preset, or nothing.
pub(crate) fn culler(given: Option<&Bound<'_, PyAny>>) -> PyResult<Culler> {
    let Some(given) = given else { return Ok(Culler::balanced()) };
    if let Ok(own) = given.cast::<PyCuller>() {
        return Ok(own.get().culler.clone());
    }
    if let Ok(name) = given.extract::<String>() {
        return Ok(preset(&name)?.0);
    }
    let found = given.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "culler must be a pycullet.Culler or the name of a preset, not {found}"
    )))
}
