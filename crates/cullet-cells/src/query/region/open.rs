//! Tests of all boxes of a scene against a buffer, the nodes above them first.

use alloc::vec::Vec;

use cullet::Simd;
use cullet::bounds::Boxes;
use cullet::cull::occlusion::OcclusionBuffer;
use cullet::hierarchy::Hierarchy;

use crate::bits;

/// Children of a node.
const CHILDREN: usize = 16;

/// Levels of nodes that are tested: higher ones hold so much that they are hidden next to never.
const LEVELS: usize = 2;

/// Masks of a test, kept for their memory.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenTest {
    wanted: [Vec<u64>; LEVELS],
    leaves: Vec<u64>,
    open: Vec<u64>,
    hidden: Vec<u64>,
}

impl OpenTest {
    /// Sets in `found` the bits of the `wanted` boxes that are neither hidden nor outside of the
    /// buffer's screen. Where a node is hidden or outside, so is what is in it.
    pub(super) fn find(
        &mut self,
        simd: Simd,
        buffer: &OcclusionBuffer,
        hierarchy: &Hierarchy,
        wanted: &[u64],
        found: &mut [u64],
    ) {
        let nodes = hierarchy.nodes();
        self.leaves.clear();
        self.leaves.extend_from_slice(wanted);
        let count = nodes.levels().len().min(LEVELS);
        for at in 0..count {
            let (below, here) = self.wanted.split_at_mut(at);
            let children = below.last().unwrap_or(&self.leaves);
            parents(children, nodes.levels()[at].len(), &mut here[0]);
        }
        for at in (0..count).rev() {
            self.test(simd, buffer, &nodes.levels()[at], at);
            let (below, _) = self.wanted.split_at_mut(at);
            match below.last_mut() {
                Some(children) => keep_children(&self.open, children, usize::MAX),
                // What was added since the nodes were made is under none.
                None => keep_children(&self.open, &mut self.leaves, nodes.len()),
            }
        }
        let boxes = hierarchy.boxes();
        let words = self.leaves.len();
        self.open.resize(words.max(self.open.len()), 0);
        self.hidden.resize(words.max(self.hidden.len()), 0);
        let (open, hidden) = (&mut self.open[..words], &mut self.hidden[..words]);
        buffer.test_boxes(simd, boxes, 0, &self.leaves, open, hidden);
        found.iter_mut().zip(open).for_each(|(found, open)| *found |= *open);
    }

    /// Tests the wanted nodes of a level: leaves the open ones in `open`.
    fn test(&mut self, simd: Simd, buffer: &OcclusionBuffer, boxes: &Boxes, at: usize) {
        let words = self.wanted[at].len();
        self.open.clear();
        self.open.resize(words, 0);
        self.hidden.resize(words.max(self.hidden.len()), 0);
        let hidden = &mut self.hidden[..words];
        buffer.test_boxes(simd, boxes, 0, &self.wanted[at], &mut self.open, hidden);
    }
}

/// The nodes of which a child is wanted.
fn parents(children: &[u64], count: usize, out: &mut Vec<u64>) {
    out.clear();
    out.resize(count.div_ceil(64), 0);
    for (word, &bits) in children.iter().enumerate() {
        for part in 0..64 / CHILDREN {
            let node = word * (64 / CHILDREN) + part;
            if node < count && bits >> (part * CHILDREN) & 0xffff != 0 {
                bits::set(out, node, true);
            }
        }
    }
}

/// Clears the children of nodes that are not open, of the first `under`.
fn keep_children(open: &[u64], children: &mut [u64], under: usize) {
    for (word, bits) in children.iter_mut().enumerate().filter(|(_, bits)| **bits != 0) {
        for part in 0..64 / CHILDREN {
            let first = word * 64 + part * CHILDREN;
            let is_open = open
                .get(first / CHILDREN / 64)
                .is_some_and(|w| w >> (first / CHILDREN % 64) & 1 == 1);
            if !is_open && first < under {
                let count = (under - first).min(CHILDREN);
                *bits &= !(((1 << count) - 1) << (part * CHILDREN));
            }
        }
    }
}
