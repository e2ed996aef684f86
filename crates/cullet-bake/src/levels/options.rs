//! How a hierarchy is made.

/// Where the error of a group comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorSource {
    /// Measured against the original surface.
    #[default]
    Measured,
    /// The simplifier's own estimate, the largest of the groups below where that is larger: no
    /// bound, to compare with.
    Returned,
}

/// How a hierarchy is made.
#[derive(Clone, Debug, PartialEq)]
pub struct HierarchyOptions {
    /// The most triangles in a cluster: a multiple of 4 from 8 to 124 (default 64). Fewer follow
    /// the surface better, more are fewer clusters to choose from.
    pub cluster_triangles: u32,
    /// How many clusters make a group, 2 to 64 (default 8): a third more in some. With more, fewer
    /// vertices are held where they are, but larger areas are drawn at one level.
    pub group_clusters: u32,
    /// Where errors come from.
    pub errors: ErrorSource,
    /// Random points on each triangle whose deviation is measured, beside the vertices (default 1,
    /// at most 64). More find deviations better and take longer, in proportion.
    pub points: u32,
    /// Points on each new triangle whose distance from the original is measured (default 6, at most
    /// 64).
    pub reverse_points: u32,
    /// Seed of the random points (default 0).
    pub seed: u64,
    /// Threads (default 1, at most 1024). The result is the same for any number.
    pub threads: usize,
}

impl Default for HierarchyOptions {
    fn default() -> Self {
        Self {
            cluster_triangles: 64,
            group_clusters: 8,
            errors: ErrorSource::Measured,
            points: 1,
            reverse_points: 6,
            seed: 0,
            threads: 1,
        }
    }
}
