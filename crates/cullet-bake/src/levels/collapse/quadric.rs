//! Sums of squared distances to planes.
//!
//! M. Garland and P. Heckbert, *Surface Simplification Using Quadric Error Metrics*, 1997.

use glam::{DVec3, Vec3};

/// The weighted sum of squared distances to planes, and the sum of weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// xx, yy, zz, xy, xz, yz.
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    /// The plane through a point with a unit normal.
    pub(super) fn plane(normal: DVec3, point: Vec3, weight: f64) -> Self {
        let d = -normal.dot(point.as_dvec3());
        let n = normal * weight;
        Self {
            a: [
                n.x * normal.x,
                n.y * normal.y,
                n.z * normal.z,
                n.x * normal.y,
                n.x * normal.z,
                n.y * normal.z,
            ],
            b: n * d,
            c: weight * d * d,
            weight,
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (a, b) in self.a.iter_mut().zip(other.a) {
            *a += b;
        }
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }

    /// The squared distance at a point, in the mean over weights.
    pub(super) fn at(&self, point: Vec3) -> f64 {
        let p = point.as_dvec3();
        let [xx, yy, zz, xy, xz, yz] = self.a;
        let rows = DVec3::new(
            xx * p.x + 2.0 * (xy * p.y + self.b.x),
            yy * p.y + 2.0 * (yz * p.z + self.b.y),
            zz * p.z + 2.0 * (xz * p.x + self.b.z),
        );
        let sum = rows.dot(p) + self.c;
        if self.weight > 0.0 { sum.abs() / self.weight } else { 0.0 }
    }
}
