//! The hierarchy of clusters: groups of clusters are simplified to half and cut into clusters
//! again, level by level.
//!
//! Vertices that two groups share stay, so groups meet without cracks whichever of them are drawn.
//! After Ponchio & Scopigno and others, *Batched Multi Triangulation*, 2005, and Karis, Stubbe &
//! Wihlidal, *A Deep Dive into Nanite Virtualized Geometry*, 2021; the simplifier's estimate of the
//! error is replaced by measuring.

use cullet::MeshData;
use cullet::mesh::{Clustering, MeshError, Part};

use super::attributes::{VertexValues, check_attributes, checked_extent};
use super::data::{Group, LevelsData, NO_GROUP};
use super::error::LevelsError;
use super::options::HierarchyOptions;
use super::part::{PartLevels, PartSurface, build_part};

use super::weld::Welded;

impl HierarchyOptions {
    fn check(&self) -> Result<(), LevelsError> {
        let range = |what, value: f64, least: f64, most: f64, allowed| {
            if value >= least && value <= most {
                return Ok(());
            }
            Err(LevelsError::Value { what, value, allowed })
        };
        let triangles = f64::from(self.cluster_triangles);
        let allowed = "a multiple of 4 from 8 to 124";
        range("cluster_triangles", triangles, 8.0, 124.0, allowed)?;
        if !self.cluster_triangles.is_multiple_of(4) {
            let (what, value) = ("cluster_triangles", triangles);
            return Err(LevelsError::Value { what, value, allowed });
        }
        range("group_clusters", self.group_clusters.into(), 2.0, 64.0, "2 to 64")?;
        range("points", self.points.into(), 0.0, 64.0, "0 to 64")?;
        range("reverse_points", self.reverse_points.into(), 0.0, 64.0, "0 to 64")?;
        range("threads", self.threads as f64, 1.0, 1024.0, "1 to 1024")
    }
}

/// The most triangles of a mesh: all levels together must have fewer than 2³² / 3, even where
/// little is gained.
const MOST_TRIANGLES: usize = 200_000_000;

/// Makes a hierarchy of clusters of each part of a mesh.
///
/// Vertices keep their numbers, so attributes go with them. Those at one position are one vertex,
/// named by the first of them; where `attributes` are given, only those with the same attributes,
/// and edges along which attributes change are kept as edges. Vertices that parts share stay where
/// they are, open borders move along themselves, and no cut of the hierarchy has cracks between
/// clusters. For meshes that deform the error is that of the pose at hand.
///
/// Triangles of which two corners are at one position are in no cluster, unless the mesh is
/// deformable; a mesh of nothing else has no clusters. Deterministic, whatever the number of
/// threads, and the same on every target.
///
/// # Errors
/// If the mesh, an attribute or an option is invalid, or the mesh extends over more than
/// [`MAX_EXTENT`](super::MAX_EXTENT).
pub fn build_hierarchy(
    data: &MeshData,
    attributes: Option<VertexValues<'_>>,
    options: &HierarchyOptions,
) -> Result<LevelsData, LevelsError> {
    options.check()?;
    checked_extent(&data.positions, &data.indices)?;
    if let Some(attributes) = attributes {
        check_attributes(attributes, data.positions.len())?;
    }
    let triangles = data.indices.len() / 3;
    if triangles > MOST_TRIANGLES {
        return Err(LevelsError::TooMany { triangles, limit: MOST_TRIANGLES });
    }
    let parts = checked_parts(data)?;
    let welded = Welded::new(&data.positions, attributes);
    let shared = shared_by_parts(data, &parts, &welded);
    let mut result = Assembly::new(data, &parts);
    // Numbers of vertices within a part, cleared after each.
    let mut local = vec![u32::MAX; data.positions.len()];
    for (number, part) in parts.iter().enumerate() {
        let mut surface = PartSurface::new(data, &welded, &shared, part, &mut local);
        let made = build_part(&mut surface, options, number as u32);
        result.add(number as u32, part, &surface, made, &welded);
    }
    Ok(result.levels)
}

