//! Bounds of normals on the nodes of a hierarchy over clusters: whole nodes seen from behind go at
//! once, whole nodes seen from the front are taken at once.

use std::ops::Range;

use cullet::Simd;
use cullet::cull::backface::{ClusterEye, ClusterPlanes};

use super::{Bound, ClusterBounds};

/// Bounds of normals on the nodes of [`hierarchy::Nodes`](cullet::hierarchy::Nodes) over clusters:
/// node i of a level is over sixteen of the level below, 16 i to 16 i + 15. So whoever has such
/// nodes for the frustum needs no second grouping. For other groups fit a bound to each, of what
/// [`join`] makes of them.
///
/// A node's bound is fitted to all planes below it, not to the bounds of its children, and may
/// prove what theirs do not: so a walk culls what [`Bulk::cull`](crate::methods::Bulk::cull) does,
/// and perhaps a little more, and all of it is proved.
///
/// Scanned surfaces gain nothing: sixteen clusters mostly face both ways. From three radii the
/// bunny's 930 clusters cost 101 % of the blocks of a flat sweep, the armadillo's 1138 cost 108 %,
/// and several times the time, for a sweep reads what lies side by side (`cargo test --release -p
/// cullet-lab --test all nodes -- --nocapture`). It pays where many clusters lie in planes or bend
/// little; see [`blocks_tested`](ClusterCut::blocks_tested).
#[derive(Clone, Debug)]
pub struct ClusterNodes<B: Bound> {
    /// Regions from which all is seen from behind, and from the front: of the clusters, then of
    /// each level of nodes up to one of at most sixteen.
    levels: Vec<[ClusterBounds<B>; 2]>,
}

/// Clusters that an eye sees from behind, and those that it sees from the front.
#[derive(Clone, Debug, Default)]
pub struct ClusterCut {
    culled: Vec<u64>,
    front: Vec<u64>,
    blocks: [Vec<u32>; 2],
    tested: usize,
}

impl ClusterCut {
    /// Returns a cut without clusters.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// One bit a cluster: it is proved to be seen from behind. Bits beyond the last are 0.
    #[must_use]
    pub fn culled(&self) -> &[u64] {
        &self.culled
    }

    /// One bit a cluster: it is proved to be seen from the front, so none of its triangles need be
    /// tested.
    #[must_use]
    pub fn front(&self) -> &[u64] {
        &self.front
    }

    /// How many blocks of sixteen nodes or clusters were tested, for both sides.
    #[must_use]
    pub fn blocks_tested(&self) -> usize {
        self.tested
    }
}

/// The planes below a node; `None` once they span too much for any bound.
type Below = Option<ClusterPlanes>;

impl<B: Bound> ClusterNodes<B> {
    /// Fits bounds to clusters with these planes, in this order, and to the nodes over them. Some
    /// microseconds a bound; nodes above one that has none are not tried, so it ends soon.
    #[must_use]
    pub fn fit(planes: &[ClusterPlanes]) -> Self {
        let mut levels = Vec::new();
        let mut below: Vec<Below> = planes.iter().cloned().map(Some).collect();
        loop {
            let mut bounds = [ClusterBounds::default(), ClusterBounds::default()];
            for planes in &mut below {
                let back = planes.as_ref().and_then(B::fit);
                let front = planes.as_ref().and_then(|p| B::fit(&p.flipped()));
                // A node above has these planes and more, and fits no better. A cluster of no
                // triangle has no bound, but hinders none.
                if back.is_none()
                    && front.is_none()
                    && planes.as_ref().is_some_and(|p| !p.is_empty())
                {
                    *planes = None;
                }
                bounds[0].push(back);
                bounds[1].push(front);
            }
            levels.push(bounds);
            if below.len() <= LANES {
                return Self { levels };
            }
            let join = |parts: &[Below]| {
                let parts: Option<Vec<&ClusterPlanes>> = parts.iter().map(Option::as_ref).collect();
                parts.map(join)
            };
            below = below.chunks(LANES).map(join).collect();
        }
    }

