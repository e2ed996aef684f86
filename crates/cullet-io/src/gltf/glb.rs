//! The GLB container: a header and chunks around the JSON and the binary buffer.

use std::ops::Range;

use super::notes::Notes;
use crate::ErrorKind;

const MAGIC: &[u8; 4] = b"glTF";
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Where the parts of a file lie in its bytes.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Container {
    /// The JSON text.
    pub(crate) json: Range<usize>,
    /// The binary chunk, if there is one.
    pub(crate) bin: Option<Range<usize>>,
    /// Whether this is a GLB rather than bare JSON.
    pub(crate) is_glb: bool,
    /// Where the file ends by its own account. What lies before and behind the chunks above are
    /// chunks of other kinds.
    pub(crate) end: usize,
}

/// Opens a container like [`open`], for callers that do not report oddities.
///
/// # Errors
/// As [`open`].
pub(crate) fn parts(bytes: &[u8]) -> Result<Container, ErrorKind> {
    open(bytes, &mut Notes::default())
}

/// Finds the JSON and the binary chunk. Bytes without the magic number are taken for bare JSON.
///
/// # Errors
/// If the container's own lengths contradict each other or the size of the file.
pub(super) fn open(bytes: &[u8], notes: &mut Notes) -> Result<Container, ErrorKind> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { json: 0..bytes.len(), bin: None, is_glb: false, end: bytes.len() });
    }
    let word =
        |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (Some(version), Some(declared)) = (word(4), word(8)) else {
        return bad("GLB header", format!("has {} bytes of {HEADER}", bytes.len()));
    };
    if version == 1 {
        return Err(super::json::version_1("1"));
    }
    if version != 2 {
        return bad("GLB header", format!("version {version}; only 2 is read"));
    }
    let end = declared as usize;
    if end > bytes.len() {
        let len = bytes.len();
        return bad(
            "GLB header",
            format!("declares {end} bytes, but the file has {len}: it is truncated"),
        );
    }
    if end < HEADER + CHUNK_HEADER {
        return bad(
            "GLB header",
            format!("declares {end} bytes; at least {} are needed", HEADER + CHUNK_HEADER),
        );
    }
    if end < bytes.len() {
        let extra = bytes.len() - end;
        notes.push("GLB header", format!("{extra} bytes beyond the declared {end} are ignored"));
    }
    let mut json = None;
    let mut bin = None;
    let mut at = HEADER;
    let mut number = 0;
    while at < end {
        let item = format!("GLB chunk {number}");
        let header = (word(at), word(at + 4));
        let (Some(len), Some(kind)) = header else {
            return bad(item, "its header is cut off");
        };
        if at + CHUNK_HEADER > end {
            return bad(item, "its header is cut off");
        }
        let start = at + CHUNK_HEADER;
        let len = len as usize;
        if len > end - start {
            return bad(item, format!("declares {len} bytes, but {} are left", end - start));
        }
        let range = start..start + len;
        at = range.end;
        if !len.is_multiple_of(4) {
            notes.push(&item, format!("its length of {len} bytes is not a multiple of 4"));
            // Some writers leave the padding out, others do not count it.
            let padded = at.next_multiple_of(4);
            let begins = |at: usize| word(at + 4).is_some_and(|kind| [JSON, BIN].contains(&kind));
            if padded >= end || !begins(at) && begins(padded) {
                at = padded;
            }
        }
        match (number, kind) {
            (0, JSON) if len == 0 => return bad(item, "the JSON is empty"),
            (0, JSON) => {
                if bytes[range.clone()].ends_with(&[0]) {
                    notes.push(&item, "is padded with NUL; glTF pads JSON with spaces");
                }
                json = Some(range);
            }
            (0, _) => return bad(item, format!("is of type {kind:#010x}, expected JSON")),
            (1, BIN) => bin = Some(range),
            (_, JSON | BIN) => {
                return bad(item, "a file has one JSON chunk, first, and one BIN chunk, second");
            }
            _ => notes.push(item, format!("of unknown type {kind:#010x}, is ignored")),
        }
        number += 1;
    }
    match json {
        Some(json) => Ok(Container { json, bin, is_glb: true, end }),
        None => bad("GLB", "has no JSON chunk"),
    }
}

