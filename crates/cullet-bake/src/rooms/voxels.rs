//! Voxels of a scene: touched by the surface of a wall, within one, or free.
//!
//! A *wall* is an instance that is closed, opaque and does not move. Everything else hides nothing
//! here. Along a line that no surface stops, which is drawn from its front at least, the surface of
//! a wall is never wound more often: so who is outside of it never sees a place within.

use cullet::math;
use cullet::mesh::{Alpha, Mesh};
use glam::{DVec3, IVec3};

use super::options::{FindOptions, RoomsError};
use crate::sampled::{Body, RayTree, direction};
use crate::threads;
use cullet_draw::Random;

/// Free: no wall touches or holds it.
pub(super) const FREE: u8 = 0;
/// The surface of a wall may be in it.
pub(super) const TOUCHED: u8 = 1;
/// Wholly within a wall.
pub(super) const SOLID: u8 = 2;

/// Voxels about the bounds of the scene, all of them free.
const MARGIN: f64 = 1.0;
/// So that walls at round coordinates do not lie on the borders of voxels, where they touch both.
const SHIFT: f64 = 0.381_966;
/// Most pairs of a triangle and a voxel that it touches.
const MOST_TOUCHES: u64 = 100_000_000;

/// Places of voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) low: DVec3,
    pub(super) size: f64,
    pub(super) counts: [usize; 3],
}

impl Grid {
    pub(super) fn new(bounds: [DVec3; 2], size: f64) -> Result<Self, RoomsError> {
        let [low, high] = bounds;
        // The last are free, also if rounding moves what is before them.
        let counts_of = |size: f64| {
            let counts = (high - low) / size + 2.0 * MARGIN + SHIFT + 1.01;
            counts.floor().max(DVec3::splat(3.0))
        };
        let counts = counts_of(size);
        let limit = FindOptions::MOST_VOXELS;
        let all = counts.element_product();
        if all > limit as f64 {
            // So small that it is too many as well, and a finite number of them.
            let mut fits = size.max((high - low).max_element() * 1e-4);
            while counts_of(fits).element_product() > limit as f64 {
                let over = counts_of(fits).element_product() / limit as f64;
                fits *= math::cbrt(over).max(1.001);
            }
            let counts = counts.to_array().map(|n| n as u64);
            return Err(RoomsError::TooMany { voxel: size, counts, limit, fits });
        }
        let low = low - (MARGIN + SHIFT) * size;
        Ok(Self { low, size, counts: counts.to_array().map(|n| n as usize) })
    }

    pub(super) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.counts[0], self.counts[0] * self.counts[1]]
    }

    pub(super) fn number(&self, at: [usize; 3]) -> usize {
        (at[2] * self.counts[1] + at[1]) * self.counts[0] + at[0]
    }

    pub(super) fn place(&self, number: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [number % nx, number / nx % ny, number / (nx * ny)]
    }

    /// Where the voxels of a number begin along an axis: the same float for all that end or begin
    /// there.
    pub(super) fn coordinate(&self, axis: usize, at: usize) -> f64 {
        self.low[axis] + at as f64 * self.size
    }

    fn middle(&self, at: [usize; 3]) -> DVec3 {
        self.low + (IVec3::from_array(at.map(|v| v as i32)).as_dvec3() + 0.5) * self.size
    }

    /// The voxels that a box comes into, first and last along each axis.
    fn range(&self, low: DVec3, high: DVec3) -> [[usize; 2]; 3] {
        std::array::from_fn(|a| {
            let at = |v: f64| ((v - self.low[a]) / self.size).floor();
            let most = self.counts[a] as f64 - 1.0;
            [at(low[a]).clamp(0.0, most) as usize, at(high[a]).clamp(0.0, most) as usize]
        })
    }

    /// Returns the distance by which rounding may move corners and borders.
    pub(super) fn slack(&self) -> f64 {
        let far = (0..3).map(|a| self.low[a].abs().max(self.coordinate(a, self.counts[a]).abs()));
        self.size * 1e-3 + far.fold(0.0, f64::max) * 1e-12
    }
}

/// A triangle of a wall, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallTriangle {
    pub(super) corners: [DVec3; 3],
    /// Number of the wall.
    pub(super) wall: u32,
}

/// Voxels, and what touches them.
pub(super) struct Voxels<'a> {
    pub(super) grid: Grid,
    pub(super) states: Vec<u8>,
    pub(super) walls: Vec<&'a Body>,
    pub(super) triangles: Vec<WallTriangle>,
    /// Touched voxels, ascending, and where the triangles of each begin in `touching`.
    pub(super) touched: Vec<(u32, u32)>,
    pub(super) touching: Vec<u32>,
}

