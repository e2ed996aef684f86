//! Levels of detail: baked for each mesh, and which of them is drawn.

use std::collections::HashMap;
use std::sync::atomic::Ordering;

use bytemuck::{Pod, Zeroable};
use cullet_bake::levels::{ChainOptions, build_chain};
use engine::lod::{Levels, Lod};
use engine::{Culler, MeshData, Visible};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{shaped, structured};
use crate::jobs::{interruptible, on_threads};
use crate::scene::PyScene;
use crate::{value_error, whole};

/// Vertices, triangles, and the level of each triangle.
type LevelMesh<'py> =
    (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<u32>>, Bound<'py, PyArray1<u32>>);

/// One level of a mesh, as `pycullet._dtypes` describes it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Row {
    mesh: u32,
    level: u32,
    triangles: u32,
    error: f32,
}

/// Sets the pixels that levels may be off. `None` leaves the culler as it is.
pub(crate) fn with_pixels(mut culler: Culler, pixels: Option<f64>) -> PyResult<Culler> {
    let Some(pixels) = pixels else { return Ok(culler) };
    if !(pixels >= 0.0 && pixels.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "lod is {pixels}; it must be a number of pixels from 0"
        )));
    }
    culler.lod = Some(Lod::default().with_pixels(pixels));
    Ok(culler)
}

/// Level of each cluster: how many groups lie between it and the original mesh, which is level 0.
fn depths(levels: &Levels) -> Vec<u32> {
    let (made_from, replaced_by) = (levels.made_from(), levels.replaced_by());
    let mut order: Vec<usize> = (0..made_from.len()).collect();
    // Groups below have lower numbers, so that those that a cluster is made from are done before it.
    order.sort_by_key(|&c| made_from[c].wrapping_add(1));
    let mut of_group = vec![1_u32; levels.group_count()];
    let mut of_cluster = vec![0; made_from.len()];
    for cluster in order {
        let depth = of_group.get(made_from[cluster] as usize).copied().unwrap_or(0);
        of_cluster[cluster] = depth;
        if let Some(above) = of_group.get_mut(replaced_by[cluster] as usize) {
            *above = depth.saturating_add(1).max(*above);
        }
    }
    of_cluster
}

/// Returns the level that is drawn of each of `ids`, which ascend. Of an instance that is drawn in several levels, it
/// is the coarsest. Visits the clusters of each mesh that is drawn by its levels once.
pub(crate) fn drawn(this: &PyScene, visible: &Visible, ids: &[u32]) -> Vec<u32> {
    let scene = this.scene();
    let mut drawn = vec![0; ids.len()];
    let mut known = HashMap::new();
    for range in visible.partial.iter().filter(|range| range.level > 0) {
        let mesh = scene.mesh_id(range.slot);
        let Some(levels) = scene.levels(mesh).get(range.level as usize - 1) else { continue };
        let depths = known.entry((mesh, range.level)).or_insert_with(|| depths(&levels.levels));
        let clusters = range.first_cluster as usize..;
        let own =
            depths.get(clusters).unwrap_or_default().iter().take(range.cluster_count as usize);
        let at = this.id(range.slot).and_then(|id| ids.binary_search(&id).ok());
        if let (Some(at), Some(&depth)) = (at, own.max()) {
            drawn[at] = depth.max(drawn[at]);
        }
    }
    drawn
}

