//! Surfaces of a map: triangles with a texture, and what the texture is.

use std::ops::Range;

/// Kind of a surface, as far as sight cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Kind {
    /// It hides what is behind it.
    Wall,
    /// The sky, which hides what is behind it too.
    Sky,
    /// A liquid: engines may draw it so that one sees through.
    Liquid,
    /// Cut out by a mask: a fence, a grate.
    Fence,
    /// A flame, a beam or glass: seen through, or the map does not say.
    Effect,
}

/// A surface.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub(crate) texture: u32,
    pub(crate) kind: Kind,
    pub(crate) two_sided: bool,
    /// A point on it, and its normal.
    pub(crate) centre: [f64; 3],
    pub(crate) normal: [f64; 3],
    /// Its corners: a range of [`Surfaces::indices`].
    pub(crate) indices: Range<usize>,
}

/// All surfaces of a map.
#[derive(Debug, Default)]
pub(crate) struct Surfaces {
    pub(crate) positions: Vec<[f32; 3]>,
    /// Three a triangle, counter-clockwise from the front.
    pub(crate) indices: Vec<u32>,
    /// One entry per face; `None` for one that is not drawn.
    pub(crate) list: Vec<Option<Surface>>,
    /// Defects that do not stop a map from loading: how many faces, and what of them.
    pub(crate) notes: Vec<(u64, &'static str)>,
}

/// Mean of corners.
pub(crate) fn middle(corners: impl ExactSizeIterator<Item = [f32; 3]>) -> [f64; 3] {
    let count = corners.len().max(1) as f64;
    let sum = corners.fold([0.0; 3], |sum, c| [0, 1, 2].map(|a| sum[a] + f64::from(c[a])));
    sum.map(|v| v / count)
}

/// Twice the area of a polygon as a vector, by Newell's sum: along its normal on the side from
/// which it is counter-clockwise.
pub(crate) fn area(corners: &[[f32; 3]]) -> glam::DVec3 {
    let at = |i: usize| glam::DVec3::from(corners[i % corners.len()].map(f64::from));
    (1..corners.len())
        .fold(glam::DVec3::ZERO, |sum, i| sum + (at(i) - at(0)).cross(at(i + 1) - at(0)))
}
