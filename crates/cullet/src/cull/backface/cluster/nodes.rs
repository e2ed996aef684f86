//! Bounds of normals on the nodes of a hierarchy over clusters: whole nodes seen from behind go at once,
//! whole nodes seen from the front are taken at once.

use fearless_simd::{Level, Simd, dispatch};

use super::{BatchBound, ClusterBounds, ClusterEye, ClusterPlanes};
use crate::bits;
use crate::bounds::LANES;

/// Bounds of normals on the nodes of [`hierarchy::Nodes`](crate::hierarchy::Nodes) over clusters: node i of
/// a level is over sixteen of the level below, 16 i to 16 i + 15. So whoever has such nodes for the frustum
/// needs no second grouping. For other groups fit a bound to each, of [`ClusterPlanes::join`].
///
/// A node's bound is fitted to all planes below it, not to the bounds of its children, and may prove what
/// theirs do not: so a walk culls what [`ClusterBounds::cull`] does, and perhaps a little more, and all of
/// it is proved.
///
/// Scanned surfaces gain nothing: sixteen clusters mostly face both ways. From three radii the bunny's 930
/// clusters cost 101 % of the blocks of a flat sweep and 2.1 times its time (1.7 µs for 0.8), the
/// armadillo's 1138 cost 108 % and 2.0 times (`cargo test --release -p cullet --test backface_nodes --
/// --nocapture`). It pays where many clusters lie in planes or bend little; see
/// [`blocks_asked`](ClusterCut::blocks_asked).
#[derive(Clone, Debug)]
pub struct ClusterNodes<B: BatchBound> {
    /// Of the clusters, then of each level of nodes up to one of at most sixteen: where all is seen from
    /// behind, and from the front.
    levels: Vec<[ClusterBounds<B>; 2]>,
}

/// What an eye sees of clusters.
#[derive(Clone, Debug, Default)]
pub struct ClusterCut {
    culled: Vec<u64>,
    front: Vec<u64>,
    blocks: [Vec<u32>; 2],
    asked: usize,
}

impl ClusterCut {
    /// Of no cluster.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// One bit a cluster: it is proved to be seen from behind. Bits beyond the last are 0.
    #[must_use]
    pub fn culled(&self) -> &[u64] {
        &self.culled
    }

    /// One bit a cluster: it is proved to be seen from the front, so none of its triangles need be asked.
    #[must_use]
    pub fn front(&self) -> &[u64] {
        &self.front
    }

    /// How many blocks of sixteen nodes or clusters were tested, for both sides.
    #[must_use]
    pub fn blocks_asked(&self) -> usize {
        self.asked
    }
}

/// The planes below a node; `None` once they span too much for any bound.
type Below = Option<ClusterPlanes>;

impl<B: BatchBound> ClusterNodes<B> {
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
                // What is above has these planes and more, and fits no better. A cluster of no triangle
                // has no bound, but hinders none.
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
                parts.map(ClusterPlanes::join)
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
    pub fn cull(&self, level: Level, eye: [f64; 4], cut: &mut ClusterCut) {
        for mask in [&mut cut.culled, &mut cut.front] {
            mask.clear();
            mask.resize(self.len().div_ceil(64), 0);
        }
        cut.asked = 0;
        if let Some(eye) = ClusterEye::new(eye).filter(|_| !self.is_empty()) {
            dispatch!(level, simd => self.walk(simd, &eye, cut));
        }
    }

    #[inline(always)]
    fn walk<S: Simd>(&self, simd: S, eye: &ClusterEye, cut: &mut ClusterCut) {
        let ClusterCut { culled, front, blocks: [here, next], asked } = cut;
        here.clear();
        here.push(0);
        for (at, bounds) in self.levels.iter().enumerate().rev() {
            // How many clusters one of this level stands for.
            let unit = LANES.pow(at as u32);
            next.clear();
            *asked += here.len();
            for &block in &*here {
                let first = block as usize * LANES;
                let left = (bounds[0].len() - first).min(LANES);
                // Not by a closure: see `to_eye`.
                let back = bounds[0].block(simd, block as usize, eye);
                let forth = bounds[1].block(simd, block as usize, eye);
                for (mask, found) in [(&mut *culled, back), (&mut *front, forth)] {
                    for run in bits::runs(found) {
                        let end = ((first + run.end) * unit).min(self.len());
                        bits::words_of((first + run.start) * unit..end)
                            .for_each(|(word, bits)| mask[word] |= bits);
                    }
                }
                if at > 0 {
                    let mixed = !(back | forth) & (u64::MAX >> (64 - left));
                    next.extend(bits::ones(mixed).map(|lane| (first + lane) as u32));
                }
            }
            std::mem::swap(here, next);
        }
    }
}
