//! Trees of boxes that rays walk: those of `obvhs`, in coordinates in which f32 and its constants
//! do no harm.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};

use super::crossing::enter_box;

/// Boxes, brought into the cube from −1 to 1.
#[derive(Debug)]
pub(super) struct BoxTree {
    tree: CwBvh,
    center: DVec3,
    scale: f64,
    bounds: [DVec3; 2],
}

/// Boxes are made larger by so much on each side, in the cube: some ten roundings of f32.
const SLACK: f64 = 2e-6;

/// How far before its start, or the cube's box, a ray begins: the tree takes nothing for met that
/// is nearer than 1e-4. More would have it visit all that lies so far behind the start.
const BEFORE: f64 = 2e-4;

impl BoxTree {
    /// A tree over boxes, of which there must be one and all must be finite; and for each place in
    /// the tree the number of its box.
    pub(super) fn new(boxes: &[[DVec3; 2]]) -> (Self, Vec<u32>) {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = boxes.iter().fold(none, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let center = low * 0.5 + high * 0.5;
        let half = (high * 0.5 - low * 0.5).max_element();
        // A single point has no size of its own.
        let scale = if half > 1e-300 { 1.0 / half } else { 1.0 };
        let inside: Vec<Aabb> = boxes
            .iter()
            .map(|b| {
                let [low, high] = b.map(|v| (v - center) * scale);
                Aabb::new((low - SLACK).as_vec3a(), (high + SLACK).as_vec3a())
            })
            .collect();
        let mut tree =
            build_cwbvh(&inside, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = std::mem::take(&mut tree.primitive_indices);
        // Flat ones have no room of their own.
        let slack = DVec3::splat(SLACK / scale);
        (Self { tree, center, scale, bounds: [low - slack, high + slack] }, order)
    }

    /// The box around all, a little larger.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// Visits the places of the boxes that a ray meets up to a distance in lengths of `along`,
    /// roughly from near to far. `visit` returns the distance from which on nothing is wanted any
    /// more. A box is never left out; one that is nearly met may be visited as well.
    #[inline]
    pub(super) fn walk(
        &self,
        start: DVec3,
        along: DVec3,
        limit: f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        let length = along.length();
        let Some(enter) = enter_box(&self.bounds, start, along) else { return };
        if enter > limit || !(length > 0.0 && length.is_finite()) {
            return;
        }
        let (unit, to_tree) = (along / length, length * self.scale);
        let from = (start + along * enter - self.center) * self.scale - unit * BEFORE;
        // A little farther, so that what lies at just that distance is not lost to rounding.
        let distance =
            |d: f64| ((d - enter) * to_tree + (BEFORE + 2.0 * SLACK)) as f32 * (1.0 + 1e-6);
        // No negative zero: the tree would take it for positive, and its inverse for negative.
        let unit = unit.as_vec3a() + Vec3A::ZERO;
        let ray = Ray::new(from.as_vec3a(), unit, 0.0, distance(limit));
        self.tree.ray_traverse(ray, &mut RayHit::none(), |_, at| distance(visit(at)));
    }
}
