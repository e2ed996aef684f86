//! Surfaces: patches of connected facets, drawn into the buffer.
//!
//! ```text
//! project    vertices, eight at a time; margin: how far one may be off, in pixels
//! cut        facets that reach before the near plane or far off the screen, in f64
//! open       blocks in which the patch may come nearer than what was drawn before: no others are looked at
//! facets     eight at a time: which show the side that is drawn, for certain
//!            each covers the pixels that it touches, widened by the margin; their least nearness is kept beside
//! silhouettes    eight edges at a time: those with a drawn facet on one side alone
//!            each removes the pixels that it touches, widened by three margins
//! coverage   what is covered and not removed, into the buffer
//! ```
//!
//! Why that is right: within a pixel the number of drawn facets that lie over a point changes only
//! at silhouette edges, for at the others one begins where the other ends. So a pixel that no such
//! edge touches is covered wholly or not at all; and whatever covers a part of it touches it, so
//! that its depth is in the least. A pixel may be counted as touched by a facet that only comes
//! within the margin of it: then the surface goes on into the pixel, or ends within three margins
//! of it, which removes it.

mod coverage;
mod cut;
mod facets;
mod projection;
mod silhouettes;
mod spots;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use fearless_simd::prelude::*;

use super::blocks::{BLOCK, BlocksMut};
use super::connected::{Connected, LANES, NUMBERS, corners_of};
use super::screen::ObjectScreen;
use crate::array::Each;
use coverage::BlockCoverage;
use cut::Cut;
pub(crate) use projection::Projection;
use spots::Spots;

/// A number for each vertex of a patch, or facet: as many as there can be, so that none needs a
/// check.
type Numbers<T> = Box<[T; NUMBERS]>;

/// Drawing of surfaces: memory.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Blocks in a row of the buffer.
    columns: usize,
    /// Blocks of the window of the patch that is drawn, and which of each row have any coverage.
    blocks: Vec<BlockCoverage>,
    used: Vec<u64>,
    /// Blocks of each row of the window that are not yet as near as the patch comes.
    open: Vec<u64>,
    spots: Spots,
    /// Codes of the vertices: bits of the planes beyond which each lies; see [`cut`].
    codes: Numbers<i32>,
    /// All bits for a facet that is drawn, else none.
    drawn: Numbers<u8>,
    silhouettes: Vec<[u16; 2]>,
    /// Quads of which both triangles are drawn, but not as one.
    halves: Vec<[u16; 3]>,
    cut: Cut,
}

/// The part of the screen on which a patch lies, and how far its vertices may be off.
#[derive(Clone, Copy, Debug)]
struct Window {
    /// First column and row of pixels.
    low: [f32; 2],
    /// One beyond the last column; the last row.
    high: [f32; 2],
    /// First column, and one beyond the last, before the window was narrowed.
    columns: [f32; 2],
    /// First block, and blocks across.
    block: [usize; 2],
    across: usize,
    /// Pixels by which a vertex, or an edge at a pixel, may be off.
    margin: f32,
    /// The same where a plane is followed.
    steep: f32,
    /// Error of nearness: a share of it, and beside that.
    share: f32,
    nearness: f32,
    /// No nearer than the nearest vertex of its own facets. Pixels that only facets around cover
    /// are drawn no nearer, or a patch would draw something though it is hidden.
    cap: f32,
    /// Whether some vertices are NaN.
    is_clipped: bool,
}

impl Window {
    /// Rows of blocks.
    fn rows(&self) -> usize {
        self.high[1] as usize / BLOCK[1] - self.block[1] + 1
    }

    /// Parts of a window so narrow that a word has a bit for each block of a row.
    fn parts(self) -> impl Iterator<Item = Self> {
        const MOST: usize = u64::BITS as usize;
        (0..self.across).step_by(MOST).map(move |first| {
            let (column, across) = (self.block[0] + first, MOST.min(self.across - first));
            let [left, right] = [column, column + across].each(|c| (c * BLOCK[0]) as f32);
            Self {
                low: [self.low[0].max(left), self.low[1]],
                high: [self.high[0].min(right), self.high[1]],
                block: [column, self.block[1]],
                across,
                ..self
            }
        })
    }
}

impl Surface {
    /// For a buffer of so many columns and rows of blocks.
    pub(super) fn new(columns: usize, rows: usize) -> Self {
        Self {
            columns,
            blocks: vec![BlockCoverage::NONE; columns * rows],
            used: vec![0; rows],
            open: vec![0; rows],
            spots: Spots::new(),
            codes: numbers(0),
            drawn: numbers(0),
            silhouettes: Vec::new(),
            halves: Vec::new(),
            cut: Cut::default(),
        }
    }

    /// Draws a patch, each side that it shows by itself, no nearer than `nearest`.
    #[inline(always)]
    pub(super) fn draw<S: Simd>(
        &mut self,
        simd: S,
        patch: &Connected,
        (screen, nearest): (&ObjectScreen, f32),
        projection: &Projection,
        target: &mut BlocksMut<'_>,
    ) {
        let away = [
            projection.faces_away(patch, 1.0),
            !patch.two_sided || projection.faces_away(patch, -1.0),
        ];
        if away == [true, true] {
            return;
        }
        let Some(mut window) = self.project(simd, screen, projection, patch) else { return };
        window.cap = window.cap.min(nearest);
        // What is drawn does not depend on where a window ends.
        for window in window.parts() {
            let Some(window) = self.opened(simd, window, target) else { continue };
            for (back, is_away) in away.into_iter().enumerate() {
                if !is_away {
                    let turned = projection.is_mirrored() ^ (back == 1);
                    let both = (screen, projection);
                    self.draw_side(simd, patch, both, &window, [back == 1, turned], target);
                }
            }
        }
    }

    /// Draws the facets that show their fronts, or their backs; `turned` are those whose corners
    /// run clockwise on the screen, y upward.
    #[inline(always)]
    fn draw_side<S: Simd>(
        &mut self,
        simd: S,
        patch: &Connected,
        screen: (&ObjectScreen, &Projection),
        window: &Window,
        [back, turned]: [bool; 2],
        target: &mut BlocksMut<'_>,
    ) {
        self.halves.clear();
        let (mut rest, mut number) = (&patch.corners[..], LANES);
        for (kind, &groups) in patch.groups.iter().enumerate() {
            // No closures: what is not inlined is compiled without the level's instructions.
            for _ in 0..groups {
                let (rows, more) = rest.split_at(corners_of(kind));
                if let Ok(quads) = rows.try_into() {
                    self.group::<S, 4>(simd, window, quads, turned, Some(number), target);
                } else if let Ok(triangles) = rows.try_into() {
                    self.group::<S, 3>(simd, window, triangles, turned, Some(number), target);
                }
                (rest, number) = (more, number + LANES);
            }
        }
        self.draw_halves(simd, window, target);
        if window.is_clipped {
            self.draw_cut(simd, window, back, target);
        }
        // Every facet shows its other side, or what it covers went to the buffer at once.
        if self.used[..window.rows()].iter().all(|columns| *columns == 0) {
            return;
        }
        if self.find_silhouettes(screen, patch, window, back) {
            self.draw_silhouettes(simd, window);
            self.resolve(simd, window, Some(target));
        } else {
            // More corners than there are numbers: nothing is certain.
            self.resolve(simd, window, None);
        }
    }
}

fn numbers<T: Copy + core::fmt::Debug>(of: T) -> Numbers<T> {
    vec![of; NUMBERS].into_boxed_slice().try_into().expect("as many as there are numbers")
}
