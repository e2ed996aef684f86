//! The outlines at a plane: edges between places, joined where they do not close.

use std::collections::VecDeque;

use crate::hash::{QuickMap, key};
use crate::result::CutReport;
use crate::sides::CutPlane;

/// Steps that looking for the ends of open outlines may take before what is left is given up.
const MOST_STEPS: usize = 50_000_000;
/// Ends of open outlines beyond which none are joined: all pairs are looked at.
const MOST_ENDS: usize = 4096;

/// The distinct points of a section. Vertices at one position, as at a seam, are one place.
pub(crate) struct Places<'a> {
    plane: &'a CutPlane,
    points: Vec<[f32; 3]>,
    by_flat: QuickMap<[u32; 2], u32>,
    by_vertex: QuickMap<u32, u32>,
    moved: Vec<(u32, [f32; 3])>,
    /// Whether the point must stay: a vertex that was there before this plane.
    fixed: Vec<bool>,
    vertices: Vec<Vec<u32>>,
}

impl<'a> Places<'a> {
    pub(crate) fn new(plane: &'a CutPlane) -> Self {
        Self {
            plane,
            points: Vec::new(),
            by_flat: QuickMap::default(),
            by_vertex: QuickMap::default(),
            moved: Vec::new(),
            fixed: Vec::new(),
            vertices: Vec::new(),
        }
    }

    /// The place of a vertex. Points that differ only across the plane, by rounding, become one,
    /// and the vertices that may (those that are not `old`) move there.
    pub(crate) fn add(&mut self, vertex: u32, point: [f32; 3], old: bool) -> u32 {
        if let Some(&place) = self.by_vertex.get(&vertex) {
            return place;
        }
        let flat = key(self.plane.flat(point));
        let next = self.points.len() as u32;
        let place = *self.by_flat.entry(flat).or_insert(next);
        self.by_vertex.insert(vertex, place);
        if place == next {
            self.points.push(point);
            self.fixed.push(old);
            self.vertices.push(if old { Vec::new() } else { vec![vertex] });
            return place;
        }
        let at = place as usize;
        let settled = self.points[at];
        if key(settled) == key(point) {
            self.fixed[at] |= old;
        } else if old && !self.fixed[at] {
            self.fixed[at] = true;
            self.points[at] = point;
            let moved = self.vertices[at].iter().map(|&v| (v, point));
            self.moved.extend(moved);
        } else if !old {
            self.moved.push((vertex, settled));
        }
        if !old {
            self.vertices[at].push(vertex);
        }
        place
    }

    /// The place of a point in the coordinates of the plane, made if there is none.
    pub(crate) fn add_flat(&mut self, flat: [f32; 2]) -> u32 {
        let next = self.points.len() as u32;
        let place = *self.by_flat.entry(key(flat)).or_insert(next);
        if place == next {
            self.points.push(self.plane.lift(flat));
        }
        place
    }

    pub(crate) fn moved(&self) -> &[(u32, [f32; 3])] {
        &self.moved
    }

    pub(crate) fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    pub(crate) fn flat(&self, place: u32) -> [f32; 2] {
        self.plane.flat(self.points[place as usize])
    }
}

/// A segment of an outline from one place to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Segment {
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// How much more the surface winds around its left than around its right.
    pub(crate) winding: i32,
    /// Whether it divides covered from uncovered by the even–odd rule.
    pub(crate) flips: bool,
}

/// Closes what can be closed, leaves out what cannot, and says how each outline is filled.
pub(crate) fn join(
    edges: &[[u32; 2]],
    places: &mut Places<'_>,
    heal: f32,
    report: &mut CutReport,
) -> Vec<Segment> {
    let count = places.points().len();
    let mut net: QuickMap<[u32; 2], i32> = QuickMap::default();
    // In the order of first use, so that the result does not depend on hashes.
    let mut order = Vec::with_capacity(edges.len());
    for &[a, b] in edges.iter().filter(|[a, b]| a != b) {
        let (pair, way) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
        *net.entry(pair).or_insert_with(|| {
            order.push(pair);
            0
        }) += way;
    }
    let mut segments: Vec<([u32; 2], i32)> =
        order.into_iter().map(|pair| (pair, net[&pair])).filter(|s| s.1 != 0).collect();
    report.non_manifold_edges += segments.iter().filter(|s| s.1.abs() > 1).count();
    let mut excess = vec![0i32; count];
    for &([a, b], n) in &segments {
        excess[a as usize] += n;
        excess[b as usize] -= n;
    }
    if excess.iter().any(|e| e % 2 != 0) {
        heal_ends(&mut segments, &mut excess, places, heal, report);
        drop_open(&mut segments, &mut excess, count, report);
    }
    let mut group: Vec<u32> = (0..count as u32).collect();
    for &([a, b], _) in &segments {
        let (a, b) = (find(&mut group, a), find(&mut group, b));
        group[a.max(b) as usize] = a.min(b);
    }
    let mut mixed = vec![false; count];
    for (p, &e) in excess.iter().enumerate().filter(|e| *e.1 != 0) {
        debug_assert_eq!(e % 2, 0, "open outlines were dropped");
        mixed[find(&mut group, p as u32) as usize] = true;
    }
    report.even_odd += mixed.iter().filter(|&&m| m).count();
    let segment = |([a, b], n): ([u32; 2], i32)| {
        let (from, to) = if n > 0 { (a, b) } else { (b, a) };
        if mixed[find(&mut group, a) as usize] {
            Segment { from, to, winding: 0, flips: n % 2 != 0 }
        } else {
            Segment { from, to, winding: n.abs(), flips: false }
        }
    };
    segments.into_iter().map(segment).filter(|s| s.winding != 0 || s.flips).collect()
}

