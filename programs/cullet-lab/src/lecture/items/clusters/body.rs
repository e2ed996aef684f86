//! A body of clusters that are culled often, and the eyes that look at it.

use crate::reproduce::model::Subject;
use crate::shapes::fibonacci;
use cullet::Mesh;
use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Cluster;
use cullet_bake::clusters::{ClusterOptions, build};
use cullet_scenes::knobbly_ball;

use crate::lecture::items::subject::one_sided;
use crate::lecture::lab::LabError;
use crate::lecture::tools::other;

/// A ball with knobs, in clusters.
pub(super) struct Body {
    /// Its mesh has these clusters.
    pub(super) subject: Subject,
    /// The planes of each cluster.
    pub(super) planes: Vec<ClusterPlanes>,
}

impl Body {
    /// 12·n² triangles, around a place.
    pub(super) fn new(n: u16, at: [f32; 3]) -> Result<Self, LabError> {
        let (mut positions, indices) = knobbly_ball(n);
        for p in &mut positions {
            *p = std::array::from_fn(|k| p[k] + at[k]);
        }
        let data = one_sided(positions, indices);
        let clustering = build(&data, &ClusterOptions::fast()).map_err(other)?;
        let subject = Subject::new("a knobbly ball".into(), data.clone());
        let subject = subject.map_err(|failure| LabError::Other(failure.message))?;
        let mesh = Mesh::with_clusters(data, &clustering).map_err(other)?;
        let planes = mesh.clusters().iter().map(|c| planes_of(&mesh, c)).collect();
        Ok(Self { subject: Subject { mesh, ..subject }, planes })
    }

    /// Eyes in so many directions from each of two distances, 1.5 and 3 radii.
    pub(super) fn eyes(&self, directions: usize) -> Vec<[f64; 4]> {
        let at = |radii: f64| {
            (0..directions).map(move |i| self.subject.eye(fibonacci(i, directions), radii))
        };
        at(1.5).chain(at(3.0)).collect()
    }

    /// How often an eye is behind all planes of a cluster.
    pub(super) fn ideal(&self, eyes: &[[f64; 4]]) -> usize {
        let behind = |eye: &[f64; 4]| self.planes.iter().filter(|p| p.is_behind(*eye)).count();
        eyes.iter().map(behind).sum()
    }
}

pub(super) fn planes_of(mesh: &Mesh, cluster: &Cluster) -> ClusterPlanes {
    ClusterPlanes::new(cluster.triangles().map(|t| mesh.corners(t)))
}
