//! Deforming meshes: planes and masks of triangles that changed are made anew.
//!
//! Normal masks were meant for rigid models: Zhang & Hoff (1997) leave what deforms to others. But a
//! triangle's mask or plane depends on its own corners alone, so that those which moved can be replaced
//! in place: 80 million masks a second, 25 million planes (one thread; `cullet bench backface/update`).
//! Instances that merely move, turn or scale need nothing: the eye is taken to their space.

use std::ops::Range;

use super::{MaskGrid, NormalMasks, Planes8, Planes16};

macro_rules! update {
    ($($planes:ty),*) => {$(
        impl $planes {
            /// Replaces the planes of the triangles of `range` by those of moved vertices; `positions`
            /// and `indices` are the whole mesh's. As right as new ones wherever the vertices went, and
            /// as fine within the box of the positions that the set was made of.
            ///
            /// # Panics
            /// If the range reaches beyond the planes or the indices, or an index beyond the positions.
            pub fn update(
                &mut self,
                positions: &[[f32; 3]],
                indices: &[u32],
                range: Range<usize>,
            ) {
                let triangles = &indices[range.start * 3..range.end * 3];
                for (i, t) in range.zip(triangles.as_chunks::<3>().0) {
                    self.set(i, t.map(|v| positions[v as usize]));
                }
            }
        }
    )*};
}
update!(Planes8, Planes16);

impl MaskGrid {
    /// Replaces the masks of the triangles of `range` by those of moved vertices; `positions` and
    /// `indices` are the whole mesh's.
    ///
    /// # Panics
    /// If the range reaches beyond the masks or the indices, or an index beyond the positions.
    pub fn update(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<usize>,
        masks: &mut NormalMasks,
    ) {
        let triangles = &indices[range.start * 3..range.end * 3];
        for (i, t) in range.zip(triangles.as_chunks::<3>().0) {
            masks.set(i, self.encode_triangle(t.map(|v| positions[v as usize])));
        }
    }
}
