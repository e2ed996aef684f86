//! How clusters are made.

use cullet::mesh::{MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES, MeshError};
use thiserror::Error;

/// From what the probability P that a cluster is culled is estimated while clusters grow. Borders
/// are always improved by view points.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Probability {
    /// The share of view points behind all triangles: fastest and best.
    #[default]
    Views,
    /// The volume of the Johannsen–Carter culling region inside the box around the mesh, grown
    /// about its middle to `scale` times its size: viewers anywhere in a scene. 1 or more.
    SceneBox {
        /// The size of the scene, in sizes of the mesh's box.
        scale: f64,
    },
    /// The same inside the cluster's own box, grown by so many of its diagonals on each side:
    /// viewers nearby. Above 0.
    NearBox {
        /// The margin, in diagonals of the cluster's box.
        diagonals: f64,
    },
}

/// How clusters are made. [`ClusterOptions::default`] takes some 1.5 s for 100,000
/// triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterOptions {
    /// The most vertices in a cluster, 3 to 64 (default 64). Fewer cull better and draw worse.
    pub max_vertices: u32,
    /// The most triangles in a cluster, 1 to 124 (default 124).
    pub max_triangles: u32,
    /// t/r: what a test of a cluster costs, in triangles drawn (default 16). Not negative; more
    /// makes fewer, larger clusters, of which fewer are culled.
    pub test_cost: f64,
    /// Cost of a vertex in a cluster, in triangles drawn (default 0.1). Not negative; more makes
    /// clusters rounder and fuller, of which fewer are culled.
    pub vertex_cost: f64,
    /// How many view points to sample, 1 to 1024, rounded up to 256, 512 or 1024 (default 256).
    /// Time and memory are in proportion.
    pub views: u32,
    /// How far view points are from the middle of the mesh, in radii of the sphere around it; each
    /// is above 0 and may be infinite. Near ones favour viewers who walk past (default 1.25, 2, 3,
    /// 6).
    pub distances: [f64; 4],
    /// How P is estimated while clusters grow.
    pub probability: Probability,
    /// How often clusters are dissolved into their neighbours and borders improved after that
    /// (default 3). 0 leaves what greedy merging makes.
    pub rounds: u32,
    /// Passes of random moves over all triangles in each round (default 60).
    pub sweeps: u32,
    /// Whether to cluster a second time as if the mesh had one material, to report what the split
    /// costs (default no). Doubles the time where there are several parts.
    pub measure_parts: bool,
}

impl ClusterOptions {
    /// Greedy merging and one pass of improvement: half the time of the default, some 8 % more
    /// clusters, of which about as much is culled.
    #[must_use]
    pub const fn fast() -> Self {
        Self { rounds: 1, sweeps: 0, ..Self::balanced() }
    }

    /// The options of [`Default`].
    #[must_use]
    pub const fn balanced() -> Self {
        Self {
            max_vertices: MAX_CLUSTER_VERTICES as u32,
            max_triangles: MAX_CLUSTER_TRIANGLES as u32,
            test_cost: 16.0,
            vertex_cost: 0.1,
            views: 256,
            distances: [1.25, 2.0, 3.0, 6.0],
            probability: Probability::Views,
            rounds: 3,
            sweeps: 60,
            measure_parts: false,
        }
    }

    /// Three times the time of the default, for what is baked once: some 3 % fewer clusters, and
    /// half a point more culled.
    #[must_use]
    pub const fn best() -> Self {
        Self { views: 1024, rounds: 4, sweeps: 200, ..Self::balanced() }
    }

    /// The default with `test_cost` from what a machine and its renderer cost: the test of a
    /// cluster, and the draw that a cluster which stays may need by itself, over what the renderer
    /// takes for a triangle that it rejects because it faces away, all in nanoseconds. Costs that
    /// are not above 0 may give a `test_cost` that [`build`](super::build) refuses.
    ///
    /// The bare t/r is so small on a CPU (some 0.002 for the reference renderer) that it leaves
    /// clusters half empty, as if each cost nothing but its test: on the bunny more than twice as
    /// many as by default, and with the draw a sixth more (`cullet reproduce johannsen-carter
    /// --test-cost`).
    #[must_use]
    pub const fn from_costs(cluster_test: f64, draw: f64, rejected_triangle: f64) -> Self {
        Self { test_cost: (cluster_test + draw) / rejected_triangle, ..Self::balanced() }
    }

    /// Whether every value is in range.
    pub(super) fn check(&self) -> Result<(), ClusterError> {
        let count = |what, value: u32, least: u32, most: usize| {
            if value < least || value as usize > most {
                return Err(ClusterError::Count { what, value, least, most: most as u32 });
            }
            Ok(())
        };
        count("max_vertices", self.max_vertices, 3, MAX_CLUSTER_VERTICES)?;
        count("max_triangles", self.max_triangles, 1, MAX_CLUSTER_TRIANGLES)?;
        count("views", self.views, 1, 1024)?;
        let cost = |what, value: f64| {
            // A million triangles drawn for one test; more would not change anything.
            if (0.0..=1e6).contains(&value) {
                return Ok(());
            }
            Err(ClusterError::Value { what, value, allowed: "a number from 0 to 1e6" })
        };
        cost("test_cost", self.test_cost)?;
        cost("vertex_cost", self.vertex_cost)?;
        for value in self.distances {
            if value.is_nan() || value <= 0.0 {
                let allowed = "a number of radii above 0, or infinity";
                return Err(ClusterError::Value { what: "distances", value, allowed });
            }
        }
        match self.probability {
            Probability::SceneBox { scale: value } if !(1.0..=1e6).contains(&value) => {
                Err(ClusterError::Value { what: "scale", value, allowed: "a number from 1 to 1e6" })
            }
            Probability::NearBox { diagonals: value } if !(value > 0.0 && value <= 1e6) => {
                let allowed = "a number above 0, to 1e6";
                Err(ClusterError::Value { what: "diagonals", value, allowed })
            }
            _ => Ok(()),
        }
    }
}

impl Default for ClusterOptions {
    fn default() -> Self {
        Self::balanced()
    }
}

/// Why clusters cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ClusterError {
    /// The mesh itself is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An option that counts is out of range.
    #[error("option {what} is {value}; {least} to {most} are allowed")]
    Count {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: u32,
        /// The least that is allowed.
        least: u32,
        /// The most that is allowed.
        most: u32,
    },
    /// An option that measures is out of range.
    #[error("option {what} is {value}; it must be {allowed}")]
    Value {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The values that are allowed.
        allowed: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_become_triangles() {
        let options = ClusterOptions::from_costs(0.5, 199.5, 80.0);
        assert_eq!(options, ClusterOptions { test_cost: 2.5, ..ClusterOptions::default() });
        assert_eq!(options.check(), Ok(()));
        let refused = ClusterOptions::from_costs(0.5, 199.5, 0.0).check();
        assert!(matches!(refused, Err(ClusterError::Value { what: "test_cost", .. })));
    }
}
