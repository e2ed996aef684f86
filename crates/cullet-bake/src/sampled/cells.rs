//! View cells: boxes that an eye may be in.

use cullet_io::baked::Region;
use glam::DVec3;

use super::SampledError;
use super::crossing::through_box;

/// Boxes that an eye may be in, none of which overlap within a region.
///
/// Each region given is cut by planes along the axes until there are as many cells as were asked
/// for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewCells {
    pub(super) boxes: Vec<[DVec3; 2]>,
    pub(super) nodes: Vec<Node>,
    /// Regions, with their node.
    pub(super) roots: Vec<([DVec3; 2], u32)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Node {
    Leaf(u32),
    Split { axis: u8, at: f64, below: u32, above: u32 },
}

/// The part of a line that lies in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stay {
    pub(super) cell: u32,
    pub(super) enter: f64,
    pub(super) leave: f64,
}

/// Most cells that can be made.
const LIMIT: u32 = 1 << 24;

impl ViewCells {
    /// Equal cells, so many along each axis of a region.
    ///
    /// # Errors
    /// If the region is no box, or there are too many cells or none.
    pub fn grid(region: Region, counts: [u32; 3]) -> Result<Self, SampledError> {
        let cells = counts.iter().map(|&n| u64::from(n)).product::<u64>();
        let mut new = Self::of_regions(&[region], cells)?;
        let mut counts_of = vec![counts];
        let mut at = 0;
        while at < new.boxes.len() {
            let counts = counts_of[at];
            let Some(axis) = (0..3).find(|&a| counts[a] > 1) else {
                at += 1;
                continue;
            };
            let below = counts[axis] / 2;
            let [low, high] = [0, 1].map(|k| new.boxes[at][k][axis]);
            let share = f64::from(below) / f64::from(counts[axis]);
            new.split(at as u32, axis, low + (high - low) * share);
            counts_of[at][axis] = below;
            let mut above = counts;
            above[axis] -= below;
            counts_of.push(above);
        }
        Ok(new)
    }

    /// A cell for each region.
    pub(super) fn of_regions(regions: &[Region], cells: u64) -> Result<Self, SampledError> {
        for (number, &[low, high]) in regions.iter().enumerate() {
            let is_box = (0..3).all(|a| low[a] < high[a] && (high[a] - low[a]).is_finite());
            if !is_box {
                return Err(SampledError::Region { region: number, low, high });
            }
        }
        if cells < regions.len().max(1) as u64 || cells > u64::from(LIMIT) || regions.is_empty() {
            return Err(SampledError::Cells { cells, limit: LIMIT });
        }
        let boxes: Vec<[DVec3; 2]> = regions.iter().map(|r| r.map(DVec3::from)).collect();
        let nodes = (0..boxes.len() as u32).map(Node::Leaf).collect();
        let roots = boxes.iter().zip(0..).map(|(b, n)| (*b, n)).collect();
        Ok(Self { boxes, nodes, roots })
    }

    /// Cuts a cell in two at a place along an axis; the upper one gets the next number.
    pub(super) fn split(&mut self, cell: u32, axis: usize, at: f64) {
        let new = self.boxes.len() as u32;
        let mut above = self.boxes[cell as usize];
        above[0][axis] = at;
        self.boxes[cell as usize][1][axis] = at;
        self.boxes.push(above);
        let is_leaf = |n: &Node| *n == Node::Leaf(cell);
        let middle = |b: &[DVec3; 2]| (b[0] + b[1]) * 0.5;
        // The node is found from its root, by the cell's own middle.
        let inside = middle(&self.boxes[cell as usize]);
        let Some(node) = self.roots.iter().find_map(|&(_, root)| {
            let node = self.descend(root, inside);
            is_leaf(&self.nodes[node as usize]).then_some(node)
        }) else {
            return;
        };
        let below = self.nodes.len() as u32;
        self.nodes.extend([Node::Leaf(cell), Node::Leaf(new)]);
        self.nodes[node as usize] = Node::Split { axis: axis as u8, at, below, above: below + 1 };
    }

