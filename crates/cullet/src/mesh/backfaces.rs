//! What a mesh holds ready for back-face culling, made when it is first asked for.

use std::sync::OnceLock;

use super::{Cluster, Mesh};
use crate::cull::backface::{Backfaces, ClusterCones, Facing};
use crate::cull::occlusion::Occluder;

/// Made on first use, and copied with the mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Prepared {
    planes: OnceLock<Backfaces>,
    behind: OnceLock<ClusterCones>,
    before: OnceLock<ClusterCones>,
    occluder: OnceLock<Occluder>,
    /// Whether the occluder is the caller's.
    is_given: bool,
}

impl Mesh {
    /// The planes of the triangles of one-sided parts, in the mesh's order; made by the first call, see
    /// [`prepare`](Self::prepare).
    pub fn backfaces(&self) -> &Backfaces {
        self.prepared.planes.get_or_init(|| {
            let ranges = self.clusters.iter().filter(|c| self.is_one_sided(c));
            Backfaces::new(&self.positions, &self.indices, ranges.map(Cluster::triangles))
        })
    }

    /// The cones of the clusters, those of two-sided parts left out, for eyes that see one side of them;
    /// made by the first call for each side, see [`prepare`](Self::prepare).
    pub fn cluster_cones(&self, facing: Facing) -> &ClusterCones {
        let once = match facing {
            Facing::Front => &self.prepared.before,
            Facing::Back | Facing::Edge => &self.prepared.behind,
        };
        once.get_or_init(|| {
            let ranges = self.clusters.iter().map(|c| self.is_one_sided(c).then(|| c.triangles()));
            let facing = if facing == Facing::Front { facing } else { Facing::Back };
            self.backfaces().cones(&self.positions, &self.indices, ranges, facing)
        })
    }

    /// What stands for the mesh in an occlusion buffer: what was given by [`set_occluder`](Self::set_occluder), or else
    /// [`Occluder::of_mesh`], made by the first call.
    pub fn occluder(&self) -> &Occluder {
        self.prepared.occluder.get_or_init(|| Occluder::of_mesh(self))
    }

    /// The occluder, unless nobody gave or made it yet.
    pub(crate) fn occluder_if_made(&self) -> Option<&Occluder> {
        self.prepared.occluder.get()
    }

    /// Gives the mesh an occluder, such as one that was baked: its shapes must lie within what the mesh hides.
    pub fn set_occluder(&mut self, occluder: Occluder) {
        self.prepared.occluder = OnceLock::from(occluder);
        self.prepared.is_given = true;
    }

    /// The occluder that was given by [`set_occluder`](Self::set_occluder); `None` where [`occluder`](Self::occluder) makes it
    /// of the mesh. It is forgotten when [`set_two_sided`](Self::set_two_sided) changes a part.
    #[must_use]
    pub fn given_occluder(&self) -> Option<&Occluder> {
        self.prepared.occluder.get().filter(|_| self.prepared.is_given)
    }

    /// Makes what the culling of back faces needs of this mesh, so that the first frame does not pay for
    /// it: see [`Scene::prepare`](crate::Scene::prepare) for the cost. Nothing for a mesh whose back faces
    /// are never culled. Meshes may be prepared at once on several threads.
    pub fn prepare(&self) {
        if !self.deformable && !self.is_two_sided() {
            self.cluster_cones(Facing::Back);
        }
    }

    fn is_one_sided(&self, cluster: &Cluster) -> bool {
        !self.parts[cluster.part as usize].two_sided
    }
}
