//! Cost of drawing shapes, by the model of [`OccluderCosts`].

use crate::costs::{DrawingCosts, OccluderCosts};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Edges of a shape, on which the cost of drawing it depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeCount {
    Convex(u32),
    Patch(u32),
}

/// Cost model of drawing, in microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CostModel {
    convex: Terms,
    patch: Terms,
}

/// Terms of [`DrawingCosts`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Terms {
    base: f32,
    edge: f32,
    outline: f32,
    pixel: f32,
}

impl Terms {
    fn new(costs: &DrawingCosts) -> Self {
        let of = |ns: f64| (ns / 1000.0) as f32;
        Self {
            base: of(costs.base_ns),
            edge: of(costs.edge_ns),
            outline: of(costs.outline_ns),
            pixel: of(costs.pixel_ns),
        }
    }

    fn cost(&self, edges: u32, pixels: f32) -> f32 {
        (self.base + self.edge * edges as f32) + pixels.sqrt() * self.outline + pixels * self.pixel
    }
}

impl CostModel {
    pub(crate) fn new(costs: &OccluderCosts) -> Self {
        Self { convex: Terms::new(&costs.convex), patch: Terms::new(&costs.patch) }
    }

    /// Cost of a shape over so many pixels.
    pub(crate) fn cost(&self, edges: EdgeCount, pixels: f32) -> f32 {
        match edges {
            EdgeCount::Convex(edges) => self.convex.cost(edges, pixels),
            EdgeCount::Patch(edges) => self.patch.cost(edges, pixels),
        }
    }

    /// No shape of at most such a value has a higher score, where none costs less than `least` and
    /// no pixel has more than `densest` of the value. (Pixels rise faster than their cost, so that
    /// a smaller shape has the lower score; the bound is raised by more than what rounding does to
    /// either.)
    pub(crate) fn score(&self, least: LeastCost, value: f32, densest: f32) -> f32 {
        let fewest = value / densest;
        let of = |edges: EdgeCount| value / self.cost(edges, fewest);
        let convex = least.convex.map_or(0.0, |edges| of(EdgeCount::Convex(edges)));
        let patch = least.patch.map_or(0.0, |edges| of(EdgeCount::Patch(edges)));
        convex.max(patch) * (1.0 + 1e-5)
    }
}

/// The fewest edges of some shapes of each kind: none of them costs less than such a shape over as
/// many pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LeastCost {
    convex: Option<u32>,
    patch: Option<u32>,
}

impl LeastCost {
    /// The least cost of shapes that are not known: that of a convex shape without edges.
    pub(crate) const ANY: Self = Self { convex: Some(0), patch: None };

    pub(super) fn of(shapes: &[EdgeCount]) -> Self {
        shapes.iter().fold(Self::default(), |least, &edges| {
            least.or(match edges {
                EdgeCount::Convex(edges) => Self { convex: Some(edges), patch: None },
                EdgeCount::Patch(edges) => Self { convex: None, patch: Some(edges) },
            })
        })
    }

    /// Returns the fewest edges of the shapes of both, for each kind.
    pub(crate) fn or(self, other: Self) -> Self {
        let least = |a: Option<u32>, b: Option<u32>| a.into_iter().chain(b).min();
        Self { convex: least(self.convex, other.convex), patch: least(self.patch, other.patch) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_shape_has_a_higher_score_than_the_bound_of_larger_ones() {
        let model = CostModel::new(&OccluderCosts::default());
        for edges in [0, 3, 12, 300] {
            for is_patch in [false, true] {
                let count = |n| if is_patch { EdgeCount::Patch(n) } else { EdgeCount::Convex(n) };
                let least = LeastCost::of(&[count(edges)]);
                for pixels in (0..2000).map(|i| (i * i) as f32 * 0.37) {
                    let cost = model.cost(count(edges + 2), pixels);
                    for larger in [pixels, pixels + 1.0, pixels * 9.0] {
                        // A pixel has at most thrice the mean, and this shape has less.
                        for density in [1.0, 0.3, 3.0] {
                            let (score, larger) = (pixels * density / cost, larger * density);
                            let any = least.or(LeastCost::ANY);
                            assert!(score <= model.score(any, larger, 3.0));
                            assert!(
                                score <= model.score(least, larger, 3.0),
                                "{pixels} of {edges}"
                            );
                        }
                    }
                }
            }
        }
        assert_eq!(model.score(LeastCost::default(), 1e6, 1.0), 0.0);
    }

    #[test]
    fn the_default_model_is_in_microseconds_what_the_costs_are_in_nanoseconds() {
        let model = CostModel::new(&OccluderCosts::default());
        assert_eq!(model.convex, Terms { base: 0.33, edge: 0.005, outline: 0.005, pixel: 2e-5 });
        assert_eq!(model.patch, Terms { base: 0.65, edge: 0.007, outline: 0.002, pixel: 3e-5 });
    }
}