    /// The leaf that a point of a region is in.
    fn descend(&self, mut node: u32, point: DVec3) -> u32 {
        while let Node::Split { axis, at, below, above } = self.nodes[node as usize] {
            node = if point[axis as usize] < at { below } else { above };
        }
        node
    }

    /// How many cells there are.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.boxes.len() as u32
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Low and high ends of a cell. The number must be one.
    #[must_use]
    pub fn bounds(&self, cell: u32) -> Region {
        self.boxes[cell as usize].map(Into::into)
    }

    /// The cell that a point is in, border included; of the first region that holds it. `None`
    /// outside, and for a NaN.
    #[must_use]
    pub fn cell_of(&self, point: [f64; 3]) -> Option<u32> {
        let point = DVec3::from(point);
        let (_, root) =
            self.roots.iter().find(|(b, _)| b[0].cmple(point).all() && point.cmple(b[1]).all())?;
        match self.nodes[self.descend(*root, point) as usize] {
            Node::Leaf(cell) => Some(cell),
            Node::Split { .. } => None,
        }
    }

    pub(super) fn boxes(&self) -> &[[DVec3; 2]] {
        &self.boxes
    }

    /// The cells that a line from a point along a direction passes between two distances, and
    /// where.
    pub(super) fn along(
        &self,
        from: DVec3,
        direction: DVec3,
        range: [f64; 2],
        out: &mut Vec<Stay>,
    ) {
        out.clear();
        let mut stack = [(0, 0.0, 0.0); 64];
        for &(bounds, root) in &self.roots {
            let [enter, leave] = through_box(&bounds, from, direction);
            let (enter, leave) = (enter.max(range[0]), leave.min(range[1]));
            // Neither end is a NaN.
            if enter >= leave {
                continue;
            }
            let mut depth = 1;
            stack[0] = (root, enter, leave);
            while depth > 0 {
                depth -= 1;
                let (mut node, mut enter, mut leave) = stack[depth];
                let cell = loop {
                    let (axis, at, below, above) = match self.nodes[node as usize] {
                        Node::Leaf(cell) => break cell,
                        Node::Split { axis, at, below, above } => (axis as usize, at, below, above),
                    };
                    let speed = direction[axis];
                    let cut = (at - from[axis]) / speed;
                    let (first, second) = if speed > 0.0 || speed == 0.0 && from[axis] < at {
                        (below, above)
                    } else {
                        (above, below)
                    };
                    // Never both where it runs along the plane: 0 / 0 is NaN, all else infinite.
                    if speed == 0.0 || cut.is_nan() || cut >= leave {
                        node = first;
                    } else if cut <= enter {
                        node = second;
                    } else {
                        if depth < stack.len() {
                            stack[depth] = (second, cut, leave);
                            depth += 1;
                        }
                        (node, leave) = (first, cut);
                    }
                    enter = enter.min(leave);
                };
                out.push(Stay { cell, enter, leave });
            }
        }
    }

