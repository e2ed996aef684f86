//! Triangles within a bound, beside a plain chain whose levels are measured as well.

use cullet::MeshData;
use cullet_bake::levels::{WithinOptions, simplify_within};
use cullet_draw::surface::Deviation;
use cullet_draw::surface::deviation;
use serde::Serialize;

use super::Stop;
use super::models::Whole;
use super::plain::simplify;

/// Bounds, in bounding radii.
pub(super) const BOUNDS: [f64; 3] = [0.001, 0.003, 0.01];

/// One bound of a model.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ChainRow {
    /// In bounding radii.
    pub(super) bound: f64,
    /// Triangles that [`simplify_within`] leaves.
    pub(super) triangles: usize,
    /// The fewest of a plain chain whose level is no farther off, as measured.
    pub(super) plain: usize,
    /// How far off ours is, in bounds: at most, and 99.9 % of the points.
    pub(super) most: f64,
    pub(super) p999: f64,
    pub(super) open_edges: [u32; 2],
}

impl ChainRow {
    pub(super) fn ratio(&self) -> f64 {
        self.triangles as f64 / self.plain as f64
    }
}

/// A row for each bound; `points` are measured each way.
pub(super) fn compare(whole: &Whole, points: u32) -> Result<Vec<ChainRow>, Stop> {
    let mesh = whole.to_data();
    let bounds = BOUNDS.map(|b| (b * whole.radius) as f32);
    let plain = plain(&mesh, &bounds, points)?;
    let row = |k: usize| {
        let found = simplify_within(&mesh, bounds[k], &WithinOptions::default())?;
        let far = measured(&mesh, &found.indices, points);
        Ok(ChainRow {
            bound: BOUNDS[k],
            triangles: found.indices.len() / 3,
            plain: plain[k],
            most: f64::from(far.max) / f64::from(bounds[k]),
            p999: f64::from(far.p999) / f64::from(bounds[k]),
            open_edges: far.open_edges,
        })
    };
    (0..bounds.len()).map(row).collect()
}

fn measured(mesh: &MeshData, indices: &[u32], points: u32) -> Deviation {
    deviation((&mesh.positions, &mesh.indices), (&mesh.positions, indices), points as usize, 77)
}

/// The fewest triangles of a plain chain, each level 0.8 times the one before and simplified from
/// the original without a limit to the error, that deviate by no more than each bound, as measured.
fn plain(mesh: &MeshData, bounds: &[f32], points: u32) -> Result<Vec<usize>, meshopt::Error> {
    let mut fewest = vec![mesh.indices.len() / 3; bounds.len()];
    let mut triangles = mesh.indices.len() / 3;
    while triangles > 50 {
        triangles = triangles * 4 / 5;
        let level = simplify(&mesh.positions, &mesh.indices, triangles)?;
        let far = measured(mesh, &level, points).max;
        for (bound, fewest) in bounds.iter().zip(&mut fewest) {
            if far <= *bound {
                *fewest = (*fewest).min(level.len() / 3);
            }
        }
        // Coarser ones are no nearer.
        if bounds.iter().all(|b| far > 8.0 * b) {
            break;
        }
    }
    Ok(fewest)
}
