//! Instances that stand for others: `standIns` of the object of `CULLET_baked` at the root. What each member means is in
//! the book's page on baking, and in `docs/schema/CULLET_baked.schema.json`.

use std::borrow::Cow;

use serde::Deserialize as Derive;
use serde_json::value::RawValue;

use super::baked_items::{MeasuredItem, check, form, item, measured, sum};
use super::buffers::{Buffers, View};
use super::json::{Float, Index, Integer};
use crate::baked::{BakedError, LevelTables, Measured, StandInTables, sum_of_stand_ins};

/// Of the object at the root, what is read here.
#[derive(Derive)]
struct RootItem<'a> {
    #[serde(borrow, rename = "standIns")]
    stand_ins: Option<&'a RawValue>,
}

#[derive(Derive)]
struct ListItem<'a> {
    #[serde(borrow)]
    hash: Cow<'a, str>,
    measured: MeasuredItem,
    all: Vec<StandInItem>,
}

#[derive(Derive)]
#[serde(rename_all = "camelCase")]
struct StandInItem {
    origin: [Float; 3],
    instances: Vec<Integer>,
    stand_ins: Vec<Integer>,
    like: Vec<[Integer; 2]>,
    triangles: Integer,
    parts: Vec<Integer>,
    positions: Index,
    indices: Index,
    clusters: Index,
    groups: Index,
}

/// Reads them from the extension's object at the root. `left` is how many bytes may yet be taken for tables.
pub(super) fn read(
    raw: &RawValue,
    buffers: &Buffers<'_>,
    left: &mut usize,
) -> Result<Option<(Measured, Vec<StandInTables>)>, BakedError> {
    let RootItem { stand_ins } = item(raw)?;
    let Some(raw) = stand_ins else { return Ok(None) };
    let ListItem { hash, measured: found, all } = item(raw)?;
    let mut made = Vec::with_capacity(all.len());
    let mut bytes = Vec::with_capacity(all.len());
    for one in &all {
        let tables = [one.positions, one.indices, one.clusters, one.groups];
        let mut own: [&[u8]; 4] = [&[]; 4];
        for (own, view) in own.iter_mut().zip(tables) {
            let count = buffers.views.len();
            let len = buffers.views.get(view.index()).map(View::len);
            let len = len.ok_or_else(|| form(format!("names bufferView {} of {count}", view.0)))?;
            *left = left.checked_sub(len).ok_or_else(|| form("tables share their bytes"))?;
            *own = buffers.view(view.index()).map_err(|e| form(e.to_string()))?;
        }
        made.push(tables_of(one, own)?);
        bytes.push(own);
    }
    let rows: Vec<_> = made.iter().zip(bytes).collect();
    check("the list of stand-ins", sum_of_stand_ins(&rows), sum(&hash)?)?;
    Ok(Some((measured(&found)?, made)))
}

fn tables_of(item: &StandInItem, bytes: [&[u8]; 4]) -> Result<StandInTables, BakedError> {
    let ints = |list: &[Integer]| -> Result<Vec<u32>, BakedError> {
        let ints = list.iter().map(|n| u32::try_from(n.0));
        ints.collect::<Result<_, _>>().map_err(|_| form("a stand-in has a number beyond 2^32"))
    };
    let [positions, indices, clusters, groups] = bytes;
    if positions.len() % 12 != 0 {
        return Err(BakedError::Size { what: "its positions", bytes: positions.len(), row: 12 });
    }
    let like = item.like.iter().map(|pair| Ok(ints(pair)?.try_into().unwrap_or_default()));
    let like: Result<Vec<[u32; 2]>, BakedError> = like.collect();
    Ok(StandInTables {
        origin: item.origin.each_ref().map(|v| v.0),
        instances: ints(&item.instances)?,
        stand_ins: ints(&item.stand_ins)?,
        like: like?,
        positions: positions
            .as_chunks::<4>()
            .0
            .as_chunks::<3>()
            .0
            .iter()
            .map(|p| p.map(f32::from_le_bytes))
            .collect(),
        levels: LevelTables::from_bytes(ints(&item.parts)?, [indices, clusters, groups])?,
        triangles: item.triangles.0,
    })
}
