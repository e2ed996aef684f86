//! Groups that the author of a scene made, as a hierarchy: a scene graph, floors and rooms, assemblies.

mod error;
mod moves;

pub use error::{GroupStatistics, GroupsError, Member};

use std::ops::Range;

use fearless_simd::Level;

use crate::bounds::{Aabb, Boxes, LANES};
use moves::rows_of;

/// Groups of things, and groups of groups, each with a box that holds all below it.
///
/// The things of a group lie side by side in *places*, its own first and then those of the groups in it,
/// one group after the other (depth first); so all that is below a group is one range of places, which is
/// taken or skipped at once. The boxes of the groups in one group lie side by side too, and are tested
/// sixteen at a time. What walks them for a view is
/// [`cull::frustum::groups`](crate::cull::frustum::groups).
///
/// A thing may be in no group, and a group may be empty. The box of a thing that is not finite is
/// everywhere, and so are the groups above it: they are always kept. An empty one is nowhere.
///
/// The groups are as good as their author made them: see [`GroupStatistics::surface`], and hold it against
/// that of [`Nodes`](super::Nodes) over the same boxes.
#[derive(Clone, Debug)]
pub struct Groups {
    level: Level,
    /// The thing at each place.
    items: Vec<u32>,
    place_of_item: Vec<u32>,
    /// The node that has the thing at each place for its own.
    node_of_place: Vec<u32>,
    boxes: Boxes,
    /// Node 0 is above all. Children of one node lie side by side and after their parent, in one block of
    /// sixteen where they fit; what that leaves free are nodes of no group.
    nodes: Vec<GroupNode>,
    node_boxes: Boxes,
    node_of_group: Vec<u32>,
    /// One bit a place: its box is empty.
    holes: Vec<u64>,
    /// One bit a node: below it is one thing, whose box is the node's.
    alone: Vec<u64>,
    /// One bit a node: it may be larger than it need be.
    loose: Vec<u64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupNode {
    pub(crate) parent: u32,
    /// The caller's number, or [`Groups::NONE`].
    pub(crate) group: u32,
    pub(crate) first_child: u32,
    pub(crate) children: u32,
    /// Places: own things from `first`, things below from `own_end`, to `end`.
    pub(crate) first: u32,
    pub(crate) own_end: u32,
    pub(crate) end: u32,
}

impl GroupNode {
    const UNUSED: Self = Self {
        parent: 0,
        group: Groups::NONE,
        first_child: 0,
        children: 0,
        first: 0,
        own_end: 0,
        end: 0,
    };

    pub(crate) fn child_range(&self) -> Range<usize> {
        self.first_child as usize..(self.first_child + self.children) as usize
    }

    /// The places of all that is below.
    pub(crate) fn places(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }

    /// The places of its own things.
    pub(crate) fn own(&self) -> Range<usize> {
        self.first as usize..self.own_end as usize
    }
}

/// Few enough that numbers of nodes, with what blocks leave free, stay u32.
const MOST: usize = u32::MAX as usize / LANES;

impl Groups {
    /// No group: the parent of a group at the top, and the group of a thing in none.
    pub const NONE: u32 = u32::MAX;

    /// Groups of things, with boxes that fit.
    ///
    /// `parents[g]` is the group that group g lies in, or [`NONE`](Self::NONE). `members` are pairs of group
    /// and thing, in any order; a thing is a number below the length of `bounds`, and what is in no pair is
    /// in no group. O(groups + things), whatever their shape: a chain of a million groups is no trouble.
    ///
    /// # Errors
    /// If a number is out of range, a group lies in itself, a thing is in two groups, or there are more than
    /// 2²⁸ − 1 groups or things.
    pub fn build(
        parents: &[u32],
        members: &[[u32; 2]],
        bounds: &[Aabb],
    ) -> Result<Self, GroupsError> {
        let mut groups = Self::over_nothing(parents, members, bounds.len())?;
        groups.set_all(bounds);
        Ok(groups)
    }

