//! Levels of a mesh: the groups that its clusters were simplified in.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use thiserror::Error;

use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::mesh::Mesh;

/// In place of the number of a group: there is none.
pub const NO_GROUP: u32 = u32::MAX;

/// Clusters that were simplified together, and by how much what came out may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Group {
    /// Centre of a sphere around all that it stands for, in the space of the mesh.
    pub centre: [f32; 3],
    /// Radius of the sphere.
    pub radius: f32,
    /// How far its simplified triangles are from the original surface at the most, in units of the
    /// mesh.
    pub error: f32,
}

impl Group {
    /// Returns how far the sphere of `self` reaches beyond that of `other`, as a share of the
    /// larger of the two radii. Returns 0 where it lies within.
    fn beyond(&self, other: &Self) -> f64 {
        let between: f64 = (0..3)
            .map(|a| (f64::from(self.centre[a]) - f64::from(other.centre[a])).powi(2))
            .sum::<f64>()
            .sqrt();
        let (own, others) = (f64::from(self.radius), f64::from(other.radius));
        let size = own.max(others).max(f64::from(f32::MIN_POSITIVE));
        ((between + own - others) / size).max(0.0)
    }
}

/// Why a mesh does not have such levels.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LevelsError {
    /// Not one number for each cluster.
    #[error("{what} has {given} entries, but the mesh has {clusters} clusters")]
    Length {
        /// Name of the list that is wrong.
        what: &'static str,
        /// How many entries it has.
        given: usize,
        /// How many clusters there are.
        clusters: usize,
    },
    /// The mesh that holds the levels has triangles that are in no cluster.
    #[error(
        "the mesh of the levels has {triangles} degenerate triangles, which no level draws: leave them out"
    )]
    Degenerate {
        /// How many.
        triangles: u32,
    },
    /// The scene has no such mesh.
    #[error("mesh {mesh} of {meshes}")]
    NoMesh {
        /// The requested mesh.
        mesh: u32,
        /// How many there are.
        meshes: usize,
    },
    /// A number beyond the groups.
    #[error("{what} of cluster {cluster} is {group}, but there are {groups} groups")]
    NoSuchGroup {
        /// Name of the list that is wrong.
        what: &'static str,
        /// The cluster whose entry is wrong.
        cluster: usize,
        /// The number.
        group: u32,
        /// How many groups there are.
        groups: usize,
    },
    /// A sphere or an error that is not finite or below zero.
    #[error("group {group} has a sphere or an error that is negative or not finite: {value:?}")]
    NotFinite {
        /// Number of the group.
        group: usize,
        /// The group itself.
        value: Group,
    },
    /// Triangles that were simplified from others would be nearer to the original, or reach beyond
    /// them: a choice among them would leave holes.
    #[error(
        "group {group} is simplified further in group {coarser}, whose {what} {more}: a choice among \
         them would leave holes"
    )]
    NotMonotone {
        /// The finer group.
        group: u32,
        /// The coarser one.
        coarser: u32,
        /// Error or sphere.
        what: &'static str,
        /// Description of the fault.
        more: String,
    },
}

/// The most that a sphere may reach beyond the one around it, as a share: what f32 rounds, with
/// room.
const SLACK: f64 = 1e-4;

/// The levels of one mesh that holds all of them, made ready for choosing.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Centre, radius and error of each group as five rows.
    pub(super) rows: [Vec<f32>; 5],
    pub(super) made_from: Vec<u32>,
    /// The clusters that each group was simplified from: `inputs[first_input[g]..first_input[g +
    /// 1]]`; the last list is of the clusters that were not simplified further.
    pub(super) inputs: Vec<u32>,
    pub(super) first_input: Vec<u32>,
    pub(super) triangles: Vec<u32>,
    originals: u32,
    /// Triangles of the clusters that were not simplified further.
    fewest: u64,
    replaced_by: Vec<u32>,
}

