//! Effects that a collapse would have: on the shape of triangles, and on distances.

use glam::Vec3;

use super::ring::Ring;
use super::{Collapser, NONE, Task};

/// Cosine of the largest angle by which a triangle may turn.
const LEAST_TURN: f32 = 0.25;

/// Share of a limit that stands for a distance beyond it which is not known.
const BEYOND: f32 = 1.25;

/// New places that leave the triangles before by less than this share of the limit are not measured.
const NEAR: f32 = 0.5;
/// The same where all is to be within a bound.
const NEARER: f32 = 0.25;

/// Points within a triangle, as weights of its corners.
const INNER: [[f32; 3]; 5] =
    [[0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7], [0.45, 0.45, 0.1], [0.45, 0.1, 0.45]];

impl Collapser {
    /// Whether a collapse folds nothing over and makes no triangle twice.
    pub(super) fn is_sound(&self, ring: &Ring, v: u32, to: u32) -> bool {
        if !ring.is_clear(to) {
            return false;
        }
        let target = self.at[to as usize];
        let from = self.at[v as usize];
        for corner in &ring.corners {
            if corner.next == to || corner.prev == to {
                continue;
            }
            if !ring.maps(to, corner.wedge) {
                return false;
            }
            let (a, b) = (self.at[corner.next as usize], self.at[corner.prev as usize]);
            let side = b - a;
            let before = side.cross(from - a);
            let after = side.cross(target - a);
            let squares = before.length_squared() * after.length_squared();
            if before.length_squared() > 0.0 && before.dot(after) <= LEAST_TURN * squares.sqrt() {
                return false;
            }
        }
        // No triangle twice the same way.
        let mut c = self.head[to as usize];
        while c != NONE {
            let (t, k) = (self.triangles[c as usize / 3], c as usize % 3);
            c = self.next[c as usize];
            if t[0] != NONE {
                let next = self.place[t[(k + 1) % 3] as usize];
                let prev = self.place[t[(k + 2) % 3] as usize];
                if ring.corners.iter().any(|c| c.next == next && c.prev == prev) {
                    return false;
                }
            }
        }
        true
    }

    /// How far the points of the ring would be off; more than `limit` where that is known to be so.
    pub(super) fn measure(&mut self, ring: &Ring, to: u32, limit: f32) -> f32 {
        self.fan.clear();
        self.of_fan.clear();
        self.found.clear();
        for corner in &ring.corners {
            if corner.next != to && corner.prev != to {
                let three = [to, corner.next, corner.prev].map(|v| self.at[v as usize]);
                self.fan.push(three);
                self.of_fan.push(corner.triangle);
            }
        }
        if self.of_fan.is_empty() {
            return f32::INFINITY;
        }
        let most = limit * limit;
        let (own, number) = self.fan.nearest(self.at[ring.place as usize]);
        // Never the limit itself, as a root may be rounded to: the rest was not measured.
        let beyond = |squared: f32| squared.sqrt().max(limit.next_up());
        if own > most {
            return beyond(own);
        }
        self.own = (number, own.sqrt());
        let mut largest = own;
        for corner in &ring.corners {
            let mut next = self.first_point[corner.triangle as usize];
            while let Some(point) = self.points.get(next as usize) {
                let (squared, number) = self.fan.nearest(point.at);
                if squared > most {
                    return beyond(squared);
                }
                largest = largest.max(squared);
                self.found.push((number, squared.sqrt()));
                next = point.next;
            }
        }
        largest.sqrt()
    }

    /// How far new triangles leave the original, where that is more than the error so far; more than
    /// `most` where it is known to be so; within a bound only whether it is. Only points that leave
    /// the triangles before by a share of `most` are looked at.
    pub(super) fn back(&mut self, ring: &Ring, to: u32, most: f32, task: &Task<'_>) -> f32 {
        let Some(original) = task.original else { return 0.0 };
        let at = |v: u32| self.at[v as usize];
        let own = at(ring.place);
        self.fan.clear();
        ring.corners.iter().for_each(|c| self.fan.push([own, at(c.next), at(c.prev)]));
        let [known, limit] =
            [self.error.min(most), most].map(|far| (f64::from(far) / self.scale) as f32);
        let is_strict = task.limit < f32::INFINITY;
        let skipped = (most * if is_strict { NEARER } else { NEAR }).powi(2);
        let (mut far, mut last) = (0.0_f32, u32::MAX);
        let mut is_far = |p: Vec3| {
            if self.fan.nearest(p).0 <= skipped {
                return false;
            }
            let p = (p.as_dvec3() / self.scale + self.centre).as_vec3().to_array();
            if is_strict {
                // Who asks for a bound measures the result: whether is enough, how far is not asked.
                if !original.is_within(p, limit, &mut last) {
                    far = most * BEYOND;
                }
            } else if !original.is_within(p, known, &mut last) {
                // Beyond the limit it need not be known.
                far = far.max(match original.nearest(p, limit) {
                    Some((distance, _)) => (f64::from(distance) * self.scale) as f32,
                    None => most * BEYOND,
                });
            }
            far > most
        };
        for c in ring.corners.iter().filter(|c| c.next != to && c.prev != to) {
            let (own, a, b) = (at(to), at(c.next), at(c.prev));
            // The middle of each new edge once, but for those along a border or a seam.
            if is_far((own + a) * 0.5)
                || !ring.is_plain(c.prev) && is_far((own + b) * 0.5)
                || is_far((own + a + b) / 3.0)
                || is_strict && INNER.iter().any(|w| is_far(own * w[0] + a * w[1] + b * w[2]))
            {
                break;
            }
        }
        far
    }
}
