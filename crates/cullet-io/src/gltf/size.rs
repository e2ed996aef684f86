//! Memory that a file takes once it is loaded, computed from its JSON alone.

use std::collections::HashSet;

use super::json::{self, Index, MeshItem, NodeItem, Root};
use crate::ErrorKind;
use crate::blocks::Source;

/// Counts of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Instances of meshes.
    pub instances: u64,
    /// Vertices of the meshes, each once.
    pub vertices: u64,
    /// Triangles of the meshes, each once.
    pub triangles: u64,
}

/// How much a glTF or GLB takes at the most, by the counts of its accessors: the binary chunk of a
/// GLB is not read. `None` where that cannot be told from them: of meshes that deform, of which
/// each node has its own, and of baked levels.
///
/// # Errors
/// If there is no JSON to be read, or what is needed of it is invalid.
pub fn counts(source: &Source<'_>) -> Result<Option<Counts>, ErrorKind> {
    let (bytes, json) = super::json_of(source)?;
    let root = json::parse(bytes.get(json).unwrap_or_default())?;
    let is_baked = root.extensions.is_some_and(|e| e.text().contains(super::BAKED));
    if is_baked || root.skins.is_some() {
        return Ok(None);
    }
    let accessors = accessor_counts(&root)?;
    let mut counts = Counts::default();
    for (i, raw) in json::all(&root.meshes).iter().enumerate() {
        let mesh: MeshItem<'_> = json::item(*raw, "mesh", i)?;
        // Positions that several primitives name are there once.
        let mut known = HashSet::new();
        for primitive in &mesh.primitives {
            if !primitive.targets.is_empty() {
                return Ok(None);
            }
            let count = |index: Index| accessors.get(index.index()).copied().unwrap_or(0);
            let Some(places) = primitive.attributes.get("POSITION") else { continue };
            if known.insert(places.index()) {
                counts.vertices = counts.vertices.saturating_add(count(places));
            }
            let corners = primitive.indices.map_or_else(|| count(places), count);
            counts.triangles += match primitive.mode.map_or(4, |mode| mode.0) {
                4 => corners / 3,
                5 | 6 => corners.saturating_sub(2),
                _ => 0,
            };
        }
    }
    for (i, raw) in json::all(&root.nodes).iter().enumerate() {
        let node: NodeItem<'_> = json::item(*raw, "node", i)?;
        if node.mesh.is_none() {
            continue;
        }
        let many = node.instancing.map(|of| {
            let counts = of.attributes.0.iter().filter_map(|(_, to)| accessors.get(to.index()));
            counts.copied().max().unwrap_or(0)
        });
        counts.instances = counts.instances.saturating_add(many.unwrap_or(1));
    }
    Ok(Some(counts))
}

/// How many elements each accessor has.
fn accessor_counts(root: &Root<'_>) -> Result<Vec<u64>, ErrorKind> {
    let mut counts = Vec::new();
    for (i, json) in json::all(&root.accessors).iter().enumerate() {
        let item: json::AccessorItem<'_> = json::item(*json, "accessor", i)?;
        counts.push(item.count.0);
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(json: &str) -> Option<Counts> {
        counts(&Source::memory(json.as_bytes())).unwrap()
    }

    const ACCESSORS: &str = r#""accessors":[{"componentType":5126,"count":8,"type":"VEC3"},{"componentType":5125,"count":36,"type":"SCALAR"},
        {"componentType":5126,"count":5,"type":"VEC3"}]"#;

    #[test]
    fn counts_are_those_of_the_accessors() {
        let meshes = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":5},
            {"attributes":{"POSITION":2},"mode":1}]}]"#;
        let nodes = r#""nodes":[{"mesh":0},{},{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}]"#;
        let text = format!(r#"{{"asset":{{"version":"2.0"}},{ACCESSORS},{meshes},{nodes}}}"#);
        let expected = Counts { instances: 1 + 5, vertices: 8 + 5, triangles: 12 + 6 };
        assert_eq!(of(&text), Some(expected));
    }

    #[test]
    fn what_deforms_or_is_baked_is_left_to_who_loads_it() {
        let with = |rest: &str| format!(r#"{{"asset":{{"version":"2.0"}},{ACCESSORS},{rest}}}"#);
        let morph = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":2}]}]}]"#;
        for rest in [morph, r#""skins":[{"joints":[0]}]"#, r#""extensions":{"CULLET_baked":{}}"#] {
            assert_eq!(of(&with(rest)), None, "{rest}");
        }
        let broken = with(r#""meshes":[{"primitives":3}]"#);
        assert!(counts(&Source::memory(broken.as_bytes())).is_err());
    }
}
