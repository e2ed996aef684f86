//! Files that a tileset names.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use cullet_io::ErrorKind;
use cullet_io::reader::{Beside, Missing};
use cullet_io::reader::{UriSource, read_uri_in};

/// The most bytes of a tileset's JSON, or of a tile.
const LARGEST: u64 = 1 << 31;

/// The path that a file in `folder` names, from the folder of the outermost tileset, in which or
/// below which it lies.
pub(super) fn local(folder: &Path, text: &str) -> Result<PathBuf, ErrorKind> {
    let invalid = |message| ErrorKind::invalid(format!("content {text:?}"), message);
    // What follows a question mark is for servers.
    let plain = text.split('?').next().unwrap_or_default();
    match read_uri_in(folder, plain).map_err(invalid)? {
        UriSource::File(path) => Ok(path),
        _ => Err(invalid("data URIs are not read as tiles; write the tile to a file".into())),
    }
}

/// The bytes of a file, which servers keep packed by gzip.
fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>, ErrorKind> {
    if !bytes.starts_with(b"\x1f\x8b") {
        return Ok(bytes);
    }
    let mut all = Vec::new();
    let read = MultiGzDecoder::new(&bytes[..]).take(LARGEST + 1).read_to_end(&mut all);
    match read {
        Ok(size) if size as u64 <= LARGEST => Ok(all),
        Ok(size) => Err(ErrorKind::OverLimit {
            item: "bytes once unpacked".to_owned(),
            count: size as u64,
            limit: LARGEST,
        }),
        Err(e) => {
            Err(ErrorKind::invalid("gzip", format!("it is packed and cannot be unpacked: {e}")))
        }
    }
}

/// The bytes of a file that a tileset names, unpacked.
pub(super) fn file(path: &Path, beside: Beside<'_>) -> Result<Vec<u8>, ErrorKind> {
    let item = || path.display().to_string();
    match beside.read(path, LARGEST) {
        Ok((bytes, size)) if size <= LARGEST => {
            unpacked(bytes.into_owned()).map_err(|e| within(path, e))
        }
        Ok((_, size)) => Err(ErrorKind::OverLimit {
            item: format!("bytes of {}", item()),
            count: size,
            limit: LARGEST,
        }),
        Err(Missing::Absent) => Err(ErrorKind::invalid(
            item(),
            "it is named by the tileset and is missing; put it beside the tileset",
        )),
        Err(Missing::NoFile) => Err(ErrorKind::invalid(item(), "it is no file")),
        Err(Missing::Unread(error)) => Err(within(path, ErrorKind::Io(error))),
    }
}

/// The same error, with the file that it is in.
pub(super) fn within(path: &Path, error: ErrorKind) -> ErrorKind {
    let path = path.display();
    match error {
        ErrorKind::Invalid { item, message } => {
            ErrorKind::Invalid { item: format!("{path}, {item}"), message }
        }
        ErrorKind::OverLimit { item, count, limit } => {
            ErrorKind::OverLimit { item: format!("{path}, {item}"), count, limit }
        }
        ErrorKind::Unsupported(message) => ErrorKind::Unsupported(format!("{path}: {message}")),
        ErrorKind::Io(error) => {
            ErrorKind::Io(std::io::Error::new(error.kind(), format!("{path}: {error}")))
        }
        // The enum may gain kinds: they keep their words.
        other => ErrorKind::Unsupported(format!("{path}: {other}")),
    }
}
