//! The tree of planes that cuts a map into leafs.

use cullet::bounds::Plane;

use super::lumps::{Records, float, invalid};
use cullet_io::ErrorKind;

/// Child of a node on one side of its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Child {
    /// Another node.
    Node(u32),
    /// A leaf.
    Leaf(u32),
}

impl Child {
    /// Decodes a child as maps write it: a node from 0, or a leaf as −1 − leaf.
    pub(crate) fn of(number: i64) -> Self {
        if number >= 0 { Self::Node(number as u32) } else { Self::Leaf((-1 - number) as u32) }
    }
}

/// A plane that cuts a region in two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Number of the plane.
    pub plane: u32,
    /// Children on the side to which the plane's normal points, and on the other.
    pub children: [Child; 2],
}

const NONE: u32 = u32::MAX;

/// The nodes of a map: one tree for the world, and in Quake one for each brush model.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    planes: Vec<Plane>,
    nodes: Vec<Node>,
    /// The node above each, or [`NONE`].
    parents: Vec<u32>,
    /// The node above each leaf, or [`NONE`]. The solid leaf 0 of Quake, which is below many, has
    /// any of them.
    above_leafs: Vec<u32>,
}

impl Tree {
    /// Checks that all that is named is there, that no node is below two others, and that each root
    /// is below none: then what is below a root is a tree.
    pub(crate) fn new(
        planes: Vec<Plane>,
        nodes: Vec<Node>,
        leafs: usize,
        roots: &[Child],
    ) -> Result<Self, ErrorKind> {
        let mut parents = vec![NONE; nodes.len()];
        let mut above_leafs = vec![NONE; leafs];
        for (number, node) in nodes.iter().enumerate() {
            let at = |message: String| invalid("nodes", number, message);
            if node.plane as usize >= planes.len() {
                let message = format!("it names plane {}, of {}", node.plane, planes.len());
                return Err(at(message));
            }
            for child in node.children {
                check(child, nodes.len(), leafs).map_err(at)?;
                match child {
                    Child::Leaf(leaf) => above_leafs[leaf as usize] = number as u32,
                    Child::Node(below) => {
                        let parent = &mut parents[below as usize];
                        if *parent != NONE {
                            let message =
                                format!("node {below} is below it, but also below node {parent}");
                            return Err(at(message));
                        }
                        *parent = number as u32;
                    }
                }
            }
        }
        // Whoever is not below a node that is below none goes round in a loop.
        let mut open: Vec<u32> =
            (0..nodes.len() as u32).filter(|n| parents[*n as usize] == NONE).collect();
        let mut reached = vec![false; nodes.len()];
        while let Some(node) = open.pop() {
            reached[node as usize] = true;
            let below = nodes[node as usize].children.iter();
            open.extend(below.filter_map(|c| if let Child::Node(n) = c { Some(*n) } else { None }));
        }
        if let Some(number) = reached.iter().position(|r| !r) {
            return Err(invalid("nodes", number, "it is below itself"));
        }
        for (model, root) in roots.iter().enumerate() {
            let at = |message: String| invalid("models", model, message);
            check(*root, nodes.len(), leafs).map_err(at)?;
            if let Child::Node(node) = *root
                && parents[node as usize] != NONE
            {
                let message = format!(
                    "its tree begins at node {node}, which is below {}",
                    parents[node as usize]
                );
                return Err(at(message));
            }
        }
        Ok(Self { planes, nodes, parents, above_leafs })
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The plane of a node, its normal of unit length.
    ///
    /// # Panics
    /// If there is no such node.
    #[must_use]
    pub fn plane(&self, node: u32) -> &Plane {
        &self.planes[self.nodes[node as usize].plane as usize]
    }

    /// The leaf of a point below `root`; a point on a plane is in front of it. A coordinate that is
    /// not a number is behind every plane. Cost: the depth of the tree.
    #[must_use]
    pub fn leaf_at(&self, root: Child, point: [f64; 3]) -> u32 {
        let mut at = root;
        loop {
            match at {
                Child::Leaf(leaf) => return leaf,
                Child::Node(node) => {
                    let front = self.plane(node).distance(point) >= 0.0;
                    at = self.nodes[node as usize].children[usize::from(!front)];
                }
            }
        }
    }

    /// Half-spaces whose intersection is a leaf, planes pointing out, from the leaf up to the root;
    /// some may touch it nowhere. Empty for a leaf that is below no node. Of Quake's leaf 0, which
    /// all solid space shares, they are those of one of its pieces.
    #[must_use]
    pub fn planes_of_leaf(&self, leaf: u32) -> Vec<Plane> {
        let above = self.above_leafs.get(leaf as usize).copied().unwrap_or(NONE);
        self.planes_above(Child::Leaf(leaf), above)
    }

    /// Half-spaces whose intersection is what a node cuts, as
    /// [`planes_of_leaf`](Self::planes_of_leaf) has them.
    pub(crate) fn planes_of_node(&self, node: u32) -> Vec<Plane> {
        self.planes_above(Child::Node(node), self.parents[node as usize])
    }

    fn planes_above(&self, mut below: Child, mut above: u32) -> Vec<Plane> {
        let mut planes = Vec::new();
        while above != NONE {
            let plane = *self.plane(above);
            let front = self.nodes[above as usize].children[0] == below;
            planes.push(if front { opposite(&plane) } else { plane });
            below = Child::Node(above);
            above = self.parents[above as usize];
        }
        planes
    }
}

/// The same plane, its normal the other way.
pub(crate) fn opposite(plane: &Plane) -> Plane {
    Plane::new(plane.normal.map(|v| -v), -plane.d)
}

fn check(child: Child, nodes: usize, leafs: usize) -> Result<(), String> {
    match child {
        Child::Node(node) if node as usize >= nodes => {
            Err(format!("it names node {node}, of {nodes}"))
        }
        Child::Leaf(leaf) if leaf as usize >= leafs => {
            Err(format!("it names leaf {leaf}, of {leafs}"))
        }
        _ => Ok(()),
    }
}

/// Reads planes: records that begin with a normal and an offset. Normals are made of unit length in
/// f64, for maps have them in f32.
pub(crate) fn planes(records: Records<'_>) -> Result<Vec<Plane>, ErrorKind> {
    let plane = |(number, record): (usize, &[u8])| {
        let [x, y, z, d] = [0, 4, 8, 12].map(|at| f64::from(float(record, at)));
        Plane::new([x, y, z], d).normalized().ok_or_else(|| {
            records.invalid(number, format!("its normal {x}, {y}, {z} or offset {d} is none"))
        })
    };
    records.iter().enumerate().map(plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(x: f64) -> Plane {
        Plane::new([1.0, 0.0, 0.0], x)
    }

    fn node(plane: u32, front: i64, back: i64) -> Node {
        Node { plane, children: [Child::of(front), Child::of(back)] }
    }

    #[test]
    fn points_find_their_leafs_and_leafs_their_planes() {
        let nodes = vec![node(0, 1, -2), node(1, -4, -3)];
        let tree = Tree::new(vec![plane(0.0), plane(5.0)], nodes, 4, &[Child::Node(0)]).unwrap();
        let at = |x| tree.leaf_at(Child::Node(0), [x, 9.0, 9.0]);
        assert_eq!([at(-1.0), at(0.0), at(4.9), at(5.0), at(f64::NAN)], [1, 2, 2, 3, 1]);
        assert_eq!(tree.planes_of_leaf(2), [plane(5.0), Plane::new([-1.0, -0.0, -0.0], -0.0)]);
        assert_eq!(tree.planes_of_leaf(0), []);
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let with = |nodes: Vec<Node>, root| {
            let tree = Tree::new(vec![plane(0.0)], nodes, 2, &[Child::of(root)]);
            tree.unwrap_err().to_string()
        };
        assert!(with(vec![node(1, -1, -2)], 0).contains("nodes, number 0: it names plane 1, of 1"));
        assert!(with(vec![node(0, -1, -3)], 0).contains("it names leaf 2, of 2"));
        assert!(with(vec![node(0, 1, -1)], 0).contains("it names node 1, of 1"));
        assert!(with(vec![node(0, -1, -2)], 1).contains("models, number 0: it names node 1, of 1"));
        // A loop, a root within a tree, and a node below two others.
        assert!(with(vec![node(0, 1, -1), node(0, 0, -1)], 0).contains("it is below itself"));
        assert!(with(vec![node(0, 1, -1), node(0, -1, -1)], 1).contains("which is below 0"));
        assert!(with(vec![node(0, 1, 1), node(0, -1, -1)], 0).contains("also below node 0"));
    }
}
