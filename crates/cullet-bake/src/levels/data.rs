//! Levels as they are baked: triangles of all levels, their clusters, and the groups by which they
//! are chosen.

use cullet::lod::Levels;
pub use cullet::lod::{Group, NO_GROUP};
use cullet::mesh::Clustering;
use cullet::{Mesh, MeshData};

use super::error::LevelsError;

/// Levels of a mesh: a hierarchy of clusters or a chain.
///
/// A cluster is drawn if and only if the group it was made from is not over the threshold
/// (originals: never over) and the group that replaced it is (the coarsest: always over). Errors
/// and spheres of groups enclose those below, so whatever the threshold and the eye, each part of
/// the surface is drawn once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelsData {
    /// Positions of the base mesh, triangles of all levels, parts as the base mesh's: all levels of
    /// part 0, then those of part 1, and so on. Within a part the base mesh's triangles come first,
    /// in their order.
    pub mesh: MeshData,
    /// Clusters of all levels; each part's from the finest to the coarsest.
    pub clustering: Clustering,
    /// Groups; those below another have lower numbers.
    pub groups: Vec<Group>,
    /// For each cluster the group that simplified it further, or [`NO_GROUP`] at the top.
    pub replaced_by: Vec<u32>,
    /// For each cluster the group whose simplification it is, or [`NO_GROUP`] for an original
    /// cluster.
    pub made_from: Vec<u32>,
}

impl LevelsData {
    /// The mesh that holds the levels, and the levels, for
    /// [`Scene::add_levels`](cullet::Scene::add_levels). Triangles that are in no cluster, which
    /// are degenerate, are left out.
    ///
    /// # Errors
    /// If something that was changed since the bake no longer fits.
    pub fn into_levels(mut self) -> Result<(Mesh, Levels), LevelsError> {
        self.leave_out_unclustered();
        let Self { mesh, clustering, groups, replaced_by, made_from } = self;
        let mesh = Mesh::with_clusters(mesh, &clustering)?;
        let levels = Levels::new(&mesh, &groups, made_from, replaced_by);
        Ok((mesh, levels?))
    }

    /// Leaves out the triangles that are in no cluster.
    fn leave_out_unclustered(&mut self) {
        let Clustering { order, .. } = &mut self.clustering;
        let triangles = self.mesh.indices.len() / 3;
        // What is wrong in other ways is found out by the mesh.
        if order.len() >= triangles || order.iter().any(|&t| t as usize >= triangles) {
            return;
        }
        let mut clustered = vec![false; triangles];
        order.iter().for_each(|&t| clustered[t as usize] = true);
        let mut before = Vec::with_capacity(triangles + 1);
        let mut kept = 0;
        for clustered in &clustered {
            before.push(kept);
            kept += u32::from(*clustered);
        }
        before.push(kept);
        let mut own = clustered.iter();
        self.mesh.indices = std::mem::take(&mut self.mesh.indices)
            .as_chunks::<3>()
            .0
            .iter()
            .filter(|_| own.next().copied().unwrap_or(false))
            .flatten()
            .copied()
            .collect();
        order.iter_mut().for_each(|t| *t = before[*t as usize]);
        let at = |t: u64| before[t.min(triangles as u64) as usize];
        for part in &mut self.mesh.parts {
            let first = u64::from(part.first_triangle);
            let end = at(first + u64::from(part.triangle_count));
            part.first_triangle = at(first);
            part.triangle_count = end - part.first_triangle;
        }
    }

    /// The corners of a cluster's triangles, as vertices of the mesh, three each.
    pub fn cluster_indices(&self, cluster: u32) -> impl Iterator<Item = u32> + '_ {
        let range = self.clustering.clusters[cluster as usize].triangles();
        self.clustering.order[range.start as usize..range.end as usize]
            .iter()
            .flat_map(|&t| self.mesh.indices[t as usize * 3..][..3].iter().copied())
    }

    /// Checks that numbers are in range, that each group replaces and makes something, and that
    /// errors and spheres of groups enclose those of the groups below. The first error, in words.
    ///
    /// # Errors
    /// As said.
    pub fn validate(&self) -> Result<(), String> {
        let clusters = self.clustering.clusters.len();
        if self.replaced_by.len() != clusters || self.made_from.len() != clusters {
            let [a, b] = [self.replaced_by.len(), self.made_from.len()];
            return Err(format!("{clusters} clusters, but {a} and {b} group numbers"));
        }
        let mut uses = vec![[0u32; 2]; self.groups.len()];
        for cluster in 0..clusters {
            let [below, above] = [self.made_from[cluster], self.replaced_by[cluster]];
            for (k, group) in [below, above].into_iter().enumerate().filter(|g| g.1 != NO_GROUP) {
                let Some(uses) = uses.get_mut(group as usize) else {
                    let groups = self.groups.len();
                    return Err(format!("cluster {cluster} names group {group} of {groups}"));
                };
                uses[k] += 1;
            }
            if below == NO_GROUP || above == NO_GROUP {
                continue;
            }
            if below >= above {
                return Err(format!("cluster {cluster} is made from {below}, replaced by {above}"));
            }
            let [low, high] = [below, above].map(|g| self.groups[g as usize]);
            if low.error > high.error {
                let [e, f] = [low.error, high.error];
                return Err(format!("group {below} errs by {e}, group {above} above it by {f}"));
            }
            let apart = (0..3)
                .map(|a| (f64::from(low.centre[a]) - f64::from(high.centre[a])).powi(2))
                .sum::<f64>()
                .sqrt();
            if apart + f64::from(low.radius) > f64::from(high.radius) {
                return Err(format!("the sphere of group {below} leaves that of group {above}"));
            }
        }
        for (group, (uses, g)) in uses.iter().zip(&self.groups).enumerate() {
            let finite = g.centre.iter().chain([&g.radius, &g.error]).all(|v| v.is_finite());
            if uses[1] == 0 || !finite || g.radius < 0.0 || g.error < 0.0 {
                return Err(format!(
                    "group {group}: {g:?}, made {}, replaced {}",
                    uses[0], uses[1]
                ));
            }
        }
        Ok(())
    }
}
