//! URIs of buffers: embedded base64, and plain files beside the model.

use std::path::{Component, Path, PathBuf};

/// Where the bytes of a buffer are.
#[derive(Debug, PartialEq, Eq)]
pub enum UriSource {
    /// In the URI itself, decoded.
    Embedded(Vec<u8>),
    /// In a file, relative to the model's folder.
    File(PathBuf),
}

/// Reads a URI that the model itself names.
///
/// # Errors
/// As [`read_in`].
pub(crate) fn read(uri: &str) -> Result<UriSource, String> {
    read_in(Path::new(""), uri)
}

/// Reads a URI that a file in `folder` names, a path from the model's folder. The path that it gives
/// is from the model's folder too, without `.` and `..`. A file must lie in the model's folder or
/// below, so that opening an unknown model reads nothing else on the machine.
///
/// # Errors
/// Names the defect, and what to do instead.
pub fn read_in(folder: &Path, uri: &str) -> Result<UriSource, String> {
    if uri.len() >= 5 && uri.is_char_boundary(5) && uri[..5].eq_ignore_ascii_case("data:") {
        return embedded(&uri[5..]).map(UriSource::Embedded);
    }
    let shown = shorten(uri);
    if uri.is_empty() {
        return Err("its URI is empty".into());
    }
    // A colon before any slash ends a scheme, or a drive letter.
    let head = uri.split(['/', '\\']).next().unwrap_or_default();
    if head.contains(':') {
        return Err(format!(
            "its URI {shown:?} is not relative: nothing is fetched; put the file beside the model and name it"
        ));
    }
    // Some writers do not encode a percent sign.
    let decoded = percent_decode(uri).unwrap_or_else(|| uri.to_owned());
    if decoded.contains('\0') {
        return Err(format!("its URI {shown:?} has a NUL, which no name of a file has"));
    }
    inside(folder, &decoded).map(UriSource::File).ok_or_else(|| {
        format!("its URI {shown:?} leaves the folder of the model: put the file beside the model")
    })
}

/// The file that a URI names if its percent signs are not an encoding; `None` where that is the
/// same.
pub(super) fn literal(folder: &Path, uri: &str) -> Option<PathBuf> {
    let differs = percent_decode(uri).is_some_and(|decoded| decoded != uri);
    differs.then(|| inside(folder, uri)).flatten()
}

/// A path by names alone, from the model's folder; `None` if it leaves that folder or names nothing.
fn inside(folder: &Path, path: &str) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in folder.components().chain(Path::new(path).components()) {
        match part {
            Component::Normal(name) => out.push(name),
            Component::CurDir => {}
            Component::ParentDir if out.pop() => {}
            _ => return None,
        }
    }
    (!out.as_os_str().is_empty()).then_some(out)
}

/// The part of a data URI after `data:`.
fn embedded(rest: &str) -> Result<Vec<u8>, String> {
    let Some((head, payload)) = rest.split_once(',') else {
        return Err("its data URI has no comma before the data".into());
    };
    let (kind, is_base64) = match head.strip_suffix(";base64") {
        Some(kind) => (kind, true),
        None => (head, false),
    };
    let known = ["application/octet-stream", "application/gltf-buffer"];
    if !known.iter().any(|k| kind.eq_ignore_ascii_case(k)) {
        let kind = shorten(kind);
        return Err(format!("its data URI is of type {kind:?}; a buffer's is {}", known[0]));
    }
    if is_base64 {
        return base64(payload.as_bytes());
    }
    percent_bytes(payload).ok_or_else(|| "its data URI is not valid percent-encoding".into())
}

/// Decodes base64 (RFC 4648, standard alphabet, padded or not).
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let text = match text {
        [rest @ .., b'=', b'='] | [rest @ .., b'='] => rest,
        rest => rest,
    };
    if text.len() % 4 == 1 {
        return Err(format!("its base64 ends early, after {} characters", text.len()));
    }
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => u8::MAX,
    };
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for (i, group) in text.chunks(4).enumerate() {
        let mut bits = 0u32;
        for (j, &c) in group.iter().enumerate() {
            let d = digit(c);
            if d == u8::MAX {
                let c = char::from(c);
                return Err(format!("its base64 has {c:?} at character {}", i * 4 + j));
            }
            bits |= u32::from(d) << (18 - 6 * j);
        }
        let bytes = [(bits >> 16) as u8, (bits >> 8) as u8, bits as u8];
        out.extend_from_slice(&bytes[..group.len() - 1]);
    }
    Ok(out)
}

