//! Where an instance lies beside the planes.

use cullet::bounds::Plane;
use cullet::{Mesh, Transform};
use glam::{DMat3, DVec3};

/// Where an instance lies.
pub(super) enum Place {
    Inside,
    Outside,
    /// Planes touch its box: which, in the space of its mesh.
    Touched(Vec<(usize, Plane)>),
}

/// Moves the planes into the space of a mesh, and sees whether they touch its box at all.
pub(super) fn place(mesh: &Mesh, transform: &Transform, planes: &[Plane]) -> Place {
    let columns = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
    let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let b = mesh.bounds();
    let mut moved = Vec::with_capacity(planes.len());
    let mut inside = true;
    for (number, plane) in planes.iter().enumerate() {
        let n = DVec3::from(plane.normal);
        let local = linear.transpose() * n;
        let d = plane.d - n.dot(DVec3::from(transform.translation));
        // A transform that flattens everything along the normal, or is not finite: one side holds
        // all.
        if !Plane::new(local.into(), d).is_finite() || local.abs().max_element() < 1e-300 {
            if d < 0.0 {
                return Place::Outside;
            }
            continue;
        }
        let corners = (0..8).map(|i| {
            let pick = |a: usize| f64::from(if i >> a & 1 == 0 { b.min[a] } else { b.max[a] });
            DVec3::new(pick(0), pick(1), pick(2))
        });
        let size = local.abs().dot(DVec3::from(b.min.map(|v| f64::from(v.abs()))))
            + local.abs().dot(DVec3::from(b.max.map(|v| f64::from(v.abs()))))
            + d.abs();
        // Far above any rounding, so that what is near a plane is cut by the exact test.
        let slack = size * 1e-12;
        let span = corners
            .map(|p| local.dot(p) - d)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |s, v| [s[0].min(v), s[1].max(v)]);
        if span[0] > slack {
            return Place::Outside;
        }
        inside &= span[1] < -slack;
        moved.push((number, Plane::new(local.into(), d)));
    }
    if inside || moved.is_empty() { Place::Inside } else { Place::Touched(moved) }
}
