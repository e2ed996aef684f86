//! Frustum tests of batches, with SIMD.
//!
//! A frustum is prepared once ([`Planes::new`]); then boxes or spheres are tested sixteen at a time and
//! the answer comes as a bit mask, an ascending list of indices, a count, three ways (outside, inside,
//! straddling), or as the plane that rejects. Answers are the same at every [`Simd`], the scalar one
//! included: products and sums are rounded one by one, never fused.
//!
//! Conservative: what touches the frustum is visible, what is not a number is visible, and what is
//! called inside is inside, in exact arithmetic (the argument stands at [`Boxes`]' module and at the
//! sphere test's form below). "Visible" is by planes alone: a box near an edge of the frustum can be
//! visible without touching it; see [`exact`](super::exact).
//!
//! ```
//! use cullet::bounds::{Aabb, Boxes, Plane};
//! use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
//! use cullet::{Frustum, Simd};
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
use crate::bounds::{Aabb, Block, BoxBlock, Boxes, Side, Sphere, SphereBlock, Spheres};

pub use crate::cull::Indices;
pub use planes::Planes;

use crate::cull::output::expand;

/// Words that are tested before they are made a list: 32768 items, whose mask stays close.
const WORDS_AT_ONCE: usize = 512;

/// The value of [`reject_boxes`] for what no plane rejects.
pub const VISIBLE: u8 = u8::MAX;

/// Words of a mask for `len` items: one bit each.
#[must_use]
pub const fn mask_words(len: usize) -> usize {
    len.div_ceil(64)
}

/// Entries that the buffer of [`list_boxes`] and [`list_spheres`] must have for `len` items: `len`
/// rounded up to a multiple of 64, for whole vectors are stored.
#[must_use]
pub const fn list_bound(len: usize) -> usize {
    len.next_multiple_of(64)
}

