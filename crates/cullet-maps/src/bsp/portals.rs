//! Cells and portals of a map, made from its tree as a compiler makes them (Teller and Séquin,
//! *Visibility Preprocessing for Interactive Walkthroughs*, 1991, have cells from a tree; the
//! portals of a node are what its plane has in common with the leafs on its two sides).

use cullet_cells::cell::{CellGraph, Portal};
use glam::DVec3;

use super::map::{Bsp, Contents};
use super::tree::Child;
use cullet_io::ErrorKind;
use cullet_io::reader::{Cut, ON, Winding};

/// How far beyond the map's box portals may reach.
const MARGIN: f64 = 64.0;
/// Portals narrower than this are left out: they are what rounding leaves between neighbours.
const NARROW: f64 = 2.0 * ON;
/// Most cuts, for each node of the tree: of a map they are about ten; of a tree that is made to be
/// slow, no bound but the square of the nodes would hold.
const CUTS: u64 = 1_000;
/// Most portals, for each node of the tree: of a map there are fewer than nodes.
const PORTALS: u64 = 16;

/// Most pieces between two cells on one plane that are tried to be joined: the search takes their
/// square.
const MOST_JOINED: usize = 64;

impl Bsp {
    /// Cells and the portals between them, made from the tree, in the map's axes: the graph of
    /// which visibility is baked, with no `.prt` file. Cells are those of
    /// [`Leaf::cell`](super::Leaf::cell); rock lies between. Sight does not pass between the sky
    /// and what is not sky, for engines draw the sky in front of what is behind it; compilers do
    /// the same. Portals between leafs of one cell vanish, and pieces of one plane between the same
    /// two cells are joined where they are convex together.
    ///
    /// Corners within a hundredth of a unit of a plane count as on it, and portals narrower than a
    /// fiftieth are left out: a slit thinner than that is lost, as it is to compilers (whose
    /// tolerance is a tenth).
    ///
    /// Cost: some hundred cuts of a polygon for each node.
    ///
    /// # Errors
    /// If the map's box is not finite, or the tree is so shaped that cuts exceed 1,000 for each
    /// node, or portals 16 for each node.
    pub fn cells(&self) -> Result<CellGraph, ErrorKind> {
        let world = &self.models[0];
        let [low, high] = world.bounds.map(DVec3::from);
        if !(low.is_finite() && high.is_finite()) {
            let message = format!("its box is {low} to {high}");
            return Err(ErrorKind::invalid("lump models, number 0", message));
        }
        let nodes = self.tree.nodes().len() as u64;
        let mut maker = Maker {
            map: self,
            uniform: self.uniform(world.root),
            limit: CUTS * nodes,
            cuts: 0,
            centre: (low + high) * 0.5,
            half: (high - low).abs() * 0.5 + MARGIN,
            portals: Vec::new(),
        };
        let mut open = vec![world.root];
        while let Some(child) = open.pop() {
            let Child::Node(node) = child else { continue };
            // Nothing is between leafs of one cell.
            if maker.uniform[node as usize].is_some() {
                continue;
            }
            maker.node(node)?;
            let [front, back] = self.tree.nodes()[node as usize].children;
            open.extend([back, front]);
        }
        CellGraph::new(self.cell_count, maker.portals)
            .map_err(|e| ErrorKind::invalid("cells", e.to_string()))
    }

    /// The place that all leafs below a node are part of; of nodes below `root`.
    fn uniform(&self, root: Child) -> Vec<Option<Place>> {
        let mut order = Vec::new();
        let mut open = vec![root];
        while let Some(child) = open.pop() {
            if let Child::Node(node) = child {
                order.push(node);
                open.extend(self.tree.nodes()[node as usize].children);
            }
        }
        let mut uniform = vec![None; self.tree.nodes().len()];
        // Children come after their parents, so from behind.
        for node in order.into_iter().rev() {
            let [front, back] = self.tree.nodes()[node as usize].children.map(|c| match c {
                Child::Node(below) => uniform[below as usize],
                Child::Leaf(leaf) => self.place(leaf),
            });
            uniform[node as usize] = front.filter(|_| front == back);
        }
        uniform
    }

    /// Where a leaf belongs; `None` in rock.
    fn place(&self, leaf: u32) -> Option<Place> {
        let leaf = &self.leafs[leaf as usize];
        let sky = leaf.contents == Contents::Sky;
        leaf.cell.filter(|_| leaf.contents.is_open()).map(|cell| Place { cell, sky })
    }
}

/// A cell, and whether it is in the sky.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Place {
    cell: u32,
    sky: bool,
}

struct Maker<'a> {
    map: &'a Bsp,
    uniform: Vec<Option<Place>>,
    cuts: u64,
    limit: u64,
    centre: DVec3,
    half: DVec3,
    portals: Vec<Portal>,
}

