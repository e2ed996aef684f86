//! Reading a file block by block, so that it is never held whole beside what is made from it.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::ErrorKind;

/// Bytes read at once: few calls, little memory, and a processor's cache holds it.
const BLOCK: usize = 256 * 1024;

#[derive(Debug)]
enum Bytes<'a> {
    Memory(&'a [u8]),
    File(File),
}

/// The bytes of a model, in a file or in memory; both are read by the same code.
#[derive(Debug)]
pub struct Source<'a> {
    bytes: Bytes<'a>,
    size: u64,
    /// Bytes of the file before the first.
    begin: u64,
    /// Bytes read at once.
    block: usize,
}

impl Source<'static> {
    /// A file, which must be a regular one: a device or a pipe may never end.
    pub fn open(path: &Path) -> Result<Self, ErrorKind> {
        let kind = std::fs::metadata(path)?;
        if !kind.is_file() {
            let what =
                if kind.is_dir() { "a folder: name a file in it" } else { "not a regular file" };
            return Err(ErrorKind::Unsupported(format!("it is {what}")));
        }
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        Ok(Self { bytes: Bytes::File(file), size, begin: 0, block: BLOCK })
    }
}

impl<'a> Source<'a> {
    /// Bytes from the start by which a kind of file is recognised.
    pub const HEAD: usize = 64 * 1024;

    /// Bytes in memory.
    pub fn memory(bytes: &'a [u8]) -> Self {
        Self { bytes: Bytes::Memory(bytes), size: bytes.len() as u64, begin: 0, block: BLOCK }
    }

    /// Bytes in memory that are read in blocks of `block` bytes.
    #[cfg(test)]
    pub fn in_blocks(bytes: &'a [u8], block: usize) -> Self {
        Self { block, ..Self::memory(bytes) }
    }

    /// Without so many bytes at the start, of those that there are.
    #[cfg(not(target_family = "wasm"))]
    pub fn after(self, count: u64) -> Self {
        let count = count.min(self.size);
        Self { size: self.size - count, begin: self.begin + count, ..self }
    }

    /// How many bytes there are. What a file gains later is not read.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// The first bytes, `most` or all.
    pub fn head(&self, most: usize) -> Result<Vec<u8>, ErrorKind> {
        let mut head = Vec::new();
        self.append(0, most, &mut head)?;
        Ok(head)
    }

    /// All bytes, for formats that refer back and forth.
    pub fn into_bytes(self) -> Result<Vec<u8>, ErrorKind> {
        let all = usize::try_from(self.size).unwrap_or(usize::MAX);
        self.head(all)
    }

    /// Appends the bytes from `offset` on, `most` or as many as there are.
    ///
    /// # Errors
    /// If they cannot be read, as when the file became shorter meanwhile.
    fn append(&self, offset: u64, most: usize, out: &mut Vec<u8>) -> Result<(), ErrorKind> {
        let left = usize::try_from(self.size.saturating_sub(offset)).unwrap_or(usize::MAX);
        let count = left.min(most);
        out.reserve_exact(count);
        let offset = self.begin.saturating_add(offset);
        match &self.bytes {
            Bytes::Memory(bytes) => {
                if let Some(from) = usize::try_from(offset).ok().and_then(|at| bytes.get(at..)) {
                    out.extend_from_slice(&from[..count]);
                }
            }
            Bytes::File(file) => {
                let start = out.len();
                out.resize(start + count, 0);
                let mut file: &File = file;
                file.seek(SeekFrom::Start(offset))?;
                file.read_exact(&mut out[start..])?;
            }
        }
        Ok(())
    }

    /// Hands the first `size` bytes to `visit`, block by block; a block that cannot be read ends
    /// it.
    pub fn scan(&self, size: u64, mut visit: impl FnMut(&[u8])) {
        let (mut at, mut block) = (0, Vec::new());
        while at < size.min(self.size) {
            block.clear();
            let most = usize::try_from(size - at).unwrap_or(usize::MAX).min(self.block);
            if self.append(at, most, &mut block).is_err() {
                return;
            }
            visit(&block);
            at += block.len() as u64;
        }
    }
}

/// A stretch of a source that is held in memory and moves forward through it.
#[derive(Debug)]
pub(crate) struct Window<'a> {
    source: Source<'a>,
    held: Vec<u8>,
    /// Where the bytes held begin.
    base: u64,
}

impl<'a> Window<'a> {
    pub(crate) fn new(source: Source<'a>) -> Self {
        Self { source, held: Vec::new(), base: 0 }
    }

    pub(crate) fn source(&self) -> &Source<'a> {
        &self.source
    }

    pub(crate) fn into_source(self) -> Source<'a> {
        self.source
    }

    #[inline]
    pub(crate) fn held(&self) -> &[u8] {
        &self.held
    }

    /// Where the bytes held begin.
    #[inline]
    pub(crate) fn base(&self) -> u64 {
        self.base
    }

    /// Where the bytes held end.
    pub(crate) fn end(&self) -> u64 {
        self.base + self.held.len() as u64
    }

    /// Whether nothing follows the bytes held.
    pub(crate) fn is_last(&self) -> bool {
        self.end() >= self.source.size
    }

    /// Forgets what is held, and goes to a place.
    pub(crate) fn go_to(&mut self, offset: u64) {
        self.held.clear();
        self.base = offset.min(self.source.size);
    }

    /// Forgets the first bytes held.
    pub(crate) fn forget(&mut self, count: usize) {
        let kept = self.held.len() - count;
        self.held.copy_within(count.., 0);
        self.held.truncate(kept);
        self.base += count as u64;
    }

    /// Holds at least a block more, as far as there is one: as much again as is held, so that what
    /// does not fit a block is read in few steps.
    pub(crate) fn extend(&mut self) -> Result<(), ErrorKind> {
        let most = self.source.block.max(self.held.len());
        self.source.append(self.end(), most, &mut self.held)
    }
}