    /// [`build`](Self::build) over boxes that are stored already, those of a [`Hierarchy`](super::Hierarchy)
    /// or a scene by slot, say: they are taken as they are, so that the answers are the same to the last bit.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn over(parents: &[u32], members: &[[u32; 2]], boxes: &Boxes) -> Result<Self, GroupsError> {
        let mut groups = Self::over_nothing(parents, members, boxes.len())?;
        groups.set_all_stored(boxes);
        Ok(groups)
    }

    /// Groups with places for things, of which no box is set.
    fn over_nothing(
        parents: &[u32],
        members: &[[u32; 2]],
        items: usize,
    ) -> Result<Self, GroupsError> {
        let too_many = |what, count| GroupsError::TooMany { what, count, limit: MOST };
        if parents.len() > MOST {
            return Err(too_many("groups", parents.len()));
        }
        if items > MOST {
            return Err(too_many("items", items));
        }
        let group_of_item = groups_of_items(parents.len(), members, items)?;
        let children = Lists::new(parents.len(), parents.iter().copied());
        let own = Lists::new(parents.len(), group_of_item.iter().copied());
        let mut groups = Self {
            level: Level::new(),
            items: Vec::with_capacity(items),
            place_of_item: vec![0; items],
            node_of_place: Vec::with_capacity(items),
            boxes: Boxes::new(),
            nodes: vec![GroupNode::UNUSED],
            node_boxes: Boxes::new(),
            node_of_group: vec![Self::NONE; parents.len()],
            holes: Vec::new(),
            alone: Vec::new(),
            loose: Vec::new(),
        };
        groups.lay_out(parents, &children, &own)?;
        let nodes = groups.nodes.len();
        groups.node_boxes.resize(nodes);
        groups.alone.resize(nodes.div_ceil(64), 0);
        groups.loose.resize(nodes.div_ceil(64), 0);
        groups.holes.resize(items.div_ceil(64), 0);
        Ok(groups)
    }

    /// Numbers the nodes and gives the things their places, parents before children. No recursion: a
    /// scene graph may be as deep as it has nodes.
    fn lay_out(
        &mut self,
        parents: &[u32],
        children: &Lists,
        own: &Lists,
    ) -> Result<(), GroupsError> {
        if let Some(group) = children.missed {
            let parent = parents[group as usize];
            return Err(GroupsError::NoParent { group, parent, groups: parents.len() as u32 });
        }
        /// A node that begins here, or one of which all is placed.
        enum Step {
            Begin(u32),
            End(u32),
        }
        let mut reached = 0;
        let mut steps = vec![Step::Begin(0)];
        while let Some(step) = steps.pop() {
            let at = match step {
                Step::End(node) => {
                    self.nodes[node as usize].end = self.items.len() as u32;
                    continue;
                }
                Step::Begin(node) => node as usize,
            };
            let group = self.nodes[at].group;
            let first = self.items.len();
            for &item in own.of(group) {
                self.place_of_item[item as usize] = self.items.len() as u32;
                self.items.push(item);
                self.node_of_place.push(at as u32);
            }
            let below = children.of(group);
            reached += below.len();
            let free = self.nodes.len().next_multiple_of(LANES) - self.nodes.len();
            if below.len() > free {
                self.nodes.extend(std::iter::repeat_n(GroupNode::UNUSED, free));
            }
            let first_child = self.nodes.len();
            for (child, &group) in (first_child..).zip(below) {
                self.node_of_group[group as usize] = child as u32;
                self.nodes.push(GroupNode { parent: at as u32, group, ..GroupNode::UNUSED });
            }
            let node = &mut self.nodes[at];
            node.first = first as u32;
            node.own_end = self.items.len() as u32;
            node.first_child = first_child as u32;
            node.children = below.len() as u32;
            steps.push(Step::End(at as u32));
            steps.extend(
                (first_child..first_child + below.len()).rev().map(|n| Step::Begin(n as u32)),
            );
        }
        if reached == parents.len() {
            return Ok(());
        }
        // What was not reached lies on a circle or below one: so many steps up, one is on it.
        let lost = self.node_of_group.iter().position(|&n| n == Self::NONE).unwrap_or_default();
        let group = (0..parents.len()).fold(lost as u32, |g, _| parents[g as usize]);
        Err(GroupsError::Cycle { group })
    }

