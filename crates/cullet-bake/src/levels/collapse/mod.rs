//! Collapses edges while the deviation that it measures stays within a limit.

mod near;
mod quadric;
mod ring;

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

pub fn knob(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

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
    dirty: Vec<bool>,
    order: Vec<(u32, u32)>,
    ring: Ring,
    target_ring: Ring,
    fan: Fan,
    of_fan: Vec<u32>,
    found: Vec<(u32, f32)>,
    centre: DVec3,
    scale: f64,
    left: usize,
    estimate: f32,
    pub(crate) stats: [u64; 4],
    knobs: [f32; 4],
}

/// Result: triangles, with the points that each has.
#[derive(Clone, Debug, Default)]
pub(crate) struct Collapsed {
    pub(crate) indices: Vec<u32>,
    /// Number of the triangle of the input that each was.
    pub(crate) from: Vec<u32>,
    /// The largest estimate by quadrics of any collapse: no bound.
    pub(crate) estimate: f32,
}

impl Collapser {
    pub(crate) fn run(&mut self, task: &Task<'_>) -> Collapsed {
        self.knobs = [knob("BETA", 1.0), knob("REV", 1.0), knob("CUTQ", 1.5), knob("START", 16.0)];
        self.load(task);
        self.passes(task);
        let estimate = (f64::from(self.estimate) / self.scale) as f32;
        let mut out = Collapsed { estimate, ..Collapsed::default() };
        for (t, corners) in (0..).zip(&self.triangles) {
            if corners[0] != NONE {
                out.indices.extend(corners);
                out.from.push(t);
            }
        }
        out
    }

    /// Points of a triangle of the input that is still there, in units of the input.
    pub(crate) fn points_of(&self, t: u32) -> impl Iterator<Item = ([f32; 3], f32)> {
        let mut next = self.first_point[t as usize];
        std::iter::from_fn(move || {
            let point = self.points.get(next as usize)?;
            next = point.next;
            let at = (point.at.as_dvec3() / self.scale + self.centre).as_vec3().to_array();
            Some((at, (f64::from(point.distance) / self.scale) as f32))
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
        self.dirty.clear();
        self.dirty.resize(vertices, true);
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

    fn passes(&mut self, task: &Task<'_>) {
        let scale = self.scale as f32;
        let limit = task.limit * scale;
        let free = task.free * scale;
        let mut last = 0.0_f32;
        loop {
            let over = self.left.saturating_sub(task.triangles);
            self.order.clear();
            for v in 0..self.at.len() as u32 {
                if self.head[v as usize] == NONE || self.locked[v as usize] {
                    continue;
                }
                if std::mem::take(&mut self.dirty[v as usize]) {
                    self.keys[v as usize] = self.least(v);
                }
                let key = self.keys[v as usize];
                if key <= limit {
                    self.order.push((key.to_bits(), v));
                }
            }
            if self.order.is_empty() {
                break;
            }
            self.order.sort_unstable();
            let key = |i: usize| f32::from_bits(self.order[i].0);
            let mut cut = if over > 0 {
                let wanted = if task.triangles == 0 {
                    (last * 2.0).max(limit / self.knobs[3])
                } else {
                    key((over / 2).min(self.order.len() - 1)) * self.knobs[2]
                };
                wanted.max(free).max(last).max(key(0))
            } else {
                free
            };
            cut = cut.min(limit);
            if key(0) > cut {
                break;
            }
            last = cut;
            let before = self.left;
            let order = std::mem::take(&mut self.order);
            for &(key, v) in &order {
                if f32::from_bits(key) > cut || (self.left <= task.triangles && cut > free) {
                    break;
                }
                self.try_collapse(v, cut, (cut * self.knobs[0]).min(limit), task);
            }
            self.order = order;
            if self.left <= task.triangles && cut > free {
                break;
            }
            self.stats[3] += 1;
            if self.left == before && cut >= limit {
                break;
            }
            if self.left == before {
                last *= 1.2;
            }
        }
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
    /// would take.
    fn try_collapse(&mut self, v: u32, cut: f32, most: f32, task: &Task<'_>) {
        self.stats[0] += 1;
        if self.head[v as usize] == NONE {
            return;
        }
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
        let mut key = f32::INFINITY;
        for &mut (cost, to) in all {
            let cost = f32::from_bits(cost);
            if cost > cut {
                key = key.min(cost);
                break;
            }
            if !self.is_sound(&ring, v, to) {
                continue;
            }
            let distance = self.measure(&ring, to, most);
            self.stats[1] += 1;
            if distance <= most && !self.strays(&ring, to, most, task) {
                self.collapse(&ring, v, to);
                self.stats[2] += 1;
                self.estimate = self.estimate.max(cost);
                key = 0.0;
                break;
            }
            key = key.min(distance.max(most * 1.25) / self.knobs[0]);
        }
        self.keys[v as usize] = key;
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
            if before.length_squared() > 0.0 && before.dot(after) <= 0.25 * squares.sqrt() {
                return false;
            }
        }
        self.target_ring.gather(to, &self.head, &self.next, &self.triangles, &self.place);
        // No triangle twice the same way.
        for corner in &ring.corners {
            if corner.next == to || corner.prev == to {
                continue;
            }
            let is_there = |c: &ring::Corner| c.next == corner.next && c.prev == corner.prev;
            if self.target_ring.corners.iter().any(is_there) {
                return false;
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

    /// Whether new triangles leave the original by more than a limit.
    fn strays(&self, ring: &Ring, to: u32, limit: f32, task: &Task<'_>) -> bool {
        let Some(original) = task.original else { return false };
        if self.knobs[1] < 1.0 {
            return false;
        }
        let limit = (f64::from(limit) / self.scale) as f32;
        let at = |v: u32| self.at[v as usize];
        let is_far = |p: Vec3| {
            let p = (p.as_dvec3() / self.scale + self.centre).as_vec3().to_array();
            original.within(p, limit).is_none()
        };
        ring.corners.iter().filter(|c| c.next != to && c.prev != to).any(|c| {
            let (own, a, b) = (at(to), at(c.next), at(c.prev));
            (self.knobs[1] != 2.0 && is_far((own + a + b) / 3.0))
                || (self.knobs[1] >= 3.0 || !ring.is_plain(c.next)) && is_far((own + a) * 0.5)
                || !ring.is_plain(c.prev) && is_far((own + b) * 0.5)
        })
    }

    fn collapse(&mut self, ring: &Ring, v: u32, to: u32) {
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
        self.dirty[to as usize] = true;
        self.target_ring.gather(to, &self.head, &self.next, &self.triangles, &self.place);
        for near in &self.target_ring.around {
            self.dirty[near.place as usize] = true;
        }
    }
}