/// The walls of a scene: closed, opaque, standing.
pub(super) fn walls<'a>(tree: &'a RayTree<'_>, options: &FindOptions) -> Vec<&'a Body> {
    let scene = tree.scene();
    let closed: Vec<bool> = scene.meshes().iter().map(is_closed).collect();
    let stands = |body: &&Body| {
        let mesh = scene.mesh(body.slot);
        closed[body.mesh as usize]
            && !body.is_transparent()
            && mesh.parts().iter().all(|part| part.alpha == Alpha::Opaque)
            && !options.ignored.contains(&body.handle)
    };
    let mut walls: Vec<&Body> = tree.bodies().iter().filter(stands).collect();
    walls.sort_by_key(|body| body.handle);
    walls
}

/// Whether each edge is gone along as often one way as the other, by the places of its ends. Then
/// how often the surface is wound around a point is a whole number that changes at the surface
/// alone, by one: also where more than two triangles meet, as at the holes that were cut into a
/// wall.
fn is_closed(mesh: &Mesh) -> bool {
    // Both zeros are one place.
    let place = |p: [f32; 3]| p.map(|v| (v + 0.0).to_bits());
    let mut edges = Vec::with_capacity(mesh.triangle_count() as usize * 3);
    for t in 0..mesh.triangle_count() {
        let corners = mesh.corners(t).map(place);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            let one = if from < to { 1 } else { -1 };
            edges.push(([from.min(to), from.max(to)], if from == to { 0 } else { one }));
        }
    }
    edges.sort_unstable();
    let of_edge = |same: &[([[u32; 3]; 2], i32)]| same.iter().map(|(_, one)| one).sum::<i32>() == 0;
    !edges.is_empty() && edges.chunk_by(|a, b| a.0 == b.0).all(of_edge)
}

/// How thick a wall is: twice its volume over its surface, which is right for a plate; with its
/// surface.
pub(super) fn thickness(tree: &RayTree<'_>, body: &Body) -> [f64; 2] {
    let mesh = tree.scene().mesh(body.slot);
    let (mut volume, mut area) = (0.0, 0.0);
    let from = body.place_of(if mesh.triangle_count() > 0 { mesh.corners(0)[0] } else { [0.0; 3] });
    for t in 0..mesh.triangle_count() {
        let [p, q, r] = mesh.corners(t).map(|p| body.place_of(p) - from);
        let cross = (q - p).cross(r - p);
        area += cross.length() * 0.5;
        volume += p.dot(cross) / 6.0;
    }
    [2.0 * f64::abs(volume) / area.max(1e-300), area]
}

/// Findings of a job about a wall.
struct Filled {
    triangles: Vec<[DVec3; 3]>,
    /// Voxels, and which triangle touches each.
    touches: Vec<(u32, u32)>,
    /// Runs of voxels within: first and how many.
    within: Vec<[u32; 2]>,
    /// Voxels of which rays disagree.
    unsure: Vec<u32>,
}

