//! The walk of a hierarchy, as the lecture's loop has it.

use std::ops::Range;

use cullet::Simd;
use cullet::bounds::{Boxes, Side};
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::hierarchy::Nodes;

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, grouped};

/// Children of a node.
const CHILDREN: usize = 16;

/// The recursion, with a count of the boxes that it tests.
struct Walk<'a> {
    planes: &'a Planes,
    /// The instances' own boxes, and the nodes above them.
    levels: Vec<&'a Boxes>,
    kept: Vec<u32>,
    tests: usize,
}

impl<'a> Walk<'a> {
    fn new(planes: &'a Planes, nodes: &'a Nodes, boxes: &'a Boxes) -> Self {
        let levels = std::iter::once(boxes).chain(nodes.levels()).collect();
        Self { planes, levels, kept: Vec::new(), tests: 0 }
    }

    fn run(mut self) -> (Vec<u32>, usize) {
        let top = self.levels.len() - 1;
        self.visit(top, 0..self.levels[top].len());
        (self.kept, self.tests)
    }

    fn visit(&mut self, level: usize, nodes: Range<usize>) {
        for node in nodes {
            self.tests += 1;
            match self.planes.classify_box(&self.levels[level].get(node)) {
                Side::Outside => {}
                Side::Straddling if level > 0 => {
                    self.visit(level - 1, self.below(level, level - 1, node));
                }
                _ => {
                    let leaves = self.below(level, 0, node);
                    self.kept.extend(leaves.map(|leaf| leaf as u32));
                }
            }
        }
    }

    /// What a node has on a level below it.
    fn below(&self, level: usize, at: usize, node: usize) -> Range<usize> {
        let each = CHILDREN.pow((level - at) as u32);
        node * each..((node + 1) * each).min(self.levels[at].len())
    }
}

/// The loop keeps what a test of every instance keeps, and the more instances there are, the smaller a share of tests it takes.
pub(super) fn recursion(lab: &Lab) -> Result<Finding, LabError> {
    let (mut told, mut shares, mut differ) = (Vec::new(), Vec::new(), 0);
    for words in
        ["city:cells=4,objects=150", "city:cells=8,objects=600", "city:cells=16,objects=2400"]
    {
        let model = lab.scene(words)?;
        let hierarchy = model.scene.hierarchy();
        let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
        let (mut tests, mut flat) = (0, 0);
        let mut each = Indices::new();
        for view in lab.views(&model, "walk", 4, SIZE)? {
            let planes = Planes::new(&view.frustum().relative_to(model.scene.origin()));
            let (kept, count) = Walk::new(&planes, nodes, boxes).run();
            tests += count;
            flat += boxes.len();
            cull_boxes(Simd::best(), &planes, boxes, &mut each);
            differ += u32::from(kept != *each);
        }
        shares.push(tests as f64 / flat as f64);
        told.push(format!("{} in place of {}", grouped(tests), grouped(flat)));
    }
    let falls = shares.windows(2).all(|pair| pair[1] < pair[0]);
    Ok(Finding::if_so(
        falls && differ == 0,
        format!(
            "in cities of three sizes the loop takes {} tests; {differ} of twelve results differ from those of all tests",
            told.join(", ")
        ),
    ))
}