impl Maker<'_> {
    fn count(&mut self) -> Result<(), ErrorKind> {
        self.cuts += 1;
        if self.cuts > self.limit {
            let item = "cuts for portals of the tree".into();
            return Err(ErrorKind::OverLimit { item, count: self.cuts, limit: self.limit });
        }
        Ok(())
    }

    /// Whether there may be portals besides these pieces.
    fn within(&self, pieces: usize) -> Result<(), ErrorKind> {
        let count = (self.portals.len() + pieces) as u64;
        let limit = PORTALS * self.map.tree().nodes().len() as u64;
        if count >= limit {
            let item = "portals of the tree".into();
            return Err(ErrorKind::OverLimit { item, count, limit });
        }
        Ok(())
    }

    /// Portals on the plane of a node.
    fn node(&mut self, node: u32) -> Result<(), ErrorKind> {
        let tree = self.map.tree();
        let plane = *tree.plane(node);
        let [front, back] = tree.nodes()[node as usize].children;
        let Some(whole) = self.whole(node)? else { return Ok(()) };
        let normal = DVec3::from(plane.normal);
        // By the cells before and behind.
        let mut pieces: Vec<([u32; 2], Winding)> = Vec::new();
        for (place, before) in self.reached(front, whole, normal)? {
            for (other, both) in self.reached(back, before, -normal)? {
                if place.cell != other.cell && place.sky == other.sky {
                    self.within(pieces.len())?;
                    pieces.push(([place.cell, other.cell], both));
                }
            }
        }
        pieces.sort_by_key(|(cells, _)| *cells);
        for same in pieces.chunk_by(|a, b| a.0 == b.0) {
            let mut joined: Vec<Winding> = same.iter().map(|(_, w)| w.clone()).collect();
            // Of very many no two are worth the search.
            while joined.len() <= MOST_JOINED
                && let Some((i, j, one)) = pair(&joined, normal)
            {
                self.count()?;
                joined.swap_remove(j);
                joined[i] = one;
            }
            for winding in joined.into_iter().filter(|w| w.width() >= NARROW) {
                let polygon = winding.0.iter().map(DVec3::to_array).collect();
                self.portals.push(Portal { cells: same[0].0, polygon });
            }
        }
        Ok(())
    }

    /// The part of a node's plane within what it cuts and the map's box.
    fn whole(&mut self, node: u32) -> Result<Option<Winding>, ErrorKind> {
        let plane = *self.map.tree().plane(node);
        let reach = self.half.length() + MARGIN;
        let mut whole = Winding::square(&plane, self.centre, reach);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let sides = axes.into_iter().flat_map(|axis| {
            [axis, -axis].map(|n| {
                let d = n.dot(self.centre) + self.half.dot(axis);
                cullet::bounds::Plane::new(n.into(), d)
            })
        });
        let sides: Vec<_> = sides.chain(self.map.tree().planes_of_node(node)).collect();
        for side in sides {
            self.count()?;
            match whole.behind(&side) {
                Some(rest) => whole = rest,
                None => return Ok(None),
            }
        }
        Ok(Some(whole))
    }

    /// The cells below `child` that a polygon on its border touches, and where. `inward` points
    /// from the polygon into what is below.
    fn reached(
        &mut self,
        child: Child,
        winding: Winding,
        inward: DVec3,
    ) -> Result<Vec<(Place, Winding)>, ErrorKind> {
        let mut reached = Vec::new();
        let mut open = vec![(child, winding)];
        while let Some((child, winding)) = open.pop() {
            let node = match child {
                Child::Leaf(leaf) => {
                    reached.extend(self.map.place(leaf).map(|place| (place, winding)));
                    continue;
                }
                Child::Node(node) => node,
            };
            if let Some(place) = self.uniform[node as usize] {
                reached.push((place, winding));
                continue;
            }
            self.count()?;
            let tree = self.map.tree();
            let plane = tree.plane(node);
            let [front, back] = tree.nodes()[node as usize].children;
            match winding.cut(plane) {
                Cut::Front => open.push((front, winding)),
                Cut::Back => open.push((back, winding)),
                // What is below lies on the side to which the polygon's border faces.
                Cut::On if inward.dot(plane.normal.into()) >= 0.0 => open.push((front, winding)),
                Cut::On => open.push((back, winding)),
                Cut::Both(before, behind) => open.extend([(back, behind), (front, before)]),
            }
        }
        Ok(reached)
    }
}

/// Two polygons that are convex together, by their numbers, and as one.
fn pair(windings: &[Winding], normal: DVec3) -> Option<(usize, usize, Winding)> {
    (0..windings.len()).find_map(|i| {
        (i + 1..windings.len())
            .find_map(|j| Some((i, j, windings[i].joined(&windings[j], normal)?)))
    })
}
