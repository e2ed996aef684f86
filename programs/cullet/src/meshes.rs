//! Records of the meshes of a model.

use std::collections::HashMap;

use cullet::Mesh;
use cullet::mesh::Alpha;
use cullet_io::Model;
use cullet_mesh::{Topology, solid};

use crate::names::mesh_name;
use crate::record::{MeshRecord, SceneRecord};
use crate::survey::MeshTally;

/// Facts of each mesh that no view changes; in the order of the scene, without those that hold
/// levels of others. Costs a sort of all edges.
pub(crate) fn facts(model: &Model) -> Vec<MeshRecord> {
    let scene = &model.scene;
    let mut instances = vec![0u64; scene.meshes().len()];
    scene.slots().for_each(|s| instances[scene.mesh_id(s) as usize] += 1);
    let holds_levels = crate::levels::holders(scene);
    let fact = |(i, mesh): (usize, &Mesh)| {
        let topology = Topology::of_mesh(mesh);
        let opaque = mesh.parts().iter().all(|p| p.alpha == Alpha::Opaque);
        // As `solid`, without sorting the edges a second time.
        let defect = if opaque {
            topology.solid().err().map(|e| e.to_string())
        } else {
            solid(mesh).err().map(|e| e.to_string())
        };
        MeshRecord {
            mesh: i as u32,
            name: mesh_name(model, i as u32),
            triangles: u64::from(mesh.triangle_count()),
            polygons: u64::from(mesh.polygon_count()),
            instances: instances[i],
            solid: defect.is_none(),
            defect,
            sides: sides(mesh),
            misoriented: topology.misoriented_edges,
            degenerate: u64::from(mesh.degenerate_count()),
            duplicate: duplicates(mesh),
            views_kept: 0,
            views_seen: 0,
            drawn: 0,
            visible: 0,
            facing_away: 0,
        }
    };
    // What holds the levels of others is no mesh of its own.
    scene.meshes().iter().enumerate().filter(|m| !holds_levels[m.0]).map(fact).collect()
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

fn sides(mesh: &Mesh) -> &'static str {
    let two = mesh.parts().iter().filter(|p| p.two_sided && p.triangle_count > 0).count();
    let one = mesh.parts().iter().filter(|p| !p.two_sided && p.triangle_count > 0).count();
    match (one, two) {
        (_, 0) => "one-sided",
        (0, _) => "two-sided",
        _ => "mixed",
    }
}

/// Triangles with the same three corners as an earlier one, whichever way they are wound;
/// degenerate ones aside.
fn duplicates(mesh: &Mesh) -> u64 {
    let drawn = mesh.triangle_count() - mesh.degenerate_count();
    let mut seen: HashMap<[[u32; 3]; 3], ()> = HashMap::with_capacity(drawn as usize);
    let mut twice = 0;
    for t in 0..drawn {
        // Adding zero makes −0 into 0, which is the same place.
        let mut key = mesh.corners(t).map(|c| c.map(|v| (v + 0.0).to_bits()));
        key.sort_unstable();
        twice += u64::from(seen.insert(key, ()).is_some());
    }
    twice
}

#[cfg(test)]
mod tests {
    use cullet::MeshData;

    use super::*;

    #[test]
    fn duplicates_are_found_by_place_not_by_index() {
        let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut positions = p.to_vec();
        positions.extend([[-0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let indices = vec![0, 1, 2, 5, 4, 3, 0, 1, 6];
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        assert_eq!(duplicates(&mesh), 1);
        assert_eq!(sides(&mesh), "two-sided");
    }
}
