//! The engine's elliptic cone as one bound of many.

use cullet::Simd;
use cullet::cull::backface::{ClusterEye, ClusterPlanes, EllipticCone, EllipticCones};

use super::margin::elliptic_margin;
use super::{Batch, Bound};

impl Bound for EllipticCone {
    type Batch = EllipticCones;

    /// Without doubt: for an eye that is exact.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        Self::fit_doubting(planes, 0.0)
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        Self::is_behind_eye(self, eye)
    }

    fn margin(&self, eye: [f64; 3]) -> f64 {
        elliptic_margin(self.apex, [self.axis, self.s, self.t], eye)
    }
}

impl Batch<EllipticCone> for EllipticCones {
    fn push(&mut self, bound: Option<EllipticCone>) {
        Self::push(self, bound);
    }

    fn len(&self) -> usize {
        Self::len(self)
    }

    fn cull_words(&self, simd: Simd, eye: &ClusterEye, first: usize, culled: &mut [u64]) {
        Self::cull_words(self, simd, eye, first, culled);
    }
}
