//! Which occluders are worth drawing.

use super::{Footprint, OcclusionBuffer, Shape};

/// How to find what is hidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// Pixels across the buffer; its height follows from the viewport. Never more than the viewport has. Half of the
    /// screen finds nearly as much as all of it, at a quarter of the cost; the answer is never wrong. Default 640.
    pub width: u32,
    /// What drawing occluders may cost, in microseconds of a cost model, not of a clock: so the same scene, view
    /// and budget give the same answer on every machine. 0 draws none. Default 2000.
    pub budget: f32,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { width: 640, budget: 2000.0 }
    }
}

impl Occlusion {
    /// How many shapes the budget could pay for, if each were of the cheapest.
    pub(crate) fn most_shapes(&self) -> usize {
        (self.budget / Candidate::LEAST_COST) as usize
    }

    /// The size of the buffer for a viewport.
    #[must_use]
    pub fn size(&self, viewport: [u32; 2]) -> [u32; 2] {
        let [width, height] = viewport.map(|v| v.clamp(1, OcclusionBuffer::LIMIT));
        let columns = self.width.clamp(1, width);
        let rows = (u64::from(height) * u64::from(columns)).div_ceil(u64::from(width));
        [columns, (rows as u32).clamp(1, OcclusionBuffer::LIMIT)]
    }
}

/// A shape that may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    /// Pixels of the rectangle around it.
    pub(crate) pixels: f32,
    /// How near it comes; infinite where it crosses the near plane.
    pub(crate) nearness: f32,
    pub(crate) slot: u32,
    pub(crate) shape: u32,
    /// Microseconds that drawing it is taken to cost.
    pub(crate) cost: f32,
    /// The pixels that it may touch; `None` where it crosses the near plane.
    pub(crate) footprint: Option<Footprint>,
}

impl Candidate {
    /// No shape costs less.
    const LEAST_COST: f32 = 0.1;

    /// What drawing a shape over `pixels` costs, in microseconds.
    pub(crate) fn cost(shape: &Shape, pixels: f32) -> f32 {
        match shape {
            Shape::Convex(convex) => {
                Self::LEAST_COST + 0.005 * convex.edges.len() as f32 + pixels * 2e-5
            }
            // Those around it are drawn too.
            Shape::Patch(patch) => 0.5 + patch.triangles.len() as f32 * 0.08 + pixels * 2e-4,
        }
    }
}

/// Keeps of the candidates those that cover most for their cost, as far as the budget goes, and puts them front to
/// back. Ties go by slot and shape, so the order in which they came does not matter.
pub(crate) fn choose(candidates: &mut Vec<Candidate>, budget: f32) {
    // Where all can be paid for, with more to spare than the rounding of any sum, which of them are better is no matter.
    let all: f64 = candidates.iter().map(|c| f64::from(c.cost)).sum();
    let affordable = candidates.len() < 100_000 && all * 1.01 <= f64::from(budget);
    if !affordable {
        candidates.sort_unstable_by(|a, b| {
            let worth = |c: &Candidate| c.pixels / c.cost;
            worth(b).total_cmp(&worth(a)).then((a.slot, a.shape).cmp(&(b.slot, b.shape)))
        });
        let mut spent = 0.0;
        let affordable = candidates.iter().take_while(|c| {
            spent += c.cost;
            spent <= budget
        });
        let count = affordable.count();
        candidates.truncate(count);
    }
    candidates.sort_unstable_by(|a, b| {
        b.nearness.total_cmp(&a.nearness).then((a.slot, a.shape).cmp(&(b.slot, b.shape)))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_buys_what_covers_most_and_order_does_not_matter() {
        let candidate = |slot: u32, pixels: f32, nearness: f32| Candidate {
            pixels,
            nearness,
            slot,
            shape: 0,
            cost: 1.0,
            footprint: None,
        };
        let all = [
            candidate(0, 10.0, 0.1),
            candidate(1, 500.0, 0.2),
            candidate(2, 500.0, f32::INFINITY),
            candidate(3, 90.0, 0.9),
        ];
        let slots = |mut list: Vec<Candidate>, budget| {
            choose(&mut list, budget);
            list.iter().map(|c| c.slot).collect::<Vec<_>>()
        };
        assert_eq!(slots(all.to_vec(), 3.0), [2, 3, 1]);
        assert_eq!(slots(all.iter().rev().copied().collect(), 3.0), [2, 3, 1]);
        assert_eq!(slots(all.to_vec(), 0.0), []);
        assert_eq!(slots(all.to_vec(), f32::NAN), []);
        assert_eq!(slots(all.to_vec(), 1e9).len(), 4);
    }

    #[test]
    fn sizes_follow_the_viewport() {
        let of = |width| Occlusion { width, ..Occlusion::default() };
        assert_eq!(of(640).size([1280, 720]), [640, 360]);
        assert_eq!(of(640).size([320, 33]), [320, 33]);
        assert_eq!(of(0).size([1280, 720]), [1, 1]);
        assert_eq!(of(7).size([65536, 65536]), [7, 7]);
    }
}