    /// How many clusters there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.levels[0][0].len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bounds of the clusters alone: seen from behind, and from the front.
    #[must_use]
    pub fn clusters(&self) -> &[ClusterBounds<B>; 2] {
        &self.levels[0]
    }

    /// Walks the nodes for a homogeneous eye in the space of the clusters. An eye that is none (see
    /// [`ClusterEye::new`]) proves nothing. Allocates only where `cut` never held as much.
    pub fn cull(&self, simd: Simd, eye: [f64; 4], cut: &mut ClusterCut) {
        for mask in [&mut cut.culled, &mut cut.front] {
            mask.clear();
            mask.resize(self.len().div_ceil(64), 0);
        }
        cut.tested = 0;
        if let Some(eye) = ClusterEye::new(eye).filter(|_| !self.is_empty()) {
            self.walk(simd, &eye, cut);
        }
    }

    fn walk(&self, simd: Simd, eye: &ClusterEye, cut: &mut ClusterCut) {
        let ClusterCut { culled, front, blocks: [here, next], tested } = cut;
        here.clear();
        here.push(0);
        for (at, bounds) in self.levels.iter().enumerate().rev() {
            // How many clusters one of this simd stands for.
            let unit = LANES.pow(at as u32);
            next.clear();
            *tested += here.len();
            // Four blocks are tested at once: those of a word are neighbours, and mostly tested
            // together.
            for blocks in here.chunk_by(|a, b| a / BLOCKS == b / BLOCKS) {
                let word = (blocks[0] / BLOCKS) as usize;
                let found = [0, 1].map(|side: usize| bounds[side].word(simd, word, eye));
                for &block in blocks {
                    let first = block as usize * LANES;
                    let shift = first % 64;
                    let [back, forth] = found.map(|word| word >> shift & 0xffff);
                    for (mask, found) in [(&mut *culled, back), (&mut *front, forth)] {
                        for lane in (0..LANES).filter(|lane| found >> lane & 1 == 1) {
                            let start = (first + lane) * unit;
                            set(mask, start..(start + unit).min(self.len()));
                        }
                    }
                    if at > 0 {
                        let left = (bounds[0].len() - first).min(LANES);
                        let mixed = |lane: &usize| (back | forth) >> lane & 1 == 0;
                        next.extend((0..left).filter(mixed).map(|lane| (first + lane) as u32));
                    }
                }
            }
            std::mem::swap(here, next);
        }
    }
}

/// Clusters or nodes a block.
const LANES: usize = 16;
/// Blocks a word of 64 bits.
const BLOCKS: u32 = 4;

/// Sets a range of bits.
fn set(mask: &mut [u64], range: Range<usize>) {
    for word in range.start / 64..range.end.div_ceil(64) {
        let from = range.start.saturating_sub(word * 64);
        let to = (range.end - word * 64).min(64);
        mask[word] |= (u64::MAX << from) & (u64::MAX >> (64 - to));
    }
}

/// The planes of several clusters as those of one: what a bound of a group of clusters is fitted
/// to.
#[must_use]
pub fn join<'a>(parts: impl IntoIterator<Item = &'a ClusterPlanes>) -> ClusterPlanes {
    let parts: Vec<_> = parts.into_iter().collect();
    let complete = parts.iter().all(|p| p.is_complete());
    let parts: Vec<_> = parts.into_iter().filter(|p| !p.is_empty()).collect();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for part in &parts {
        // The corners are known from the middle, give or take the rounding of a sum.
        let (centre, half) = (part.centre(), part.half_extent());
        let slack = part.largest() * (4.0 * f64::EPSILON);
        for k in 0..3 {
            low[k] = low[k].min(centre[k] - half[k] - slack);
            high[k] = high[k].max(centre[k] + half[k] + slack);
        }
    }
    let planes = parts.iter().flat_map(|p| p.half_spaces());
    ClusterPlanes::of_planes(planes, [low, high], complete)
}
