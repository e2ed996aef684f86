//! Cuts of hierarchies and what is measured of them.

use std::collections::HashMap;

use cullet::lod::{LevelEye, Levels, Lod, PixelScale, Selection};
use cullet::{Simd, Transform};
use cullet_bake::levels::LevelsData;
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;
use cullet_testkit::Rng;

/// Pixels a radian of a picture of 1080 lines and 60°.
pub(crate) const PIXELS: f64 = 935.0;

/// Middle of the box, and the distance to the farthest vertex.
pub(crate) fn bounding(positions: &[[f32; 3]]) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        for a in 0..3 {
            low[a] = low[a].min(f64::from(p[a]));
            high[a] = high[a].max(f64::from(p[a]));
        }
    }
    let middle = std::array::from_fn(|a| (low[a] + high[a]) / 2.0);
    let radius = positions.iter().map(|p| apart(p.map(f64::from), middle)).fold(0.0, f64::max);
    (middle, radius)
}

pub(crate) fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// An eye so many radii from the middle.
pub(crate) fn view_from(positions: &[[f32; 3]], direction: [f64; 3], radii: f64) -> PixelScale {
    let (middle, radius) = bounding(positions);
    let eye = std::array::from_fn(|a| middle[a] + direction[a] * radii * radius);
    PixelScale { eye: Some(eye), pixels: PIXELS, near: radius * 1e-3 }
}

/// Levels that are cut as the engine does.
pub(crate) struct Cuts<'a> {
    pub(crate) data: &'a LevelsData,
    levels: Levels,
}

impl<'a> Cuts<'a> {
    pub(crate) fn new(data: &'a LevelsData) -> Self {
        let (_, levels) = data.clone().into_levels().expect("levels of a mesh");
        Self { data, levels }
    }

    /// The clusters of the cut at so many pixels.
    pub(crate) fn clusters(&self, view: &PixelScale, pixels: f64) -> Vec<u32> {
        let lod = Lod::default().with_pixels(pixels);
        let eye = LevelEye::new(&lod, view, &Transform::IDENTITY, None);
        let mut selection = Selection::default();
        assert!(self.levels.select(Simd::best(), &eye, &mut selection), "all levels are there");
        selection.ranges().flatten().collect()
    }

    /// Corners of the triangles of the cut at so many pixels.
    pub(crate) fn triangles(&self, view: &PixelScale, pixels: f64) -> Vec<u32> {
        let clusters = self.clusters(view, pixels);
        clusters.into_iter().flat_map(|c| self.data.cluster_indices(c)).collect()
    }
}

/// Edges that triangles have on one side more often than on the other, by welded vertices, and how much.
pub(crate) fn open_edges(welded: &[u32], indices: &[u32]) -> HashMap<[u32; 2], i32> {
    let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
    for t in indices.chunks_exact(3) {
        let t = [t[0], t[1], t[2]].map(|v| welded[v as usize]);
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    sides.retain(|e, n| *n != 0 && e[0] != e[1]);
    sides
}

/// How far a cut is off, in units of the threshold: of samples of the original to the cut and back.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deviation {
    pub(crate) samples: usize,
    pub(crate) over: usize,
    pub(crate) most: f64,
    /// Bound that 99.9 % stay within.
    pub(crate) p999: f64,
}

pub(crate) fn deviation(
    levels: &LevelsData,
    original: (&[u32], &SurfaceTree),
    drawn: &[u32],
    view: &PixelScale,
    threshold: f64,
    samples: usize,
    seed: u64,
) -> Deviation {
    let positions = &levels.mesh.positions;
    let of_cut = SurfaceTree::new(positions, drawn);
    let eye = view.eye.expect("an eye");
    let mut found = Vec::new();
    for (from, to) in [(original.0, &of_cut), (drawn, original.1)] {
        for p in surface_points(positions, from, samples, seed) {
            let distance = apart(p.point.map(f64::from), eye).max(view.near);
            // Anything nearer than a thousandth of what is allowed counts as nothing.
            let allowed = threshold * distance / view.pixels;
            if to.within(p.point, (allowed * 1e-3) as f32).is_some() {
                found.push(0.0);
                continue;
            }
            let off = to.nearest(p.point, f32::INFINITY).map_or(f64::INFINITY, |n| n.0.into());
            found.push(off / allowed);
        }
    }
    found.sort_unstable_by(f64::total_cmp);
    Deviation {
        samples: found.len(),
        over: found.iter().filter(|d| **d > 1.0).count(),
        most: found.last().copied().unwrap_or_default(),
        p999: found.get(found.len() * 999 / 1000).copied().unwrap_or_default(),
    }
}

/// Eight directions and so many radii: triangles drawn at one pixel, and the worst deviation.
pub(crate) fn row(
    levels: &LevelsData,
    original: &[u32],
    radii: f64,
    samples: usize,
) -> (f64, Deviation) {
    let positions = &levels.mesh.positions;
    let tree = SurfaceTree::new(positions, original);
    let cuts = Cuts::new(levels);
    let mut rng = Rng(5);
    let mut worst = Deviation::default();
    let mut triangles = 0.0;
    for seed in 0..8 {
        let view = view_from(positions, rng.direction(), radii);
        let drawn = cuts.triangles(&view, 1.0);
        triangles += drawn.len() as f64 / 24.0;
        if samples > 0 {
            let d = deviation(levels, (original, &tree), &drawn, &view, 1.0, samples, 100 + seed);
            worst.samples += d.samples;
            worst.over += d.over;
            worst.most = worst.most.max(d.most);
            worst.p999 = worst.p999.max(d.p999);
        }
    }
    (triangles, worst)
}
