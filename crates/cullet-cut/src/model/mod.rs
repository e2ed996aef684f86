//! Cuts of whole models.

mod caps;
mod instance;
mod options;
mod place;
mod report;

use std::ops::ControlFlow;

use cullet::{Handle, Instance, Scene, SceneError};
use cullet_io::{Attributes, Material, Model, NodeTree};
use thiserror::Error;

pub use instance::Section;
pub use options::ModelOptions;
pub use report::{ModelReport, OpenMesh};

use crate::options::{CutError, Keep};
use crate::sides;
use instance::InstanceCut;
use place::{Place, place};

/// The colour of caps: the red of cut faces in drawings.
const CUT_FACE: [f32; 4] = [0.50, 0.065, 0.04, 1.0];

/// A model after a cut.
#[derive(Debug)]
pub struct CutModel {
    /// Its own scene, committed, with the names, materials, cameras and nodes of what it was cut
    /// from, and one more material, `cut face`, where there are caps.
    pub model: Model,
    /// The figures of the cut.
    pub report: ModelReport,
    /// The outlines, where they are wanted.
    pub sections: Vec<Section>,
    /// Original instance of each remaining instance, by the index of its handle.
    pub origin: Vec<Handle>,
    /// For each mesh of what is left, which original triangle each of its triangles is of,
    /// [`NO_ORIGIN`](crate::NO_ORIGIN) in caps; empty where the mesh is whole.
    pub triangles: Vec<Vec<u32>>,
    /// The material of caps.
    pub cap_material: u32,
}

/// Why a model cannot be cut.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A plane is none, or there are too many.
    #[error(transparent)]
    Planes(CutError),
    /// A mesh cannot be cut, or what is left of it is no mesh.
    #[error("mesh `{name}`: {what}")]
    Mesh {
        /// Its name.
        name: String,
        /// The defect.
        what: String,
    },
    /// The instances that are left cannot be a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The cut goes through more triangles than [`ModelOptions::most_triangles`].
    #[error(
        "the cut goes through instances with {triangles} triangles, more than {limit}; cut elsewhere or less"
    )]
    TooLarge {
        /// Triangles of the instances that planes go through.
        triangles: u64,
        /// How many may be.
        limit: u64,
    },
    /// The caller's function said so.
    #[error("stopped before all instances were cut")]
    Stopped,
}

