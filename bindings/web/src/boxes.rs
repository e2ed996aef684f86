//! Boxes and planes: the smallest module.

use alloc::vec;
use alloc::vec::Vec;

use cullet::bounds::{Aabb, Plane};
use cullet::cull::Indices;
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Cut;
#[cfg(feature = "occluders")]
use cullet::cull::occlusion::OcclusionBuffer;
use cullet::hierarchy::{Handle, Hierarchy};
use cullet::{Simd, Transform, view::Frustum};

use crate::fault::has_room;
use crate::listing::Ascending;

/// Boxes under fixed numbers, in a hierarchy, and views of them that remember what they found.
#[derive(Debug)]
pub struct BoxSet {
    simd: Simd,
    /// Boxes that the page writes: least and greatest corner.
    boxes: Vec<[f32; 6]>,
    /// Matrices that the page writes where boxes are of objects' own spaces; as many as boxes once
    /// they are wanted.
    matrices: Vec<[f32; 16]>,
    hierarchy: Hierarchy,
    slot_of: Vec<u32>,
    index_of: Vec<u32>,
    /// Boxes that were given for the first time since the last sorting.
    fresh: usize,
    views: Vec<BoxView>,
}

/// One view of a set.
#[derive(Debug, Default)]
struct BoxView {
    cut: Cut,
    slots: Indices,
    visible: Ascending,
    #[cfg(feature = "occluders")]
    unhidden: (Vec<u64>, Indices, Ascending),
    last: Option<(u64, [u64; 24])>,
}

/// Bytes that a box takes: written box, stored box, slot, number, lists.
const BYTES: usize = 128;

impl BoxSet {
    /// Views that a set may have.
    pub const MAX_VIEWS: usize = 1024;

    /// Boxes that are nowhere, until they are written and committed; `None` where memory does not
    /// suffice.
    pub fn new(len: usize) -> Option<Self> {
        if !has_room(len.checked_mul(BYTES)?) {
            return None;
        }
        let mut hierarchy = Hierarchy::new();
        for _ in 0..len {
            hierarchy.insert(&Aabb::EMPTY).ok()?;
        }
        Some(Self {
            simd: Simd::best(),
            boxes: vec![[0.0; 6]; len],
            matrices: Vec::new(),
            hierarchy,
            slot_of: (0..len as u32).collect(),
            index_of: (0..len as u32).collect(),
            fresh: 0,
            views: Vec::new(),
        })
    }

    /// The set tested at another level, for measurements.
    #[must_use]
    pub fn at_level(mut self, simd: Simd) -> Self {
        self.simd = simd;
        self
    }

    /// How many boxes there are.
    pub fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// The boxes to be written: x, y, z of the least corner, then of the greatest.
    pub fn boxes_mut(&mut self) -> &mut [[f32; 6]] {
        &mut self.boxes
    }

    /// The matrices to be written, column-major; `None` where memory does not suffice.
    pub fn matrices_mut(&mut self) -> Option<&mut [[f32; 16]]> {
        if self.matrices.is_empty() {
            if !has_room(self.boxes.len().checked_mul(64)?) {
                return None;
            }
            self.matrices.resize(self.boxes.len(), IDENTITY);
        }
        Some(&mut self.matrices)
    }

    /// Takes over `count` boxes from `first` on; with `moved` each goes through its matrix. A NaN
    /// makes a box that every view sees, a least corner beyond the greatest one that none sees.
    /// False, and nothing happens, where there are fewer.
    ///
    /// The nodes above are fitted: O(count), and O(len) for a quarter or more. Sorts where many
    /// come for the first time.
    pub fn commit(&mut self, first: usize, count: usize, moved: bool) -> bool {
        let end = first.saturating_add(count);
        if end > self.boxes.len() || (moved && self.matrices_mut().is_none()) {
            return false;
        }
        let is_many = count * 4 >= self.boxes.len();
        for i in first..end {
            let bounds = self.world_box(i, moved);
            let slot = self.slot_of[i];
            self.fresh += usize::from(self.hierarchy.boxes().get(slot as usize).is_empty());
            if !is_many {
                // There is a handle for each number, for none is ever removed.
                let _ = self.hierarchy.set_bounds(handle(i), &bounds);
            }
        }
        if is_many {
            let mut all = core::mem::take(&mut self.hierarchy);
            all.write_bounds(|boxes| {
                for i in first..end {
                    boxes.set(self.slot_of[i], &self.world_box(i, moved));
                }
            });
            self.hierarchy = all;
        } else {
            self.hierarchy.refit();
        }
        true
    }

