//! Meshes and instances that are added, moved and removed.

use std::collections::HashMap;

use cullet_io::Material;
use engine::mesh::{Alpha, Part};
use engine::{Instance, Mesh, MeshData, Transform};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{faces, ids, matrices, numbers, row, rows, shaped};
use crate::scene::PyScene;
use crate::{value_error, whole};

/// Vertices and triangles.
type Triangles<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<u32>>);

/// A transform of a matrix whose last row is that of an affine one.
fn transform(m: &[f64; 16], at: usize) -> PyResult<Transform> {
    if let Some(v) = m.iter().find(|v| !v.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "transform {at} has {v}; all numbers must be finite"
        )));
    }
    let last = [m[3], m[7], m[11], m[15]];
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(PyValueError::new_err(format!(
            "the last row of transform {at} is {last:?}; it must be 0, 0, 0, 1 (matrices are for column vectors: transpose them if they are not)"
        )));
    }
    Ok(Transform::from_matrix(m))
}

#[pymethods]
impl PyScene {
    /// Returns the number of the mesh, and where its vertices were moved from: float64 far from the origin would lose
    /// its digits in float32.
    #[pyo3(signature = (vertices, faces, *, two_sided=None, color=None, name=None, opaque=true))]
    #[expect(
        clippy::too_many_arguments,
        reason = "what a mesh may be given, each with its name in Python"
    )]
    fn _add_mesh<'py>(
        &mut self,
        py: Python<'py>,
        vertices: &Bound<'py, PyAny>,
        faces: &Bound<'py, PyAny>,
        two_sided: Option<bool>,
        color: Option<&Bound<'py, PyAny>>,
        name: Option<String>,
        opaque: bool,
    ) -> PyResult<(u32, [f64; 3])> {
        let (vertices, single) = rows::<3>(vertices, "vertices")?;
        let indices = self::faces(faces, "faces", vertices.len())?;
        let color = color.map(|c| row::<4>(c, "color")).transpose()?;
        let (mesh, moved) = py
            .detach(|| {
                let moved = if single { [0.0; 3] } else { centre(&vertices) };
                let near = |v: &[f64; 3]| std::array::from_fn(|a| (v[a] - moved[a]) as f32);
                let material = self.model.materials.len() as u32;
                let triangle_count = (indices.len() / 3) as u32;
                let alpha = if opaque { Alpha::Opaque } else { Alpha::Blended };
                let two_sided = two_sided.unwrap_or(true);
                let part = Part { triangle_count, material, two_sided, alpha, first_triangle: 0 };
                let positions = vertices.iter().map(near).collect();
                Mesh::new(MeshData { positions, indices, parts: vec![part], ..MeshData::default() })
                    .map(|mesh| (mesh, moved))
            })
            .map_err(value_error)?;
        let mut mesh = mesh;
        if two_sided.is_none() {
            // A solid shows its outside alone.
            mesh.set_two_sided(cullet_mesh::solid(&mesh).is_err());
        }
        let name = name.unwrap_or_else(|| format!("mesh {}", self.model.mesh_names.len()));
        let color = color.unwrap_or([0.8, 0.8, 0.8, 1.0]).map(|v| v as f32);
        self.model.materials.push(Material { name: name.clone(), color });
        self.model.mesh_names.push(name);
        Ok((self.model.scene.add_mesh(mesh), moved))
    }

    /// Adds an instance of a mesh for each transform, (n, 4, 4) or (4, 4); returns their ids.
    #[pyo3(signature = (mesh, transforms=None, *, layers=1))]
    fn add_instances<'py>(
        &mut self,
        py: Python<'py>,
        mesh: &Bound<'py, PyAny>,
        transforms: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let mesh = whole::mesh(mesh, self.model.scene.meshes().len())?;
        let transforms = transforms.map(|t| matrices(t, "transforms")).transpose()?;
        let transforms = transforms.unwrap_or_else(|| vec![Transform::IDENTITY.to_matrix()]);
        // All are looked at before any is added.
        let transforms: Vec<Transform> = transforms
            .iter()
            .enumerate()
            .map(|(at, m)| transform(m, at))
            .collect::<PyResult<_>>()?;
        let mut ids = Vec::with_capacity(transforms.len());
        for transform in transforms {
            let instance = Instance { layers, ..Instance::new(mesh, transform) };
            let handle = self.model.scene.add(instance).map_err(value_error)?;
            ids.push(self.note(handle));
        }
        Ok(PyArray1::from_vec(py, ids))
    }

    fn _set_name(&mut self, id: u32, name: String) -> PyResult<()> {
        let index = self.handle(id)?.index as usize;
        let names = &mut self.model.instance_names;
        if names.len() <= index {
            names.resize(index + 1, String::new());
        }
        names[index] = name;
        Ok(())
    }

    /// Moves instances: ``transforms`` is (n, 4, 4), one for each id. All are checked before any is moved.
    fn set_transforms(
        &mut self,
        ids: &Bound<'_, PyAny>,
        transforms: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (ids, matrices) = (self::ids(ids, "ids")?, matrices(transforms, "transforms")?);
        if ids.len() != matrices.len() {
            return Err(PyValueError::new_err(format!(
                "there are {} ids, but {} transforms",
                ids.len(),
                matrices.len()
            )));
        }
        let handles = ids.iter().map(|&id| self.handle(id)).collect::<PyResult<Vec<_>>>()?;
        let transforms: Vec<Transform> =
            matrices.iter().enumerate().map(|(at, m)| transform(m, at)).collect::<PyResult<_>>()?;
        for (handle, transform) in handles.into_iter().zip(transforms) {
            self.model.scene.set_transform(handle, transform).map_err(value_error)?;
        }
        self.model.scene.refit();
        self.model.update_cells();
        Ok(())
    }

    /// Puts instances into layers, a bit each; in none, an instance is never seen.
    fn set_layers(
        &mut self,
        ids: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole::layers)] layers: u32,
    ) -> PyResult<()> {
        let ids = self::ids(ids, "ids")?;
        let handles = ids.iter().map(|&id| self.handle(id)).collect::<PyResult<Vec<_>>>()?;
        for handle in handles {
            self.model.scene.set_layers(handle, layers).map_err(value_error)?;
        }
        Ok(())
    }

    /// Removes instances. Their ids are not given again.
    fn remove(&mut self, ids: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut ids = self::ids(ids, "ids")?;
        ids.sort_unstable();
        ids.dedup();
        let handles = ids.iter().map(|&id| self.handle(id)).collect::<PyResult<Vec<_>>>()?;
        for (id, handle) in ids.into_iter().zip(handles) {
            self.model.scene.remove(handle).map_err(value_error)?;
            self.handles[id as usize] = None;
            self.id_of[handle.index as usize] = crate::scene::NO_ID;
        }
        Ok(())
    }

    /// Sorts instances by place and prepares new meshes: once after much was added or moved far, for speed. Without,
    /// answers are as right, and more is kept of meshes that are new.
    fn commit(&mut self, py: Python<'_>) {
        py.detach(|| {
            let scene = &mut self.model.scene;
            let extent = scene.extent();
            let (centre, reach) = (extent.center(), extent.half_extent());
            if !extent.is_empty() && length(centre) > 8.0 * length(reach) {
                let origin = scene.origin();
                scene.rebase(std::array::from_fn(|a| (centre[a] + origin[a]).round()));
            }
            scene.commit(&engine::Culler::default());
            self.model.update_cells();
        });
    }

    /// Vertices (n, 3) and triangles (m, 3) of a mesh, in its own space.
    fn mesh<'py>(&self, number: &Bound<'py, PyAny>) -> PyResult<Triangles<'py>> {
        let (py, meshes) = (number.py(), self.model.scene.meshes());
        let mesh = &meshes[whole::mesh(number, meshes.len())? as usize];
        let (positions, indices) = (mesh.positions(), mesh.original_indices());
        let triangles = indices.len() / 3;
        Ok((
            shaped(py, positions.as_flattened().to_vec(), &[positions.len(), 3])?,
            shaped(py, indices, &[triangles, 3])?,
        ))
    }

    /// Returns what is left of every instance, in world space: vertices, triangles, and for each
    /// triangle the instance and whether it closes the cut.
    #[pyo3(signature = (planes, *, cap=true, keep="inside"))]
    fn _cut<'py>(
        &self,
        py: Python<'py>,
        planes: &Bound<'py, PyAny>,
        cap: bool,
        keep: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let planes = match numbers(planes, "planes")?.shape[..] {
            [4] => vec![row::<4>(planes, "planes")?],
            _ => rows::<4>(planes, "planes")?.0,
        };
        let planes: Vec<_> =
            planes.iter().map(|&[x, y, z, d]| engine::bounds::Plane::new([x, y, z], d)).collect();
        let keep = match keep {
            "inside" => cullet_cut::Keep::Inside,
            "outside" => cullet_cut::Keep::Outside,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "keep is {keep:?}; it must be \"inside\" or \"outside\""
                )));
            }
        };
        let options =
            cullet_cut::ModelOptions { planes: &planes, keep, caps: cap, ..Default::default() };
        let left = py.detach(|| {
            cullet_cut::cut_model(&self.model, &options, || std::ops::ControlFlow::Continue(()))
                .map(|cut| self.joined(&cut))
        });
        let Joined { positions, indices, ids, caps } = left.map_err(value_error)?;
        let (vertices, triangles) = (positions.len(), ids.len());
        let positions = shaped(py, positions.into_iter().flatten().collect(), &[vertices, 3])?;
        let indices = shaped(py, indices, &[triangles, 3])?;
        let rest = (PyArray1::from_vec(py, ids), PyArray1::from_vec(py, caps));
        Ok((positions, indices, rest.0, rest.1).into_pyobject(py)?.into_any())
    }
}

