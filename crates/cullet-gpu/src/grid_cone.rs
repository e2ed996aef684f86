//! Cones of clusters in steps of a grid, and the eye as they take it: the test of back faces in
//! integers.

use bytemuck::{Pod, Zeroable};
use cullet::cull::backface::EllipticCone;
use glam::DVec3;

use super::grid::{Grid, MOST};

/// Components of the vectors of a cone reach so far: three products with numbers of 15 bits fit 30.
const VECTOR: f64 = 8191.0;
/// Numbers of an eye reach so far, so that rounding leaves them within 16 bits.
const EYE: f64 = 32000.0;
/// The way from an apex to the eye is off by so many steps at the most: see
/// [`GridCone::is_behind`].
const OFF: i32 = 2;
/// Shifted by so much, every apex is 0 or −1: lines of sight are parallel.
const PARALLEL: u32 = 31;

/// An [`EllipticCone`] on a [`Grid`]: 24 bytes, as they lie on the device. The default has no eye
/// behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridCone {
    /// A point behind every plane, in steps.
    pub apex: [i16; 3],
    /// The middle of the cone of normals, s and t: its vectors, all longer by one factor.
    pub vectors: [[i16; 3]; 3],
}

/// An eye on the grid of a mesh: 16 bytes, as they lie on the device. No cone is behind the
/// default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ConeEye {
    /// In units of 2^`shift` steps, 16 bits each.
    pub at: [i32; 3],
    /// How much coarser than the grid its units are; 31 for a direction.
    pub shift: u32,
}

impl Default for ConeEye {
    fn default() -> Self {
        Self { at: [0; 3], shift: PARALLEL }
    }
}

impl ConeEye {
    /// A homogeneous eye in the space of the mesh: a positive multiple of (position, 1), or of
    /// (direction towards the viewer, 0). The [default](Self::default) where a number is not
    /// finite, or the eye farther than 2³⁰ times the grid.
    #[must_use]
    pub fn new(eye: [f64; 4], grid: &Grid) -> Self {
        let [x, y, z, w] = eye;
        let way = DVec3::new(x, y, z);
        let (way, mut shift) = if w > 0.0 {
            ((way / w - DVec3::from(grid.origin)) / grid.step, 0)
        } else {
            (way * (EYE / way.abs().max_element()), PARALLEL)
        };
        let size = way.abs().max_element();
        // Written so that NaN is no eye.
        if !(w >= 0.0 && way.is_finite() && size <= EYE * f64::from(1 << (PARALLEL - 1))) {
            return Self::default();
        }
        while shift < PARALLEL && size > EYE * f64::from(1 << shift) {
            shift += 1;
        }
        let unit = if shift == PARALLEL { 1.0 } else { f64::from(1 << shift) };
        Self { at: (way / unit).round().to_array().map(|v| v as i32), shift }
    }
}

impl GridCone {
    /// A cone on a grid. The default, which keeps its cluster, where there is no place for its
    /// apex.
    #[must_use]
    pub fn new(cone: &EllipticCone, grid: &Grid) -> Self {
        let of = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let vectors = [cone.axis, cone.s, cone.t].map(of);
        let most = vectors.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
        let apex = (of(cone.apex) - DVec3::from(grid.origin)) / grid.step;
        let Some(apex) = within(apex, vectors) else { return Self::default() };
        let steps = |v: DVec3| v.round().to_array().map(|v| v as i16);
        Self { apex: steps(apex), vectors: vectors.map(|v| steps(v * (VECTOR / most))) }
    }

    /// Whether the eye is behind every plane of the cluster for sure. The device's shader does the
    /// same.
    ///
    /// With w the way from the apex to the eye and K the factor of the vectors, the cone is K
    /// axis·w < 0 and (K axis·w)² > (K s·w)² + (K t·w)². Of w it knows v, which is off by half a
    /// unit for the rounding of the eye, one for that of the shifted apex and a quarter for that of
    /// the apex itself, or by half and half without shift; halved, or quartered, rounded down, and
    /// so off by 2 at the most in each coordinate. A vector n is off by half in each. So n·v is off
    /// by at most 2 |n|₁ + (|v|₁ + 6) / 2.
    #[must_use]
    pub fn is_behind(&self, eye: &ConeEye) -> bool {
        let way: [i32; 3] =
            std::array::from_fn(|a| eye.at[a] - (i32::from(self.apex[a]) >> eye.shift));
        // To 15 bits with the sign.
        let size = way.iter().fold(0, |m, v| m.max(v.abs()));
        let shift = (top_bit(size) - 13).max(0);
        let way = way.map(|v| v >> shift);
        let around = way.iter().map(|v| v.abs()).sum::<i32>() / 2 + 2 * OFF;
        let along = |n: [i16; 3]| -> i32 { (0..3).map(|a| i32::from(n[a]) * way[a]).sum() };
        let off = |n: [i16; 3]| OFF * n.iter().map(|v| i32::from(*v).abs()).sum::<i32>() + around;
        let [axis, s, t] = self.vectors;
        let behind = -along(axis) - off(axis);
        if behind <= 0 {
            return false;
        }
        let across = [s, t].map(|n| along(n).abs() + off(n));
        // To 15 bits, so that squares fit 30.
        let shift = (top_bit(behind.max(across[0]).max(across[1])) - 14).max(0);
        let square = |v: i32| (v as u32).pow(2);
        let [s, t] = across.map(|v| square((v >> shift) + 1));
        square(behind >> shift) > s + t
    }
}

/// The number of the highest bit of what is not negative; −1 of zero.
fn top_bit(v: i32) -> i32 {
    31 - v.leading_zeros() as i32
}

/// An apex of the same cone, or of one within it, that lies on the grid: brought to the grid, then
/// moved behind so far that it is within the cone from before.
fn within(apex: DVec3, [axis, s, t]: [DVec3; 3]) -> Option<DVec3> {
    const REACH: f64 = MOST - 7.0;
    let on_grid = apex.clamp(DVec3::splat(-REACH), DVec3::splat(REACH));
    // Written so that NaN has no place.
    if apex == on_grid {
        return Some(apex);
    }
    // The way along which the axis falls by 1, and s and t not at all.
    let normal = s.cross(t);
    let behind = -normal / axis.dot(normal);
    let moved = on_grid - apex;
    let [along, across] = [axis.dot(moved), s.dot(moved).hypot(t.dot(moved))];
    let size = moved.length() * (axis.length() + s.length() + t.length());
    let by = (along + across + size * 1e-9).max(0.0);
    let found = on_grid + behind * by;
    (found.is_finite() && found.abs().max_element() <= REACH).then_some(found)
}
