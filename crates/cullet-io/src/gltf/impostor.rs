//! The impostor of a mesh in `CULLET_baked`.

use std::borrow::Cow;

use cullet::lod::Impostor;
use serde::Deserialize as Derive;
use serde_json::value::RawValue;

use super::baked_items::{check, form, item, sum, table};
use super::buffers::Buffers;
use super::json::{Float, Index, Integer};
use crate::baked::{BakedError, Measured, impostor_from_bytes, impostor_sum};

#[derive(Derive)]
pub(super) struct ImpostorItem<'a> {
    pub(super) atlas: Index,
    #[serde(borrow)]
    pub(super) hash: Cow<'a, str>,
    pub(super) measured: SeenItem,
}

#[derive(Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct SeenItem {
    directions: Integer,
    quantile: Float,
    most_over: Float,
    seed: Integer,
}

/// The impostor, how it was measured, and how many bytes it has. `left` is how many bytes may yet be taken for tables.
pub(super) fn read(
    raw: &RawValue,
    geometry: u64,
    buffers: &Buffers<'_>,
    left: &mut usize,
) -> Result<(Measured, Impostor, u64), BakedError> {
    let ImpostorItem { atlas, hash, measured } = item(raw)?;
    let bytes = table(buffers, atlas, left)?;
    let measured = seen(&measured)?;
    check("its impostor", impostor_sum(geometry, &measured, bytes), sum(&hash)?)?;
    Ok((measured, impostor_from_bytes(bytes)?, bytes.len() as u64))
}

/// How it was measured.
pub(super) fn seen(item: &SeenItem) -> Result<Measured, BakedError> {
    let SeenItem { directions, quantile, most_over, seed } = item;
    let points =
        u32::try_from(directions.0).map_err(|_| form(format!("{} directions", directions.0)))?;
    Ok(Measured {
        points,
        reverse_points: 0,
        quantile: quantile.0,
        most_over: most_over.0,
        seed: seed.0,
    })
}
