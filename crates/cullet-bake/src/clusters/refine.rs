//! Better borders between clusters: triangles change to a neighbouring cluster where that pays.

use super::merge::Limits;
use super::surface::PartSurface;
use super::views::{Bits, Views, count};

/// A cluster under change.
#[derive(Clone)]
struct Cell<const W: usize> {
    /// For each view point, how many of the cluster's triangles it sees from the front: a binary
    /// number whose bit k is in plane k, so that a triangle is added to all of them by seven ANDs
    /// and XORs.
    planes: [Bits<W>; 7],
    /// The view points that see none.
    none: Bits<W>,
    /// View points that see exactly one.
    one: Bits<W>,
    /// How many view points see none.
    hits: i64,
    triangles: u32,
    /// Vertices in use come first; each with how many triangles use it.
    vertices: [u32; 64],
    uses: [u8; 64],
    vertex_count: u32,
}

impl<const W: usize> Cell<W> {
    const EMPTY: Self = Self {
        planes: [[0; W]; 7],
        none: [u64::MAX; W],
        one: [0; W],
        hits: W as i64 * 64,
        triangles: 0,
        vertices: [u32::MAX; 64],
        uses: [0; 64],
        vertex_count: 0,
    };

    fn value(&self) -> i64 {
        self.hits * i64::from(self.triangles)
    }

    fn place(&self, vertex: u32) -> Option<usize> {
        // Without an early exit this is a handful of vector comparisons.
        let at = (0..64).fold(64, |at, i| if self.vertices[i] == vertex { i } else { at });
        (at < 64).then_some(at)
    }

    fn add(&mut self, behind: &Bits<W>, corners: [u32; 3]) {
        for i in 0..W {
            let mut carry = !behind[i];
            for plane in &mut self.planes {
                (plane[i], carry) = (plane[i] ^ carry, plane[i] & carry);
            }
        }
        self.triangles += 1;
        for v in corners {
            match self.place(v) {
                Some(at) => self.uses[at] += 1,
                None => {
                    let at = self.vertex_count as usize;
                    (self.vertices[at], self.uses[at]) = (v, 1);
                    self.vertex_count += 1;
                }
            }
        }
        self.settle();
    }

    fn remove(&mut self, behind: &Bits<W>, corners: [u32; 3]) {
        for i in 0..W {
            let mut borrow = !behind[i];
            for plane in &mut self.planes {
                (plane[i], borrow) = (plane[i] ^ borrow, !plane[i] & borrow);
            }
        }
        self.triangles -= 1;
        for v in corners {
            if let Some(at) = self.place(v) {
                self.uses[at] -= 1;
                if self.uses[at] == 0 {
                    let last = self.vertex_count as usize - 1;
                    (self.vertices[at], self.uses[at]) = (self.vertices[last], self.uses[last]);
                    (self.vertices[last], self.uses[last]) = (u32::MAX, 0);
                    self.vertex_count -= 1;
                }
            }
        }
        self.settle();
    }

    fn settle(&mut self) {
        for i in 0..W {
            let more = self.planes[1..].iter().fold(0, |a, p| a | p[i]);
            self.none[i] = !(more | self.planes[0][i]);
            self.one[i] = self.planes[0][i] & !more;
        }
        self.hits = count(&self.none);
    }

    /// Vertices of a triangle that are not here yet.
    fn missing(&self, corners: [u32; 3]) -> u32 {
        let holds = |v: u32| self.vertices.iter().fold(false, |h, w| h | (*w == v));
        corners.iter().map(|&v| u32::from(!holds(v))).sum()
    }

    /// Vertices that only this triangle uses.
    fn sole(&self, corners: [u32; 3]) -> u32 {
        corners.iter().map(|&v| u32::from(self.place(v).is_some_and(|at| self.uses[at] == 1))).sum()
    }
}

/// Weights in the gain of a move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    /// t/r, times the number of view points.
    pub(super) test: i64,
    /// Cost of a vertex of a cluster.
    pub(super) vertex: i64,
}

/// A partition of a surface into clusters, that can be changed triangle by triangle.
pub(super) struct Partition<'a, const W: usize> {
    surface: &'a PartSurface,
    views: &'a Views<W>,
    limits: Limits,
    weights: Weights,
    cells: Vec<Cell<W>>,
    of: Vec<u32>,
}

