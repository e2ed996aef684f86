//! Records of the meshes of a model.

use cullet_io::{MeshFacts, Model, mesh_facts};

use crate::record::{MeshRecord, SceneRecord};
use crate::survey::MeshTally;

/// Facts of each mesh that no view changes, in the order of the scene, without meshes that only
/// hold levels of others. Costs a sort of all edges.
pub(crate) fn facts(model: &Model) -> Vec<MeshRecord> {
    let record = |facts: MeshFacts| MeshRecord {
        mesh: facts.mesh,
        name: facts.name,
        triangles: facts.triangles,
        polygons: facts.polygons,
        instances: facts.instances,
        solid: facts.solid,
        defect: facts.defect,
        sides: facts.sides,
        misoriented: facts.misoriented,
        degenerate: facts.degenerate,
        duplicate: facts.duplicate,
        views_kept: 0,
        views_seen: 0,
        drawn: 0,
        visible: 0,
        facing_away: 0,
    };
    mesh_facts(model).into_iter().map(record).collect()
}

/// Adds what the views found, and puts the meshes that waste the most first.
pub(crate) fn with_tallies(facts: &[MeshRecord], tallies: &[MeshTally]) -> Vec<MeshRecord> {
    let mut meshes: Vec<MeshRecord> = facts
        .iter()
        .map(|m| (m, &tallies[m.mesh as usize]))
        .map(|(m, t)| MeshRecord {
            views_kept: t.kept,
            views_seen: t.seen,
            drawn: t.drawn,
            visible: t.visible,
            facing_away: t.facing_away,
            ..m.clone()
        })
        .collect();
    meshes.sort_by_key(|m| (std::cmp::Reverse(m.drawn.saturating_sub(m.visible)), m.mesh));
    meshes
}

/// Counts of a scene.
pub(crate) fn scene_record(model: &Model, facts: &[MeshRecord]) -> SceneRecord {
    let scene = &model.scene;
    SceneRecord {
        name: model.name.clone(),
        meshes: facts.len() as u64,
        instances: u64::from(scene.instance_count()),
        triangles: scene.triangle_count(),
        unique_triangles: facts.iter().map(|m| m.triangles).sum(),
        polygons: facts.iter().map(|m| m.polygons * m.instances).sum(),
        solids: facts.iter().filter(|m| m.solid).count() as u64,
        materials: model.materials.len() as u64,
        cameras: model.cameras.len() as u64,
        extent: cullet_io::extent(scene),
        warnings: model.warnings.iter().map(ToString::to_string).collect(),
    }
}
