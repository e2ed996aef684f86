//! Levels of one mesh.

use std::collections::HashMap;

use cullet::mesh::{Part, weld};
use cullet::{Mesh, MeshData};
use cullet_bake::levels::{
    ChainOptions, HierarchyOptions, LevelsData, LevelsError, VertexValues, build_chain,
    build_hierarchy,
};
use cullet_cli::levels::LEVELS_VERSION;
use cullet_io::Attributes;
use cullet_io::baked::{ClusterRow, LevelKind, LevelTables, Measured, hash};

/// Meshes of no more triangles have no hierarchy: little of them is far from the rest.
const SMALL: u32 = 5000;

/// The kinds of levels that a mesh of so many triangles has.
pub(super) fn kinds(triangles: u32) -> impl Iterator<Item = LevelKind> {
    let hierarchy = (triangles > SMALL).then_some(LevelKind::Hierarchy);
    let chain = (triangles > 1).then_some(LevelKind::Chain);
    chain.into_iter().chain(hierarchy)
}

/// How errors of a kind of levels are measured.
pub(super) fn measured(kind: LevelKind) -> Measured {
    match kind {
        // `build_chain` has no choice: the error of a level is the largest of all distances that
        // were measured.
        LevelKind::Chain => Measured {
            points: 1,
            reverse_points: 4,
            quantile: 1.0,
            most_over: 1.0,
            seed: 0x6c65_7665_6c73,
        },
        LevelKind::Hierarchy | LevelKind::Impostor => {
            let options = HierarchyOptions::default();
            Measured {
                points: options.points,
                reverse_points: options.reverse_points,
                quantile: 1.0,
                most_over: 1.0,
                seed: options.seed,
            }
        }
    }
}

/// A mesh, as levels are made of it.
#[derive(Debug)]
pub(super) struct Source {
    data: MeshData,
    attributes: Attributes,
}

impl Source {
    /// Prepares a mesh as it stands, without the triangles that have no area and that no level
    /// draws.
    pub(super) fn new(mesh: &Mesh, attributes: Option<&Attributes>) -> Self {
        let mut data = MeshData { deformable: false, polygons: 0, ..mesh.to_data() };
        if mesh.is_deformable() {
            // It stands now, so that what has no area never will.
            if let Ok(rigid) = Mesh::new(data.clone()) {
                without_degenerate(&mut data, &rigid);
            }
        } else {
            without_degenerate(&mut data, mesh);
        }
        let vertices = data.positions.len();
        let fits = |a: &&Attributes| {
            [a.normals.len(), a.uvs.len(), a.colors.len()]
                .iter()
                .all(|&count| count == 0 || count == vertices)
        };
        Self { data, attributes: attributes.filter(fits).cloned().unwrap_or_default() }
    }

