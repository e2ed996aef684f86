//! Buffers and views of them: read, checked against each other, decompressed when first used.

use std::cell::{Cell, OnceCell};
use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::json::{self, BufferItem, Integer, MeshoptItem, Root, ViewItem};
use super::meshopt::{self, Filter, Mode};
use super::uri::{self, UriSource};
use crate::ErrorKind;
use crate::beside::{Beside, Missing};
use crate::json::Json;

/// The bytes of a buffer.
#[derive(Debug)]
enum Data {
    /// The file gives none: a placeholder.
    Absent,
    /// The binary chunk of the GLB.
    Chunk(Range<usize>),
    /// A file or data URI, by its number in `Buffers::owned`.
    Owned(usize),
}

#[derive(Debug)]
struct Buffer {
    data: Data,
    len: usize,
}

/// How a view is compressed.
#[derive(Debug)]
struct Compressed {
    buffer: usize,
    range: Range<usize>,
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Filter,
}

/// A view whose range is known to lie in its buffer.
#[derive(Debug)]
pub(super) struct View {
    buffer: usize,
    range: Range<usize>,
    /// Bytes from element to element, where the file says.
    pub(super) stride: Option<usize>,
    compressed: Option<Compressed>,
    decoded: OnceCell<Vec<u8>>,
}

impl View {
    /// First byte in the buffer.
    pub(super) fn start(&self) -> usize {
        self.range.start
    }

    /// How many bytes.
    pub(super) fn len(&self) -> usize {
        self.range.len()
    }
}

/// All buffers and views of a document.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    file: &'a [u8],
    owned: Vec<Vec<u8>>,
    buffers: Vec<Buffer>,
    pub(super) views: Vec<View>,
    /// How many bytes may yet be decompressed.
    budget: Cell<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers that are needed and checks all views. External files are `beside`.
    ///
    /// # Errors
    /// If a buffer is missing or short, or a view does not fit.
    pub(super) fn read(
        root: &Root<'_>,
        file: &'a [u8],
        bin: Option<Range<usize>>,
        is_glb: bool,
        beside: Beside<'_>,
    ) -> Result<Self, ErrorKind> {
        let mut owned = Vec::new();
        let items = views(root)?;
        let fallback = fallback(&items);
        let mut files: Vec<(PathBuf, usize)> = Vec::new();
        let mut buffers = Vec::new();
        for (i, raw) in json::all(&root.buffers).iter().enumerate() {
            let item: BufferItem<'_> = json::item(*raw, "buffer", i)?;
            let name = || format!("buffer {i}");
            let wrong = |message: String| ErrorKind::invalid(name(), message);
            let len = item.byte_length.index();
            if len == 0 {
                return Err(wrong("its byteLength is 0".into()));
            }
            let data = match item.uri.as_deref() {
                _ if fallback.contains(&i) => Data::Absent,
                Some(text) => {
                    Data::Owned(match uri::read_in(beside.inner(), text).map_err(wrong)? {
                        UriSource::Embedded(bytes) => {
                            owned.push(bytes);
                            owned.len() - 1
                        }
                        UriSource::File(path) => {
                            // A file that several buffers name is held once, as long as the longest.
                            let number = match files.iter().find(|(known, _)| *known == path) {
                                Some(&(_, number)) => number,
                                None => {
                                    files.push((path.clone(), owned.len()));
                                    owned.push(Vec::new());
                                    owned.len() - 1
                                }
                            };
                            if owned[number].len() < len {
                                let literal = uri::literal(beside.inner(), text);
                                owned[number] = read_file(beside, (&path, literal), len, &name())?;
                            }
                            number
                        }
                    })
                }
                None if is_glb && i == 0 => match &bin {
                    Some(range) => Data::Chunk(range.clone()),
                    None => return Err(wrong("the file has no binary chunk for it".into())),
                },
                None => Data::Absent,
            };
            let actual = match &data {
                Data::Absent => len,
                Data::Chunk(range) => range.len(),
                Data::Owned(number) => owned[*number].len(),
            };
            if actual < len {
                return Err(wrong(format!("declares {len} bytes, but there are {actual}")));
            }
            buffers.push(Buffer { data, len });
        }
        let stored = file.len() + owned.iter().map(Vec::len).sum::<usize>();
        let mut views = Vec::new();
        for (i, item) in items.iter().enumerate() {
            views.push(view(item, i, &buffers)?);
        }
        let budget = Cell::new(stored.saturating_mul(meshopt::MOST_EXPANSION));
        Ok(Self { file, owned, buffers, views, budget })
    }

    /// The bytes of a buffer.
    fn bytes(&self, buffer: usize) -> Option<&[u8]> {
        let Buffer { data, len } = &self.buffers[buffer];
        match data {
            Data::Absent => None,
            Data::Chunk(range) => self.file.get(range.clone())?.get(..*len),
            Data::Owned(number) => self.owned[*number].get(..*len),
        }
    }

    /// The bytes of a view, decompressed if need be.
    ///
    /// # Errors
    /// If its buffer has no bytes in this file, or its compressed form is damaged.
    pub(super) fn view(&self, index: usize) -> Result<&[u8], ErrorKind> {
        let name = || format!("bufferView {index}");
        let view = &self.views[index];
        let absent = |buffer: usize| {
            ErrorKind::invalid(name(), format!("its buffer {buffer} has no data in this file"))
        };
        let Some(c) = &view.compressed else {
            let bytes = self.bytes(view.buffer).ok_or_else(|| absent(view.buffer))?;
            return Ok(&bytes[view.range.clone()]);
        };
        if let Some(decoded) = view.decoded.get() {
            return Ok(decoded);
        }
        let bytes = &self.bytes(c.buffer).ok_or_else(|| absent(c.buffer))?[c.range.clone()];
        let size = c.count * c.stride;
        let Some(left) = self.budget.get().checked_sub(size) else {
            // Only views that share their compressed bytes can come here.
            return Err(ErrorKind::OverLimit {
                item: format!("bytes decompressed by {}", name()),
                count: size as u64,
                limit: self.budget.get() as u64,
            });
        };
        self.budget.set(left);
        let decoded = meshopt::decode(bytes, c.mode, c.filter, c.count, c.stride)
            .map_err(|message| ErrorKind::invalid(name(), message))?;
        Ok(view.decoded.get_or_init(|| decoded))
    }
}

