//! Collapses edges while the deviation that it measures stays within a limit.

mod checks;
mod near;
mod points;
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
pub(crate) use points::Points;
use quadric::Quadric;
use ring::Ring;

const NONE: u32 = u32::MAX;

/// Input of a simplification.
pub(crate) struct Task<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    /// For each vertex the first at its position.
    pub(crate) place: &'a [u32],
    pub(crate) indices: &'a [u32],
    /// Whether a place stays, by its first vertex; empty where none has to.
    pub(crate) locks: &'a [bool],
    /// For each place the share of the limit that collapses next to it may use; empty for all of it.
    pub(crate) shares: &'a [f32],
    /// Points of the original that the triangles carry.
    pub(crate) carried: &'a Points,
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

/// A point of the original.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: Vec3,
    /// Where it is in the input.
    given: [f32; 3],
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
    own: (u32, f32),
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

    /// Points of a triangle of the input that is still there, and how far they are off: those that were
    /// given, and the places that were collapsed.
    pub(crate) fn points_of(&self, t: u32) -> impl Iterator<Item = ([f32; 3], f32)> {
        let mut next = self.first_point[t as usize];
        std::iter::from_fn(move || {
            let point = self.points.get(next as usize)?;
            next = point.next;
            Some((point.given, (f64::from(point.distance) / self.scale) as f32))
        })
    }

    fn load(&mut self, task: &Task<'_>) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in task.indices {
            let p = DVec3::from_array(task.positions[v as usize].map(f64::from));
            (low, high) = (low.min(p), high.max(p));
        }
        let half = ((high - low) * 0.5).max_element();
        self.scale = if half > 0.0 { math::exp2(-math::log2(half).ceil()) } else { 1.0 };
        self.centre = if half >= 0.0 { (low + high) * 0.5 } else { DVec3::ZERO };
        let (centre, scale) = (self.centre, self.scale);
        let bring =
            |p: &[f32; 3]| ((DVec3::from_array(p.map(f64::from)) - centre) * scale).as_vec3();
        self.at.clear();
        self.at.extend(task.positions.iter().map(bring));
        self.place.clear();
        self.place.extend(task.place);
        let vertices = task.positions.len();
        self.locked.clear();
        self.locked.extend(task.locks);
        self.locked.resize(vertices, false);
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
        // A triangle with two corners in one place, as meshes that deform may have, is no side of an
        // edge there.
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.place[v as usize]);
            for p in [(a, b), (b, c), (c, a)].into_iter().filter(|p| p.0 == p.1) {
                self.locked[p.0 as usize] = true;
            }
        }
        self.points.clear();
        self.first_point.clear();
        let mut at = 0;
        for &count in &task.carried.counts {
            let end = at + count as usize;
            self.first_point.push(if count > 0 { at as u32 } else { NONE });
            for i in at..end {
                let next = if i + 1 < end { i as u32 + 1 } else { NONE };
                let distance = (f64::from(task.carried.distances[i]) * scale) as f32;
                let given = task.carried.points[i];
                self.points.push(Point { at: bring(&given), given, distance, next });
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
        let is_measured = task.original.is_some();
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
            // The way back last: it searches all of the original.
            let measured = self.measure(&ring, to, if is_measured { most } else { f32::MAX });
            let counts = is_measured || measured == f32::INFINITY;
            let mut distance = if counts { measured } else { 0.0 };
            if distance <= most {
                distance = distance.max(self.back(&ring, to, most, task));
            }
            if distance <= most {
                self.error = self.error.max(distance);
                self.estimate = self.estimate.max(cost);
                self.collapse(&ring, v, to, key, task);
                done = true;
                break;
            }
            next = next.min(distance / EXPECTED);
        }
        if !done {
            // What may use less than others waits for its neighbours to change.
            self.keys[v as usize] = if next > key { next } else { f32::INFINITY };
            self.blocked[v as usize] = is_blocked;
            self.wait(v);
        }
        self.ring = ring;
    }

    /// Collapses a place onto another, as it was measured last.
    fn collapse(&mut self, ring: &Ring, v: u32, to: u32, key: f32, task: &Task<'_>) {
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
        // The place itself goes on as a point, if it is none yet.
        let at = self.at[v as usize];
        if all.iter().all(|&p| self.points[p as usize].at != at) {
            let (number, distance) = self.own;
            let first = &mut self.first_point[self.of_fan[number as usize] as usize];
            let next = std::mem::replace(first, self.points.len() as u32);
            let given = task.positions[v as usize];
            self.points.push(Point { at, given, distance, next });
        }
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
