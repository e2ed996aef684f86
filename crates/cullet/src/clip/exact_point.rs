//! Points in exact arithmetic, for the oracles of this room.

use super::region::HalfSpace;
use crate::exact::Exact;

/// A point with a common denominator, which is positive: no division, so no rounding.
#[derive(Clone, Debug)]
pub(super) struct ExactPoint<const D: usize> {
    numerators: [Exact; D],
    denominator: Exact,
}

impl<const D: usize> ExactPoint<D> {
    pub(super) fn new(p: &[f64; D]) -> Self {
        Self { numerators: p.map(Exact::from), denominator: Exact::from(1.0) }
    }

    /// n·x − d, times the denominator.
    pub(super) fn height(&self, side: &HalfSpace<f64, D>) -> Exact {
        Exact::dot(&side.normal().map(Exact::from), &self.numerators)
            .minus(&self.denominator.times(&side.d().into()))
    }

    /// Where the edge from p, of height below zero, to q, above, crosses.
    pub(super) fn crossing(p: &Self, height_p: &Exact, q: &Self, height_q: &Exact) -> Self {
        // (p·hq − q·hp) / (hq − hp), and each height carries its point's denominator.
        let blend = |a: &Exact, b: &Exact| a.times(height_q).minus(&b.times(height_p));
        Self {
            numerators: std::array::from_fn(|i| blend(&p.numerators[i], &q.numerators[i])),
            denominator: blend(&p.denominator, &q.denominator),
        }
    }

    pub(super) fn rounded(&self) -> [f64; D] {
        let w = self.denominator.value();
        std::array::from_fn(|i| self.numerators[i].value() / w)
    }
}
