//! Collapses edges while the deviation that it measures stays within a limit.

mod near;
mod quadric;
mod ring;
#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use cullet::math;
use cullet_draw::surface::SurfaceTree;
use glam::{DVec3, Vec3};

use near::Fan;
use quadric::Quadric;
use ring::Ring;

const NONE: u32 = u32::MAX;

/// Input of a simplification.
pub(crate) struct Task<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    /// For each vertex the first at its position.
    pub(crate) place: &'a [u32],
    pub(crate) indices: &'a [u32],
    /// Whether a place stays, by its first vertex.
    pub(crate) locks: &'a [bool],
    /// For each place the share of the limit that collapses next to it may use; empty for all of it.
    pub(crate) shares: &'a [f32],
    /// Points of the original, triangle by triangle, and how many each triangle has.
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) distances: &'a [f32],
    pub(crate) counts: &'a [u32],
    /// Stop at so many triangles.
    pub(crate) triangles: usize,
    /// Collapses that keep within this are made even then.
    pub(crate) free: f32,
    /// No point may be farther than this.
    pub(crate) limit: f32,
    /// The surface that new triangles may not leave; `None` leaves that to who measures the result.
    pub(crate) original: Option<&'a SurfaceTree>,
}

/// How far a collapse may be off beside its key: the estimate by quadrics is a mean, so that of what
/// is estimated alike the flat ones go first. With 1 a fifth more triangles are drawn, with a half a
/// few percent fewer, in half as much time again.
const EXPECTED: f32 = 0.7;

/// All are tried again while more than this part of the triangles goes.
const SWEEP: usize = 64;

/// The share of triangles that goes in any case.
const WORTH: f64 = 0.2;

/// Cosine of the largest angle by which a triangle may turn.
const LEAST_TURN: f32 = 0.25;

/// What counts for a distance beyond a limit that is not known.
const BEYOND: f32 = 1.25;

/// New places that leave the triangles before by less than this share of the limit are not measured.
const NEAR: f32 = 0.5;

/// Points within a triangle, as weights of its corners.
const INNER: [[f32; 3]; 5] = [
    [0.7, 0.15, 0.15],
    [0.15, 0.7, 0.15],
    [0.15, 0.15, 0.7],
    [0.45, 0.45, 0.1],
    [0.45, 0.1, 0.45],
];

/// A point of the original.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: Vec3,
    distance: f32,
    next: u32,
}

/// Reused memory.
#[derive(Debug, Default)]
pub(crate) struct Collapser {
    at: Vec<Vec3>,
    place: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// First corner at each place, next corner at the place of each corner.
    head: Vec<u32>,
    next: Vec<u32>,
    locked: Vec<bool>,
    quadrics: Vec<Quadric>,
    points: Vec<Point>,
    first_point: Vec<u32>,
    keys: Vec<f32>,
    blocked: Vec<bool>,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
    /// The largest distance so far.
    error: f32,
    ring: Ring,
    fan: Fan,
    of_fan: Vec<u32>,
    found: Vec<(u32, f32)>,
    centre: DVec3,
    scale: f64,
    left: usize,
    estimate: f32,
}

/// Result: triangles, with the points that each has.
#[derive(Clone, Debug, Default)]
pub(crate) struct Collapsed {
    pub(crate) indices: Vec<u32>,
    /// Number of the triangle of the input that each was.
    pub(crate) from: Vec<u32>,
    /// The largest estimate by quadrics of any collapse: no bound.
    pub(crate) estimate: f32,
    /// The largest distance that was measured, at least what was free.
    pub(crate) error: f32,
}

impl Collapser {
    pub(crate) fn run(&mut self, task: &Task<'_>) -> Collapsed {
        self.load(task);
        self.collapse_all(task);
        let estimate = (f64::from(self.estimate) / self.scale) as f32;
        let error = (f64::from(self.error) / self.scale) as f32;
        let mut out = Collapsed { estimate, error, ..Collapsed::default() };
        for (t, corners) in (0..).zip(&self.triangles) {
            if corners[0] != NONE {
                out.indices.extend(corners);
                out.from.push(t);
            }
        }
        out
    }

