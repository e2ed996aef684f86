//! Options of the renderer, and the frame that it returns.

use cullet::Visible;

use crate::sort;

/// An original triangle of an instance: the instance's slot, and the triangle's number in its mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PixelId {
    /// The instance's slot.
    pub slot: u32,
    /// The triangle, by its original number.
    pub triangle: u32,
}

impl PixelId {
    /// Nothing: what owns the pixels of the sky.
    pub const NONE: Self = Self { slot: u32::MAX, triangle: u32::MAX };

    /// A number that ascends with it.
    pub(crate) fn key(self) -> u64 {
        sort::pair(self.slot, self.triangle)
    }
}

/// The triangles that are drawn.
#[derive(Clone, Copy, Debug)]
pub enum Selection<'a> {
    /// All of them: no culling but each part's declared sidedness.
    All,
    /// The triangles that a culler left; its output must be [`cullet::Output::Triangles`]. Slots
    /// and triangles that do not exist are skipped.
    Visible(&'a Visible),
}

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// How many threads; 0 is those of the pool that the call runs in. The frame is the same.
    pub threads: usize,
    /// Where in its pixel the sample lies, from the top left corner: 0.5, 0.5 is the centre.
    /// Clamped to 0..1; NaN is the centre.
    pub jitter: [f64; 2],
    /// Count the fragments of every pixel, hidden ones too: then nothing can be skipped, so it
    /// costs several times as much where much is hidden.
    pub count_layers: bool,
    /// The frame is this many times wider and higher than the view's viewport; 0 is 1. For smooth
    /// pictures. The frame is at most 65 536 pixels wide or high: a larger scale is lowered.
    pub scale: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { threads: 0, jitter: [0.5; 2], count_layers: false, scale: 1 }
    }
}

/// Counts of a frame. All but `covered_pixels` are 0 unless [`RenderOptions::count_layers`] is set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Samples that some triangle covered within the depth range, before any depth test; each
    /// counts once for every such triangle, blended and masked ones included.
    pub fragments: u64,
    /// Pixels that an opaque triangle owns.
    pub covered_pixels: u64,
    /// The most fragments on one pixel.
    pub max_layers: u32,
    /// Fragments per pixel, over the pixels that have any.
    pub mean_layers: f64,
}

/// A rendered view: which triangle owns each pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The owner of each pixel, row by row from the top; [`PixelId::NONE`] where there is nothing.
    pub ids: Vec<PixelId>,
    /// The owner's depth in normalised device coordinates; the far value (1, or 0 in a reversed
    /// view) where there is nothing.
    pub depth: Vec<f64>,
    /// Blended and masked triangles of which a sample is not behind what is opaque; sorted, each
    /// once.
    pub blended: Vec<PixelId>,
    /// For each of `blended`, the first pixel where that is so, by row and then column.
    pub blended_at: Vec<[u32; 2]>,
    /// Fragments of each pixel; empty unless [`RenderOptions::count_layers`] is set.
    pub layers: Vec<u32>,
    /// Counts.
    pub stats: FrameStats,
}

impl Frame {
    /// The visible set S at this resolution: the owners of pixels and the blended triangles;
    /// sorted, each once. Costs a sort of the owners that differ from their left neighbour.
    #[must_use]
    pub fn visible(&self) -> Vec<PixelId> {
        let mut keys = Vec::new();
        for id in self.ids.iter().chain(&self.blended) {
            if keys.last() != Some(&id.key()) {
                keys.push(id.key());
            }
        }
        sort::sort(&mut keys);
        keys.dedup();
        let of = |key: u64| PixelId { slot: (key >> 32) as u32, triangle: key as u32 };
        keys.into_iter().map(of).filter(|id| *id != PixelId::NONE).collect()
    }

    /// The owner of a pixel; [`PixelId::NONE`] outside the frame.
    #[must_use]
    pub fn id(&self, x: u32, y: u32) -> PixelId {
        if x >= self.width || y >= self.height {
            return PixelId::NONE;
        }
        self.ids[y as usize * self.width as usize + x as usize]
    }

    /// Each `n`th pixel of each `n`th row, for a smaller picture: owners and depths alone. 0 is 1.
    #[must_use]
    pub fn thinned(&self, n: u32) -> Self {
        let n = n.max(1);
        let (width, height) = (self.width.div_ceil(n), self.height.div_ceil(n));
        let kept = || {
            let rows = (0..self.height).step_by(n as usize);
            rows.flat_map(|y| {
                let row = y as usize * self.width as usize;
                (0..self.width).step_by(n as usize).map(move |x| row + x as usize)
            })
        };
        let ids = kept().map(|at| self.ids[at]).collect();
        let depth = kept().map(|at| self.depth[at]).collect();
        Self { width, height, ids, depth, ..Self::default() }
    }

    /// Fills in the blended triangles, from where each passed in each tile.
    pub(crate) fn set_blended(&mut self, passed: &[(PixelId, [u32; 2])]) {
        let passed = first_of_each(passed, PixelId::key);
        self.blended = passed.iter().map(|p| p.0).collect();
        self.blended_at = passed.iter().map(|p| p.1).collect();
    }

    /// Fills in the counts from `ids` and `layers`.
    pub(crate) fn count(&mut self) {
        self.stats = FrameStats {
            covered_pixels: self.ids.iter().filter(|id| **id != PixelId::NONE).count() as u64,
            fragments: self.layers.iter().map(|&n| u64::from(n)).sum(),
            max_layers: self.layers.iter().copied().max().unwrap_or(0),
            mean_layers: 0.0,
        };
        let touched = self.layers.iter().filter(|&&n| n > 0).count();
        if touched > 0 {
            self.stats.mean_layers = self.stats.fragments as f64 / touched as f64;
        }
    }
}

/// First pixel, by row and then column, of each thing that is seen; ascending by `key`.
pub(crate) fn first_of_each<T: Copy>(
    seen: &[(T, [u32; 2])],
    key: impl Fn(T) -> u64,
) -> Vec<(T, [u32; 2])> {
    let by_pixel = sort::sorted_by(seen, |&(_, [x, y])| sort::pair(y, x));
    let mut sorted = sort::sorted_by(&by_pixel, |s| key(s.0));
    sorted.dedup_by_key(|s| key(s.0));
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_frame_has_each_second_pixel_of_each_second_row() {
        let id = |slot| PixelId { slot, triangle: 0 };
        let frame = Frame {
            width: 5,
            height: 3,
            ids: (0..15).map(id).collect(),
            depth: (0..15).map(f64::from).collect(),
            ..Frame::default()
        };
        let thinned = frame.thinned(2);
        assert_eq!((thinned.width, thinned.height), (3, 2));
        assert_eq!(thinned.ids, [0, 2, 4, 10, 12, 14].map(id));
        assert_eq!(thinned.depth, [0.0, 2.0, 4.0, 10.0, 12.0, 14.0]);
        assert_eq!(frame.thinned(0), frame);
    }
}
