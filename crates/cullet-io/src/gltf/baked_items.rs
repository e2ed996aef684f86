//! Parts that the readers of `CULLET_baked` share: objects, sums, and the errors in them.

use super::buffers::{Buffers, View};
use super::json::{Index, Integer};
use super::uri::shorten;
use crate::baked::{BakedError, Measured};
use crate::from_json;
use crate::json::{FromJson, Json};

/// The extension's name.
pub(crate) const NAME: &str = "CULLET_baked";

from_json! {
    pub(super) struct MeasuredItem {
        points: Integer = need("points"),
        reverse_points: Integer = need("reversePoints"),
        quantile: f64 = need("quantile"),
        most_over: f64 = need("mostOver"),
        seed: Integer = need("seed"),
    }
}

pub(super) fn form(message: impl Into<String>) -> BakedError {
    BakedError::Form(message.into())
}

/// An object of the extension.
pub(super) fn item<'a, T: FromJson<'a>>(json: Json<'a>) -> Result<T, BakedError> {
    T::from_json(json).map_err(BakedError::Form)
}

/// A sum: sixteen hexadecimal digits.
pub(super) fn sum(text: &str) -> Result<u64, BakedError> {
    let digits = text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit());
    let number = if digits { u64::from_str_radix(text, 16).ok() } else { None };
    number.ok_or_else(|| form(format!("{:?} are no sixteen hexadecimal digits", shorten(text))))
}

pub(super) fn check(what: &str, found: u64, expected: u64) -> Result<(), BakedError> {
    if found == expected {
        return Ok(());
    }
    Err(BakedError::Damaged { what: what.to_owned(), found, expected })
}

pub(super) fn measured(item: &MeasuredItem) -> Result<Measured, BakedError> {
    let int =
        |n: Integer| u32::try_from(n.0).map_err(|_| form(format!("{} points a triangle", n.0)));
    Ok(Measured {
        points: int(item.points)?,
        reverse_points: int(item.reverse_points)?,
        quantile: item.quantile,
        most_over: item.most_over,
        seed: item.seed.0,
    })
}

/// The bytes of a table. `left` is how many may yet be taken for any.
pub(super) fn table<'a>(
    buffers: &'a Buffers<'_>,
    view: Index,
    left: &mut usize,
) -> Result<&'a [u8], BakedError> {
    let count = buffers.views.len();
    let len = buffers.views.get(view.index()).map(View::len);
    let len = len.ok_or_else(|| form(format!("names bufferView {} of {count}", view.0)))?;
    *left = left.checked_sub(len).ok_or_else(|| form("tables share their bytes"))?;
    buffers.view(view.index()).map_err(|e| form(e.to_string()))
}
