//! Greatest nearness of tiles: what is before everything that was drawn.

use alloc::vec::Vec;

use crate::simd::dispatch;
use fearless_simd::prelude::*;

use super::super::raster::{OcclusionBuffer, ScreenBounds};

/// The greatest nearness of each tile of a buffer that is done.
///
/// Where no pixel that a box may touch is nearer than the box's farthest point, nothing within the
/// box is hidden. In a scene of very many instances most of those that are seen are so by the
/// hundred, and one test answers for all under a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearest {
    blocks: Vec<[u16; 8]>,
}

impl Nearest {
    /// Reads a buffer: costs a look at the pixels of each tile that is covered in part.
    pub(crate) fn read(&mut self, simd: crate::Simd, buffer: &OcclusionBuffer) {
        dispatch!(simd, simd => buffer.read().most(simd, &mut self.blocks));
    }

    /// Whether a rectangle lies within the screen, none of its sides along an edge, and all its
    /// pixels are as far as `farthest` or farther.
    #[inline(always)]
    pub(super) fn is_before<S: Simd>(
        &self,
        simd: S,
        buffer: &OcclusionBuffer,
        bounds: &ScreenBounds,
        farthest: f32,
    ) -> bool {
        let ScreenBounds { min, max, .. } = *bounds;
        let size = buffer.size();
        // Rectangles that reach beyond an edge are cut off there; some of their parts may be
        // outside.
        if (0..2).any(|a| min[a] == 0 || max[a] + 1 >= size[a]) {
            return false;
        }
        buffer.read().is_before(simd, &self.blocks, bounds, farthest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Simd;
    use crate::bounds::Aabb;
    use crate::cull::occlusion::Convex;
    use crate::{Camera, Depth, Projection, Transform, View};

    #[test]
    fn a_rectangle_is_before_what_no_pixel_of_it_contradicts() {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: 100.0 };
        let camera = Camera::look_at([0.0, 0.0, 10.0], [0.0; 3], projection);
        // Neither edge is a multiple of a tile.
        let size = [203, 125];
        let view = View::new(&camera, Depth::Reversed, size).unwrap();
        let mut buffer = OcclusionBuffer::new(size).unwrap();
        buffer.begin(&view, [0.0; 3]);
        let wall = Convex::from_box(&Aabb::new([-2.0, -1.0, -0.1], [1.0, 3.0, 0.1])).unwrap();
        for level in Simd::all() {
            let name = level.name();
            wall.draw(level, &mut buffer, &Transform::IDENTITY);
            let mut nearest = Nearest::default();
            nearest.read(level, &buffer);
            let mut before = 0;
            for i in 0..4000_u32 {
                let min = [i * 7 % 190, i * 13 % 120];
                let max = [(min[0] + i % 31).min(202), (min[1] + i % 23).min(124)];
                let farthest = [0.02, 0.09, 0.1, 0.11][i as usize % 4];
                let found = dispatch!(level, simd => {
                    let bounds = ScreenBounds { min, max, nearness: 0.0 };
                    nearest.is_before(simd, &buffer, &bounds, farthest)
                });
                let pixels = (min[1]..=max[1]).flat_map(|y| (min[0]..=max[0]).map(move |x| (x, y)));
                let nearer = pixels.filter(|&(x, y)| buffer.nearness(x, y) > farthest);
                assert!(!found || nearer.count() == 0, "{name}: {min:?} {max:?} {farthest}");
                let at_an_edge = min.contains(&0) || max[0] == 202 || max[1] == 124;
                assert!(!found || !at_an_edge);
                before += usize::from(found);
            }
            // The floor: of 4000, with some a tile beside the wall that are not found.
            assert!(before > 2000, "{name}: {before}");
        }
    }
}
