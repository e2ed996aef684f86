//! Outlines split where they cross or touch each other, so that they can be triangulated.

use cullet::exact;

use crate::hash::QuickMap;
use crate::result::CutReport;
use crate::section::{Places, Segment};

/// Crossing points are rounded, which can make new crossings next to them; as many times they are
/// split again.
const ROUNDS: usize = 6;

/// Segments that meet in their ends alone.
pub(crate) struct Arrangement {
    /// How much more the surface winds around the left of each than around its right, from its
    /// lower to its higher place; and whether it divides by the even–odd rule.
    pub(crate) segments: QuickMap<[u32; 2], (i32, bool)>,
    /// The same in the order they were found, so that results do not depend on hashes.
    pub(crate) order: Vec<[u32; 2]>,
    /// Outline segments that were split: the segment, and the places along it, both ends included.
    pub(crate) split: Vec<(Segment, Vec<u32>)>,
}

/// Splits. `None` where the work exceeds the budget of a section of that size.
pub(crate) fn arrange(
    outlines: &[Segment],
    places: &mut Places<'_>,
    report: &mut CutReport,
) -> Option<Arrangement> {
    // The chain of places that each segment has become.
    let mut chains: Vec<Vec<u32>> = outlines.iter().map(|s| vec![s.from, s.to]).collect();
    let mut budget = 256 * outlines.len() + 1_000_000;
    let before = places.points().len();
    let mut settled = false;
    for _ in 0..ROUNDS {
        let mut links: Vec<[u32; 2]> = Vec::new();
        let mut number: QuickMap<[u32; 2], u32> = QuickMap::default();
        for chain in &chains {
            for w in chain.windows(2) {
                let link = [w[0].min(w[1]), w[0].max(w[1])];
                number.entry(link).or_insert_with(|| {
                    links.push(link);
                    links.len() as u32 - 1
                });
            }
        }
        let splits = find_splits(&links, places, &mut budget)?;
        if splits.is_empty() {
            settled = true;
            break;
        }
        for chain in &mut chains {
            let mut longer = vec![chain[0]];
            for w in chain.windows(2) {
                let link = [w[0].min(w[1]), w[0].max(w[1])];
                if let Some(on) = splits.get(&number[&link]) {
                    let forward = w[0] == link[0];
                    let push = |p: &u32| longer.push(*p);
                    if forward { on.iter().for_each(push) } else { on.iter().rev().for_each(push) }
                }
                longer.push(w[1]);
            }
            longer.dedup();
            *chain = longer;
        }
    }
    if !settled {
        return None;
    }
    report.crossings += places.points().len() - before;
    let mut found =
        Arrangement { segments: QuickMap::default(), order: Vec::new(), split: Vec::new() };
    for (segment, chain) in outlines.iter().zip(chains) {
        for w in chain.windows(2) {
            let (link, way) = if w[0] < w[1] { ([w[0], w[1]], 1) } else { ([w[1], w[0]], -1) };
            let entry = found.segments.entry(link).or_insert_with(|| {
                found.order.push(link);
                (0, false)
            });
            entry.0 += way * segment.winding;
            entry.1 ^= segment.flips;
        }
        if chain.len() > 2 {
            found.split.push((*segment, chain));
        }
    }
    Some(found)
}

type Splits = QuickMap<u32, Vec<u32>>;

/// The places at which links must be split, from the lower end to the higher one.
fn find_splits(links: &[[u32; 2]], places: &mut Places<'_>, budget: &mut usize) -> Option<Splits> {
    let grid = Grid::new(links, places, budget)?;
    let mut splits: QuickMap<u32, Vec<u32>> = QuickMap::default();
    let mut add = |link: u32, place: u32| {
        let on = splits.entry(link).or_default();
        if !on.contains(&place) && !links[link as usize].contains(&place) {
            on.push(place);
        }
    };
    for cell in grid.cells.chunk_by(|a, b| a.0 == b.0) {
        *budget = budget.checked_sub(cell.len() * (cell.len() - 1) / 2)?;
        for (i, &(_, s)) in cell.iter().enumerate() {
            for &(_, t) in &cell[i + 1..] {
                let (p, q) = (links[s as usize], links[t as usize]);
                let [a, b] = p.map(|v| places.flat(v));
                let [c, d] = q.map(|v| places.flat(v));
                if !(0..2)
                    .all(|i| a[i].min(b[i]) <= c[i].max(d[i]) && c[i].min(d[i]) <= a[i].max(b[i]))
                {
                    continue;
                }
                let sides = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
                let ends = [(q[0], s, [a, b], c), (q[1], s, [a, b], d)];
                let others = [(p[0], t, [c, d], a), (p[1], t, [c, d], b)];
                for ((place, link, [from, to], point), side) in
                    ends.into_iter().chain(others).zip(sides)
                {
                    if side == 0 && between(from, to, point) {
                        add(link, place);
                    }
                }
                if sides[0] * sides[1] < 0 && sides[2] * sides[3] < 0 {
                    let place = places.add_flat(crossing([a, b], [c, d]));
                    add(s, place);
                    add(t, place);
                }
            }
        }
    }
    splits.retain(|_, on| !on.is_empty());
    for (&link, on) in &mut splits {
        let [from, to] = links[link as usize].map(|p| places.flat(p).map(f64::from));
        let along = |&p: &u32| {
            let p = places.flat(p).map(f64::from);
            (p[0] - from[0]) * (to[0] - from[0]) + (p[1] - from[1]) * (to[1] - from[1])
        };
        on.sort_by(|p, q| along(p).total_cmp(&along(q)).then(p.cmp(q)));
    }
    Some(splits)
}

