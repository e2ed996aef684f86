//! What may be wrong with groups, and what they measure.

use thiserror::Error;

/// What is in a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Member {
    /// A thing, by the caller's number.
    Item(u32),
    /// A group, by the caller's number.
    Group(u32),
}

impl std::fmt::Display for Member {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Item(item) => write!(f, "item {item}"),
            Self::Group(group) => write!(f, "group {group}"),
        }
    }
}

/// Why groups are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum GroupsError {
    /// A group lies in one that is not there.
    #[error(
        "group {group} lies in group {parent}, but there are {groups}: give a number below that, or Groups::NONE for one at the top"
    )]
    NoParent {
        /// Which group.
        group: u32,
        /// What it says it lies in.
        parent: u32,
        /// How many groups there are.
        groups: u32,
    },
    /// A group lies in itself, by way of others or at once.
    #[error("group {group} lies in itself: follow its parents, one of them must be taken out")]
    Cycle {
        /// A group of the circle.
        group: u32,
    },
    /// A thing is in a group that is not there.
    #[error("item {item} is in group {group}, but there are {groups}")]
    NoGroup {
        /// Which thing.
        item: u32,
        /// The group it says it is in.
        group: u32,
        /// How many groups there are.
        groups: u32,
    },
    /// A thing that has no bounds is in a group.
    #[error("group {group} has item {item}, but there are bounds of {items} items")]
    NoItem {
        /// The group.
        group: u32,
        /// Which thing.
        item: u32,
        /// How many there are.
        items: u32,
    },
    /// A thing is in two groups, or twice in one.
    #[error("item {item} is in group {first} and again in group {second}: leave it in one")]
    Twice {
        /// Which thing.
        item: u32,
        /// The group that has it.
        first: u32,
        /// The one that would have it, too.
        second: u32,
    },
    /// Numbers are u32, and some of them are in use.
    #[error("{count} {what}, but there may be {limit}: make several hierarchies")]
    TooMany {
        /// Groups or items.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// There is not one box a group.
    #[error("{given} boxes for {groups} groups: give one for each")]
    Count {
        /// How many boxes.
        given: usize,
        /// How many groups.
        groups: usize,
    },
    /// A group's box does not hold what is in the group.
    #[error(
        "{member} leaves the box of group {group}: enlarge the box, or let Groups::fit make it"
    )]
    Leaves {
        /// The group; [`Groups::NONE`](super::Groups::NONE) for the one above all.
        group: u32,
        /// What leaves it.
        member: Member,
    },
}

/// What [`Groups::validate`](super::Groups::validate) measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupStatistics {
    /// How many groups there are.
    pub groups: usize,
    /// How many of them have nothing below them.
    pub empty: usize,
    /// How many groups lie in each other at most; 1 if none does.
    pub depth: usize,
    /// The most groups and things that one group has for its own.
    pub widest: usize,
    /// How many things are in no group.
    pub ungrouped: usize,
    /// Surface of all groups over that of the box around everything: how many of them a random ray meets,
    /// so the lower the better. 0 where everything is a point or nothing is finite.
    pub surface: f64,
    /// Bytes of the groups: without the boxes of things.
    pub bytes: usize,
}
