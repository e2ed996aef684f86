//! The impostor of a mesh in `CULLET_baked`.

use std::borrow::Cow;

use super::baked_items::{check, form, sum, table};
use super::buffers::Buffers;
use super::json::{Index, Integer};
use crate::baked::{BakedError, Measured, impostor_from_bytes, impostor_sum};
use crate::from_json;
use cullet_mesh::Impostor;

from_json! {
    pub(super) struct ImpostorItem<'a> {
        atlas: Index = need("atlas"),
        hash: Cow<'a, str> = need("hash"),
        measured: SeenItem = need("measured"),
    }

    pub(super) struct SeenItem {
        directions: Integer = need("directions"),
        quantile: f64 = need("quantile"),
        most_over: f64 = need("mostOver"),
        seed: Integer = need("seed"),
    }
}

/// The impostor, how it was measured, and how many bytes it has. `left` is how many bytes may yet
/// be taken for tables.
pub(super) fn read(
    item: &ImpostorItem<'_>,
    geometry: u64,
    buffers: &Buffers<'_>,
    left: &mut usize,
) -> Result<(Measured, Impostor, u64), BakedError> {
    let bytes = table(buffers, item.atlas, left)?;
    let measured = seen(&item.measured)?;
    check("its impostor", impostor_sum(geometry, &measured, bytes), sum(&item.hash)?)?;
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
        quantile: *quantile,
        most_over: *most_over,
        seed: seed.0,
    })
}