/// 1 where `p` is left of the line from `a` to `b`, −1 right of it, 0 on it; exact.
pub(crate) fn side(a: [f32; 2], b: [f32; 2], p: [f32; 2]) -> i32 {
    let wide = |v: [f32; 2]| v.map(f64::from);
    let (x, y, z) = (wide(a), wide(b), wide(p));
    let left = (y[0] - x[0]) * (z[1] - x[1]);
    let right = (y[1] - x[1]) * (z[0] - x[0]);
    let value = left - right;
    if value.abs() > (left.abs() + right.abs()) * (4.0 * f64::EPSILON) {
        return if value > 0.0 { 1 } else { -1 };
    }
    exact::area_sign(&[a, b, p].map(|p| [p[0], p[1], 0.0]), 2)
}

/// Whether a point of the line through `a` and `b` lies between them.
fn between(a: [f32; 2], b: [f32; 2], p: [f32; 2]) -> bool {
    p != a && p != b && (0..2).all(|i| a[i].min(b[i]) <= p[i] && p[i] <= a[i].max(b[i]))
}

fn crossing([a, b]: [[f32; 2]; 2], [c, d]: [[f32; 2]; 2]) -> [f32; 2] {
    let [a, b, c, d] = [a, b, c, d].map(|p| p.map(f64::from));
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let w = [c[0] - a[0], c[1] - a[1]];
    let share = (w[0] * v[1] - w[1] * v[0]) / (u[0] * v[1] - u[1] * v[0]);
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
    [0, 1].map(|i| (a[i] + u[i] * share) as f32 + 0.0)
}

/// Links that pass through each cell.
struct Grid {
    cells: Vec<(u32, u32)>,
}

impl Grid {
    fn new(links: &[[u32; 2]], places: &Places<'_>, budget: &mut usize) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in links.iter().flatten().map(|&p| places.flat(p).map(f64::from)) {
            for i in 0..2 {
                low[i] = low[i].min(p[i]);
                high[i] = high[i].max(p[i]);
            }
        }
        // About two links a row and column, for outlines are thin.
        let side = (links.len() as f64).clamp(1.0, 4096.0).floor();
        let longest = (high[0] - low[0]).max(high[1] - low[1]);
        let size = if longest > 0.0 { longest / side } else { 1.0 };
        let cell = |p: [f64; 2]| [0, 1].map(|i| ((p[i] - low[i]) / size).min(side) as i64);
        let mut cells = Vec::with_capacity(links.len() * 3);
        for (number, link) in (0u32..).zip(links) {
            let [mut p, mut q] = link.map(|p| places.flat(p).map(f64::from));
            if p[1] > q[1] {
                (p, q) = (q, p);
            }
            let (first, last) = (cell(p)[1], cell(q)[1]);
            for row in first..=last {
                // Where the link runs within the row, and half a cell more for rounding.
                let mut span = [p[0], q[0]];
                if q[1] > p[1] && first != last {
                    let at = |y: f64| {
                        let share = ((y - p[1]) / (q[1] - p[1])).clamp(0.0, 1.0);
                        p[0] + (q[0] - p[0]) * share
                    };
                    let y = low[1] + row as f64 * size;
                    span = [at(y - 0.01 * size), at(y + 1.01 * size)];
                }
                let (from, to) = (span[0].min(span[1]), span[0].max(span[1]));
                let columns = cell([from - 0.01 * size, 0.0])[0]..=cell([to + 0.01 * size, 0.0])[0];
                for column in columns {
                    *budget = budget.checked_sub(1)?;
                    cells.push(((row * 8192 + column.max(0)) as u32, number));
                }
            }
        }
        cells.sort_unstable();
        Some(Self { cells })
    }
}