impl<'a, const W: usize> Partition<'a, W> {
    pub(super) fn new(
        surface: &'a PartSurface,
        views: &'a Views<W>,
        limits: Limits,
        weights: Weights,
        of: Vec<u32>,
        clusters: usize,
    ) -> Self {
        let mut cells = vec![Cell::EMPTY; clusters];
        for (t, &c) in of.iter().enumerate() {
            cells[c as usize].add(&views.behind[t], surface.corners[t]);
        }
        Self { surface, views, limits, weights, cells, of }
    }

    /// The gain of moving a triangle. `None` if a limit forbids it, or if it cannot be more than
    /// `floor`: most moves cost far more than vertices could make up for, which need not be
    /// counted.
    fn gain(&self, t: u32, to: u32, floor: i64) -> Option<i64> {
        let (a, b) = (&self.cells[self.of[t as usize] as usize], &self.cells[to as usize]);
        if b.triangles as usize >= self.limits.triangles {
            return None;
        }
        let behind = &self.views.behind[t as usize];
        let (mut left, mut joined) = (0, 0);
        for i in 0..W {
            left += (a.none[i] | a.one[i] & !behind[i]).count_ones();
            joined += (b.none[i] & behind[i]).count_ones();
        }
        let (na, nb) = (i64::from(a.triangles) - 1, i64::from(b.triangles) + 1);
        let emptied = if na == 0 { self.weights.test } else { 0 };
        let hits = na * i64::from(left) + nb * i64::from(joined) - a.value() - b.value() + emptied;
        if hits + 3 * self.weights.vertex <= floor {
            return None;
        }
        let corners = self.surface.corners[t as usize];
        let missing = b.missing(corners);
        if (b.vertex_count + missing) as usize > self.limits.vertices {
            return None;
        }
        let vertices = i64::from(a.sole(corners)) - i64::from(missing);
        Some(hits + vertices * self.weights.vertex)
    }

    fn apply(&mut self, t: u32, to: u32) {
        let from = self.of[t as usize] as usize;
        let (behind, corners) = (self.views.behind[t as usize], self.surface.corners[t as usize]);
        self.cells[from].remove(&behind, corners);
        self.cells[to as usize].add(&behind, corners);
        self.of[t as usize] = to;
    }

    /// The neighbouring cluster to which a triangle would best move, if that gains more than
    /// `floor`.
    fn best(&self, t: u32, floor: i64) -> Option<(i64, u32)> {
        let own = self.of[t as usize];
        let mut best: Option<(i64, u32)> = None;
        for &u in self.surface.neighbours(t) {
            let c = self.of[u as usize];
            let floor = best.map_or(floor, |b| b.0);
            if c != own
                && let Some(g) = self.gain(t, c, floor)
                && g > floor
            {
                best = Some((g, c));
            }
        }
        best
    }

    /// Moves triangles while a move gains something, at most `sweeps` times over all of them.
    /// Returns the number of moves.
    pub(super) fn descend(&mut self, sweeps: usize) -> usize {
        let mut moves = 0;
        let mut active = vec![true; self.of.len()];
        for _ in 0..sweeps {
            let before = moves;
            for t in 0..self.of.len() as u32 {
                if !std::mem::take(&mut active[t as usize]) {
                    continue;
                }
                if let Some((_, to)) = self.best(t, 0) {
                    self.apply(t, to);
                    moves += 1;
                    for &u in self.surface.neighbours(t) {
                        active[u as usize] = true;
                    }
                }
            }
            if moves == before {
                break;
            }
        }
        moves
    }

    /// Random moves, of which worse ones are made less and less often, after the idea of
    /// Kirkpatrick, Gelatt & Vecchi, *Optimization by Simulated Annealing*, 1983. `heat` is a loss
    /// in triangles that is often accepted at first.
    ///
    /// The chance of a loss x falls as heat / (heat + x), not as an exponential: that needs no
    /// logarithm, whose last bit differs between machines, and does as well. The seed is fixed.
    pub(super) fn anneal(&mut self, heat: f64, sweeps: u32, mut step: impl FnMut(u32) -> bool) {
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        for sweep in 0..sweeps {
            let left = 1.0 - f64::from(sweep) / f64::from(sweeps);
            let heat = heat * left * left * (W * 64) as f64;
            for t in 0..self.of.len() as u32 {
                let near = self.surface.neighbours(t);
                if near.is_empty() {
                    continue;
                }
                let r = random();
                let to = self.of[near[(r % near.len() as u64) as usize] as usize];
                if to == self.of[t as usize] {
                    continue;
                }
                // A share in (0, 1), by bits that the choice hardly used.
                let chance = ((r >> 40) as f64 + 0.5) / (1u64 << 24) as f64;
                let floor = ((heat * (1.0 - 1.0 / chance)) as i64).min(-1);
                if self.gain(t, to, floor).is_some_and(|g| g > floor) {
                    self.apply(t, to);
                }
            }
            if !step(sweep) {
                return;
            }
        }
    }

