//! Frustum tests of batches, with SIMD.
//!
//! A frustum is prepared once ([`Planes::new`]); then boxes are tested sixteen at a time and the
//! answer comes as a bit mask, an ascending list of indices, a count, three ways (outside, inside,
//! straddling), or as the plane that rejects. Answers are the same at every [`Simd`], the scalar
//! one included: products and sums are rounded one by one, never fused. Spheres are only listed
//! ([`cull_spheres`]).
//!
//! Conservative: what touches the frustum is visible, what is not a number is visible, and what is
//! called inside is inside, in exact arithmetic (the argument stands at [`Boxes`]' module).
//! "Visible" is by planes alone: a box near an edge of the frustum can be
//! visible without touching it; see [`exact`](super::exact).
//!
//! ```
//! use cullet::bounds::{Aabb, Boxes, Plane};
//! use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
//! use cullet::{Simd, view::Frustum};
//!
//! // Everything with x ≤ 10.
//! let wall = Plane::new([1.0, 0.0, 0.0], 10.0);
//! let planes = Planes::new(&Frustum::from_planes([Some(wall), None, None, None, None, None]));
//! let boxes = Boxes::from_slice(&[
//!     Aabb::new([0.0; 3], [1.0; 3]),
//!     Aabb::new([11.0; 3], [12.0; 3]),
//!     Aabb::new([9.0; 3], [11.0; 3]),
//! ]);
//! let mut visible = Indices::new();
//! cull_boxes(Simd::best(), &planes, &boxes, &mut visible);
//! assert_eq!(*visible, [0, 2]);
//! ```

mod boxes;
pub(in crate::cull::frustum) mod planes;
mod spheres;
pub(in crate::cull::frustum) mod words;

use crate::Simd;
use crate::bounds::Boxes;
use crate::cull::output::expand;

pub use crate::cull::Indices;
pub use planes::Planes;
pub use spheres::{SpherePlanes, cull_spheres};

/// Words that are tested before they are made a list: 32768 items, whose mask stays close.
const WORDS_AT_ONCE: usize = 512;

/// The value of [`reject_boxes`] for what no plane rejects.
pub const VISIBLE: u8 = u8::MAX;

/// Words of a mask for `len` items: one bit each.
#[must_use]
pub const fn mask_words(len: usize) -> usize {
    len.div_ceil(64)
}

/// Lists the visible boxes, ascending.
///
/// Allocates only when `visible` has never held a batch as large. At most one pass over the
/// batch; the time does not depend on how many are visible.
pub fn cull_boxes(simd: Simd, planes: &Planes, boxes: &Boxes, visible: &mut Indices) {
    list(simd, boxes.len(), visible, |first, words| {
        mask_boxes(simd, planes, boxes, first, words);
    });
}

/// Sets bit i of `words` where a box is visible: bit 0 of `words[0]` is box 64 · `first_word`. Bits
/// past the last box are clear.
///
/// Several threads may each fill a part of one mask.
pub fn mask_boxes(
    simd: Simd,
    planes: &Planes,
    boxes: &Boxes,
    first_word: usize,
    words: &mut [u64],
) {
    boxes::visible(simd, planes, boxes, first_word, words);
}

/// Returns the number of visible boxes.
#[must_use]
pub fn count_boxes(simd: Simd, planes: &Planes, boxes: &Boxes) -> usize {
    let mut count = 0;
    each_part(mask_words(boxes.len()), |first, words| {
        mask_boxes(simd, planes, boxes, first, words);
        count += words.iter().map(|w| w.count_ones() as usize).sum::<usize>();
    });
    count
}

/// Sets the bit of each box in `visible` unless it is outside, and in `inside` if it is proved
/// inside every plane; visible without inside is straddling. Words as in [`mask_boxes`].
///
/// Costs up to twice the mask; words without anything visible cost no more than there.
///
/// # Panics
/// If the two masks differ in length.
pub fn classify_boxes(
    simd: Simd,
    planes: &Planes,
    boxes: &Boxes,
    first_word: usize,
    visible: &mut [u64],
    inside: &mut [u64],
) {
    assert!(visible.len() == inside.len(), "one word of each mask for the same items");
    mask_boxes(simd, planes, boxes, first_word, visible);
    boxes::inside(simd, planes, boxes, first_word, visible, inside);
}

/// Writes for each box the number of the first plane that rejects it, or [`VISIBLE`]. `reasons[0]`
/// is box `first`. Slower: the mask, and then one by one what is outside.
///
/// # Panics
/// If `reasons` reaches past the batch.
pub fn reject_boxes(simd: Simd, planes: &Planes, boxes: &Boxes, first: usize, reasons: &mut [u8]) {
    let last = first + reasons.len();
    assert!(last <= boxes.len(), "boxes {first}..{last} of a batch of {}", boxes.len());
    let mut word = [0];
    let mut held = usize::MAX;
    for (i, reason) in (first..).zip(reasons) {
        if i / 64 != held {
            held = i / 64;
            mask_boxes(simd, planes, boxes, held, &mut word);
        }
        let is_visible = word[0] >> (i % 64) & 1 == 1;
        *reason = if is_visible { VISIBLE } else { planes.first_rejecting(boxes, i) };
    }
}

/// Lists the set bits of a mask for `len` items, which `fill` fills word by word: it gets the first
/// word and the words.
fn list(simd: Simd, len: usize, visible: &mut Indices, mut fill: impl FnMut(usize, &mut [u64])) {
    // Whole vectors are stored.
    visible.fill(len.next_multiple_of(64), |out| {
        let mut listed = 0;
        each_part(mask_words(len), |first, words| {
            fill(first, words);
            listed += expand(simd, words, (first * 64) as u32, &mut out[listed..]);
        });
        listed
    });
}

/// Calls `each` for every part of a mask of `all` words, with the first word and zeroed words to
/// fill.
fn each_part(all: usize, mut each: impl FnMut(usize, &mut [u64])) {
    let mut words = [0; WORDS_AT_ONCE];
    for first in (0..all).step_by(WORDS_AT_ONCE) {
        each(first, &mut words[..WORDS_AT_ONCE.min(all - first)]);
    }
}