/// Where the JSON lies in a file that begins with `head`, without a look at what follows it; `None`
/// if that cannot be told. `head` is the container's header and that of its first chunk, or more.
pub(super) fn json_at(head: &[u8]) -> Option<Range<usize>> {
    let word = |at: usize| {
        let bytes = head.get(at..at + 4)?;
        Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    };
    let start = HEADER + CHUNK_HEADER;
    let (len, kind) = (word(HEADER)? as usize, word(HEADER + 4)?);
    (head.starts_with(MAGIC) && kind == JSON).then_some(start..start.checked_add(len)?)
}

/// Bytes that tell where the JSON lies.
pub(super) const HEAD: usize = HEADER + CHUNK_HEADER;

fn bad<T>(item: impl Into<String>, message: impl Into<String>) -> Result<T, ErrorKind> {
    Err(ErrorKind::invalid(item, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(version: u32, declared: Option<u32>, chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut out = Vec::new();
        out.extend(MAGIC);
        out.extend(version.to_le_bytes());
        let len: usize = chunks.iter().map(|c| CHUNK_HEADER + c.1.len()).sum();
        out.extend(declared.unwrap_or((HEADER + len) as u32).to_le_bytes());
        for (kind, data) in chunks {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(*data);
        }
        out
    }

    fn message(bytes: &[u8]) -> String {
        open(bytes, &mut Notes::default()).unwrap_err().to_string()
    }

    #[test]
    fn finds_both_chunks() {
        let bytes = glb(2, None, &[(JSON, b"{}  "), (BIN, b"12345678")]);
        let container = open(&bytes, &mut Notes::default()).unwrap();
        assert_eq!(&bytes[container.json], b"{}  ");
        assert_eq!(&bytes[container.bin.unwrap()], b"12345678");
    }

    #[test]
    fn every_truncation_is_an_error() {
        let bytes = glb(2, None, &[(JSON, b"{}  "), (BIN, b"12345678")]);
        for len in MAGIC.len()..bytes.len() {
            assert!(open(&bytes[..len], &mut Notes::default()).is_err(), "{len} bytes");
        }
    }

    #[test]
    fn lengths_are_named() {
        assert!(message(&glb(2, Some(99), &[(JSON, b"{}  ")])).contains("99 bytes"));
        assert!(message(&glb(1, None, &[(JSON, b"{}  ")])).contains("version 1"));
        assert!(message(&glb(2, None, &[(BIN, b"1234")])).contains("expected JSON"));
        let mut long = glb(2, None, &[(JSON, b"{}  ")]);
        long[HEADER] = 200;
        assert!(message(&long).contains("declares 200 bytes, but 4 are left"));
    }

    #[test]
    fn chunks_that_are_not_padded_or_whose_padding_is_not_counted_are_read_with_a_warning() {
        let left_out = glb(2, None, &[(JSON, b"{} "), (BIN, b"12345")]);
        let mut not_counted = glb(2, None, &[(JSON, b"{}  "), (BIN, b"12345678")]);
        not_counted[HEADER] = 3;
        not_counted[HEADER + CHUNK_HEADER + 4] = 5;
        for bytes in [left_out, not_counted] {
            let mut notes = Notes::default();
            let container = open(&bytes, &mut notes).unwrap();
            assert_eq!(&bytes[container.json], b"{} ");
            assert_eq!(&bytes[container.bin.unwrap()], b"12345");
            let warnings = notes.into_warnings();
            assert_eq!(warnings.len(), 2);
            assert!(warnings[1].to_string().contains("chunk 1: its length of 5 bytes"));
        }
        let padded = glb(2, None, &[(JSON, b"{}\0\0")]);
        let mut notes = Notes::default();
        open(&padded, &mut notes).unwrap();
        assert!(notes.into_warnings()[0].to_string().contains("padded with NUL"));
    }

    #[test]
    fn unknown_chunks_and_trailing_bytes_are_noted() {
        let mut bytes = glb(2, None, &[(JSON, b"{}  "), (0x1234, b"1234")]);
        bytes.push(7);
        let mut notes = Notes::default();
        let container = open(&bytes, &mut notes).unwrap();
        assert_eq!(container.bin, None);
        assert_eq!(notes.into_warnings().len(), 2);
    }
}
