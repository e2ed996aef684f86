//! The result: what can be seen from each cell.

use cullet::math;
use glam::DVec3;

use super::SampledSettings;
use super::cells::ViewCells;
use super::targets::{Ball, Granularity, Targets};
use super::tree::RayTree;
use crate::rows::{BitRows, ones};
use cullet_io::baked::Region;
use cullet_io::baked::{InstanceMark, hash, instance_marks, scene_hash};

/// First bytes of [`ScenePvs::rows_bytes`].
const MAGIC: &[u8; 8] = b"PVSROWS2";

/// Targets that can be seen from each view cell of a scene, as far as sampled lines found them.
///
/// Not conservative: what no line found is missing, unless a setting kept it.
/// [`missing`](Self::missing) estimates how much that is, and
/// [`check_pictures`](super::check_pictures) measures it by other means.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenePvs {
    /// The cells, as boxes in the world.
    pub cells: Vec<Region>,
    /// A row of bits for each cell, a bit for each [target](Self::targets).
    pub visible: BitRows,
    /// Targets that the bits stand for.
    pub targets: Targets,
    /// Estimated share, for each cell, of looks from random points of it, in random directions,
    /// that end on something that its row lacks. By Good and Turing: the share of lines without an
    /// aim that hit what no other line found before or since. It leaves out what the settings keep
    /// besides. It is an estimate, not a bound; 1 where no line passed.
    pub missing: Vec<f32>,
    /// Cells within something solid, as far as lines tell: whichever way one looks from them, the
    /// first that is met are backs of triangles. Their rows hold what would be seen, which need be
    /// of no use.
    pub buried: Vec<u32>,
    /// Rays that were traced, also those of the sets that it went on from.
    pub rays: u64,
    /// Sets like [`visible`](Self::visible), without what the settings kept besides: each bit is a
    /// line that was found, or one that the sets of before an edit had.
    pub found: BitRows,
    /// Hash of the geometry and places that it was baked for; see [`scene_hash`].
    pub scene_hash: u64,
    /// Marks of the instances, by which a later bake tells what an edit changed.
    pub marks: Vec<InstanceMark>,
}

impl ScenePvs {
    pub(super) fn new(
        tree: &RayTree<'_>,
        cells: &ViewCells,
        settings: &SampledSettings,
        (found, before): (BitRows, Option<BitRows>),
        missing: Vec<f32>,
        buried: Vec<u32>,
        rays: u64,
    ) -> Self {
        let mut visible = found.clone();
        keep_large(tree, cells, settings.keep_angle, &mut visible);
        for cell in 0..cells.len() {
            tree.kept().iter().for_each(|&target| visible.set(cell, target));
        }
        if let Some(radius) = settings.union_radius {
            // What was there before an edit was joined then.
            let mut news = visible.clone();
            if let Some(before) = &before {
                let words = news.words_mut().iter_mut().zip(before.words());
                words.for_each(|(new, old)| *new &= !old);
            }
            let news = joined(cells, radius, &news);
            visible.words_mut().iter_mut().zip(news.words()).for_each(|(all, new)| *all |= new);
        }
        Self {
            cells: (0..cells.len()).map(|c| cells.bounds(c)).collect(),
            visible,
            targets: tree.targets().clone(),
            missing,
            buried,
            rays,
            found,
            scene_hash: scene_hash(tree.scene),
            marks: instance_marks(tree.scene),
        }
    }

    /// How many pairs of a cell and a target are kept.
    #[must_use]
    pub fn visible_pairs(&self) -> u64 {
        self.visible.count()
    }

    /// The targets that a cell sees, ascending. The number must be one.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        ones(self.visible.row(cell))
    }

    /// The rows as plain bytes, little-endian: `PVSROWS2`, then u32 how many rows, bits and bytes a
    /// row has, then the rows one after the other, bit k of a row in byte k / 8 at place k % 8.
    /// Bits beyond the last are 0.
    #[must_use]
    pub fn rows_bytes(&self) -> Vec<u8> {
        let columns = self.visible.columns();
        let stride = (columns as usize).div_ceil(8);
        let mut out = MAGIC.to_vec();
        let rows = self.cells.len() as u32;
        [rows, columns, stride as u32].iter().for_each(|n| out.extend(n.to_le_bytes()));
        for row in 0..self.visible.rows() {
            out.extend(self.visible.row(row).iter().flat_map(|w| w.to_le_bytes()).take(stride));
        }
        out
    }

    /// Hash of [`rows_bytes`](Self::rows_bytes).
    #[must_use]
    pub fn rows_hash(&self) -> u64 {
        hash(&self.rows_bytes())
    }
}

/// Keeps what could appear wider than an angle.
fn keep_large(tree: &RayTree<'_>, cells: &ViewCells, angle: f64, visible: &mut BitRows) {
    // At π it is 1: only where an eye may be in the ball.
    let sine = math::sin(angle * 0.5);
    for body in tree.bodies() {
        let Some(range) = tree.targets().range(body.handle.index) else { continue };
        let b = tree.scene.bounds(body.slot);
        let corners = [b.min, b.max].map(|v| DVec3::from(v.map(f64::from)) + tree.origin);
        let radius = (corners[1] - corners[0]).length() * 0.5;
        // Clusters are within these bounds and no larger, so that only cells so near may keep one.
        let near = cells.near(&corners, radius / sine);
        if near.is_empty() {
            continue;
        }
        let balls: Vec<(u32, Ball)> =
            range.filter_map(|target| Some((target, tree.ball(target)?))).collect();
        for cell in near {
            let [low, high] = cells.boxes()[cell as usize];
            for (target, ball) in &balls {
                let distance = (ball.center - ball.center.clamp(low, high)).length();
                if distance * sine <= ball.radius {
                    visible.set(cell, *target);
                }
            }
        }
    }
}

/// Each row with those of all cells within a distance.
fn joined(cells: &ViewCells, radius: f64, visible: &BitRows) -> BitRows {
    let mut out = visible.clone();
    for cell in 0..cells.len() {
        for near in cells.near(&cells.boxes()[cell as usize], radius) {
            let row = visible.row(near);
            out.row_mut(cell).iter_mut().zip(row).for_each(|(a, b)| *a |= b);
        }
    }
    out
}

impl Granularity {
    /// Returns the name of the items that the bits stand for.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Instance => "instance",
            Self::Cluster => "cluster",
        }
    }
}
