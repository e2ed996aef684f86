//! Sorting many boxes into blocks, in steps that may each run as jobs.
//!
//! Where a box lies along the curve decides its bucket; whole boxes are scattered into the buckets, and
//! each bucket, which fits in the second cache, is sorted and gathered for itself. Boxes are thus read at
//! random only where they are near. Sorting numbers alone, with every box fetched from where it came at
//! the end, took twice as long for a million: each fetch missed the caches.
//!
//! A safe scatter by several threads needs places that are theirs alone: each job takes some of the buckets, and
//! reads all keys for them, four bytes a box.

use std::ops::Range;

use bytemuck::Zeroable;

use super::Handle;
use super::order::{Curve, Extent, radix_sort};
use crate::Simd;
use crate::bounds::{Aabb, BoxBlock, Boxes, LANES, gather_into};

/// The upper bits of a key tell its bucket: as many streams as the first cache has lines for.
const BUCKETS: usize = 256;
const BUCKET_SHIFT: u32 = 24;
/// Digits of 256 values that the rest of the key has.
const PASSES: usize = 3;
/// Buckets smaller than this are sorted by comparing: emptying the counters would take longer.
const FEW: usize = 128;
/// Keys of which a scattering job picks its own before it moves their boxes.
const PICKED: usize = 1024;

/// Result of [`sort`].
pub(super) struct Sorted {
    /// One handle per slot. Its index is the number of the box in the input.
    pub(super) handles: Vec<Handle>,
    pub(super) boxes: Boxes,
    pub(super) curve: Curve,
}

/// A box on its way to its slot.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
struct Record {
    bounds: Aabb,
    number: u32,
    key: u32,
}

/// A part of building a hierarchy, to be called once on any thread.
#[derive(Debug)]
pub struct BuildJob<'a>(Step<'a>);

/// Result of a [`BuildJob`]: give it back to
/// [`Hierarchy::build_in_jobs`](super::Hierarchy::build_in_jobs).
#[derive(Debug)]
pub struct BuildDone(());

#[derive(Debug)]
enum Step<'a> {
    Measure { items: &'a [Aabb], extent: &'a mut Extent },
    Key { items: &'a [Aabb], curve: &'a Curve, keys: &'a mut [u32], counts: &'a mut [u32; BUCKETS] },
    Scatter(Scatter<'a>),
    Sort(Sort<'a>),
}

impl BuildJob<'_> {
    /// Does it.
    #[must_use]
    pub fn run(self) -> BuildDone {
        match self.0 {
            Step::Measure { items, extent } => items.iter().for_each(|b| extent.add(b)),
            Step::Key { items, curve, keys, counts } => {
                for (b, key) in items.iter().zip(keys) {
                    *key = curve.key(b);
                    counts[bucket_of(*key)] += 1;
                }
            }
            Step::Scatter(scatter) => scatter.run(),
            Step::Sort(sort) => sort.run(),
        }
        BuildDone(())
    }
}

fn bucket_of(key: u32) -> usize {
    (key >> BUCKET_SHIFT) as usize
}

/// Sorts `items` along a curve through them. The order is that of [`spatial_order`](super::spatial_order).
pub(super) fn sort(
    level: Simd,
    items: &[Aabb],
    jobs: usize,
    run: &mut dyn FnMut(Vec<BuildJob<'_>>) -> Vec<BuildDone>,
) -> Sorted {
    let mut step = |jobs: Vec<BuildJob<'_>>| {
        let expected = jobs.len();
        let done = run(jobs).len();
        assert_eq!(done, expected, "jobs done, of those given");
    };
    let share = items.len().div_ceil(jobs).max(1);
    let shares = items.len().div_ceil(share);

    let mut extents = vec![Extent::default(); shares];
    let all = items.chunks(share).zip(&mut extents);
    step(all.map(|(items, extent)| BuildJob(Step::Measure { items, extent })).collect());
    let mut extent = Extent::default();
    extents.iter().for_each(|part| extent.merge(part));
    let curve = Curve::new(&extent);

    let mut keys = vec![0; items.len()];
    let mut counts = vec![[0; BUCKETS]; shares];
    let all = items.chunks(share).zip(keys.chunks_mut(share)).zip(&mut counts);
    let job = |((items, keys), counts)| BuildJob(Step::Key { items, curve: &curve, keys, counts });
    step(all.map(job).collect());
    let mut starts = vec![0; BUCKETS + 1];
    for b in 0..BUCKETS {
        starts[b + 1] = starts[b] + counts.iter().map(|c| c[b] as usize).sum::<usize>();
    }

    // Each job takes whole buckets, as near to its share as they can be.
    let first_of = |job: usize| starts.partition_point(|&s| s < job * items.len() / jobs);
    let parts = (0..jobs)
        .map(|job| first_of(job)..if job + 1 < jobs { first_of(job + 1) } else { BUCKETS });
    let parts: Vec<Range<usize>> =
        parts.filter(|part| starts[part.start] < starts[part.end]).collect();

    let mut records: Vec<Record> = bytemuck::zeroed_vec(items.len());
    let mut rest = &mut *records;
    let all = parts.iter().map(|part| {
        let (first, end) = (starts[part.start], starts[part.end]);
        let records = rest.split_off_mut(..end - first).unwrap_or_default();
        let places = starts[part.clone()].iter().map(|s| (s - first) as u32).collect();
        BuildJob(Step::Scatter(Scatter {
            items,
            keys: &keys,
            buckets: part.clone(),
            places,
            records,
        }))
    });
    step(all.collect());

    let mut boxes = Boxes::zeroed(items.len());
    let mut handles = vec![Handle { index: 0, generation: 0 }; items.len()];
    let (mut blocks, mut passed) = (boxes.blocks_mut(), 0);
    let mut rest = &mut *handles;
    let all = parts.iter().map(|part| {
        let slots = starts[part.start]..starts[part.end];
        let whole = whole_blocks(&slots);
        let _shared = blocks.split_off_mut(..whole.start - passed);
        passed = whole.end;
        let own = blocks.split_off_mut(..whole.len()).unwrap_or_default();
        let handles = rest.split_off_mut(..slots.len()).unwrap_or_default();
        BuildJob(Step::Sort(Sort {
            level,
            records: &records[slots.clone()],
            ends: starts[part.start + 1..=part.end].iter().map(|s| s - slots.start).collect(),
            skip: (whole.start * LANES).min(slots.end) - slots.start,
            handles,
            blocks: own,
        }))
    });
    step(all.collect());
    // Blocks at the borders of jobs hold boxes of two.
    for part in &parts {
        let slots = starts[part.start]..starts[part.end];
        let whole = whole_blocks(&slots);
        let before = slots.start..(whole.start * LANES).min(slots.end);
        let after = (whole.end * LANES).clamp(before.end, slots.end)..slots.end;
        for slot in before.chain(after) {
            boxes.set(slot, &items[handles[slot].index as usize]);
        }
    }
    Sorted { handles, boxes, curve }
}

