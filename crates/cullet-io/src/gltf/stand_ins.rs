//! Instances that stand for others: `standIns` of the object of `CULLET_baked` at the root. What
//! each member means is in the book's page on baking, and in
//! `docs/schema/CULLET_baked.schema.json`.

use std::borrow::Cow;

use super::baked_items::{MeasuredItem, check, form, measured, sum, table};
use super::buffers::Buffers;
use super::json::{Index, Integer};
use crate::Attributes;
use crate::baked::{
    BakedError, LevelTables, Measured, StandInTables, attribute_sum, sum_of_stand_ins,
};
use crate::bytes::to_f32s;
use crate::from_json;
use crate::json::{FromJson, Json, Object};

from_json! {
    pub(super) struct ListItem<'a> {
        hash: Cow<'a, str> = need("hash"),
        measured: MeasuredItem = need("measured"),
        all: Vec<StandInItem<'a>> = need("all"),
    }

    pub(super) struct StandInItem<'a> {
        origin: [f64; 3] = need("origin"),
        instances: Vec<Integer> = need("instances"),
        stand_ins: Vec<Integer> = need("standIns"),
        like: Vec<[Integer; 2]> = need("like"),
        triangles: Integer = need("triangles"),
        parts: Vec<Integer> = need("parts"),
        positions: Index = need("positions"),
        indices: Index = need("indices"),
        clusters: Index = need("clusters"),
        groups: Index = need("groups"),
        attributes: Option<AttributesItem<'a>> = get("attributes"),
    }

    /// Attributes of the vertices, which older readers pass over.
    pub(super) struct AttributesItem<'a> {
        uvs: Option<Index> = get("uvs"),
        colors: Option<Index> = get("colors"),
        hash: Cow<'a, str> = need("hash"),
    }
}

impl StandInItem<'_> {
    /// The bufferViews of positions, indices, clusters and groups.
    pub(super) fn tables(&self) -> [Index; 4] {
        [self.positions, self.indices, self.clusters, self.groups]
    }
}

/// The list in the extension's object at the root, if there is one.
pub(super) fn list(root: Json<'_>) -> Result<Option<ListItem<'_>>, BakedError> {
    Object::from_json(root).and_then(|all| all.get("standIns")).map_err(BakedError::Form)
}

/// Reads them from the extension's object at the root, with `details` their attributes too. `left`
/// is how many bytes may yet be taken for tables.
pub(super) fn read(
    root: Json<'_>,
    buffers: &Buffers<'_>,
    details: bool,
    left: &mut usize,
) -> Result<Option<(Measured, Vec<StandInTables>)>, BakedError> {
    let Some(ListItem { hash, measured: found, all }) = list(root)? else { return Ok(None) };
    let mut made = Vec::with_capacity(all.len());
    let mut bytes = Vec::with_capacity(all.len());
    for one in &all {
        let mut own: [&[u8]; 4] = [&[]; 4];
        for (own, view) in own.iter_mut().zip(one.tables()) {
            *own = table(buffers, view, left)?;
        }
        let mut tables = tables_of(one, own)?;
        if let Some(item) = one.attributes.as_ref().filter(|_| details) {
            tables.attributes = attributes_of(item, tables.positions.len(), buffers, left)?;
        }
        made.push(tables);
        bytes.push(own);
    }
    let rows: Vec<_> = made.iter().zip(bytes).collect();
    check("the list of stand-ins", sum_of_stand_ins(&rows), sum(&hash)?)?;
    Ok(Some((measured(&found)?, made)))
}

fn attributes_of(
    item: &AttributesItem<'_>,
    vertices: usize,
    buffers: &Buffers<'_>,
    left: &mut usize,
) -> Result<Attributes, BakedError> {
    let mut bytes: [&[u8]; 2] = [&[]; 2];
    for (bytes, view) in bytes.iter_mut().zip([item.uvs, item.colors]) {
        if let Some(view) = view {
            *bytes = table(buffers, view, left)?;
        }
    }
    check("attributes of a stand-in", attribute_sum(bytes), sum(&item.hash)?)?;
    for (bytes, row) in bytes.into_iter().zip([8, 16]) {
        let (found, expected) = (bytes.len() as u64, vertices as u64 * row);
        if found != expected && found != 0 {
            let what = "bytes of attributes of a stand-in";
            return Err(BakedError::Count { what, found, expected });
        }
    }
    let mut all =
        Attributes { uvs: rows(bytes[0]), colors: rows(bytes[1]), ..Attributes::default() };
    all.mend();
    Ok(all)
}

/// Rows of numbers, as many as are whole.
fn rows<const N: usize>(bytes: &[u8]) -> Vec<[f32; N]> {
    to_f32s(bytes).as_chunks::<N>().0.to_vec()
}

/// All that is said of one but for its tables.
pub(super) fn head_of(item: &StandInItem<'_>) -> Result<StandInTables, BakedError> {
    let ints = |list: &[Integer]| -> Result<Vec<u32>, BakedError> {
        let ints = list.iter().map(|n| u32::try_from(n.0));
        ints.collect::<Result<_, _>>().map_err(|_| form("a stand-in has a number beyond 2^32"))
    };
    let like = item.like.iter().map(|pair| Ok(ints(pair)?.try_into().unwrap_or_default()));
    let like: Result<Vec<[u32; 2]>, BakedError> = like.collect();
    Ok(StandInTables {
        origin: item.origin,
        instances: ints(&item.instances)?,
        stand_ins: ints(&item.stand_ins)?,
        like: like?,
        levels: LevelTables { parts: ints(&item.parts)?, ..LevelTables::default() },
        triangles: item.triangles.0,
        ..StandInTables::default()
    })
}

fn tables_of(item: &StandInItem<'_>, bytes: [&[u8]; 4]) -> Result<StandInTables, BakedError> {
    let [positions, indices, clusters, groups] = bytes;
    if positions.len() % 12 != 0 {
        return Err(BakedError::Size { what: "its positions", bytes: positions.len(), row: 12 });
    }
    let head = head_of(item)?;
    let levels = LevelTables::from_bytes(head.levels.parts, [indices, clusters, groups])?;
    Ok(StandInTables { positions: rows(positions), levels, ..head })
}