/// The views of a document, unchecked.
fn views<'a>(root: &Root<'a>) -> Result<Vec<ViewItem<'a>>, ErrorKind> {
    let views = json::all(&root.buffer_views).iter().enumerate();
    views.map(|(i, json)| json::item(*json, "bufferView", i)).collect()
}

impl<'a> ViewItem<'a> {
    /// How it is compressed, and by which extension: both have the same form.
    fn compression(&self) -> Option<(&MeshoptItem<'a>, &'static str)> {
        let khronos = self.meshopt_of_khronos.as_ref().map(|c| (c, "KHR_meshopt_compression"));
        self.meshopt.as_ref().map(|c| (c, "EXT_meshopt_compression")).or(khronos)
    }
}

/// Buffers that only readers without decompression need: every view of them has compressed bytes
/// elsewhere.
fn fallback(views: &[ViewItem<'_>]) -> HashSet<usize> {
    let (packed, plain): (Vec<_>, Vec<_>) = views.iter().partition(|v| v.compression().is_some());
    let mut fallback: HashSet<usize> = packed.iter().map(|v| v.buffer.index()).collect();
    plain.iter().for_each(|v| _ = fallback.remove(&v.buffer.index()));
    for (c, _) in packed.iter().filter_map(|v| v.compression()) {
        fallback.remove(&c.buffer.index());
    }
    fallback
}

/// The files that the buffers of a document name. What is wrong with a buffer is left to who loads
/// the model.
pub(super) fn files(root: &Root<'_>) -> Vec<PathBuf> {
    let fallback = views(root).map(|items| fallback(&items)).unwrap_or_default();
    let buffers = json::all(&root.buffers).iter().enumerate();
    let file = |(i, raw): (usize, &Json<'_>)| {
        let item: BufferItem<'_> = json::item(*raw, "buffer", i).ok()?;
        match uri::read(item.uri.as_deref()?).ok()? {
            UriSource::File(path) => Some(path),
            UriSource::Embedded(_) => None,
        }
    };
    buffers.filter(|(i, _)| !fallback.contains(i)).filter_map(file).collect()
}

/// The first `len` bytes of a file: of the first of two paths, or of the other where that is not
/// there.
fn read_file(
    beside: Beside<'_>,
    (path, literal): (&Path, Option<PathBuf>),
    len: usize,
    item: &str,
) -> Result<Vec<u8>, ErrorKind> {
    let shown = path.display();
    let wrong = |message: String| ErrorKind::invalid(item, message);
    let instead = "or convert the model to .glb, which holds all it needs";
    let read = beside.read(path, len as u64).or_else(|missing| match (&missing, literal) {
        (Missing::Absent, Some(literal)) => beside.read(&literal, len as u64).map_err(|_| missing),
        _ => Err(missing),
    });
    let (bytes, has) = read.map_err(|missing| {
        wrong(match (missing, beside) {
            (Missing::Absent, Beside::Folder(_) | Beside::Below(..)) => {
                format!("{shown} is not there: put it where the model expects it, {instead}")
            }
            (Missing::Absent, Beside::Given(_)) => {
                format!("{shown} is missing: give it together with the model, {instead}")
            }
            (Missing::NoFile, _) => format!("{shown} is not a file"),
            (Missing::Unread(e), _) => format!("{shown} cannot be read: {e}"),
        })
    })?;
    if has < len as u64 {
        return Err(wrong(format!("declares {len} bytes, but {shown} has {has}")));
    }
    Ok(bytes.into_owned())
}

/// A range inside a buffer, if it fits.
fn range(
    offset: Option<Integer>,
    len: Integer,
    buffer: usize,
    buffers: &[Buffer],
) -> Result<Range<usize>, String> {
    let Some(whole) = buffers.get(buffer) else {
        return Err(format!("names buffer {buffer} of {}", buffers.len()));
    };
    let offset = offset.map_or(0, |o| o.0);
    if len.0 == 0 {
        return Err("its byteLength is 0".into());
    }
    match offset.checked_add(len.0) {
        Some(end) if end <= whole.len as u64 => Ok(offset as usize..end as usize),
        _ => Err(format!(
            "{} bytes at {offset} do not fit buffer {buffer} of {} bytes",
            len.0, whole.len
        )),
    }
}

fn view(item: &ViewItem<'_>, index: usize, buffers: &[Buffer]) -> Result<View, ErrorKind> {
    // The target of index data; only vertex data may be strided.
    const ELEMENT_ARRAY: u64 = 34963;
    let wrong = |message: String| ErrorKind::invalid(format!("bufferView {index}"), message);
    let buffer = item.buffer.index();
    let own = range(item.byte_offset, item.byte_length, buffer, buffers).map_err(wrong)?;
    if let Some(Integer(stride)) = item.byte_stride {
        if !(4..=252).contains(&stride) || stride % 4 != 0 {
            return Err(wrong(format!(
                "its byteStride is {stride}; it must be a multiple of 4 from 4 to 252"
            )));
        }
        if stride > item.byte_length.0 {
            let len = item.byte_length.0;
            return Err(wrong(format!("its byteStride of {stride} exceeds its {len} bytes")));
        }
        if item.target == Some(Integer(ELEMENT_ARRAY)) {
            return Err(wrong(format!(
                "has a byteStride of {stride}, which index data must not have: remove it"
            )));
        }
    }
    let compressed = match item.compression() {
        Some((c, by)) => Some(
            compressed(c, buffers, own.len(), item.byte_stride)
                .map_err(|message| wrong(format!("{by}: {message}")))?,
        ),
        None => None,
    };
    Ok(View {
        buffer,
        range: own,
        stride: item.byte_stride.map(Integer::index),
        compressed,
        decoded: OnceCell::new(),
    })
}

fn compressed(
    c: &MeshoptItem<'_>,
    buffers: &[Buffer],
    len: usize,
    view_stride: Option<Integer>,
) -> Result<Compressed, String> {
    let buffer = c.buffer.index();
    let range = range(c.byte_offset, c.byte_length, buffer, buffers)?;
    let mode = match &*c.mode {
        "ATTRIBUTES" => Mode::Attributes,
        "TRIANGLES" => Mode::Triangles,
        "INDICES" => Mode::Indices,
        other => return Err(format!("mode {:?} is not known", uri::shorten(other))),
    };
    let filter = match c.filter.as_deref() {
        None | Some("NONE") => Filter::None,
        Some("OCTAHEDRAL") => Filter::Octahedral,
        Some("QUATERNION") => Filter::Quaternion,
        Some("EXPONENTIAL") => Filter::Exponential,
        Some(other) => return Err(format!("filter {:?} is not known", uri::shorten(other))),
    };
    let (stride, count) = (c.byte_stride.index(), c.count.index());
    if view_stride.is_some_and(|s| s != c.byte_stride) {
        return Err(format!("its byteStride is {stride}, not that of the view"));
    }
    if stride.checked_mul(count) != Some(len) {
        return Err(format!("{count} elements of {stride} bytes do not fill the view of {len}"));
    }
    meshopt::check(mode, filter, count, stride, range.len())?;
    Ok(Compressed { buffer, range, stride, count, mode, filter })
}