/// A cursor over the records of a binary file.
#[derive(Debug)]
pub(crate) struct Records<'a> {
    window: Window<'a>,
    at: usize,
}

impl<'a> Records<'a> {
    /// From a place on; one beyond the end is the end.
    pub(crate) fn new(source: Source<'a>, offset: u64) -> Self {
        let mut window = Window::new(source);
        window.go_to(offset);
        Self { window, at: 0 }
    }

    /// Where the next record begins.
    pub(crate) fn offset(&self) -> u64 {
        self.window.base() + self.at as u64
    }

    /// How many bytes are left.
    pub(crate) fn left(&self) -> u64 {
        self.window.source().size() - self.offset()
    }

    /// The next `N` bytes; `None`, and no step, where there are fewer.
    #[inline]
    pub(crate) fn take<const N: usize>(&mut self) -> Result<Option<[u8; N]>, ErrorKind> {
        if self.window.held().len() - self.at < N && !self.fill(N)? {
            return Ok(None);
        }
        let bytes = self.window.held()[self.at..].first_chunk().copied();
        self.at += N;
        Ok(bytes)
    }

    #[cold]
    fn fill(&mut self, count: usize) -> Result<bool, ErrorKind> {
        if self.left() < count as u64 {
            return Ok(false);
        }
        self.window.forget(self.at);
        self.at = 0;
        while self.window.held().len() < count {
            self.window.extend()?;
        }
        Ok(true)
    }

    /// Skips bytes, to the end at most.
    pub(crate) fn skip(&mut self, count: u64) {
        let to = self.offset().saturating_add(count);
        if to <= self.window.end() {
            self.at = (to - self.window.base()) as usize;
        } else {
            self.window.go_to(to);
            self.at = 0;
        }
    }
}

/// Makes room for `more` items, growing by a quarter: an array that doubled would take thrice its
/// final size while it moves.
#[inline]
pub(crate) fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        let quarter = (list.capacity() / 4).max(64);
        list.reserve_exact(more.max(quarter));
    }
}

/// Appends an item as [`make_room`] says.
#[inline]
pub(crate) fn push<T>(list: &mut Vec<T>, item: T) {
    make_room(list, 1);
    list.push(item);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_cross_blocks() {
        let bytes: Vec<u8> = (0..100).collect();
        for block in [1, 3, 7, 64, 1000] {
            let mut records = Records::new(Source::in_blocks(&bytes, block), 4);
            assert_eq!(records.take::<5>().unwrap(), Some([4, 5, 6, 7, 8]));
            assert_eq!(records.take::<1>().unwrap(), Some([9]));
            records.skip(20);
            assert_eq!((records.offset(), records.left()), (30, 70));
            assert_eq!(records.take::<2>().unwrap(), Some([30, 31]));
            records.skip(65);
            assert_eq!(records.take::<4>().unwrap(), None);
            assert_eq!(records.take::<3>().unwrap(), Some([97, 98, 99]));
            assert_eq!(records.take::<1>().unwrap(), None);
            records.skip(u64::MAX);
            assert_eq!(records.left(), 0);
        }
    }

    #[test]
    fn a_scan_sees_each_byte_once() {
        let bytes: Vec<u8> = (0..100).collect();
        for block in [1, 9, 200] {
            for size in [0, 1, 50, 100, 500] {
                let mut seen = Vec::new();
                Source::in_blocks(&bytes, block).scan(size, |b| seen.extend_from_slice(b));
                assert_eq!(seen, &bytes[..(size as usize).min(100)]);
            }
        }
    }

    #[test]
    fn files_and_memory_read_alike() {
        let path = std::env::temp_dir().join(format!("cullet-blocks-{}", std::process::id()));
        let bytes: Vec<u8> = (0..BLOCK as u32 * 2 / 3).flat_map(u32::to_le_bytes).collect();
        std::fs::write(&path, &bytes).unwrap();
        let mut records = Records::new(Source::open(&path).unwrap(), 0);
        for expected in bytes.chunks_exact(4) {
            assert_eq!(records.take::<4>().unwrap().as_ref().map(|b| &b[..]), Some(expected));
        }
        assert_eq!(Source::open(&path).unwrap().head(10).unwrap(), bytes[..10]);
        let source = Source::open(&path).unwrap();
        // A file that became shorter is an error, never a shorter model.
        std::fs::write(&path, &bytes[..10]).unwrap();
        assert!(source.into_bytes().is_err());
        std::fs::remove_file(&path).unwrap();
        assert!(Source::open(&std::env::temp_dir()).is_err());
    }

    #[test]
    fn arrays_grow_by_a_quarter() {
        let mut list = Vec::new();
        for i in 0..100_000u32 {
            push(&mut list, i);
            assert!(list.capacity() <= list.len() * 5 / 4 + 64, "{i}");
        }
    }
}