    /// Points of a triangle of the input that is still there: their numbers in the input, and how far
    /// they are off.
    pub(crate) fn points_of(&self, t: u32) -> impl Iterator<Item = (u32, f32)> {
        let mut next = self.first_point[t as usize];
        std::iter::from_fn(move || {
            let own = next;
            let point = self.points.get(own as usize)?;
            next = point.next;
            Some((own, (f64::from(point.distance) / self.scale) as f32))
        })
    }

    fn load(&mut self, task: &Task<'_>) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in task.indices {
            let p = DVec3::from_array(task.positions[v as usize].map(f64::from));
            (low, high) = (low.min(p), high.max(p));
        }
        let half = ((high - low) * 0.5).max_element();
        self.scale = if half > 0.0 { (-half.log2().ceil()).exp2() } else { 1.0 };
        self.centre = if half >= 0.0 { (low + high) * 0.5 } else { DVec3::ZERO };
        let (centre, scale) = (self.centre, self.scale);
        let bring = |p: &[f32; 3]| ((DVec3::from_array(p.map(f64::from)) - centre) * scale).as_vec3();
        self.at.clear();
        self.at.extend(task.positions.iter().map(bring));
        self.place.clear();
        self.place.extend(task.place);
        let vertices = task.positions.len();
        self.locked.clear();
        self.locked.extend(task.locks);
        self.head.clear();
        self.head.resize(vertices, NONE);
        self.next.clear();
        self.next.resize(task.indices.len(), NONE);
        self.triangles.clear();
        self.triangles.extend(task.indices.as_chunks::<3>().0);
        self.left = self.triangles.len();
        self.estimate = 0.0;
        for (c, &v) in task.indices.iter().enumerate().rev() {
            let p = self.place[v as usize] as usize;
            self.next[c] = self.head[p];
            self.head[p] = c as u32;
        }
        self.points.clear();
        self.first_point.clear();
        let mut at = 0;
        for &count in task.counts {
            let end = at + count as usize;
            self.first_point.push(if count > 0 { at as u32 } else { NONE });
            for i in at..end {
                let next = if i + 1 < end { i as u32 + 1 } else { NONE };
                let distance = (f64::from(task.distances[i]) * scale) as f32;
                self.points.push(Point { at: bring(&task.points[i]), distance, next });
            }
            at = end;
        }
        self.keys.clear();
        self.keys.resize(vertices, 0.0);
        self.blocked.clear();
        self.blocked.resize(vertices, false);
        self.fill_quadrics();
    }

    fn fill_quadrics(&mut self) {
        self.quadrics.clear();
        self.quadrics.resize(self.at.len(), Quadric::default());
        for t in 0..self.triangles.len() {
            let corners = self.triangles[t];
            let [a, b, c] = corners.map(|v| self.at[v as usize]);
            let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let area = cross.length();
            if area <= 0.0 {
                continue;
            }
            let q = Quadric::plane(cross / area, a, area.sqrt());
            for v in corners {
                self.quadrics[self.place[v as usize] as usize].add(&q);
            }
        }
        // Edges that are to stay where they are: borders and seams.
        for v in 0..self.at.len() as u32 {
            if self.head[v as usize] == NONE {
                continue;
            }
            let Self { ring, .. } = self;
            ring.gather(v, &self.head, &self.next, &self.triangles, &self.place);
            for n in 0..self.ring.around.len() {
                let near = self.ring.around[n];
                if near.is_plain() || near.place < v {
                    continue;
                }
                let weight = if near.is_border() { 10.0 } else { 0.5 };
                for t in [near.triangle_out, near.triangle_in] {
                    if t == NONE {
                        continue;
                    }
                    let corners = self.triangles[t as usize];
                    let [a, b, c] = corners.map(|v| self.at[v as usize].as_dvec3());
                    let normal = (b - a).cross(c - a);
                    let (from, to) = (self.at[v as usize], self.at[near.place as usize]);
                    let along = (to - from).as_dvec3();
                    let across = along.cross(normal);
                    let length = across.length();
                    if length <= 0.0 {
                        continue;
                    }
                    let q = Quadric::plane(across / length, from, along.length() * weight);
                    self.quadrics[v as usize].add(&q);
                    self.quadrics[near.place as usize].add(&q);
                }
            }
        }
    }

    /// Collapses places in the order of their keys until the target is reached. A place whose
    /// neighbours changed may be cheaper than it was, so all are tried again, until that gains
    /// little.
    fn collapse_all(&mut self, task: &Task<'_>) {
        self.error = task.free * self.scale as f32;
        self.heap.clear();
        let before = self.left;
        loop {
            let left = self.left;
            for v in 0..self.at.len() as u32 {
                if self.head[v as usize] != NONE && !self.locked[v as usize] {
                    self.keys[v as usize] = self.least(v);
                    self.wait(v);
                }
            }
            if self.run_queue(before, task) || (left - self.left) * SWEEP <= left {
                break;
            }
        }
    }

    /// Returns whether the target is reached.
    fn run_queue(&mut self, before: usize, task: &Task<'_>) -> bool {
        let limit = task.limit * self.scale as f32;
        while let Some(Reverse((bits, v))) = self.heap.pop() {
            let key = f32::from_bits(bits);
            if self.keys[v as usize].to_bits() != bits || self.head[v as usize] == NONE {
                continue;
            }
            if key * EXPECTED > limit {
                self.heap.clear();
                return false;
            }
            let is_enough = self.left <= task.triangles || self.is_worth_no_more(before, key, task);
            if key > self.error && is_enough {
                return true;
            }
            let most = (key * EXPECTED).max(self.error).min(limit);
            self.try_collapse(v, key, most, task);
        }
        false
    }

    /// Puts a place into the queue, if it can be collapsed at all.
    fn wait(&mut self, v: u32) {
        let key = self.keys[v as usize];
        if key < f32::INFINITY {
            self.heap.push(Reverse((key.to_bits(), v)));
        } else {
            self.blocked[v as usize] = true;
        }
    }

    /// Whether even the target, reached with no larger an error than the next collapse's, would be
    /// worth less than what is there: the share of triangles that goes, over all octaves of distance
    /// from which the rest is drawn.
    fn is_worth_no_more(&self, before: usize, key: f32, task: &Task<'_>) -> bool {
        let gone = |left: usize| (before - left) as f64 / before as f64;
        // In units of half the size.
        let octaves = |error: f32| (-math::log2(f64::from(error))).max(1e-3);
        task.limit == f32::INFINITY
            && self.error > 0.0
            && gone(self.left) > WORTH
            && gone(task.triangles) * octaves(key) < gone(self.left) * octaves(self.error)
    }

    /// The least key of a place: what the best collapse is thought to cost.
    fn least(&mut self, v: u32) -> f32 {
        let Self { ring, .. } = self;
        ring.gather(v, &self.head, &self.next, &self.triangles, &self.place);
        let mut best = f32::INFINITY;
        let q = &self.quadrics[v as usize];
        ring.targets(|n| best = best.min(q.at(self.at[n as usize]).sqrt() as f32));
        best
    }

    /// Collapses a place onto its best neighbour if that keeps within a limit; else notes what it
    /// would take, and lets it wait.
    fn try_collapse(&mut self, v: u32, key: f32, most: f32, task: &Task<'_>) {
        let mut ring = std::mem::take(&mut self.ring);
        ring.gather(v, &self.head, &self.next, &self.triangles, &self.place);
        let mut all = [(0u32, 0u32); 24];
        let mut count = 0;
        let q = &self.quadrics[v as usize];
        ring.targets(|n| {
            if count < all.len() {
                all[count] = ((q.at(self.at[n as usize]).sqrt() as f32).to_bits(), n);
                count += 1;
            }
        });
        let all = &mut all[..count];
        all.sort_unstable();
        let most = match task.shares {
            [] => most,
            shares => {
                let around = ring.around.iter().map(|n| shares[n.place as usize]);
                most.min(task.limit * self.scale as f32 * around.fold(shares[v as usize], f32::min))
            }
        };
        let mut next = f32::INFINITY;
        let (mut done, mut is_blocked) = (false, false);
        for &mut (cost, to) in all {
            let cost = f32::from_bits(cost);
            if cost > key.max(most) {
                next = next.min(cost);
                break;
            }
            if !self.is_sound(&ring, v, to) {
                is_blocked = true;
                continue;
            }
            let mut distance = self.back(&ring, to, most, task);
            if distance <= most {
                distance = distance.max(self.measure(&ring, to, most));
            }
            if distance <= most {
                self.error = self.error.max(distance);
                self.estimate = self.estimate.max(cost);
                self.collapse(&ring, v, to, key);
                done = true;
                break;
            }
            next = next.min(distance / EXPECTED);
        }
        if !done {
            // Never the same again, however it is rounded.
            self.keys[v as usize] = next.max(key.next_up());
            self.blocked[v as usize] = is_blocked;
            self.wait(v);
        }
        self.ring = ring;
    }

    /// Whether a collapse folds nothing over and makes no triangle twice.
    fn is_sound(&mut self, ring: &Ring, v: u32, to: u32) -> bool {
        let Some(_) = ring.wedges(to) else { return false };
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
    fn measure(&mut self, ring: &Ring, to: u32, limit: f32) -> f32 {
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
        let own = self.fan.nearest(self.at[ring.place as usize]).0;
        if own > most {
            return own.sqrt();
        }
        let mut largest = 0.0_f32;
        for corner in &ring.corners {
            let mut next = self.first_point[corner.triangle as usize];
            while let Some(point) = self.points.get(next as usize) {
                let (squared, number) = self.fan.nearest(point.at);
                if squared > most {
                    return squared.sqrt();
                }
                largest = largest.max(squared);
                self.found.push((number, squared.sqrt()));
                next = point.next;
            }
        }
        largest.sqrt()
    }

    /// How far new triangles leave the original, where that is more than the error so far; more than
    /// `most` where it is known to be so. Only points that leave the triangles before by a share of
    /// `most` are looked at.
    fn back(&mut self, ring: &Ring, to: u32, most: f32, task: &Task<'_>) -> f32 {
        let Some(original) = task.original else { return 0.0 };
        let at = |v: u32| self.at[v as usize];
        let own = at(ring.place);
        self.fan.clear();
        ring.corners.iter().for_each(|c| self.fan.push([own, at(c.next), at(c.prev)]));
        let [known, limit] = [self.error, most].map(|far| (f64::from(far) / self.scale) as f32);
        let is_strict = task.limit < f32::INFINITY;
        let skipped = if is_strict { 0.0 } else { (most * NEAR).powi(2) };
        let mut far = 0.0_f32;
        let mut is_far = |p: Vec3| {
            if self.fan.nearest(p).0 <= skipped {
                return false;
            }
            let p = (p.as_dvec3() / self.scale + self.centre).as_vec3().to_array();
            if original.within(p, known).is_none() {
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

    fn collapse(&mut self, ring: &Ring, v: u32, to: u32, key: f32) {
        // Points first, while each triangle still has its own; in the order of `found`.
        let found = std::mem::take(&mut self.found);
        let mut all = Vec::new();
        for corner in &ring.corners {
            let first = &mut self.first_point[corner.triangle as usize];
            let mut next = std::mem::replace(first, NONE);
            while next != NONE {
                all.push(next);
                next = self.points[next as usize].next;
            }
        }
        for (&point, &(number, distance)) in all.iter().zip(&found).rev() {
            let first = &mut self.first_point[self.of_fan[number as usize] as usize];
            let own = &mut self.points[point as usize];
            own.distance = distance;
            own.next = std::mem::replace(first, point);
        }
        self.found = found;
        for corner in &ring.corners {
            let t = corner.triangle as usize;
            if corner.next == to || corner.prev == to {
                self.triangles[t] = [NONE; 3];
                self.left -= 1;
                continue;
            }
            self.triangles[t][corner.corner as usize] = ring.mapped(to, corner.wedge);
            let c = corner.triangle * 3 + u32::from(corner.corner);
            self.next[c as usize] = std::mem::replace(&mut self.head[to as usize], c);
        }
        self.head[v as usize] = NONE;
        let q = self.quadrics[v as usize];
        self.quadrics[to as usize].add(&q);
        for n in 0..=ring.around.len() {
            let v = ring.around.get(n).map_or(to, |near| near.place);
            // What was refused may be possible now.
            if !self.locked[v as usize] && std::mem::take(&mut self.blocked[v as usize]) {
                self.keys[v as usize] = key;
                self.wait(v);
            }
        }
    }
}