    fn world_box(&self, i: usize, moved: bool) -> Aabb {
        let [a, b, c, x, y, z] = self.boxes[i];
        let own = Aabb::new([a, b, c], [x, y, z]);
        if own.is_empty() || !moved {
            return own;
        }
        Transform::from_matrix(self.matrices[i]).transform_box(&own, [0.0; 3])
    }

    /// Sorts the boxes by place, as is done by itself when many come for the first time: for boxes
    /// that have moved far. O(len log len). It allocates.
    pub fn sort(&mut self) {
        self.hierarchy.commit();
        self.fresh = 0;
        for slot in 0..self.hierarchy.slot_count() {
            let index = self.hierarchy.handle(slot).map_or(slot, |h| h.index);
            self.index_of[slot as usize] = index;
            self.slot_of[index as usize] = slot;
        }
    }

    /// Lists the boxes that planes do not reject, ascending. Planes are inward normals and
    /// constants: a point is inside where n·p + c ≥ 0. One with a number that is not finite, or
    /// without a direction, rejects nothing. What is listed lies at [`visible`](Self::visible).
    /// False for a number of a view beyond [`MAX_VIEWS`](Self::MAX_VIEWS).
    pub fn cull(&mut self, view: usize, planes: &[f64; 24]) -> bool {
        if view >= Self::MAX_VIEWS {
            return false;
        }
        if self.fresh * 16 > self.len() {
            self.sort();
        }
        if self.views.len() <= view {
            self.views.resize_with(view + 1, BoxView::default);
        }
        let state = &mut self.views[view];
        let version = self.hierarchy.change_version();
        let asked = Some((version, planes.map(f64::to_bits)));
        if state.last == asked {
            return true;
        }
        state.last = asked;
        let planes: [Option<Plane>; 6] = core::array::from_fn(|i| {
            let [x, y, z, c] = [0, 1, 2, 3].map(|j| planes[i * 4 + j]);
            Some(Plane::new([-x, -y, -z], c))
        });
        let frustum = Frustum::from_planes(planes);
        let planes = Planes::new(&frustum);
        let (nodes, boxes) = (self.hierarchy.nodes(), self.hierarchy.boxes());
        state.cut.cull(self.simd, &planes, nodes, boxes);
        state.cut.list(self.simd, &mut state.slots);
        // Where no plane is left, none rejects the boxes that are nowhere.
        let is_listed =
            |slot: &u32| frustum.present() != 0 || !boxes.get(*slot as usize).is_empty();
        let listed = state.slots.iter().copied().filter(is_listed);
        let numbers = listed.map(|slot| self.index_of[slot as usize]);
        state.visible.fill(self.simd, self.boxes.len(), numbers);
        true
    }

    /// Returns what the last cull of a view listed; nothing before.
    pub fn visible(&self, view: usize) -> &[u32] {
        self.views.get(view).map_or(&[], |v| v.visible.list())
    }