impl<'a> Voxels<'a> {
    /// Fills voxels with walls that are at least four voxels wide along two axes: smaller ones
    /// close nothing.
    pub(super) fn new(
        tree: &'a RayTree<'_>,
        walls: Vec<&'a Body>,
        grid: Grid,
        threads: usize,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, RoomsError> {
        let wide = |body: &&Body| {
            let [low, high] = tree.body_bounds(body);
            let mut extents = (high - low).to_array();
            extents.sort_by(f64::total_cmp);
            extents[1] >= 4.0 * grid.size
        };
        let walls: Vec<&Body> = walls.into_iter().filter(wide).collect();
        if walls.is_empty() {
            return Err(RoomsError::NoWalls { instances: tree.scene().instance_count() });
        }
        let job = |_: &mut (), at: usize| fill(tree, walls[at], &grid);
        let filled = threads::run(threads, walls.len(), || (), job, go_on);
        let filled = filled.ok_or(RoomsError::Stopped)?;
        let found: u64 = filled.iter().map(|f| f.touches.len() as u64).sum();
        if found > MOST_TOUCHES {
            let limit = MOST_TOUCHES;
            return Err(RoomsError::TooDense { found, voxel: grid.size, limit });
        }
        let mut states = vec![FREE; grid.len()];
        let mut triangles = Vec::new();
        let mut touches: Vec<(u32, u32)> = Vec::with_capacity(found as usize);
        for (wall, filled) in (0..).zip(&filled) {
            let first = triangles.len() as u32;
            triangles
                .extend(filled.triangles.iter().map(|&corners| WallTriangle { corners, wall }));
            touches.extend(filled.touches.iter().map(|&(voxel, t)| (voxel, first + t)));
            touches.iter().skip(touches.len() - filled.touches.len()).for_each(|&(voxel, _)| {
                states[voxel as usize] = TOUCHED;
            });
            filled.unsure.iter().for_each(|&voxel| states[voxel as usize] = TOUCHED);
        }
        // What is wholly within one wall is solid, whatever else touches it.
        for [first, count] in filled.iter().flat_map(|f| &f.within) {
            states[*first as usize..][..*count as usize].fill(SOLID);
        }
        drop(filled);
        touches.retain(|&(voxel, _)| states[voxel as usize] == TOUCHED);
        touches.sort_unstable();
        let mut touched: Vec<(u32, u32)> = Vec::new();
        for (at, &(voxel, _)) in (0..).zip(&touches) {
            if touched.last().is_none_or(|&(last, _)| last != voxel) {
                touched.push((voxel, at));
            }
        }
        let touching = touches.into_iter().map(|(_, t)| t).collect();
        Ok(Self { grid, states, walls, triangles, touched, touching })
    }

    /// The triangles that touch a voxel, ascending.
    pub(super) fn triangles_of(&self, voxel: u32) -> &[u32] {
        let Ok(at) = self.touched.binary_search_by_key(&voxel, |&(voxel, _)| voxel) else {
            return &[];
        };
        let end = self.touched.get(at + 1).map_or(self.touching.len(), |&(_, end)| end as usize);
        &self.touching[self.touched[at].1 as usize..end]
    }
}

/// The voxels that a wall touches and holds.
fn fill(tree: &RayTree<'_>, body: &Body, grid: &Grid) -> Filled {
    let mesh = tree.scene().mesh(body.slot);
    let slack = grid.slack();
    let mut out = Filled {
        triangles: Vec::new(),
        touches: Vec::new(),
        within: Vec::new(),
        unsure: Vec::new(),
    };
    for t in 0..mesh.triangle_count() {
        let corners = mesh.corners(t).map(|p| tree.world_of(body, p));
        touch(grid, &corners, slack, |voxel| out.touches.push((voxel as u32, t)));
        out.triangles.push(corners);
    }
    let corners = || out.triangles.iter().flatten();
    let low = corners().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let range = grid.range(low - slack, high + slack);
    let extents: [usize; 3] = std::array::from_fn(|a| range[a][1] - range[a][0] + 1);
    if extents.iter().any(|&n| n < 3) {
        return out;
    }
    let mut touched = vec![false; extents.iter().product()];
    let local = |voxel: usize| {
        let at = grid.place(voxel);
        let at: [usize; 3] = std::array::from_fn(|a| at[a] - range[a][0].min(at[a]));
        (at[2] * extents[1] + at[1]) * extents[0] + at[0]
    };
    out.touches.iter().for_each(|&(voxel, _)| touched[local(voxel as usize)] = true);
    let mut random = Random::new(0x726f_6f6d, [body.handle.index, 0]);
    for z in range[2][0]..=range[2][1] {
        for y in range[1][0]..=range[1][1] {
            let first = grid.number([range[0][0], y, z]);
            let row = &touched[local(first)..][..extents[0]];
            // Voxels without a triangle between two with one are all within or all without.
            let mut x = 0;
            while x < row.len() {
                if row[x] {
                    x += 1;
                    continue;
                }
                let count = row[x..].iter().take_while(|&&t| !t).count();
                let middle = grid.middle([range[0][0] + x, y, z]);
                let run = [(first + x) as u32, count as u32];
                match winding(tree, body, middle, &mut random) {
                    Some(true) => out.within.push(run),
                    Some(false) => {}
                    None => out.unsure.extend(run[0]..run[0] + run[1]),
                }
                x += count;
            }
        }
    }
    out
}

/// Whether the surface of a wall is wound around a point, by three rays; `None` where they
/// disagree.
pub(super) fn winding(
    tree: &RayTree<'_>,
    body: &Body,
    point: DVec3,
    random: &mut Random,
) -> Option<bool> {
    let first = tree.winding(body, point, direction(random));
    let all = (0..2).all(|_| tree.winding(body, point, direction(random)) == first);
    all.then_some(first > 0)
}

/// Calls `touch` with all voxels that a triangle may come into: those of its box that its plane
/// comes into.
fn touch(grid: &Grid, corners: &[DVec3; 3], slack: f64, mut touch: impl FnMut(usize)) {
    let [p, q, r] = *corners;
    let range = grid.range(p.min(q).min(r) - slack, p.max(q).max(r) + slack);
    let normal = (q - p).cross(r - p);
    let length = normal.length();
    // Along this axis the plane is crossed soonest.
    let along = normal.abs().max_position();
    let strides = grid.strides();
    let [first, last] = range[along];
    let (b, c) = ((along + 1) % 3, (along + 2) % 3);
    // A voxel as far from the plane as this holds nothing of it; a triangle without area has no
    // plane.
    let reach = normal.abs().element_sum() * grid.size * 0.5 + length * slack;
    for j in range[c][0]..=range[c][1] {
        for i in range[b][0]..=range[b][1] {
            let mut at = [0; 3];
            (at[b], at[c]) = (i, j);
            let base = i * strides[b] + j * strides[c];
            let height = normal.dot(grid.middle(at) - p);
            let ends = [-reach - height, reach - height].map(|h| h / (normal[along] * grid.size));
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let span = if length > 0.0 && low.is_finite() && high.is_finite() {
                let (low, high) = ((low - 1e-6).ceil(), (high + 1e-6).floor());
                if high < first as f64 || low > last as f64 {
                    continue;
                }
                [low.max(first as f64) as usize, high.min(last as f64) as usize]
            } else {
                [first, last]
            };
            (span[0]..=span[1]).for_each(|k| touch(base + k * strides[along]));
        }
    }
}