    /// The gain of adding a triangle to a cluster, whatever it was in before. `None` if a limit
    /// forbids it.
    fn welcome(&self, t: u32, to: u32) -> Option<i64> {
        let (cell, behind) = (&self.cells[to as usize], &self.views.behind[t as usize]);
        let missing = cell.missing(self.surface.corners[t as usize]);
        if cell.triangles as usize >= self.limits.triangles
            || (cell.vertex_count + missing) as usize > self.limits.vertices
        {
            return None;
        }
        let joined: u32 = (0..W).map(|i| (cell.none[i] & behind[i]).count_ones()).sum();
        let hits = i64::from(joined) * i64::from(cell.triangles + 1) - cell.value();
        Some(hits - i64::from(missing) * self.weights.vertex)
    }

    /// The neighbouring cluster that gains most by a triangle of cluster `own`.
    fn host(&self, t: u32, own: u32) -> Option<(i64, u32)> {
        let near = self.surface.neighbours(t).iter().map(|&u| self.of[u as usize]);
        near.filter(|&c| c != own)
            .filter_map(|c| Some((self.welcome(t, c)?, c)))
            .max_by_key(|&(g, c)| (g, std::cmp::Reverse(c)))
    }

    /// Gives away the triangles of clusters, smallest first, where that costs less than the test
    /// that it saves. Returns how many clusters went.
    pub(super) fn dissolve(&mut self) -> usize {
        let mut members = vec![Vec::new(); self.cells.len()];
        for (t, &c) in self.of.iter().enumerate() {
            members[c as usize].push(t as u32);
        }
        let mut order: Vec<u32> = (0..self.cells.len() as u32).collect();
        order.sort_by_key(|&c| (self.cells[c as usize].triangles, c));
        let mut gone = 0;
        let mut log = Vec::new();
        for c in order {
            members[c as usize].retain(|&t| self.of[t as usize] == c);
            let rest = std::mem::take(&mut members[c as usize]);
            if self.scatter(c, &rest, &mut log) {
                gone += 1;
                log.iter().for_each(|&(t, to): &(u32, u32)| members[to as usize].push(t));
            } else {
                members[c as usize] = rest;
            }
        }
        gone
    }

    /// Gives away the triangles of one cluster, if that pays; `log` says to whom.
    fn scatter(&mut self, own: u32, triangles: &[u32], log: &mut Vec<(u32, u32)>) -> bool {
        log.clear();
        if triangles.is_empty() {
            return false;
        }
        let cell = &self.cells[own as usize];
        let freed = i64::from(cell.vertex_count) * self.weights.vertex;
        let mut total = self.weights.test + freed - cell.value();
        let mut rest: Vec<(u32, Option<(i64, u32)>)> =
            triangles.iter().map(|&t| (t, self.host(t, own))).collect();
        // The host gains at most P by a triangle, and P is hardly ever above one half.
        let most = W as i64 * 32;
        let pays = loop {
            if rest.is_empty() {
                break total > 0;
            }
            let best = rest.iter().enumerate().filter_map(|(i, r)| Some((r.1?, i)));
            let best = best.max_by_key(|((g, _), i)| (*g, std::cmp::Reverse(*i)));
            let Some(((g, to), i)) = best else { break false };
            total += g;
            if total + most * (rest.len() as i64 - 1) < 0 {
                break false;
            }
            let (t, _) = rest.swap_remove(i);
            let (behind, corners) =
                (self.views.behind[t as usize], self.surface.corners[t as usize]);
            self.cells[to as usize].add(&behind, corners);
            self.of[t as usize] = to;
            log.push((t, to));
            let near = self.surface.neighbours(t);
            for r in &mut rest {
                if r.1.is_some_and(|h| h.1 == to) || near.contains(&r.0) {
                    r.1 = self.host(r.0, own);
                }
            }
        };
        if pays {
            self.cells[own as usize] = Cell::EMPTY;
        } else {
            for &(t, to) in log.iter() {
                let behind = self.views.behind[t as usize];
                self.cells[to as usize].remove(&behind, self.surface.corners[t as usize]);
                self.of[t as usize] = own;
            }
        }
        pays
    }

