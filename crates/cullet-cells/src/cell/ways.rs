//! How far it is through open portals: what is heard from a place, and how loud.

use alloc::collections::BinaryHeap;
use alloc::vec;
use alloc::vec::Vec;
use core::cmp::{Ordering, Reverse};

use super::graph::CellGraph;
#[cfg(not(feature = "std"))]
use cullet::math::Float as _;

/// A portal that was reached, by the length of the way; the nearest first, and of two as near that
/// of the lower number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arrived {
    length: f64,
    portal: u32,
    /// The cell behind it.
    cell: u32,
}

impl Eq for Arrived {}

impl Ord for Arrived {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_place = (self.portal, self.cell).cmp(&(other.portal, other.cell));
        self.length.total_cmp(&other.length).then(by_place)
    }
}

impl PartialOrd for Arrived {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl CellGraph {
    /// For each cell, how long the way is from a point in `cell` to the portal where it enters
    /// there: 0 for `cell` itself, infinity where none leads there, or all are longer than `limit`.
    /// A way goes through open portals, by the middle of each (of one-way portals as sight does),
    /// so that it is no shorter than the shortest. What is heard in a cell, sound that goes around
    /// corners and not through walls, is what has a short way there, though it may not be seen;
    /// compare [`VisibleSets`](crate::pvs::VisibleSets). O(portals · log portals) of those within
    /// the limit (Dijkstra, 1959).
    ///
    /// # Panics
    /// If there is no such cell.
    #[must_use]
    pub fn ways_from(&self, cell: u32, point: [f64; 3], limit: f64) -> Vec<f64> {
        let mut lengths = vec![f64::INFINITY; self.cell_count() as usize];
        lengths[cell as usize] = 0.0;
        // In which direction a portal was passed, by twice its number.
        let mut passed = vec![false; self.portals().len() * 2];
        let mut queue = BinaryHeap::new();
        let go_on = |from: u32, point: [f64; 3], length: f64, queue: &mut BinaryHeap<_>| {
            for &portal in self.portals_of(from) {
                let Some(cell) = self.beyond(portal, from) else { continue };
                let length = length + distance(point, self.middle(portal));
                if length <= limit {
                    queue.push(Reverse(Arrived { length, portal, cell }));
                }
            }
        };
        go_on(cell, point, 0.0, &mut queue);
        while let Some(Reverse(Arrived { length, portal, cell })) = queue.pop() {
            let is_first = self.portals()[portal as usize].cells[0] == cell;
            if core::mem::replace(&mut passed[portal as usize * 2 + usize::from(is_first)], true) {
                continue;
            }
            let shortest = &mut lengths[cell as usize];
            *shortest = shortest.min(length);
            go_on(cell, self.middle(portal), length, &mut queue);
        }
        lengths
    }

    /// The middle of a portal's corners.
    fn middle(&self, portal: u32) -> [f64; 3] {
        let polygon = &self.portals()[portal as usize].polygon;
        let sum = |a: usize| polygon.iter().map(|corner| corner[a]).sum::<f64>();
        core::array::from_fn(|a| sum(a) / polygon.len() as f64)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Portal;

    /// A ring of four rooms: doors at x = 1, 2, 3 in a row, and a long way round from the last to
    /// the first.
    fn ring() -> CellGraph {
        let door = |cells, x: f64| Portal {
            cells,
            polygon: vec![[x, -1.0, 0.0], [x, -1.0, 2.0], [x, 1.0, 2.0], [x, 1.0, 0.0]],
        };
        let doors = [([0, 1], 1.0), ([1, 2], 2.0), ([2, 3], 3.0), ([3, 0], -9.0)];
        CellGraph::new(5, doors.map(|(cells, x)| door(cells, x)).to_vec()).unwrap()
    }

    #[test]
    fn ways_are_the_shortest_through_open_portals() {
        let mut graph = ring();
        let ways = |graph: &CellGraph, limit| graph.ways_from(0, [0.0, 0.0, 1.0], limit);
        let far = f64::INFINITY;
        assert_eq!(ways(&graph, far), [0.0, 1.0, 2.0, 3.0, far]);
        assert_eq!(ways(&graph, 2.5), [0.0, 1.0, 2.0, far, far]);
        // By the other way round: to the door at -9, and from there to that at 3, through the
        // fourth room.
        graph.set_open(1, false);
        assert_eq!(ways(&graph, far), [0.0, 1.0, 21.0, 9.0, far]);
        graph.set_one_way(3, true);
        assert_eq!(ways(&graph, far), [0.0, 1.0, far, far, far]);
    }

    #[test]
    fn no_way_is_longer_than_any_chain_of_portals() {
        use cullet_testkit::{Rng, cases};
        let mut rng = Rng(21);
        let mut checked = 0;
        for _ in 0..cases(40) {
            let count = 6;
            let portal = |rng: &mut Rng| {
                let cells = [rng.below(count) as u32, rng.below(count) as u32];
                let at = rng.vector(5.0);
                let corner = |y: f64, z: f64| [at[0], at[1] + y, at[2] + z];
                let polygon = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
                (cells[0] != cells[1]).then_some(Portal { cells, polygon })
            };
            let portals = (0..9).filter_map(|_| portal(&mut rng)).collect();
            let mut graph = CellGraph::new(count as u32, portals).unwrap();
            for portal in 0..graph.portals().len() as u32 {
                graph.set_open(portal, rng.chance(0.8));
                graph.set_one_way(portal, rng.chance(0.2));
            }
            let point = rng.vector(5.0);
            let ways = graph.ways_from(0, point, f64::INFINITY);
            // Any walk at random is no shorter.
            for _ in 0..60 {
                let (mut cell, mut at, mut length) = (0, point, 0.0);
                for _ in 0..6 {
                    let around = graph.portals_of(cell);
                    if around.is_empty() {
                        break;
                    }
                    let portal = around[rng.below(around.len() as u64) as usize];
                    let Some(next) = graph.beyond(portal, cell) else { continue };
                    length += distance(at, graph.middle(portal));
                    (cell, at) = (next, graph.middle(portal));
                    assert!(ways[cell as usize] <= length, "{cell}");
                    checked += 1;
                }
            }
        }
        assert!(checked > cases(40) * 50, "{checked}");
    }
}
