//! Contents of a model and its defects, as `cullet info --json` gives them.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use cullet_io::{InstanceFacts, MeshFacts, Model, instance_facts, mesh_facts};
use serde::Serialize;

use crate::fault::{Code, Fault};
use crate::files::read;

/// Version of the record, which is that of the program `cullet`.
const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Record {
    schema: u32,
    scene: Scene,
    cameras: Vec<String>,
    cells: usize,
    portals: usize,
    mirrored_instances: u64,
    non_finite_instances: u64,
    unbounded_instances: u64,
    singular_instances: u64,
    groups: Option<Groups>,
    /// Whether something is baked in the file; the program tells what.
    is_baked: bool,
    meshes: Vec<MeshFacts>,
}

#[derive(Serialize)]
struct Scene {
    name: String,
    meshes: usize,
    instances: u64,
    triangles: u64,
    unique_triangles: u64,
    polygons: u64,
    solids: usize,
    materials: usize,
    cameras: usize,
    extent: Option<[[f64; 3]; 2]>,
    warnings: Vec<String>,
}

/// The node tree of the file.
#[derive(Serialize)]
struct Groups {
    nodes: usize,
    empty: usize,
    depth: usize,
    widest: usize,
}

/// Reads a file with the files that it names, and returns counts, sizes and defects as JSON.
///
/// # Errors
/// If the file, or one that it names, is missing, of no known kind, invalid or over a limit.
pub fn info(name: &str, bytes: &[u8], beside: &[(String, Vec<u8>)]) -> Result<String, Fault> {
    let model = read(name, bytes, beside)?;
    serde_json::to_string(&record(&model)).map_err(|error| Fault::new(Code::File, error))
}

fn record(model: &Model) -> Record {
    let scene = &model.scene;
    let meshes = mesh_facts(model);
    let InstanceFacts { mirrored, non_finite, unbounded, singular } = instance_facts(scene);
    let tree = Some(&model.node_tree).filter(|tree| !tree.is_empty());
    let groups = tree.and_then(|_| model.node_tree_statistics());
    Record {
        schema: SCHEMA,
        scene: Scene {
            name: model.name.clone(),
            meshes: meshes.len(),
            instances: u64::from(scene.instance_count()),
            triangles: scene.triangle_count(),
            unique_triangles: meshes.iter().map(|m| m.triangles).sum(),
            polygons: meshes.iter().map(|m| m.polygons * m.instances).sum(),
            solids: meshes.iter().filter(|m| m.solid).count(),
            materials: model.materials.len(),
            cameras: model.cameras.len(),
            extent: cullet_io::extent(scene),
            warnings: model.warnings.iter().map(ToString::to_string).collect(),
        },
        cameras: model.cameras.iter().map(|camera| camera.name.clone()).collect(),
        cells: model.cells.cells.len(),
        portals: model.cells.portals.len(),
        mirrored_instances: mirrored,
        non_finite_instances: non_finite,
        unbounded_instances: unbounded,
        singular_instances: singular,
        groups: groups.map(|g| Groups {
            nodes: g.nodes,
            empty: g.empty,
            depth: g.depth,
            widest: g.widest,
        }),
        is_baked: model.baked.is_some(),
        meshes,
    }
}