fn find(group: &mut [u32], mut of: u32) -> u32 {
    while group[of as usize] != of {
        group[of as usize] = group[group[of as usize] as usize];
        of = group[of as usize];
    }
    of
}

/// Joins ends that are near each other by straight lines, the nearest first.
fn heal_ends(
    segments: &mut Vec<([u32; 2], i32)>,
    excess: &mut [i32],
    places: &Places<'_>,
    heal: f32,
    report: &mut CutReport,
) {
    let ends: Vec<u32> =
        (0..excess.len() as u32).filter(|&p| excess[p as usize] % 2 != 0).collect();
    if heal.is_nan() || heal <= 0.0 || ends.len() > MOST_ENDS {
        return;
    }
    let point = |p: u32| glam::DVec3::from(places.points()[p as usize].map(f64::from));
    let mut pairs = Vec::new();
    for (i, &a) in ends.iter().enumerate() {
        for &b in &ends[i + 1..] {
            let apart = point(a).distance(point(b));
            if apart <= f64::from(heal) {
                // A start with an end before two of a kind.
                let alike = (excess[a as usize] > 0) == (excess[b as usize] > 0);
                pairs.push((alike, apart, a, b));
            }
        }
    }
    pairs.sort_by(|x, y| {
        x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then(x.2.cmp(&y.2)).then(x.3.cmp(&y.3))
    });
    for (_, _, a, b) in pairs {
        let (of_a, of_b) = (excess[a as usize], excess[b as usize]);
        if of_a % 2 == 0 || of_b % 2 == 0 {
            continue;
        }
        // From where something ends to where something starts.
        let way = if of_b > of_a { 1 } else { -1 };
        segments.push(([a, b], way));
        excess[a as usize] += way;
        excess[b as usize] -= way;
        report.healed += 1;
    }
}

/// Leaves out the shortest ways between ends, so that what is left closes.
fn drop_open(
    segments: &mut Vec<([u32; 2], i32)>,
    excess: &mut [i32],
    count: usize,
    report: &mut CutReport,
) {
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (i, ([a, b], n)) in segments.iter().enumerate() {
        if n % 2 != 0 {
            at[*a as usize].push(i as u32);
            at[*b as usize].push(i as u32);
        }
    }
    let mut steps = 0;
    // The segment by which a search came to a place, and which search that was.
    let mut came = vec![(u32::MAX, u32::MAX); count];
    let mut queue = VecDeque::new();
    for start in 0..count as u32 {
        if excess[start as usize] % 2 == 0 {
            continue;
        }
        queue.clear();
        queue.push_back(start);
        came[start as usize] = (start, u32::MAX);
        let mut end = None;
        'search: while let Some(p) = queue.pop_front() {
            for &s in &at[p as usize] {
                steps += 1;
                let ([a, b], n) = segments[s as usize];
                let q = a ^ b ^ p;
                if n % 2 == 0 || came[q as usize].0 == start {
                    continue;
                }
                came[q as usize] = (start, s);
                if excess[q as usize] % 2 != 0 {
                    end = Some(q);
                    break 'search;
                }
                queue.push_back(q);
            }
        }
        let Some(mut p) = end.filter(|_| steps < MOST_STEPS) else { break };
        report.open_chains += 1;
        while p != start {
            let s = came[p as usize].1;
            let ([a, b], n) = &mut segments[s as usize];
            let way = n.signum();
            *n -= way;
            excess[*a as usize] -= way;
            excess[*b as usize] += way;
            report.open_edges += 1;
            p ^= *a ^ *b;
        }
    }
    if excess.iter().any(|e| e % 2 != 0) {
        // Given up: nothing of the plane is capped.
        report.open_chains += 1;
        report.open_edges += segments.len();
        segments.clear();
        excess.fill(0);
    }
    segments.retain(|s| s.1 != 0);
}
