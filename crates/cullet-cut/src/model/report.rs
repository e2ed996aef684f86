//! Figures of the cut of a model.

use cullet::Mesh;
use cullet_mesh::Topology;
use serde::Serialize;

use crate::result::CutReport;

/// The figures of a cut, over all instances.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ModelReport {
    /// Triangles of all instances before the cut.
    pub triangles_before: u64,
    /// And after it, caps included.
    pub triangles_after: u64,
    /// Triangles of caps.
    pub cap_triangles: u64,
    /// The area of the caps, in squared units of the world.
    pub cap_area: f64,
    /// Instances before the cut.
    pub instances_before: u64,
    /// Instances that no plane touches and that are kept.
    pub instances_untouched: u64,
    /// Instances that were cut and of which something is left.
    pub instances_cut: u64,
    /// Instances of which nothing is left.
    pub instances_dropped: u64,
    /// Sum of [`CutReport::duplicates`].
    pub duplicates_dropped: u64,
    /// Sum of [`CutReport::open_chains`].
    pub open_chains: u64,
    /// Sum of [`CutReport::open_edges`].
    pub open_edges: u64,
    /// The meshes with outlines that do not close.
    pub open_meshes: Vec<OpenMesh>,
    /// Sum of [`CutReport::welded`].
    pub welded: u64,
    /// Sum of [`CutReport::healed`].
    pub healed: u64,
    /// Sum of [`CutReport::even_odd`].
    pub even_odd_outlines: u64,
    /// Sum of [`CutReport::crossings`].
    pub crossings: u64,
    /// Sum of [`CutReport::folded`].
    pub folded_caps: u64,
}

/// A mesh with outlines at the cut that do not close.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenMesh {
    /// Number of the mesh in the scene.
    pub mesh: usize,
    /// Its name.
    pub name: String,
    /// Outlines that do not close, over all its instances that were cut.
    pub open_chains: u64,
    /// Edges of those outlines.
    pub open_edges: u64,
    /// Edges of one triangle, before the cut.
    pub boundary_edges: u32,
    /// Edges of more than two triangles, before the cut.
    pub non_manifold_edges: u32,
}

impl ModelReport {
    /// Adds what the cut of one instance found. Where that is an open outline, the mesh is looked
    /// at as it was before the cut, once.
    pub(super) fn add(&mut self, number: usize, name: &str, mesh: &Mesh, report: &CutReport) {
        self.duplicates_dropped += report.duplicates as u64;
        self.open_chains += report.open_chains as u64;
        self.open_edges += report.open_edges as u64;
        self.welded += report.welded as u64;
        self.healed += report.healed as u64;
        self.even_odd_outlines += report.even_odd as u64;
        self.crossings += report.crossings as u64;
        self.folded_caps += report.folded as u64;
        if report.open_chains == 0 {
            return;
        }
        let list = &mut self.open_meshes;
        let at = list.iter().position(|m| m.mesh == number).unwrap_or_else(|| {
            let topology = Topology::of_mesh(mesh);
            list.push(OpenMesh {
                mesh: number,
                name: name.into(),
                open_chains: 0,
                open_edges: 0,
                boundary_edges: topology.boundary_edges,
                non_manifold_edges: topology.non_manifold_edges,
            });
            list.len() - 1
        });
        list[at].open_chains += report.open_chains as u64;
        list[at].open_edges += report.open_edges as u64;
    }
}
