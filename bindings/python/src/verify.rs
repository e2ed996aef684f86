//! The proof: each view drawn with and without culling.

use std::sync::atomic::Ordering;

use bytemuck::{Pod, Zeroable};
use cullet_draw::VerifyOptions;
use engine::{Reason, ViewState, funnel::FunnelRow};
use pyo3::prelude::*;

use crate::arrays::structured;
use crate::jobs::{interruptible, on_threads};
use crate::scene::{NO_ID, PyScene};
use crate::{camera, culler, whole};

/// Visible triangle that was dropped, as `pycullet._dtypes` describes it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct FalseCull {
    camera: u32,
    id: u32,
    /// −1 for an instance that is seen between the pixels alone.
    triangle: i32,
    x: u32,
    y: u32,
    stage: u32,
}

/// Figures of a view, as `pycullet._dtypes` describes them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Figures {
    all: u64,
    kept: u64,
    visible: u64,
    /// Triangles that each stage took.
    dropped: [u64; 9],
}

#[pymethods]
impl PyScene {
    /// Figures of each view, and what was lost.
    #[pyo3(signature = (camera, culler=None, *, samples=4, seed=0, threads=0))]
    fn _verify<'py>(
        &self,
        py: Python<'py>,
        camera: &Bound<'py, PyAny>,
        culler: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = whole::samples)] samples: u32,
        #[pyo3(from_py_with = whole::seed)] seed: u64,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let ((views, _), culler) = (camera::views(camera)?, culler::culler(culler)?);
        let options = VerifyOptions { samples, seed, ..VerifyOptions::default() };
        let (figures, lost) = interruptible(py, |stop| {
            on_threads(threads, || {
                let (mut figures, mut lost) = (Vec::new(), Vec::new());
                let mut state = ViewState::default();
                for (number, view) in (0..).zip(&views) {
                    if stop.load(Ordering::Relaxed) {
                        break;
                    }
                    let proof =
                        cullet_draw::verify(self.scene(), view, &culler, &mut state, &options);
                    let mut dropped = [0; 9];
                    for row in &proof.funnel.rows {
                        dropped[row.stage as usize - 1] += FunnelRow::dropped(row).triangles;
                    }
                    figures.push(Figures {
                        all: proof.all,
                        kept: proof.potentially_visible,
                        visible: proof.visible,
                        dropped,
                    });
                    lost.extend(proof.false_culls.iter().map(|f| FalseCull {
                        camera: number,
                        id: self.id(f.slot).unwrap_or(NO_ID),
                        triangle: f.triangle.map_or(-1, |t| t as i32),
                        x: f.pixel[0],
                        y: f.pixel[1],
                        stage: f.reason.map_or(0, |Reason { stage, .. }| stage as u32),
                    }));
                }
                (figures, lost)
            })
        })?;
        Ok((structured(py, &figures, "FIGURES")?, structured(py, &lost, "FALSE_CULLS")?))
    }
}
