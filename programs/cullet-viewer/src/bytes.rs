//! Messages as bytes and back: settings and results by `postcard`, long arrays of plain data as
//! they lie in memory; with every count held against what is there.

use bytemuck::{AnyBitPattern, NoUninit};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// Why bytes make no model, nor anything else that was packed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum UnpackError {
    /// They end before what they promise.
    #[error("the packed bytes end early, at byte {0}")]
    Short(usize),
    /// The bytes cannot be a packed model.
    #[error("the packed bytes are damaged: {0}")]
    Damaged(String),
}

/// Appends to a list of bytes.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    pub(crate) bytes: Vec<u8>,
}

impl Writer {
    /// A value of any type but maps and iterators of unknown length, which `postcard` refuses:
    /// nothing is left then, and the reader says that the bytes end early.
    pub(crate) fn value(&mut self, value: &(impl Serialize + ?Sized)) {
        let bytes = std::mem::take(&mut self.bytes);
        self.bytes = postcard::to_extend(value, bytes).unwrap_or_default();
    }

    /// Plain data as it lies in memory.
    pub(crate) fn pod<T: NoUninit>(&mut self, value: &T) {
        self.bytes.extend_from_slice(bytemuck::bytes_of(value));
    }

    /// A list of plain data as it lies in memory.
    pub(crate) fn pods<T: NoUninit>(&mut self, values: &[T]) {
        self.count(values.len());
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
    }

    /// How many items follow.
    pub(crate) fn count(&mut self, count: usize) {
        self.value(&(count as u64));
    }
}

type Unpacked<T> = Result<T, UnpackError>;

/// Reads what a [`Writer`] wrote.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// How far it has read.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn value<T: DeserializeOwned>(&mut self) -> Unpacked<T> {
        let left = self.bytes.get(self.at..).unwrap_or_default();
        let (value, left) = postcard::take_from_bytes(left).map_err(|error| match error {
            postcard::Error::DeserializeUnexpectedEnd => UnpackError::Short(self.bytes.len()),
            error => UnpackError::Damaged(error.to_string()),
        })?;
        self.at = self.bytes.len() - left.len();
        Ok(value)
    }

    pub(crate) fn take(&mut self, count: usize) -> Unpacked<&'a [u8]> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at += taken.map_or(0, <[u8]>::len);
        taken.ok_or(UnpackError::Short(self.at))
    }

    pub(crate) fn pod<T: AnyBitPattern>(&mut self) -> Unpacked<T> {
        Ok(bytemuck::pod_read_unaligned(self.take(size_of::<T>())?))
    }

    pub(crate) fn pods<T: AnyBitPattern>(&mut self) -> Unpacked<Vec<T>> {
        let mut values = Vec::new();
        self.pods_into(&mut values)?;
        Ok(values)
    }

    /// Reads like [`pods`](Self::pods), replacing the contents of a list.
    pub(crate) fn pods_into<T: AnyBitPattern>(&mut self, values: &mut Vec<T>) -> Unpacked<()> {
        let count = self.count(size_of::<T>())?;
        let bytes = self.take(count * size_of::<T>())?;
        values.clear();
        // They may lie anywhere, so they are copied rather than cast.
        values.extend(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>));
        Ok(())
    }

    /// A count of items of at least `size` bytes, if there can be as many.
    pub(crate) fn count(&mut self, size: usize) -> Unpacked<usize> {
        let count: u64 = self.value()?;
        let left = (self.bytes.len() - self.at) as u64;
        if count.checked_mul(size as u64).is_none_or(|bytes| bytes > left) {
            return Err(UnpackError::Short(self.bytes.len()));
        }
        Ok(count as usize)
    }
}
