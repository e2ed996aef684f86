//! Sides between touched voxels: which are proven closed, because each of their points lies within
//! a wall.
//!
//! The planes of all triangles near a side cut it into convex polygons. No surface crosses one of
//! them, so it lies wholly within a wall if one of its points does. That needs no wall of voxels: a
//! wall that is thicker than one is enough, and walls that only touch each other close what is
//! between them. Contacts that are open by less than a thousandth of a voxel count as closed.

use glam::{DVec2, DVec3};

use super::options::RoomsError;
use super::voxels::{TOUCHED, Voxels, winding};
use crate::sampled::RayTree;
use crate::threads;
use cullet_draw::Random;

/// A side that more lines cross is open.
const MOST_LINES: usize = 20;
/// Touched voxels of a job.
const BLOCK: usize = 4096;

/// Closed sides of voxels.
pub(super) struct Sides {
    /// Sides of each touched voxel, one bit for its high side along each axis.
    closed: Vec<u8>,
    /// Sides between two touched voxels, and how many are closed.
    pub(super) counts: [u64; 2],
}

impl Sides {
    pub(super) fn new(
        tree: &RayTree<'_>,
        voxels: &Voxels<'_>,
        threads: usize,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, RoomsError> {
        let blocks = voxels.touched.len().div_ceil(BLOCK);
        let job = |scratch: &mut Scratch, block: usize| {
            let all = &voxels.touched[block * BLOCK..];
            let mut counts = [0; 2];
            let bits = all.iter().take(BLOCK).map(|&(voxel, _)| {
                let mut bits = 0;
                for axis in 0..3 {
                    let beyond = voxel as usize + voxels.grid.strides()[axis];
                    // The voxels at the border of the grid are free.
                    if voxels.states.get(beyond) == Some(&TOUCHED) {
                        let is_closed = scratch.is_closed(tree, voxels, voxel, axis);
                        counts[0] += 1;
                        counts[1] += u64::from(is_closed);
                        bits |= u8::from(is_closed) << axis;
                    }
                }
                bits
            });
            (bits.collect::<Vec<u8>>(), counts)
        };
        let blocks = threads::run(threads, blocks, Scratch::default, job, go_on);
        let mut out = Self { closed: Vec::with_capacity(voxels.touched.len()), counts: [0; 2] };
        for (bits, counts) in blocks.ok_or(RoomsError::Stopped)? {
            out.closed.extend(bits);
            (0..2).for_each(|i| out.counts[i] += counts[i]);
        }
        Ok(out)
    }

    /// Writes them into the states of the voxels, above the lower four bits: closed high sides.
    pub(super) fn mark(&self, voxels: &mut Voxels<'_>) {
        for (&(voxel, _), bits) in voxels.touched.iter().zip(&self.closed) {
            // A solid voxel is closed as it is.
            if voxels.states[voxel as usize] == TOUCHED {
                voxels.states[voxel as usize] |= bits << 4;
            }
        }
    }
}

/// Memory of a thread.
#[derive(Default)]
struct Scratch {
    near: Vec<u32>,
    lines: Vec<(DVec2, f64)>,
    polygons: Vec<Vec<DVec2>>,
    walls: Vec<u32>,
}

impl Scratch {
    /// Whether the high side of a voxel along an axis is proven closed.
    fn is_closed(
        &mut self,
        tree: &RayTree<'_>,
        voxels: &Voxels<'_>,
        voxel: u32,
        axis: usize,
    ) -> bool {
        let grid = &voxels.grid;
        let beyond = voxel + grid.strides()[axis] as u32;
        self.near.clear();
        self.near.extend(voxels.triangles_of(voxel));
        self.near.extend(voxels.triangles_of(beyond));
        self.near.sort_unstable();
        self.near.dedup();
        self.walls.clear();
        self.walls.extend(self.near.iter().map(|&t| voxels.triangles[t as usize].wall));
        self.walls.dedup();
        let mut at = grid.place(voxel as usize);
        at[axis] += 1;
        let low = DVec3::from_array(std::array::from_fn(|a| grid.coordinate(a, at[a])));
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let half = grid.size * 0.5;
        let mut middle = low;
        middle[b] += half;
        middle[c] += half;
        // Half of the crack that counts as closed.
        let crack = grid.size * 5e-4;
        let slack = grid.slack();
        self.lines.clear();
        for &t in &self.near {
            let corners = voxels.triangles[t as usize].corners.map(|p| p - middle);
            let [p, q, r] = corners;
            let (least, most) = (p.min(q).min(r), p.max(q).max(r));
            let misses = |a: usize, reach: f64| least[a] > reach || most[a] < -reach;
            if misses(axis, slack) || misses(b, half + slack) || misses(c, half + slack) {
                continue;
            }
            let Some(normal) = (q - p).cross(r - p).try_normalize() else { continue };
            let across = DVec2::new(normal[b], normal[c]);
            let steep = across.length();
            // In the plane of the side itself: the triangles beside it along their edges are what
            // cuts it.
            if steep < 1e-6 {
                continue;
            }
            let line = (across / steep, normal.dot(p) / steep);
            let is_same = |other: &(DVec2, f64)| {
                let turn = if other.0.dot(line.0) < 0.0 { -1.0 } else { 1.0 };
                (other.0 * turn - line.0).length() < 1e-6
                    && (other.1 * turn - line.1).abs() < crack * 0.5
            };
            if line.1.abs() < 2.0 * half && !self.lines.iter().any(is_same) {
                if self.lines.len() == MOST_LINES {
                    return false;
                }
                self.lines.push(line);
            }
        }
        self.cut(half, crack);
        let mut random = Random::new(0x7369_6465, [voxel, axis as u32]);
        let (polygons, walls) = (&self.polygons, &self.walls);
        polygons.iter().all(|polygon| {
            let inner = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
            let mut point = middle;
            point[b] += inner.x;
            point[c] += inner.y;
            walls.iter().any(|&wall| {
                let body = voxels.walls[wall as usize];
                winding(tree, body, point, &mut random) == Some(true)
            })
        })
    }

    /// Cuts the side, about its middle, at all lines; what would be a thinner strip than a crack is
    /// not cut off.
    fn cut(&mut self, half: f64, crack: f64) {
        let corner = |x: f64, y: f64| DVec2::new(x, y) * half;
        self.polygons.clear();
        self.polygons.push(vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ]);
        for &(normal, d) in &self.lines {
            for at in 0..self.polygons.len() {
                let heights = self.polygons[at].iter().map(|p| normal.dot(*p) - d);
                let least = heights.clone().fold(f64::INFINITY, f64::min);
                let most = heights.fold(f64::NEG_INFINITY, f64::max);
                if least > -crack || most < crack {
                    continue;
                }
                let above = clip(&self.polygons[at], -normal, -d);
                self.polygons[at] = clip(&self.polygons[at], normal, d);
                self.polygons.push(above);
            }
        }
    }
}

/// The part of a convex polygon where n·p ≤ d.
fn clip(polygon: &[DVec2], normal: DVec2, d: f64) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (from, to) = (normal.dot(p) - d, normal.dot(q) - d);
        if from <= 0.0 {
            out.push(p);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            out.push(p.lerp(q, from / (from - to)));
        }
    }
    out
}