    /// Works at another SIMD level than the best of the machine. The answers are the same.
    #[must_use]
    pub fn with_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Gives the groups boxes of the author's own, by group, in place of those that fit: `bounds` with a
    /// margin for what is going to move, say. A box that is not finite is everywhere.
    ///
    /// # Errors
    /// If there is not one box a group, or one does not hold all that is in the group; then the boxes stay
    /// as they were.
    pub fn give_bounds(&mut self, bounds: &[Aabb]) -> Result<(), GroupsError> {
        if bounds.len() != self.node_of_group.len() {
            let groups = self.node_of_group.len();
            return Err(GroupsError::Count { given: bounds.len(), groups });
        }
        let before = self.node_boxes.clone();
        for (b, &node) in bounds.iter().zip(&self.node_of_group) {
            self.node_boxes.set(node as usize, b);
        }
        self.fit_node(0);
        if let Err(error) = self.validate() {
            self.node_boxes = before;
            return Err(error);
        }
        (0..self.nodes.len()).for_each(|node| self.note_alone(node));
        self.loose.fill(0);
        Ok(())
    }

    /// How many groups there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.node_of_group.len()
    }

    /// Whether there is no group.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.node_of_group.is_empty()
    }

    /// The boxes of things by place, and so in the order of the answers.
    #[must_use]
    pub fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// The thing at each place.
    #[must_use]
    pub fn items(&self) -> &[u32] {
        &self.items
    }

    /// The place of a thing; `None` if there is no such thing.
    #[must_use]
    pub fn place(&self, item: u32) -> Option<u32> {
        self.place_of_item.get(item as usize).copied()
    }

    /// The group that has a thing for its own; `None` for one in no group, or if there is no such thing.
    #[must_use]
    pub fn group_of(&self, item: u32) -> Option<u32> {
        let node = self.node_of_place[self.place(item)? as usize];
        Some(self.nodes[node as usize].group).filter(|&g| g != Self::NONE)
    }

    /// The places of all that is in a group and the groups in it; `None` if there is no such group.
    #[must_use]
    pub fn places(&self, group: u32) -> Option<Range<usize>> {
        self.node_of_group.get(group as usize).map(|&node| self.nodes[node as usize].places())
    }

    /// The group that a group lies in; `None` at the top, or if there is no such group.
    #[must_use]
    pub fn parent(&self, group: u32) -> Option<u32> {
        let node = *self.node_of_group.get(group as usize)?;
        let parent = self.nodes[node as usize].parent;
        Some(self.nodes[parent as usize].group).filter(|&g| g != Self::NONE)
    }

    /// The box of a group, as it is stored; `None` if there is no such group.
    #[must_use]
    pub fn bounds(&self, group: u32) -> Option<Aabb> {
        let node = *self.node_of_group.get(group as usize)?;
        Some(self.node_boxes.get(node as usize))
    }

    /// Checks that every group holds what is in it, and measures them. O(groups + things).
    ///
    /// # Errors
    /// If a group does not, naming it and what leaves it.
    pub fn validate(&self) -> Result<GroupStatistics, GroupsError> {
        let mut found = GroupStatistics { groups: self.len(), ..GroupStatistics::default() };
        let mut depth = vec![0; self.nodes.len()];
        let mut surface = 0.0;
        let used = (0..self.nodes.len()).filter(|&n| n == 0 || self.nodes[n].group != Self::NONE);
        for node in used {
            let n = &self.nodes[node];
            let held = rows_of(&self.node_boxes, node);
            let holds = |rows: [f32; 6]| (0..6).all(|r| rows[r] <= held[r]);
            let item = n.own().find(|&p| !holds(rows_of(&self.boxes, p)));
            let item = item.map(|p| Member::Item(self.items[p]));
            let child = n.child_range().find(|&c| !holds(rows_of(&self.node_boxes, c)));
            let child = child.map(|c| Member::Group(self.nodes[c].group));
            if let Some(member) = item.or(child) {
                return Err(GroupsError::Leaves { group: n.group, member });
            }
            if node == 0 {
                found.ungrouped = n.own().len();
                continue;
            }
            depth[node] = depth[n.parent as usize] + 1;
            found.depth = found.depth.max(depth[node]);
            found.widest = found.widest.max(n.own().len() + n.children as usize);
            found.empty += usize::from(n.places().is_empty());
            let b = self.node_boxes.get(node);
            surface += if b.is_empty() { 0.0 } else { b.surface_area() };
        }
        let around = self.node_boxes.get(0);
        let whole = if around.is_empty() { 0.0 } else { around.surface_area() };
        found.surface = if whole > 0.0 { surface / whole } else { 0.0 };
        found.bytes = size_of_val(&*self.nodes)
            + size_of_val(self.node_boxes.as_floats())
            + 8 * (self.alone.len() + self.loose.len() + self.holes.len())
            + 4 * (self.node_of_group.len() + self.node_of_place.len())
            + 4 * (self.items.len() + self.place_of_item.len());
        Ok(found)
    }

    pub(crate) fn nodes(&self) -> &[GroupNode] {
        &self.nodes
    }

    pub(crate) fn node_boxes(&self) -> &Boxes {
        &self.node_boxes
    }

    /// One bit a place: its box is empty.
    pub(crate) fn holes(&self) -> &[u64] {
        &self.holes
    }

    /// Of the sixteen nodes of a block, those below which is one thing, with the node's own box.
    pub(crate) fn alone(&self, block: usize) -> u32 {
        (self.alone[block / 4] >> (block % 4 * LANES)) as u32 & 0xffff
    }
}

