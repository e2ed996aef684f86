//! Cuts at one pixel: how many triangles they have, and how far off they are found to be.

use std::collections::HashMap;

use cullet::Simd;
use cullet::lod::{Levels, PixelScale, Selection};
use cullet::mesh::weld;
use cullet_bake::levels::LevelsData;
use cullet_draw::surface::LargestDistances;
use cullet_draw::surface::SHARE_ABOVE;
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;
use serde::Serialize;

use super::models::{Whole, apart, directions, level_eye};
use super::peer::PeerLevels;

/// Bounding radii between the middle of a model and the eyes.
pub(super) const RADII: [f64; 6] = [1.1, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Eyes at each distance.
pub(super) const EYES: u32 = 8;
/// Factors for the errors of the peer, until a pixel is a pixel.
const FACTORS: [f32; 18] = [
    1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0,
    160.0,
];

/// Drawn triangles at one pixel from one distance, and their deviation.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Kept {
    pub(super) radii: f64,
    /// In the mean of the eyes.
    pub(super) triangles: f64,
    /// The largest deviation of all points, in pixels.
    pub(super) most: f64,
    /// Bound that 99.9 % of the points of any eye stay within.
    pub(super) p999: f64,
    /// Independent points, of both surfaces.
    pub(super) points: u64,
    /// Edges that are open though they are not the original's, of all eyes.
    pub(super) cracks: u64,
}

impl Kept {
    /// Whether a pixel is a pixel: for all but one in a thousand, and for those nearly.
    pub(super) fn is_kept(&self) -> bool {
        self.p999 <= 1.0 && self.most <= 1.2
    }
}

/// One kind of levels of a model.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cuts {
    pub(super) levels: &'static str,
    /// Factor for its errors.
    pub(super) factor: f32,
    pub(super) rows: Vec<Kept>,
}

impl Cuts {
    /// Whether a pixel must be a pixel.
    pub(super) fn is_ours(&self) -> bool {
        [super::MEASURED, super::DRAWN].contains(&self.levels)
    }
}

/// Levels whose cuts are the engine's: a hierarchy, a chain.
pub(super) struct Ours {
    data: LevelsData,
    levels: Levels,
}

impl Ours {
    pub(super) fn new(data: LevelsData) -> Result<Self, cullet_bake::levels::LevelsError> {
        let (_, levels) = data.clone().into_levels()?;
        Ok(Self { data, levels })
    }

    pub(super) fn levels(&self) -> &Levels {
        &self.levels
    }

    fn cut(&self, view: &PixelScale) -> Vec<u32> {
        let mut selection = Selection::default();
        self.levels.select(Simd::best(), &level_eye(view, 1.0), &mut selection);
        selection.ranges().flatten().flat_map(|c| self.data.cluster_indices(c)).collect()
    }
}

/// The smallest cut of several, as the engine draws of all levels that an instance has.
fn smallest(all: &[&Ours], view: &PixelScale) -> Vec<u32> {
    all.iter().map(|ours| ours.cut(view)).min_by_key(Vec::len).unwrap_or_default()
}

/// A model with what its cuts are measured against.
pub(super) struct Original<'a> {
    whole: &'a Whole,
    tree: SurfaceTree,
    welded: Vec<u32>,
    /// Edges of the original that are open.
    open: HashMap<[u32; 2], i32>,
}

impl<'a> Original<'a> {
    pub(super) fn new(whole: &'a Whole) -> Self {
        let welded = weld(&whole.positions);
        let open = open_edges(&welded, &whole.indices);
        Self { whole, tree: SurfaceTree::new(&whole.positions, &whole.indices), welded, open }
    }

    /// Ours, with so many points a distance: of each eye the smallest cut.
    pub(super) fn ours(&self, name: &'static str, ours: &[&Ours], points: u32) -> Cuts {
        let rows = RADII.iter().map(|&radii| self.row(radii, points, |view| smallest(ours, view)));
        Cuts { levels: name, factor: 1.0, rows: rows.collect() }
    }

    /// The peer's by the errors that it returns.
    pub(super) fn peer(&self, peer: &PeerLevels, factor: f32, points: u32) -> Cuts {
        let cut = |view: &PixelScale| peer.cut(&level_eye(view, 1.0), factor);
        let rows = RADII.iter().map(|&radii| self.row(radii, points, cut));
        Cuts { levels: "clusterlod", factor, rows: rows.collect() }
    }

    /// The peer's with the least factor at which a pixel is a pixel from everywhere; `None` if that
    /// is none of those tried.
    pub(super) fn peer_kept(&self, peer: &PeerLevels, points: u32) -> Option<Cuts> {
        let keeps = |&factor: &f32| {
            let cut = |view: &PixelScale| peer.cut(&level_eye(view, 1.0), factor);
            RADII.iter().rev().all(|&radii| self.row(radii, points, cut).is_kept())
        };
        let factor = FACTORS.into_iter().find(keeps)?;
        Some(self.peer(peer, factor, points))
    }

    fn row(&self, radii: f64, points: u32, cut: impl Fn(&PixelScale) -> Vec<u32>) -> Kept {
        let mut row = Kept { radii, ..Kept::default() };
        for (number, direction) in directions(EYES).enumerate() {
            let view = self.whole.seen(direction, radii);
            let drawn = cut(&view);
            row.triangles += drawn.len() as f64 / 3.0 / f64::from(EYES);
            row.cracks += self.cracks(&drawn);
            self.measure(&drawn, &view, points / (2 * EYES), number as u64, &mut row);
        }
        row
    }

    /// Points of the original to the cut and back, each in pixels where it is.
    fn measure(&self, drawn: &[u32], view: &PixelScale, points: u32, seed: u64, row: &mut Kept) {
        const SEED: u64 = 0x6b65_7074;
        let positions = &self.whole.positions;
        let of_cut = SurfaceTree::new(positions, drawn);
        let eye = view.eye.unwrap_or_default();
        for (from, to) in [(&self.whole.indices[..], &of_cut), (drawn, &self.tree)] {
            let points = surface_points(positions, from, points as usize, SEED ^ seed);
            let mut largest = LargestDistances::new(points.len(), SHARE_ABOVE, 0.0);
            for p in &points {
                let pixel = apart(p.point.map(f64::from), eye).max(view.near) / view.pixels;
                // Most are nearer than others before them.
                let known = (pixel * f64::from(largest.quantile())) as f32;
                if to.within(p.point, known).is_none() {
                    let off = to.nearest(p.point, f32::INFINITY).map_or(f32::INFINITY, |n| n.0);
                    largest.push((f64::from(off) / pixel) as f32);
                }
            }
            row.most = row.most.max(largest.max().into());
            row.p999 = row.p999.max(largest.quantile().into());
            row.points += points.len() as u64;
        }
    }

    /// Edges of a cut that are open, but for those between vertices of the original's own border,
    /// which moves along itself.
    fn cracks(&self, drawn: &[u32]) -> u64 {
        let border: std::collections::HashSet<u32> = self.open.keys().flatten().copied().collect();
        let is_own = |e: &[u32; 2]| border.contains(&e[0]) && border.contains(&e[1]);
        open_edges(&self.welded, drawn).keys().filter(|e| !is_own(e)).count() as u64
    }
}

/// Edges that triangles have on one side more often than on the other, and how much.
fn open_edges(welded: &[u32], indices: &[u32]) -> HashMap<[u32; 2], i32> {
    let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
    for t in indices.as_chunks::<3>().0 {
        let t = t.map(|v| welded[v as usize]);
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    sides.retain(|_, n| *n != 0);
    sides
}