    /// The cells whose boxes come within a distance of a box, ascending.
    pub(super) fn near(&self, bounds: &[DVec3; 2], distance: f64) -> Vec<u32> {
        let within = |low: DVec3, high: DVec3| {
            let apart = (bounds[0] - high).max(low - bounds[1]).max(DVec3::ZERO);
            apart.length_squared() <= distance * distance
        };
        let mut found = Vec::new();
        let mut stack: Vec<(u32, [DVec3; 2])> = self.roots.iter().map(|&(b, n)| (n, b)).collect();
        while let Some((node, b)) = stack.pop() {
            if !within(b[0], b[1]) {
                continue;
            }
            match self.nodes[node as usize] {
                Node::Leaf(cell) => found.push(cell),
                Node::Split { axis, at, below, above } => {
                    let (mut low, mut high) = (b, b);
                    low[1][axis as usize] = at;
                    high[0][axis as usize] = at;
                    stack.extend([(below, low), (above, high)]);
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;

    fn some_cells(rng: &mut Rng) -> ViewCells {
        let regions = [[[0.0; 3], [4.0, 1.0, 4.0]], [[6.0, 0.0, 0.0], [8.0, 2.0, 3.0]]];
        let mut cells = ViewCells::of_regions(&regions, 40).expect("boxes");
        while cells.len() < 40 {
            let cell = rng.index(cells.len() as usize) as u32;
            let axis = rng.index(3);
            let [low, high] = cells.bounds(cell);
            let share = rng.range(0.2, 0.8);
            cells.split(cell, axis, low[axis] + (high[axis] - low[axis]) * share);
        }
        cells
    }

    #[test]
    fn every_point_of_a_region_is_in_the_cell_that_holds_it() {
        let mut rng = Rng(3);
        let cells = some_cells(&mut rng);
        for _ in 0..2000 {
            let point = [rng.range(-1.0, 9.0), rng.range(-1.0, 3.0), rng.range(-1.0, 5.0)];
            let holds = |c: u32| {
                let [low, high] = cells.bounds(c);
                (0..3).all(|a| low[a] <= point[a] && point[a] <= high[a])
            };
            let holding: Vec<u32> = (0..cells.len()).filter(|&c| holds(c)).collect();
            assert_eq!(cells.cell_of(point), holding.first().copied(), "{point:?}");
        }
        assert_eq!(cells.cell_of([f64::NAN, 0.5, 0.5]), None);
    }

    #[test]
    fn a_line_passes_the_cells_that_its_points_are_in() {
        let mut rng = Rng(4);
        let cells = some_cells(&mut rng);
        let mut found = Vec::new();
        for round in 0..500 {
            let from = DVec3::new(rng.range(-2.0, 9.0), rng.range(0.0, 1.0), rng.range(0.0, 4.0));
            let mut direction = DVec3::from(rng.direction());
            if round % 5 == 0 {
                direction = [DVec3::X, DVec3::NEG_Y, DVec3::Z][round % 3];
            }
            cells.along(from, direction, [-1.0, 7.0], &mut found);
            for k in 0..200 {
                let t = -1.0 + 8.0 * (f64::from(k) + 0.37) / 200.0;
                let here = cells.cell_of((from + direction * t).into());
                let near_border =
                    |s: &Stay| (s.enter - t).abs() < 1e-9 || (s.leave - t).abs() < 1e-9;
                let stays: Vec<&Stay> =
                    found.iter().filter(|s| s.enter <= t && t <= s.leave).collect();
                assert!(
                    stays.iter().any(|s| near_border(s))
                        || stays.first().map(|s| s.cell) == here && stays.len() < 2,
                    "{from} {direction} at {t}: {stays:?} {here:?}"
                );
            }
        }
    }

    #[test]
    fn a_grid_has_equal_cells() {
        let cells = ViewCells::grid([[0.0; 3], [3.0, 2.0, 10.0]], [3, 1, 5]).expect("a box");
        assert_eq!(cells.len(), 15);
        for c in 0..15 {
            let [low, high] = cells.bounds(c);
            let size: Vec<f64> = (0..3).map(|a| high[a] - low[a]).collect();
            assert!((size[0] - 1.0).abs() < 1e-9 && size[1] == 2.0 && (size[2] - 2.0).abs() < 1e-9);
        }
        let b = cells.boxes()[7];
        let by_loop: Vec<u32> = (0..15)
            .filter(|&c| {
                let o = cells.boxes()[c as usize];
                (b[0] - o[1]).max(o[0] - b[1]).max(DVec3::ZERO).length() <= 0.5
            })
            .collect();
        assert_eq!(cells.near(&b, 0.5), by_loop);
    }

    #[test]
    fn regions_and_counts_that_make_no_cells_are_refused() {
        let refused =
            |region| matches!(ViewCells::grid(region, [1; 3]), Err(SampledError::Region { .. }));
        assert!(refused([[0.0; 3], [1.0, 0.0, 1.0]]));
        assert!(refused([[0.0; 3], [1.0, f64::NAN, 1.0]]));
        assert!(refused([[0.0; 3], [1.0, f64::INFINITY, 1.0]]));
        let cells = |n| ViewCells::grid([[0.0; 3], [1.0; 3]], [n; 3]);
        assert!(matches!(cells(0), Err(SampledError::Cells { .. })));
        assert!(matches!(cells(1000), Err(SampledError::Cells { .. })));
    }
}
