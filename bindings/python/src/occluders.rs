//! Occluders baked for each mesh.

use cullet_bake::occluders::{OccluderOptions, Occluders, occluders};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::shaped;
use crate::jobs::interruptible;
use crate::scene::PyScene;
use crate::value_error;

/// Boxes, polygons, triangles of the mesh, and the share of its silhouette that they hide.
type Tables<'py> = (
    Bound<'py, PyArrayDyn<f32>>,
    Vec<Bound<'py, PyArrayDyn<f32>>>,
    Bound<'py, PyArrayDyn<f32>>,
    f64,
);

fn tables<'py>(py: Python<'py>, made: &Occluders, efficiency: f64) -> PyResult<Tables<'py>> {
    let boxes: Vec<f32> = made.boxes.iter().flat_map(|b| [b.min, b.max].concat()).collect();
    let polygon = |points: &Vec<[f32; 3]>| shaped(py, points.concat(), &[points.len(), 3]);
    let triangles: Vec<[[f32; 3]; 3]> =
        made.sheets.iter().flat_map(|s| s.triangles.iter().copied()).collect();
    let count = triangles.len();
    Ok((
        shaped(py, boxes, &[made.boxes.len(), 2, 3])?,
        made.polygons.iter().map(|p| polygon(&p.points)).collect::<PyResult<_>>()?,
        shaped(py, triangles.concat().concat(), &[count, 3, 3])?,
        efficiency,
    ))
}

#[pymethods]
impl PyScene {
    /// Bakes occluders of every mesh, and gives them to the scene where that is wanted.
    #[pyo3(signature = (*, apply=true))]
    fn _occluders<'py>(&mut self, py: Python<'py>, apply: bool) -> PyResult<Vec<Tables<'py>>> {
        let options = OccluderOptions::default();
        let meshes = self.model.scene.meshes();
        let made = interruptible(py, |stop| {
            let bake = |mesh| {
                // Whoever stops it looks at none of them.
                let is_stopped = stop.load(std::sync::atomic::Ordering::Relaxed);
                (!is_stopped).then(|| occluders(mesh, &options)).transpose()
            };
            meshes.par_iter().map(bake).collect::<Result<Vec<_>, _>>()
        })?;
        let made = made.map_err(value_error)?;
        let mut out = Vec::with_capacity(made.len());
        for (id, (made, report)) in (0..).zip(made.into_iter().flatten()) {
            if apply {
                let occluder = made.to_engine().map_err(value_error)?;
                self.model.scene.set_occluder(id, occluder);
            }
            out.push(tables(py, &made, report.efficiency())?);
        }
        Ok(out)
    }
}