/// The parts of a mesh; one that names none has one.
fn checked_parts(data: &MeshData) -> Result<Vec<Part>, LevelsError> {
    let triangles = data.indices.len() / 3;
    if data.parts.is_empty() {
        let triangle_count = triangles as u32;
        return Ok(vec![Part { triangle_count, two_sided: true, ..Part::default() }]);
    }
    let mut expected = 0;
    for (part, p) in data.parts.iter().enumerate() {
        let first = p.first_triangle;
        let end = u64::from(first) + u64::from(p.triangle_count);
        let last = part + 1 == data.parts.len() && end != triangles as u64;
        if first != expected || end > triangles as u64 || last {
            return Err(MeshError::Parts { part, first, expected, triangles }.into());
        }
        expected = end as u32;
    }
    Ok(data.parts.clone())
}

/// For each vertex that is the first at its position whether triangles of several parts have it.
fn shared_by_parts(data: &MeshData, parts: &[Part], welded: &Welded) -> Vec<bool> {
    let mut shared = vec![false; data.positions.len()];
    if parts.len() < 2 {
        return shared;
    }
    let mut of = vec![u32::MAX; data.positions.len()];
    for (number, part) in (0..).zip(parts) {
        let first = part.first_triangle as usize * 3;
        for &v in &data.indices[first..first + part.triangle_count as usize * 3] {
            let at = welded.position[v as usize] as usize;
            shared[at] |= of[at] != u32::MAX && of[at] != number;
            of[at] = number;
        }
    }
    shared
}

/// Levels of parts, put together.
struct Assembly<'a> {
    data: &'a MeshData,
    levels: LevelsData,
}

impl<'a> Assembly<'a> {
    fn new(data: &'a MeshData, parts: &[Part]) -> Self {
        let mesh = MeshData {
            positions: data.positions.clone(),
            indices: Vec::new(),
            parts: Vec::with_capacity(parts.len()),
            polygons: data.polygons,
            deformable: data.deformable,
        };
        Self { data, levels: LevelsData { mesh, ..LevelsData::default() } }
    }

    fn add(
        &mut self,
        number: u32,
        part: &Part,
        surface: &PartSurface,
        made: PartLevels,
        welded: &Welded,
    ) {
        let LevelsData { mesh, clustering, groups, replaced_by, made_from } = &mut self.levels;
        let Clustering { order, clusters } = clustering;
        let first_triangle = (mesh.indices.len() / 3) as u32;
        let own = part.first_triangle as usize * 3..;
        let own = &self.data.indices[own][..part.triangle_count as usize * 3];
        mesh.indices.extend(own.iter().map(|&v| welded.vertex[v as usize]));
        let first_group = groups.len() as u32;
        let global = |g: u32| if g == NO_GROUP { NO_GROUP } else { first_group + g };
        let mut triangles = surface.order.iter();
        for cluster in made.clusters {
            let first = order.len() as u32;
            if cluster.made_from == NO_GROUP {
                let own = triangles.by_ref().take(cluster.triangles as usize);
                order.extend(own.map(|t| first_triangle + t));
            } else {
                for t in cluster.indices.chunks_exact(3) {
                    order.push((mesh.indices.len() / 3) as u32);
                    mesh.indices.extend(t.iter().map(|&v| surface.vertices[v as usize]));
                }
            }
            let triangle_count = order.len() as u32 - first;
            let cluster_of_mesh =
                cullet::mesh::Cluster { first_triangle: first, triangle_count, part: number };
            clusters.push(cluster_of_mesh);
            made_from.push(global(cluster.made_from));
            replaced_by.push(global(cluster.replaced_by));
        }
        groups.extend(made.groups.into_iter().map(|(ball, error)| Group {
            centre: ball.centre,
            radius: ball.radius,
            error,
        }));
        let triangle_count = (mesh.indices.len() / 3) as u32 - first_triangle;
        mesh.parts.push(Part { first_triangle, triangle_count, ..*part });
    }
}
