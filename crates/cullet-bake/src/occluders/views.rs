//! How much of what a mesh hides its occluders hide, seen from all around.

use cullet::bounds::Aabb;
use glam::{DVec2, DVec3};

use super::Occluders;
use super::surface::Surface;
use crate::sample::fibonacci;
use cullet_io::baked::{BOX_QUADS, box_corners};

/// Pixels along each side of the pictures that are compared.
const SIZE: usize = 128;

/// Areas of the mesh and its occluders, seen from one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HiddenFrom {
    /// Towards the eye, which is infinitely far.
    pub direction: [f64; 3],
    /// The area of the mesh's opaque silhouette, in squared units of the mesh.
    pub mesh: f64,
    /// The area within it that the occluders cover.
    pub occluders: f64,
}

/// Measures both, from directions on a spiral; sampled at 128 × 128 points a direction.
pub(super) fn hidden(
    surface: &Surface,
    occluders: &Occluders,
    directions: usize,
) -> Vec<HiddenFrom> {
    let low = surface.points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = surface.points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    let radius = ((high - low) * 0.5).length();
    if surface.triangles.is_empty() || !radius.is_finite() || radius <= 0.0 {
        return Vec::new();
    }
    let pixel = 2.0 * radius / SIZE as f64;
    (0..directions)
        .map(|i| {
            let towards = fibonacci(i, directions);
            let mut mesh = Mask::new(towards, (low + high) * 0.5, pixel);
            let mut proxies = mesh.clone();
            for t in &surface.triangles {
                mesh.fill(&surface.corners(t), t.two_sided);
            }
            for b in &occluders.boxes {
                box_triangles(b).for_each(|t| proxies.fill(&t, true));
            }
            for polygon in &occluders.polygons {
                let points: Vec<DVec3> =
                    polygon.points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
                for w in points.windows(2).skip(1) {
                    proxies.fill(&[points[0], w[0], w[1]], polygon.two_sided);
                }
            }
            for sheet in &occluders.sheets {
                for t in &sheet.triangles {
                    proxies.fill(&t.map(|p| DVec3::from(p.map(f64::from))), sheet.two_sided);
                }
            }
            let count = |on: &mut dyn Iterator<Item = bool>| {
                on.filter(|b| *b).count() as f64 * pixel * pixel
            };
            HiddenFrom {
                direction: towards.to_array(),
                mesh: count(&mut mesh.on.iter().copied()),
                occluders: count(&mut mesh.on.iter().zip(&proxies.on).map(|(a, b)| *a && *b)),
            }
        })
        .collect()
}

/// The twelve triangles of a box, wound outward.
fn box_triangles(b: &Aabb) -> impl Iterator<Item = [DVec3; 3]> {
    let corners = box_corners(b).map(|p| DVec3::from(p.map(f64::from)));
    BOX_QUADS
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(move |t| t.map(|v| corners[v]))
}

/// Covered points of a plane, seen along a direction.
#[derive(Clone, Debug)]
struct Mask {
    right: DVec3,
    up: DVec3,
    middle: DVec3,
    pixel: f64,
    on: Vec<bool>,
}

impl Mask {
    fn new(towards: DVec3, middle: DVec3, pixel: f64) -> Self {
        let right = towards.any_orthonormal_vector();
        Self { right, up: towards.cross(right), middle, pixel, on: vec![false; SIZE * SIZE] }
    }

    /// Draws a triangle; one that faces away only if it has two sides.
    fn fill(&mut self, t: &[DVec3; 3], two_sided: bool) {
        let flat = t.map(|p| {
            let p = (p - self.middle) / self.pixel;
            DVec2::new(p.dot(self.right), p.dot(self.up)) + SIZE as f64 * 0.5
        });
        let [mut a, b, mut c] = flat;
        let area = (b - a).perp_dot(c - a);
        if area < 0.0 {
            if !two_sided {
                return;
            }
            (a, c) = (c, a);
        }
        let clamped = |v: DVec2| v.clamp(DVec2::ZERO, DVec2::splat(SIZE as f64));
        let (first, end) = (clamped(a.min(b).min(c).floor()), clamped(a.max(b).max(c).ceil()));
        for y in first.y as usize..end.y as usize {
            for x in first.x as usize..end.x as usize {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let inside =
                    [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (*e - *s).perp_dot(p - *s) >= 0.0);
                self.on[y * SIZE + x] |= inside;
            }
        }
    }
}
