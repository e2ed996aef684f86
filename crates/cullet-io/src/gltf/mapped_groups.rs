//! Where the tables of merged groups lie in the bytes of a GLB.

use std::ops::Range;

use super::baked_items;
use super::json::Root;
use super::mapped_tables::{level_tables, rows};
use super::stand_ins::{self, ListItem, StandInItem};
use crate::baked::{BakedError, Measured, StandInTables};

/// The merged groups of a file.
#[derive(Debug, Default)]
pub(crate) struct ListedGroups {
    pub(crate) all: Vec<ListedGroup>,
    /// All that is said of them but for their tables.
    pub(crate) heads: Vec<StandInTables>,
    /// The sum of it all, as the file says.
    pub(crate) sum: u64,
    pub(crate) measured: Measured,
}

/// A merged group of instances, and where its tables lie.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedGroup {
    /// Where the origin of its positions is in the scene.
    pub origin: [f64; 3],
    /// The instances that it stands for, by their numbers in the order in which a walk of the
    /// scene's nodes comes to meshes.
    pub instances: Vec<u32>,
    /// The groups that it stands for, by their numbers, lower than its own.
    pub groups: Vec<u32>,
    /// How many triangles all instances below have.
    pub triangles: u64,
    /// For each part an instance below, and which primitive of triangles of its mesh the part is
    /// drawn like.
    pub like: Vec<[u32; 2]>,
    /// How many triangles of all levels each part has; they follow each other.
    pub parts: Vec<u32>,
    /// Bytes of the file: positions.
    pub positions: Range<usize>,
    /// Bytes of the file: indices, clusters, groups.
    pub tables: [Range<usize>; 3],
    /// Bytes of the file: texture coordinates and colours, each empty where there are none, and
    /// their sum.
    pub attributes: Option<([Range<usize>; 2], u64)>,
}

/// Finds them. All ranges are added to those that are taken.
pub(super) fn groups(
    root: &Root<'_>,
    list: Option<&ListItem<'_>>,
    bin: &Range<usize>,
    taken: &mut Vec<Range<usize>>,
) -> Result<ListedGroups, BakedError> {
    let Some(ListItem { hash, measured, all }) = list else { return Ok(ListedGroups::default()) };
    let mut out = ListedGroups {
        sum: baked_items::sum(hash)?,
        measured: baked_items::measured(measured)?,
        ..ListedGroups::default()
    };
    for item in all {
        let head = stand_ins::head_of(item)?;
        let group = group(root, item, &head, bin)?;
        taken.push(group.positions.clone());
        taken.extend(group.tables.clone());
        let attributes = group.attributes.iter().flat_map(|a| a.0.clone());
        taken.extend(attributes.filter(|range| !range.is_empty()));
        out.heads.push(head);
        out.all.push(group);
    }
    Ok(out)
}

fn group(
    root: &Root<'_>,
    item: &StandInItem<'_>,
    head: &StandInTables,
    bin: &Range<usize>,
) -> Result<ListedGroup, BakedError> {
    let [positions, tables @ ..] = item.tables();
    let positions = rows(root, positions, ("its positions", 12), bin)?;
    let attributes = match &item.attributes {
        None => None,
        Some(of) => {
            let kinds = [("its texture coordinates", 8), ("its colours", 16)];
            let mut ranges = [0..0, 0..0];
            for ((range, view), (what, row)) in
                ranges.iter_mut().zip([of.uvs, of.colors]).zip(kinds)
            {
                let Some(view) = view else { continue };
                *range = rows(root, view, (what, row), bin)?;
                let (found, expected) = ((range.len() / row) as u64, (positions.len() / 12) as u64);
                if found != expected {
                    return Err(BakedError::Count { what, found, expected });
                }
            }
            Some((ranges, baked_items::sum(&of.hash)?))
        }
    };
    Ok(ListedGroup {
        origin: head.origin,
        instances: head.instances.clone(),
        groups: head.stand_ins.clone(),
        triangles: head.triangles,
        like: head.like.clone(),
        parts: head.levels.parts.clone(),
        tables: level_tables(root, tables, &head.levels.parts, bin)?,
        positions,
        attributes,
    })
}
