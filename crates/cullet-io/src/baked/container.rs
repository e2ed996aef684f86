//! A file of what is baked: chunks with names, each found and read by itself.
//!
//! Everything is little-endian. 32 bytes of header: `CULLBAKE`, the version (1) and the number of
//! chunks as u32, the size of the file and the sum of the table as u64. Then the table, 32 bytes a
//! chunk: four letters, four bytes of zero, where the chunk begins, its size and its sum as u64.
//! Then the chunks, each at a multiple of 64 bytes, so that a file that is mapped into memory can
//! be used as it lies: what is never read is never fetched.

use thiserror::Error;

use super::hash::hash;

const MAGIC: &[u8; 8] = b"CULLBAKE";
const VERSION: u32 = 1;
/// Bytes of the header, and of a chunk's entry in the table.
const ENTRY: usize = 32;
/// Chunks begin at multiples of this.
const ALIGNMENT: usize = 64;

/// The name of a chunk: four letters.
pub type Tag = [u8; 4];

/// Reason for which bytes are no file of chunks, or one is not in it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ContainerError {
    /// They begin otherwise.
    #[error("it does not begin with CULLBAKE: no baked file")]
    Magic,
    /// The version is another.
    #[error("a baked file of version {0}, but only version 1 is known: bake it again")]
    Version(u32),
    /// They are too few or too many.
    #[error("{found} bytes, but its header says {expected}: cut short?")]
    Size {
        /// How many there are.
        found: u64,
        /// How many there should be.
        expected: u64,
    },
    /// A sum is wrong, or a chunk is not within the file.
    #[error("its {0} is damaged: bake it again, or fetch it again")]
    Damaged(String),
    /// There is no such chunk.
    #[error("it has no chunk {0}: a baked file of another kind")]
    Missing(String),
}

/// A name as people read it.
fn words(tag: Tag) -> String {
    String::from_utf8_lossy(&tag).into_owned()
}

/// The bytes of a file with some chunks, in this order.
#[must_use]
pub fn write_chunks(chunks: &[(Tag, &[u8])]) -> Vec<u8> {
    let mut out = vec![0; first_chunk(chunks.len() as u64) as usize];
    let mut places = Vec::with_capacity(chunks.len());
    for (_, bytes) in chunks {
        out.resize(out.len().next_multiple_of(ALIGNMENT), 0);
        places.push(out.len());
        out.extend_from_slice(bytes);
    }
    for (k, ((tag, bytes), &at)) in chunks.iter().zip(&places).enumerate() {
        let sum = hash(&out[at..(at + bytes.len()).next_multiple_of(ALIGNMENT).min(out.len())]);
        let entry = &mut out[ENTRY * (k + 1)..][..ENTRY];
        entry[..4].copy_from_slice(tag);
        for (place, v) in entry[8..].chunks_mut(8).zip([at as u64, bytes.len() as u64, sum]) {
            place.copy_from_slice(&v.to_le_bytes());
        }
    }
    let sum = hash(&out[ENTRY..first_chunk(chunks.len() as u64) as usize]);
    let size = out.len() as u64;
    out[..8].copy_from_slice(MAGIC);
    out[8..12].copy_from_slice(&VERSION.to_le_bytes());
    out[12..16].copy_from_slice(&(chunks.len() as u32).to_le_bytes());
    out[16..24].copy_from_slice(&size.to_le_bytes());
    out[24..32].copy_from_slice(&sum.to_le_bytes());
    out
}

/// Where the first of some chunks begins.
fn first_chunk(count: u64) -> u64 {
    (ENTRY as u64 * (1 + count)).next_multiple_of(ALIGNMENT as u64)
}

/// A file of chunks, read or mapped.
#[derive(Clone, Copy, Debug)]
pub struct Container<'a> {
    bytes: &'a [u8],
    table: &'a [[u8; ENTRY]],
}