/// A text whose percent signs stand before two digits; `None` if one does not, or it is no UTF-8.
fn percent_decode(text: &str) -> Option<String> {
    String::from_utf8(percent_bytes(text)?).ok()
}

fn percent_bytes(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        if b != b'%' {
            out.push(b);
            continue;
        }
        let hex = |b: u8| char::from(b).to_digit(16);
        out.push((hex(bytes.next()?)? * 16 + hex(bytes.next()?)?) as u8);
    }
    Some(out)
}

/// The start of a text, for a message.
pub(super) fn shorten(text: &str) -> String {
    const MOST: usize = 80;
    if text.chars().count() <= MOST {
        return text.to_owned();
    }
    text.chars().take(MOST).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(uri: &str) -> PathBuf {
        match read(uri).unwrap() {
            UriSource::File(path) => path,
            UriSource::Embedded(_) => panic!("embedded"),
        }
    }

    #[test]
    fn files_are_percent_decoded() {
        assert_eq!(file("a%20b/%C3%A9.bin"), PathBuf::from("a b/é.bin"));
        assert_eq!(file("./x.bin"), PathBuf::from("x.bin"));
        assert_eq!(file("a/./../x.bin"), PathBuf::from("x.bin"));
        assert_eq!(file("a/b:c.bin"), PathBuf::from("a/b:c.bin"));
    }

    #[test]
    fn percent_signs_that_encode_nothing_are_part_of_the_name() {
        assert_eq!(file("100%.bin"), PathBuf::from("100%.bin"));
        assert_eq!(file("50%of.bin"), PathBuf::from("50%of.bin"));
        assert_eq!(file("%ff.bin"), PathBuf::from("%ff.bin"), "no UTF-8");
        // What could be either is first looked for as the standard has it.
        assert_eq!(file("a%20b.bin"), PathBuf::from("a b.bin"));
        let literal = |uri| literal(Path::new(""), uri);
        assert_eq!(literal("a%20b.bin"), Some(PathBuf::from("a%20b.bin")));
        assert_eq!(literal("100%.bin"), None);
        assert_eq!(literal("../a%20b.bin"), None);
    }

    #[test]
    fn dots_stay_within_the_outermost_folder() {
        assert_eq!(file("a/../x.bin"), PathBuf::from("x.bin"));
        assert_eq!(file("a/./b/../../x.bin"), PathBuf::from("x.bin"));
        let from = |uri| read_in(Path::new("tiles/one"), uri);
        assert_eq!(from("../x.bin"), Ok(UriSource::File("tiles/x.bin".into())));
        assert_eq!(from("x.bin"), Ok(UriSource::File("tiles/one/x.bin".into())));
        assert_eq!(from("../../y/x.bin"), Ok(UriSource::File("y/x.bin".into())));
        assert!(from("../../../x.bin").is_err());
        assert!(from("/x.bin").is_err());
    }

    #[test]
    fn nothing_outside_the_folder_is_named() {
        for uri in [
            "",
            ":",
            "http://a/b.bin",
            "file:///etc/passwd",
            "/etc/passwd",
            "../x.bin",
            "a/../../x",
            "%2e%2e/x",
            "C:\\x",
            "%00",
            "a/..",
        ] {
            assert!(read(uri).is_err(), "{uri}");
        }
    }

    #[test]
    fn base64_of_every_length() {
        let data = |s: &str| read(&format!("data:application/octet-stream;base64,{s}"));
        for (text, bytes) in [
            ("", &b""[..]),
            ("AA==", b"\0"),
            ("AA", b"\0"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYmE=", b"fooba"),
            ("+/+/", b"\xfb\xff\xbf"),
        ] {
            assert_eq!(data(text), Ok(UriSource::Embedded(bytes.to_vec())), "{text}");
        }
        for text in ["A", "A===", "Zm9vA", "Zm-v", "Zm9v\n"] {
            assert!(data(text).is_err(), "{text}");
        }
        assert_eq!(
            read("data:application/gltf-buffer,%00a%fF"),
            Ok(UriSource::Embedded(b"\0a\xff".to_vec()))
        );
        assert!(read("data:application/gltf-buffer,%0").is_err());
        assert!(read("data:").is_err());
        assert!(read("data:application/octet-stream;;base64,AA==").is_err());
        assert!(read("data:text/plain;base64,AA==").is_err());
        assert!(read("DATA:Application/Octet-Stream;base64,AA==").is_ok());
    }
}
