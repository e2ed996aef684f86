//! The node tree of a file: the names that its author gave, and how nodes nest.

/// The nodes of a file, or of whatever made the model. Empty for formats that have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeTree {
    /// The parent of each node; [`NodeTree::NONE`] for a root.
    pub parents: Vec<u32>,
    /// The name of each node; empty where it has none.
    pub names: Vec<String>,
    /// The transform of each node to its parent, column-major, a root's to the scene; as the file
    /// has it, whatever moved since. Empty unless
    /// [`LoadOptions::details`](crate::LoadOptions::details) requests it.
    pub locals: Vec<[f64; 16]>,
    /// The node that drew each instance, by the index of the instance's handle. Those beyond the
    /// end were drawn by none.
    pub node_of_instance: Vec<u32>,
}

/// Measures of a node tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeTreeStatistics {
    /// Nodes.
    pub nodes: usize,
    /// Nodes with no instance in them or below.
    pub empty: usize,
    /// Nodes on the longest way down from a root.
    pub depth: usize,
    /// The most children and instances that one node has for its own.
    pub widest: usize,
}

impl NodeTree {
    /// In place of a node: no parent, or drawn by none.
    pub const NONE: u32 = u32::MAX;

    /// How many nodes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parents.is_empty()
    }

    /// The name of a node, or its number where it has none (`node 12`).
    #[must_use]
    pub fn name(&self, node: u32) -> String {
        match self.names.get(node as usize) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => format!("node {node}"),
        }
    }

    /// Nodes, each after its parent, with the depth of each, 1 for a root; `None` if a parent is no
    /// node, or parents go round in a loop.
    fn parents_first(&self) -> Option<(Vec<u32>, Vec<usize>)> {
        let mut depth = vec![0; self.len()];
        let mut order = Vec::with_capacity(self.len());
        let mut chain = Vec::new();
        for start in 0..self.len() as u32 {
            let mut at = start;
            // Longer than the tree: a loop.
            while at != Self::NONE && *depth.get(at as usize)? == 0 && chain.len() <= self.len() {
                chain.push(at);
                at = self.parents[at as usize];
            }
            if chain.len() > self.len() {
                return None;
            }
            while let Some(node) = chain.pop() {
                let parent = self.parents[node as usize];
                depth[node as usize] = depth.get(parent as usize).map_or(1, |d| d + 1);
                order.push(node);
            }
        }
        Some((order, depth))
    }

    /// Measures the tree with its instances, given by the indices of their handles. `None` if a
    /// parent is no node, or parents go round in a loop. O(nodes + instances).
    pub(crate) fn statistics(
        &self,
        instances: impl Iterator<Item = u32>,
    ) -> Option<NodeTreeStatistics> {
        let (order, depth) = self.parents_first()?;
        let mut own = vec![0; self.len()];
        let mut below = vec![0; self.len()];
        for index in instances {
            let node = self.node_of_instance.get(index as usize).map(|&n| n as usize);
            if let Some(node) = node.filter(|&n| n < self.len()) {
                own[node] += 1;
                below[node] += 1;
            }
        }
        for &node in order.iter().rev() {
            let parent = self.parents[node as usize];
            if parent != Self::NONE {
                own[parent as usize] += 1;
                below[parent as usize] += below[node as usize];
            }
        }
        Some(NodeTreeStatistics {
            nodes: self.len(),
            empty: below.iter().filter(|&&instances| instances == 0).count(),
            depth: depth.into_iter().max().unwrap_or(0),
            widest: own.into_iter().max().unwrap_or(0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(parents: &[u32]) -> NodeTree {
        NodeTree { parents: parents.to_vec(), ..NodeTree::default() }
    }

    #[test]
    fn a_tree_is_measured_whatever_the_order_of_its_nodes() {
        const NONE: u32 = NodeTree::NONE;
        // 3 is a root over 1 and 2; 0 is below 2, and draws the instance; 4 is a root of its own.
        let mut tree = tree(&[2, 3, 3, NONE, NONE]);
        tree.node_of_instance = vec![0];
        let found = tree.statistics([0].into_iter()).expect("a tree");
        assert_eq!(found, NodeTreeStatistics { nodes: 5, empty: 2, depth: 3, widest: 2 });
        tree.node_of_instance = vec![NONE];
        assert_eq!(tree.statistics([0].into_iter()).expect("a tree").empty, 5);
        assert_eq!(tree.statistics([0, 1].into_iter()).expect("a tree").empty, 5, "beyond the end");
    }

    #[test]
    fn loops_and_parents_that_are_no_nodes_are_told() {
        for parents in [&[0][..], &[1, 0], &[NodeTree::NONE, 2, 3, 1], &[7]] {
            assert_eq!(tree(parents).statistics([0].into_iter()), None, "{parents:?}");
        }
        let none = tree(&[]).statistics([0].into_iter());
        assert_eq!(none, Some(NodeTreeStatistics::default()));
    }
}