impl<'a> Container<'a> {
    /// Reads header and table; the chunks are not looked at. O(chunks).
    ///
    /// # Errors
    /// If the bytes begin otherwise, are of another version, are not as many as they say, or the
    /// table was changed.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ContainerError> {
        if !bytes.starts_with(MAGIC) {
            return Err(ContainerError::Magic);
        }
        let found = bytes.len() as u64;
        let size = |expected| ContainerError::Size { found, expected };
        let (header, rest) =
            bytes.split_first_chunk::<ENTRY>().ok_or_else(|| size(ENTRY as u64))?;
        let [version, count] = [2, 3].map(|at| u32::from_le_bytes(header.as_chunks().0[at]));
        let (expected, sum) = (long(header, 16), long(header, 24));
        if version != VERSION {
            return Err(ContainerError::Version(version));
        }
        if found != expected {
            return Err(size(expected));
        }
        let end = usize::try_from(first_chunk(count.into())).ok();
        let table = end.and_then(|end| rest.get(..end - ENTRY)).filter(|table| hash(table) == sum);
        let table = table.ok_or_else(|| ContainerError::Damaged("table of chunks".to_owned()))?;
        Ok(Self { bytes, table: &table.as_chunks().0[..count as usize] })
    }

    /// The names of the chunks, in their order.
    pub fn tags(&self) -> impl Iterator<Item = Tag> + use<'a> {
        self.table.iter().map(|entry| [entry[0], entry[1], entry[2], entry[3]])
    }

    /// The first chunk of a name, its sum not checked: for large ones of files that are mapped.
    ///
    /// # Errors
    /// If there is none, or it is not within the file.
    pub fn unchecked(&self, tag: Tag) -> Result<&'a [u8], ContainerError> {
        let (bytes, size, _) = self.find(tag)?;
        Ok(&bytes[..size])
    }

    /// The first chunk of a name.
    ///
    /// # Errors
    /// If there is none, it is not within the file, or it was changed.
    pub fn chunk(&self, tag: Tag) -> Result<&'a [u8], ContainerError> {
        let (bytes, size, sum) = self.find(tag)?;
        let damaged = || ContainerError::Damaged(format!("chunk {}", words(tag)));
        (hash(bytes) == sum).then(|| &bytes[..size]).ok_or_else(damaged)
    }

    /// The bytes of a chunk with the zeros behind it, its size without them, and its sum.
    fn find(&self, tag: Tag) -> Result<(&'a [u8], usize, u64), ContainerError> {
        let entry = self.table.iter().find(|entry| entry.starts_with(&tag));
        let entry = entry.ok_or_else(|| ContainerError::Missing(words(tag)))?;
        let [first, size, sum] = [8, 16, 24].map(|at| long(entry, at));
        let found = first.checked_add(size).filter(|&end| end <= self.bytes.len() as u64);
        let found = found.and_then(|end| {
            let end = (end as usize).next_multiple_of(ALIGNMENT).min(self.bytes.len());
            self.bytes.get(first as usize..end)
        });
        let damaged = || ContainerError::Damaged(format!("chunk {}", words(tag)));
        Ok((found.ok_or_else(damaged)?, size as usize, sum))
    }
}

/// A number of eight bytes, `at` a multiple of them.
fn long(bytes: &[u8; ENTRY], at: usize) -> u64 {
    u64::from_le_bytes(bytes.as_chunks().0[at / 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        write_chunks(&[(*b"ROWS", &[7; 100]), (*b"NONE", &[]), (*b"LAST", &[1; 64])])
    }

    #[test]
    fn chunks_come_back_at_their_places() {
        let bytes = file();
        let file = Container::open(&bytes).unwrap();
        assert!(file.tags().eq([*b"ROWS", *b"NONE", *b"LAST"]));
        for read in [Container::chunk, Container::unchecked] {
            assert_eq!(read(&file, *b"ROWS"), Ok(&[7; 100][..]));
            assert_eq!(read(&file, *b"NONE"), Ok(&[][..]));
            let error = read(&file, *b"LINE").unwrap_err();
            assert_eq!(error.to_string(), "it has no chunk LINE: a baked file of another kind");
        }
        let at = file.chunk(*b"ROWS").unwrap().as_ptr() as usize - bytes.as_ptr() as usize;
        assert_eq!(at % ALIGNMENT, 0);
        assert!(Container::open(&write_chunks(&[])).unwrap().tags().next().is_none());
    }

    #[test]
    fn every_changed_byte_and_every_cut_is_noticed() {
        let good = file();
        for length in 0..good.len() {
            assert!(Container::open(&good[..length]).is_err(), "{length}");
        }
        for at in 0..good.len() {
            let mut bytes = good.clone();
            bytes[at] ^= 0x41;
            let read = Container::open(&bytes)
                .and_then(|file| file.tags().try_for_each(|tag| file.chunk(tag).map(drop)));
            assert!(read.is_err(), "byte {at}");
        }
    }
}
