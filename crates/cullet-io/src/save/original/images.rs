//! Images of other files, taken in.

use std::borrow::Cow;

use super::buffers::missing;
use super::object::{Object, list};
use crate::beside::Beside;
use crate::gltf::{UriSource, read_uri};
use crate::{ErrorKind, Warning};

/// The first bytes of each kind of image, where they begin, and its name.
const KINDS: [(usize, &[u8], &str); 6] = [
    (0, b"\x89PNG\r\n\x1a\n", "image/png"),
    (0, b"\xff\xd8\xff", "image/jpeg"),
    (8, b"WEBP", "image/webp"),
    (0, b"\xabKTX 20\xbb\r\n\x1a\n", "image/ktx2"),
    (0, b"DDS ", "image/vnd-ms.dds"),
    (4, b"ftypavif", "image/avif"),
];

/// Puts images that lie in other files at the end of the buffer. One that is not there, or of no
/// known kind, stays where it is said to be, with a warning.
pub(super) fn embed(
    root: &mut Object<'_>,
    bin: &mut Vec<u8>,
    beside: Beside<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<(), ErrorKind> {
    let mut images = list(root, "images")?;
    let mut views = list(root, "bufferViews")?;
    let before = views.len();
    for (i, text) in images.iter_mut().enumerate() {
        let own = text.clone().into_owned();
        let mut image = Object::parse(&own, &format!("image {i}"))?;
        let Some(uri) = image.string("uri").filter(|uri| !uri.starts_with("data:")) else {
            continue;
        };
        let (bytes, kind) = match read(&uri, beside) {
            Ok(found) => found,
            Err(why) => {
                let message = format!("stays outside of the file, as {uri:?}: {why}");
                warnings.push(Warning { item: format!("image {i}"), message });
                continue;
            }
        };
        // Files of images are of no even length, and what follows may be numbers.
        bin.resize(bin.len().next_multiple_of(8), 0);
        let (start, length) = (bin.len(), bytes.len());
        bin.extend(bytes);
        image.remove("uri");
        image.set("bufferView", views.len().to_string());
        image.set("mimeType", format!("\"{kind}\""));
        *text = Cow::Owned(image.to_text());
        views.push(Cow::Owned(format!(
            r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}}}"#
        )));
    }
    if views.len() > before {
        root.set_list("images", &images);
        root.set_list("bufferViews", &views);
    }
    Ok(())
}

fn read(uri: &str, beside: Beside<'_>) -> Result<(Vec<u8>, &'static str), String> {
    let path = match read_uri(uri)? {
        UriSource::File(path) => path,
        UriSource::Embedded(_) => return Err("it is embedded already".to_owned()),
    };
    let (bytes, _) = beside.read(&path, u32::MAX.into()).map_err(|e| missing(&path, &e))?;
    let kind = KINDS
        .iter()
        .find(|(at, first, _)| bytes.get(*at..).is_some_and(|bytes| bytes.starts_with(first)));
    match kind {
        Some((_, _, kind)) => Ok((bytes.into_owned(), kind)),
        None => Err("of no kind of image that is known".to_owned()),
    }
}
