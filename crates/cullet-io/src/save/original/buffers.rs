//! All buffers of a file as one, which a GLB holds.

use std::borrow::Cow;
use std::path::Path;

use super::object::{Object, list};
use crate::ErrorKind;
use crate::beside::{Beside, Missing};
use crate::gltf::{UriSource, read_uri};

/// Numbers of all types begin at multiples of this.
const STEP: usize = 8;

/// Where the bytes of a buffer have come to.
#[derive(Clone, Copy)]
struct Place {
    buffer: usize,
    base: usize,
}

/// The bytes of all buffers, which buffer 0 of the file has from now on; views name it. A file
/// whose only bytes are those of its binary chunk stays as it is. Buffers without bytes, which
/// stand for what is decompressed, stay, behind it.
pub(super) fn join(
    root: &mut Object<'_>,
    mut chunk: Option<Vec<u8>>,
    is_glb: bool,
    beside: Beside<'_>,
) -> Result<Vec<u8>, ErrorKind> {
    let texts = list(root, "buffers")?;
    let items: Vec<Object<'_>> =
        texts.iter().map(|text| Object::parse(text, "buffer")).collect::<Result<_, _>>()?;
    let holds_chunk = |i: usize| i == 0 && is_glb && items[0].get("uri").is_none();
    let mut bin = Vec::new();
    let mut places = Vec::new();
    let mut empty = Vec::new();
    let mut first = None;
    for (i, item) in items.iter().enumerate() {
        let name = format!("buffer {i}");
        let length = item.number("byteLength");
        let length = length.ok_or_else(|| ErrorKind::invalid(&name, "has no byteLength"))?;
        let is_fallback = item.get("extensions").is_some_and(|text| text.contains("\"fallback\""));
        let bytes = match (item.string("uri"), chunk.take_if(|_| holds_chunk(i))) {
            (Some(uri), _) => match read(&uri, length, beside, &name) {
                // Nobody who can read what is packed needs it.
                Err(_) if is_fallback => None,
                read => Some(read?),
            },
            (None, chunk) => chunk,
        };
        let Some(mut bytes) = bytes else {
            places.push(Place { buffer: 1 + empty.len(), base: 0 });
            let mut placeholder = Object::parse(&texts[i], "buffer")?;
            placeholder.remove("uri");
            empty.push(Cow::Owned(placeholder.to_text()));
            continue;
        };
        if bytes.len() < length {
            let message = format!("declares {length} bytes, but there are {}", bytes.len());
            return Err(ErrorKind::invalid(name, message));
        }
        bytes.truncate(length);
        bin.resize(bin.len().next_multiple_of(STEP), 0);
        places.push(Place { buffer: 0, base: bin.len() });
        if bin.is_empty() {
            bin = bytes;
        } else {
            bin.extend(bytes);
        }
        first.get_or_insert(i);
    }
    let Some(first) = first else {
        // Nothing that a view could be of; a chunk that no buffer is of is nobody's.
        if !empty.is_empty() {
            return Err(ErrorKind::invalid("buffers", "have no bytes"));
        }
        return Ok(Vec::new());
    };
    let stays = places.iter().enumerate().all(|(i, p)| (p.buffer, p.base) == (i, 0));
    let mut whole = Object::parse(&texts[first], "buffer")?;
    whole.remove("uri");
    let mut buffers = vec![Cow::Owned(whole.to_text())];
    buffers.extend(empty);
    if !stays {
        let mut views = list(root, "bufferViews")?;
        for (v, view) in views.iter_mut().enumerate() {
            *view = Cow::Owned(moved(view, &places, &format!("bufferView {v}"))?);
        }
        root.set_list("bufferViews", &views);
    }
    root.set_list("buffers", &buffers);
    Ok(bin)
}

/// A view, or what an extension has in its place, of a buffer that has moved.
fn moved(text: &str, places: &[Place], item: &str) -> Result<String, ErrorKind> {
    let mut view = Object::parse(text, item)?;
    if view.get("buffer").is_some() {
        let place = view.number("buffer").and_then(|b| places.get(b)).copied();
        let place = place.ok_or_else(|| ErrorKind::invalid(item, "names no buffer"))?;
        let offset = view.number("byteOffset").unwrap_or(0) + place.base;
        view.set("buffer", place.buffer.to_string());
        if offset > 0 {
            view.set("byteOffset", offset.to_string());
        }
    }
    if view.get("extensions").is_some() {
        // Compression: its bytes are in a buffer too.
        view.change("extensions", &mut |all| {
            let names: Vec<String> = all.members().map(|(name, _)| name.to_owned()).collect();
            for name in names {
                let own = all.get(&name).filter(|text| text.starts_with('{'));
                if let Some(own) = own.map(|text| moved(text, places, item)).transpose()? {
                    all.set(&name, own);
                }
            }
            Ok(())
        })?;
    }
    Ok(view.to_text())
}

/// The bytes that a URI of a buffer stands for.
fn read(uri: &str, length: usize, beside: Beside<'_>, item: &str) -> Result<Vec<u8>, ErrorKind> {
    let wrong = |message: String| ErrorKind::invalid(item, message);
    match read_uri(uri).map_err(wrong)? {
        UriSource::Embedded(bytes) => Ok(bytes),
        UriSource::File(path) => {
            let most = length as u64;
            let (bytes, _) = beside.read(&path, most).map_err(|e| wrong(missing(&path, &e)))?;
            Ok(bytes.into_owned())
        }
    }
}

/// Why a file is not there, in words.
pub(super) fn missing(path: &Path, why: &Missing) -> String {
    let shown = path.display();
    match why {
        Missing::Absent => format!("{shown} is not there"),
        Missing::NoFile => format!("{shown} is no file"),
        Missing::Unread(e) => format!("{shown} cannot be read: {e}"),
    }
}

/// Says how long buffer 0 has become, which there is from now on.
pub(super) fn set_length(root: &mut Object<'_>, length: usize) -> Result<(), ErrorKind> {
    let mut buffers = list(root, "buffers")?;
    let text = buffers.first().map_or_else(|| "{}".to_owned(), |text| text.clone().into_owned());
    let mut first = Object::parse(&text, "buffer 0")?;
    first.set("byteLength", length.to_string());
    let first = Cow::Owned(first.to_text());
    match buffers.first_mut() {
        Some(place) => *place = first,
        None => buffers.push(first),
    }
    root.set_list("buffers", &buffers);
    Ok(())
}