    /// The cluster of each triangle, numbered without gaps, and their number.
    pub(super) fn finish(self) -> (Vec<u32>, usize) {
        let mut number = vec![u32::MAX; self.cells.len()];
        let mut used = 0;
        for (c, cell) in self.cells.iter().enumerate() {
            if cell.triangles > 0 {
                number[c] = used;
                used += 1;
            }
        }
        (self.of.iter().map(|&c| number[c as usize]).collect(), used as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::super::merge::tests::sheet;
    use super::*;

    /// Counts of a cluster, from its triangles alone.
    fn count_ref(
        surface: &PartSurface,
        views: &Views<4>,
        triangles: &[u32],
    ) -> (Bits<4>, Bits<4>, usize) {
        let (mut none, mut one) = ([0; 4], [0; 4]);
        for i in 0..256 {
            let seen = |t: &&u32| views.behind[**t as usize][i / 64] >> (i % 64) & 1 == 0;
            match triangles.iter().filter(seen).count() {
                0 => none[i / 64] |= 1 << (i % 64),
                1 => one[i / 64] |= 1 << (i % 64),
                _ => {}
            }
        }
        let mut v: Vec<u32> = triangles.iter().flat_map(|&t| surface.corners[t as usize]).collect();
        v.sort_unstable();
        v.dedup();
        (none, one, v.len())
    }

    fn check(p: &Partition<'_, 4>) {
        for (c, cell) in p.cells.iter().enumerate() {
            let all = 0..p.of.len() as u32;
            let own: Vec<u32> = all.filter(|&t| p.of[t as usize] as usize == c).collect();
            let (none, one, vertices) = count_ref(p.surface, p.views, &own);
            assert_eq!((cell.none, cell.one), (none, one), "cluster {c}");
            assert_eq!(
                (cell.triangles as usize, cell.vertex_count as usize),
                (own.len(), vertices)
            );
            assert!(own.len() <= p.limits.triangles && vertices <= p.limits.vertices);
        }
    }

    /// The cost that moves are to lower, in units of triangles × view points.
    fn cost(p: &Partition<'_, 4>) -> i64 {
        let used = p.cells.iter().filter(|c| c.triangles > 0);
        used.map(|c| p.weights.test + i64::from(c.vertex_count) * p.weights.vertex - c.value())
            .sum()
    }

    #[test]
    fn every_step_keeps_the_counts_and_lowers_the_cost_by_what_it_says() {
        let (_, surface, views) = sheet(16);
        let limits = Limits { vertices: 40, triangles: 50 };
        let weights = Weights { test: 16 * 256, vertex: 30 };
        let of: Vec<u32> = (0..surface.len() as u32).map(|t| t / 20).collect();
        let clusters = surface.len().div_ceil(20);
        let mut p = Partition::new(&surface, &views, limits, weights, of, clusters);
        check(&p);
        let mut moves = 0;
        for t in 0..surface.len() as u32 {
            if let Some((gain, to)) = p.best(t, i64::MIN) {
                let before = cost(&p);
                p.apply(t, to);
                assert_eq!(before - cost(&p), gain, "triangle {t} to {to}");
                moves += 1;
            }
        }
        assert!(moves > 50, "{moves} moves");
        check(&p);
        let before = cost(&p);
        assert!(p.descend(20) > 0);
        check(&p);
        let descended = cost(&p);
        assert!(descended < before);
        assert!(p.dissolve() > 0);
        check(&p);
        assert!(cost(&p) < descended);
        p.anneal(0.5, 5, |_| true);
        check(&p);
        let (of, clusters) = p.finish();
        let mut used = vec![false; clusters];
        of.iter().for_each(|&c| used[c as usize] = true);
        assert!(used.iter().all(|u| *u));
    }
}
