//! Lines and translucent triangles over the scene: frusta, boxes, cones.

use cullet::bounds::Aabb;
use cullet::{Transform, View};
use glam::{DMat3, DVec3};

use crate::draw::LineVertex;

/// The corners of a box's twelve edges, as bits x, y, z.
const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// A colour with an alpha.
#[must_use]
pub fn tint([r, g, b]: [u8; 3], alpha: u8) -> [u8; 4] {
    [r, g, b, alpha]
}

/// A point of a mesh in world space.
#[must_use]
pub fn to_world(transform: &Transform, p: [f32; 3]) -> DVec3 {
    let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
    linear * DVec3::from(p.map(f64::from)) + DVec3::from(transform.translation)
}

/// Vertices of lines, two each, or of triangles, three each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines(pub Vec<LineVertex>);

impl Lines {
    fn vertex(&mut self, p: DVec3, colour: [u8; 4]) {
        self.0.push(LineVertex { position: p.as_vec3().to_array(), colour });
    }

    /// A line from `a` to `b`.
    pub fn line(&mut self, a: DVec3, b: DVec3, colour: [u8; 4]) {
        // A non-finite point has no place on the screen.
        if a.is_finite() && b.is_finite() {
            self.vertex(a, colour);
            self.vertex(b, colour);
        }
    }

    /// A triangle, for translucent surfaces.
    pub fn triangle(&mut self, corners: [DVec3; 3], colour: [u8; 4]) {
        if corners.iter().all(|c| c.is_finite()) {
            corners.iter().for_each(|&c| self.vertex(c, colour));
        }
    }

    /// The edges of a box given relative to `origin`; none of a box that is empty or endless.
    pub fn edges(&mut self, b: &Aabb, origin: [f64; 3], colour: [u8; 4]) {
        if b.is_empty() || !b.is_finite() {
            return;
        }
        let origin = DVec3::from(origin);
        let corner = |i: usize| {
            let of = |a: usize| f64::from(if i >> a & 1 == 1 { b.max[a] } else { b.min[a] });
            DVec3::new(of(0), of(1), of(2)) + origin
        };
        for [i, j] in EDGES {
            self.line(corner(i), corner(j), colour);
        }
    }

    /// The edges of what a view sees, to `length` beyond its near plane; and its sides as
    /// translucent triangles into `sides`.
    pub fn frustum(&mut self, view: &View, length: f64, colour: [u8; 4], sides: &mut Self) {
        let [w, h] = view.viewport().map(f64::from);
        let rays: Option<Vec<_>> = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]
            .into_iter()
            .map(|pixel| view.ray(pixel))
            .collect();
        let Some(rays) = rays else { return };
        // As far along the middle of the view as along its edges, so that the end is flat.
        let middle = view.ray([w * 0.5, h * 0.5]).map_or(DVec3::ZERO, |r| r.direction.into());
        let near: Vec<DVec3> = rays.iter().map(|r| r.origin.into()).collect();
        let far: Vec<DVec3> = rays
            .iter()
            .map(|r| {
                let d = DVec3::from(r.direction);
                DVec3::from(r.origin) + d * (length / d.dot(middle).max(0.05))
            })
            .collect();
        let [r, g, b, _] = colour;
        for i in 0..4 {
            let j = (i + 1) % 4;
            self.line(near[i], near[j], colour);
            self.line(near[i], far[i], colour);
            self.line(far[i], far[j], colour);
            sides.triangle([near[i], far[i], far[j]], [r, g, b, 22]);
            sides.triangle([near[i], far[j], near[j]], [r, g, b, 22]);
        }
        if !view.is_orthographic() {
            // A mark where the eye is, in three directions, of a size that is seen from afar.
            let [x, y, z, _] = view.eye();
            let eye = DVec3::new(x, y, z);
            let size = length * 0.012;
            for axis in DVec3::AXES {
                self.line(eye - axis * size, eye + axis * size, colour);
            }
        }
    }

    /// A cone from `apex` along the unit `axis`, `length` long, with this half angle.
    pub fn cone(
        &mut self,
        apex: DVec3,
        axis: DVec3,
        length: f64,
        half_angle: f64,
        colour: [u8; 4],
    ) {
        const SIDES: usize = 12;
        let (right, up) = axis.any_orthonormal_pair();
        let (sin, cos) = half_angle.min(std::f64::consts::FRAC_PI_2).sin_cos();
        let rim = |i: usize| {
            let (s, c) = (i as f64 / SIDES as f64 * std::f64::consts::TAU).sin_cos();
            apex + (axis * cos + (right * c + up * s) * sin) * length
        };
        self.line(apex, apex + axis * length, colour);
        for i in 0..SIDES {
            self.line(rim(i), rim(i + 1), colour);
            if i % 3 == 0 {
                self.line(apex, rim(i), colour);
            }
        }
    }
}