/// The blocks of which all slots are among these.
fn whole_blocks(slots: &Range<usize>) -> Range<usize> {
    let first = slots.start.div_ceil(LANES);
    first..(slots.end / LANES).max(first)
}

/// Moves the boxes of some buckets there.
#[derive(Debug)]
struct Scatter<'a> {
    items: &'a [Aabb],
    keys: &'a [u32],
    buckets: Range<usize>,
    /// Where the next of each bucket goes.
    places: Vec<u32>,
    records: &'a mut [Record],
}

impl Scatter<'_> {
    fn run(mut self) {
        if self.buckets == (0..BUCKETS) {
            (0..self.items.len()).for_each(|i| self.move_one(i));
            return;
        }
        let mut picked = [0; PICKED];
        for first in (0..self.keys.len()).step_by(PICKED) {
            let some = &self.keys[first..(first + PICKED).min(self.keys.len())];
            // Written whether it counts or not: no branch that is wrong half the time.
            let mut count = 0;
            for (i, &key) in some.iter().enumerate() {
                picked[count] = first + i;
                count += usize::from(self.buckets.contains(&bucket_of(key)));
            }
            picked[..count].iter().for_each(|&i| self.move_one(i));
        }
    }

    #[inline(always)]
    fn move_one(&mut self, i: usize) {
        let key = self.keys[i];
        let place = &mut self.places[bucket_of(key) - self.buckets.start];
        self.records[*place as usize] = Record { bounds: self.items[i], number: i as u32, key };
        *place += 1;
    }
}

/// Sorts the buckets of a job, one after another, and fills its blocks while a bucket is near.
#[derive(Debug)]
struct Sort<'a> {
    level: Simd,
    records: &'a [Record],
    /// Where each bucket ends.
    ends: Vec<usize>,
    /// How many come first whose block is another's too.
    skip: usize,
    handles: &'a mut [Handle],
    blocks: &'a mut [BoxBlock],
}

impl Sort<'_> {
    fn run(mut self) {
        let (mut keys, mut other, mut waiting) = (Vec::new(), Vec::new(), Vec::<u32>::new());
        let mut first = 0;
        for &end in &self.ends {
            let bucket = first as u64..end as u64;
            keys.clear();
            let records = &self.records[first..end];
            keys.extend(bucket.zip(records).map(|(i, r)| u64::from(r.key) << 32 | i));
            if keys.len() < FEW {
                keys.sort_unstable();
            } else {
                radix_sort::<256, PASSES>(&mut keys, &mut other);
            }
            for (to, &key) in self.handles[first..end].iter_mut().zip(&keys) {
                to.index = self.records[key as u32 as usize].number;
            }
            waiting.extend(keys.iter().map(|&key| key as u32));
            let skipped = self.skip.min(waiting.len());
            self.skip -= skipped;
            let (whole, _) = waiting[skipped..].as_chunks::<LANES>();
            let count = whole.len();
            let blocks = self.blocks.split_off_mut(..count).unwrap_or_default();
            gather_into(self.level, blocks, whole, |i| self.records[i as usize].bounds);
            waiting.drain(..skipped + count * LANES);
            first = end;
        }
    }
}
