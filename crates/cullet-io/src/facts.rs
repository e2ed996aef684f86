//! Facts of a model that no view changes: counts of its meshes and of instances that need a note.

use std::collections::HashSet;

use cullet::mesh::Alpha;
use cullet::{Mesh, Scene};
use cullet_mesh::{Topology, solid};
use serde::Serialize;

use crate::Model;

/// Facts of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshFacts {
    /// The mesh's number in the scene.
    pub mesh: u32,
    /// Name, or `mesh` and its number where it has none.
    pub name: String,
    /// Triangles stored, degenerate ones included.
    pub triangles: u64,
    /// Polygons that the triangles come from.
    pub polygons: u64,
    /// Instances of the mesh.
    pub instances: u64,
    /// Whether it is an opaque closed body wound outward.
    pub solid: bool,
    /// Why it is not a solid.
    pub defect: Option<String>,
    /// `one-sided`, `two-sided` or `mixed`.
    pub sides: &'static str,
    /// Edges along which two triangles are wound against each other.
    pub misoriented: u32,
    /// Triangles without area.
    pub degenerate: u64,
    /// Triangles with the same three corners as an earlier one, degenerate ones aside.
    pub duplicate: u64,
}

/// Counts of instances that need a note.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct InstanceFacts {
    /// Instances whose transform mirrors.
    pub mirrored: u64,
    /// Instances with a transform that is not finite.
    pub non_finite: u64,
    /// Instances of finite transforms that every view keeps for want of bounds.
    pub unbounded: u64,
    /// Instances scaled to nothing along an axis.
    pub singular: u64,
}

/// Returns the facts of each mesh in the order of the scene, without meshes that only hold levels
/// of others. Costs a sort of all edges.
#[must_use]
pub fn mesh_facts(model: &Model) -> Vec<MeshFacts> {
    let scene = &model.scene;
    let mut instances = vec![0u64; scene.meshes().len()];
    scene.slots().for_each(|s| instances[scene.mesh_id(s) as usize] += 1);
    let holds_levels = level_holders(scene);
    let fact = |(i, mesh): (usize, &Mesh)| {
        let topology = Topology::of_mesh(mesh);
        let opaque = mesh.parts().iter().all(|p| p.alpha == Alpha::Opaque);
        // As `solid`, without sorting the edges a second time.
        let defect = if opaque {
            topology.solid().err().map(|e| e.to_string())
        } else {
            solid(mesh).err().map(|e| e.to_string())
        };
        MeshFacts {
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
        }
    };
    scene.meshes().iter().enumerate().filter(|m| !holds_levels[m.0]).map(fact).collect()
}

/// Counts the instances of a scene that need a note. O(instances).
#[must_use]
pub fn instance_facts(scene: &Scene) -> InstanceFacts {
    let mut facts = InstanceFacts::default();
    for slot in scene.slots() {
        let transform = scene.transform(slot);
        if !transform.is_finite() {
            facts.non_finite += 1;
            continue;
        }
        let determinant = transform.determinant();
        facts.mirrored += u64::from(determinant < 0.0);
        facts.singular += u64::from(determinant == 0.0);
        facts.unbounded += u64::from(!scene.bounds(slot).is_finite());
    }
    facts
}

/// Returns for each mesh of a scene whether it only holds levels of another: no instance shows it.
#[must_use]
pub fn level_holders(scene: &Scene) -> Vec<bool> {
    let mut holds = vec![false; scene.meshes().len()];
    for mesh in 0..scene.meshes().len() as u32 {
        scene.levels(mesh).iter().for_each(|levels| holds[levels.mesh as usize] = true);
    }
    scene.slots().for_each(|slot| holds[scene.mesh_id(slot) as usize] = false);
    holds
}

/// Returns the name of a mesh, or `mesh` and its number where it has none.
#[must_use]
pub fn mesh_name(model: &Model, mesh: u32) -> String {
    match model.mesh_names.get(mesh as usize) {
        Some(name) if !name.is_empty() => name.clone(),
        _ => format!("mesh {mesh}"),
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
    let mut seen: HashSet<[[u32; 3]; 3]> = HashSet::with_capacity(drawn as usize);
    let mut twice = 0;
    for t in 0..drawn {
        // Adding zero makes −0 into 0, which is the same place.
        let mut key = mesh.corners(t).map(|c| c.map(|v| (v + 0.0).to_bits()));
        key.sort_unstable();
        twice += u64::from(!seen.insert(key));
    }
    twice
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, MeshData, Transform};

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

    #[test]
    fn each_instance_that_needs_a_note_is_counted_for_its_own_reason() {
        let mut scene = Scene::new();
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let data = MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() };
        let mesh = scene.add_mesh(Mesh::new(data).unwrap());
        for (scale, x) in [
            ([1.0, 1.0, 1.0], 0.0),
            ([2.0, 3.0, 4.0], 5.0),
            ([-1.0, 1.0, 1.0], 0.0),
            ([1.0, 0.0, 1.0], 0.0),
            ([1.0, 1.0, 1.0], f64::NAN),
            ([1.0, 1.0, 1.0], 1e19),
            ([1.0, -1.0, 1.0], -1e19),
        ] {
            let transform = Transform::from_scale_translation(scale, [x, 0.0, 0.0]);
            scene.add(Instance::new(mesh, transform)).unwrap();
        }
        let facts = instance_facts(&scene);
        let expected = InstanceFacts { mirrored: 2, non_finite: 1, unbounded: 2, singular: 1 };
        assert_eq!(facts, expected);
    }
}
