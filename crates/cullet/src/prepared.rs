//! Prepared data: what is derived from a mesh once, so that culling it frame after frame is cheap.
//!
//! A [`Mesh`] is checked geometry and nothing else. Planes of its triangles, cones of its clusters
//! and its occluder stand beside it in the scene. They are made when the scene is
//! [committed](crate::Scene::commit), by jobs of the caller, or are given, but never by surprise in
//! a frame: a stage that misses its data keeps what it cannot test.

use crate::cull::backface::{Backfaces, ClusterCones, Facing};
use crate::cull::occlusion::{Occluder, Shape};
use crate::mesh::{Cluster, Mesh};

/// The kinds of prepared data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Preparation {
    /// Planes of triangles and cones of clusters, for views that cull back faces by
    /// [`Backface::Fast`](crate::Backface::Fast). Some 5 bytes per triangle, and the most expensive
    /// to make: as long as drawing the mesh some hundred times.
    pub backfaces: bool,
    /// The same cones for views that cull what is wound counter-clockwise: because they draw the
    /// backs alone, as some shadow passes do, or because their fronts are clockwise, as in a
    /// mirror. Few scenes have one, so that they are not made by default; without, such a view
    /// tests single triangles.
    pub frontfaces: bool,
    /// The shapes that stand for the mesh in an occlusion buffer, for
    /// [`Culler::occlusion`](crate::Culler::occlusion).
    pub occluder: bool,
}

impl Preparation {
    /// Nothing.
    pub const NONE: Self = Self { backfaces: false, frontfaces: false, occluder: false };
    /// Everything.
    pub const ALL: Self = Self { backfaces: true, frontfaces: true, occluder: true };

    /// Union of both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            backfaces: self.backfaces || other.backfaces,
            frontfaces: self.frontfaces || other.frontfaces,
            occluder: self.occluder || other.occluder,
        }
    }
}

impl Default for Preparation {
    /// Data for views that cull back faces.
    fn default() -> Self {
        Self { frontfaces: false, ..Self::ALL }
    }
}

/// Data derived from one mesh. Plain values: copied with the scene's data, made on any thread.
#[derive(Clone, Debug)]
pub struct Prepared {
    made: Preparation,
    planes: Option<Backfaces>,
    behind: Option<ClusterCones>,
    before: Option<ClusterCones>,
    occluder: Option<Occluder>,
    /// Whether the occluder is the caller's.
    is_given: bool,
}

impl Default for Prepared {
    /// Nothing is made.
    fn default() -> Self {
        Self {
            made: Preparation::NONE,
            planes: None,
            behind: None,
            before: None,
            occluder: None,
            is_given: false,
        }
    }
}

impl Prepared {
    /// Makes the wanted data of a mesh. Cost: for back faces linear in triangles and clusters, more
    /// where the normals of a cluster spread; nothing for a mesh whose back faces are never culled,
    /// because it is two-sided or can deform.
    #[must_use]
    pub fn of(mesh: &Mesh, wanted: Preparation) -> Self {
        let mut made = Self::default();
        made.add(mesh, wanted);
        made
    }

    /// Makes what is wanted and not yet there, of the mesh of which the rest was made.
    pub fn add(&mut self, mesh: &Mesh, wanted: Preparation) {
        let has_backs = cfg!(feature = "clusters") && !mesh.is_deformable() && !mesh.is_two_sided();
        let wants_planes = wanted.backfaces || wanted.frontfaces;
        if has_backs && wants_planes && self.planes.is_none() {
            let one_sided = mesh.clusters().iter().filter(|c| is_one_sided(mesh, c));
            let one_sided = one_sided.map(Cluster::triangles);
            self.planes = Some(Backfaces::new(mesh.positions(), mesh.indices(), one_sided));
        }
        if let Some(planes) = self.planes.as_ref().filter(|_| cfg!(feature = "clusters")) {
            let cones = |facing| {
                let of = |c: &Cluster| is_one_sided(mesh, c).then(|| c.triangles());
                let ranges = mesh.clusters().iter().map(of);
                planes.cones(mesh.positions(), mesh.indices(), ranges, facing)
            };
            if wanted.backfaces && self.behind.is_none() {
                self.behind = Some(cones(Facing::Back));
            }
            if wanted.frontfaces && self.before.is_none() {
                self.before = Some(cones(Facing::Front));
            }
        }
        if wanted.occluder && self.occluder.is_none() {
            self.occluder = Some(Occluder::of_mesh(mesh));
        }
        self.made = self.made.and(wanted);
    }

    /// Kinds of data that were made or given.
    #[must_use]
    pub fn made(&self) -> Preparation {
        self.made
    }

    /// Takes an occluder of the caller's, such as one that was baked, in place of
    /// [`Occluder::of_mesh`]. Its shapes must lie within what the mesh hides.
    #[must_use]
    pub fn with_occluder(mut self, occluder: Occluder) -> Self {
        self.occluder = Some(occluder);
        (self.made.occluder, self.is_given) = (true, true);
        self
    }

    /// The planes of the triangles of one-sided parts, in the mesh's order; `None` where they were
    /// not made, and for a mesh without backs.
    #[must_use]
    pub fn backfaces(&self) -> Option<&Backfaces> {
        self.planes.as_ref()
    }

    /// The cones of the clusters, those of two-sided parts left out, for eyes that see this side of
    /// them; `None` where they were not made, and where no eye is before or behind all of any
    /// cluster.
    #[must_use]
    pub fn cluster_cones(&self, facing: Facing) -> Option<&ClusterCones> {
        let cones = if facing == Facing::Front { &self.before } else { &self.behind };
        cones.as_ref().filter(|cones| !cones.is_empty())
    }

    /// The shapes that stand for the mesh in an occlusion buffer; `None` where they were not made.
    #[must_use]
    pub fn occluder(&self) -> Option<&Occluder> {
        self.occluder.as_ref()
    }

    /// The occluder that was [given](Self::with_occluder); `None` where it was made of the mesh.
    #[must_use]
    pub fn given_occluder(&self) -> Option<&Occluder> {
        self.occluder().filter(|_| self.is_given)
    }

    /// The shapes of the [occluder](Self::occluder); none where it was not made.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        self.occluder().map_or(&[], Occluder::shapes)
    }
}

/// Makes what is wanted of many meshes.
pub(crate) fn add_all(prepared: &mut [Prepared], meshes: &[Mesh], wanted: Preparation) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        prepared.par_iter_mut().zip(meshes).for_each(|(prepared, mesh)| prepared.add(mesh, wanted));
    }
    #[cfg(not(feature = "rayon"))]
    prepared.iter_mut().zip(meshes).for_each(|(prepared, mesh)| prepared.add(mesh, wanted));
}

fn is_one_sided(mesh: &Mesh, cluster: &Cluster) -> bool {
    !mesh.parts()[cluster.part as usize].two_sided
}