macro_rules! batch_tests {
    (
        $kind:ident, $what:literal, $batch:ty, $item:ty, $block:ty, $lane:ident:
        $cull:ident, $list:ident, $mask:ident, $count:ident, $classify:ident, $reject:ident,
        $slice:ident, $cull_ref:ident
    ) => {
        #[doc = concat!("Lists the visible ", $what, ", ascending.")]
        ///
        /// Allocates only when `visible` has never held a batch as large. At most one pass over the
        /// batch; the time does not depend on how many are visible.
        pub fn $cull(level: Simd, planes: &Planes, batch: &$batch, visible: &mut Indices) {
            visible.fill(list_bound(batch.len()), |out| $list(level, planes, batch, out));
        }

        #[doc = concat!("Writes the indices of the visible ", $what, " to `out`, ascending, and")]
        /// returns how many there are. Entries after them may be overwritten.
        ///
        /// # Panics
        /// If `out` is shorter than [`list_bound`] of the batch's length.
        pub fn $list(level: Simd, planes: &Planes, batch: &$batch, out: &mut [u32]) -> usize {
            let bound = list_bound(batch.len());
            assert!(out.len() >= bound, "a list of {} entries where {bound} may be", out.len());
            let blocks = (batch.blocks(), batch.len());
            let mut len = 0;
            let mut words = [0; WORDS_AT_ONCE];
            let all = mask_words(batch.len());
            for first in (0..all).step_by(WORDS_AT_ONCE) {
                let words = &mut words[..WORDS_AT_ONCE.min(all - first)];
                $kind::visible(level, planes, blocks, first, words);
                len += expand(level, words, (first * 64) as u32, &mut out[len..]);
            }
            len
        }

        #[doc = concat!("Sets bit i of `words` where one of the ", $what, " is visible: bit 0 of")]
        /// `words[0]` is item 64 · `first_word`. Bits past the last item are clear.
        ///
        /// Several threads may each fill a part of one mask.
        pub fn $mask(
            level: Simd,
            planes: &Planes,
            batch: &$batch,
            first_word: usize,
            words: &mut [u64],
        ) {
            $kind::visible(level, planes, (batch.blocks(), batch.len()), first_word, words);
        }

        #[doc = concat!("How many of the ", $what, " are visible.")]
        #[must_use]
        pub fn $count(level: Simd, planes: &Planes, batch: &$batch) -> usize {
            let mut words = [0; WORDS_AT_ONCE];
            let all = mask_words(batch.len());
            let mut count = 0;
            for first in (0..all).step_by(WORDS_AT_ONCE) {
                let words = &mut words[..WORDS_AT_ONCE.min(all - first)];
                $mask(level, planes, batch, first, words);
                count += words.iter().map(|w| w.count_ones() as usize).sum::<usize>();
            }
            count
        }

        #[doc = concat!("Where each of the ", $what, " lies: sets its bit in `visible` unless it is")]
        /// outside, and in `inside` if it is proved inside every plane; visible without inside is
        /// straddling. Words as in the mask: the first is word `first_word` of the batch.
        ///
        /// Costs up to twice the mask; words without anything visible cost no more than there.
        ///
        /// # Panics
        /// If the two masks differ in length.
        pub fn $classify(
            level: Simd,
            planes: &Planes,
            batch: &$batch,
            first_word: usize,
            visible: &mut [u64],
            inside: &mut [u64],
        ) {
            assert_eq!(visible.len(), inside.len(), "one word of each mask for the same items");
            $mask(level, planes, batch, first_word, visible);
            let blocks = (batch.blocks(), batch.len());
            $kind::inside(level, planes, blocks, first_word, visible, inside);
        }

        #[doc = concat!("For each of the ", $what, " the number of the first plane that rejects it,")]
        /// or [`VISIBLE`]. `reasons[0]` is item `first`. Slower: the mask, and then one by one what is
        /// outside.
        ///
        /// # Panics
        /// If `reasons` reaches past the batch.
        pub fn $reject(
            level: Simd,
            planes: &Planes,
            batch: &$batch,
            first: usize,
            reasons: &mut [u8],
        ) {
            let last = first + reasons.len();
            assert!(last <= batch.len(), "items {first}..{last} of a batch of {}", batch.len());
            let mut word = [0];
            let mut held = usize::MAX;
            for (i, reason) in reasons.iter_mut().enumerate() {
                let item = first + i;
                if item / 64 != held {
                    held = item / 64;
                    $mask(level, planes, batch, held, &mut word);
                }
                *reason = if word[0] >> (item % 64) & 1 == 1 {
                    VISIBLE
                } else {
                    planes.$lane(&batch.blocks()[item / 16].0, item % 16)
                };
            }
        }

        #[doc = concat!("Lists the visible ", $what, " of a slice, ascending, with no batch needed.")]
        ///
        /// The same answer as that of a batch of them. Preparing the items costs some operations each,
        /// so what is tested more than once is better kept in a batch.
        pub fn $slice(level: Simd, planes: &Planes, items: &[$item], visible: &mut Indices) {
            visible.fill(list_bound(items.len()), |out| {
                // As many as stay in the nearest cache between being prepared and being tested.
                const AT_ONCE: usize = 256;
                let mut blocks: [$block; AT_ONCE / 16] = bytemuck::Zeroable::zeroed();
                let mut words = [0; AT_ONCE / 64];
                let mut len = 0;
                for (chunk, part) in items.chunks(AT_ONCE).enumerate() {
                    for (i, item) in part.iter().enumerate() {
                        blocks[i / 16].set(i % 16, item);
                    }
                    let words = &mut words[..mask_words(part.len())];
                    $kind::visible(level, planes, (&blocks, part.len()), 0, words);
                    len += expand(level, words, (chunk * AT_ONCE) as u32, &mut out[len..]);
                }
                len
            });
        }

        #[doc = concat!("The oracle of [`", stringify!($cull), "`]: one item after the other, no SIMD.")]
        #[must_use]
        pub fn $cull_ref(planes: &Planes, batch: &$batch) -> Vec<u32> {
            (0..batch.len())
                .filter(|&i| {
                    planes.$kind(&batch.blocks()[i / 16].0, i % 16) != Side::Outside
                })
                .map(|i| i as u32)
                .collect()
        }
    };
}

batch_tests!(
    boxes, "boxes", Boxes, Aabb, BoxBlock, rejecting_box:
    cull_boxes, list_boxes, mask_boxes, count_boxes, classify_boxes, reject_boxes, cull_box_slice,
    cull_boxes_ref
);

batch_tests!(
    spheres, "spheres", Spheres, Sphere, SphereBlock, rejecting_sphere:
    cull_spheres, list_spheres, mask_spheres, count_spheres, classify_spheres, reject_spheres,
    cull_sphere_slice, cull_spheres_ref
);