/// Cuts every instance of a model, in the order of their handles. Those that no plane touches stay
/// as they are and go on sharing their mesh; each that one touches becomes a mesh of its own.
/// Whether one does is decided by the box of its mesh, whatever its bounds were set to. An empty
/// result is a value. What moves does so no longer, and warnings, views and cells stay behind.
///
/// `each` is called when an instance is done; it may stop the work. Costs
/// [`cut_mesh`](crate::cut_mesh) for each instance that planes touch.
///
/// ```
/// use std::ops::ControlFlow;
/// use cullet::bounds::Plane;
/// use cullet_cut::{ModelOptions, cut_model};
///
/// let model = cullet_scenes::build("solids")?;
/// let planes = [Plane::new([0.0, 0.0, 1.0], 0.0)];
/// let options = ModelOptions { planes: &planes, caps: true, ..ModelOptions::default() };
/// let half = cut_model(&model, &options, || ControlFlow::Continue(()))?;
/// assert!(half.report.cap_triangles > 0 && half.report.open_edges == 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a plane is none, a mesh cannot be cut, the limit on triangles is passed, or `each` stops it.
pub fn cut_model(
    model: &Model,
    options: &ModelOptions<'_>,
    mut each: impl FnMut() -> ControlFlow<()>,
) -> Result<CutModel, ModelError> {
    sides::prepare(options.planes).map_err(ModelError::Planes)?;
    let scene = &model.scene;
    within_limit(scene, options)?;
    let mut out = Model {
        name: model.name.clone(),
        materials: model.materials.clone(),
        cameras: model.cameras.clone(),
        node_tree: NodeTree { node_of_instance: Vec::new(), ..model.node_tree.clone() },
        ..Model::default()
    };
    out.scene = Scene::new();
    out.scene.rebase(scene.origin());
    let cap_material = out.materials.len() as u32;
    let mut report = ModelReport {
        triangles_before: scene.triangle_count(),
        instances_before: u64::from(scene.instance_count()),
        ..ModelReport::default()
    };
    let mut sections = Vec::new();
    let mut shared = vec![None; scene.meshes().len()];
    let inside = options.keep == Keep::Inside;
    let none = Attributes::default();
    // In the order of the file: slots are sorted by place.
    let mut handles: Vec<Handle> = scene.slots().filter_map(|s| scene.handle(s)).collect();
    handles.sort_unstable_by_key(|h| h.index);
    let mut origin = Vec::new();
    let mut triangles = Vec::new();
    for handle in handles {
        let Ok(slot) = scene.slot(handle) else { continue };
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let number = scene.mesh_id(slot) as usize;
        let name = model.mesh_names.get(number).cloned().unwrap_or_default();
        let attributes = model.attributes.get(number).unwrap_or(&none);
        let id = match place(mesh, transform, options.planes) {
            Place::Touched(planes) => {
                let cap = options.caps && !is_shell(scene, slot, options.hollow);
                let cut = InstanceCut {
                    options,
                    cap,
                    mesh,
                    number,
                    name: &name,
                    attributes,
                    transform,
                    planes: &planes,
                };
                let left = cut.run(cap_material, &mut report, &mut sections);
                let left = left.map_err(|what| ModelError::Mesh { name: name.clone(), what })?;
                left.map(|left| {
                    report.instances_cut += 1;
                    out.mesh_names.push(name);
                    out.attributes.push(left.attributes);
                    triangles.push(left.origin);
                    out.scene.add_mesh(left.mesh)
                })
            }
            side if matches!(side, Place::Inside) == inside => {
                report.instances_untouched += 1;
                Some(*shared[number].get_or_insert_with(|| {
                    out.mesh_names.push(name);
                    out.attributes.push(attributes.clone());
                    triangles.push(Vec::new());
                    out.scene.add_mesh(mesh.clone())
                }))
            }
            _ => None,
        };
        if let Some(id) = id {
            let (layers, flags) = (scene.layers(slot), scene.flags(slot));
            out.scene.add(Instance { layers, flags, ..Instance::new(id, *transform) })?;
            out.instance_names.push(model.instance_name(handle).into());
            origin.push(handle);
            // Handles count up from 0 in the order of adding.
            let node = model.node_tree.node_of_instance.get(handle.index as usize);
            out.node_tree.node_of_instance.push(node.copied().unwrap_or(NodeTree::NONE));
        } else {
            report.instances_dropped += 1;
        }
        if each().is_break() {
            return Err(ModelError::Stopped);
        }
    }
    if report.cap_triangles > 0 {
        out.materials.push(Material { name: "cut face".into(), color: CUT_FACE });
    }
    // Meshes are not prepared: only a caller who culls the cut model needs that.
    out.scene.sort();
    report.triangles_after = out.scene.triangle_count();
    Ok(CutModel { model: out, report, sections, origin, triangles, cap_material })
}

/// Whether the planes go through no more than they may.
fn within_limit(scene: &Scene, options: &ModelOptions<'_>) -> Result<(), ModelError> {
    let Some(limit) = options.most_triangles else { return Ok(()) };
    let touched = |&slot: &u32| {
        matches!(place(scene.mesh(slot), scene.transform(slot), options.planes), Place::Touched(_))
    };
    let count = |slot| u64::from(scene.mesh(slot).triangle_count());
    let triangles: u64 = scene.slots().filter(touched).map(count).sum();
    if triangles > limit { Err(ModelError::TooLarge { triangles, limit }) } else { Ok(()) }
}

/// Whether an instance is no solid and lies around a point in the open.
fn is_shell(scene: &Scene, slot: u32, hollow: Option<[f64; 3]>) -> bool {
    let around = |p: [f64; 3]| {
        let (b, origin) = (scene.bounds(slot), scene.origin());
        (0..3).all(|i| (f64::from(b.min[i])..=f64::from(b.max[i])).contains(&(p[i] - origin[i])))
    };
    hollow.is_some_and(around) && cullet_mesh::solid(scene.mesh(slot)).is_err()
}
