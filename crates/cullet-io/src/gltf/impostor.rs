//! The impostor of a mesh in `CULLET_baked`.

use std::borrow::Cow;

use cullet::lod::Impostor;
use serde::Deserialize as Derive;
use serde_json::value::RawValue;

use super::baked_items::{check, form, item, sum};
use super::buffers::Buffers;
use super::json::{Float, Index, Integer};
use crate::baked::{BakedError, Measured, impostor_from_bytes, impostor_sum};

#[derive(Derive)]
struct ImpostorItem<'a> {
    atlas: Index,
    #[serde(borrow)]
    hash: Cow<'a, str>,
    measured: MeasuredItem,
}

#[derive(Derive)]
#[serde(rename_all = "camelCase")]
struct MeasuredItem {
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
    let count = buffers.views.len();
    let len = buffers.views.get(atlas.index()).map(super::buffers::View::len);
    let len = len.ok_or_else(|| form(format!("names bufferView {} of {count}", atlas.0)))?;
    *left = left.checked_sub(len).ok_or_else(|| form("tables share their bytes"))?;
    let bytes = buffers.view(atlas.index()).map_err(|e| form(e.to_string()))?;
    let MeasuredItem { directions, quantile, most_over, seed } = measured;
    let directions =
        u32::try_from(directions.0).map_err(|_| form(format!("{} directions", directions.0)))?;
    let measured = Measured {
        points: directions,
        reverse_points: 0,
        quantile: quantile.0,
        most_over: most_over.0,
        seed: seed.0,
    };
    check("its impostor", impostor_sum(geometry, &measured, bytes), sum(&hash)?)?;
    Ok((measured, impostor_from_bytes(bytes)?, len as u64))
}