/// The group of each thing.
fn groups_of_items(
    groups: usize,
    members: &[[u32; 2]],
    items: usize,
) -> Result<Vec<u32>, GroupsError> {
    let mut group_of_item = vec![Groups::NONE; items];
    for &[group, item] in members {
        if group as usize >= groups {
            return Err(GroupsError::NoGroup { item, group, groups: groups as u32 });
        }
        let Some(slot) = group_of_item.get_mut(item as usize) else {
            return Err(GroupsError::NoItem { group, item, items: items as u32 });
        };
        if *slot != Groups::NONE {
            return Err(GroupsError::Twice { item, first: *slot, second: group });
        }
        *slot = group;
    }
    Ok(group_of_item)
}

/// A list of numbers for each group, and one for none.
struct Lists {
    numbers: Vec<u32>,
    starts: Vec<u32>,
    /// The first number that is in a group that is not there.
    missed: Option<u32>,
}

impl Lists {
    /// Of 0, 1, 2 ... the lists of those in each group, ascending; `group_of` gives the group of each.
    fn new(groups: usize, group_of: impl Iterator<Item = u32> + Clone) -> Self {
        // The list of none is the last.
        let list = |group: u32| if group == Groups::NONE { groups } else { group as usize };
        let mut starts = vec![0; groups + 2];
        for (number, group) in group_of.clone().enumerate() {
            let Some(start) = starts.get_mut(list(group) + 1).filter(|_| list(group) <= groups)
            else {
                return Self { numbers: Vec::new(), starts, missed: Some(number as u32) };
            };
            *start += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; starts[groups + 1] as usize];
        for (number, group) in group_of.enumerate() {
            let at = &mut next[list(group)];
            numbers[*at as usize] = number as u32;
            *at += 1;
        }
        Self { numbers, starts, missed: None }
    }

    fn of(&self, group: u32) -> &[u32] {
        let list = if group == Groups::NONE { self.starts.len() - 2 } else { group as usize };
        &self.numbers[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}