    /// Lists, of what the last cull of a view listed, what an occlusion buffer does not hide,
    /// ascending. Nothing for a view that was not culled. The list lies at
    /// [`unhidden`](Self::unhidden).
    #[cfg(feature = "occluders")]
    pub fn hide(&mut self, view: usize, buffer: &OcclusionBuffer) {
        let Some(state) = self.views.get_mut(view) else { return };
        let (alive, slots, unhidden) = &mut state.unhidden;
        alive.clear();
        alive.resize(self.boxes.len().div_ceil(64), 0);
        for &slot in state.slots.iter() {
            alive[slot as usize / 64] |= 1 << (slot % 64);
        }
        let (nodes, boxes) = (self.hierarchy.nodes(), self.hierarchy.boxes());
        buffer.hide_boxes(self.simd, nodes, boxes, alive);
        slots.clear();
        slots.append_ones(self.simd, alive, 0);
        let numbers = slots.iter().map(|&slot| self.index_of[slot as usize]);
        unhidden.fill(self.simd, self.boxes.len(), numbers);
    }

    /// Returns what the last [`hide`](Self::hide) of a view listed; nothing before.
    #[cfg(feature = "occluders")]
    pub fn unhidden(&self, view: usize) -> &[u32] {
        self.views.get(view).map_or(&[], |v| v.unhidden.2.list())
    }

    /// Forgets what a view knows, and gives its memory back.
    pub fn forget(&mut self, view: usize) {
        if let Some(view) = self.views.get_mut(view) {
            *view = BoxView::default();
        }
    }
}

/// The handle of a box: they were inserted in the order of their numbers.
fn handle(index: usize) -> Handle {
    Handle { index: index as u32, generation: 0 }
}

const IDENTITY: [f32; 16] =
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

#[cfg(test)]
mod tests {
    use super::*;

    /// |x|, |y|, |z| ≤ 10.
    const CUBE: [f64; 24] = [
        1.0, 0.0, 0.0, 10.0, -1.0, 0.0, 0.0, 10.0, 0.0, 1.0, 0.0, 10.0, 0.0, -1.0, 0.0, 10.0, 0.0,
        0.0, 1.0, 10.0, 0.0, 0.0, -1.0, 10.0,
    ];

    fn place(set: &mut BoxSet, i: usize, x: f32) {
        set.boxes_mut()[i] = [x, 0.0, 0.0, x + 0.5, 1.0, 1.0];
    }

    #[test]
    fn the_list_is_that_of_a_sweep_however_boxes_came_and_moved() {
        let len = 3000;
        let mut set = BoxSet::new(len).unwrap();
        let at = |i: usize, step: usize| ((i * 7919 + step * 31) % 997) as f32 * 0.1 - 40.0;
        for step in 0..40 {
            // A few at a time, then all.
            let (first, count) = if step < 30 { (step * 100, 100) } else { (0, len) };
            for i in first..first + count {
                place(&mut set, i, at(i, step));
            }
            assert!(set.commit(first, count, false));
            assert!(set.cull(0, &CUBE) && set.cull(1, &[f64::NAN; 24]));
            let here = |i: &u32| {
                let b = set.boxes[*i as usize];
                (*i as usize) < first + count && b[0] <= 10.0 && b[3] >= -10.0
            };
            let expected: Vec<u32> = (0..len as u32).filter(here).collect();
            assert_eq!(set.visible(0), expected);
            assert_eq!(set.visible(1).len(), first + count);
        }
        set.hierarchy.validate().unwrap();
    }

    #[test]
    fn a_box_goes_through_its_matrix_and_a_nan_is_everywhere() {
        let mut set = BoxSet::new(3).unwrap();
        set.boxes_mut().fill([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]);
        let matrices = set.matrices_mut().unwrap();
        (matrices[0][12], matrices[1][12], matrices[2][0]) = (10.5, 11.5, f32::NAN);
        assert!(set.commit(0, 3, true) && set.cull(0, &CUBE));
        assert_eq!(set.visible(0), [0, 2]);
        assert!(!set.commit(2, 2, true) && !set.commit(usize::MAX, 2, false));
        assert!(!set.cull(BoxSet::MAX_VIEWS, &CUBE));
    }

    #[test]
    fn nothing_of_nothing() {
        let mut set = BoxSet::new(0).unwrap();
        assert!(set.commit(0, 0, false) && set.cull(0, &CUBE));
        assert_eq!(set.visible(0), [0_u32; 0]);
    }
}
