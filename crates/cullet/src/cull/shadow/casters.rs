//! Batches of casters against a region.

use fearless_simd::Level;

use super::region::{CasterReason, CasterRegion};
use crate::bits;
use crate::bounds::Boxes;
use crate::cull::Indices;
use crate::cull::frustum::batch::{list_bound, mask_boxes, mask_words};
use crate::cull::frustum::tree::Cut;
use crate::cull::output::expand;
use crate::hierarchy::Nodes;

/// The casters of a batch that matter to a light and a view. Keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct ShadowCasters {
    kept: Vec<u64>,
    /// The words of `kept` that may not be zero, ascending: so that nothing costs more than what is kept.
    touched: Vec<u32>,
    len: usize,
    cut: Cut,
}

/// How many casters went, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CasterCounts {
    /// How many there were.
    pub casters: u64,
    /// How many may matter.
    pub kept: u64,
    /// How many were dropped because nothing that the view sees is lit.
    pub no_receiver: u64,
    /// How many are farther from the light than it reaches.
    pub beyond_range: u64,
    /// How many are outside the spot's cone.
    pub outside_cone: u64,
    /// How many are outside the planes of the sweep.
    pub outside_sweep: u64,
}

impl ShadowCasters {
    /// None kept of none.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Keeps the casters whose shadow may fall on what the view sees; see [`CasterRegion::new`] for what that
    /// promises. A box that is not finite is kept, unless there is no receiver at all; an empty one is dropped if the
    /// region has a plane.
    ///
    /// With `nodes` over `boxes`, or over the first of them, whole groups are asked first; the answer is the same,
    /// at every level. Allocates only when there were never as many.
    ///
    /// # Panics
    /// If the nodes are over more boxes than there are.
    pub fn cull(
        &mut self,
        level: Level,
        region: &CasterRegion,
        nodes: Option<&Nodes>,
        boxes: &Boxes,
    ) {
        for word in self.touched.drain(..) {
            self.kept[word as usize] = 0;
        }
        self.len = boxes.len();
        self.kept.resize(mask_words(boxes.len()), 0);
        if region.no_receiver() {
            return;
        }
        if let Some(nodes) = nodes {
            self.cut.cull(level, region.planes(), nodes, boxes);
            for word in self.cut.touched() {
                self.kept[word] = self.cut.visible()[word];
                self.touched.push(word as u32);
            }
        } else {
            mask_boxes(level, region.planes(), boxes, 0, &mut self.kept);
            self.touched.extend(0..self.kept.len() as u32);
        }
        if region.has_sphere() {
            for &word in &self.touched {
                let kept = &mut self.kept[word as usize];
                for bit in bits::ones(*kept) {
                    let b = boxes.get(word as usize * 64 + bit);
                    *kept &= !(u64::from(region.is_beyond_range(&b)) << bit);
                }
            }
        }
    }

    /// One bit a caster: it may matter. Bits past the last are clear.
    #[must_use]
    pub fn kept(&self) -> &[u64] {
        &self.kept
    }

    /// How many may matter.
    #[must_use]
    pub fn count(&self) -> usize {
        self.touched.iter().map(|&w| self.kept[w as usize].count_ones() as usize).sum()
    }

    /// Lists those that may matter, ascending.
    pub fn list(&self, level: Level, kept: &mut Indices) {
        kept.fill(list_bound(self.len), |out| {
            let mut len = 0;
            for &word in &self.touched {
                let bits = &self.kept[word as usize..=word as usize];
                len += expand(level, bits, word * 64, &mut out[len..]);
            }
            len
        });
    }

    /// For each caster, why it does not matter; `None` if it may. Two bytes each; one by one for what was dropped.
    /// `region` and `boxes` are those of the last [`cull`](Self::cull).
    ///
    /// # Panics
    /// If `reasons` or `boxes` is not as long as what was culled.
    pub fn reasons_into(
        &self,
        region: &CasterRegion,
        boxes: &Boxes,
        reasons: &mut [Option<CasterReason>],
    ) {
        let lens = (boxes.len(), reasons.len());
        assert_eq!(lens, (self.len, self.len), "casters and reasons for {} culled", self.len);
        for (i, reason) in reasons.iter_mut().enumerate() {
            *reason = (!bits::get(&self.kept, i)).then(|| region.reason(boxes, i)).flatten();
        }
    }

    /// How many went for each reason. Costs as [`reasons_into`](Self::reasons_into), and has the same needs.
    ///
    /// # Panics
    /// If `boxes` is not as long as what was culled.
    #[must_use]
    pub fn counts(&self, region: &CasterRegion, boxes: &Boxes) -> CasterCounts {
        assert_eq!(boxes.len(), self.len, "as many boxes as were culled");
        let mut counts = CasterCounts { casters: self.len as u64, ..CasterCounts::default() };
        for i in 0..self.len {
            let kept = bits::get(&self.kept, i);
            let of = match (!kept).then(|| region.reason(boxes, i)).flatten() {
                None => &mut counts.kept,
                Some(CasterReason::NoReceiver) => &mut counts.no_receiver,
                Some(CasterReason::BeyondRange) => &mut counts.beyond_range,
                Some(CasterReason::OutsideCone) => &mut counts.outside_cone,
                Some(CasterReason::OutsideSweep(_)) => &mut counts.outside_sweep,
            };
            *of += 1;
        }
        counts
    }
}
