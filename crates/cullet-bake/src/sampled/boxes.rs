//! View cells from the boxes that a file has of them.

use cullet_io::baked::Region;
use glam::DVec3;

use super::SampledError;
use super::cells::{Node, ViewCells};

impl ViewCells {
    /// Cells from their [bounds](Self::bounds), in the same order: those of sets that were baked
    /// before. O(n log² n); slow where boxes overlap, which cells of one region never do.
    ///
    /// # Errors
    /// If one is no box, or there is none.
    pub fn of_boxes(boxes: &[Region]) -> Result<Self, SampledError> {
        let mut cells = Self::of_regions(boxes, boxes.len() as u64)?;
        cells.nodes.clear();
        cells.roots.clear();
        let mut groups: Vec<Vec<u32>> = vec![(0..boxes.len() as u32).collect()];
        while let Some(group) = groups.pop() {
            let bounds = cells.around(&group);
            let kept = cells.nodes.len();
            // What is no region, cut without a rest, is taken apart first.
            if cells.fills(&group, &bounds)
                && let Some(root) = cells.grow(group.clone())
            {
                cells.roots.push((bounds, root));
                continue;
            }
            cells.nodes.truncate(kept);
            match cells.cut(&group) {
                Some((_, _, below, above)) => groups.extend([below, above]),
                None => {
                    for cell in group {
                        cells.roots.push((cells.boxes[cell as usize], cells.nodes.len() as u32));
                        cells.nodes.push(Node::Leaf(cell));
                    }
                }
            }
        }
        // The first region that holds a point has it.
        cells.roots.sort_by_key(|&(_, root)| first_leaf(&cells.nodes, root));
        Ok(cells)
    }

    /// The box around some cells.
    fn around(&self, cells: &[u32]) -> [DVec3; 2] {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        cells.iter().fold(none, |[low, high], &cell| {
            let [l, h] = self.boxes[cell as usize];
            [low.min(l), high.max(h)]
        })
    }

    /// Whether cells take as much room as a box around them.
    fn fills(&self, cells: &[u32], [low, high]: &[DVec3; 2]) -> bool {
        let room = |low: DVec3, high: DVec3| (high - low).element_product();
        let taken = cells.iter().map(|&cell| {
            let [low, high] = self.boxes[cell as usize];
            room(low, high)
        });
        let (taken, all) = (taken.sum::<f64>(), room(*low, *high));
        (taken - all).abs() <= all * 1e-9
    }

    /// Makes the nodes of some cells; `None` where no plane parts them.
    fn grow(&mut self, cells: Vec<u32>) -> Option<u32> {
        let root = self.nodes.len();
        self.nodes.push(Node::Leaf(0));
        let mut left = vec![(root, cells)];
        while let Some((node, cells)) = left.pop() {
            if let [cell] = cells[..] {
                self.nodes[node] = Node::Leaf(cell);
                continue;
            }
            let (axis, at, under, over) = self.cut(&cells)?;
            let below = self.nodes.len();
            self.nodes.extend([Node::Leaf(0); 2]);
            let [b, a] = [below as u32, below as u32 + 1];
            self.nodes[node] = Node::Split { axis: axis as u8, at, below: b, above: a };
            left.extend([(below, under), (below + 1, over)]);
        }
        Some(root as u32)
    }

    /// The plane along an axis that parts some cells most evenly and cuts none, and the cells on
    /// both sides of it.
    fn cut(&self, cells: &[u32]) -> Option<(usize, f64, Vec<u32>, Vec<u32>)> {
        let mut best: Option<(usize, usize, f64)> = None;
        for axis in 0..3 {
            let low = |cell: &u32| self.boxes[*cell as usize][0][axis];
            let mut order = cells.to_vec();
            order.sort_by(|a, b| low(a).total_cmp(&low(b)));
            let mut end = f64::NEG_INFINITY;
            for (count, cell) in order.iter().enumerate() {
                let even = count.min(order.len() - count);
                if count > 0 && low(cell) >= end && best.is_none_or(|(most, ..)| even > most) {
                    best = Some((even, axis, low(cell)));
                }
                end = end.max(self.boxes[*cell as usize][1][axis]);
            }
        }
        let (_, axis, at) = best?;
        let (below, above) =
            cells.iter().partition(|&&cell| self.boxes[cell as usize][0][axis] < at);
        Some((axis, at, below, above))
    }
}

/// The lowest number of the cells under a node.
fn first_leaf(nodes: &[Node], node: u32) -> u32 {
    match nodes[node as usize] {
        Node::Leaf(cell) => cell,
        Node::Split { below, above, .. } => first_leaf(nodes, below).min(first_leaf(nodes, above)),
    }
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;

    #[test]
    fn cells_come_back_from_their_boxes() {
        let mut rng = Rng(8);
        for case in 0..40 {
            // The second stands apart, touches the first, or overlaps it.
            let x = [6.0, 4.0, 3.5][case % 3];
            let regions = [[[0.0; 3], [4.0, 1.0, 4.0]], [[x, 0.0, 0.0], [8.0, 2.0, 3.0]]];
            let mut cells = ViewCells::of_regions(&regions, 30).expect("boxes");
            while cells.len() < 30 {
                let cell = rng.index(cells.len() as usize) as u32;
                let axis = rng.index(3);
                let [low, high] = cells.bounds(cell);
                cells.split(cell, axis, low[axis] + (high[axis] - low[axis]) * rng.range(0.2, 0.8));
            }
            let boxes: Vec<Region> = (0..cells.len()).map(|c| cells.bounds(c)).collect();
            let again = ViewCells::of_boxes(&boxes).expect("boxes");
            assert_eq!(again.boxes, cells.boxes);
            // The most even plane may cut through both, but what is left are few regions.
            assert!(case % 3 == 2 || again.roots.len() <= 6, "{}", again.roots.len());
            for _ in 0..500 {
                let point = [rng.range(-1.0, 9.0), rng.range(-1.0, 3.0), rng.range(-1.0, 5.0)];
                let [found, expected] = [&again, &cells].map(|c| c.cell_of(point));
                let holds = |cell: u32| {
                    let [low, high] = cells.bounds(cell);
                    (0..3).all(|a| low[a] <= point[a] && point[a] <= high[a])
                };
                assert_eq!(found.is_some(), expected.is_some(), "{point:?}");
                assert!(found.is_none_or(holds), "{point:?}");
                assert!(case % 3 == 2 || found == expected, "{point:?}");
            }
            let b = cells.boxes[3];
            assert_eq!(again.near(&b, 0.3), cells.near(&b, 0.3));
        }
    }
}