impl Levels {
    /// Levels of `mesh`, which holds the triangles of all of them. For each of its clusters
    /// `made_from` has the group whose simplified triangles it is part of, [`NO_GROUP`] for the
    /// original ones, and `replaced_by` the group that it was simplified in, [`NO_GROUP`] for the
    /// coarsest.
    ///
    /// # Errors
    /// If a list does not fit the mesh, or a number is out of range, or errors or spheres do not
    /// grow from group to group.
    pub fn new(
        mesh: &Mesh,
        groups: &[Group],
        made_from: Vec<u32>,
        replaced_by: Vec<u32>,
    ) -> Result<Self, LevelsError> {
        let clusters = mesh.clusters().len();
        if mesh.degenerate_count() > 0 {
            return Err(LevelsError::Degenerate { triangles: mesh.degenerate_count() });
        }
        for (what, list) in [("made_from", &made_from), ("replaced_by", &replaced_by)] {
            if list.len() != clusters {
                return Err(LevelsError::Length { what, given: list.len(), clusters });
            }
            let wrong = list.iter().position(|&g| g != NO_GROUP && g as usize >= groups.len());
            if let Some(cluster) = wrong {
                let (group, groups) = (list[cluster], groups.len());
                return Err(LevelsError::NoSuchGroup { what, cluster, group, groups });
            }
        }
        let bad = |g: &Group| {
            !g.centre.iter().all(|v| v.is_finite())
                || !(0.0..f32::INFINITY).contains(&g.radius)
                || !(0.0..f32::INFINITY).contains(&g.error)
        };
        if let Some(group) = groups.iter().position(bad) {
            return Err(LevelsError::NotFinite { group, value: groups[group] });
        }
        for (&group, &coarser) in made_from.iter().zip(&replaced_by) {
            if group != NO_GROUP && coarser != NO_GROUP {
                check_pair(groups, group, coarser)?;
            }
        }
        let mut first_input = vec![0; groups.len() + 2];
        let list_of = |g: u32| if g == NO_GROUP { groups.len() } else { g as usize };
        replaced_by.iter().for_each(|&g| first_input[list_of(g) + 1] += 1);
        for g in 1..first_input.len() {
            first_input[g] += first_input[g - 1];
        }
        let mut next = first_input.clone();
        let mut inputs = vec![0; clusters];
        for (cluster, &g) in replaced_by.iter().enumerate() {
            let at = &mut next[list_of(g)];
            inputs[*at as usize] = cluster as u32;
            *at += 1;
        }
        let triangles: Vec<u32> = mesh.clusters().iter().map(|c| c.triangle_count).collect();
        let coarsest = &inputs[first_input[groups.len()] as usize..];
        let row = |of: fn(&Group) -> f32| groups.iter().map(of).collect();
        Ok(Self {
            rows: [
                row(|g| g.centre[0]),
                row(|g| g.centre[1]),
                row(|g| g.centre[2]),
                row(|g| g.radius),
                row(|g| g.error),
            ],
            originals: made_from.iter().filter(|&&g| g == NO_GROUP).count() as u32,
            fewest: coarsest.iter().map(|&c| u64::from(triangles[c as usize])).sum(),
            triangles,
            made_from,
            inputs,
            first_input,
            replaced_by,
        })
    }

    /// Whether these are levels of a mesh with so many clusters, of as many triangles.
    pub(crate) fn check(&self, mesh: &Mesh) -> Result<(), LevelsError> {
        let (given, clusters) = (self.triangles.len(), mesh.clusters().len());
        let same =
            mesh.clusters().iter().map(|c| c.triangle_count).eq(self.triangles.iter().copied());
        match (same, mesh.degenerate_count()) {
            (true, 0) => Ok(()),
            (true, triangles) => Err(LevelsError::Degenerate { triangles }),
            _ => Err(LevelsError::Length { what: "the levels' clusters", given, clusters }),
        }
    }

    /// How many groups there are.
    #[must_use]
    pub fn group_count(&self) -> usize {
        self.rows[0].len()
    }

    /// A group.
    ///
    /// # Panics
    /// If there are not as many.
    #[must_use]
    pub fn group(&self, group: usize) -> Group {
        let [x, y, z, radius, error] = [0, 1, 2, 3, 4].each(|row: usize| self.rows[row][group]);
        Group { centre: [x, y, z], radius, error }
    }

    /// The group that each cluster was made from, or [`NO_GROUP`].
    #[must_use]
    pub fn made_from(&self) -> &[u32] {
        &self.made_from
    }

    /// The group that each cluster was simplified in, or [`NO_GROUP`].
    #[must_use]
    pub fn replaced_by(&self) -> &[u32] {
        &self.replaced_by
    }

    /// How many clusters are the original's.
    #[must_use]
    pub fn original_clusters(&self) -> u32 {
        self.originals
    }

    /// Returns how many triangles are drawn from far away, where nothing but the coarsest is.
    pub(crate) fn fewest_triangles(&self) -> u64 {
        self.fewest
    }

    /// The clusters that were simplified in a group; with the number of groups, those that were in
    /// none.
    pub(super) fn inputs_of(&self, group: usize) -> &[u32] {
        &self.inputs[self.first_input[group] as usize..self.first_input[group + 1] as usize]
    }
}

fn check_pair(groups: &[Group], group: u32, coarser: u32) -> Result<(), LevelsError> {
    let (a, b) = (&groups[group as usize], &groups[coarser as usize]);
    let wrong = |what, more| Err(LevelsError::NotMonotone { group, coarser, what, more });
    if group == coarser {
        return wrong("triangles", "are its own".to_owned());
    }
    if b.error < a.error {
        return wrong("error", format!("is {}, below {}", b.error, a.error));
    }
    let beyond = a.beyond(b);
    if beyond > SLACK {
        return wrong("sphere", format!("leaves out {:.2} % of its radius", beyond * 100.0));
    }
    Ok(())
}