#[pymethods]
impl PyScene {
    /// Bakes levels of detail of every mesh: the whole mesh again and again, each time with fewer triangles.
    ///
    /// Returns a row for each level: ``mesh``, ``level`` (0 is the mesh itself), ``triangles`` and ``error``, the
    /// largest distance between the level and the mesh that was measured, in units of the mesh. `cull` draws levels
    /// with ``lod``. They replace levels that a mesh had, and are held by meshes of their own, which count in
    /// `mesh_count`; a mesh that cannot be simplified has level 0 alone. The same on every run and machine. Costs
    /// seconds for meshes of a hundred thousand triangles, on ``threads`` threads, 0 for one a processor; Ctrl-C
    /// interrupts it, and then nothing has changed.
    #[pyo3(signature = (*, threads=0))]
    fn bake_levels<'py>(
        &mut self,
        py: Python<'py>,
        #[pyo3(from_py_with = whole::threads)] threads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let scene = &self.model.scene;
        let mut holds = vec![false; scene.meshes().len()];
        for mesh in 0..holds.len() as u32 {
            scene.levels(mesh).iter().for_each(|levels| holds[levels.mesh as usize] = true);
        }
        let own: Vec<u32> = (0_u32..).zip(&holds).filter(|(_, h)| !**h).map(|(m, _)| m).collect();
        let bake = |&mesh: &u32| {
            let mesh = &scene.meshes()[mesh as usize];
            let data = MeshData { deformable: false, polygons: 0, ..mesh.to_data() };
            build_chain(&data, &ChainOptions::default())?.into_levels()
        };
        let made = interruptible(py, |stop| {
            let unless_stopped =
                |mesh| (!stop.load(Ordering::Relaxed)).then(|| bake(mesh)).transpose();
            let bake_all = || own.par_iter().map(unless_stopped).collect::<Result<Vec<_>, _>>();
            on_threads(threads, bake_all)
        })?;
        let mut rows = Vec::new();
        for (mesh, made) in own.into_iter().zip(made.map_err(value_error)?) {
            let Some((held, levels)) = made else { continue };
            let triangles = self.scene().meshes()[mesh as usize].triangle_count();
            rows.push(Row { mesh, level: 0, triangles, error: 0.0 });
            let mut of_level = vec![0; levels.group_count()];
            for (cluster, &group) in held.clusters().iter().zip(levels.made_from()) {
                if let Some(count) = of_level.get_mut(group as usize) {
                    *count += cluster.triangle_count;
                }
            }
            rows.extend((0..).zip(of_level).map(|(group, triangles)| Row {
                mesh,
                level: group as u32 + 1,
                triangles,
                error: levels.group(group).error,
            }));
            let model = &mut self.model;
            model.scene.clear_levels(mesh);
            if levels.group_count() == 0 {
                continue;
            }
            let name = format!("{}, levels", model.mesh_names.get(mesh as usize).map_or("", |n| n));
            let held_by = model.scene.add_mesh(held);
            model.mesh_names.resize(held_by as usize, String::new());
            model.mesh_names.push(name);
            model.scene.add_levels(mesh, held_by, levels).map_err(value_error)?;
        }
        structured(py, &rows, "LEVELS")
    }

    /// Vertices (n, 3), triangles (m, 3) and the level of each triangle (m,), of all levels of a mesh.
    ///
    /// ``number`` is which of its levels, from 1 (the default), as ``level`` of `Result.partial`: a file may bring several kinds.
    /// `Result.triangles` numbers the triangles of an instance that is drawn at a level above 0 as they are here.
    /// Raises `IndexError` where the mesh has no such levels.
    #[pyo3(signature = (mesh, number=None))]
    fn level_mesh<'py>(
        &self,
        mesh: &Bound<'py, PyAny>,
        number: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<LevelMesh<'py>> {
        let (py, meshes) = (mesh.py(), self.scene().meshes());
        let mesh = whole::mesh(mesh, meshes.len())?;
        let all = self.scene().levels(mesh);
        let number = number.map_or(Ok(Some(1)), |number| whole::named(number, "number"))?;
        let at = number.and_then(|number| usize::try_from(number - 1).ok());
        let levels = at.and_then(|at| all.get(at)).ok_or_else(|| {
            let number = number.map_or("of that number".into(), |number| number.to_string());
            PyIndexError::new_err(format!(
                "mesh {mesh} has no levels {number}; it has {}, which count from 1; `bake_levels` makes them",
                all.len()
            ))
        })?;
        let held = &meshes[levels.mesh as usize];
        let (positions, indices) = (held.positions(), held.original_indices());
        let mut of_triangle = vec![0; indices.len() / 3];
        for (cluster, depth) in held.clusters().iter().zip(depths(&levels.levels)) {
            for triangle in cluster.triangles() {
                of_triangle[held.original_triangle()[triangle as usize] as usize] = depth;
            }
        }
        let triangles = of_triangle.len();
        Ok((
            shaped(py, positions.as_flattened().to_vec(), &[positions.len(), 3])?,
            shaped(py, indices, &[triangles, 3])?,
            PyArray1::from_vec(py, of_triangle),
        ))
    }
}
