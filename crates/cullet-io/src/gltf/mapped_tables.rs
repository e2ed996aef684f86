//! The bytes of tables in a GLB, counted from the start of the file.

use std::ops::Range;

use super::baked_items::form;
use super::json::{self, Index, Integer, Root, ViewItem};
use crate::baked::{BakedError, ROWS, TABLE_ALIGNMENT};

/// The tables of levels whose parts have so many triangles: indices, clusters, groups.
pub(super) fn level_tables(
    root: &Root<'_>,
    views: [Index; 3],
    parts: &[u32],
    bin: &Range<usize>,
) -> Result<[Range<usize>; 3], BakedError> {
    let mut tables = [0..0, 0..0, 0..0];
    for ((range, view), (what, row)) in tables.iter_mut().zip(views).zip(ROWS) {
        *range = rows(root, view, (what, row), bin)?;
    }
    let found = (tables[0].len() / 12) as u64;
    let expected = parts.iter().map(|&n| u64::from(n)).sum();
    if found != expected {
        return Err(BakedError::Count { what: "triangles of all levels", found, expected });
    }
    Ok(tables)
}

/// The bytes of a table of whole rows.
pub(super) fn rows(
    root: &Root<'_>,
    view: Index,
    (what, row): (&'static str, usize),
    bin: &Range<usize>,
) -> Result<Range<usize>, BakedError> {
    let range = aligned(root, view, what, bin)?;
    match range.len().is_multiple_of(row) {
        true => Ok(range),
        false => Err(BakedError::Size { what, bytes: range.len(), row }),
    }
}

/// The bytes of a table, which begins where tables do.
pub(super) fn aligned(
    root: &Root<'_>,
    view: Index,
    what: &'static str,
    bin: &Range<usize>,
) -> Result<Range<usize>, BakedError> {
    let range = table(root, view.index(), bin)?;
    match range.start.is_multiple_of(TABLE_ALIGNMENT) {
        true => Ok(range),
        false => Err(BakedError::Unaligned { what, at: range.start }),
    }
}

/// The bytes of a view, counted from the start of the file.
fn table(root: &Root<'_>, view: usize, bin: &Range<usize>) -> Result<Range<usize>, BakedError> {
    let views = json::all(&root.buffer_views);
    let raw = views.get(view);
    let raw = raw.ok_or_else(|| form(format!("names bufferView {view} of {}", views.len())))?;
    let wrong = |message: String| form(format!("bufferView {view}: {message}"));
    let item: ViewItem<'_> =
        json::item(*raw, "bufferView", view).map_err(|e| form(e.to_string()))?;
    if item.buffer.index() != 0 || item.meshopt.is_some() || item.byte_stride.is_some() {
        return Err(wrong("is not of bytes that lie in the file one after another".to_owned()));
    }
    let (start, length) = (item.byte_offset.map_or(0, |Integer(o)| o), item.byte_length.0);
    let end = start.checked_add(length).filter(|&end| end <= bin.len() as u64 && length > 0);
    let end = end.ok_or_else(|| {
        wrong(format!("{length} bytes at {start} do not fit the {} that there are", bin.len()))
    })?;
    Ok(bin.start + start as usize..bin.start + end as usize)
}