/// Instances of a cut as one list of triangles.
#[derive(Default)]
struct Joined {
    positions: Vec<[f64; 3]>,
    indices: Vec<u32>,
    ids: Vec<u32>,
    caps: Vec<bool>,
}

impl PyScene {
    fn joined(&self, cut: &cullet_cut::CutModel) -> Joined {
        let (scene, mut out) = (&cut.model.scene, Joined::default());
        // Handles of what is left count up in the order of `origin`.
        let mut slots: Vec<(u32, u32)> =
            scene.slots().filter_map(|slot| Some((scene.handle(slot)?.index, slot))).collect();
        slots.sort_unstable();
        for ((_, slot), origin) in slots.into_iter().zip(&cut.origin) {
            let mesh = scene.mesh(slot);
            let m = scene.transform(slot).to_matrix();
            let world = |p: &[f32; 3]| {
                let p = p.map(f64::from);
                std::array::from_fn(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r])
            };
            // Caps have vertices of their own, for their normals; here they are the same points.
            let mut number = HashMap::new();
            let merged: Vec<u32> = mesh
                .positions()
                .iter()
                .map(|p| {
                    *number.entry(p.map(f32::to_bits)).or_insert_with(|| {
                        out.positions.push(world(p));
                        out.positions.len() as u32 - 1
                    })
                })
                .collect();
            out.indices.extend(mesh.original_indices().iter().map(|&i| merged[i as usize]));
            let id = self.id_of.get(origin.index as usize).copied().unwrap_or(crate::scene::NO_ID);
            let from = &cut.triangles[scene.mesh_id(slot) as usize];
            for triangle in 0..mesh.triangle_count() as usize {
                out.ids.push(id);
                out.caps.push(from.get(triangle) == Some(&cullet_cut::NO_ORIGIN));
            }
        }
        out
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Where a mesh far from the origin is moved from, in whole numbers, so that differences of coordinates stay exact.
fn centre(vertices: &[[f64; 3]]) -> [f64; 3] {
    let ends = |a: usize| {
        let of = || vertices.iter().map(|v| v[a]);
        [of().fold(f64::INFINITY, f64::min), of().fold(f64::NEG_INFINITY, f64::max)]
    };
    let ends: [[f64; 2]; 3] = std::array::from_fn(ends);
    let middle = ends.map(|[low, high]| (low + high) * 0.5);
    let is_far = length(middle) > 8.0 * length(ends.map(|[low, high]| (high - low) * 0.5));
    if vertices.is_empty() || !is_far { [0.0; 3] } else { middle.map(f64::round) }
}
