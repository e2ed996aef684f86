//! The oracle: lines of sight sampled by code of its own, slow and plain, against which sets of
//! cells are held.

use cullet_cells::cell::CellGraph;
use glam::DVec3;

use crate::rows::BitRows;
use crate::threads;
use cullet_draw::Random;

/// A line of sight between two cells of which a set says that they do not see each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissedSight {
    /// The cell that is looked from.
    pub from: u32,
    /// The cell that is seen.
    pub to: u32,
    /// A point of the line.
    pub point: [f64; 3],
    /// Its direction.
    pub direction: [f64; 3],
}

/// Findings of an oracle's lines.
#[derive(Clone, Debug, PartialEq)]
pub struct SightCheck {
    /// How many lines were sampled.
    pub lines: u64,
    /// Pairs of cells, in either order, that they found to see each other.
    pub found: BitRows,
    /// How many of these pairs the sets miss, each counted once for each order.
    pub missed: u64,
    /// The first of them.
    pub first: Vec<MissedSight>,
}

/// Missed pairs that are kept as examples.
const SHOWN: usize = 8;
/// Lines of a job.
const LINES: u64 = 1 << 14;

/// Samples lines of sight and looks each pair of cells along them up in `rows`. A line counts only
/// where it is `margin` inside of each portal that it passes.
///
/// Lines start at random points of random portals, in random directions. Equal for any number of
/// threads.
#[must_use]
pub fn check_sight_ref(
    graph: &CellGraph,
    rows: &BitRows,
    lines: u64,
    seed: u64,
    margin: f64,
    threads: usize,
) -> SightCheck {
    let cells = graph.cell_count();
    let mut check =
        SightCheck { lines: 0, found: BitRows::new(cells, cells), missed: 0, first: Vec::new() };
    if graph.portals().is_empty() {
        return check;
    }
    let jobs = lines.div_ceil(LINES) as usize;
    // In groups, so that what jobs find does not pile up.
    for group in (0..jobs).step_by(16) {
        let job = |_: &mut (), k: usize| {
            let number = (group + k) as u64;
            let count = (lines - number * LINES).min(LINES);
            let mut random = Random::new(seed ^ 0x0b5e_55ed, [number as u32, 77]);
            (
                count,
                (0..count).filter_map(|_| sample(graph, &mut random, margin)).collect::<Vec<_>>(),
            )
        };
        let found = threads::run(threads, (jobs - group).min(16), || (), job, || true);
        for (count, sights) in found.unwrap_or_default() {
            check.lines += count;
            sights.iter().for_each(|sight| note(&mut check, rows, sight));
        }
    }
    check
}

/// A line and the cells along it.
struct Sight {
    point: DVec3,
    direction: DVec3,
    cells: Vec<u32>,
}

fn note(check: &mut SightCheck, rows: &BitRows, sight: &Sight) {
    for &from in &sight.cells {
        for &to in &sight.cells {
            if check.found.has(from, to) {
                continue;
            }
            check.found.set(from, to);
            if !rows.has(from, to) {
                check.missed += 1;
                if check.first.len() < SHOWN {
                    let (point, direction) = (sight.point.into(), sight.direction.into());
                    check.first.push(MissedSight { from, to, point, direction });
                }
            }
        }
    }
}

fn sample(graph: &CellGraph, random: &mut Random, margin: f64) -> Option<Sight> {
    let portal = random.below(graph.portals().len() as u32);
    let polygon = &graph.portals()[portal as usize].polygon;
    // Weights of all corners: any point of the polygon, those near the middle more often.
    let weights: Vec<f64> = polygon.iter().map(|_| random.unit().powi(3)).collect();
    let sum: f64 = weights.iter().sum();
    let point = polygon.iter().zip(&weights).map(|(&v, w)| DVec3::from(v) * (w / sum)).sum();
    let direction = loop {
        let [x, y, z] = random.three().map(|v| v * 2.0 - 1.0);
        let v = DVec3::new(x, y, z);
        // Half of the lines are nearly level, as those are that go far in buildings.
        let v = if random.unit() < 0.5 { v * DVec3::new(1.0, 1.0, 0.1) } else { v };
        if v.length_squared() <= 1.0 && v.length_squared() > 1e-4 {
            break v.normalize();
        }
    };
    if !inside(graph, portal, point, margin) {
        return None;
    }
    let speed = DVec3::from(graph.plane(portal).normal).dot(direction);
    if speed.abs() < 1e-3 {
        return None;
    }
    // The normal points to the first cell.
    let [first, second] = graph.portals()[portal as usize].cells;
    let (ahead, behind) = if speed > 0.0 { (first, second) } else { (second, first) };
    let mut cells = Vec::new();
    walk(graph, portal, behind, point, -direction, margin, &mut cells);
    cells.reverse();
    cells.extend([behind, ahead]);
    walk(graph, portal, ahead, point, direction, margin, &mut cells);
    Some(Sight { point, direction, cells })
}

/// The cells that a line enters after a portal, one after the other.
fn walk(
    graph: &CellGraph,
    mut last: u32,
    mut cell: u32,
    point: DVec3,
    direction: DVec3,
    margin: f64,
    cells: &mut Vec<u32>,
) {
    let mut gone = 0.0;
    while cells.len() < 1000 {
        let mut next: Option<(f64, u32)> = None;
        for &portal in graph.portals_of(cell).iter().filter(|&&portal| portal != last) {
            let plane = graph.plane(portal);
            let normal = DVec3::from(plane.normal);
            let is_first = graph.portals()[portal as usize].cells[0] == cell;
            // Out of the first cell is against the normal.
            let speed = normal.dot(direction) * if is_first { -1.0 } else { 1.0 };
            if speed < 1e-6 {
                continue;
            }
            let t = (plane.d - normal.dot(point)) / normal.dot(direction);
            if t > gone
                && next.is_none_or(|(best, _)| t < best)
                && inside(graph, portal, point + direction * t, margin)
            {
                next = Some((t, portal));
            }
        }
        let Some((t, portal)) = next else { return };
        let [a, b] = graph.portals()[portal as usize].cells;
        cell = if a == cell { b } else { a };
        cells.push(cell);
        (gone, last) = (t, portal);
    }
}

/// Whether a point of a portal's plane is inside all of its edges by a margin.
fn inside(graph: &CellGraph, portal: u32, point: DVec3, margin: f64) -> bool {
    let polygon = &graph.portals()[portal as usize].polygon;
    let normal = DVec3::from(graph.plane(portal).normal);
    (0..polygon.len()).all(|k| {
        let a = DVec3::from(polygon[k]);
        let edge = DVec3::from(polygon[(k + 1) % polygon.len()]) - a;
        let height = normal.cross(edge).dot(point - a);
        edge == DVec3::ZERO || height >= margin * edge.length()
    })
}