    /// Sum of all that the levels of a kind are a function of.
    pub(super) fn key(&self, kind: LevelKind) -> u64 {
        let settings = match kind {
            LevelKind::Chain => format!("{:?}", ChainOptions::default()),
            LevelKind::Hierarchy | LevelKind::Impostor => {
                format!("{:?}", HierarchyOptions::default())
            }
        };
        let version = (LEVELS_VERSION, env!("CARGO_PKG_VERSION"), kind.name(), settings);
        let floats = |values: &[f32]| -> u64 {
            hash(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
        };
        let ints = |values: &mut dyn Iterator<Item = u32>| -> u64 {
            hash(&values.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
        };
        let sums = [
            hash(format!("{version:?}").as_bytes()),
            floats(self.data.positions.as_flattened()),
            ints(&mut self.data.indices.iter().copied()),
            ints(&mut self.data.parts.iter().map(|p| p.triangle_count)),
            self.attributes.stride() as u64,
            floats(&self.attributes.interleaved()),
        ];
        hash(&sums.map(u64::to_le_bytes).concat())
    }

    /// Levels of a kind; `None` where the mesh cannot be simplified.
    pub(super) fn build(
        &self,
        kind: LevelKind,
        threads: usize,
    ) -> Result<Option<LevelTables>, LevelsError> {
        let made = match kind {
            LevelKind::Chain => {
                let same = if self.attributes.is_empty() { Vec::new() } else { self.same() };
                let mut options = ChainOptions::default();
                options.within.same = &same;
                build_chain(&self.data, &options)?
            }
            // No job is of impostors: they are made beside what these make.
            LevelKind::Impostor => return Ok(None),
            LevelKind::Hierarchy => {
                let values = self.attributes.interleaved();
                let seams = VertexValues { values: &values, count: self.attributes.stride() };
                let seams = (!self.attributes.is_empty()).then_some(seams);
                let options = HierarchyOptions { threads, ..HierarchyOptions::default() };
                build_hierarchy(&self.data, seams, &options)?
            }
        };
        Ok((!made.groups.is_empty()).then(|| tables(&made)))
    }

    /// For each vertex the first one of the same position and attributes.
    fn same(&self) -> Vec<u32> {
        let by_position = weld(&self.data.positions);
        let (numbers, stride) = (self.attributes.interleaved(), self.attributes.stride());
        let key = |v: usize| -> Vec<u32> {
            let own = &numbers[v * stride..(v + 1) * stride];
            // Adding 0 turns −0 into 0.
            let own = own.iter().map(|n| (n + 0.0).to_bits());
            std::iter::once(by_position[v]).chain(own).collect()
        };
        let mut first: HashMap<Vec<u32>, u32> = HashMap::with_capacity(by_position.len());
        (0..by_position.len()).map(|v| *first.entry(key(v)).or_insert(v as u32)).collect()
    }
}

/// Takes the degenerate triangles of a mesh out of its data.
fn without_degenerate(data: &mut MeshData, mesh: &Mesh) {
    let count = mesh.triangle_count() as usize;
    let clustered = count - mesh.degenerate_count() as usize;
    if clustered == count {
        return;
    }
    let mut drawn = vec![false; count];
    mesh.original_triangle()[..clustered].iter().for_each(|&t| drawn[t as usize] = true);
    let all = std::mem::take(&mut data.indices);
    let mut first_triangle = 0;
    for part in &mut data.parts {
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        for t in range.map(|t| t as usize).filter(|&t| drawn[t]) {
            data.indices.extend_from_slice(&all[t * 3..][..3]);
        }
        let end = (data.indices.len() / 3) as u32;
        *part = Part { first_triangle, triangle_count: end - first_triangle, ..*part };
        first_triangle = end;
    }
}

/// Converts levels to tables: triangles in the order of the clusters, clusters in that of the
/// parts.
fn tables(levels: &LevelsData) -> LevelTables {
    let clusters = &levels.clustering.clusters;
    let mut order: Vec<u32> = (0..clusters.len() as u32).collect();
    order.sort_by_key(|&c| clusters[c as usize].part);
    let mut out = LevelTables {
        parts: vec![0; levels.mesh.parts.len()],
        groups: levels.groups.clone(),
        ..LevelTables::default()
    };
    for cluster in order {
        let at = cluster as usize;
        let first_triangle = (out.indices.len() / 3) as u32;
        out.indices.extend(levels.cluster_indices(cluster));
        let triangle_count = clusters[at].triangle_count;
        out.parts[clusters[at].part as usize] += triangle_count;
        out.clusters.push(ClusterRow {
            first_triangle,
            triangle_count,
            made_from: levels.made_from[at],
            replaced_by: levels.replaced_by[at],
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::{meshes, soups};

    #[test]
    fn triangles_without_area_are_in_no_level_and_parts_stay() {
        let (positions, mut indices) = soups::ball(12, 24);
        let good = indices.len() as u32 / 3;
        indices.splice(0..0, [0, 0, 1]);
        indices.extend([5, 6, 6, 7, 7, 7]);
        let part = |first_triangle, triangle_count, material| Part {
            first_triangle,
            triangle_count,
            material,
            ..Part::default()
        };
        let parts = vec![part(0, 1, 0), part(1, good, 1), part(1 + good, 2, 2)];
        let data = MeshData { positions, indices, parts, ..MeshData::default() };
        let mesh = Mesh::new(data).expect("valid");
        let source = Source::new(&mesh, None);
        assert_eq!(source.data.indices.len(), good as usize * 3);
        let made = source.build(LevelKind::Chain, 1).expect("valid").expect("fewer triangles");
        assert_eq!((made.parts[0], made.parts[2]), (0, 0));
        assert!(made.parts[1] > good);
        let (held_by, levels) = made.clone().build(&mesh).expect("levels");
        assert_eq!(held_by.parts()[1].material, 1);
        assert_eq!(LevelTables::of(&held_by, &levels), Some(made));
    }

    #[test]
    fn keys_differ_by_kind_mesh_and_attributes() {
        let mesh = meshes::tetrahedron();
        let normals = vec![[0.0, 1.0, 0.0]; mesh.positions().len()];
        let attributes = Attributes { normals, ..Attributes::default() };
        let plain = Source::new(&mesh, None);
        let keys = [
            plain.key(LevelKind::Chain),
            plain.key(LevelKind::Hierarchy),
            Source::new(&mesh, Some(&attributes)).key(LevelKind::Chain),
        ];
        assert!(keys[0] != keys[1] && keys[0] != keys[2]);
        assert_eq!(Source::new(&mesh, None).key(LevelKind::Chain), keys[0]);
    }
}
